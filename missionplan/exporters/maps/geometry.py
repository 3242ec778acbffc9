"""Points of the local plane on Earth, and circles, for maps."""

import math

import numpy as np

from missionplan.arrays import Array
from missionplan.mission.geodesy import to_geographic
from missionplan.mission.schema.site import Geographic
from missionplan.results.plan import PlannedMooring, Waypoint

Origin = tuple[float, float]
"""Latitude and longitude [rad]."""


def longitudes_latitudes(points: Array, origin: Origin) -> list[list[float]]:
    """Return longitude and latitude [deg] of points of shape (2, n), rounded to about a centimetre.

    Longitudes continue across the antimeridian, beyond ±180°.
    """
    place = Geographic.model_construct(latitude=origin[0], longitude=origin[1])
    latitude, longitude = to_geographic(points[0], points[1], place)
    longitude = origin[1] + np.remainder(longitude - origin[1] + math.pi, 2.0 * math.pi) - math.pi
    rounded: list[list[float]] = np.round(np.degrees((longitude, latitude)).T, 7).tolist()
    return rounded


def longitude_latitude(point: Waypoint | PlannedMooring, origin: Origin) -> list[float]:
    """Return longitude and latitude of a planned point [deg]."""
    return longitudes_latitudes(np.array([[point.east], [point.north]]), origin)[0]


def circle(centre: tuple[float, float], radius: float, points: int = 72) -> Array:
    """Return a closed circle, shape (2, points + 1), counter-clockwise."""
    angle = np.linspace(0.0, 2.0 * math.pi, points + 1)
    return np.array(centre)[:, None] + radius * np.array([np.cos(angle), np.sin(angle)])


def course_line(waypoints: tuple[Waypoint, ...]) -> Array:
    """Return the course through waypoints, shape (2, n) [m]."""
    return np.array([[waypoint.east, waypoint.north] for waypoint in waypoints]).T
