"""Teledyne Slocum gliders: `goto_l*.ma`, `surfac*.ma` and `yo*.ma`, the files that a glider's mission names by number.

Latitudes and longitudes are degrees and decimal minutes in one number, DDMM.mmmm and DDDMM.mmmm, longitude first and
west negative; angles are radians. Each transit has a number of its own: 10 for the first, 11 for the second.

Arguments, their limits (`LIMITS`) and the meaning of `start_when` are those of Teledyne's masterdata, which annotates
them with ``#!``; the files repeat the annotation. A glider flies no level run but with its thruster, between two depths
about the run depth; what it cannot do is refused.
"""

import math
from collections.abc import Mapping

import numpy as np

from missionplan.errors import InputError, Problem
from missionplan.exporters.header import NO_REMAINING_LEGS, header, one_interval, plain, unheld_moorings
from missionplan.phases.transit.execution import Execution
from missionplan.results.plan import Plan, PlannedTransit
from missionplan.results.plan_states import GuardKind

TITLE = "files for Slocum gliders"
NEEDS_ORIGIN = True
CONFORMANCE: Mapping[GuardKind, str] = {
    "reckoned-within": "weaker: within 10 m of the point, the least that masterdata allows",
    "way-made": "weaker: as time at the planned speed, from the end of the last surfacing",
    "at-surface": "kept",
    "fix-received": "kept, for gps_wait_time at most",
    "fix-within": "refused: the list ends where the dead reckoning is there",
    "fix-beyond": "refused: no further legs",
    "since-fix": "refused: the crew releases the anchor",
    "at-depth": "refused, with the mooring",
    "in-state": "refused, but for gps_wait_time",
    "in-phase": "refused: the mission file's abend has a time-out of its own",
    "energy-used": "refused: the mission file's abend has limits of its own",
}

MASTERDATA = "masterdata of release 7 and later"
"""Whose annotations the limits are."""
_NO = math.inf
LIMITS: Mapping[str, tuple[float, float]] = {
    "num_legs_to_run(nodim)": (-2, _NO),
    "num_waypoints(nodim)": (1, 8),
    "initial_wpt(enum)": (-2, 7),
    "list_when_wpt_dist(m)": (10, _NO),
    "gps_wait_time(s)": (120, _NO),
    "num_half_cycles_to_do(nodim)": (-1, _NO),
    "d_target_depth(m)": (3, 1000),
    "c_target_depth(m)": (3, 1000),
    "d_bpump_value(X)": (-1000, 1000),
    "c_bpump_value(X)": (-1000, 1000),
    "d_thruster_value(X)": (1, 9),
    "c_thruster_value(X)": (1, 9),
}
"""Least and greatest value of the arguments that have limits."""

FIRST = 10
"""Number of the first transit's files."""
AT_WAYPOINT = 30
"""Number of the first transit's surfacing on arrival."""
FASTEST, GLIDING = 1.0, 0.5
"""Greatest speeds through the water with the thruster, and by buoyancy (Teledyne's data sheet of the G3) [m/s]."""
BAND = 1.0
"""Half the height of the powered yo about the run depth [m]."""
WATTS = 9
"""Of the thruster: the most that masterdata allows [W]."""
_MOST = AT_WAYPOINT - FIRST
_CLIMB = (
    "c_use_bpump(enum) 2",
    "c_bpump_value(X) 1000",
    "c_use_pitch(enum) 3",
    "c_pitch_value(X) 0.4538 # rad, 26 deg",
)
_CLIMB_ANGLE, _SHALLOW = 0.4538, 0.209
"""Pitch of a climb to the surface and of a glide, 26°, and of a powered run, 12° [rad]."""
_SAW_TOOTH = (
    f"it glides up and down between {LIMITS['c_target_depth(m)'][0]:g} m and that depth, in all currents between"
)
_BAW_PITCH_IDLE, _BAW_WHEN_SECS, _BAW_WHEN_WPT_DIST, _BAW_WHEN_HIT_WAYPOINT = 2, 6, 7, 8


def executes(transit: PlannedTransit) -> Execution:
    """Return how a glider carries out a transit: to where its dead reckoning is near the point, and no farther.

    It aims off by the drift of its last segment (`u_use_current_correction` 1, the default of masterdata), and stays at
    the surface for a fix and then for a key.
    """
    return Execution(
        ends="reckoning",
        aim=np.array([transit.steered_for.east, transit.steered_for.north]),
        interval=transit.surfacing.interval,
        surface_time=transit.surfacing.surface_time + _key_wait(transit),
        capture=LIMITS["list_when_wpt_dist(m)"][0],
        corrects=True,
    )


def refusals(plan: Plan) -> tuple[Problem, ...]:
    """Say what of a plan no glider can do, each with its number."""
    found = [] if len(plan.transits) <= _MOST else [
        f"the mission has {len(plan.transits)} transits; the files of a glider have numbers for {_MOST}"
    ]  # fmt: skip
    top, fastest = LIMITS["c_target_depth(m)"][0], FASTEST if plan.has_thruster else GLIDING
    least = top + BAND * (1.0 if plan.has_thruster else 2.0)
    means = "with its thruster" if plan.has_thruster else "without a thruster, and the vehicle has none (propulsion)"
    for transit in plan.transits:
        cannot = f"{transit.name}: a Slocum glider cannot"
        if transit.depth < least:
            found.append(
                f"{cannot} run at {transit.depth:g} m: masterdata lets its yo climb to {top:g} m at least, and the run "
                f"depth has to be {least - top:g} m below that"
            )
        most = LIMITS["num_waypoints(nodim)"][1]
        if len(transit.parts) > most:
            found.append(f"{cannot} go by {len(transit.parts)} points: masterdata lets a list hold {most:g}")
        if transit.speed > fastest:
            found.append(f"{cannot} make {transit.speed:g} m/s {means}: at most {fastest:g} m/s")
    return tuple(Problem(words, key="to") for words in found)


def lost(plan: Plan) -> tuple[str, ...]:
    """Say what the files cannot hold."""
    slow = ", ".join(f"{transit.name} {transit.speed:g} m/s" for transit in plan.transits)
    near = LIMITS["list_when_wpt_dist(m)"][0]
    return (
        f"the speed through the water, which {f'the thruster at {WATTS} W' if plan.has_thruster else 'its buoyancy'} "
        f"and the pitch set ({slow})",
        "a level run: " + (f"a powered yo of {BAND:g} m about its depth" if plan.has_thruster else _SAW_TOOTH),
        f"arrival by the fix: the list ends where the dead reckoning is within {near:g} m of the point",
        NO_REMAINING_LEGS,
        "time-outs and the order of the transits, which the mission file (.mi) that names these files has",
        "legs by distance: the glider surfaces after the time that such a leg takes at that speed in still water",
        *one_interval(plan),
        *unheld_moorings(plan),
    )


def files(plan: Plan, stem: str) -> dict[str, str | bytes]:
    """Write for each transit a list with its goal, two surfacing behaviours, and a yo about its depth."""
    del stem  # the glider knows its files by number
    refused = refusals(plan)
    if refused:
        raise InputError(refused)
    written: dict[str, str | bytes] = {}
    for number, transit in enumerate(plan.transits):
        name = FIRST + number
        written[f"goto_l{name}.ma"] = _behaviour(plan, "goto_list", f"goto_l{name}.ma", *_goto(transit))
        written[f"surfac{name}.ma"] = _behaviour(plan, "surface", f"surfac{name}.ma", _every(transit))
        arrival = AT_WAYPOINT + number
        written[f"surfac{arrival}.ma"] = _behaviour(plan, "surface", f"surfac{arrival}.ma", _on_arrival(transit))
        written[f"yo{name}.ma"] = _behaviour(plan, "yo", f"yo{name}.ma", _yo(plan, transit))
    return written


def degrees_minutes(angle: float) -> str:
    """Write an angle [rad] as degrees and decimal minutes in one number, to 0.0001 minutes (19 cm)."""
    ten_thousandths = round(abs(math.degrees(angle)) * 600_000.0)
    degrees, rest = divmod(ten_thousandths, 600_000)
    sign = "-" if angle < 0.0 and ten_thousandths else ""
    return f"{sign}{degrees:d}{rest / 10_000.0:07.4f}"


def _goto(transit: PlannedTransit) -> tuple[list[str], list[str]]:
    """Arguments and waypoints of the list: the goal, which the glider steers for after each surfacing, and via what."""
    points = [part.steered_for for part in transit.parts]
    arguments = [
        "num_legs_to_run(nodim) -2 # traverse the list once",
        "start_when(enum) 0 # BAW_IMMEDIATELY",
        f"list_stop_when(enum) {_BAW_WHEN_WPT_DIST} # BAW_WHEN_WPT_DIST",
        f"list_when_wpt_dist(m) {LIMITS['list_when_wpt_dist(m)'][0]:.1f}",
        "initial_wpt(enum) 0 # the first",
        f"num_waypoints(nodim) {len(points)}",
    ]
    return arguments, [f"{degrees_minutes(point.longitude)} {degrees_minutes(point.latitude)}" for point in points]


def _every(transit: PlannedTransit) -> list[str]:
    """Surface after the time of a leg, less that of the climb at the surface's pitch."""
    rule = transit.surfacing
    climb = min(transit.depth / math.tan(_CLIMB_ANGLE), 0.5 * rule.interval) / transit.speed
    return [
        f"start_when(enum) {_BAW_WHEN_SECS} # BAW_WHEN_SECS, from the end of the last surfacing",
        f"when_secs(sec) {math.floor(rule.interval_time - climb)} # {rule.interval:.1f} m at {transit.speed:g} m/s, "
        "less the climb",
        *_at_surface(transit),
    ]


def _on_arrival(transit: PlannedTransit) -> list[str]:
    return [f"start_when(enum) {_BAW_WHEN_HIT_WAYPOINT} # BAW_WHEN_HIT_WAYPOINT", *_at_surface(transit)]


def _at_surface(transit: PlannedTransit) -> list[str]:
    least, _ = LIMITS["gps_wait_time(s)"]
    return [
        "end_action(enum) 1 # wait for ^C, then resume",
        f"gps_wait_time(s) {max(math.ceil(transit.surfacing.surface_time_p99), int(least))}",
        f"keystroke_wait_time(s) {_key_wait(transit)}",
        *_CLIMB,
    ]


def _key_wait(transit: PlannedTransit) -> int:
    """For a key, once there is a fix, or none: as long as a fix takes [s]."""
    return math.ceil(transit.surfacing.surface_time)


def _yo(plan: Plan, transit: PlannedTransit) -> list[str]:
    """A powered yo about the run depth at a shallow pitch; without a thruster a glide between the surface and it."""
    powered = plan.has_thruster
    deep = transit.depth + (BAND if powered else 0.0)
    high = transit.depth - BAND if powered else LIMITS["c_target_depth(m)"][0]
    arguments = [
        f"start_when(enum) {_BAW_PITCH_IDLE} # BAW_PITCH_IDLE",
        "num_half_cycles_to_do(nodim) -1 # until it surfaces",
        f"d_target_depth(m) {deep:.2f}",
        f"c_target_depth(m) {high:.2f}",
    ]
    for way, sign in (("d", -1.0), ("c", 1.0)):
        pitch = sign * (_SHALLOW if powered else _CLIMB_ANGLE)
        arguments += [
            f"{way}_use_bpump(enum) 2",
            f"{way}_bpump_value(X) {0 if powered else round(sign * 1000.0)}",
            f"{way}_use_pitch(enum) 3",
            f"{way}_pitch_value(X) {pitch:.4f} # rad, {round(math.degrees(pitch))} deg",
        ]
        arguments += [f"{way}_use_thruster(enum) 4 # power", f"{way}_thruster_value(X) {WATTS} # W"] if powered else []
    return [*arguments, "end_action(enum) 2 # resume"]


def _behaviour(plan: Plan, behaviour: str, name: str, arguments: list[str], waypoints: list[str] | None = None) -> str:
    lines = [f"behavior_name={behaviour}", f"# {name}"]
    lines += [f"# {plain(line)}" for line in header(plan, TITLE, lost(plan))]
    lines += [f"# Limits (#!) are those of {MASTERDATA}"]
    lines += ["<start:b_arg>", *(f"    b_arg: {plain(_annotated(argument))}" for argument in arguments), "<end:b_arg>"]
    if waypoints is not None:
        lines += ["<start:waypoints>", "# longitude latitude, DDDMM.mmmm", *waypoints, "<end:waypoints>"]
    return "\n".join(lines) + "\n"


def _annotated(argument: str) -> str:
    """Add the limits of an argument, as masterdata has them."""
    written, _, comment = argument.partition(" # ")
    low, high = LIMITS.get(written.split(" ")[0], (-_NO, _NO))
    limits = [f"min = {low:.1f}"] if low > -_NO else []
    limits += [f"max = {high:.1f}"] if high < _NO else []
    said = f" #! {'; '.join(limits)}" if limits else ""
    return written + said + (f" # {comment}" if comment else "")
