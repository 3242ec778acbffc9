"""MOOS-IvP: a behaviour file (`.bhv`) for pHelmIvP with waypoint, depth and periodic-surface behaviours.

Points are metres east and north in the frame of `CMOOSGeodesy`: UTM in the zone of LatOrigin and LongOrigin, less the
UTM of that origin. That grid is turned against true north by the convergence of the meridians and scaled, so that it is
not the mission's own plane. Without an origin the points are those of the mission's plane.
"""

import math

from missionplan.exporters.header import header, one_interval, plain, token
from missionplan.results.plan import Plan, PlannedMooring, PlannedTransit, Waypoint

TITLE = "behaviours for MOOS-IvP"
NEEDS_ORIGIN = False

_SURFACE_DEPTH = 0.3
"""Depth above which the vehicle is at the surface [m]."""
_END = "done"


def lost(plan: Plan) -> tuple[str, ...]:
    """Say what the file cannot hold."""
    return (
        "time-outs of single legs; those of whole transits are there",
        "legs by distance: the vehicle surfaces after the time that such a leg takes in still water",
        *one_interval(plan),
        "the correction of the course for drift from fix to fix, unless the helm's own navigation has one",
        "the release of an anchor but as the variable ANCHOR_RELEASE, which the vehicle's driver has to act on",
    )


def files(plan: Plan, stem: str) -> dict[str, str | bytes]:
    """Write one file: the phases in turn, by the variable PHASE; the helm is let loose by DEPLOY = true."""
    names = [token(number, phase.name) for number, phase in enumerate(plan.phases, start=1)]
    lines = [f"// {plain(line)}" for line in header(plan, TITLE, lost(plan))]
    lines += [*_frame(plan), "", "initialize DEPLOY = false", f"initialize PHASE = {names[0]}", ""]
    lines += ["set MODE = ACTIVE {", "  DEPLOY = true", "} INACTIVE", ""]
    for phase, name, following in zip(plan.phases, names, [*names[1:], _END], strict=True):
        if isinstance(phase, PlannedMooring):
            lines += _mooring(phase, name, following)
        else:
            lines += _transit(plan, phase, name, following)
    lines += _behaviour("BHV_ConstantDepth", f"surface_{_END}", _END, {"depth": "0"})
    lines += _behaviour("BHV_ConstantSpeed", f"stop_{_END}", _END, {"speed": "0"})
    return {f"{stem}.bhv": "\n".join(lines)}


def local_xy(plan: Plan, waypoint: Waypoint) -> tuple[float, float]:
    """Return a waypoint in the frame of MOOS [m]."""
    if plan.origin is None:
        return waypoint.east, waypoint.north
    from pyproj import Proj

    latitude, longitude = (math.degrees(angle) for angle in plan.origin)
    projection = Proj(proj="utm", zone=utm_zone(latitude, longitude), south=latitude < 0.0, ellps="WGS84")
    origin = projection(longitude, latitude)
    place = projection(math.degrees(waypoint.longitude), math.degrees(waypoint.latitude))
    return place[0] - origin[0], place[1] - origin[1]


def utm_zone(latitude: float, longitude: float) -> int:
    """Return the number of the UTM zone of a point [deg], with the exceptions about Norway and Svalbard."""
    if 56.0 <= latitude < 64.0 and 3.0 <= longitude < 12.0:
        return 32
    if 72.0 <= latitude < 84.0 and 0.0 <= longitude < 42.0:
        return 31 + 2 * int((longitude + 3.0) // 12.0)
    return int((longitude + 180.0) % 360.0 // 6.0) + 1


def _frame(plan: Plan) -> list[str]:
    if plan.origin is None:
        return ["// The mission has no origin: points are east and north of its own plane [m]."]
    latitude, longitude = (math.degrees(angle) for angle in plan.origin)
    return [
        "// Points are metres in the frame of this origin, to be set in the .moos file:",
        f"//   LatOrigin  = {latitude:.8f}",
        f"//   LongOrigin = {longitude:.8f}",
    ]


def _transit(plan: Plan, transit: PlannedTransit, name: str, following: str) -> list[str]:
    rule, goal = transit.surfacing, transit.goal
    x, y = local_xy(plan, goal)
    place = [] if plan.origin is None else [f"{math.degrees(goal.latitude):.8f}, {math.degrees(goal.longitude):.8f}"]
    return [
        f"// {plain(transit.name)}: to {' '.join(place) or 'the goal'}",
        *_behaviour(
            "BHV_Waypoint",
            f"waypoint_{name}",
            name,
            {
                "speed": f"{transit.speed:.4g}",
                "capture_radius": f"{transit.arrival_radius:.4g}",
                "slip_radius": f"{transit.arrival_radius:.4g}",
                "points": f"{x:.2f},{y:.2f}",
                "repeat": "0",
                "endflag": f"PHASE = {following}",
            },
        ),
        *_behaviour("BHV_ConstantDepth", f"depth_{name}", name, {"depth": f"{transit.depth:.2f}"}),
        *_behaviour(
            "BHV_PeriodicSurface",
            f"surface_{name}",
            name,
            {
                "period": f"{rule.interval_time:.1f}",
                "mark_variable": "GPS_UPDATE_RECEIVED",
                "zero_speed_depth": f"{_SURFACE_DEPTH:g}",
                "max_time_at_surface": f"{math.ceil(rule.surface_time)}",
                "ascent_speed": "current",
                "ascent_grade": "fullspeed",
            },
            weight=1000,
        ),
        *_behaviour(
            "BHV_Timer",
            f"time_out_{name}",
            name,
            {"duration": f"{transit.time_out:.0f}", "endflag": "TIME_OUT = true"},
        ),
    ]


def _mooring(mooring: PlannedMooring, name: str, following: str) -> list[str]:
    """At the surface until the release; then the helm is still while the vehicle is moored."""
    release, hold = f"release_{name}", f"hold_{name}"
    return [
        f"// {plain(mooring.name)}: release, by {mooring.release_time_p99:.1f} s in 99 % of cases; hold",
        *_behaviour("BHV_ConstantDepth", f"surface_{name}", name, {"depth": "0"}),
        *_behaviour("BHV_ConstantSpeed", f"stop_{name}", name, {"speed": "0"}),
        *_behaviour(
            "BHV_Timer",
            release,
            name,
            {"duration": f"{mooring.release_time:.1f}", "endflag": ["ANCHOR_RELEASE = true", f"PHASE = {hold}"]},
        ),
        *_behaviour("BHV_ConstantSpeed", f"stop_{hold}", hold, {"speed": "0"}),
        *_behaviour(
            "BHV_Timer",
            hold,
            hold,
            {
                "duration": f"{mooring.hold + mooring.galvanic_release:.1f}",
                "endflag": ["GALVANIC_RELEASE = true", f"PHASE = {following}"],
            },
        ),
    ]


def _behaviour(
    kind: str, name: str, phase: str, parameters: dict[str, str | list[str]], weight: int = 100
) -> list[str]:
    lines = [f"Behavior = {kind}", "{"]
    given: dict[str, str | list[str]] = {
        "name": name,
        "pwt": str(weight),
        "condition": ["MODE == ACTIVE", f"PHASE = {phase}"],
        **parameters,
    }
    if "duration" not in parameters:
        given["duration"] = "no-time-limit"
    for key, values in given.items():
        lines += [f"  {key} = {value}" for value in ([values] if isinstance(values, str) else values)]
    return [*lines, "}", ""]
