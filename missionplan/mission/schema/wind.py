"""Wind over the site, and how a vehicle afloat answers to it."""

from typing import Annotated, Generic

from pydantic import Field
from typing_extensions import Doc

from missionplan.mission.schema import quantities as q
from missionplan.mission.schema.limits import Limit
from missionplan.mission.schema.moment import Moment
from missionplan.mission.schema.section import FileSection, V

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

    file: str
    start: Moment | None = None


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
