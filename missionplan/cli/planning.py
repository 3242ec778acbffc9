"""Commands that plan, from simulate to sweep-transition, and that choose: explore, optimise."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal, get_args

import typer

import missionplan
from missionplan.cli import options as o
from missionplan.cli.running import run_resumable, run_study
from missionplan.errors import InputError, Problem

if TYPE_CHECKING:
    from missionplan.studies.leg_length.plan_result import LegPlan
    from missionplan.studies.leg_length.sweep_result import Sweep

REQUIREMENT_NOT_MET = 3
_BLOCKS_NEED = "missionplan.studies.simulation.block_sequence"
_PAGE = "missionplan.report.simulation.page"
_CELLS_NEED = "missionplan.studies.exploration.cells"
_SWEEPS_NEED = "missionplan.studies.leg_length.sweep_dmax"
_PLANS_NEED = "missionplan.studies.leg_length.plan_legs"
_MANY_TRIALS = 8192
"""Trials beyond which a second process gains more than its start takes."""
CostMethod = Literal["both", "analytic", "monte-carlo"]
LegObjective = Literal["mean", "p95", "energy"]
VehicleFormat = Literal["slocum", "moos", "neptus", "iver", "qgc"]
"""Formats that a vehicle carries out; the names are those of `missionplan.exporters`."""


@contextmanager
def _workers_importing(module: str, count: int) -> Iterator[None]:
    """Start worker processes, which import what their tasks need while this process does; 0: none."""
    from missionplan.montecarlo.pool import preloaded_pool

    with preloaded_pool(count, module):
        yield


_Method = Annotated[
    CostMethod | None, o.choice(CostMethod, "--method", help="Default: both where the analytic form applies.")
]


def sweep_dmax(
    mission: o.MissionFile,
    method: _Method = None,
    *,
    run: o.MonteCarloOptions,
    output: o.OutputOptions,
    allow_outside: o.AllowOutside = False,
) -> None:
    """Compute the cost of each maximum leg length d_max, and find the best, for each velocity error."""
    with _workers_importing(_SWEEPS_NEED, run.other_processes):
        study = partial(missionplan.sweep_dmax, method=method, **run.arguments())
        sweep = run_study(mission, "sweep-dmax", study, output, allow_outside=allow_outside)
    _exit_as_judged(sweep)


_Aim = Annotated[
    LegObjective,
    o.choice(
        LegObjective,
        "--aim",
        help="Least mean time; least time that 95 % of transits keep (or fewest late for the mission's deadline); "
        "least energy, with the speed chosen too.",
    ),
]


def plan_legs(
    mission: o.MissionFile,
    aim: _Aim = "mean",
    *,
    run: o.MonteCarloOptions,
    output: o.OutputOptions,
    allow_outside: o.AllowOutside = False,
) -> None:
    """Find leg lengths that adapt to the distance left, and what they save against the best fixed d_max."""
    with _workers_importing(_PLANS_NEED, run.other_processes):
        study = partial(missionplan.plan_legs, aim=aim, **run.arguments())
        plan = run_study(mission, "plan-legs", study, output, allow_outside=allow_outside)
    _exit_as_judged(plan)


def _exit_as_judged(result: "Sweep | LegPlan") -> None:
    """Exit with 3 where the mission with what is recommended misses a requirement."""
    if result.judged is not None and not result.judged.requirements_met:
        raise typer.Exit(REQUIREMENT_NOT_MET)


_Probability = Annotated[
    float | None,
    typer.Option(
        help="Also find the lightest anchor whose dives stay within the radius with this probability; "
        "default: what the mission requires."
    ),
]
_Mooring = Annotated[str | None, typer.Option(help="Name of the mooring; default: the first.")]


def size_anchor(
    mission: o.MissionFile,
    probability: _Probability = None,
    phase: _Mooring = None,
    *,
    run: o.MonteCarloOptions,
    output: o.OutputOptions,
    allow_outside: o.AllowOutside = False,
) -> None:
    """Size the anchor that takes the vehicle down within the radius: weight, length, trim ring, and its dive."""
    study = partial(missionplan.size_anchor, probability=probability, phase=phase, **run.arguments())
    if not run_study(mission, "size-anchor", study, output, allow_outside=allow_outside).succeeds:
        raise typer.Exit(REQUIREMENT_NOT_MET)


_Precision = Annotated[
    str | None,
    typer.Option(
        metavar="TARGET",
        help="Stop when the standard error is below it: 0.5% (of P(success)), total.duration=0.5%, moor.offset=0.1m.",
    ),
]
_KeepTrials = Annotated[bool, typer.Option("--keep-trials", help="Write trials.parquet, one row per trial.")]
_Assumptions = Annotated[
    bool, typer.Option(help="Say what each assumption of the mission is worth: some hundred trials without each.")
]
_Searched = Annotated[
    Path | None,
    typer.Option(
        metavar="GEOJSON",
        help="Areas that were searched in vain: polygons with the properties probability_of_detection and time. The "
        "search areas are those of what is left.",
    ),
]


_AsExported = Annotated[
    VehicleFormat | None,
    o.choice(
        VehicleFormat,
        "--as-exported",
        metavar="FORMAT",
        help=f"Run what the vehicle does with the files of `export`, one of {', '.join(get_args(VehicleFormat))}.",
    ),
]


_Rare = Annotated[
    str | None,
    typer.Option(
        metavar="[EVENT]",
        help="Estimate the probability of a rare failure instead, and how it comes about: 'not total.success' "
        "(where no event is given), moor.struck_seafloor, 'moor.offset > 30 m'. --trials: at most; --precision: "
        "coefficient of variation, default 10%.",
    ),
]


def with_default_event(arguments: Sequence[str]) -> list[str]:
    """Add the event that `--rare` stands for where it is given without one: typer's options need their values."""
    words = list(arguments)
    for place in reversed([place for place, argument in enumerate(words) if argument == "--rare"]):
        if place + 1 == len(words) or words[place + 1].startswith("-"):
            words.insert(place + 1, FAILS)
    return words


FAILS = "not total.success"
"""Event of `--rare` where none is given."""


def simulate(
    mission: o.MissionFile,
    *,
    run: o.MonteCarloOptions,
    rare: _Rare = None,
    precision: _Precision = None,
    resume: o.Resume = False,
    keep_trials: _KeepTrials = False,
    searched: _Searched = None,
    assumptions: _Assumptions = True,
    as_exported: _AsExported = None,
    output: o.OutputOptions,
    allow_outside: o.AllowOutside = False,
) -> None:
    """Simulate the whole mission: will it work, how long will it take, how much energy, and what makes it fail."""
    if rare is not None:
        options = {"resume": resume, "keep_trials": keep_trials, "searched": searched is not None}
        refused = [name for name, is_given in {**options, "as_exported": as_exported is not None}.items() if is_given]
        if refused:
            message = "does not go with --rare, which writes failures.csv and starts anew"
            raise InputError([Problem(message, key=name) for name in refused])
        search = partial(missionplan.find_rare_failure, event=rare, precision=precision, **run.arguments())
        run_study(mission, "simulate", search, output, allow_outside=allow_outside)
        return
    study = partial(
        missionplan.simulate,
        precision=precision,
        keep_trials=keep_trials,
        searched=searched,
        assumptions=assumptions,
        as_exported=as_exported,
        **run.arguments(),
    )
    with _workers_importing(_BLOCKS_NEED, run.other_processes if (run.trials or 0) > _MANY_TRIALS else 0):
        page = _PAGE if run.other_processes else ""
        outcome = run_resumable(
            mission, "simulate", study, output, allow_outside=allow_outside, resume=resume, keep=True, page=page
        )
    if not outcome.requirements_met or not outcome.can_be_built:
        raise typer.Exit(REQUIREMENT_NOT_MET)


_Transition = Annotated[str | None, typer.Option(metavar="NAME", help="Name of the transition; default: the first.")]


def sweep_transition(
    mission: o.MissionFile, phase: _Transition = None, *, output: o.OutputOptions, allow_outside: o.AllowOutside = False
) -> None:
    """Compute depth, pitch and energy of slowing down to hover, over the grid of a transition phase."""
    study = partial(missionplan.sweep_transition, phase=phase)
    run_study(mission, "sweep-transition", study, output, allow_outside=allow_outside)


ExplorationAim = Literal["success", "energy", "duration"]
Least = Literal["energy", "duration"]


_Vary = Annotated[
    list[str],
    typer.Option(
        metavar="KEY=FROM:TO:STEP",
        help="What to vary, once or twice: ingress.speed=0.8:2:0.1 m/s; start=04:00:12:00:10 min; "
        "vehicle=a.yaml,b.yaml; KEY+KEY=… for keys that take the same value.",
    ),
]
_BestBy = Annotated[
    ExplorationAim,
    o.choice(
        ExplorationAim,
        "--aim",
        help="Best of those that meet all requirements: most often successful, least energy, least time.",
    ),
]
_Quantities = Annotated[
    list[str] | None,
    typer.Option("--quantity", metavar="NAME", help="Report this too, such as moor.offset; repeatable."),
]
_OnlyBest = Annotated[bool, typer.Option("--only-best", help="Few trials of what cannot be the best; no windows.")]


def explore(
    mission: o.MissionFile,
    vary: _Vary,
    aim: _BestBy = "success",
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
    with _workers_importing(_CELLS_NEED, run.other_processes):
        study = partial(
            missionplan.explore, vary=vary, aim=aim, only_best=only_best, quantities=quantity or (), **run.arguments()
        )
        exploration = run_resumable(mission, "explore", study, output, allow_outside=allow_outside, resume=resume)
    if not exploration.any_meets_all:
        raise typer.Exit(REQUIREMENT_NOT_MET)


_Choose = Annotated[
    list[str] | None,
    typer.Option(
        metavar="KEY=FROM:TO:STEP",
        help="What may be chosen, as explore's --vary; repeatable. Default: the mission's section optimise.",
    ),
]
_Least = Annotated[
    Least | None, o.choice(Least, "--aim", help="What is to be least; default: the mission's, or energy.")
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
    processes = o.worker_count(jobs)
    with _workers_importing(_CELLS_NEED, processes - 1):
        study = partial(missionplan.optimise, choose=choose or (), aim=aim, trials=trials, seed=seed, jobs=processes)
        optimisation = run_resumable(mission, "optimise", study, output, allow_outside=allow_outside, resume=resume)
    if not optimisation.feasible:
        raise typer.Exit(REQUIREMENT_NOT_MET)
