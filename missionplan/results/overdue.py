"""If the vehicle does not come back: expected times, when to worry, and where to search."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated

import pandas as pd

from missionplan.arrays import Array
from missionplan.results.entries import Entry, Record

SHARE = 0.95
"""Of the trials that a search area holds."""


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
    """Where the vehicle is with `SHARE` certainty, if it failed in one way: within an ellipse.

    Attributes
    ----------
    line : array, shape (2, k)
        Its outline, closed, east and north of the origin [m].
    """

    way: Annotated[
        str, Entry("``not released``, ``adrift at the surface``, ``on the seafloor`` or ``still under way``")
    ]
    overdue: Annotated[float, Entry("after the time at which to worry", "s")]
    line: Array
    centre_east: Annotated[float, Entry("centre, east of the origin", "m")]
    centre_north: Annotated[float, Entry("centre, north of the origin", "m")]
    half_length: Annotated[float, Entry("major half axis, or the radius of a circle", "m")]
    half_width: Annotated[float, Entry("minor half axis, or the radius of a circle", "m")]
    trials: Annotated[int, Entry("from which it is taken")]
    assumed: Annotated[
        bool, Entry("whether these are trials that did not fail so: too few did, and the others are assumed to")
    ]

    @property
    def area(self) -> Annotated[float, Entry(unit="m2", after="half_width")]:
        """Area of the ellipse."""
        return math.pi * self.half_length * self.half_width


@dataclass(frozen=True)
class Overdue(Record):
    """What the boat needs to know if the vehicle does not come back.

    Attributes
    ----------
    beyond_record : bool
        Whether the drift goes beyond the record of the current, whose last values are held.
    """

    times: Annotated[tuple[ExpectedTime, ...], Entry("of the surfacings in their order, the return last")]
    missing: Annotated[Mapping[str, float], Entry("share of the trials that never end, by the step at which they fail")]
    areas: Annotated[tuple[SearchArea, ...], Entry("way by way, by hours overdue")]
    beyond_record: bool = False

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

    def to_frame(self) -> pd.DataFrame:
        """One row per way and hours overdue."""
        return pd.DataFrame([area.row() for area in self.areas])
