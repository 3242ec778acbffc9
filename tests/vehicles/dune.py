"""Neptus and DUNE, as their public sources have them: reads a `.nmisz` and sails its plans.

A Goto goes by dead reckoning until the path controller is near its point. A PopUp goes up where the vehicle is, and
without WaitAtSurface drifts until a fix comes. No radius, no duration and no time-out is looked at then. Plans are
started one after the other by the crew. Imports nothing of the package.
"""

import io
import math
import zipfile
from dataclasses import dataclass, field
from xml.etree import ElementTree

from pyproj import Proj
from sea import Voyage


@dataclass(frozen=True)
class Order:
    """Go to a point of the plane about the home reference [m], then up for a fix."""

    east: float
    north: float
    speed: float
    depth: float


def read(content: bytes) -> tuple[tuple[float, float], list[list[Order]]]:
    """Home reference [deg], and the orders of each plan."""
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        root = ElementTree.fromstring(archive.read("mission.nmis"))
    reference = root.find("definitions/home-reference/origin")
    home = float(reference.find("latitude").text), float(reference.find("longitude").text)
    plane = Proj(proj="aeqd", lat_0=home[0], lon_0=home[1], ellps="WGS84")
    plans = []
    for graph in root.findall("body/plan/graph"):
        nodes = {node.find("id").text: node.find("maneuver") for node in graph.findall("node")}
        after = {edge.find("source").text: edge.find("target").text for edge in graph.findall("edge")}
        (name,) = (node.find("id").text for node in graph.findall("node") if node.get("start") == "true")
        orders = []
        while name is not None:
            goto, flags = nodes[name].find("Goto"), nodes[after[name]].find("PopUp/flags")
            assert (flags.get("CurrPos"), flags.get("WaitAtSurface")) == ("true", "false")
            point = goto.find("finalPoint/point")
            longitude, latitude = (float(point.find(f"coordinate/{axis}").text) for axis in ("longitude", "latitude"))
            orders.append(
                Order(*plane(longitude, latitude), float(goto.find("speed").text), float(point.find("z").text))
            )
            name = after.get(after[name])
        plans.append(orders)
    return home, plans


@dataclass
class Sailed:
    """What happened: the plans' ends, true and by the fix [m], legs of each, and the log as of `helm.Sailed`."""

    ends: list[tuple[tuple[float, float], tuple[float, float]]] = field(default_factory=list)
    legs: list[int] = field(default_factory=list)
    states: list[tuple[float, ...]] = field(default_factory=list)
    fixes: list[tuple[float, float, float]] = field(default_factory=list)


class Dead:
    """A vehicle that goes by dead reckoning, straight, and knows of its drift only by fixes."""

    def __init__(self, voyage: Voyage) -> None:
        self.voyage, self.time, self.fixed = voyage, 0.0, True
        self.true = [0.0, 0.0]
        self.nav = list(voyage.fix(self.true))
        self.done = Sailed(fixes=[(0.0, *self.nav)])

    def run(self, order: Order, length: float | None = None, step: float = 15.0) -> float:
        """Go for a point, or so far towards it; returns the way through the water [m]."""
        error = self.voyage.leg_error()
        ahead = order.east - self.nav[0], order.north - self.nav[1]
        distance = math.hypot(*ahead)
        way = distance if length is None else min(length, distance)
        heading = math.atan2(*ahead)
        through = order.speed * math.sin(heading), order.speed * math.cos(heading)
        made = self.voyage.made(through, error, order.depth)
        left = way / order.speed
        while left > 1e-9:
            span = min(step, left)
            left, self.time = left - span, self.time + span
            for axis in (0, 1):
                self.nav[axis] += through[axis] * span
                self.true[axis] += made[axis] * span
            self.done.states.append((self.time, *self.nav, order.depth, heading, order.speed))
        return way

    def drift(self, seconds: float, fixed: bool = True) -> None:
        """At the surface; a fix at the end, if one has come."""
        self.fixed = fixed
        east, north = self.voyage.current(0.0)
        self.true = [self.true[0] + east * seconds, self.true[1] + north * seconds]
        self.time += seconds
        if fixed:
            self.nav = list(self.voyage.fix(self.true))
            self.done.fixes.append((self.time, *self.nav))
        self.done.states.append((self.time + 0.1, *self.nav, 0.0, 0.0, 0.0))


def sail(plans: list[list[Order]], voyage: Voyage) -> Sailed:
    """Start one plan after the other."""
    boat = Dead(voyage)
    for orders in plans:
        for order in orders:
            boat.run(order)
            boat.drift(voyage.fix_time)
        boat.done.ends.append((tuple(boat.true), tuple(boat.nav)))
        boat.done.legs.append(len(orders))
    return boat.done
