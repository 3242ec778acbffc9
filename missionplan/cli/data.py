"""Commands that learn from measurements: diagnose, identify."""

from typing import TYPE_CHECKING, Any

import typer

from missionplan.cli import options as o
from missionplan.cli.running import deliver, report_folder, run_study

if TYPE_CHECKING:
    from missionplan.mission import Mission
    from missionplan.results.base import Result


def register(app: typer.Typer) -> None:
    """Add the commands."""
    app.command()(diagnose)
    app.command()(identify)


def diagnose(
    mission: o.MissionFile,
    dataset: o.DatasetFolder,
    seed: o.Seed = None,
    jobs: o.Jobs = 0,
    out: o.Out = None,
    force: o.Force = False,
    as_json: o.Json = False,
    quiet: o.Quiet = False,
    allow_outside: o.AllowOutside = False,
) -> None:
    """What the simulation gets wrong about measured data, why, the extended mission, and what it gains."""

    def study(loaded: "Mission", progress: Any) -> "Result":
        from missionplan.montecarlo.parallel_map import MAX_PROCESSES
        from missionplan.montecarlo.pool import preloaded_pool

        processes = o.worker_count(jobs)
        others = min(processes, MAX_PROCESSES) - 1
        with preloaded_pool(others, "missionplan.diagnosis.diagnose"):  # they import while this process does
            from missionplan.diagnosis.diagnose import diagnose

            return diagnose(loaded, dataset, seed=seed, jobs=processes, progress=progress)

    run_study(mission, "diagnose", study, o.Output(out, force, as_json, quiet), allow_outside=allow_outside)


def identify(
    dataset: o.DatasetFolder,
    out: o.Out = None,
    force: o.Force = False,
    as_json: o.Json = False,
    quiet: o.Quiet = False,
) -> None:
    """Hydrodynamic and thruster parameters from tank data, with their errors and a fragment for a vehicle file."""
    from missionplan.store.folder import check_new_folder
    from missionplan.studies.identification.identify import identify

    folder = out or report_folder(dataset.resolve().name, "identify")
    check_new_folder(folder, force=force)
    deliver(identify(dataset), folder, o.Output(out, force, as_json, quiet))
