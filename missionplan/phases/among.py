"""An effect on some of the trials of a descent, for calls in which each trial has causes of its own."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from missionplan.phases.hooks import Array, DescentEffect, Scalars


@dataclass(frozen=True)
class Among(DescentEffect):
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
        return self._spread(self.effect.lone_drag_factor(), 1.0)

    def drag_factor(self, since_taut: Scalars, speed: Scalars) -> Scalars:
        """Factor on both bodies' drag."""
        return self._spread(self.effect.drag_factor(self._own(since_taut), self._own(speed)), 1.0)

    def wet_weight_factor(self, since_separation: Scalars) -> Scalars:
        """Factor on the anchor's wet weight."""
        return self._spread(self.effect.wet_weight_factor(self._own(since_separation)), 1.0)

    def lift(self, depth: Scalars) -> Scalars:
        """Upward force on the vehicle [N]."""
        return self._spread(self.effect.lift(self._own(depth)), 0.0)

    def mass_factor(self) -> Scalars:
        """Factor on the joint mass."""
        return self._spread(self.effect.mass_factor(), 1.0)

    def water_velocity(self) -> Scalars:
        """Downward velocity of the water [m/s]."""
        return self._spread(self.effect.water_velocity(), 0.0)

    def delay(self, line_length: Scalars) -> Scalars:
        """Time by which everything comes late [s]."""
        return self._spread(self.effect.delay(self._own(line_length)), 0.0)

    def reading(self, t: Array, depth: Array) -> Array:
        """Depth that the sensor reads [m]."""
        result = depth.copy()
        result[:, self.trials] = self.effect.reading(t, depth[:, self.trials])
        return result

    def _own(self, value: Scalars) -> Scalars:
        """What the trials that feel the effect have of an argument."""
        return value[..., self.trials] if isinstance(value, np.ndarray) else value

    def _spread(self, value: Scalars, neutral: float) -> Array:
        result = np.full(self.count, neutral)
        result[self.trials] = value
        return result
