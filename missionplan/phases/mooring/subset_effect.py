"""An effect on a subset of the trials of a descent, for calls in which trials have different effects."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array, Scalars
from missionplan.phases.hooks import DescentEffect


@dataclass(frozen=True)
class SubsetEffect(DescentEffect):
    """An effect on a subset of the trials; it is neutral to the others and not computed for them."""

    effect: DescentEffect
    """Its parameters are floats or arrays over the subset, shape (m,)."""
    trials: NDArray[np.intp]
    """Indices of the subset, shape (m,)."""
    count: int
    """Number n of all trials."""

    def refines(self, hook: str) -> bool:
        """Whether the effect refines a hook."""
        return self.effect.refines(hook)

    def lone_drag_factor(self) -> Scalars:
        """Factor on the anchor's drag while it falls alone."""
        return self._factors(self.effect.lone_drag_factor())

    def drag_factor(self, since_taut: Scalars, speed: Scalars) -> Scalars:
        """Factor on both bodies' drag."""
        return self._factors(self.effect.drag_factor(self._subset(since_taut), self._subset(speed)))

    def local_drag_factor(self, depth: Scalars, line_length: Scalars) -> Scalars:
        """Factor on both bodies' drag."""
        return self._factors(self.effect.local_drag_factor(self._subset(depth), self._subset(line_length)))

    def wet_weight_factor(self, since_separation: Scalars) -> Scalars:
        """Factor on the anchor's wet weight."""
        return self._factors(self.effect.wet_weight_factor(self._subset(since_separation)))

    def lift(self, depth: Scalars) -> Scalars:
        """Upward force on the vehicle [N]."""
        return self._terms(self.effect.lift(self._subset(depth)))

    def mass_factor(self) -> Scalars:
        """Factor on the joint mass."""
        return self._factors(self.effect.mass_factor())

    def water_velocity(self) -> Scalars:
        """Downward velocity of the water [m/s]."""
        return self._terms(self.effect.water_velocity())

    def delay(self, line_length: Scalars) -> Scalars:
        """Delay of everything after the separation [s]."""
        return self._terms(self.effect.delay(self._subset(line_length)))

    def reading(self, t: Array, depth: Array) -> Array:
        """Depth that the sensor reads [m]."""
        result = depth.copy()
        result[:, self.trials] = self.effect.reading(t, depth[:, self.trials])
        return result

    def _subset(self, value: Scalars) -> Scalars:
        """Values of an argument for the subset."""
        return value.take(self.trials, axis=-1) if isinstance(value, np.ndarray) else value

    @cached_property
    def _ones(self) -> Array:
        return np.ones(self.count)

    def _factors(self, value: Scalars) -> Array:
        """Factors of all trials, 1 outside the subset."""
        result = self._ones.copy()  # three times as fast as a new array of ones
        result[self.trials] = value
        return result

    def _terms(self, value: Scalars) -> Array:
        """Terms of all trials, 0 outside the subset."""
        result = np.zeros(self.count)
        result[self.trials] = value
        return result
