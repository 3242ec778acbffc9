"""Commands that plan: sweep-dmax, plan-legs, size-anchor, simulate, sweep-transition."""

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from missionplan.cli import options as o
from missionplan.cli.running import deliver, progress_bar, report_folder, run_study
from missionplan.errors import InputError, Problem, RunError

if TYPE_CHECKING:
    from missionplan.mission import Mission
    from missionplan.results.base import Result

REQUIREMENT_NOT_MET = 3
BLOCKS = "blocks"
"""Folder of finished blocks inside a report folder."""


class Method(StrEnum):
    """How the cost of a d_max is found."""

    BOTH = "both"
    ANALYTIC = "analytic"
    MONTE_CARLO = "monte-carlo"


class Aim(StrEnum):
    """What legs are chosen for."""

    MEAN = "mean"
    P95 = "p95"
    ENERGY = "energy"


def register(app: typer.Typer) -> None:
    """Add the commands."""
    app.command("sweep-dmax")(sweep_dmax)
    app.command("plan-legs")(plan_legs)
    app.command("size-anchor")(size_anchor)
    app.command()(simulate)
    app.command("sweep-transition")(sweep_transition)


def sweep_dmax(
    mission: o.MissionFile,
    method: Annotated[
        Method | None, typer.Option(help="Default: both where the analytic form applies.", show_default=False)
    ] = None,
    trials: o.Trials = None,
    seed: o.Seed = None,
    jobs: o.Jobs = 0,
    backend: o.BackendOption = o.Backend.LOKY,
    scheduler: o.Scheduler = None,
    out: o.Out = None,
    force: o.Force = False,
    as_json: o.Json = False,
    quiet: o.Quiet = False,
    allow_outside: o.AllowOutside = False,
) -> None:
    """Cost of each maximum leg length d_max, for each velocity error; the best d_max with its uncertainty."""

    def study(loaded: "Mission", progress: Any) -> "Result":
        from missionplan.studies.leg_length.sweep_dmax import sweep_dmax

        return sweep_dmax(
            loaded,
            method=method.value if method else None,
            trials=trials,
            seed=seed,
            jobs=o.worker_count(jobs),
            backend=backend.value,
            scheduler=scheduler,
            progress=progress,
        )

    run_study(mission, "sweep-dmax", study, o.Output(out, force, as_json, quiet), allow_outside=allow_outside)


def plan_legs(
    mission: o.MissionFile,
    aim: Annotated[
        Aim,
        typer.Option(help="Mean time; time (or the mission's deadline) that 95 % keep; energy, with the speed chosen."),
    ] = Aim.MEAN,
    trials: o.Trials = None,
    seed: o.Seed = None,
    jobs: o.Jobs = 0,
    backend: o.BackendOption = o.Backend.LOKY,
    scheduler: o.Scheduler = None,
    out: o.Out = None,
    force: o.Force = False,
    as_json: o.Json = False,
    quiet: o.Quiet = False,
    allow_outside: o.AllowOutside = False,
) -> None:
    """Legs that adapt to the distance left: a table better than any fixed d_max, and what it saves."""

    def study(loaded: "Mission", progress: Any) -> "Result":
        from missionplan.studies.leg_length.plan_legs import plan_legs

        return plan_legs(
            loaded,
            aim=aim.value,
            trials=trials,
            seed=seed,
            jobs=o.worker_count(jobs),
            backend=backend.value,
            scheduler=scheduler,
            progress=progress,
        )

    run_study(mission, "plan-legs", study, o.Output(out, force, as_json, quiet), allow_outside=allow_outside)


def size_anchor(
    mission: o.MissionFile,
    probability: Annotated[
        float | None,
        typer.Option(
            min=0.0, max=1.0, help="Also find the lightest anchor that holds the radius so often.", show_default=False
        ),
    ] = None,
    phase: Annotated[
        str | None, typer.Option(help="Name of the mooring; default: the first.", show_default=False)
    ] = None,
    trials: o.Trials = None,
    seed: o.Seed = None,
    jobs: o.Jobs = 0,
    backend: o.BackendOption = o.Backend.LOKY,
    scheduler: o.Scheduler = None,
    out: o.Out = None,
    force: o.Force = False,
    as_json: o.Json = False,
    quiet: o.Quiet = False,
    allow_outside: o.AllowOutside = False,
) -> None:
    """Anchor that takes the vehicle down within the radius: weight, length, trim ring, and the dive it gives."""

    def study(loaded: "Mission", progress: Any) -> "Result":
        from missionplan.studies.anchor.size_anchor import size_anchor

        return size_anchor(
            loaded,
            probability=probability,
            phase=phase,
            trials=trials,
            seed=seed,
            jobs=o.worker_count(jobs),
            backend=backend.value,
            scheduler=scheduler,
        )

    run_study(mission, "size-anchor", study, o.Output(out, force, as_json, quiet), allow_outside=allow_outside)


def simulate(
    mission: o.MissionFile,
    trials: o.Trials = None,
    seed: o.Seed = None,
    jobs: o.Jobs = 0,
    backend: o.BackendOption = o.Backend.LOKY,
    scheduler: o.Scheduler = None,
    precision: Annotated[
        str | None,
        typer.Option(
            metavar="TARGET",
            help="Stop when a standard error is below it: 0.5% (of P(success)), total.duration=0.5%, moor.offset=0.1m.",
            show_default=False,
        ),
    ] = None,
    resume: Annotated[
        bool, typer.Option("--resume", help="Go on with the finished blocks of a run cut short.")
    ] = False,
    keep_trials: Annotated[
        bool, typer.Option("--keep-trials", help="Write one row a trial as trials.parquet.")
    ] = False,
    out: o.Out = None,
    force: o.Force = False,
    as_json: o.Json = False,
    quiet: o.Quiet = False,
    allow_outside: o.AllowOutside = False,
) -> None:
    """The whole mission, phase by phase: will it work, how long, how much energy, and what spoils it."""
    from missionplan.mission import load
    from missionplan.store.folder import check_new_folder
    from missionplan.studies.simulation.simulate import simulate

    folder = out or (_last_unfinished(mission.stem) if resume else report_folder(mission.stem, "simulate"))
    check_new_folder(folder, force=force or resume)
    loaded = load(mission, allow_outside=allow_outside)
    if force and not resume:
        _discard_blocks(folder / BLOCKS)
    try:
        with progress_bar("simulate", shown=not quiet) as progress:
            outcome = simulate(
                loaded,
                trials=trials,
                seed=seed,
                jobs=o.worker_count(jobs),
                backend=backend.value,
                scheduler=scheduler,
                precision=precision,
                checkpoint=folder / BLOCKS,
                resume=resume,
                keep_trials=keep_trials,
                progress=progress,
            )
    except (KeyboardInterrupt, RunError):
        if any((folder / BLOCKS).glob("block-*.npz")):
            typer.echo(f"Finished blocks are kept; go on with: --resume --out {folder}", err=True)
        raise
    deliver(outcome, folder, o.Output(out, force, as_json, quiet), force=True)
    if not outcome.requirements_met:
        raise typer.Exit(REQUIREMENT_NOT_MET)


def _discard_blocks(folder: Path) -> None:
    """Remove the finished blocks of an earlier run, and nothing that is not one."""
    for path in (*folder.glob("block-*.npz"), folder / "run.json"):
        path.unlink(missing_ok=True)


def _last_unfinished(stem: str) -> Path:
    """Find the newest report folder of a mission whose run was cut short."""
    parent = Path("reports") / stem
    for folder in sorted(parent.glob("simulate-*"), reverse=True):
        if (folder / BLOCKS).is_dir() and not (folder / "report.html").exists():
            return folder
    raise InputError([Problem("there is no unfinished run to resume", str(parent), hint="--out names its folder")])


def sweep_transition(
    mission: o.MissionFile,
    phase: Annotated[
        str | None, typer.Option(metavar="NAME", help="Transition phase; default: the first.", show_default=False)
    ] = None,
    out: o.Out = None,
    force: o.Force = False,
    as_json: o.Json = False,
    quiet: o.Quiet = False,
    allow_outside: o.AllowOutside = False,
) -> None:
    """Depth, pitch and energy of slowing down to hover, over the grid of the transition phase."""

    def study(loaded: "Mission", _progress: Any) -> "Result":
        from missionplan.studies.transition.sweep_transition import sweep_transition

        return sweep_transition(loaded, phase=phase)

    run_study(mission, "sweep-transition", study, o.Output(out, force, as_json, quiet), allow_outside=allow_outside)
