"""Places and directions on the Earth: metres and degrees, a made-up origin for sharing, and magnetic declination.

Short distances are on the ellipsoid, to 0.1 % within some tens of kilometres.
"""

import math
from dataclasses import replace
from datetime import UTC, datetime
from functools import lru_cache
from importlib import import_module
from importlib.util import find_spec
from typing import Any, TypeVar

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.errors import InputError, Problem, shown
from missionplan.identity import how_to_install
from missionplan.importers.mapping import MappedName
from missionplan.importers.track import Fixes, Positions, Series, Track, positions
from missionplan.mission.schema.place import (
    ECCENTRICITY_SQUARED,
    EQUATORIAL_RADIUS,
    Geographic,
    to_geographic,
    to_plane,
)


def metres_per_degree(latitude: Scalars) -> tuple[Array, Array]:
    """Length of a degree of longitude and of latitude on WGS 84 [m], at a latitude [deg].

    By the radii of curvature across the meridian and along it (Snyder 1987, *Map Projections: A Working Manual*, Eqs.
    4-18 to 4-21).
    """
    angle = np.radians(latitude)
    squared = 1.0 - ECCENTRICITY_SQUARED * np.sin(angle) ** 2
    across = np.radians(EQUATORIAL_RADIUS) / np.sqrt(squared)
    return np.asarray(across * np.cos(angle)), np.asarray(across * (1.0 - ECCENTRICITY_SQUARED) / squared)


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


_FARTHEST = 300e3
"""Of positions in a plane about their origin [m]."""
_NEAR = 120.0
"""How far in time a fix may be from the first position for the origin to be found from both [s]."""


def origin_of(name: MappedName | None) -> tuple[float, float] | None:
    """Read `origin=48.5,-123.1`.

    Raises InputError when it is no latitude and longitude.
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

    Raises InputError when there is no origin, and no fix near a position, or they are of no plane about one.

    `t`, `east`, `north`, shape (n,): time since 1970 [s], position from the origin [m]. `fixes`: by which the origin is
    found where it is not given: the position nearest in time to a fix is that fix. `origin`: latitude and longitude of
    the origin [deg].
    """
    there = np.isfinite(t) & np.isfinite(east) & np.isfinite(north)
    t, east, north = t[there], east[there], north[there]
    if not len(t):
        return Positions()
    away = float(np.hypot(east, north).max())
    if away > _FARTHEST:
        message = (
            f"positions are {away / 1e3:.0f} km from their origin: metres of a projection such as UTM, whose north"
        )
        raise InputError([Problem(f"{message} is not true", key="map", hint="give latitudes and longitudes")])
    place = _place(*origin) if origin is not None else _found(t, east, north, fixes)
    latitude, longitude = to_geographic(east, north, place)
    return positions(t, np.degrees(latitude), np.degrees(longitude))


def _place(latitude: float, longitude: float) -> Geographic:
    return Geographic.model_construct(latitude=math.radians(latitude), longitude=math.radians(longitude))


def _found(t: Array, east: Array, north: Array, fixes: Fixes) -> Geographic:
    after = np.clip(np.searchsorted(t, fixes.t), 0, len(t) - 1)
    nearest = after - ((after > 0) & (fixes.t - t[after - 1] < t[after] - fixes.t))
    away = np.abs(t[nearest] - fixes.t)
    near = np.flatnonzero(away <= _NEAR)
    if not len(near):
        hint = "add origin=LATITUDE,LONGITUDE to --map"
        raise InputError([Problem("positions are in metres, and their origin is not known", key="map", hint=hint)])
    fix = near[away[near] <= away[near].min() + 1.0][0]  # the earliest of the nearest: the reckoning errs more later on
    row = nearest[fix]
    at_fix = _place(float(fixes.latitude[fix]), float(fixes.longitude[fix]))
    latitude, longitude = to_geographic(np.array([-east[row]]), np.array([-north[row]]), at_fix)
    # the plane about the origin, not about the fix: one step of correction is exact to millimetres
    place = _place(float(np.degrees(latitude[0])), float(np.degrees(longitude[0])))
    missed = to_plane(np.array([at_fix.latitude]), np.array([at_fix.longitude]), place)
    shift = to_geographic(missed[0] - east[row], missed[1] - north[row], place)
    return _place(float(np.degrees(shift[0][0])), float(np.degrees(shift[1][0])))


T = TypeVar("T", Fixes, Positions)


def shifted(track: Track, latitude: float, longitude: float) -> Track:
    """Move all positions so that the first fix lies at a place [deg]; distances and directions from it are kept.

    Raises InputError when there is no such place, or one so near a pole that directions would turn.
    """
    if not (abs(latitude) <= 85.0 and abs(longitude) <= 180.0):
        message = f"given {latitude:g}, {longitude:g}, expected a latitude to 85 deg and a longitude to 180 deg"
        raise InputError([Problem(message, key="shift_origin")])
    if not len(track.fixes):
        return track
    old = _place(float(track.fixes.latitude[0]), float(track.fixes.longitude[0]))
    new = _place(latitude, longitude)

    def at_new(lat: Array, lon: Array) -> tuple[Array, Array]:
        moved = to_geographic(*to_plane(np.radians(lat), np.radians(lon), old), new)
        return np.degrees(moved[0]), np.degrees(moved[1])

    notice = f"all positions are moved: the first fix lies at {latitude:g}, {longitude:g}, a made-up place"
    return replace(
        track,
        fixes=_with_places(track.fixes, *at_new(track.fixes.latitude, track.fixes.longitude)),
        reckoned=_with_places(track.reckoned, *at_new(track.reckoned.latitude, track.reckoned.longitude)),
        notices=(*track.notices, notice),
    )


def _with_places(positions: T, latitude: Array, longitude: Array) -> T:
    return replace(positions, latitude=latitude, longitude=longitude)


WRONG = 1.5
"""Difference from the model beyond which a vehicle's declination is called wrong [deg]: the model's own error is about
0.5 deg, vehicles round to whole degrees."""


_MODELS = ("WMM_2010", "WMM_2015v2", "WMM_2020", "WMM_2025")


def model_declination(latitude: float, longitude: float, t: float) -> float | None:
    """Return the declination of the World Magnetic Model [deg, east positive], or None without its package.

    Before 2010 and after 2030 the nearest of its five-year models is extrapolated by at most two years; beyond, there
    is none.

    `latitude`, `longitude` [deg]. `t`: since 1970 [s].
    """
    if find_spec("pygeomag") is None:
        return None
    moment = datetime.fromtimestamp(t, UTC)
    begun = datetime(moment.year, 1, 1, tzinfo=UTC)
    year = moment.year + (moment - begun).total_seconds() / (365.2425 * 86400.0)
    if not 2008.0 <= year <= 2032.0:
        return None
    which = min(max(int((year - 2010.0) // 5), 0), len(_MODELS) - 1)
    field = _model(_MODELS[which]).calculate(
        glat=latitude, glon=(longitude + 180.0) % 360.0 - 180.0, alt=0.0, time=year, allow_date_outside_lifespan=True
    )
    return float(field.d)


def _no_model() -> str:
    is_installed = find_spec("pygeomag") is not None
    return "no model is of that date" if is_installed else f"{how_to_install('magnetic')} to check and add it"


@lru_cache(maxsize=4)
def _model(name: str) -> Any:
    return import_module("pygeomag").GeoMag(coefficients_file=f"wmm/{name}.COF")


def with_declination(track: Track) -> Track:
    """Check a vehicle's declination, and take the model's where headings are magnetic and none was logged."""
    if not len(track.heading) or not len(track.fixes) or track.heading_from == "true":
        return track
    middle = len(track.fixes) // 2
    place = float(track.fixes.latitude[middle]), float(track.fixes.longitude[middle])
    t = float(track.fixes.t[middle])
    model = model_declination(*place, t)
    if not len(track.declination):
        return _without_own(track, t, model)
    readings = track.declination.values[track.declination.values != 0.0]  # but for the zeros before it knew one
    angle = float(np.median(readings)) if len(readings) else 0.0
    if model is None:
        notice = f"the vehicle's declination, {angle:.1f} deg, was not checked: {_no_model()}"
    elif abs(angle - model) > WRONG:
        notice = (
            f"the vehicle's declination is {angle:.1f} deg, but the World Magnetic Model has {model:.1f} deg there and "
            f"then: its dead reckoning is turned by {angle - model:+.1f} deg, which looks like an error of the compass"
        )
    else:
        notice = f"the vehicle's declination, {angle:.1f} deg, is that of the World Magnetic Model, {model:.1f} deg"
    return replace(track, notices=(*track.notices, notice))


def _without_own(track: Track, t: float, model: float | None) -> Track:
    if track.heading_from != "magnetic":
        return track
    if model is None:
        notice = f"no declination is logged: headings are taken as from true north ({_no_model()})"
        return replace(track, notices=(*track.notices, notice))
    notice = f"no declination is logged: that of the World Magnetic Model, {model:.1f} deg, is used"
    return replace(track, declination=Series(np.array([t]), np.array([model])), notices=(*track.notices, notice))
