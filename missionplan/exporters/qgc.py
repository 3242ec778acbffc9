"""QGroundControl plans (`.plan`) for ArduSub and PX4: a mission of MAVLink commands for each transit.

The file is JSON as QGroundControl's developer guide has it (Plan File Format: version 1, mission 2, geoFence 2,
rallyPoints 2). Altitudes are relative to home, which is the surface (MAV_FRAME_GLOBAL_RELATIVE_ALT): depths are
negative. ArduSub takes no other frame and no positive altitude, and takes an altitude of zero as "where it is"
(`ArduSub/commands_logic.cpp`), so that the surface is a decimetre deep, its own depth of being surfaced. Its legs are
straight lines in space; a waypoint below the place of the last fix therefore comes before each.

A polygon of `geoFence` that is no inclusion keeps the vehicle out, at all times and depths (MAVLink's
NAV_FENCE_POLYGON_VERTEX_EXCLUSION); it has neither holes nor a closing corner.

NAV_LOITER_TIME goes to its place and counts from when it is there, so that a fix that comes meanwhile takes the vehicle
to the leg's end at the surface, under power.
"""

import json
import math
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from missionplan.exporters import FIXED_POINTS, header, limits_lost, no_battery, token, unheld_moorings
from missionplan.phases.transit.plan import Execution
from missionplan.results.plan import Plan, PlannedTransit
from missionplan.results.plan_places import Waypoint
from missionplan.results.plan_states import GuardKind

TITLE = "QGroundControl plan for {}"
NEEDS_ORIGIN = True
CONFORMANCE: Mapping[GuardKind, str] = {
    "reckoned-within": "kept, within the autopilot's own acceptance radius",
    "way-made": "weaker: legs go through fixed points, from where the vehicle has held its place",
    "at-surface": "kept",
    "fix-received": "weaker: it holds its place for a fixed time, in which 99 % of fixes come",
    "fix-within": "weaker: it goes to the place at the surface when a fix comes, and does not ask for one",
    "fix-beyond": "done otherwise: back to the place at the surface, and one further leg (DO_JUMP)",
    "since-fix": "refused: the crew releases the anchor between the missions",
    "at-depth": "refused, with the mooring",
    "in-state": "refused: the autopilot's failsafes have limits of their own",
    "in-phase": "refused: the autopilot's failsafes have limits of their own",
    "energy-used": "refused: by parameters set by hand, in ArduSub; PX4's failsafe lands or returns",
}

AUTOPILOTS = {"ardusub": ("ArduSub", 3), "px4": ("PX4", 12)}
"""By the end of the file's name: name, and MAV_AUTOPILOT."""
SUBMARINE = 12
"""MAV_TYPE_SUBMARINE."""
RELATIVE_TO_HOME, MISSION_FRAME = 3, 2
"""MAV_FRAME_GLOBAL_RELATIVE_ALT, and MAV_FRAME_MISSION of commands without a place."""
WAYPOINT, LOITER_TIME, JUMP, SPEED = 16, 19, 177, 178
"""MAV_CMD of NAV_WAYPOINT, NAV_LOITER_TIME, DO_JUMP and DO_CHANGE_SPEED."""
SURFACE = -0.1
"""Altitude at the surface [m]."""
RETURN_TIME = 60.0
"""For the way back to the leg's end, beside the time for a fix [s]."""
MOST_CORNERS = 255
"""Of a polygon that ArduPilot stores, three at least, the first one not repeated (`AC_PolyFence_loader`)."""
JUMPS = 1
"""Further legs for a fix that came late."""


def executes(transit: PlannedTransit) -> Execution:
    """Return how the autopilot carries out a transit: through the legs' ends, at each of which it holds its place."""
    ends = (*transit.waypoints[1:-1], *[transit.goal] * (1 + JUMPS + transit.extra_legs))  # aimed off for no drift
    points = np.array([(point.east, point.north) for point in ends]).T
    return Execution(ends="count", aim=points[:, -1], points=points, surface_time=_loiter(transit), holds=True)


def lost(plan: Plan) -> tuple[str, ...]:
    """Say what the files cannot hold."""
    return (
        "waiting for a fix: it holds its place at the surface, with power, for a fixed time "
        f"({', '.join(f'{transit.name} {_loiter(transit):.0f} s' for transit in plan.transits)})",
        "arrival by the fix: where one comes the vehicle goes on to the place at the surface, and does not ask for one",
        "what the battery gives for holding the place, which simulate --as-exported leaves out",
        FIXED_POINTS,
        "the acceptance radius in ArduSub, which is its parameter WPNAV_RADIUS; its speed may be WPNAV_SPEED",
        "time-outs, which the autopilot's failsafes have",
        *no_battery(
            plan,
            "set by hand in ArduSub BATT_CAPACITY (mAh: 1000 times that over its volts), BATT_CRT_MAH (not 0) and "
            "BATT_FS_CRT_ACT 3 (surface); in PX4 COM_LOW_BAT_ACT, which lands or returns",
        ),
        *_fence_lost(plan),
        *unheld_moorings(plan),
    )


def _fence_lost(plan: Plan) -> tuple[str, ...]:
    if not plan.fences:
        return ()
    acts = "what the autopilot does at a fence: FENCE_ENABLE, FENCE_TYPE and FENCE_ACTION in ArduSub, GF_ACTION in PX4"
    many = [f"{fence.name} {len(fence.outline)}" for fence in plan.fences if len(fence.outline) > MOST_CORNERS]
    refused = f"polygons of more than {MOST_CORNERS} corners in ArduSub, which refuses all then ({', '.join(many)})"
    return (acts, *limits_lost(plan), *((refused,) if many else ()))


def files(plan: Plan, stem: str) -> dict[str, str | bytes]:
    """Write a file for each autopilot and transit, so that no vehicle turns back before it has moored."""
    several = len(plan.transits) > 1
    return {
        f"{stem}{f'-{token(number, transit.name)}' if several else ''}-{suffix}.plan": _plan(plan, transit, suffix)
        for number, transit in enumerate(plan.transits, start=1)
        for suffix in AUTOPILOTS
    }


def _plan(plan: Plan, transit: PlannedTransit, suffix: str) -> str:
    name, autopilot = AUTOPILOTS[suffix]
    data = {
        "fileType": "Plan",
        "version": 1,
        "groundStation": "QGroundControl",
        "notes": list(header(plan, TITLE.format(name), lost(plan))),
        "mission": {
            "version": 2,
            "firmwareType": autopilot,
            "vehicleType": SUBMARINE,
            "cruiseSpeed": round(transit.speed, 4),
            "hoverSpeed": round(transit.speed, 4),
            "globalPlanAltitudeMode": 1,
            "plannedHomePosition": [*_place(transit.start), 0],
            "items": list(_items(transit)),
        },
        "geoFence": {
            "version": 2,
            "circles": [],
            "polygons": [
                {"version": 1, "inclusion": False, "polygon": [_degrees(*corner) for corner in fence.outline]}
                for fence in plan.fences
            ],
        },
        "rallyPoints": {"version": 2, "points": []},
    }
    return json.dumps(data, indent=4, ensure_ascii=False) + "\n"


def _items(transit: PlannedTransit) -> Iterator[dict[str, object]]:
    """Yield the commands: speed; for each leg down, to its end, and up; then a jump back to the last end."""
    speed = [1, round(transit.speed, 4), -1, 0, 0, 0, 0]
    yield _item(1, SPEED, MISSION_FRAME, speed)
    number, place, depth = 2, transit.start, min(-transit.depth, SURFACE)
    radius = round(transit.arrival_radius, 2)
    for end in (*transit.waypoints[1:-1], transit.goal):
        for command, at, altitude, first in (
            (WAYPOINT, place, depth, 0.0),
            (WAYPOINT, end, depth, 0.0),
            (LOITER_TIME, end, SURFACE, _loiter(transit)),
        ):
            parameters = [first, radius if command == WAYPOINT else 0, 0, None if command == WAYPOINT else 0]
            yield _item(number, command, RELATIVE_TO_HOME, [*parameters, *_place(at), round(altitude, 3)])
            number += 1
        place = end
    yield _item(number, JUMP, MISSION_FRAME, [number - 2, JUMPS + transit.extra_legs, 0, 0, 0, 0, 0])


def _item(number: int, command: int, frame: int, parameters: Sequence[object]) -> dict[str, object]:
    item: dict[str, object] = {
        "type": "SimpleItem",
        "autoContinue": True,
        "command": command,
        "doJumpId": number,
        "frame": frame,
        "params": list(parameters),
    }
    if frame == RELATIVE_TO_HOME:
        item |= {"AMSLAltAboveTerrain": None, "Altitude": parameters[-1], "AltitudeMode": 1}
    return item


def _loiter(transit: PlannedTransit) -> float:
    return math.ceil(transit.surfacing.surface_time_p99) + RETURN_TIME


def _place(waypoint: Waypoint) -> list[float]:
    return _degrees(waypoint.latitude, waypoint.longitude)


def _degrees(latitude: float, longitude: float) -> list[float]:
    return [round(math.degrees(latitude), 8), round(math.degrees(longitude), 8)]
