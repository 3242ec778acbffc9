"""Iver, MAVLink autopilots and Slocum gliders, as their manuals have them: read a file and sail it by dead reckoning.

Imports nothing of the package. Each returns the ends of its transits, true and by the last fix, and its legs.
"""

import json
import math
import re

from dune import Dead, Order, Sailed
from pyproj import Proj
from sea import Voyage

FOOT, KNOT = 0.3048, 1852.0 / 3600.0


def ended(boat: Dead, legs: int) -> None:
    """Without a fix, whether it has arrived is seen by where it is."""
    boat.done.ends.append((tuple(boat.true), tuple(boat.nav if boat.fixed else boat.true)))
    boat.done.legs.append(legs)


def iver(texts: list[str], home: tuple[float, float], voyage: Voyage) -> Sailed:
    """VectorMap missions: near each point at D feet and S knots, then P minutes parked at the surface, adrift."""
    plane, boat = Proj(proj="aeqd", lat_0=home[0], lon_0=home[1], ellps="WGS84"), Dead(voyage)
    for text in texts:
        lines = text.splitlines()
        near = float(next(line for line in lines if line.startswith("UVC=WPRadius=")).partition("WPRadius=")[2])
        stops = lines[lines.index("START") + 1 : lines.index("END")][1:]
        for stop in stops:
            _, latitude, longitude, _, _, commands, *_ = (part.strip() for part in stop.split(";"))
            depth, park, speed = (float(re.search(rf"\b{key}([\d.]+)", commands)[1]) for key in "DPS")
            order = Order(*plane(float(longitude), float(latitude)), speed * KNOT, depth * FOOT)
            boat.run(order, max(math.dist((order.east, order.north), boat.nav) - near, 0.0))
            boat.drift(60.0 * park, voyage.fix_time <= 60.0 * park)
        ended(boat, len(stops))
    return boat.done


def autopilot(texts: list[str], home: tuple[float, float], voyage: Voyage) -> Sailed:
    """Plans of QGroundControl: NAV_WAYPOINT by dead reckoning; NAV_LOITER_TIME is held with power once a fix came."""
    plane, boat = Proj(proj="aeqd", lat_0=home[0], lon_0=home[1], ellps="WGS84"), Dead(voyage)
    for text in texts:
        items = json.loads(text)["mission"]["items"]
        place, speed, legs, jumps = 0, 0.0, 0, 0
        while place < len(items):
            command, own = items[place]["command"], items[place]["params"]
            if command == 178:
                speed = own[1]
            elif command == 177 and jumps < own[1]:
                jumps, place = jumps + 1, own[0] - 1
                continue
            elif command == 16:
                boat.run(Order(*plane(own[5], own[4]), speed, -own[6]))
            elif command == 19:
                legs += 1
                point = plane(own[5], own[4])
                boat.drift(min(voyage.fix_time, own[0]), voyage.fix_time <= own[0])
                away = point[0] - boat.nav[0], point[1] - boat.nav[1]
                share = min(1.0, speed * max(own[0] - voyage.fix_time, 0.0) / max(math.hypot(*away), 1e-9))
                boat.true = [boat.true[axis] + share * away[axis] for axis in (0, 1)]
                boat.nav = [boat.nav[axis] + share * away[axis] for axis in (0, 1)]
            place += 1
        ended(boat, legs)
    return boat.done


def glider(files: dict[str, str], home: tuple[float, float], voyage: Voyage, speed: float, depth: float) -> Sailed:
    """Missions one after the other, by the files that they name; aims off by the drift of the last segment.

    `speed` and `depth` are how the glider happens to fly, which its files do not say.
    """
    plane, boat = Proj(proj="aeqd", lat_0=home[0], lon_0=home[1], ellps="WGS84"), Dead(voyage)
    climb = depth / math.tan(0.4538)
    for mission in sorted(name for name in files if name.endswith(".mi")):
        begun, named = (
            boat.time,
            re.findall(r"behavior: (\w+)\n    b_arg: args_from_file\(enum\) (\d+)", files[mission]),
        )
        (number,) = (each for behaviour, each in named if behaviour == "goto_list")
        surfacings = [_b_args(files[f"surfac{each}.ma"]) for behaviour, each in named if behaviour == "surface"]
        assert any((each["start_when"], each["end_action"]) == (3.0, 0.0) for each in surfacings)
        (surface,) = (each for each in surfacings if each["start_when"] == 6.0)
        near, overtime = _b_args(files[f"goto_l{number}.ma"])["list_when_wpt_dist"], _b_args(files[mission])["overtime"]
        block = files[f"goto_l{number}.ma"].split("<start:waypoints>")[1].split("<end:waypoints>")[0]
        points = [line.split() for line in block.splitlines() if line and not line.startswith("#")]
        assert len(points) == 1 or any(each["start_when"] == 8.0 for each in surfacings)
        water, legs = (0.0, 0.0), 0
        for longitude, latitude in points:
            point, reached = plane(_degrees(longitude), _degrees(latitude)), False
            while not reached and boat.time - begun < overtime:
                left = math.dist(point, boat.nav)
                whole = max(left - near, 0.0)
                longest = surface["when_secs"] * speed + climb
                reached, way = whole <= longest, min(whole, longest)
                span, ahead = way / speed, [(point[axis] - boat.nav[axis]) / max(left, 1e-9) for axis in (0, 1)]
                aim = [boat.nav[axis] + ahead[axis] * way - water[axis] * span for axis in (0, 1)]
                gone = boat.run(Order(aim[0], aim[1], speed, depth))
                before, fixed = list(boat.true), voyage.fix_time <= surface["gps_wait_time"]
                boat.drift(min(voyage.fix_time, surface["gps_wait_time"]) + surface["keystroke_wait_time"], fixed)
                first = voyage.fix(before)  # on surfacing
                if gone and fixed:
                    water = tuple((first[axis] - aim[axis]) * speed / gone for axis in (0, 1))
                legs += 1
        ended(boat, legs)
    return boat.done


def _b_args(text: str) -> dict[str, float]:
    return {name: float(value) for name, value in re.findall(r"b_arg: (\w+)\([\w%]+\) (\S+)", text)}


def _degrees(written: str) -> float:
    number = float(written)
    degrees = math.trunc(number / 100.0)
    return degrees + (number - 100.0 * degrees) / 60.0
