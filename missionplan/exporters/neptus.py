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
from itertools import pairwise
from xml.etree import ElementTree

import numpy as np

from missionplan.exporters import (
    FIXED_POINTS,
    Content,
    document,
    filled,
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
    lines = header(plan, TITLE, lost(plan))
    content: Content = {
        "header": {
            "id": token(1, stem),
            "name": plan.mission or stem,
            "type": "Test",
            "description": lines[1],
            "notes": {"note": lines},
        },
        "definitions": {
            "vehicles": {"vehicle": {"id": VEHICLE, "name": VEHICLE}},
            "maps": {},
            "checklists": {},
            "home-reference": {
                "id": "home",
                "name": "home",
                "origin": {**_place(*(plan.origin or ())), "depth": "0.0"},
            },
        },
        "body": {"plan": [_plan(number, transit) for number, transit in enumerate(plan.transits, start=1)]},
    }
    return document(filled(ElementTree.Element("mission-def"), content))


def _plan(number: int, transit: PlannedTransit) -> Content:
    nodes: list[Content] = []
    names: list[str] = []
    radius, surfaced = f"{transit.arrival_radius:g}", math.ceil(transit.surfacing.surface_time_p99)
    speed: Content = {"@type": "float", "@unit": "MPS", "": f"{transit.speed:.4g}"}
    for place, leg in enumerate(transit.sequence, start=1):
        coordinate: Content = {**_place(leg.latitude, leg.longitude), "height": "0.0"}
        depth: Content = {"z": f"{transit.depth:g}", "zunits": "DEPTH"}
        point: Content = {"id": leg.name, "name": leg.name, "coordinate": coordinate, **depth}
        way: Content = {
            "@kind": "automatic",
            "finalPoint": {"@type": "pointType", "point": point, "radiusTolerance": radius},
        }
        goto: Content = {**way, "speed": speed, "trajectoryTolerance": {"radiusTolerance": radius}}
        # up where the vehicle is (CurrPos), and adrift until a fix comes: with WaitAtSurface none would end it
        flags: Content = {"@CurrPos": "true", "@WaitAtSurface": "false"}
        pop_up: Content = {**way, "duration": str(surfaced), "speed": speed, "flags": flags}
        names += [f"Goto{place}", f"PopUp{place}"]
        nodes += [
            _node(names[-2], leg.time_out, {"Goto": goto}, first=place == 1),
            _node(names[-1], 2 * surfaced + 60, {"PopUp": pop_up}, first=False),  # the ascent is in it
        ]
    edges: list[Content] = [
        {"id": f"{one}-{other}", "source": one, "target": other, "guard": "ManeuverIsDone"}
        for one, other in pairwise(names)
    ]
    return {"@id": token(number, transit.name), "@vehicle": VEHICLE, "graph": {"node": nodes, "edge": edges}}


def _node(name: str, longest: float, manoeuvre: Content, *, first: bool) -> Content:
    times: Content = {"minTime": "0", "maxTime": f"{longest:.0f}"}
    start = "true" if first else "false"
    return {"@start": start, "@xPos": "0", "@yPos": "0", "id": name, "maneuver": {**times, **manoeuvre}}


def _place(latitude: float, longitude: float) -> dict[str, str]:
    return {"latitude": f"{math.degrees(latitude):.8f}", "longitude": f"{math.degrees(longitude):.8f}"}
