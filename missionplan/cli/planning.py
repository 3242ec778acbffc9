"""Commands that plan: sweep-dmax, plan-legs, size-anchor, simulate, sweep-transition."""

from collections.abc import Mapping, Sequence
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from missionplan.cli import options as o
from missionplan.cli.running import Progress, run_resumable, run_study

if TYPE_CHECKING:
    from missionplan.mission import Mission
    from missionplan.results.base import Result
    from missionplan.results.simulation import Outcome

REQUIREMENT_NOT_MET = 3


class CostMethod(StrEnum):
    """How the cost of a d_max is computed."""

    BOTH = "both"
    ANALYTIC = "analytic"
    MONTE_CARLO = "monte-carlo"


class LegObjective(StrEnum):
    """What legs are chosen for."""

    MEAN = "mean"
    P95 = "p95"
    ENERGY = "energy"


_Method = Annotated[
    CostMethod | None,
    o.choice(CostMethod, "--method", help="Default: both where the analytic form applies.", show_default=False),
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

    def study(loaded: "Mission", progress: Progress) -> "Result":
        from missionplan.studies.leg_length.sweep_dmax import sweep_dmax

        return sweep_dmax(loaded, method=method.value if method else None, progress=progress, **run.arguments())

    _exit_as_judged(run_study(mission, "sweep-dmax", study, output, allow_outside=allow_outside))


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
    aim: _Aim = LegObjective.MEAN,
    *,
    run: o.MonteCarloOptions,
    output: o.OutputOptions,
    allow_outside: o.AllowOutside = False,
) -> None:
    """Find leg lengths that adapt to the distance left, and what they save against the best fixed d_max."""

    def study(loaded: "Mission", progress: Progress) -> "Result":
        from missionplan.studies.leg_length.plan_legs import plan_legs

        return plan_legs(loaded, aim=aim.value, progress=progress, **run.arguments())

    _exit_as_judged(run_study(mission, "plan-legs", study, output, allow_outside=allow_outside))


def _exit_as_judged(result: "Result | None") -> None:
    """Exit with 3 where the mission with what is recommended misses a requirement."""
    judged = getattr(result, "judged", None)
    if judged is not None and not judged.requirements_met:
        raise typer.Exit(REQUIREMENT_NOT_MET)


_Probability = Annotated[
    float | None,
    typer.Option(
        help="Also find the lightest anchor whose dives stay within the radius with this probability; "
        "default: what the mission requires.",
        show_default=False,
    ),
]
_Mooring = Annotated[str | None, typer.Option(help="Name of the mooring; default: the first.", show_default=False)]


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
    from missionplan.results.anchor_sizing import AnchorSizing

    def study(loaded: "Mission", progress: Progress) -> AnchorSizing:
        from missionplan.studies.anchor.size_anchor import size_anchor

        return size_anchor(loaded, probability=probability, phase=phase, progress=progress, **run.arguments())

    sizing = run_study(mission, "size-anchor", study, output, allow_outside=allow_outside)
    if isinstance(sizing, AnchorSizing) and not sizing.succeeds:
        raise typer.Exit(REQUIREMENT_NOT_MET)


_Precision = Annotated[
    str | None,
    typer.Option(
        metavar="TARGET",
        help="Stop when the standard error is below it: 0.5% (of P(success)), total.duration=0.5%, moor.offset=0.1m.",
        show_default=False,
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
        show_default=False,
    ),
]


class VehicleFormat(StrEnum):
    """Formats that a vehicle carries out; the names are those of `missionplan.exporters.formats`."""

    SLOCUM = "slocum"
    MOOS = "moos"
    NEPTUS = "neptus"
    IVER = "iver"
    QGC = "qgc"


_AsExported = Annotated[
    VehicleFormat | None,
    o.choice(
        VehicleFormat,
        "--as-exported",
        metavar="FORMAT",
        help=f"Run what the vehicle does with the files of `export`, one of {', '.join(VehicleFormat)}.",
        show_default=False,
    ),
]


_Rare = Annotated[
    str | None,
    typer.Option(
        metavar="[EVENT]",
        help="Estimate the probability of a rare failure instead, and how it comes about: 'not total.success' "
        "(where no event is given), moor.struck_seafloor, 'moor.offset > 30 m'. --trials: at most; --precision: "
        "coefficient of variation, default 10%.",
        show_default=False,
    ),
]


def with_default_event(arguments: Sequence[str]) -> list[str]:
    """Add the event that `--rare` stands for where it is given without one: typer's options need their values."""
    given = list(arguments)
    for place in reversed([place for place, argument in enumerate(given) if argument == "--rare"]):
        if place + 1 == len(given) or given[place + 1].startswith("-"):
            given.insert(place + 1, FAILS)
    return given


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
        given = {"resume": resume, "keep_trials": keep_trials, "searched": searched is not None}
        _refuse_with_rare({**given, "as_exported": as_exported is not None})

        def study(loaded: "Mission", progress: Progress) -> "Result":
            from missionplan.studies.rare_failure.find_rare_failure import find_rare_failure

            return find_rare_failure(loaded, event=rare, precision=precision, progress=progress, **run.arguments())

        run_study(mission, "simulate", study, output, allow_outside=allow_outside)
        return

    def outcome_of(loaded: "Mission", kept: "Path", progress: Progress) -> "Outcome":
        from missionplan.studies.simulation.simulate import simulate

        return simulate(
            loaded,
            precision=precision,
            checkpoint=kept,
            resume=resume,
            keep_trials=keep_trials,
            searched=searched,
            assumptions=assumptions,
            as_exported=as_exported.value if as_exported else None,
            progress=progress,
            **run.arguments(),
        )

    outcome = run_resumable(
        mission, "simulate", outcome_of, output, allow_outside=allow_outside, resume=resume, keep=True
    )
    if not outcome.requirements_met or not outcome.can_be_built:
        raise typer.Exit(REQUIREMENT_NOT_MET)


def _refuse_with_rare(given: Mapping[str, bool]) -> None:
    """Refuse options of the plain simulation that a search for a rare failure does not have."""
    from missionplan.errors import InputError, Problem

    problems = [
        Problem("does not go with --rare, which writes failures.csv and starts anew", key=name)
        for name, is_given in given.items()
        if is_given
    ]
    if problems:
        raise InputError(problems)


_Transition = Annotated[
    str | None, typer.Option(metavar="NAME", help="Name of the transition; default: the first.", show_default=False)
]


def sweep_transition(
    mission: o.MissionFile,
    phase: _Transition = None,
    *,
    output: o.OutputOptions,
    allow_outside: o.AllowOutside = False,
) -> None:
    """Compute depth, pitch and energy of slowing down to hover, over the grid of a transition phase."""

    def study(loaded: "Mission", progress: Progress) -> "Result":
        from missionplan.studies.sweep_transition import sweep_transition

        return sweep_transition(loaded, phase=phase, progress=progress)

    run_study(mission, "sweep-transition", study, output, allow_outside=allow_outside)
