"""Positions in the local east-north plane of the site's origin, and back to latitude and longitude (WGS 84)."""

import math
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from missionplan.arrays import Array
from missionplan.mission.schema.site import Geographic

if TYPE_CHECKING:
    from pyproj import Proj


_EQUATORIAL_RADIUS, _ECCENTRICITY_SQUARED = 6_378_137.0, 0.006_694_379_990_14
"""Of WGS 84 [m, 1]."""


@lru_cache(maxsize=16)
def _plane(latitude: float, longitude: float) -> "Proj":
    from pyproj import Proj

    # Azimuthal equidistant: distances and azimuths from the origin are exact on the ellipsoid.
    return Proj(proj="aeqd", lat_0=math.degrees(latitude), lon_0=math.degrees(longitude), ellps="WGS84")


def to_plane(latitude: Array, longitude: Array, origin: Geographic) -> tuple[Array, Array]:
    """East and north of `origin` [m], from latitude and longitude [rad]."""
    east, north = _plane(origin.latitude, origin.longitude)(np.degrees(longitude), np.degrees(latitude))
    return np.asarray(east, dtype=float), np.asarray(north, dtype=float)


def curvature_of_parallel(latitude: float) -> float:
    """Geodesic curvature of a parallel, tan(latitude [rad]) over the ellipsoid's normal radius, toward north [1/m]."""
    return math.tan(latitude) * math.sqrt(1.0 - _ECCENTRICITY_SQUARED * math.sin(latitude) ** 2) / _EQUATORIAL_RADIUS


def to_geographic(east: Array, north: Array, origin: Geographic) -> tuple[Array, Array]:
    """Latitude and longitude [rad], from east and north of `origin` [m]."""
    longitude, latitude = _plane(origin.latitude, origin.longitude)(east, north, inverse=True)
    return np.radians(latitude), np.radians(longitude)
