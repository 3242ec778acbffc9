"""Velocity errors that change all the time and persist from leg to leg: their means over the legs."""

from dataclasses import dataclass

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.phases.hooks import Leg, TransitEffect


@dataclass(frozen=True)
class MarkovVelocity(TransitEffect):
    """Velocity error of one Markov process in time on each axis, felt as its mean over each leg.

    A leg's mean does not tell the process at the leg's end: what is known of that, the means so far given, is carried
    from leg to leg by the Kalman filter without measurement noise, so that one normal an axis draws each leg's mean
    from its distribution given all those before (innovations form: Durbin & Koopman 2012, *Time Series Analysis by
    State Space Methods*, section 4.3).
    """

    @property
    def is_random(self) -> bool:
        """It needs standard normals for each leg."""
        return True

    def transition(self, elapsed: Array) -> tuple[Array, Array]:
        """Share of the velocity that is kept over a time [s], and the variance that is added [m²/s²]."""
        raise NotImplementedError

    @property
    def first_variance(self) -> Scalars:
        """Variance where a run begins [m²/s²]."""
        raise NotImplementedError

    def mean_over(self, duration: Array) -> tuple[Array, Array]:
        """Mean over a time [s] given the values at its ends: the share of their sum, and its variance [m²/s²]."""
        raise NotImplementedError

    def step(self, memory: Array | None, elapsed: Array, normals: Array, leg: Leg) -> tuple[Array, Array]:
        """Draw the mean over a leg given those before it.

        Memory: mean (two rows) and variance of the velocity at the end of the last leg, and that leg's duration.
        """
        expected, variance = self._at_start(memory, elapsed, normals, leg)
        kept, added = self.transition(leg.duration)
        share, rest = self.mean_over(leg.duration)
        of_mean = np.square(share) * (np.square(1.0 + kept) * variance + added) + rest
        of_end = share * ((1.0 + kept) * kept * variance + added)
        innovation = np.sqrt(of_mean) * normals
        gain = of_end / np.where(of_mean > 0.0, of_mean, 1.0)
        end = kept * expected + gain * innovation
        left = np.maximum(np.square(kept) * variance + added - gain * of_end, 0.0)
        return np.stack([*end, left, leg.duration]), share * (1.0 + kept) * expected + innovation

    def _at_start(self, memory: Array | None, elapsed: Array, normals: Array, leg: Leg) -> tuple[Array, Array]:
        """Mean, shape (2, n), and variance, shape (n,), of the velocity at a leg's start, the means so far given."""
        if memory is None:
            return np.zeros_like(normals), np.broadcast_to(self.first_variance, leg.duration.shape)
        between = np.maximum(elapsed - 0.5 * (memory[3] + leg.duration), 0.0)
        kept, added = self.transition(between)
        return kept * memory[:2], np.square(kept) * memory[2] + added
