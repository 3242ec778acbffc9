"""Teledyne Slocum gliders: `goto_l*.ma`, `surfac*.ma` and `yo*.ma`, the files that a glider's mission names by number.

Latitudes and longitudes are degrees and decimal minutes in one number, DDMM.mmmm and DDDMM.mmmm, longitude first and
west negative; angles are radians. Each transit has a number of its own: 10 for the first, 11 for the second.
"""

import math

import numpy as np

from missionplan.errors import InputError, Problem
from missionplan.exporters.header import (
    NO_CORRECTION,
    NO_REMAINING_LEGS,
    header,
    one_interval,
    plain,
    unheld_moorings,
)
from missionplan.phases.transit.execution import Execution
from missionplan.results.plan import Plan, PlannedTransit

TITLE = "files for Slocum gliders"
NEEDS_ORIGIN = True

FIRST = 10
"""Number of the first transit's files."""
AT_WAYPOINT = 30
"""Number of the first transit's surfacing on arrival."""
_MOST = AT_WAYPOINT - FIRST
_CLIMB = (
    "c_use_bpump(enum) 2",
    "c_bpump_value(X) 1000",
    "c_use_pitch(enum) 3",
    "c_pitch_value(X) 0.4538 # rad, 26 deg",
)
_BAW_PITCH_IDLE, _BAW_WHEN_WPT_DIST, _BAW_WHEN_HIT_WAYPOINT, _BAW_EVERY_SECS = 2, 7, 8, 9


def executes(transit: PlannedTransit) -> Execution:
    """Return how a glider carries out a transit: to where its dead reckoning comes within the radius, and no farther.

    It aims off by the drift of its last segment (`u_use_current_correction` 1, the default of masterdata).
    """
    return Execution(
        ends="reckoning",
        aim=np.array([transit.goal.east, transit.goal.north]),
        interval=transit.surfacing.interval,
        capture=transit.arrival_radius,
        corrects=True,
    )


def lost(plan: Plan) -> tuple[str, ...]:
    """Say what the files cannot hold."""
    slow = ", ".join(f"{transit.name} {transit.speed:g} m/s" for transit in plan.transits)
    return (
        f"the speed through the water, which a glider's buoyancy and pitch or its thruster set ({slow})",
        "time-outs and the order of the transits, which the mission file (.mi) that names these files has",
        "legs by distance: the glider surfaces after the time that such a leg takes at that speed in still water",
        *one_interval(plan),
        NO_CORRECTION,
        NO_REMAINING_LEGS,
        *unheld_moorings(plan),
    )


def files(plan: Plan, stem: str) -> dict[str, str | bytes]:
    """Write for each transit a list with its goal, two surfacing behaviours, and a yo at its depth if it has one."""
    del stem  # the glider knows its files by number
    if len(plan.transits) > _MOST:
        words = f"the mission has {len(plan.transits)} transits; the files of a glider have numbers for {_MOST}"
        raise InputError([Problem(words, key="to")])
    written: dict[str, str | bytes] = {}
    for number, transit in enumerate(plan.transits):
        name = one = FIRST + number
        written[f"goto_l{name}.ma"] = _behaviour(plan, "goto_list", f"goto_l{one}.ma", *_goto(transit))
        written[f"surfac{name}.ma"] = _behaviour(plan, "surface", f"surfac{one}.ma", _every(transit))
        arrival = AT_WAYPOINT + number
        written[f"surfac{arrival}.ma"] = _behaviour(plan, "surface", f"surfac{arrival}.ma", _on_arrival(transit))
        if transit.depth > 0.0:
            written[f"yo{name}.ma"] = _behaviour(plan, "yo", f"yo{one}.ma", _yo(transit))
    return written


def degrees_minutes(angle: float) -> str:
    """Write an angle [rad] as degrees and decimal minutes in one number, to 0.0001 minutes (19 cm)."""
    ten_thousandths = round(abs(math.degrees(angle)) * 600_000.0)
    degrees, rest = divmod(ten_thousandths, 600_000)
    sign = "-" if angle < 0.0 and ten_thousandths else ""
    return f"{sign}{degrees:d}{rest / 10_000.0:07.4f}"


def _goto(transit: PlannedTransit) -> tuple[list[str], list[str]]:
    """Arguments and waypoints of the list: the goal alone, which the glider steers for after each surfacing."""
    goal = transit.goal
    arguments = [
        "num_legs_to_run(nodim) -2 # traverse the list once",
        "start_when(enum) 0 # BAW_IMMEDIATELY",
        f"list_stop_when(enum) {_BAW_WHEN_WPT_DIST} # BAW_WHEN_WPT_DIST",
        f"list_when_wpt_dist(m) {transit.arrival_radius:.1f}",
        "initial_wpt(enum) 0 # the first",
        "num_waypoints(nodim) 1",
    ]
    return arguments, [f"{degrees_minutes(goal.longitude)} {degrees_minutes(goal.latitude)}"]


def _every(transit: PlannedTransit) -> list[str]:
    rule = transit.surfacing
    return [
        f"start_when(enum) {_BAW_EVERY_SECS} # BAW_EVERY_SECS",
        f"when_secs(sec) {rule.interval_time:.0f} # {rule.interval:.1f} m at {transit.speed:g} m/s",
        *_at_surface(transit),
    ]


def _on_arrival(transit: PlannedTransit) -> list[str]:
    return [f"start_when(enum) {_BAW_WHEN_HIT_WAYPOINT} # BAW_WHEN_HIT_WAYPOINT", *_at_surface(transit)]


def _at_surface(transit: PlannedTransit) -> list[str]:
    rule = transit.surfacing
    return [
        "end_action(enum) 1 # wait for ^C, then resume",
        f"gps_wait_time(s) {math.ceil(rule.surface_time_p99)}",
        f"keystroke_wait_time(s) {math.ceil(rule.surface_time)}",
        *_CLIMB,
    ]


def _yo(transit: PlannedTransit) -> list[str]:
    """A level run is a yo whose dive and climb end at the same depth."""
    depth = f"{transit.depth:.2f}"
    return [
        f"start_when(enum) {_BAW_PITCH_IDLE} # BAW_PITCH_IDLE",
        "num_half_cycles_to_do(nodim) -1 # until it surfaces",
        f"d_target_depth(m) {depth}",
        f"c_target_depth(m) {depth}",
        "end_action(enum) 2 # resume",
    ]


def _behaviour(plan: Plan, behaviour: str, name: str, arguments: list[str], waypoints: list[str] | None = None) -> str:
    lines = [f"behavior_name={behaviour}", f"# {name}"]
    lines += [f"# {plain(line)}" for line in header(plan, TITLE, lost(plan))]
    lines += ["<start:b_arg>", *(f"    b_arg: {plain(argument)}" for argument in arguments), "<end:b_arg>"]
    if waypoints is not None:
        lines += ["<start:waypoints>", "# longitude latitude, DDDMM.mmmm", *waypoints, "<end:waypoints>"]
    return "\n".join(lines) + "\n"
