"""Move a track to a made-up place, so that its data can be shared."""

from dataclasses import replace
from typing import TypeVar

import numpy as np

from missionplan.arrays import Array
from missionplan.errors import InputError, Problem
from missionplan.importers.track import Fixes, Positions, Track
from missionplan.mission.geodesy import to_geographic, to_plane
from missionplan.mission.schema.site import Geographic

T = TypeVar("T", Fixes, Positions)


def shifted(track: Track, latitude: float, longitude: float) -> Track:
    """Move all positions so that the first fix lies at a place [deg]; distances and directions from it are kept.

    Raises
    ------
    InputError
        When there is no such place, or one so near a pole that directions would turn.
    """
    if not (abs(latitude) <= 85.0 and abs(longitude) <= 180.0):
        message = f"given {latitude:g}, {longitude:g}, expected a latitude to 85 deg and a longitude to 180 deg"
        raise InputError([Problem(message, key="shift_origin")])
    if not len(track.fixes):
        return track
    old = _place(float(track.fixes.latitude[0]), float(track.fixes.longitude[0]))
    new = _place(latitude, longitude)

    def at_new(lat: Array, lon: Array) -> tuple[Array, Array]:
        plane = to_plane(np.radians(lat), np.radians(lon), old)
        moved = to_geographic(*plane, new)
        return np.degrees(moved[0]), np.degrees(moved[1])

    notice = f"all positions are moved: the first fix lies at {latitude:g}, {longitude:g}, a made-up place"
    return replace(
        track,
        fixes=_with_places(track.fixes, *at_new(track.fixes.latitude, track.fixes.longitude)),
        reckoned=_with_places(track.reckoned, *at_new(track.reckoned.latitude, track.reckoned.longitude)),
        notices=(*track.notices, notice),
    )


def _place(latitude: float, longitude: float) -> Geographic:
    return Geographic.model_construct(latitude=float(np.radians(latitude)), longitude=float(np.radians(longitude)))


def _with_places(positions: T, latitude: Array, longitude: Array) -> T:
    return replace(positions, latitude=latitude, longitude=longitude)
