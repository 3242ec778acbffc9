"""The gain for the plan: what the planner would choose with the base and with the extended model."""

import math
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from missionplan.diagnose.data import TANK
from missionplan.errors import MissionplanError
from missionplan.mission import Mission, load
from missionplan.mission.phases import MoorPhase
from missionplan.results.base import to_yaml
from missionplan.studies.simulate import simulate
from missionplan.studies.size_anchor import size_anchor
from missionplan.studies.sweep_dmax import sweep_dmax

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
    seed, jobs : int
        Of the Monte Carlo runs.

    Returns
    -------
    dict
        ``before`` and ``after``, and ``base_choice_under_extended``: how the base model's choice fares when the
        extended model is true; or ``reason`` why there is no plan to compare.
    """
    if kind in TANK and not (base.moors and base.vehicle and base.vehicle.anchor):
        return {"before": {}, "after": {}, "reason": "no mooring's anchor, whose choice the tank's data could change"}
    try:
        after = load_data(extended)
        choose = _leg_length if kind == "transit" else _anchor
        return choose(base, after, seed, jobs)
    except MissionplanError as error:
        return {"before": {}, "after": {}, "reason": str(error)}


def load_data(data: Mapping[str, Any]) -> Mission:
    """Load a mission from its data, as `simulate` would from the file that is written.

    Raises
    ------
    InputError
        When it is no mission.
    """
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "mission.yaml"
        path.write_text(to_yaml(data), encoding="utf-8")
        return load(path, allow_outside=True)


def _leg_length(base: Mission, extended: Mission, seed: int, jobs: int) -> dict[str, Any]:
    found = []
    for mission in (base, extended):
        plain = mission.model_copy(update={"sweep": type(mission.sweep).model_validate({"d_max": GRID})})
        sweep = sweep_dmax(plain, trials=TRIALS, seed=seed, jobs=jobs, method="monte-carlo")
        found.append(sweep.curves[0])
    before, after = found
    same = after.points[before.best_index]
    return {
        "before": {"d_max_m": before.best.d_max, "cost": _finite(before.best.cost), "arrived": _value(before.best)},
        "after": {"d_max_m": after.best.d_max, "cost": _finite(after.best.cost), "arrived": _value(after.best)},
        "base_choice_under_extended": {"d_max_m": same.d_max, "cost": _finite(same.cost), "arrived": _value(same)},
    }


def _value(point: Any) -> float:
    return float(point.arrived.value)


def _finite(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def _anchor(base: Mission, extended: Mission, seed: int, jobs: int) -> dict[str, Any]:
    chosen = [float(size_anchor(m, trials=TRIALS, seed=seed, jobs=jobs).anchor.wet_weight) for m in (base, extended)]
    results = [
        _odds(mission, weight, seed, jobs)
        for mission, weight in ((base, chosen[0]), (extended, chosen[1]), (extended, chosen[0]))
    ]
    return dict(zip(("before", "after", "base_choice_under_extended"), results, strict=True))


def _odds(mission: Mission, weight: float, seed: int, jobs: int) -> dict[str, Any]:
    """Probabilities of a mooring with a given anchor."""
    moor = next(phase for phase in mission.phases if isinstance(phase, MoorPhase))
    entries = tuple(
        entry.model_copy(update={"moor": entry.moor.model_copy(update={"anchor_wet_weight": weight})})
        if entry.moor is moor
        else entry
        for entry in mission.entries
    )
    outcome = simulate(mission.model_copy(update={"entries": entries}), trials=TRIALS, seed=seed, jobs=jobs)
    phase = next(phase for phase in outcome.phases if phase.name == moor.name)
    return {
        "anchor_wet_weight_n": weight,
        "within_radius": phase.events["within_radius"].value,
        "struck_seafloor": phase.events["struck_seafloor"].value,
    }
