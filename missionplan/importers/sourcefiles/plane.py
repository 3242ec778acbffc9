"""Positions in metres east and north of an origin that is given, or found at the first fix."""

import math

import numpy as np

from missionplan.arrays import Array
from missionplan.errors import InputError, Problem, shown
from missionplan.importers.mapping import MappedName
from missionplan.importers.track import Fixes, Positions, positions
from missionplan.mission.geodesy import to_geographic, to_plane
from missionplan.mission.schema.site import Geographic

_NEAR = 120.0
"""How far in time a fix may be from the first position for the origin to be found from both [s]."""


def origin_of(name: MappedName | None) -> tuple[float, float] | None:
    """Read `origin=48.5,-123.1`.

    Raises
    ------
    InputError
        When it is no latitude and longitude.
    """
    if name is None:
        return None
    words = name.name.split(",")
    try:
        latitude, longitude = (float(word) for word in words)
    except ValueError:
        message = f"given {shown(name.name)}, expected origin=LATITUDE,LONGITUDE in degrees"
        raise InputError([Problem(message, key="map")]) from None
    return latitude, longitude


def plane_positions(t: Array, east: Array, north: Array, fixes: Fixes, origin: tuple[float, float] | None) -> Positions:
    """Turn metres into latitude and longitude.

    Parameters
    ----------
    t, east, north : array, shape (n,)
        Time since 1970 [s], position from the origin [m].
    fixes : Fixes
        By which the origin is found where it is not given: the position nearest in time to a fix is that fix.
    origin : tuple or None
        Latitude and longitude of the origin [deg].

    Raises
    ------
    InputError
        When there is no origin, and no fix near a position.
    """
    there = np.isfinite(t) & np.isfinite(east) & np.isfinite(north)
    t, east, north = t[there], east[there], north[there]
    if not len(t):
        return Positions()
    place = _place(*origin) if origin is not None else _found(t, east, north, fixes)
    latitude, longitude = to_geographic(east, north, place)
    return positions(t, np.degrees(latitude), np.degrees(longitude))


def _place(latitude: float, longitude: float) -> Geographic:
    return Geographic.model_construct(latitude=math.radians(latitude), longitude=math.radians(longitude))


def _found(t: Array, east: Array, north: Array, fixes: Fixes) -> Geographic:
    nearest = np.clip(np.searchsorted(t, fixes.t), 0, len(t) - 1)
    away = np.abs(t[nearest] - fixes.t)
    near = np.flatnonzero(away <= _NEAR)
    if not len(near):
        hint = "add origin=LATITUDE,LONGITUDE to --map"
        raise InputError([Problem("positions are in metres, and their origin is not known", key="map", hint=hint)])
    fix, own = near[0], nearest[near[0]]
    at_fix = _place(float(fixes.latitude[fix]), float(fixes.longitude[fix]))
    latitude, longitude = to_geographic(np.array([-east[own]]), np.array([-north[own]]), at_fix)
    # the plane about the origin, not about the fix: one step of correction is exact to millimetres
    place = _place(float(np.degrees(latitude[0])), float(np.degrees(longitude[0])))
    missed = to_plane(np.array([at_fix.latitude]), np.array([at_fix.longitude]), place)
    shift = to_geographic(missed[0] - east[own], missed[1] - north[own], place)
    return _place(float(np.degrees(shift[0][0])), float(np.degrees(shift[1][0])))
