"""Teledyne Slocum gliders: missions (`plan*.mi`), and the files that these name by number (`goto_l*.ma` and others).

Latitudes and longitudes are degrees and decimal minutes in one number, DDMM.mmmm and DDDMM.mmmm, longitude first and
west negative; angles are radians. A mission ends with its list of points, of which masterdata allows eight: a transit
by more has several missions, which the glider runs one after the other (`sequence`). Files of mission 10 have numbers
10, 30 and 50, of mission 11 numbers 11, 31 and 51.

Behaviours, arguments, their limits (`LIMITS`) and the meaning of `start_when` are those of Teledyne's masterdata, which
annotates them with ``#!``; the files repeat the annotation. The missions are built as Teledyne's `thrstock.mi` is. A
glider flies no level run but with its thruster, between two depths about the run depth; what it cannot do is refused.
"""

import math
from collections.abc import Mapping

import numpy as np

from missionplan.errors import InputError, Problem
from missionplan.exporters import header, no_battery, one_interval, plain, unheld_moorings, zones_lost
from missionplan.phases.transit.plan import Execution
from missionplan.results.plan import Plan, PlannedTransit
from missionplan.results.plan_states import GuardKind

TITLE = "files for Slocum gliders"
NEEDS_ORIGIN = True
CONFORMANCE: Mapping[GuardKind, str] = {
    "reckoned-within": "weaker: within 10 m of the point, the least that masterdata allows",
    "way-made": "weaker: as time at the planned speed, from the end of the last surfacing",
    "at-surface": "kept",
    "fix-received": "weaker: after gps_wait_time it goes on by dead reckoning; ten times without one, it aborts",
    "fix-within": "refused: the list ends where the dead reckoning is there",
    "fix-beyond": "refused: no further legs",
    "since-fix": "refused: the crew releases the anchor",
    "at-depth": "refused, with the mooring",
    "in-state": "refused, but for gps_wait_time",
    "in-phase": "kept, by overtime of abend",
    "energy-used": "kept, and earlier: with 10 % left, by remaining_charge_min of abend",
}

MASTERDATA = "masterdata of release 10.5"
"""Whose annotations the limits are."""
_NO = math.inf
LIMITS: Mapping[str, tuple[float, float]] = {
    "num_legs_to_run(nodim)": (-2, _NO),
    "num_waypoints(nodim)": (1, 8),
    "initial_wpt(enum)": (-2, 7),
    "list_when_wpt_dist(m)": (10, _NO),
    "when_secs(sec)": (120, _NO),
    "gps_wait_time(sec)": (120, _NO),
    "keystroke_wait_time(sec)": (0, 900),
    "num_half_cycles_to_do(nodim)": (-1, _NO),
    "d_target_depth(m)": (3, 1000),
    "c_target_depth(m)": (3, 1000),
    "d_bpump_value(X)": (-1000, 1000),
    "c_bpump_value(X)": (-1000, 1000),
    "d_thruster_value(X)": (1, 9),
    "c_thruster_value(X)": (1, 9),
}
"""Least and greatest value of the arguments that have limits."""

FIRST, ARRIVAL, ON_THE_WAY = 10, 30, 50
"""Numbers of the first mission's files, of its surfacing on arrival, and of that at each point before."""
RESERVE = 10
"""Charge with which left a mission is given up, masterdata's default [%]."""
FASTEST, GLIDING = 1.0, 0.5
"""Greatest speeds through the water with the thruster, and by buoyancy (Teledyne's data sheet of the G3) [m/s]."""
BAND = 1.0
"""Half the height of the powered yo about the run depth [m]."""
WATTS = 9
"""Of the thruster: the most that masterdata allows [W]."""
_MOST = ARRIVAL - FIRST
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
_BAW_PITCH_IDLE, _BAW_HEADING_IDLE, _BAW_WHEN_SECS, _BAW_WHEN_WPT_DIST, _BAW_WHEN_HIT_WAYPOINT = 2, 3, 6, 7, 8
_QUIT, _RESUME_AFTER_KEY, _RESUME = 0, 1, 2
_List = tuple[PlannedTransit, ...]
"""Straight parts of a transit whose ends are the points of one list."""


def executes(transit: PlannedTransit) -> Execution:
    """Return how a glider carries out a transit: to where its dead reckoning is near the point, and no farther.

    It aims off by the drift of its last segment (`u_use_current_correction` 1, the default of masterdata), and stays at
    the surface for a fix and then for a key.
    """
    return Execution(
        ends="reckoning",
        aim=np.array([transit.steered_for.east, transit.steered_for.north]),
        interval=transit.surfacing.interval,
        fix_wait=_fix_wait(transit),
        key_wait=_key_wait(transit),
        time_out=transit.abort_time,
        reserve=RESERVE / 100.0,
        capture=LIMITS["list_when_wpt_dist(m)"][0],
        corrects=True,
    )


def refusals(plan: Plan) -> tuple[Problem, ...]:
    """Say what of a plan no glider can do, each with its number."""
    lists = len(_lists(plan))
    reasons = (
        []
        if lists <= _MOST
        else [f"the mission has {lists} lists of points; the files of a glider have numbers for {_MOST}"]
    )
    top, fastest = LIMITS["c_target_depth(m)"][0], FASTEST if plan.has_thruster else GLIDING
    least = top + BAND * (1.0 if plan.has_thruster else 2.0)
    shortest, _ = LIMITS["when_secs(sec)"]
    means = "with its thruster" if plan.has_thruster else "without a thruster, and the vehicle has none (propulsion)"
    for transit in plan.transits:
        cannot = f"{transit.name}: a Slocum glider cannot"
        if transit.depth < least:
            reasons.append(
                f"{cannot} run at {transit.depth:g} m: masterdata lets its yo climb to {top:g} m at least, and the run "
                f"depth has to be {least - top:g} m below that"
            )
        if transit.speed > fastest:
            reasons.append(f"{cannot} make {transit.speed:g} m/s {means}: at most {fastest:g} m/s")
        elif _interval(transit) < shortest:
            reasons.append(
                f"{cannot} surface {_interval(transit)} s after it dived, for legs of {transit.surfacing.interval:g} m "
                f"(d_max) at {transit.speed:g} m/s less the climb: masterdata lets it do so after {shortest:g} s"
            )
    return tuple(Problem(words, key="to") for words in reasons)


def lost(plan: Plan) -> tuple[str, ...]:
    """Say what the files cannot hold."""
    slow = ", ".join(f"{transit.name} {transit.speed:g} m/s" for transit in plan.transits)
    near = LIMITS["list_when_wpt_dist(m)"][0]
    return (
        f"the speed through the water, which {f'the thruster at {WATTS} W' if plan.has_thruster else 'its buoyancy'} "
        f"and the pitch set ({slow})",
        "a level run: " + (f"a powered yo of {BAND:g} m about its depth" if plan.has_thruster else _SAW_TOOTH),
        f"arrival by the fix: the list ends where the dead reckoning is within {near:g} m of the point",
        "further legs where the last one ends outside the arrival radius",
        "a fix that does not come in gps_wait_time: it goes on by dead reckoning",
        *no_battery(
            plan,
            f"it gives up with {RESERVE} % left (remaining_charge_min), if m_coulomb_amphr_total begins at 0 and "
            "f_coulomb_battery_capacity is that of this battery",
        ),
        "all other limits of abend (overdepth, samedepth_for, undervolts, …), which are masterdata's defaults",
        "legs by distance: the glider surfaces after the time that such a leg takes at that speed in still water",
        *one_interval(plan),
        *zones_lost(plan),
        *unheld_moorings(plan),
    )


def files(plan: Plan, stem: str) -> dict[str, str | bytes]:
    """Write for each list of points a mission, the list, its surfacings, and a yo about the run depth."""
    del stem  # the glider knows its files by number
    refused = refusals(plan)
    if refused:
        raise InputError(refused)
    written: dict[str, str | bytes] = {}
    for number, points in enumerate(_lists(plan)):
        first, arrival, way = FIRST + number, ARRIVAL + number, ON_THE_WAY + number
        transit, several = points[0], len(points) > 1
        surfacings = {arrival: _surface(transit, f"{_BAW_HEADING_IDLE} # BAW_HEADING_IDLE", _QUIT)}
        if several:
            hit = f"{_BAW_WHEN_HIT_WAYPOINT} # BAW_WHEN_HIT_WAYPOINT"
            surfacings[way] = _surface(transit, hit, _RESUME_AFTER_KEY)
        after = f"{_BAW_WHEN_SECS} # BAW_WHEN_SECS, from the end of the last surfacing"
        length = f"{transit.surfacing.interval:.1f} m at {transit.speed:g} m/s, less the climb"
        every = f"when_secs(sec) {_interval(transit)} # {length}"
        surfacings[first] = [*_surface(transit, after, _RESUME_AFTER_KEY), every]
        written[f"plan{first}.mi"] = _mission(plan, transit, first, list(surfacings))
        written[f"goto_l{first}.ma"] = _behaviour(plan, "goto_list", f"goto_l{first}.ma", *_goto(points))
        for at, arguments in surfacings.items():
            written[f"surfac{at}.ma"] = _behaviour(plan, "surface", f"surfac{at}.ma", arguments)
        written[f"yo{first}.ma"] = _behaviour(plan, "yo", f"yo{first}.ma", _yo(plan, transit))
    return written


def _lists(plan: Plan) -> list[_List]:
    """Split the parts of the transits into lists of as many points as masterdata allows."""
    most = int(LIMITS["num_waypoints(nodim)"][1])
    return [
        transit.parts[begin : begin + most] for transit in plan.transits for begin in range(0, len(transit.parts), most)
    ]


def degrees_minutes(angle: float) -> str:
    """Write an angle [rad] as degrees and decimal minutes in one number, to 0.0001 minutes (19 cm)."""
    ten_thousandths = round(abs(math.degrees(angle)) * 600_000.0)
    degrees, rest = divmod(ten_thousandths, 600_000)
    sign = "-" if angle < 0.0 and ten_thousandths else ""
    return f"{sign}{degrees:d}{rest / 10_000.0:07.4f}"


def _mission(plan: Plan, transit: PlannedTransit, number: int, surfacings: list[int]) -> str:
    """Write a mission: behaviours in the order of their priority."""
    stack = [
        ("abend", f"overtime(sec) {transit.abort_time:.0f}", f"remaining_charge_min(%) {RESERVE:.1f}"),
        *(("surface", f"args_from_file(enum) {surfacing}") for surfacing in surfacings),
        ("goto_list", f"args_from_file(enum) {number}", "start_when(enum) 0 # BAW_IMMEDIATELY"),
        ("yo", f"args_from_file(enum) {number}", f"start_when(enum) {_BAW_PITCH_IDLE} # BAW_PITCH_IDLE"),
        (
            "prepare_to_dive",
            "start_when(enum) 0",
            f"wait_time(sec) {math.ceil(transit.surfacing.fix_wait)} # for a fix",
        ),
        ("sensors_in",),
    ]
    lines = [f"# plan{number}.mi: {plain(transit.name)}", *_about(plan)]
    lines += ["sensor: u_use_current_correction(nodim) 1 # steer by the drift of the last segment"]
    for behaviour, *arguments in stack:
        lines += ["", f"behavior: {behaviour}", *(f"    b_arg: {_annotated(argument)}" for argument in arguments)]
    return "\n".join(lines) + "\n"


def _goto(points: _List) -> tuple[list[str], list[str]]:
    """Arguments and waypoints of a list: where the glider steers for after each surfacing, in turn."""
    ends = [part.steered_for for part in points]
    arguments = [
        "num_legs_to_run(nodim) -2 # traverse the list once",
        "start_when(enum) 0 # BAW_IMMEDIATELY",
        f"list_stop_when(enum) {_BAW_WHEN_WPT_DIST} # BAW_WHEN_WPT_DIST",
        f"list_when_wpt_dist(m) {LIMITS['list_when_wpt_dist(m)'][0]:.1f}",
        "initial_wpt(enum) 0 # the first",
        f"num_waypoints(nodim) {len(ends)}",
    ]
    return arguments, [f"{degrees_minutes(point.longitude)} {degrees_minutes(point.latitude)}" for point in ends]


def _interval(transit: PlannedTransit) -> int:
    """Time under way after which it goes up: that of a leg, less that of the climb at the surface's pitch [s]."""
    rule = transit.surfacing
    climb = min(transit.depth / math.tan(_CLIMB_ANGLE), 0.5 * rule.interval) / transit.speed
    return math.floor(rule.interval_time - climb)


def _surface(transit: PlannedTransit, when: str, then: int) -> list[str]:
    words = {_QUIT: "quit: the list is done", _RESUME_AFTER_KEY: "wait for ^C, then resume"}
    return [
        f"start_when(enum) {when}",
        f"end_action(enum) {then} # {words[then]}",
        f"gps_wait_time(sec) {_fix_wait(transit)}",
        f"keystroke_wait_time(sec) {_key_wait(transit)}",
        *_CLIMB,
    ]


def _fix_wait(transit: PlannedTransit) -> int:
    """For a fix: as long as 99 % take, and as masterdata allows [s]."""
    return max(math.ceil(transit.surfacing.surface_time_p99), int(LIMITS["gps_wait_time(sec)"][0]))


def _key_wait(transit: PlannedTransit) -> int:
    """For a key, once there is a fix, or none: as long as a fix takes, and as masterdata allows [s]."""
    return min(math.ceil(transit.surfacing.surface_time), int(LIMITS["keystroke_wait_time(sec)"][1]))


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
    return [*arguments, f"end_action(enum) {_RESUME} # resume"]


def _behaviour(plan: Plan, behaviour: str, name: str, arguments: list[str], waypoints: list[str] | None = None) -> str:
    lines = [f"behavior_name={behaviour}", f"# {name}", *_about(plan)]
    lines += ["<start:b_arg>", *(f"    b_arg: {plain(_annotated(argument))}" for argument in arguments), "<end:b_arg>"]
    if waypoints is not None:
        lines += ["<start:waypoints>", "# longitude latitude, DDDMM.mmmm", *waypoints, "<end:waypoints>"]
    return "\n".join(lines) + "\n"


def _about(plan: Plan) -> list[str]:
    comments = [f"# {plain(line)}" for line in header(plan, TITLE, lost(plan))]
    return [*comments, f"# Limits (#!) are those of {MASTERDATA}"]


def _annotated(argument: str) -> str:
    """Add the limits of an argument, as masterdata has them."""
    written, _, comment = argument.partition(" # ")
    low, high = LIMITS.get(written.split(" ")[0], (-_NO, _NO))
    limits = [f"min = {low:.1f}"] if low > -_NO else []
    limits += [f"max = {high:.1f}"] if high < _NO else []
    said = f" #! {'; '.join(limits)}" if limits else ""
    return written + said + (f" # {comment}" if comment else "")
