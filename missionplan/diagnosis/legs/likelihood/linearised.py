"""A set of causes linearised about given coordinates, as the likelihood of a log takes it, and effects held there."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array, Scalars
from missionplan.diagnosis.inference.marginal_likelihood import Marginal
from missionplan.diagnosis.legs.likelihood.hyperparameters import SLAB_SCALE, HyperparameterValues
from missionplan.diagnosis.legs.likelihood.modulation import Modulation
from missionplan.phases.hooks import Leg, TransitEffect


@dataclass(frozen=True)
class CoordinatePrior:
    """Normal prior of k coordinates: mean, shape (k,), and lower factor L of the covariance L Lᵀ, shape (k, k)."""

    mean: Array
    factor: Array

    def posterior(self, marginal: Marginal) -> tuple[Array, Array]:
        """Return mean (k,) and covariance (k, k) of the coordinates from those of the standardised coefficients."""
        k = len(self.mean)
        mean = self.mean + self.factor @ marginal.mean[:k]
        return mean, self.factor @ marginal.covariance[:k, :k] @ self.factor.T


@dataclass(frozen=True)
class LinearisedLegs:
    """Linearised model of a set of causes: y ≈ columns·coefficients + noise, coefficients ~ N(0, 1) and independent."""

    about: Array
    """Coordinates about which it is linearised, shape (k,)."""
    prior: CoordinatePrior
    """Of the k coordinates, which are its mean plus its factor times the first k coefficients."""
    y: Array
    """Velocity errors less those at the prior means, on the principal axes, shape (2, n) [m/s]."""
    columns: Array
    """Of the coefficients: k for the coordinates, then m of the functions that modulate oscillations, shape (2, n, k +
    m)."""
    slabs: Mapping[str, list[int]]
    """By cause, the coefficients whose prior standard deviation its slab scale multiplies."""
    modulations: tuple[Modulation, ...]
    """Whose functions follow the coordinates, in their order."""

    def prior_sd(self, values: HyperparameterValues) -> Array:
        """Prior standard deviations of the coefficients, 1 but for slabs and modulations, shape (k + m,)."""
        sd = np.ones(len(self.about))
        for effect, places in self.slabs.items():
            sd[places] = values.get((effect, SLAB_SCALE), 1.0)
        for each in self.modulations:
            if each.effect in self.slabs:
                sd[self.slabs[each.effect]] *= each.mean_sd(values[each.keys[1]])
        of_functions = [each.sd(*(values[key] for key in each.keys)) for each in self.modulations]
        return np.concatenate([sd, *of_functions])

    @cached_property
    def joined(self) -> Array:
        """Columns and, last, data, shape (2, n, k + m + 1)."""
        return np.concatenate([self.columns, self.y[:, :, None]], axis=2)


class HeldEffect(TransitEffect):
    """An effect whose hooks for the legs of a log are computed once."""

    def __init__(self, effect: TransitEffect, leg: Leg) -> None:
        self._effect, self._leg = effect, leg

    @cached_property
    def _velocity(self) -> Array | float:
        return self._effect.velocity(self._leg)

    @cached_property
    def _factor(self) -> NDArray[np.complex128] | Scalars:
        return self._effect.course_factor(self._leg)

    def velocity(self, leg: Leg) -> Array | float:
        """Return the mean velocity error."""
        return self._velocity

    def course_factor(self, leg: Leg) -> NDArray[np.complex128] | Scalars:
        """Return the factor on the velocity through the water."""
        return self._factor

    @property
    def answers_current(self) -> bool:
        """Whether the effect does."""
        return self._effect.answers_current

    def answer_to_current(self, leg: Leg, water: Array) -> Array | float:
        """Return the answer to this current."""
        return self._effect.answer_to_current(leg, water)

    def surface_velocity(self, t: Array, duration: Array, position: Array) -> Array | float:
        """Return the drift at the surface."""
        return self._effect.surface_velocity(t, duration, position)
