"""Commands that choose: explore, optimise."""

from enum import StrEnum
from typing import TYPE_CHECKING, Annotated

import typer

from missionplan.cli import options as o
from missionplan.cli.planning import REQUIREMENT_NOT_MET
from missionplan.cli.running import Progress, run_resumable

if TYPE_CHECKING:
    from pathlib import Path

    from missionplan.mission import Mission
    from missionplan.results.optimisation import Optimised
    from missionplan.studies.exploration.result import Exploration

_WORKERS_NEED = "missionplan.studies.exploration.cells"


class ExplorationAim(StrEnum):
    """What the best of the cells is."""

    SUCCESS = "success"
    ENERGY = "energy"
    DURATION = "duration"


_Vary = Annotated[
    list[str],
    typer.Option(
        metavar="KEY=FROM:TO:STEP",
        help="What to vary, once or twice: ingress.speed=0.8:2:0.1 m/s; start=04:00:12:00:10 min; "
        "vehicle=a.yaml,b.yaml; KEY+KEY=… for keys that take the same value.",
        show_default=False,
    ),
]
_Aim = Annotated[
    ExplorationAim,
    o.choice(
        ExplorationAim,
        "--aim",
        help="Best of those that meet all requirements: most often successful, least energy, least time.",
    ),
]
_Quantities = Annotated[
    list[str] | None,
    typer.Option(
        "--quantity", metavar="NAME", help="Report this too, such as moor.offset; repeatable.", show_default=False
    ),
]
_OnlyBest = Annotated[bool, typer.Option("--only-best", help="Few trials of what cannot be the best; no windows.")]


def explore(
    mission: o.MissionFile,
    vary: _Vary,
    aim: _Aim = ExplorationAim.SUCCESS,
    only_best: _OnlyBest = False,
    quantity: _Quantities = None,
    *,
    run: o.MonteCarloOptions,
    resume: o.Resume = False,
    output: o.OutputOptions,
    allow_outside: o.AllowOutside = False,
) -> None:
    """Vary one or two keys of a mission: when to go, how fast, with which line, and what is as good as the best.

    Example: missionplan explore missions/chesapeake.yaml --vary "ingress.speed=1:2:0.25m/s" --trials 2000
    """
    from missionplan.montecarlo.parallel.pool import preloaded_pool

    def study(loaded: "Mission", kept: "Path", progress: Progress) -> "Exploration":
        from missionplan.studies.exploration.explore import explore

        return explore(
            loaded,
            vary,
            aim=aim.value,
            only_best=only_best,
            quantities=quantity or (),
            checkpoint=kept,
            resume=resume,
            progress=progress,
            **run.arguments(),
        )

    with preloaded_pool(run.other_processes, _WORKERS_NEED):  # they import while this process does
        found = run_resumable(mission, "explore", study, output, allow_outside=allow_outside, resume=resume)
    if not found.any_meets_all:
        raise typer.Exit(REQUIREMENT_NOT_MET)


class Least(StrEnum):
    """What is to be least."""

    ENERGY = "energy"
    DURATION = "duration"


_Choose = Annotated[
    list[str] | None,
    typer.Option(
        metavar="KEY=FROM:TO:STEP",
        help="What may be chosen, as explore's --vary; repeatable. Default: the mission's section optimise.",
        show_default=False,
    ),
]
_Least = Annotated[
    Least | None,
    o.choice(Least, "--aim", help="What is to be least; default: the mission's, or energy.", show_default=False),
]


def optimise(
    mission: o.MissionFile,
    choose: _Choose = None,
    aim: _Least = None,
    trials: o.Trials = None,
    seed: o.Seed = None,
    jobs: o.Jobs = 0,
    *,
    resume: o.Resume = False,
    output: o.OutputOptions,
    allow_outside: o.AllowOutside = False,
) -> None:
    """Choose anchor, line, legs, speed and start together, so that all requirements hold at the least energy or time.

    Example: missionplan optimise missions/chesapeake.yaml --choose "ingress.d_max=200:1000:200m"
    """
    from missionplan.montecarlo.parallel.pool import preloaded_pool

    processes = o.worker_count(jobs)

    def study(loaded: "Mission", kept: "Path", progress: Progress) -> "Optimised":
        from missionplan.studies.optimisation.optimise import optimise

        return optimise(
            loaded,
            choose=choose or (),
            aim=aim.value if aim else None,
            trials=trials,
            seed=seed,
            jobs=processes,
            checkpoint=kept,
            resume=resume,
            progress=progress,
        )

    with preloaded_pool(processes - 1, _WORKERS_NEED):
        found = run_resumable(mission, "optimise", study, output, allow_outside=allow_outside, resume=resume)
    if not found.feasible:
        raise typer.Exit(REQUIREMENT_NOT_MET)
