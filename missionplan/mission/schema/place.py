"""What is known of a site's ground, coast and sea level: the files that hold it, and the tide's height."""

from typing import Annotated, Generic, Literal

from pydantic import Discriminator, Tag, model_validator
from typing_extensions import Doc

from missionplan.mission.schema import quantity_parser as q
from missionplan.mission.schema.quantity_parser import Limit
from missionplan.mission.schema.section import FileSection, V, invalid

_TIDES = Limit((-30.0, 30.0), (-10.0, 10.0), "the Bay of Fundy has 16 m between low and high water")


class PlaceFile(FileSection):
    """A local file with positions; `projection` is that of coordinates whose file names none.

    ``EPSG:32610``, or ``local`` for metres east and north of the origin. Without it a file that says nothing is in
    degrees.
    """

    file: Annotated[str, Doc("file of the polygons or depths")]
    projection: Annotated[str | None, Doc("projection of its coordinates")] = None


class BathymetryFile(PlaceFile):
    """A grid of depths, or depth contours.

    `variable` is the one of a NetCDF file with several; `positive` says which way values count where the file does not.
    """

    variable: Annotated[str | None, Doc("name of the depths in the file")] = None
    positive: Annotated[Literal["up", "down"] | None, Doc("whether its numbers count up or down")] = None


class HeightConstituent(FileSection):
    """A constituent of the tide's height."""

    name: Annotated[str, Doc("name of the constituent, such as M2")]
    amplitude: Annotated[q.FixedDistance, Doc("amplitude of the constituent"), _TIDES]
    phase: Annotated[q.FixedAngle, Doc("lag behind the equilibrium tide at Greenwich")]


class TideHeight(FileSection, Generic[V]):
    """Height of the sea level over the datum, from constituents or a record (CSV `t_s, height_m`) and its error."""

    file: Annotated[str | None, Doc("file of heights over time")] = None
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
    Annotated[TideHeight[V], Tag("<tide>")] | Annotated[q.Length[V], Tag("<height>")],
    Discriminator(_tide_tag),
]
