"""Where the vehicle of a mission is: how it stands on its line at a mooring, and where if it does not come back."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING, Annotated, Final, Literal, get_args

import numpy as np

from missionplan.arrays import Array
from missionplan.results.entries import Entry, Record

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class HeldState(Record):
    """The vehicle on its line in one current."""

    current: Annotated[str, Entry("which, such as ``mean current``")]
    speed: Annotated[float, Entry("of the lowest layer", "m/s")]
    nose_altitude: Annotated[float, Entry("of the nose above the seafloor below it", "m")]
    tail_altitude: Annotated[float, Entry("of the tail above the seafloor below it", "m")]
    clearance: float
    """Of the hull's lowest point above the seafloor below it [m]."""
    excursion: Annotated[float, Entry("horizontal distance of the nose from the anchor", "m")]
    pitch: Annotated[float, Entry("elevation of the tail seen from the nose", "rad")]
    line_angle: Annotated[float, Entry("of the line to the vertical at the anchor", "rad")]
    tension_at_nose: Annotated[float, Entry("of the line at the nose", "N")]
    tension_at_anchor: Annotated[float, Entry("of the line at the anchor", "N")]
    anchor_drag: Annotated[float, Entry("the anchor's own", "N")]
    friction_needed: Annotated[
        float, Entry("holding factor with which the anchor just holds; null, here infinite, where none does")
    ]
    holding_margin: Annotated[float, Entry("see `seafloor.holding_margin`")]
    least_weight: Annotated[
        float, Entry("wet weight with which an anchor of this size just holds", "N", "least_wet_weight")
    ]
    line: Array
    """From the anchor to the nose: downstream and up; shape (k, 2) [m]."""
    tail: tuple[float, float]
    """Downstream and up from the anchor [m]."""
    uphill: float
    """Rise of the seafloor over a metre downstream."""

    @property
    def grounded(self) -> Annotated[bool, Entry()]:
        """Whether the hull lies on the seafloor."""
        return self.clearance <= 0.0


@dataclass(frozen=True)
class HeldVehicle(Record):
    """A mooring's vehicle on its line, distributions at their means."""

    phase: Annotated[str, Entry("name of the mooring")]
    length: float
    diameter: float
    """Of the hull [m]."""
    anchor_length: float
    anchor_diameter: float
    anchor_weight: float
    """[m, m, N]."""
    line_length: float
    """Line length [m]."""
    friction: Annotated[float, Entry("friction coefficient of the anchor on the seafloor", key="holding_factor")]
    friction_assumed: Annotated[
        bool, Entry("whether the vehicle file does not say how the anchor holds", key="holding_factor_assumed")
    ]
    centres_assumed: Annotated[
        bool, Entry("whether the vehicle file does not say where the centres of gravity and buoyancy are")
    ]
    if_polyester: Annotated[
        float | None,
        Entry(
            "in the worst current were the line, taken as weightless, of polyester; null where its weight is known, or "
            "it has no diameter",
            "m",
            "nose_altitude_if_polyester",
        ),
    ]
    states: Annotated[tuple[HeldState, ...], Entry("in the mean and in the worst current")]
    remedies: Annotated[
        tuple[str, ...], Entry("what is wrong in the worst current, and what would mend it, a sentence each")
    ]

    @property
    def line_weight_assumed(self) -> Annotated[bool, Entry()]:
        """Whether the line is taken as weightless."""
        return self.if_polyester is not None


SHARES = (0.5, 0.9, 0.95)
"""Of the trials that search areas hold."""
AFLOAT: Final = "adrift at the surface"
Way = Literal["not released", "adrift at the surface", "on the seafloor", "still under way"]
"""To be lost."""
WAYS: tuple[Way, ...] = get_args(Way)


class DriftAssumption(StrEnum):
    """What search areas take for granted, and what that means."""

    NO_WIND = "The mission has no wind: a vehicle afloat goes with the water alone (site.wind)."
    ERROR_OF_CURRENT = (
        "The mission does not say how far its current may be off: 0.1 m/s on each axis, forgotten over half a day."
    )
    STEADY_LAYERS = (
        "The current stays as the mission has it, for six hours overdue at most, in which a tide turns. Without a "
        "record, tide or tidal-current there are no areas for longer."
    )
    BEYOND_RECORD = (
        "Beyond the record of the current, or of the wind, its last values are held; those of the current for six "
        "hours, and there are no areas for longer."
    )
    NO_LAND = "Nothing stops a vehicle that drifts ashore."


@dataclass(frozen=True)
class ExpectedTime(Record):
    """When the vehicle is at the surface, over the trials that came so far.

    Times are since the mission's start; nan for a share that so few trials cannot tell.
    """

    name: Annotated[str, Entry("such as ``egress, surfacing 2``, or ``back``")]
    share: Annotated[float, Entry("of all trials that came so far")]
    p50: Annotated[float, Entry("by when half of these are there", "s")]
    p95: Annotated[float, Entry("by when 95 % of these are there", "s")]
    p99: Annotated[float, Entry("by when 99 % of these are there", "s")]
    p999: Annotated[float, Entry("by when 99.9 % of these are there", "s")]
    energy_left: Annotated[
        float, Entry("in the battery then, in all but 5 % of these trials; nan where energy is not computed", "W h")
    ]


@dataclass(frozen=True)
class SearchArea(Record):
    """The smallest area that holds the vehicle with some probability, if it was lost in one way."""

    way: Annotated[Way, Entry("of being lost")]
    after: Annotated[str, Entry("mooring at which it lies, or after which it drifts; empty for other ways")]
    overdue: Annotated[float, Entry("after the time at which to worry", "s")]
    share: Annotated[float, Entry("of the trials that it holds")]
    polygons: tuple[tuple[Array, ...], ...]
    """Its parts: closed rings east and north of the origin, the outer one first, then holes; shape (2, k) [m]."""
    centre_east: Annotated[float, Entry("mean of the places, east of the origin", "m")]
    centre_north: Annotated[float, Entry("mean of the places, north of the origin", "m")]
    densest_east: Annotated[float, Entry("where they are densest: where a search begins, east of the origin", "m")]
    densest_north: Annotated[float, Entry("where they are densest, north of the origin", "m")]
    half_length: Annotated[
        float, Entry("long half axis of the ellipse that would hold the share of a normal cloud, or radius", "m")
    ]
    half_width: Annotated[float, Entry("short half axis of that ellipse, or radius", "m")]
    toward: Annotated[float, Entry("direction of the long axis, clockwise from north", "rad")]
    missed: Annotated[float, Entry("probability that the searches so far miss it", key="missed_by_searches")]
    trials: Annotated[int, Entry("from which it is taken")]
    is_assumed: Annotated[bool, Entry("whether trials are assumed to be lost so, as too few are", key="assumed")]

    @property
    def area(self) -> Annotated[float, Entry(unit="m2", after="toward")]:
        """Area, without its holes."""
        return sum(_ring_area(rings[0]) - sum(map(_ring_area, rings[1:])) for rings in self.polygons)

    @property
    def points(self) -> Array:
        """All points of its outlines, shape (2, k) [m]."""
        return np.hstack([ring for rings in self.polygons for ring in rings])


def _ring_area(ring: Array) -> float:
    east, north = ring - ring[:, :1]
    return 0.5 * abs(float(np.sum(east * np.roll(north, -1) - np.roll(east, -1) * north)))


@dataclass(frozen=True)
class Overdue(Record):
    """What the boat needs to know if the vehicle does not come back."""

    times: Annotated[tuple[ExpectedTime, ...], Entry("of the surfacings in their order, the return last")]
    missing: Annotated[Mapping[str, float], Entry("share of the trials that never end, by the step at which they fail")]
    areas: Annotated[tuple[SearchArea, ...], Entry("way by way, by hours overdue")]
    searches: Annotated[int, Entry("searches that found nothing and are allowed for")] = 0
    assumptions: Annotated[tuple[DriftAssumption, ...], Entry("what the areas rest on, in words")] = ()

    @property
    def worry_share(self) -> Annotated[float, Entry()]:
        """Largest share of the missions that come back whose time the trials can tell: 0.999 with enough of them."""
        back = self.times[-1]
        return 0.999 if math.isfinite(back.p999) else 0.99 if math.isfinite(back.p99) else 0.95

    @property
    def worry_after(self) -> Annotated[float, Entry(unit="s")]:
        """Time by which that share of the missions that come back is back [s]."""
        back = self.times[-1]
        return next(time for time in (back.p999, back.p99, back.p95) if math.isfinite(time))

    def to_frame(self) -> "pd.DataFrame":
        """One row per way and hours overdue."""
        from pandas import DataFrame

        return DataFrame([area.row() for area in self.areas])
