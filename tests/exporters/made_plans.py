"""Plans made by hand in which no two numbers are alike, so that a file that takes one for another is found out."""

import math
from dataclasses import replace
from datetime import UTC, datetime

import numpy as np
from pyproj import Geod

from missionplan.results.plan import Plan, PlannedMooring, PlannedTransit, SurfacingRule
from missionplan.results.plan_places import Waypoint

GEOD = Geod(ellps="WGS84")
WEST = (math.radians(37.2516), math.radians(-76.3842))
DATE_LINE = (math.radians(-17.5), math.radians(179.996))
"""Courses cross the antimeridian."""
ON_IT = (math.radians(-17.5), math.radians(179.99305))
"""It crosses the circles about the mooring."""
RULE = SurfacingRule(interval=411.7, interval_time=317.6, surface_time=203.3, surface_time_p99=371.4)
SHORT = SurfacingRule(interval=523.2, interval_time=402.9, surface_time=21.4, surface_time_p99=44.8)
TABLE = SurfacingRule(
    interval=1333.0,
    interval_time=1066.4,
    surface_time=88.6,
    surface_time_p99=131.2,
    table=((200.0, 180.0), (1500.0, 1400.0)),
    extra_time=101.4,
    extra_time_error=13.8,
)


def on_earth(origin, east, north):
    """Latitude and longitude [rad] by azimuth and distance on the ellipsoid, another way than the package's own."""
    azimuth, distance = np.degrees(np.arctan2(east, north)), np.hypot(east, north)
    longitude, latitude, _ = GEOD.fwd(*np.degrees(origin[::-1]), azimuth, distance)
    return math.radians(latitude), math.radians(longitude)


def metres_apart(origin, east, north, latitude, longitude):
    """Distance [m] between a point of the plane and where a file has it [deg]."""
    expected = np.degrees(on_earth(origin, east, north))
    return GEOD.inv(expected[1], expected[0], longitude, latitude)[2]


def course(origin, name, points, since, speed):
    """Waypoints through points of the plane [m], from a moment of the mission [s]."""
    made, elapsed = [], since
    for number, (east, north) in enumerate(points):
        dx, dy = (east - points[number - 1][0], north - points[number - 1][1]) if number else (0.0, 0.0)
        length = math.hypot(dx, dy)
        elapsed += length / speed + 31.7 * (number > 1)
        made.append(
            Waypoint(
                name=f"{name} {number}",
                kind="start" if number == 0 else "arrival" if number == len(points) - 1 else "surfacing",
                east=east,
                north=north,
                **dict(zip(("latitude", "longitude"), on_earth(origin, east, north), strict=True)),
                course=math.atan2(dx, dy) % (2.0 * math.pi) if number else math.nan,
                length=length,
                duration=length / speed + 2.3 if number else 0.0,
                duration_p99=length / speed * 1.31 if number else math.nan,
                elapsed=elapsed,
            )
        )
    return tuple(made)


def made(origin, rules=(RULE, SHORT)):
    """There, a mooring, and back by another way: legs on headings of all four quadrants."""
    out = [(12.5, -40.25), (-310.75, 205.5), (-520.0, -388.125), (731.5, -612.75)]
    back = [(755.25, -590.5), (402.75, 55.5), (91.0, 717.5)]
    there = PlannedTransit("ingress", 4.37, 1.313, 62.5, rules[0], course(origin, "ingress", out, 17.0, 1.313), 2954.3)
    latitude, longitude = on_earth(origin, *out[-1])
    moor = PlannedMooring(
        name="moor",
        east=out[-1][0],
        north=out[-1][1],
        latitude=latitude,
        longitude=longitude,
        radius=23.75,
        water_depth=14.62,
        line_length=3.08,
        anchor_wet_weight=19.83,
        release_time=10.7,
        release_time_p99=18.9,
        hold=1807.0,
        galvanic_release=5431.0,
        elapsed=2613.2,
    )
    aim = replace(there.goal, east=out[-1][0] + 7.25, north=out[-1][1] - 3.5)
    aim = replace(aim, **dict(zip(("latitude", "longitude"), on_earth(origin, aim.east, aim.north), strict=True)))
    there = replace(there, aim=aim, extra_legs=2)
    home = PlannedTransit("egress", 7.91, 1.126, 38.5, rules[1], course(origin, "egress", back, 9876.0, 1.126), 1612.6)
    start = datetime(2026, 6, 1, 12, 34, 56, tzinfo=UTC)
    return Plan(
        "Trip & back", "f00d" * 16, "0.0.made", start, origin, (there, moor, home), ("as made by hand",), corrects=True
    )


PLANS = {"west": made(WEST), "date line": made(DATE_LINE, (TABLE, SHORT)), "circles on it": made(ON_IT)}
