"""Places of a plan: positions on Earth, waypoints with the legs that lead to them, and zones kept out of."""

import math
from dataclasses import dataclass
from typing import Annotated, Literal, NamedTuple

from missionplan.results.entries import Entry, Record

TIME_OUT_MARGIN = 1.1
"""Time-out over the 99 % duration."""
DEGREE = math.radians(1.0)

East = Annotated[float, Entry("east of the origin", "m", digits=3)]
North = Annotated[float, Entry("north of the origin", "m", digits=3)]
Latitude = Annotated[float, Entry("on WGS 84; null where the mission has no origin", "deg", scale=DEGREE, digits=8)]
Longitude = Annotated[float, Entry("east of Greenwich", "deg", scale=DEGREE, digits=8)]
"""In memory [rad], nan where not known."""
WaypointKind = Literal["start", "surfacing", "arrival"]


@dataclass(frozen=True)
class Waypoint(Record):
    """A point of the course, with the leg that leads to it."""

    name: Annotated[str, Entry("such as ``ingress 2``")]
    kind: Annotated[WaypointKind, Entry("whether the transit starts, a planned leg ends, or the transit ends there")]
    east: East
    north: North
    latitude: Latitude
    longitude: Longitude
    course: Annotated[
        float,
        Entry("of the leg, clockwise from true north, without drift; null at a start", "deg", scale=DEGREE, digits=3),
    ]
    length: Annotated[float, Entry("of the leg", "m", key="leg", digits=3)]
    duration: Annotated[float, Entry("length over speed, with the acceleration from rest", "s", digits=1)]
    duration_p99: Annotated[
        float, Entry("99 % of the trials take at most this for the leg of this number, with corrections", "s", digits=1)
    ]
    elapsed: Annotated[
        float,
        Entry(
            "since the mission's start, nominally: legs, surfacings, release, hold and galvanic release, without dive "
            "and ascent",
            "s",
            digits=1,
        ),
    ]
    is_via: bool = False
    """Whether it is a point on the way that the transit goes round by: it is arrived at as the goal is."""

    @property
    def time_out(self) -> float:
        """Time after which the leg has failed, in whole seconds: the longer of its durations and a tenth [s]."""
        return time_out(self.duration, self.duration_p99)

    @property
    def leg_time_out(self) -> Annotated[float | None, Entry(unit="s", key="time_out", after="duration_p99")]:
        """Time after which the leg has failed: a tenth more than the longer of the two; none at a start."""
        return None if self.kind == "start" else self.time_out


def time_out(nominal: float, p99: float) -> float:
    """Return the time-out of a duration, whole seconds [s]."""
    longest = nominal if math.isnan(p99) else max(nominal, p99)
    return float(math.ceil(TIME_OUT_MARGIN * longest - 1e-9))


Ring = tuple[tuple[float, float], ...]
"""Latitude and longitude of corners, the first one not repeated."""


@dataclass(frozen=True)
class Fence(Record):
    """A zone that the vehicle keeps out of; its limits are infinite where it holds always, or at all depths."""

    name: Annotated[str, Entry("of the zone")]
    outline: Ring
    """[rad]"""
    kind: Annotated[Literal["land", "keep-out"], Entry("what it is")] = "keep-out"
    holes: tuple[Ring, ...] = ()
    """Of the water inside it [rad]."""
    since: Annotated[
        float, Entry("when it begins to hold, since the mission's start; null: always", "s", key="from")
    ] = -math.inf
    until: Annotated[float, Entry("until when it holds; null: for ever", "s", key="to")] = math.inf
    above: Annotated[float, Entry("it holds at depths less than this; null: at all", "m")] = math.inf
    below: Annotated[float, Entry("it holds at depths greater than this; null: at all", "m")] = -math.inf

    @property
    def outline_in_degrees(self) -> Annotated[list[tuple[float, float]], Entry(key="outline_deg", after="kind")]:
        """Latitude and longitude of its corners, the first one not repeated."""
        return _in_degrees(self.outline)

    @property
    def holes_in_degrees(
        self,
    ) -> Annotated[list[list[tuple[float, float]]], Entry(key="holes_deg", after="outline_in_degrees")]:
        """Corners of the water inside it."""
        return [_in_degrees(hole) for hole in self.holes]

    @property
    def limits(self) -> dict[str, float]:
        """When and at which depths it holds, by the keys of a file: those limits that it has [s, m]."""
        limits = {"from_s": self.since, "to_s": self.until, "above_m": self.above, "below_m": self.below}
        return {key: value for key, value in limits.items() if math.isfinite(value)}


def _in_degrees(ring: Ring) -> list[tuple[float, float]]:
    return [(round(math.degrees(latitude), 8), round(math.degrees(longitude), 8)) for latitude, longitude in ring]


class PlaceInDegrees(NamedTuple):
    """A place on WGS 84 [deg]."""

    latitude_deg: float
    longitude_deg: float
