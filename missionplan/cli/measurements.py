"""Commands that learn from measurements: diagnose, identify, score, history, tide."""

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

import missionplan
from missionplan.cli import options as o
from missionplan.cli.running import Progress, deliver, loaded, progress_bar, report_folder, run_study

if TYPE_CHECKING:
    from missionplan.mission import Mission
    from missionplan.results import Result
    from missionplan.results.score import Score


OUTSIDE_CHANCE = 3
"""Exit status of a score whose predictions are not what chance allows."""
_WORKERS_NEED = (
    "missionplan.diagnosis.legs.model",
    "missionplan.diagnosis.dives.model",
    "scipy.optimize",
    "missionplan.scenario.phases",
)
"""Modules that fits need; none that reads files or tables."""
_Holdout = Annotated[
    float | None,
    typer.Option(
        min=0.0,
        max=1.0,
        metavar="LAST",
        help="Keep this last share of each record away from the diagnosis, and score the extended mission on it.",
    ),
]
NextTrial = Annotated[
    bool, typer.Option("--next-trial", help="Value the trials that could be made next: a few seconds more.")
]
_Diagnosed = Annotated[list[Path], typer.Argument(metavar="DATASET...", help="Data sets: folders with dataset.yaml.")]
_Datasets = Annotated[list[Path], typer.Argument(metavar="DATASET...", help="Data sets of legs or dives.")]


def diagnose(
    mission: o.MissionFile,
    datasets: _Diagnosed,
    seed: o.Seed = None,
    jobs: o.Jobs = 0,
    *,
    output: o.OutputOptions,
    next_trial: NextTrial = False,
    holdout: _Holdout = None,
    allow_outside: o.AllowOutside = False,
) -> None:
    """Find what the simulation gets wrong about measured data and why, and write the extended mission.

    Several data sets of one campaign, of any kinds, are diagnosed one after the other into one extended mission.
    """
    with report_folder(output, mission.stem, "diagnose") as folder:
        result = diagnosed(
            mission,
            datasets,
            folder,
            seed=seed,
            jobs=jobs,
            next_trial=next_trial,
            holdout=holdout,
            allow_outside=allow_outside,
            quiet=output.quiet,
        )
        deliver(result, folder, output)


def diagnosed(
    mission: Path,
    datasets: Sequence[Path],
    folder: Path,
    *,
    seed: int | None,
    jobs: int,
    next_trial: bool,
    holdout: float | None,
    allow_outside: bool,
    quiet: bool,
) -> "Result":
    """Load a mission and diagnose data sets, with workers that import what fits need while this process does."""
    from missionplan.montecarlo.blocks import MAX_PROCESSES
    from missionplan.montecarlo.pool import preloaded_pool

    processes = o.worker_count(jobs)
    with preloaded_pool(min(processes, MAX_PROCESSES) - 1, *_WORKERS_NEED):
        mission_loaded = loaded(mission, datasets, folder, allow_outside=allow_outside)
        with progress_bar("diagnose", shown=not quiet) as progress:
            several = partial(missionplan.diagnose_campaign, datasets=datasets)
            study = several if len(datasets) > 1 else partial(missionplan.diagnose, dataset=datasets[0])
            return study(
                mission_loaded,
                seed=seed,
                jobs=processes,
                next_trial=next_trial,
                holdout=holdout,
                allow_outside=allow_outside,
                progress=progress,
            )


def identify(dataset: o.DatasetFolder, *, output: o.OutputOptions, allow_outside: o.AllowOutside = False) -> None:
    """Identify hydrodynamic or thruster parameters from tank data, with errors, for a vehicle file."""
    from missionplan.datasets import dataset_files

    with report_folder(output, dataset.resolve().name, "identify", dataset_files(dataset)) as folder:
        deliver(missionplan.identify(dataset, allow_outside=allow_outside), folder, output)


def score(
    mission: o.MissionFile,
    datasets: _Datasets,
    seed: o.Seed = None,
    *,
    output: o.OutputOptions,
    allow_outside: o.AllowOutside = False,
) -> None:
    """Score how well a mission as it stands predicts measured legs or dives; nothing is fitted.

    Example: missionplan score mission.yaml sea-trial
    """

    def study(loaded: "Mission", progress: Progress) -> "Score":
        return missionplan.score(loaded, *datasets, seed=seed, allow_outside=allow_outside, progress=progress)

    result = run_study(mission, "score", study, output, allow_outside=allow_outside, datasets=datasets)
    if not result.is_within_chance:
        raise typer.Exit(OUTSIDE_CHANCE)


def history(
    folder: Annotated[
        Path, typer.Argument(metavar="FOLDER", help="Holds reports of diagnose, and reliability.csv, at any depth.")
    ],
    *,
    mission: Annotated[
        Path | None, typer.Option(metavar="MISSION", help="Whose failure rates the counts of a fleet update.")
    ] = None,
    output: o.OutputOptions,
) -> None:
    """Draw how each learned parameter has moved from mission to mission; update failure rates by a fleet's counts.

    Example: missionplan history reports
    """
    with report_folder(output, folder.resolve().name, "history") as report:
        deliver(missionplan.history(folder, mission=mission), report, output)


_Record = Annotated[Path, typer.Argument(metavar="RECORD", help="Record of a current: CSV or NetCDF.")]
_Latitude = Annotated[
    str | None, typer.Option(metavar="ANGLE", help="Where it was measured; default: as the file says.")
]
_Start = Annotated[
    str | None, typer.Option(metavar="TIME", help="From which seconds in a CSV file count (ISO 8601, UTC).")
]


def tide(record: _Record, latitude: _Latitude = None, start: _Start = None, *, output: o.OutputOptions) -> None:
    """Find the tide in a record of a current, with errors, and write it as the current of a mission.

    Example: missionplan tide mooring.csv --latitude '37.2 deg'
    """
    with report_folder(output, record.stem, "tide", [record]) as folder:
        with progress_bar("tide", shown=not output.quiet) as progress:
            result = missionplan.tide(record, latitude=latitude, start=start, progress=progress)
        deliver(result, folder, output)
