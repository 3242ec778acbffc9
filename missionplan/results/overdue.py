"""If the vehicle does not come back: expected times, when to worry, and where to search."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import pandas as pd

from missionplan.arrays import Array

SHARE = 0.95
"""Of the trials that a search area holds."""


@dataclass(frozen=True)
class ExpectedTime:
    """When the vehicle is at the surface, over the trials that came so far.

    Attributes
    ----------
    name : str
        Such as ``egress, surfacing 2``, or ``back``.
    share : float
        Of all trials that came so far.
    p50, p95, p99, p999 : float
        Since the mission's start [s]; nan for a share that so few trials cannot tell.
    energy_left : float
        In the battery then, in all but 5 % of these trials [W h]; nan where energy is not computed.
    """

    name: str
    share: float
    p50: float
    p95: float
    p99: float
    p999: float
    energy_left: float


@dataclass(frozen=True)
class SearchArea:
    """Where the vehicle is with `SHARE` certainty, if it failed in one way.

    Attributes
    ----------
    way : str
        ``not released``, ``adrift at the surface``, ``on the seafloor`` or ``still under way``.
    overdue : float
        After the time at which to worry [s].
    line : array, shape (2, k)
        Closed, east and north of the origin [m].
    centre : (float, float)
        [m]
    half_length, half_width : float
        Half axes of the ellipse, or the radius of the circle [m].
    trials : int
        From which it is taken.
    assumed : bool
        Whether these are trials that did not fail so: too few did, and the others are assumed to.
    """

    way: str
    overdue: float
    line: Array
    centre: tuple[float, float]
    half_length: float
    half_width: float
    trials: int
    assumed: bool

    @property
    def area(self) -> float:
        """[m²]."""
        return math.pi * self.half_length * self.half_width

    def row(self) -> dict[str, object]:
        """Row of `search-areas.csv`."""
        return {
            "way": self.way,
            "overdue_s": self.overdue,
            "centre_east_m": self.centre[0],
            "centre_north_m": self.centre[1],
            "half_length_m": self.half_length,
            "half_width_m": self.half_width,
            "area_m2": self.area,
            "trials": self.trials,
            "assumed": self.assumed,
        }


@dataclass(frozen=True)
class Overdue:
    """What the boat needs to know if the vehicle does not come back.

    Attributes
    ----------
    times : tuple of ExpectedTime
        Of the surfacings in their order, the return last.
    missing : mapping of str to float
        Share of the trials that never end, by the step at which they fail.
    areas : tuple of SearchArea
        Way by way, by hours overdue.
    beyond_record : bool
        Whether the drift goes beyond the record of the current, whose last values are held.
    """

    times: tuple[ExpectedTime, ...]
    missing: Mapping[str, float]
    areas: tuple[SearchArea, ...]
    beyond_record: bool = False

    @property
    def worry_share(self) -> float:
        """Largest share of the missions that come back whose time the trials can tell: 0.999 with enough of them."""
        back = self.times[-1]
        return 0.999 if math.isfinite(back.p999) else 0.99 if math.isfinite(back.p99) else 0.95

    @property
    def worry_after(self) -> float:
        """Time by which that share of the missions that come back is back [s]."""
        back = self.times[-1]
        return next(time for time in (back.p999, back.p99, back.p95) if math.isfinite(time))

    def summary(self) -> dict[str, object]:
        """Return the part of `summary.json`."""
        return {
            "worry_after_s": self.worry_after,
            "worry_share": self.worry_share,
            "times": [
                {
                    "name": time.name,
                    "share": time.share,
                    "p50_s": time.p50,
                    "p95_s": time.p95,
                    "p99_s": time.p99,
                    "p999_s": time.p999,
                    "energy_left_wh": time.energy_left,
                }
                for time in self.times
            ],
            "missing": dict(self.missing),
            "areas": [area.row() for area in self.areas],
        }

    def to_frame(self) -> pd.DataFrame:
        """One row per way and hours overdue."""
        return pd.DataFrame([area.row() for area in self.areas])
