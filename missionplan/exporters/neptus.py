"""Neptus and DUNE (LSTS): a zipped mission (`.nmisz`) with a plan for each transit.

A plan is a graph of manoeuvres: a Goto to the end of each planned leg, then a PopUp there for the fix. Latitudes and
longitudes are decimal degrees, z is a depth, speeds are metres a second, times whole seconds. The elements are those
that Neptus writes itself (`MissionType`, `GraphType`, `Goto` and `PopUp` of its sources).

What DUNE does with them (its `Maneuver/Multiplexer` and `Plan/Engine`): a Goto ends when the path controller is near
the point; no radius and no time-out of a manoeuvre is looked at. A PopUp with CurrPos goes up where the vehicle is;
with WaitAtSurface it keeps station with power for `duration` and heeds no fix; without, it drifts until a fix of enough
satellites agrees with the navigation, then goes down. A transition has one condition, that the manoeuvre is done.
"""

import io
import math
import zipfile
from collections.abc import Mapping
from xml.etree import ElementTree

import numpy as np

from missionplan.exporters import (
    FIXED_POINTS,
    Element,
    add,
    document,
    header,
    no_battery,
    no_correction,
    no_decision,
    token,
    unheld_moorings,
    zones_lost,
)
from missionplan.phases.transit.plan import Execution
from missionplan.results.plan import Plan, PlannedTransit
from missionplan.results.plan_places import Waypoint
from missionplan.results.plan_states import GuardKind

TITLE = "mission for Neptus"
NEEDS_ORIGIN = True
CONFORMANCE: Mapping[GuardKind, str] = {
    "reckoned-within": "kept: near the point by the path controller",
    "way-made": "weaker: legs go through fixed points and may be longer than d_max by the drift",
    "at-surface": "kept",
    "fix-received": "kept",
    "fix-within": "refused: no guard on a place; the planned legs and some more, then the end",
    "fix-beyond": "weaker: a fixed number of further legs",
    "since-fix": "refused: the crew releases the anchor between the plans",
    "at-depth": "refused, with the mooring",
    "in-state": "refused: DUNE looks at no time-out",
    "in-phase": "refused: DUNE looks at no time-out",
    "energy-used": "refused: a transition has no guard on energy",
}

VEHICLE = "lauv-xplore-1"
"""Neptus ties a plan to a vehicle that it knows; the crew chooses its own after loading."""
_WRITTEN = (1980, 1, 1, 0, 0, 0)
"""Time of the file inside the archive, so that a plan gives the same bytes whenever it is written."""


def executes(transit: PlannedTransit) -> Execution:
    """Return how the vehicle carries out a transit: to each point by dead reckoning, and up until a fix comes."""
    points = np.array([(point.east, point.north) for point in transit.sequence]).T
    return Execution(ends="count", aim=points[:, -1], points=points)


def lost(plan: Plan) -> tuple[str, ...]:
    """Say what the file cannot hold."""
    return (
        f"the vehicle: plans name {VEHICLE} until another is chosen in Neptus",
        FIXED_POINTS,
        *no_correction(plan),
        *no_decision(plan),
        "time-outs, and the greatest wait for a fix: DUNE looks at none of a manoeuvre's",
        *no_battery(plan, "DUNE's configuration may have one (Monitors.FuelLevel)"),
        *zones_lost(plan, "DUNE's operational limits, which the mission does not hold, are one rectangle to stay in"),
        *unheld_moorings(plan),
    )


def files(plan: Plan, stem: str) -> dict[str, str | bytes]:
    """Write one archive that holds `mission.nmis`."""
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(zipfile.ZipInfo("mission.nmis", _WRITTEN), _mission(plan, stem))
    return {f"{stem}.nmisz": content.getvalue()}


def _mission(plan: Plan, stem: str) -> str:
    root = ElementTree.Element("mission-def")
    about, lines = add(root, "header"), header(plan, TITLE, lost(plan))
    add(about, "id", token(1, stem))
    add(about, "name", plan.mission or stem)
    add(about, "type", "Test")
    add(about, "description", lines[1])
    notes = add(about, "notes")
    for line in lines:
        add(notes, "note", line)
    definitions = add(root, "definitions")
    vehicle = add(add(definitions, "vehicles"), "vehicle")
    add(vehicle, "id", VEHICLE)
    add(vehicle, "name", VEHICLE)
    add(definitions, "maps")
    add(definitions, "checklists")
    home = add(definitions, "home-reference")
    add(home, "id", "home")
    add(home, "name", "home")
    origin = add(home, "origin")
    _place(origin, *(plan.origin or ()))
    add(origin, "depth", "0.0")
    body = add(root, "body")
    for number, transit in enumerate(plan.transits, start=1):
        _plan(body, number, transit)
    return document(root)


def _plan(body: Element, number: int, transit: PlannedTransit) -> None:
    graph = add(add(body, "plan", id=token(number, transit.name), vehicle=VEHICLE), "graph")
    names: list[str] = []
    for leg_number, leg in enumerate(transit.sequence, start=1):
        names += [f"Goto{leg_number}", f"PopUp{leg_number}"]
        _goto(_node(graph, names[-2], leg.time_out, first=leg_number == 1), transit, leg)
        surfaced = 2 * _surfaced(transit) + 60  # the ascent is in it
        _pop_up(_node(graph, names[-1], surfaced, first=False), transit, leg)
    for index in range(len(names) - 1):
        edge = add(graph, "edge")
        add(edge, "id", f"{names[index]}-{names[index + 1]}")
        add(edge, "source", names[index])
        add(edge, "target", names[index + 1])
        add(edge, "guard", "ManeuverIsDone")


def _node(graph: Element, name: str, longest: float, *, first: bool) -> Element:
    node = add(graph, "node", start="true" if first else "false", xPos="0", yPos="0")
    add(node, "id", name)
    manoeuvre = add(node, "maneuver")
    add(manoeuvre, "minTime", "0")
    add(manoeuvre, "maxTime", f"{longest:.0f}")
    return manoeuvre


def _goto(manoeuvre: Element, transit: PlannedTransit, leg: Waypoint) -> None:
    goto = add(manoeuvre, "Goto", kind="automatic")
    _final_point(goto, transit, leg)
    _speed(goto, transit)
    add(add(goto, "trajectoryTolerance"), "radiusTolerance", f"{transit.arrival_radius:g}")


def _pop_up(manoeuvre: Element, transit: PlannedTransit, leg: Waypoint) -> None:
    """Surface where the vehicle is (CurrPos) and drift until a fix comes: with WaitAtSurface none would end it."""
    pop_up = add(manoeuvre, "PopUp", kind="automatic")
    _final_point(pop_up, transit, leg)
    add(pop_up, "duration", str(_surfaced(transit)))
    _speed(pop_up, transit)
    add(pop_up, "flags", CurrPos="true", WaitAtSurface="false")


def _surfaced(transit: PlannedTransit) -> int:
    """Time at the surface, which no fix ends: that of 99 % of the fixes, whole seconds [s]."""
    return math.ceil(transit.surfacing.surface_time_p99)


def _final_point(manoeuvre: Element, transit: PlannedTransit, leg: Waypoint) -> None:
    final = add(manoeuvre, "finalPoint", type="pointType")
    point = add(final, "point")
    add(point, "id", leg.name)
    add(point, "name", leg.name)
    coordinate = add(point, "coordinate")
    _place(coordinate, leg.latitude, leg.longitude)
    add(coordinate, "height", "0.0")
    add(point, "z", f"{transit.depth:g}")
    add(point, "zunits", "DEPTH")
    add(final, "radiusTolerance", f"{transit.arrival_radius:g}")


def _place(parent: Element, latitude: float, longitude: float) -> None:
    add(parent, "latitude", f"{math.degrees(latitude):.8f}")
    add(parent, "longitude", f"{math.degrees(longitude):.8f}")


def _speed(manoeuvre: Element, transit: PlannedTransit) -> None:
    add(manoeuvre, "speed", f"{transit.speed:.4g}", type="float", unit="MPS")
