"""A tidal current at one place: a mean and waves at some depths, linear between them; it has no end in time."""

from dataclasses import dataclass

import numpy as np
from typing_extensions import override

from missionplan.arrays import Array, Scalars
from missionplan.phases.recorded_currents import RecordedCurrent

EVER = np.array([-np.inf, np.inf])
"""The times of a current that has no end [s]."""


@dataclass(frozen=True)
class TidalStream(RecordedCurrent):
    """A mean current and waves ``C·cos(ωt) + S·sin(ωt)``, the same at every place; `time` is `EVER`.

    Attributes
    ----------
    mean : array, shape (2, m)
        East and north at each depth [m/s].
    frequency : array, shape (k,)
        ω [rad/s].
    cosine, sine : array, shape (2, k, m)
        C and S, east and north at each depth [m/s].
    """

    mean: Array
    frequency: Array
    cosine: Array
    sine: Array

    @override
    def velocity(self, t: Scalars, depth: Scalars, position: Array) -> Array:
        return self._average(t, 0.0, depth) * self._known(0.0, depth, position)

    @override
    def mean_velocity(self, t: Scalars, duration: Scalars, depth: Scalars, start: Array, through: Array) -> Array:
        return self._average(t, duration, depth) * self._known(0.0, depth, start)

    def _average(self, t: Scalars, duration: Scalars, depth: Scalars) -> Array:
        """Mean over a time, exact: a wave's is its value at the middle, times sin(x)/x with x = ω·duration/2."""
        at = np.atleast_1d(depth)
        share = np.stack([np.interp(at, self.depth, node) for node in np.eye(len(self.depth))])
        middle = self.frequency[:, None] * (np.asarray(t) + 0.5 * np.asarray(duration))
        kept = np.sinc(self.frequency[:, None] * np.asarray(duration) / (2.0 * np.pi))
        waves = (self.cosine @ share) * np.cos(middle) + (self.sine @ share) * np.sin(middle)
        return np.asarray(self.mean @ share + np.sum(waves * kept, axis=1))
