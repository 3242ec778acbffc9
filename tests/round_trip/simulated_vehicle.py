"""A vehicle that takes a plan in its own format, sails it with an error that it does not know, and writes its own log.

It imports nothing of the package: it reads the plan and moves on the ellipsoid by other code.
"""

import io
import re
import zipfile
from dataclasses import dataclass, field
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from pyproj import Geod, Transformer

GEOD = Geod(ellps="WGS84")
EPOCH = 1_780_000_000.0
STEP = 15.0
"""Interval of the log under way [s]."""
FIX_INTERVAL = 10.0


@dataclass(frozen=True)
class Order:
    """Go to a point [deg], at a speed and depth, surfacing after `interval` seconds under way and on arrival."""

    latitude: float
    longitude: float
    speed: float
    depth: float
    interval: float
    surface_time: float
    radius: float


def orders_of_bhv(text: str, utm: int) -> tuple[tuple[float, float], list[Order]]:
    """Read a MOOS-IvP behaviour file; returns the origin [deg] and the orders. `utm` is the EPSG code of the zone."""
    origin = tuple(float(re.search(rf"{key}\s*=\s*(\S+)", text)[1]) for key in ("LatOrigin", "LongOrigin"))
    plane = Transformer.from_crs(4326, utm, always_xy=True)
    east, north = plane.transform(origin[1], origin[0])
    by_phase: dict[str, dict[str, dict[str, str]]] = {}
    for kind, body in re.findall(r"Behavior = (\w+)\s*\{(.*?)\}", text, re.S):
        pairs = [[part.strip() for part in line.split("=", 1)] for line in body.strip().splitlines()]
        phase = next(value for key, value in pairs if key == "condition" and value.startswith("PHASE"))
        by_phase.setdefault(phase, {})[kind] = {key: value for key, value in pairs if key != "condition"}
    orders = []
    for behaviours in by_phase.values():
        if "BHV_Waypoint" not in behaviours:
            continue
        waypoint, surface = behaviours["BHV_Waypoint"], behaviours["BHV_PeriodicSurface"]
        x, y = (float(part) for part in waypoint["points"].split(","))
        longitude, latitude = plane.transform(east + x, north + y, direction="INVERSE")
        orders.append(
            Order(
                latitude,
                longitude,
                float(waypoint["speed"]),
                float(behaviours["BHV_ConstantDepth"]["depth"]),
                float(surface["period"]),
                float(surface["max_time_at_surface"]),
                float(waypoint["capture_radius"]),
            )
        )
    return origin, orders


def orders_of_nmisz(content: bytes) -> tuple[tuple[float, float], list[Order]]:
    """Read a Neptus mission; returns the home reference [deg] and the orders."""
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        root = ElementTree.fromstring(archive.read("mission.nmis"))
    home = root.find("definitions/home-reference/origin")
    orders = []
    for graph in root.findall("body/plan/graph"):
        nodes = {node.find("id").text: node.find("maneuver") for node in graph.findall("node")}
        after = {edge.find("source").text: edge.find("target").text for edge in graph.findall("edge")}
        (name,) = (node.find("id").text for node in graph.findall("node") if node.get("start") == "true")
        while name is not None:
            goto, pop_up = nodes[name].find("Goto"), nodes[after[name]].find("PopUp")
            point = goto.find("finalPoint/point")
            orders.append(
                Order(
                    float(point.find("coordinate/latitude").text),
                    float(point.find("coordinate/longitude").text),
                    float(goto.find("speed").text),
                    float(point.find("z").text),
                    float("inf"),
                    float(pop_up.find("duration").text),
                    float(goto.find("finalPoint/radiusTolerance").text),
                )
            )
            name = after.get(after[name])
    return (float(home.find("latitude").text), float(home.find("longitude").text)), orders


@dataclass
class Log:
    """What the vehicle knew: (t, lat, lon, depth, heading, speed) under way, (t, lat, lon) of fixes [s, deg, m, m/s]."""

    states: list[tuple[float, ...]] = field(default_factory=list)
    fixes: list[tuple[float, float, float]] = field(default_factory=list)


@dataclass
class Vehicle:
    """A vehicle with a compass that is off and a log that is off, of both of which it knows nothing.

    Attributes
    ----------
    compass_bias : float
        Course made less course steered, clockwise [deg].
    speed_error : float
        Speed made over speed commanded, less one.
    sigma, fix_sd : float
        Velocity error of a leg, each axis [m/s]; error of a fix, each axis [m].
    """

    latitude: float
    longitude: float
    rng: np.random.Generator
    compass_bias: float = 0.0
    speed_error: float = 0.0
    sigma: float = 0.015
    fix_sd: float = 3.0
    time: float = EPOCH
    log: Log = field(default_factory=Log)
    reckoned: tuple[float, float] = (0.0, 0.0)

    def sail(self, orders: list[Order]) -> Log:
        """Carry out the orders."""
        self._stay(120.0)
        for order in orders:
            for _ in range(50):
                arrived = self._leg(order)
                self._stay(order.surface_time)
                if arrived:
                    break
            else:
                raise RuntimeError("the vehicle does not get there")
        return self.log

    def _leg(self, order: Order) -> bool:
        """Run under water; whether dead reckoning reached the point."""
        error = self.sigma * self.rng.standard_normal(2)
        left = order.interval
        while left > 1e-6:
            azimuth, _, distance = GEOD.inv(self.reckoned[1], self.reckoned[0], order.longitude, order.latitude)
            if distance < order.radius:
                return True
            step = min(STEP, left, distance / order.speed)
            self.reckoned = _moved(self.reckoned, azimuth, order.speed * step)
            course = np.radians(azimuth + self.compass_bias)
            over_ground = order.speed * (1.0 + self.speed_error) * np.array([np.sin(course), np.cos(course)]) + error
            made = np.degrees(np.arctan2(*over_ground)), float(np.hypot(*over_ground)) * step
            self.latitude, self.longitude = _moved((self.latitude, self.longitude), *made)
            self.time, left = self.time + step, left - step
            self.log.states.append((self.time, *self.reckoned, order.depth, azimuth % 360.0, order.speed))
        return False

    def _stay(self, duration: float) -> None:
        """Take fixes at the surface, and begin dead reckoning anew from the last."""
        for _ in range(max(int(duration / FIX_INTERVAL), 2)):
            self.time += FIX_INTERVAL
            north, east = self.fix_sd * self.rng.standard_normal(2)
            fix = _moved((self.latitude, self.longitude), np.degrees(np.arctan2(east, north)), np.hypot(east, north))
            self.log.fixes.append((self.time, *fix))
            self.reckoned = fix
            self.log.states.append((self.time + 0.1, *fix, 0.0, 0.0, 0.0))


def _moved(place: tuple[float, float], azimuth: float, distance: float) -> tuple[float, float]:
    longitude, latitude, _ = GEOD.fwd(place[1], place[0], azimuth, distance)
    return latitude, longitude


def write_alog(path: Path, log: Log) -> None:
    """Write the log as pLogger does."""
    rows = []
    for t, latitude, longitude in log.fixes:
        rows += [(t, "GPS_LATITUDE", latitude), (t + 0.01, "GPS_LONGITUDE", longitude)]
    for t, latitude, longitude, depth, heading, speed in log.states:
        rows += [(t, "NAV_LAT", latitude), (t, "NAV_LONG", longitude), (t, "NAV_DEPTH", depth)]
        rows += [(t, "NAV_HEADING", heading), (t, "NAV_SPEED", speed)]
    lines = ["%" * 50, "%% LOG FILE:       ./made.alog", f"%% LOGSTART           {EPOCH:.1f}", "%" * 50]
    lines += [f"{t - EPOCH:.3f} {name} pNav {value:.9f}" for t, name, value in sorted(rows)]
    path.write_text("\n".join(lines) + "\n")


def write_lsf(path: Path, log: Log) -> None:
    """Write the log as DUNE does."""
    import imcpy

    messages = []
    for t, latitude, longitude in log.fixes:
        fix = imcpy.GpsFix()
        fix.timestamp, fix.lat, fix.lon = t, np.radians(latitude), np.radians(longitude)
        fix.hacc, fix.satellites, fix.validity = 3.0, 9, 4 | 32
        messages.append(fix)
    for t, latitude, longitude, depth, heading, speed in log.states:
        state = imcpy.EstimatedState()
        state.timestamp, state.lat, state.lon = t, np.radians(latitude), np.radians(longitude)
        state.depth, state.psi, state.u = depth, np.radians(heading), speed
        messages.append(state)
    messages.sort(key=lambda each: each.timestamp)
    path.write_bytes(b"".join(imcpy.Packet.serialize(each) for each in messages))
