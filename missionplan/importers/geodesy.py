"""Short distances on the ellipsoid: metres from degrees and back, to 0.1 % within some tens of kilometres."""

import numpy as np

from missionplan.arrays import Array, Scalars


def metres_per_degree(latitude: Scalars) -> tuple[Array, Array]:
    """Length of a degree of longitude and of latitude on WGS 84 [m], at a latitude [deg].

    Series of the National Geospatial-Intelligence Agency's "Length of a degree" tables; within 1 cm.
    """
    angle = np.radians(latitude)
    north = 111132.92 - 559.82 * np.cos(2 * angle) + 1.175 * np.cos(4 * angle) - 0.0023 * np.cos(6 * angle)
    east = 111412.84 * np.cos(angle) - 93.5 * np.cos(3 * angle) + 0.118 * np.cos(5 * angle)
    return np.asarray(east), np.asarray(north)


def displacement(from_lat: Scalars, from_lon: Scalars, to_lat: Scalars, to_lon: Scalars) -> tuple[Array, Array]:
    """East and north from one position to another [m]; positions in degrees, across 180° too."""
    east, north = metres_per_degree(0.5 * (np.asarray(from_lat) + np.asarray(to_lat)))
    turn = np.remainder(np.asarray(to_lon) - np.asarray(from_lon) + 180.0, 360.0) - 180.0
    return np.asarray(turn * east), np.asarray((np.asarray(to_lat) - np.asarray(from_lat)) * north)


def moved(latitude: Scalars, longitude: Scalars, east: Scalars, north: Scalars) -> tuple[Array, Array]:
    """Latitude and longitude [deg] of a place east and north of another [m]."""
    _, per_north = metres_per_degree(latitude)
    new = np.asarray(latitude) + np.asarray(north) / per_north
    per_east, per_north = metres_per_degree(0.5 * (np.asarray(latitude) + new))
    new = np.asarray(latitude) + np.asarray(north) / per_north
    return np.asarray(new), np.asarray(np.asarray(longitude) + np.asarray(east) / per_east)
