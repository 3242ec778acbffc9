"""An effect on some of the trials of a descent, for calls in which each trial has causes of its own."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array, Scalars
from missionplan.phases.hooks import DescentEffect


@dataclass(frozen=True)
class SubsetEffect(DescentEffect):
    """An effect that some of the trials feel; to the others it is neutral, and they cost nothing.

    Attributes
    ----------
    effect : DescentEffect
        Its parameters are floats or arrays over the trials that feel it.
    trials : array of int, shape (m,)
        Which they are.
    count : int
        Number of all trials, n.
    """

    effect: DescentEffect
    trials: NDArray[np.intp]
    count: int

    def refines(self, hook: str) -> bool:
        """Whether the effect refines a hook."""
        return self.effect.refines(hook)

    def lone_drag_factor(self) -> Scalars:
        """Factor on the anchor's drag while it falls alone."""
        return self._factors(self.effect.lone_drag_factor())

    def drag_factor(self, since_taut: Scalars, speed: Scalars) -> Scalars:
        """Factor on both bodies' drag."""
        return self._factors(self.effect.drag_factor(self._own(since_taut), self._own(speed)))

    def wet_weight_factor(self, since_separation: Scalars) -> Scalars:
        """Factor on the anchor's wet weight."""
        return self._factors(self.effect.wet_weight_factor(self._own(since_separation)))

    def lift(self, depth: Scalars) -> Scalars:
        """Upward force on the vehicle [N]."""
        return self._terms(self.effect.lift(self._own(depth)))

    def mass_factor(self) -> Scalars:
        """Factor on the joint mass."""
        return self._factors(self.effect.mass_factor())

    def water_velocity(self) -> Scalars:
        """Downward velocity of the water [m/s]."""
        return self._terms(self.effect.water_velocity())

    def delay(self, line_length: Scalars) -> Scalars:
        """Time by which everything comes late [s]."""
        return self._terms(self.effect.delay(self._own(line_length)))

    def reading(self, t: Array, depth: Array) -> Array:
        """Depth that the sensor reads [m]."""
        result = depth.copy()
        result[:, self.trials] = self.effect.reading(t, depth[:, self.trials])
        return result

    def _own(self, value: Scalars) -> Scalars:
        """What the trials that feel the effect have of an argument."""
        return value.take(self.trials, axis=-1) if isinstance(value, np.ndarray) else value

    @cached_property
    def _ones(self) -> Array:
        return np.ones(self.count)

    def _factors(self, value: Scalars) -> Array:
        """Factors on all trials, 1 on those that do not feel the effect."""
        result = self._ones.copy()  # a third of the time of a new one
        result[self.trials] = value
        return result

    def _terms(self, value: Scalars) -> Array:
        """Terms of all trials, 0 for those that do not feel the effect."""
        result = np.zeros(self.count)
        result[self.trials] = value
        return result
