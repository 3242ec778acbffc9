"""Where the coordinates of a file lie in the mission's plane, and the part of the plane that a mission needs."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from missionplan.arrays import Array
from missionplan.errors import InputError, Problem
from missionplan.mission.geodesy import to_geographic, to_plane
from missionplan.mission.schema.place import BathymetryFile
from missionplan.mission.schema.site import Geographic

DEGREES = "EPSG:4326"
LOCAL = "local"
Transform = Callable[[Array, Array], tuple[Array, Array]]


@dataclass(frozen=True)
class Chart:
    """A file of a place, and the part of the plane that is wanted of it.

    Attributes
    ----------
    low, high : array, shape (2,)
        South-west and north-east corner of what is wanted [m].
    """

    key: str
    """Of the mission file, such as ``site.land``."""
    written: BathymetryFile
    """Of polygons, one that asks for no variable and direction."""
    origin: Geographic | None
    """None where all coordinates are local."""
    low: Array
    high: Array

    @property
    def path(self) -> Path:
        """Path of the file."""
        return Path(self.written.file)

    def problem(self, message: str, hint: str = "") -> InputError:
        """Return the error of the file."""
        return InputError([Problem(message, self.written.file, key=self.key, hint=hint)])

    def system(self, named: str | None) -> str:
        """Return the reference system of the coordinates: the mission's word, else the file's, else degrees."""
        return self.written.projection or named or DEGREES

    def to_plane(self, x: Array, y: Array, system: str) -> Array:
        """East and north of the origin, shape (2, n), of coordinates in a reference system [m].

        Raises
        ------
        InputError
            When nobody knows the system, or the coordinates are not of it.
        """
        if system == LOCAL:
            return np.stack((x, y)).astype(float)
        longitude, latitude = (x, y) if system == DEGREES else self._transform(system, DEGREES)(x, y)
        if not (np.isfinite(longitude).all() and np.isfinite(latitude).all()) or np.abs(latitude).max(initial=0) > 90:
            hint = f"{self.key}.projection: EPSG:… names it; `local` is for metres east and north of the origin"
            raise self.problem(f"its coordinates are not of {'degrees' if system == DEGREES else system}", hint)
        origin = self._origin()
        beside = longitude_beside(np.asarray(longitude), origin)
        return np.stack(to_plane(np.radians(latitude), np.radians(beside), origin))

    def from_plane(self, places: Array, system: str) -> Array:
        """Coordinates in a reference system, shape (2, n), of places east and north of the origin [m]."""
        if system == LOCAL:
            return places
        latitude, longitude = to_geographic(places[0], places[1], self._origin())
        x, y = longitude_beside(np.degrees(longitude), self._origin()), np.degrees(latitude)
        return np.stack((x, y) if system == DEGREES else self._transform(DEGREES, system)(x, y))

    def wanted(self, count: int = 33) -> Array:
        """Places over the wanted part of the plane, its edges among them, shape (2, count²) [m]."""
        axes = [np.linspace(a, b, count) for a, b in zip(self.low, self.high, strict=True)]
        return np.stack([axis.ravel() for axis in np.meshgrid(*axes)])

    def _origin(self) -> Geographic:
        if self.origin is None:
            raise self.problem("needs the site's origin, by which it is placed")
        return self.origin

    def _transform(self, begin: str, end: str) -> Transform:
        from pyproj import Transformer
        from pyproj.exceptions import ProjError

        try:
            found: Transform = Transformer.from_crs(begin, end, always_xy=True).transform
        except ProjError as error:
            named = next(system for system in (begin, end) if system != DEGREES)
            message = f"given {named[:60]!r}, which is no reference system: {str(error).partition(':')[0]}"
            raise InputError([Problem(message, self.written.file, key=f"{self.key}.projection")]) from None
        return found


def longitude_beside(longitude: Array, origin: Geographic) -> Array:
    """Longitudes within 180° of the origin's: neither the date line nor a file's convention matters [deg]."""
    middle = math.degrees(origin.longitude)
    return np.asarray((longitude - middle + 180.0) % 360.0 - 180.0 + middle)
