"""The gain for the plan: what the planner would choose with the base and with the extended mission."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial

from missionplan.errors import MissionplanError
from missionplan.mission import Mission
from missionplan.mission.schema.phases import MoorPhase
from missionplan.montecarlo.blocks import parallel_map
from missionplan.montecarlo.distributions import mean_of
from missionplan.montecarlo.posterior import NOWHERE
from missionplan.results.failures import SUCCESS, Counted
from missionplan.results.learned import Plan, PlanGain
from missionplan.results.learned.levels import AHEAD, ParameterLevels
from missionplan.studies.leg_length.sweep_result import SweepCurve, SweepPoint

Choice = Callable[[Mission, Mission, int, int], PlanGain]
"""Of base and extended mission, seed and processes."""

TRIALS = 1000
TRIALS_AHEAD, MATTERS = 2000, 0.01
"""Trials of each, and fall of the probability of success from which it does."""
GRID = {"from": 0.1, "to": 1.0, "points": 10, "of": "distance"}
"""Maximum leg lengths that are tried."""


def plan_gain(choice: Choice, base: Mission, extended: Mapping[str, object], *, seed: int, jobs: int) -> PlanGain:
    """Plan with both missions, or find out why that cannot be done.

    Parameters
    ----------
    choice : callable
        What is chosen: `leg_length_choice` or `anchor_choice`.
    base : Mission
    extended : mapping
        Data of the extended mission.
    seed : int
        Of the Monte Carlo runs.
    jobs : int
        Processes among which the missions are shared.
    """
    try:
        return choice(base, Mission.from_data(extended), seed, jobs)
    except MissionplanError as error:
        return PlanGain(reason=str(error))


def leg_length_choice(base: Mission, extended: Mission, seed: int, jobs: int) -> PlanGain:
    """Choose the maximum leg length that `sweep_dmax` recommends."""
    swept = next((phase for phase in base.transits if base.sweep.phase in (None, phase.name)), None)
    written = None if swept is None or hasattr(swept.d_max, "table") else mean_of(swept.d_max)
    asked = [(base, None), (extended, None), *([(extended, written)] if written is not None else [])]
    before, after, *others = parallel_map(partial(_sweeps, seed), asked, jobs=jobs, separately=True)
    kept = after.points[before.recommended_index]
    as_written = next((_leg_plan(curve.recommended) for curve in others), None)
    best, anew = _leg_plan(before.recommended), _leg_plan(after.recommended)
    return PlanGain(best, anew, _leg_plan(kept), as_written_under_extended=as_written)


def _sweeps(seed: int, asked: Sequence[tuple[Mission, float | None]]) -> list[SweepCurve]:
    """Cost over maximum leg length of each mission, or of one leg length."""
    from missionplan.studies.leg_length.sweep_dmax import first_curve  # each kind of data needs one of the studies

    tried = [(mission, GRID if d_max is None else (f"{d_max!r} m",)) for mission, d_max in asked]
    plain = [m.model_copy(update={"sweep": type(m.sweep).model_validate({"d_max": d_max})}) for m, d_max in tried]
    return [first_curve(m, trials=TRIALS, seed=seed) for m in plain]


def _leg_plan(point: SweepPoint) -> Plan:
    cost = float(point.cost) if math.isfinite(point.cost) else None
    return {"d_max_m": point.d_max, "cost": cost, "arrived": float(point.arrived.value)}


def anchor_choice(base: Mission, extended: Mission, seed: int, jobs: int) -> PlanGain:
    """Choose the anchor for the worst current of the design."""
    from missionplan.studies.anchor import worst_case_anchor

    # with an anchor that carries the vehicle's net buoyancy too: Eq. 15's alone may not even sink it
    carrying = {"carry_net_buoyancy": True}
    missions = [
        with_first_mooring(mission, lambda moor: moor.model_copy(update=carrying)) for mission in (base, extended)
    ]
    chosen = [worst_case_anchor(mission) for mission in missions]
    cases = [(missions[0], chosen[0]), (missions[1], chosen[1])]
    if chosen[0] != chosen[1]:
        cases.append((missions[1], chosen[0]))
    written = missions[1].moors[0].anchor_wet_weight
    written_cases = [] if isinstance(written, str) else [(missions[1], mean_of(written))]
    results = parallel_map(partial(_anchor_plans, seed), [*cases, *written_cases], jobs=jobs, separately=True)
    as_written = results[-1] if written_cases else None
    return PlanGain(results[0], results[1], results[len(cases) - 1], as_written_under_extended=as_written)


def with_first_mooring(mission: Mission, change: Callable[[MoorPhase], MoorPhase]) -> Mission:
    """The mission with its first mooring, if there is one, changed."""
    first = next(iter(mission.moors), None)
    entries = tuple(
        entry.model_copy(update={"moor": change(first)}) if first and entry.moor is first else entry
        for entry in mission.entries
    )
    return mission.model_copy(update={"entries": entries})


def with_anchor(mission: Mission, weight: float) -> Mission:
    """The mission with an anchor of this wet weight [N] in its first mooring."""
    return with_first_mooring(mission, lambda moor: moor.model_copy(update={"anchor_wet_weight": weight}))


def _anchor_plans(seed: int, cases: Sequence[tuple[Mission, float]]) -> list[Plan]:
    """Probabilities of each mission's first mooring with a given anchor."""
    from missionplan.studies.simulation.simulate import event_probabilities

    plans: list[Plan] = []
    for mission, weight in cases:
        anchored = with_anchor(mission, weight)
        probabilities, phase = event_probabilities(anchored, trials=TRIALS, seed=seed), mission.moors[0].name
        events = ("within_radius", "struck_seafloor")
        shares = {name: probabilities[Counted.event(f"{phase}.{name}")].value for name in events}
        plans.append({"anchor_wet_weight_n": weight, **shares, "success": probabilities[SUCCESS].value})
    return plans


def with_urgency(levels: Sequence[ParameterLevels], mission: Mission, seed: int) -> tuple[ParameterLevels, ...]:
    """Say of trends in how many missions they cost success, by simulating the mission as the vehicle then is."""
    from missionplan.studies.simulation.simulate import event_probabilities

    first: float | None = None
    for ahead in AHEAD if any(level.has_trend for level in levels) else ():
        then = mission.at_place(NOWHERE, missions=float(ahead))
        success = event_probabilities(then, trials=TRIALS_AHEAD, seed=seed)[SUCCESS].value
        first = success if first is None else first
        if success < first - MATTERS:
            return tuple(replace(level, matters_in=ahead) if level.has_trend else level for level in levels)
    return tuple(levels)
