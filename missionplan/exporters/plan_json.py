"""The whole plan as JSON, for programs; `plan.schema.json` beside this module says what each key is."""

import json
import math
from collections.abc import Iterable
from dataclasses import asdict
from importlib.resources import files as files_of
from typing import cast

from missionplan.exporters.table import OF_MOORINGS, OF_TRANSITS, known, place, waypoint_row
from missionplan.results import to_json
from missionplan.results.plan import Plan, PlannedMooring, PlannedTransit
from missionplan.results.plan_states import ACTIONS, GUARDS, State, states_of

TITLE = "JSON, all of the plan"
NEEDS_ORIGIN = False

_ELSEWHERE = (*OF_TRANSITS, *OF_MOORINGS)
_LIMITS = "from_s", "to_s", "above_m", "below_m"
_UNITS = {"interval": "_m", "table": "_m"}
"""Of the fields of a rule for surfacing; others are times."""


def lost(plan: Plan) -> tuple[str, ...]:
    """Say what the form cannot hold: nothing."""
    del plan
    return ()


PLAN_FORMAT = 2
"""Number of the form: it goes up when a file of it would be read otherwise."""


def files(plan: Plan, stem: str) -> dict[str, str | bytes]:
    """Write one file."""
    return {f"{stem}.plan.json": plan_json(plan)}


def plan_json(plan: Plan) -> str:
    """Write the plan; what is not known is null."""
    return to_json(plan_data(plan))


def plan_schema() -> dict[str, object]:
    """Return the JSON schema of these files (draft 2020-12)."""
    return cast(
        dict[str, object], json.loads((files_of("missionplan.exporters") / "plan.schema.json").read_text("utf-8"))
    )


def plan_data(plan: Plan) -> dict[str, object]:
    """Return the whole plan by the keys of `plan.json`: SI units that end the key, angles in degrees."""
    return {
        "format": "missionplan plan",
        "format_version": PLAN_FORMAT,
        "mission": plan.mission,
        "mission_sha256": plan.digest,
        "missionplan": plan.version,
        "start_utc": plan.start.isoformat() if plan.start else None,
        "origin": None
        if plan.origin is None
        else {"latitude_deg": math.degrees(plan.origin[0]), "longitude_deg": math.degrees(plan.origin[1])},
        "phases": [_mooring(phase) if isinstance(phase, PlannedMooring) else _transit(phase) for phase in plan.phases],
        "states": [_state(state) for state in states_of(plan)],
        "fences": [
            {
                "name": fence.name,
                "kind": fence.kind,
                "outline_deg": _corners(fence.outline),
                "holes_deg": [_corners(hole) for hole in fence.holes],
                **{key: fence.limits.get(key) for key in _LIMITS},
            }
            for fence in plan.fences
        ],
        "notes": list(plan.notes),
    }


def _corners(ring: Iterable[Iterable[float]]) -> list[list[float]]:
    return [[round(math.degrees(each), 8) for each in corner] for corner in ring]


def _state(state: State) -> dict[str, object]:
    return {
        "name": state.name,
        "kind": state.kind,
        "phase": state.phase or None,
        "does": ACTIONS[state.kind],
        "transitions": [
            {
                "to": transition.to,
                "guards": [
                    {"kind": guard.kind, "value": known(guard.value, 3), "unit": GUARDS[guard.kind][1] or None}
                    for guard in transition.guards
                ],
            }
            for transition in state.transitions
        ],
    }


def _transit(transit: PlannedTransit) -> dict[str, object]:
    rule = transit.surfacing
    return {
        "name": transit.name,
        "kind": "transit",
        "depth_m": transit.depth,
        "speed_m_s": transit.speed,
        "arrival_radius_m": transit.arrival_radius,
        "duration_p99_s": known(transit.duration_p99, 1),
        "time_out_s": transit.time_out,
        "surfacing": {f"{key}{_UNITS.get(key, '_s')}": _rounded(value) for key, value in asdict(rule).items()},
        "waypoints": [
            {key: value for key, value in waypoint_row(transit, waypoint).items() if key not in _ELSEWHERE}
            for waypoint in transit.waypoints
        ],
    }


def _mooring(mooring: PlannedMooring) -> dict[str, object]:
    return {
        "name": mooring.name,
        "kind": "mooring",
        **place(mooring),
        "radius_m": mooring.radius,
        "water_depth_m": known(mooring.water_depth, 3),
        "line_length_m": mooring.line_length,
        "anchor_wet_weight_n": known(mooring.anchor_wet_weight, 3),
        "release_time_s": round(mooring.release_time, 2),
        "release_time_p99_s": round(mooring.release_time_p99, 2),
        "hold_s": mooring.hold,
        "galvanic_release_s": mooring.galvanic_release,
        "elapsed_s": known(mooring.elapsed, 1),
    }


def _rounded(value: object) -> object:
    return round(value, 3) if isinstance(value, float) else value
