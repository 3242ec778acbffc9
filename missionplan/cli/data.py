"""Commands that learn from measurements: identify."""

import typer

from missionplan.cli import options as o
from missionplan.cli.running import deliver, report_folder


def register(app: typer.Typer) -> None:
    """Add the commands."""
    app.command()(identify)


def identify(
    dataset: o.DatasetFolder,
    out: o.Out = None,
    force: o.Force = False,
    as_json: o.Json = False,
    quiet: o.Quiet = False,
) -> None:
    """Hydrodynamic and thruster parameters from tank data, with their errors and a fragment for a vehicle file."""
    from missionplan.store.folder import check_new_folder
    from missionplan.studies.identify import identify

    folder = out or report_folder(dataset.resolve().name, "identify")
    check_new_folder(folder, force=force)
    deliver(identify(dataset), folder, o.Output(out, force, as_json, quiet))
