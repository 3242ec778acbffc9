"""Where the mission is: origin, depth, water and current.

Wind over the site, and how a vehicle afloat answers to it.
"""

import math
from itertools import pairwise
from typing import Annotated, Generic, Literal, Self

from pydantic import Discriminator, Field, Tag, model_validator
from typing_extensions import Doc

from missionplan.errors import LocalProblem
from missionplan.mission.schema import FileSection, Moment, ReadBy, V, all_invalid, invalid
from missionplan.mission.schema import quantity_parser as q
from missionplan.mission.schema.place import BathymetryFile, Geographic, PlaceFile, TideHeight, TideOrHeight
from missionplan.mission.schema.quantity_parser import Limit, QuantityParser

_SPEED = Limit((0.0, 90.0), (0.0, 33.0), "force 12 begins at 33 m/s; gusts of 85 m/s have been measured")
_SHARE = Limit((0.0, 0.2), (0.0, 0.07), "Allen and Plourde 1999: 0.4 to 7 % of the wind's speed")
_ERROR = Limit((0.0, 1.0), (0.0, 0.25), "Allen and Plourde 1999: 0.01 to 0.2 m/s")


class SteadyWind(FileSection, Generic[V]):
    """One wind for the whole mission."""

    speed: Annotated[q.Speed[V], Doc("speed of the wind, 10 m above the sea"), _SPEED]
    blows_from: Annotated[q.Angle[V], Doc("direction from which it blows, clockwise from north")] = Field(alias="from")


class WindFile(FileSection):
    """A wind read from a file: a CSV record of `t_s, east_m_s, north_m_s`, or a NetCDF field.

    Components are those toward which the air moves. `start`: when the seconds of a CSV record begin to count, UTC;
    without it, at the mission's. Beyond the record its last values are held.
    """

    file: Annotated[str, Doc("file of the wind"), Field(examples=["wind.csv"])]
    start: Annotated[Moment | None, Doc("time of the file at which the mission begins")] = None


def wind_tag(value: object) -> str:
    """Tell a steady wind from a file's."""
    return "<file>" if isinstance(value, WindFile) or (isinstance(value, dict) and "file" in value) else "<steady>"


class LeewaySection(FileSection, Generic[V]):
    """Velocity through the water that the wind gives a vehicle afloat, in shares of the wind's speed.

    The defaults are those of a moored mine of 1943 set adrift, the measured object most like a torpedo that floats low
    (Allen and Plourde 1999, class MINE; Breivik and Allen 2008): a drum has 0.75 %, a kayak 1.2 %, a submarine's buoy
    0.4 %, all within the scatter.
    """

    downwind: Annotated[q.Number[V], Doc("share of the wind's speed down the wind"), _SHARE] = q.default(0.0107)
    crosswind: Annotated[
        q.Number[V], Doc("share of the wind's speed across the wind, to the left or right by chance"), _SHARE
    ] = q.default(0.0041)
    downwind_offset: Annotated[
        q.SignedSpeed[V],
        Doc("velocity down the wind besides its share"),
        Limit((0.0, 1.0), (0.0, 0.2), "Allen and Plourde 1999: −0.08 to 0.15 m/s", signed=True),
    ] = q.default(0.0447)
    scatter: Annotated[q.Speed[V], Doc("standard deviation of each component, drawn once a trial"), _ERROR] = q.default(
        0.054
    )


_FixedSignedSpeed = Annotated[float, q.fixed("m/s", -12.0, 12.0)]
PositiveDuration = Annotated[V, ReadBy(QuantityParser("s", low=0.0, open_low=True))]
Weight = Annotated[float, q.fixed("")]
SlopeAngle = Annotated[V, ReadBy(QuantityParser("rad", low=0.0, high=1.0))]
"""Steeper than 57° is a cliff, on which nothing lies."""


class WaterSection(FileSection, Generic[V]):
    """Water, by temperature and practical salinity, or by density and viscosity."""

    temperature: Annotated[q.Temperature[V] | None, Doc("temperature of the water")] = None
    salinity: Annotated[
        q.Salinity[V] | None, Doc("practical salinity"), Limit((0.0, math.inf), (0.0, 42.0), "the Red Sea has 41")
    ] = None
    density: Annotated[
        q.WaterDensity[V] | None,
        Doc("density of the water"),
        Limit((0.0, math.inf), (990.0, 1060.0), "fresh 998, ocean 1020 to 1050 kg/m^3"),
    ] = None
    viscosity: Annotated[
        q.Viscosity[V] | None,
        Doc("kinematic viscosity of the water"),
        Limit((0.0, math.inf), (5e-7, 2.2e-6), "1.8e-6 m^2/s at 0 degC, 0.6e-6 at 45"),
    ] = None

    @model_validator(mode="after")
    def _one_pair(self) -> Self:
        by_state = self.temperature is not None and self.salinity is not None
        by_value = self.density is not None and self.viscosity is not None
        count = sum(value is not None for value in (self.temperature, self.salinity, self.density, self.viscosity))
        if count != 2 or not (by_state or by_value):
            raise invalid("expected {temperature, salinity} or {density, viscosity}")
        return self


class CurrentLayer(FileSection, Generic[V]):
    """A layer of the current, below the layer above."""

    down_to: Annotated[q.PositiveLength[V], Doc("lower end of the layer"), q.DEPTH]
    speed: Annotated[q.SignedSpeed[V], Doc("speed of the layer"), q.CURRENT]
    toward: Annotated[q.Angle[V], Doc("direction towards which it flows, clockwise from north")]


class ForecastError(FileSection, Generic[V]):
    """Error of a forecast on each axis."""

    sigma: Annotated[
        q.Speed[V],
        Doc("standard deviation of the forecast's error on each axis"),
        Limit((0.0, 3.0), (0.005, 0.5), "forecasts err by 0.02 to 0.3 m/s on each axis"),
    ]
    time: Annotated[
        PositiveDuration[V],
        Doc("time over which the error is forgotten"),
        Limit((60.0, 1e7), (600.0, 30.0 * q.DAY), "eddies last hours to weeks"),
    ]
    length: Annotated[
        q.PositiveLength[V] | None,
        Doc("length over which the error is forgotten"),
        Limit((10.0, 1e6), (200.0, 3e5), "eddies are 1 km to 200 km across"),
    ] = None


class CurrentFile(FileSection, Generic[V]):
    """A current read from files: a CSV record, or the NetCDF field of an ocean model.

    `file` is a path, a pattern (``forecast-*.nc``) or an OPeNDAP address. `projection` is that of a field whose
    coordinates are metres, such as ``EPSG:32610``, or ``local`` for metres from the origin. `outside` is for what is
    beyond the record's times, depths and places: `error`, a trial that leaves it fails; `hold`, the values at its end;
    `zero`, no current. `start`: when the seconds of a CSV record begin to count, UTC; without it, at the mission's.
    `error`: by how much the current differs from it. Of an ensemble `file` lists the members, or the file has a
    dimension of members; `weights`: their probabilities, in any scale.
    """

    file: Annotated[
        str | tuple[str, ...], Doc("file of the current, or the files of an ensemble"), Field(examples=["current.nc"])
    ]
    weights: Annotated[tuple[Weight, ...] | None, Doc("probability of each file; without it all are as likely")] = None
    start: Annotated[Moment | None, Doc("time of the file at which the mission begins")] = None
    projection: Annotated[str | None, Doc("projection of its coordinates"), Field(examples=["EPSG:32610"])] = None
    outside: Annotated[Literal["error", "hold", "zero"], Doc("what holds outside its times and places")] = "error"
    error: Annotated[ForecastError[V] | None, Doc("error of the forecast")] = None

    @property
    def members(self) -> tuple[str, ...]:
        """Path, pattern or address of each member of an ensemble; one where it is none."""
        return (self.file,) if isinstance(self.file, str) else self.file

    @model_validator(mode="after")
    def _weighted(self) -> Self:
        if isinstance(self.file, tuple) and len(self.file) < 2:
            raise invalid("an ensemble has two members or more; a single file is no list", ("file",))
        if self.weights is not None:
            if isinstance(self.file, tuple) and len(self.weights) != len(self.file):
                raise invalid(f"{len(self.weights)} weights for {len(self.file)} members", ("weights",))
            if not sum(self.weights) > 0.0:
                raise invalid("expected at least one weight above zero", ("weights",))
        return self


class TidalConstituent(FileSection):
    """The ellipse of a constituent."""

    name: Annotated[str, Doc("name of the constituent, such as M2"), Field(examples=["M2"])]
    major: Annotated[q.FixedSpeed, Doc("major semi-axis of the ellipse"), q.CURRENT]
    minor: Annotated[
        _FixedSignedSpeed, Doc("minor semi-axis; negative where the current turns clockwise"), q.CURRENT
    ] = 0.0
    toward: Annotated[q.FixedAngle, Doc("direction of the major axis, clockwise from north")]
    phase: Annotated[q.FixedAngle, Doc("lag behind the equilibrium tide at Greenwich")]


class TideAtDepth(FileSection):
    """The tide at one depth, and the mean current there."""

    depth: Annotated[q.FixedDistance, Doc("depth of these tides"), q.DEPTH]
    east: Annotated[_FixedSignedSpeed, Doc("mean current towards the east there"), q.CURRENT] = 0.0
    north: Annotated[_FixedSignedSpeed, Doc("mean current towards the north there"), q.CURRENT] = 0.0
    constituents: Annotated[tuple[TidalConstituent, ...], Doc("tides at this depth")]


class TideSection(FileSection):
    """Tides at some depths, as `missionplan tide` writes them."""

    depths: Annotated[tuple[TideAtDepth, ...], Doc("tides by depth, linear between")]

    @model_validator(mode="after")
    def _downward(self) -> "TideSection":
        if not self.depths:
            raise invalid("expected at least one depth", ("depths",))
        for index, (above, below) in enumerate(pairwise(self.depths)):
            if below.depth <= above.depth:
                raise invalid("depths go from the surface down, each once", ("depths", index + 1, "depth"))
        return self


class TidalCurrent(FileSection, Generic[V]):
    """A current forecast from tidal constituents; `outside`: above and below their depths; `error`: its error."""

    tide: Annotated[TideSection, Doc("tide from which the current follows")]
    outside: Annotated[Literal["error", "hold", "zero"], Doc("what holds above and below its depths")] = "error"
    error: Annotated[ForecastError[V] | None, Doc("error of the forecast")] = None


def _current_tag(value: object) -> str:
    if isinstance(value, TidalCurrent) or (isinstance(value, dict) and "tide" in value and "file" not in value):
        return "<tide>"
    return "<file>" if isinstance(value, dict | CurrentFile) else "<layers>"


class SlopeSection(FileSection, Generic[V]):
    """Slope of the seafloor about the mooring."""

    angle: Annotated[
        SlopeAngle[V],
        Doc("angle of the seafloor with the horizontal"),
        Limit((0.0, 1.0), (0.0, 0.35), "sand lies no steeper than 0.6 rad (35 deg)"),
    ]
    toward: Annotated[q.Angle[V], Doc("direction towards which the seafloor falls, clockwise from north")]


class Site(FileSection, Generic[V]):
    """Site of the mission; `chart` is a file drawn behind the map.

    `land` and `keep_out` are polygons that no trial may touch; `bathymetry` stands in the place of `depth`.
    """

    origin: Annotated[Geographic | None, Doc("place of the origin of coordinates")] = None
    depth: Annotated[
        q.PositiveLength[V] | None,
        Doc("depth of the water at the mooring"),
        Limit((0.1, 11_000.0), (1.0, 6000.0), q.DEPTH.source),
    ] = None
    water: Annotated[WaterSection[V] | None, Doc("temperature, salinity or density of the water")] = None
    current: Annotated[
        Annotated[tuple[CurrentLayer[V], ...], Tag("<layers>")]
        | Annotated[CurrentFile[V], Tag("<file>")]
        | Annotated[TidalCurrent[V], Tag("<tide>")],
        Discriminator(_current_tag),
        Doc("current in layers, from files, or of tidal constituents"),
    ] = ()
    wind: Annotated[
        Annotated[
            Annotated[SteadyWind[V], Tag("<steady>")] | Annotated[WindFile, Tag("<file>")], Discriminator(wind_tag)
        ]
        | None,
        Doc("wind that drives the vehicle while it is afloat"),
    ] = None
    slope: Annotated[SlopeSection[V] | None, Doc("slope of the seafloor at the mooring")] = None
    roughness: Annotated[
        q.PositiveLength[V] | None,
        Doc("z₀ of the seafloor, for the current near it"),
        Limit((1e-7, 1.0), (1e-5, 0.03), "Soulsby 1997: 0.05 mm silt, 6 mm rippled sand"),
    ] = None
    chart: Annotated[
        str | None, Doc("image or coast that maps draw and nothing computes with"), Field(examples=["coast.geojson"])
    ] = None
    bathymetry: Annotated[BathymetryFile | None, Doc("grid of depths, in place of one depth")] = None
    depth_datum: Annotated[
        str | None, Doc("level from which the grid of depths counts"), Field(examples=["mean sea level"])
    ] = None
    tide_height: Annotated[
        TideOrHeight[V] | None,
        Doc("height of the sea level over the datum of the depths"),
        Limit((-30.0, 30.0), (-10.0, 10.0), "the Bay of Fundy has 16 m between low and high water"),
    ] = None
    clearance: Annotated[
        q.Distance[V],
        Doc("water that is to stay under the hull"),
        Limit((0.0, 1000.0), (0.0, 50.0), "vehicles keep 1 to 10 m over charted ground"),
    ] = q.default(0.0)
    land: Annotated[PlaceFile | None, Doc("polygons of land that no trial may touch")] = None
    keep_out: Annotated[PlaceFile | None, Doc("polygons that the vehicle has to stay out of")] = None

    @property
    def place_files(self) -> dict[str, PlaceFile]:
        """Files of the ground and the coast, by their keys."""
        named = {"bathymetry": self.bathymetry, "land": self.land, "keep_out": self.keep_out}
        return {key: file for key, file in named.items() if file is not None}

    @model_validator(mode="after")
    def _one_depth(self) -> Self:
        problems = []
        if self.bathymetry is not None and self.depth is not None:
            message = "given beside site.bathymetry, which says how deep it is: leave one of them out"
            problems.append(LocalProblem(("depth",), message))
        for key, file in self.place_files.items():
            if self.origin is None and file.projection != "local":
                problems.append(LocalProblem(("origin",), f"missing; site.{key} is placed by it"))
        if problems:
            raise all_invalid(problems)
        return self

    @property
    def files(self) -> tuple[str, ...]:
        """Files that the site is read from, patterns and addresses too, besides those that the mission includes."""
        current = self.current.members if isinstance(self.current, CurrentFile) else ()
        wind = (self.wind.file,) if isinstance(self.wind, WindFile) else ()
        tide = self.tide_height.file if isinstance(self.tide_height, TideHeight) else None
        named = (self.chart, tide, *(file.file for file in self.place_files.values()))
        return (*current, *wind, *(name for name in named if name))

    @model_validator(mode="after")
    def _chart_has_a_place(self) -> Self:
        if self.chart is None:
            return self
        if not self.chart.lower().endswith((".json", ".geojson", ".gpkg", ".shp", ".tif", ".tiff")):
            expected = "GeoJSON (.geojson, .json), GeoPackage (.gpkg), shapefile (.shp) or GeoTIFF file (.tif, .tiff)"
            raise invalid(f"expected a {expected}", ("chart",))
        if self.origin is None:
            raise invalid("a chart needs the origin's latitude and longitude", ("origin",))
        return self
