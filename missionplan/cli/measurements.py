"""Commands that learn from measurements: diagnose, identify."""

from typing import TYPE_CHECKING, Annotated

import typer

from missionplan.cli import options as o
from missionplan.cli.running import Progress, checked_folder, deliver, run_study

if TYPE_CHECKING:
    from missionplan.mission import Mission
    from missionplan.results.base import Result


def register(app: typer.Typer) -> None:
    """Add the commands."""
    app.command()(o.with_option_groups(diagnose))
    app.command()(o.with_option_groups(identify))


def diagnose(
    mission: o.MissionFile,
    dataset: o.DatasetFolder,
    seed: o.Seed = None,
    jobs: o.Jobs = 0,
    *,
    output: o.OutputOptions,
    next_trial: Annotated[
        bool, typer.Option("--next-trial", help="Value the trials that could be made next: a few seconds more.")
    ] = False,
    allow_outside: o.AllowOutside = False,
) -> None:
    """Find what the simulation gets wrong about measured data and why, and write the extended mission."""

    def study(loaded: "Mission", progress: Progress) -> "Result":
        from missionplan.montecarlo.parallel_map import MAX_PROCESSES
        from missionplan.montecarlo.pool import preloaded_pool
        from missionplan.studies.validation.datasets import check_dataset

        check_dataset(dataset, loaded, allow_outside=allow_outside)  # a refusal needs neither workers nor their imports
        processes = o.worker_count(jobs)
        others = min(processes, MAX_PROCESSES) - 1
        with preloaded_pool(others, "missionplan.diagnosis.diagnose"):  # they import while this process does
            from missionplan.diagnosis.diagnose import diagnose

            return diagnose(
                loaded,
                dataset,
                seed=seed,
                jobs=processes,
                next_trial=next_trial,
                allow_outside=allow_outside,
                progress=progress,
            )

    from missionplan.datasets.reading import dataset_files

    inputs = dataset_files(dataset)
    run_study(mission, "diagnose", study, output, allow_outside=allow_outside, inputs=inputs)


def identify(dataset: o.DatasetFolder, *, output: o.OutputOptions, allow_outside: o.AllowOutside = False) -> None:
    """Identify hydrodynamic or thruster parameters from tank data, with errors, for a vehicle file."""
    from missionplan.datasets.reading import dataset_files
    from missionplan.studies.identification.identify import identify

    folder = checked_folder(output, dataset.resolve().name, "identify", dataset_files(dataset))
    deliver(identify(dataset, allow_outside=allow_outside), folder, output)
