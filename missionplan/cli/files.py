"""Commands about files: validate, init, compare."""

from pathlib import Path
from typing import Annotated

import typer

from missionplan.cli import options as o
from missionplan.cli.running import deliver, report_folder
from missionplan.errors import InputError, Problem


def register(app: typer.Typer) -> None:
    """Add the commands."""
    app.command()(validate)
    app.command()(init)
    app.command()(compare)


def init(
    folder: Annotated[Path, typer.Argument(metavar="[DIR]", help="Where to.")] = Path(),
    quiet: o.Quiet = False,
) -> None:
    """Write a commented starter mission, vehicle and data set; nothing is overwritten."""
    from missionplan.studies.init import init

    written = init(folder)
    if not quiet:
        for path in written:
            typer.echo(str(path))


def compare(
    first: Annotated[Path, typer.Argument(metavar="REPORT", help="Report folder, before.", show_default=False)],
    second: Annotated[Path, typer.Argument(metavar="REPORT", help="Report folder, after.", show_default=False)],
    out: o.Out = None,
    force: o.Force = False,
    as_json: o.Json = False,
    quiet: o.Quiet = False,
) -> None:
    """Two reports of one command: what changed in the mission, what in the results, and is it more than noise."""
    from missionplan.store.folder import check_new_folder
    from missionplan.studies.comparison.compare import compare

    folder = out or report_folder(second.resolve().name, "compare")
    check_new_folder(folder, force=force)
    deliver(compare(first, second), folder, o.Output(out, force, as_json, quiet))


def validate(
    missions: Annotated[list[Path], typer.Argument(metavar="MISSION...", help="Mission files.", show_default=False)],
    allow_outside: o.AllowOutside = False,
    quiet: o.Quiet = False,
) -> None:
    """Check mission files and run nothing."""
    from missionplan.mission import load

    problems: list[Problem] = []
    for path in missions:
        try:
            mission = load(path, allow_outside=allow_outside)
        except InputError as error:
            problems += error.problems
            continue
        if not quiet:
            uncertain = len(mission.uncertain())
            kinds = ", ".join(phase.kind for phase in mission.phases) or "none"
            typer.echo(f"{path}: valid. Phases: {kinds}; {uncertain} quantities are distributions.")
            for notice in mission.notices():
                typer.echo(f"{path}: {notice}", err=True)
    if problems:
        raise InputError(problems)
