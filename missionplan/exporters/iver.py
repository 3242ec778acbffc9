"""OceanServer/L3Harris Iver: a VectorMap mission (`.mis`) with a waypoint at the end of each planned leg.

A waypoint is a line `number; latitude; longitude; distance; heading; commands; 0;-1`: decimal degrees, metres and
degrees from true north, then D (depth, feet), P (time to park at the surface, minutes), VC (cameras, off) and S
(speed, knots). Conventions after the mission files that VectorMap and Neptus write and that the perls library of
the University of Michigan reads ("Iver2 Mission Planning Manual", rev. 1.2).
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise

import numpy as np

from missionplan.exporters import (
    FIXED_POINTS,
    header,
    no_battery,
    no_correction,
    no_decision,
    plain,
    token,
    unheld_moorings,
    zones_lost,
)
from missionplan.phases.transit.plan import Execution
from missionplan.results.plan import Plan, PlannedTransit
from missionplan.results.plan_places import Waypoint
from missionplan.results.plan_states import GuardKind

TITLE = "mission for Iver (VectorMap)"
NEEDS_ORIGIN = True
CONFORMANCE: Mapping[GuardKind, str] = {
    "reckoned-within": "weaker: within 5 m of the point (WPRadius)",
    "way-made": "weaker: legs go through fixed points and may be longer than d_max by the drift",
    "at-surface": "kept: it parks at the surface",
    "fix-received": "weaker: it parks for whole minutes, in which 99 % of fixes come",
    "fix-within": "refused: no guard on a place; the planned legs and some more, then the end",
    "fix-beyond": "weaker: a fixed number of further legs",
    "since-fix": "refused: the crew releases the anchor between the missions",
    "at-depth": "refused, with the mooring",
    "in-state": "refused",
    "in-phase": "refused: the vehicle's safety rules have a time-out of their own (RunsLnger)",
    "energy-used": "refused: the vehicle's safety rules have a limit of their own (MinPower)",
}

FOOT = 0.3048
"""[m]"""
KNOT = 1852.0 / 3600.0
"""[m/s]"""
NEAR = 5.0
"""A vehicle under way turns for the next waypoint within so much of one [m]."""
_COLUMNS = (
    "2X ;WP Number; Latitude; Longitude; Distance(m); Heading; Depth(ft) (D:depth from surface, H: Height from bottom, "
    "U:undulate); P:Parking(mins) VC:Video Camera S:Speed(kn) SS:Sidescan MB:Multibeam"
)


def executes(transit: PlannedTransit) -> Execution:
    """Return how the vehicle carries out a transit: to each point by dead reckoning, and up for a fixed time."""
    points = np.array([(point.east, point.north) for point in transit.sequence]).T
    near = _radius(transit)
    return Execution(
        ends="count", aim=points[:, -1], points=points, capture=near, surface_time=60.0 * _minutes(transit)
    )


def lost(plan: Plan) -> tuple[str, ...]:
    """Say what the file cannot hold."""
    times = {(transit.surfacing.surface_time_p99, _minutes(transit)) for transit in plan.transits}
    parked = ", ".join(f"{minutes} min for {time:.0f} s" for time, minutes in sorted(times))
    return (
        f"times at the surface but in whole minutes ({parked})",
        "time-outs; the vehicle's safety rules, which the file leaves alone, have one (RunsLnger)",
        "a fix that does not come while it parks: it goes on by dead reckoning",
        *no_battery(plan, "the vehicle's safety rules, which the file leaves alone, have one (MinPower)"),
        FIXED_POINTS,
        *no_correction(plan),
        *no_decision(plan),
        *zones_lost(plan),
        *unheld_moorings(plan),
    )


def files(plan: Plan, stem: str) -> dict[str, str | bytes]:
    """Write a file for each transit, so that no vehicle turns back before it has moored."""
    several = len(plan.transits) > 1
    names = [
        f"{stem}-{token(number, transit.name)}" if several else stem for number, transit in enumerate(plan.transits, 1)
    ]
    return {f"{name}.mis": _mission(plan, transit, name) for name, transit in zip(names, plan.transits, strict=True)}


def _mission(plan: Plan, transit: PlannedTransit, name: str) -> str:
    park, stops = _minutes(transit), (transit.start, *transit.sequence)
    lines = ["MISSION FILE VERSION V1.1", _COLUMNS, "MISSION NAME", plain(name), "START"]
    ways = [_way(*pair) for pair in pairwise((stops[0], *stops))]
    lines += [
        _line(number, transit, waypoint, park, *way)
        for number, (waypoint, way) in enumerate(zip(stops, ways, strict=True), start=1)
    ]
    lines += ["END", "WP TIMING", *_timing(stops, ways, park), "END WP TIMING"]
    lines += ["START NOTES", *(plain(line) for line in header(plan, TITLE, lost(plan))), "END NOTES"]
    lines += ["START VEHICLE", f"UVC=WPRadius={_radius(transit):.0f}", "END VEHICLE"]
    return "\r\n".join(lines) + "\r\n"


def _way(before: Waypoint, after: Waypoint) -> tuple[float, float]:
    """Length [m] and heading [deg] of the way between two points, which may lie off the planned course."""
    east, north = after.east - before.east, after.north - before.north
    return math.hypot(east, north), math.degrees(math.atan2(east, north)) % 360.0


def _line(number: int, transit: PlannedTransit, waypoint: Waypoint, park: int, length: float, heading: float) -> str:
    at_start = waypoint.kind == "start"
    depth = 0.0 if at_start else transit.depth / FOOT
    return (
        f"{number}; {math.degrees(waypoint.latitude):.7f}; {math.degrees(waypoint.longitude):.7f}; "
        f"{length:.3f}; {heading:.2f}; D{depth:.2f} P{0 if at_start else park} "
        f"VC1,0,0,1000,0,VC2,0,0,1000,0 S{transit.speed / KNOT:.3f}; 0;-1"
    )


def _timing(stops: Sequence[Waypoint], ways: Sequence[tuple[float, float]], park: int) -> Iterator[str]:
    time = distance = 0.0
    for number, (waypoint, (length, _)) in enumerate(zip(stops, ways, strict=True), start=1):
        time += waypoint.duration + (60.0 * park if number > 1 else 0.0)
        distance += length
        yield f"WP{number};Time={time:.1f};Dist={distance:.1f}"
    hours, rest = divmod(round(time), 3600)
    yield f"Total Time = {hours:02d}:{rest // 60:02d}:{rest % 60:02d};Total Distance = {distance:.2f}"


def _radius(transit: PlannedTransit) -> float:
    """Distance at which a waypoint counts as reached by dead reckoning, which is not the arrival radius [m]."""
    return min(NEAR, max(math.floor(transit.arrival_radius), 1.0))


def _minutes(transit: PlannedTransit) -> int:
    """Whole minutes that hold the time of 99 % of the fixes, at least one: else the vehicle does not surface."""
    return max(math.ceil(transit.surfacing.surface_time_p99 / 60.0), 1)
