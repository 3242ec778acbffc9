"""MOOS-IvP: a behaviour file (`.bhv`) for pHelmIvP that runs the plan's states by the variable PHASE.

Points are metres east and north in the frame of `CMOOSGeodesy`: UTM in the zone of LatOrigin and LongOrigin, less the
UTM of that origin. That grid is turned against true north by the convergence of the meridians and scaled, so that it is
not the mission's own plane. Without an origin the points are those of the mission's plane.

Behaviours and parameters are those of the MOOS-IvP documentation (Benjamin et al., "An Overview of MOOS-IvP and a Users
Guide to the IvP Helm"). No condition there can ask whether a variable has *changed*; BHV_PeriodicSurface can. One of
them, whose period never ends, therefore does nothing but post the time left of it, FIX_CLOCK, which jumps back with
every changed GPS_UPDATE_RECEIVED. FIXED is true from a fix at the surface until the vehicle dives or begins a leg. A
BHV_Waypoint of the arrival radius, run at the surface where the navigation has the fix, compares it with the goal.
"""

import math
from collections.abc import Mapping

import numpy as np

from missionplan.exporters import header, no_battery, no_correction, one_interval, plain, token, zones_lost
from missionplan.phases.transit.plan import Execution
from missionplan.results.plan import CLIMB, SURFACE_DEPTH, Plan, PlannedMooring, PlannedTransit
from missionplan.results.plan_places import Waypoint
from missionplan.results.plan_states import GuardKind

TITLE = "behaviours for MOOS-IvP"
NEEDS_ORIGIN = False
CONFORMANCE: Mapping[GuardKind, str] = {
    "reckoned-within": "kept",
    "way-made": "weaker: as time at the planned speed; the log's error is in the leg's length",
    "at-surface": "kept",
    "fix-received": "kept: GPS_UPDATE_RECEIVED changed at the surface",
    "fix-within": "kept",
    "fix-beyond": "kept",
    "since-fix": "kept, to a second",
    "at-depth": "kept",
    "in-state": "kept",
    "in-phase": "kept",
    "energy-used": "kept, where the vehicle posts ENERGY_USED",
}

FRESH = 10.0
"""Age up to which a fix is one that has just come: many iterations of a helm under time warp [s]."""
SETTLE, DECISION = 1.0, 3.0
"""For the navigation to take the fix over, and for the helm to compare it with the goal [s]."""
HANDLING = SETTLE + 2.0
"""From the fix to the release's clock, with the mail between the helm's iterations [s]."""
LATENCY = 1.0
"""A helm of 4 Hz acts up to so much after a timer has run out [s]."""
FIX_UNDER_WAY = 10.0
"""A leg that has its fix at the surface while it is still under way ends so much later [s]."""
_CLOCK = 1_000_000.0
"""Period that never ends [s]."""
_NEAR = 1.0
"""Capture radius of the point that is steered for [m]."""
_PASSED = 3.0
"""Distance from that point within which it counts as reached once it is passed by [m]."""
_END, _ABORT = "done", "abort"


def executes(transit: PlannedTransit) -> Execution:
    """Return how the helm carries out a transit: by the plan's rules, but for the correction of drift."""
    point = transit.steered_for
    return Execution(
        ends="fix",
        aim=np.array([point.east, point.north]),
        interval=transit.surfacing.interval,
        fix_wait=transit.surfacing.fix_wait,
        aborts=True,
        time_out=transit.abort_time,
    )


def lost(plan: Plan) -> tuple[str, ...]:
    """Say what the file cannot hold."""
    aimed = [f"{transit.name} aims {transit.aim_off:.1f} m off" for transit in plan.transits if transit.aim_off > _NEAR]
    instead = (f"for the mean drift at the surface {', '.join(aimed)}, and further legs follow",) if aimed else ()
    return (
        "legs by distance: the vehicle surfaces after the time that such a leg takes in still water, less the ascent",
        *one_interval(plan),
        *("; ".join(words) for words in ((*no_correction(plan), *instead),) if words),
        *no_battery(plan, "kept only where the vehicle posts ENERGY_USED, the W h used since the start"),
        *zones_lost(
            plan, "BHV_OpRegion is one convex polygon to stay in, BHV_AvoidObstacleV24 steers round convex ones"
        ),
        "the release of an anchor but as the variable ANCHOR_RELEASE, which the vehicle's driver has to act on",
    )


def files(plan: Plan, stem: str) -> dict[str, str | bytes]:
    """Write one file: the states in turn, by the variable PHASE; the helm is let loose by DEPLOY = true."""
    parts = [(phase, token(number.replace(".", "_"), phase.name)) for number, phase in plan.parts]
    firsts = [f"{name}_{'release' if isinstance(phase, PlannedMooring) else 'leg'}" for phase, name in parts]
    lines = [f"// {plain(line)}" for line in header(plan, TITLE, lost(plan))]
    lines += [f"// {line}" for line in _ASSUMED]
    lines += [
        *_frame(plan),
        "",
        "initialize DEPLOY = false",
        *(f"initialize {flag}" for flag in (*_enter(firsts[0]), "WAY = true", "FIXED = false")),
        "",
    ]
    lines += ["set MODE = ACTIVE {", "  DEPLOY = true", "} INACTIVE", ""]
    lines += [f"// FIX_CLOCK counts down from {_CLOCK:.0f} s since the last fix", *_fix_clock()]
    lines += ["// stopped at the surface, where no state asks for anything else", *_idle()]
    for (phase, name), following in zip(parts, [*firsts[1:], _END], strict=True):
        if isinstance(phase, PlannedMooring):
            lines += _mooring(phase, name, following)
        else:
            lines += _transit(plan, phase, name, following)
    return {f"{stem}.bhv": "\n".join(lines)}


def local_xy(plan: Plan, waypoint: Waypoint) -> tuple[float, float]:
    """Return a waypoint in the frame of MOOS [m]."""
    if plan.origin is None:
        return waypoint.east, waypoint.north
    from pyproj import Proj

    latitude, longitude = (math.degrees(angle) for angle in plan.origin)
    projection = Proj(proj="utm", zone=utm_zone(latitude, longitude), ellps="WGS84")
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


_ASSUMED = (
    f"Assumed: the vehicle floats, and climbs at {math.degrees(CLIMB):.0f} degrees or steeper: it goes up by that way",
    "before the end of a leg, then on to its end, where the propeller stops, at the surface or below it.",
    "Assumed: the navigation takes a fix over at once and then posts a changed GPS_UPDATE_RECEIVED.",
)


def _enter(state: str) -> list[str]:
    """Flags that lead to a state, and to its stage, the phase of the mission."""
    return [f"PHASE = {state}", f"STAGE = {state.rpartition('_')[0] or state}"]


_UP, _UNDER = f"NAV_DEPTH <= {SURFACE_DEPTH:g}", f"NAV_DEPTH > {2.0 * SURFACE_DEPTH:g}"
_FIXED = "FIXED = true"


def _fix_clock() -> list[str]:
    parameters: _Parameters = {
        "period": f"{_CLOCK:.0f}",
        "mark_variable": "GPS_UPDATE_RECEIVED",
        "pending_status_var": "FIX_CLOCK",
        "max_time_at_surface": f"{_CLOCK:.0f}",
    }
    fresh = f"FIX_CLOCK > {_CLOCK - FRESH:.0f}"
    return [
        *_behaviour("BHV_PeriodicSurface", "fix_clock", [], parameters),
        *_timer("fixed", [_UP, fresh, "FIXED = false"], 0.0, ["FIXED = true"]),
        *_timer("under_water", [_UNDER, "FIXED = true"], 0.0, ["FIXED = false"]),
    ]


def _transit(plan: Plan, transit: PlannedTransit, name: str, following: str) -> list[str]:
    rule, goal, margin = transit.surfacing, transit.goal, transit.ascent_margin
    leg, up, fix, decide = (f"{name}_{state}" for state in ("leg", "surfacing", "fix", "decide"))
    level = (rule.interval - margin) / transit.speed + rule.interval_time - rule.interval / transit.speed
    place = [] if plan.origin is None else [f"{math.degrees(goal.latitude):.8f}, {math.degrees(goal.longitude):.8f}"]
    steer = {"speed": f"{transit.speed:.4g}", "points": _point(plan, transit.steered_for), "repeat": "0"}
    lines = [
        f"// {plain(transit.name)}: to {' '.join(place) or 'the goal'}; legs of {rule.interval:.1f} m, the last "
        f"{margin:.1f} m of them for the ascent",
        *_waypoint(f"waypoint_{leg}", [_in(leg)], steer, (_NEAR, _PASSED), _enter(up)),
    ]
    if transit.depth > 2.0 * SURFACE_DEPTH:  # up early, but not before it has been down
        down = f"NAV_DEPTH > {0.5 * transit.depth:.2f}"
        lines += _waypoint(f"early_{leg}", [_in(leg), down], steer, (max(margin, _NEAR), 0.0), _enter(up))
    return [
        *lines,
        *_behaviour("BHV_ConstantDepth", f"depth_{leg}", [_in(leg)], _depth(transit.depth)),
        *_timer(f"interval_{leg}", [_in(leg)], level, _enter(up), leg),
        "// up, and on to the point, or as far as a leg is long",
        *_waypoint(f"rise_{up}", [_in(up), "WAY = true"], steer, (_NEAR, _PASSED), ["WAY = false"]),
        *_timer(f"whole_{leg}", [f"STAGE = {name}", "WAY = true"], rule.interval_time - LATENCY, ["WAY = false"], leg),
        *_timer(f"surfaced_{up}", [_in(up), "WAY = false", _UP], SETTLE, _enter(fix), up),
        *_timer(f"fixed_{up}", [_in(up), _FIXED], FIX_UNDER_WAY, _enter(decide), up),
        "// at the surface, until a fix comes",
        *_timer(f"fixed_{fix}", [_in(fix), _FIXED], SETTLE, _enter(decide), fix),
        *_timer(f"no_fix_{fix}", [_in(fix)], rule.fix_wait, _aborted("NO_FIX"), fix),
        "// arrived where the fix lies within the radius; else a further leg",
        *_behaviour("BHV_ConstantSpeed", f"stop_{decide}", [_in(decide)], {"speed": "0"}, _FIRST),
        *_waypoint(
            f"arrived_{decide}",
            [_in(decide)],
            {**steer, "points": _point(plan, goal)},
            (transit.arrival_radius, 0.0),
            [*_enter(following), "WAY = true"],
        ),
        *_timer(f"further_{decide}", [_in(decide)], DECISION, [*_enter(leg), "WAY = true", "FIXED = false"], decide),
        *_timer(f"time_out_{name}", [f"STAGE = {name}"], transit.abort_time, _aborted("TRANSIT")),
        *_battery(plan, name),
    ]


def _battery(plan: Plan, name: str) -> list[str]:
    if not math.isfinite(plan.capacity):
        return []
    used = f"ENERGY_USED > {plan.capacity:.6g}"
    return _timer(f"battery_{name}", [f"STAGE = {name}", used], 0.0, _aborted("BATTERY"))


def _mooring(mooring: PlannedMooring, name: str, following: str) -> list[str]:
    """At the surface until the release; then the helm is still while the vehicle is moored."""
    latest = mooring.release_time + mooring.fix_wait
    release, sink, hold, rise, fix = (f"{name}_{state}" for state in ("release", "descend", "hold", "ascend", "fix"))
    lines = [
        f"// {plain(mooring.name)}: release {mooring.release_time:.1f} s after the fix, of which {HANDLING:.1f} s have "
        f"gone; by {mooring.release_time_p99:.1f} s in 99 % of cases",
        *_timer(
            f"at_{release}",
            [_in(release), _FIXED],
            max(mooring.release_time - HANDLING, 0.0),
            ["ANCHOR_RELEASE = true", *_enter(sink)],
            release,
        ),
        *_timer(f"no_fix_{release}", [_in(release)], latest, _aborted("NO_FIX"), release),
    ]
    if math.isfinite(mooring.touchdown_depth):
        lines += _timer(
            f"down_{sink}", [_in(sink), f"NAV_DEPTH > {mooring.touchdown_depth:.2f}"], 0.0, _enter(hold), sink
        )
    return [
        *lines,
        *_timer(f"lies_{sink}", [_in(sink)], mooring.longest_sinking, _enter(hold), sink),
        *_timer(f"at_{hold}", [_in(hold)], mooring.hold, ["GALVANIC_RELEASE = true", *_enter(rise)], hold),
        *_timer(f"parted_{rise}", [_in(rise)], mooring.galvanic_release, ["WAY = false"], rise),
        *_timer(f"surfaced_{rise}", [_in(rise), "WAY = false", _UP], SETTLE, _enter(fix), rise),
        *_timer(f"late_{rise}", [_in(rise)], mooring.longest_release, _aborted("ASCENT"), rise),
        *_timer(f"fixed_{fix}", [_in(fix), _FIXED], SETTLE, [*_enter(following), "WAY = true"], fix),
        *_timer(f"no_fix_{fix}", [_in(fix)], mooring.fix_wait, _aborted("NO_FIX"), fix),
    ]


_FIRST, _LAST = 1000, 0.1
"""Priorities of a stop over a waypoint's speed, and of what is wished where nothing else is."""
_Parameters = dict[str, str | list[str]]


def _in(state: str) -> str:
    return f"PHASE = {state}"


def _aborted(reason: str) -> list[str]:
    return ["TIME_OUT = true", f"ABORTED_BY = {reason}", *_enter(_ABORT)]


def _point(plan: Plan, waypoint: Waypoint) -> str:
    x, y = local_xy(plan, waypoint)
    return f"{x:.2f},{y:.2f}"


def _depth(depth: float) -> _Parameters:
    """Keep a depth to a peak: the default peak is 6 m wide."""
    return {"depth": f"{depth:.2f}", "peakwidth": "0", "basewidth": "2"}


def _idle() -> list[str]:
    """Wishes of hardly any weight for all that a helm decides: without one for each it reports an error and stops."""
    return [
        *_behaviour("BHV_ConstantDepth", "idle_depth", [], _depth(0.0), _LAST),
        *_behaviour("BHV_ConstantSpeed", "idle_speed", [], {"speed": "0"}, _LAST),
        *_behaviour("BHV_ConstantHeading", "idle_course", [], {"heading": "0"}, _LAST),
    ]


def _waypoint(
    name: str, conditions: list[str], steer: Mapping[str, str], radii: tuple[float, float], flags: list[str]
) -> list[str]:
    """Steer for a point, until within the first radius of it, or past it within the second."""
    parameters: _Parameters = {
        **steer,
        "capture_radius": f"{radii[0]:.4g}",
        "slip_radius": f"{radii[1]:.4g}",
        "perpetual": "true",
        "endflag": flags,
    }
    return _behaviour("BHV_Waypoint", name, conditions, parameters)


def _timer(name: str, conditions: list[str], seconds: float, flags: list[str], begins: str = "") -> list[str]:
    """Post flags a time after a state began, or after the conditions first held where none is named."""
    parameters: _Parameters = {"duration": f"{seconds:.1f}", "endflag": flags, "perpetual": "true"}
    parameters["post_mapping"] = ["TIMER_IDLE,silent", "TIMER_RUNNING,silent"]  # else posted by each at every iteration
    if begins:
        parameters["duration_reset"] = f"PHASE={begins}"
    return _behaviour("BHV_Timer", name, conditions, parameters)


def _behaviour(kind: str, name: str, conditions: list[str], parameters: _Parameters, weight: float = 100) -> list[str]:
    lines = [f"Behavior = {kind}", "{"]
    settings: _Parameters = {
        "name": name,
        "pwt": f"{weight:g}",
        "condition": ["MODE == ACTIVE", *conditions],
        **parameters,
    }
    if "duration" not in parameters:
        settings["duration"] = "no-time-limit"
    for key, values in settings.items():
        lines += [f"  {key} = {value}" for value in ([values] if isinstance(values, str) else values)]
    return [*lines, "}", ""]
