"""Places: positions, in the local east-north plane of the site's origin and by latitude and longitude (WGS 84).

What is known of a site's ground, coast and sea level: the files that hold it, and the tide's height.
"""

import math
from functools import lru_cache
from typing import TYPE_CHECKING, Annotated, Generic, Literal

import numpy as np
from pydantic import Discriminator, Field, Tag, model_validator
from typing_extensions import Doc

from missionplan.arrays import Array
from missionplan.mission.schema import FileSection, ReadBy, V, invalid
from missionplan.mission.schema import quantity_parser as q
from missionplan.mission.schema.quantity_parser import CoordinateParser, Limit

if TYPE_CHECKING:
    from pyproj import Proj

_TIDES = Limit((-30.0, 30.0), (-10.0, 10.0), "the Bay of Fundy has 16 m between low and high water")


Latitude = Annotated[float, ReadBy(CoordinateParser("rad", low=-1.5707964, high=1.5707964, fixed=True))]
Longitude = Annotated[float, ReadBy(CoordinateParser("rad", low=-6.2831854, high=6.2831854, fixed=True, signs="EW"))]


class Geographic(FileSection):
    """A point by latitude and longitude, WGS 84 [rad]."""

    latitude: Annotated[Latitude, Doc("latitude, WGS 84")]
    longitude: Annotated[Longitude, Doc("longitude, WGS 84")]


Planar = Annotated[tuple[q.Length[V], q.Length[V]], Tag("<planar>")]
Position = Annotated[
    Planar[V] | Annotated[Geographic, Tag("<geographic>")],
    Discriminator(lambda value: "<geographic>" if isinstance(value, dict | Geographic) else "<planar>"),
]
"""East and north of the origin [m], or latitude and longitude."""


class PlaceFile(FileSection):
    """A local file with positions; `projection` is that of coordinates whose file names none.

    ``EPSG:32610``, or ``local`` for metres east and north of the origin. Without it a file that says nothing is in
    degrees.
    """

    file: Annotated[str, Doc("file of the polygons or depths"), Field(examples=["coast.geojson"])]
    projection: Annotated[str | None, Doc("projection of its coordinates"), Field(examples=["EPSG:32610"])] = None


class BathymetryFile(PlaceFile):
    """A grid of depths, or depth contours.

    `variable` is the one of a NetCDF file with several; `positive` says which way values count where the file does not.
    """

    variable: Annotated[str | None, Doc("name of the depths in the file"), Field(examples=["elevation"])] = None
    positive: Annotated[Literal["up", "down"] | None, Doc("whether its numbers count up or down")] = None


class HeightConstituent(FileSection):
    """A constituent of the tide's height."""

    name: Annotated[str, Doc("name of the constituent, such as M2"), Field(examples=["M2"])]
    amplitude: Annotated[q.FixedDistance, Doc("amplitude of the constituent"), _TIDES]
    phase: Annotated[q.FixedAngle, Doc("lag behind the equilibrium tide at Greenwich")]


class TideHeight(FileSection, Generic[V]):
    """Height of the sea level over the datum, from constituents or a record (CSV `t_s, height_m`) and its error."""

    file: Annotated[str | None, Doc("file of heights over time"), Field(examples=["tide.csv"])] = None
    constituents: Annotated[tuple[HeightConstituent, ...], Doc("constituents, in place of a file")] = ()
    level: Annotated[q.Length[V], Doc("mean sea level over the datum, added to the tide"), _TIDES] = q.default(0.0)
    error: Annotated[q.Length[V], Doc("error of the height, one a trial"), _TIDES] = q.default(0.0)

    @model_validator(mode="after")
    def _one_source(self) -> "TideHeight[V]":
        if (self.file is None) == (not self.constituents):
            raise invalid("expected a height, {constituents: [...]} or {file: ...}")
        return self


def _tide_tag(value: object) -> str:
    whole = isinstance(value, TideHeight) or (isinstance(value, dict) and {"file", "constituents"} & set(value))
    return "<tide>" if whole else "<height>"


TideOrHeight = Annotated[
    Annotated[TideHeight[V], Tag("<tide>")] | Annotated[q.Length[V], Tag("<height>")], Discriminator(_tide_tag)
]


EQUATORIAL_RADIUS, ECCENTRICITY_SQUARED = 6_378_137.0, 0.006_694_379_990_14
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
    return math.tan(latitude) * math.sqrt(1.0 - ECCENTRICITY_SQUARED * math.sin(latitude) ** 2) / EQUATORIAL_RADIUS


def to_geographic(east: Array, north: Array, origin: Geographic) -> tuple[Array, Array]:
    """Latitude and longitude [rad], from east and north of `origin` [m]."""
    longitude, latitude = _plane(origin.latitude, origin.longitude)(east, north, inverse=True)
    return np.radians(latitude), np.radians(longitude)
