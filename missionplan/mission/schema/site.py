"""Where the mission is: origin, depth, water and current."""

from itertools import pairwise
from typing import Annotated, Generic, Literal, Self

from pydantic import Discriminator, Tag, model_validator

from missionplan.mission.schema import quantities as q
from missionplan.mission.schema.moment import Moment
from missionplan.mission.schema.quantity_parser import QuantityParser
from missionplan.mission.schema.section import FileSection, ReadBy, V, invalid

_FixedSignedSpeed = Annotated[float, ReadBy(QuantityParser("m/s", low=-12.0, high=12.0, fixed=True))]
_LATITUDE = QuantityParser("rad", low=-1.5707964, high=1.5707964, fixed=True)
Latitude = Annotated[float, ReadBy(_LATITUDE)]
PositiveDuration = Annotated[V, ReadBy(QuantityParser("s", low=0.0, open_low=True))]
Weight = Annotated[float, ReadBy(QuantityParser("", low=0.0, fixed=True))]
SlopeAngle = Annotated[V, ReadBy(QuantityParser("rad", low=0.0, high=1.0))]
"""Steeper than 57° is a cliff, on which nothing lies."""


class Geographic(FileSection):
    """A point by latitude and longitude, WGS 84 [rad]."""

    latitude: Latitude
    longitude: q.FixedAngle


Planar = Annotated[tuple[q.Length[V], q.Length[V]], Tag("<planar>")]
Position = Annotated[
    Planar[V] | Annotated[Geographic, Tag("<geographic>")],
    Discriminator(lambda value: "<geographic>" if isinstance(value, dict | Geographic) else "<planar>"),
]
"""East and north of the origin [m], or latitude and longitude."""


class WaterSection(FileSection, Generic[V]):
    """Water, by temperature and practical salinity, or by density and viscosity."""

    temperature: q.Temperature[V] | None = None
    salinity: q.Salinity[V] | None = None
    density: q.WaterDensity[V] | None = None
    viscosity: q.Viscosity[V] | None = None

    @model_validator(mode="after")
    def _one_pair(self) -> Self:
        by_state = self.temperature is not None and self.salinity is not None
        by_value = self.density is not None and self.viscosity is not None
        given = sum(value is not None for value in (self.temperature, self.salinity, self.density, self.viscosity))
        if given != 2 or not (by_state or by_value):
            raise invalid("expected {temperature, salinity} or {density, viscosity}")
        return self


class CurrentLayer(FileSection, Generic[V]):
    """A layer of the current, from the layer above down to `down_to`; `toward` is clockwise from north."""

    down_to: q.PositiveLength[V]
    speed: q.SignedSpeed[V]
    toward: q.Angle[V]


class ForecastError(FileSection, Generic[V]):
    """Error of a forecast on each axis: its standard deviation, and over what time and length it is forgotten."""

    sigma: q.Speed[V]
    time: PositiveDuration[V]
    length: q.PositiveLength[V] | None = None


class CurrentFile(FileSection, Generic[V]):
    """A current read from files: a CSV record, or the NetCDF field of an ocean model.

    `file` is a path, a pattern (``forecast-*.nc``) or an OPeNDAP address. `projection` is that of a field whose
    coordinates are metres, such as ``EPSG:32610``, or ``local`` for metres from the origin. `outside` is for what is
    beyond the record's times, depths and places: `error`, a trial that leaves it fails; `hold`, the values at its end;
    `zero`, no current. `start`: when the seconds of a CSV record begin to count, UTC; without it, at the mission's.
    `error`: by how much the current differs from it. Of an ensemble `file` lists the members, or the file has a
    dimension of members; `weights`: their probabilities, in any scale.
    """

    file: str | tuple[str, ...]
    weights: tuple[Weight, ...] | None = None
    start: Moment | None = None
    projection: str | None = None
    outside: Literal["error", "hold", "zero"] = "error"
    error: ForecastError[V] | None = None

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
    """An ellipse: semi-axes, direction of the major one, and the lag behind the equilibrium tide at Greenwich.

    A negative minor axis turns clockwise.
    """

    name: str
    major: q.FixedSpeed
    minor: _FixedSignedSpeed = 0.0
    toward: q.FixedAngle
    phase: q.FixedAngle


class TideAtDepth(FileSection):
    """The tide at one depth, and the mean current there."""

    depth: q.FixedDistance
    east: _FixedSignedSpeed = 0.0
    north: _FixedSignedSpeed = 0.0
    constituents: tuple[TidalConstituent, ...]


class TideSection(FileSection):
    """Tides at some depths, as `missionplan tide` writes them."""

    depths: tuple[TideAtDepth, ...]

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

    tide: TideSection
    outside: Literal["error", "hold", "zero"] = "error"
    error: ForecastError[V] | None = None


def _current_tag(value: object) -> str:
    if isinstance(value, TidalCurrent) or (isinstance(value, dict) and "tide" in value and "file" not in value):
        return "<tide>"
    return "<file>" if isinstance(value, dict | CurrentFile) else "<layers>"


class SlopeSection(FileSection, Generic[V]):
    """Slope of the seafloor about the mooring; it falls `toward`, clockwise from north."""

    angle: SlopeAngle[V]
    toward: q.Angle[V]


class Site(FileSection, Generic[V]):
    """Site of the mission; `roughness` is z₀ of the seafloor, `chart` a file drawn behind the map."""

    origin: Geographic | None = None
    depth: q.PositiveLength[V] | None = None
    water: WaterSection[V] | None = None
    current: Annotated[
        Annotated[tuple[CurrentLayer[V], ...], Tag("<layers>")]
        | Annotated[CurrentFile[V], Tag("<file>")]
        | Annotated[TidalCurrent[V], Tag("<tide>")],
        Discriminator(_current_tag),
    ] = ()
    slope: SlopeSection[V] | None = None
    roughness: q.PositiveLength[V] | None = None
    chart: str | None = None

    @model_validator(mode="after")
    def _chart_has_a_place(self) -> Self:
        if self.chart is None:
            return self
        if not self.chart.lower().endswith((".json", ".geojson", ".tif", ".tiff")):
            raise invalid("expected a GeoJSON (.geojson, .json) or GeoTIFF file (.tif, .tiff)", ("chart",))
        if self.origin is None:
            raise invalid("a chart needs the origin's latitude and longitude", ("origin",))
        return self
