"""A log whose clock does not keep time."""

from dataclasses import dataclass

import numpy as np

from missionplan.arrays import Array, Scalars, row_and_next
from missionplan.effects.finding import Finding
from missionplan.effects.info import EffectInfo, Instrument, Parameter
from missionplan.phases.hooks import DescentEffect


@dataclass(frozen=True)
class ClockRate(DescentEffect):
    """The log counts ``1 + fraction`` seconds in a second since the separation."""

    fraction: Scalars = 0.0

    def reading(self, t: Array, depth: Array) -> Array:
        """Return the depth at the true times, linear between those of the grid and straight beyond its end [m]."""
        rates = np.broadcast_to(1.0 + np.asarray(self.fraction, dtype=float), depth.shape[1:])
        place = np.arange(float(len(t))).reshape(-1, *(1,) * (depth.ndim - 1)) / rates
        row = np.minimum(place.astype(np.intp), len(depth) - 2)
        low, high = row_and_next(depth, row)
        return np.asarray((1.0 - (place - row)) * low + (place - row) * high)


INFO = EffectInfo(
    id="clock-rate",
    phase="descent",
    tier="physical",
    effect=ClockRate,
    parameters={
        "fraction": Parameter(
            "", "relative error of the clock's rate, fast positive", -0.2, 0.2, scale=0.01, spike=2e-4
        )
    },
    what="The log's clock runs fast or slow: times are counted in samples that are not taken as often as stated.",
    finding=Finding(
        "fraction",
        "the log's clock runs {size} fast",
        "the log's clock runs {size} slow",
        remedy="compare it with a watch over an hour and correct the log; the plan stays as it is",
        in_percent=True,
    ),
    sizes="A crystal keeps time to 0.01 %; oscillators without one, and loops that wait between samples, to 1 to 5 %.",
    confused_with=("depth-scale", "drag-bias", "vertical-current"),
    distinguished_by="The log against a watch; dives whose line takes long to pay out.",
    changes_plan=False,
    follows_law=True,
    instrument=Instrument("the log's clock against a watch for an hour", "fraction", 5e-4, 60.0),
)
