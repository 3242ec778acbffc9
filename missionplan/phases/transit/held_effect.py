"""An effect on a transit that acts in some of the trials."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array, Scalars
from missionplan.phases.hooks import DriftParts, Leg, TransitEffect


@dataclass(frozen=True)
class HeldEffect(TransitEffect):
    """An effect where it holds; neutral in the other trials.

    Attributes
    ----------
    effect : TransitEffect
        Its parameters are floats or arrays over all trials, shape (n,).
    held : array of bool, shape (n,) or ()
        Whether it holds.
    """

    effect: TransitEffect
    held: NDArray[np.bool_]

    def velocity(self, leg: Leg) -> Array | float:
        """Mean velocity error over the leg [m/s]."""
        return self._terms(self.effect.velocity(leg))

    def course_factor(self, leg: Leg) -> NDArray[np.complex128] | Scalars:
        """Factor on the velocity through the water."""
        return np.where(self.held, self.effect.course_factor(leg), 1.0)

    @property
    def changes_course(self) -> bool:
        """Whether the effect refines `course_factor`."""
        return self.effect.changes_course

    def surface_velocity(self, t: Array, duration: Array, position: Array) -> Array | float:
        """Drift velocity at the surface [m/s]."""
        return self._terms(self.effect.surface_velocity(t, duration, position))

    def fix_variance(self) -> Scalars:
        """Extra variance of a fix, each axis [m²]."""
        return np.where(self.held, self.effect.fix_variance(), 0.0)

    def tail_dof(self) -> Scalars:
        """Degrees of freedom of a velocity error that is independent from leg to leg."""
        return np.where(self.held, self.effect.tail_dof(), np.inf)

    def error_scale(self, normals: Array) -> Array | float:
        """Factor on the leg's random velocity error."""
        return np.where(self.held, self.effect.error_scale(normals), 1.0)

    @property
    def is_random(self) -> bool:
        """Whether it needs standard normals for each leg."""
        return self.effect.is_random and bool(self.held.any())

    def step(
        self, memory: Array | None, elapsed: Array, normals: Array, leg: Leg
    ) -> tuple[Array | None, Array | float]:
        """Advance a random velocity from leg to leg; it is kept of all trials and felt where it holds."""
        memory, velocity = self.effect.step(memory, elapsed, normals, leg)
        return memory, self._terms(velocity)

    def drift(self) -> DriftParts:
        """What a filter of the drift may estimate of it: its parts, nil where it does not hold."""
        parts = self.effect.drift()
        persistent = parts.persistent
        return DriftParts(
            velocity=self._columns(parts.velocity),
            surface=self._columns(parts.surface),
            waves={period: self._columns(wave) for period, wave in parts.waves.items()},
            inertial=None if parts.inertial is None else self._columns(parts.inertial),
            persistent=None if persistent is None else (np.where(self.held, persistent[0], 0.0), persistent[1]),
            walk=np.where(self.held, parts.walk, 0.0),
            modulation=parts.modulation,
        )

    def _terms(self, value: Array | float) -> Array | float:
        return np.where(self.held, value, 0.0)

    def _columns(self, vector: Array | float) -> Array:
        """Components of a vector, or a number for all of them, in every trial; nil where the effect does not hold."""
        found = np.asarray(vector, dtype=float)
        return np.where(self.held, found if found.ndim > 1 else found.reshape(-1, 1), 0.0)
