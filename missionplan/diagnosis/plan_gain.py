"""The gain for the plan: what the planner would choose with the base and with the extended model."""

import math
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

from missionplan.datasets.reading import TANK
from missionplan.errors import MissionplanError
from missionplan.mission import Mission
from missionplan.montecarlo.parallel_map import parallel_map
from missionplan.results.sweep import SweepCurve
from missionplan.studies.anchor.size_anchor import worst_case_anchor
from missionplan.studies.leg_length.sweep_dmax import sweep_dmax
from missionplan.studies.simulation.simulate import simulate

TRIALS = 1000
GRID = {"from": 0.1, "to": 1.0, "points": 10, "of": "distance"}


def decide(kind: str, base: Mission, extended: Mapping[str, Any], *, seed: int, jobs: int) -> dict[str, Any]:
    """Plan with both models; where the plan lacks a part, say which.

    Parameters
    ----------
    kind : str
        Of the data set: what is chosen is d_max for a transit, the anchor for a descent.
    base : Mission
    extended : mapping
        Data of the extended mission.
    seed : int
        Of the Monte Carlo runs.
    jobs : int
        Processes among which the missions are shared.

    Returns
    -------
    dict
        ``before`` and ``after``, and ``base_choice_under_extended``: how the base model's choice fares when the
        extended model is true; or ``reason`` why there is no plan to compare.
    """
    if kind in TANK and not (base.moors and base.vehicle and base.vehicle.anchor):
        return {"before": {}, "after": {}, "reason": "no mooring's anchor, whose choice the tank's data could change"}
    try:
        after = Mission.from_data(extended)
        choose = _leg_length if kind == "transit" else _anchor
        return choose(base, after, seed, jobs)
    except MissionplanError as error:
        return {"before": {}, "after": {}, "reason": str(error)}


def _leg_length(base: Mission, extended: Mission, seed: int, jobs: int) -> dict[str, Any]:
    before, after = parallel_map(partial(_sweeps, seed), (base, extended), jobs=jobs)
    same = after.points[before.best_index]
    return {
        "before": {"d_max_m": before.best.d_max, "cost": _finite(before.best.cost), "arrived": _value(before.best)},
        "after": {"d_max_m": after.best.d_max, "cost": _finite(after.best.cost), "arrived": _value(after.best)},
        "base_choice_under_extended": {"d_max_m": same.d_max, "cost": _finite(same.cost), "arrived": _value(same)},
    }


def _sweeps(seed: int, missions: Sequence[Mission]) -> list[SweepCurve]:
    """Cost over d_max of each mission."""
    plain = [m.model_copy(update={"sweep": type(m.sweep).model_validate({"d_max": GRID})}) for m in missions]
    return [sweep_dmax(m, trials=TRIALS, seed=seed, method="monte-carlo").curves[0] for m in plain]


def _value(point: Any) -> float:
    return float(point.arrived.value)


def _finite(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def _anchor(base: Mission, extended: Mission, seed: int, jobs: int) -> dict[str, Any]:
    missions = [_carrying(mission) for mission in (base, extended)]
    chosen = [worst_case_anchor(mission) for mission in missions]
    cases = [(missions[0], chosen[0]), (missions[1], chosen[1])]
    if chosen[0] != chosen[1]:
        cases.append((missions[1], chosen[0]))
    results = parallel_map(partial(_odds, seed), cases, jobs=jobs)
    return {"before": results[0], "after": results[1], "base_choice_under_extended": results[-1]}


def _carrying(mission: Mission) -> Mission:
    """The mission with an anchor that carries the vehicle's net buoyancy too: Eq. 15's alone may not even sink it."""
    return _with_mooring(mission, carry_net_buoyancy=True)


def _with_mooring(mission: Mission, **changes: Any) -> Mission:
    """The mission with its first mooring, if there is one, changed."""
    first = next(iter(mission.moors), None)
    entries = tuple(
        entry.model_copy(update={"moor": first.model_copy(update=changes)}) if first and entry.moor is first else entry
        for entry in mission.entries
    )
    return mission.model_copy(update={"entries": entries})


def _odds(seed: int, cases: Sequence[tuple[Mission, float]]) -> list[dict[str, Any]]:
    """Probabilities of each mooring with a given anchor."""
    return [_mooring(mission, weight, seed) for mission, weight in cases]


def _mooring(mission: Mission, weight: float, seed: int) -> dict[str, Any]:
    outcome = simulate(_with_mooring(mission, anchor_wet_weight=weight), trials=TRIALS, seed=seed)
    phase = next(phase for phase in outcome.phases if phase.name == mission.moors[0].name)
    return {
        "anchor_wet_weight_n": weight,
        "within_radius": phase.events["within_radius"].value,
        "struck_seafloor": phase.events["struck_seafloor"].value,
        "success": outcome.total.events["success"].value,
    }
