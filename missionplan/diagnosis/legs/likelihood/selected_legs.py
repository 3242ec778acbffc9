"""Likelihoods of the legs of a linearised log at many hyperparameters, what they share computed once."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from missionplan.arrays import Array
from missionplan.diagnosis.inference.marginal_likelihood import Marginal, student_marginal
from missionplan.diagnosis.legs.likelihood.linearised import LinearisedLegs
from missionplan.diagnosis.legs.likelihood.markov_covariance import MarkovCovariance
from missionplan.phases.hooks import MarkovProcess

MIN_DOF = 2.02
"""Degrees of freedom at and below which a Student-t error has practically no variance."""
KEPT_GRAMS = 8
"""Most inner products kept: a gradient by differences needs those of a point and of each step along a noise."""
NoiseKey = tuple[float | MarkovProcess | None, ...]


@dataclass(frozen=True)
class NoiseComponents:
    """Parts of the errors' covariance."""

    white: Array
    """Variance of the velocity error that is the same on every leg, on each axis, shape (2,) [m²/s²]."""
    walk: float
    """Growth of the variance of the position error under way, each axis [m²/s]."""
    fix_sd: float
    """Standard deviation of a fix, each axis [m]."""
    process: MarkovProcess | None
    """Error that persists from leg to leg."""
    dof: float
    """Degrees of freedom of the errors; infinite: normal."""

    @cached_property
    def key(self) -> NoiseKey:
        """What distinguishes it from other noises of normal errors."""
        return (*self.white.tolist(), self.walk, self.fix_sd, self.process)

    def independent(self, under_way: Array) -> Array:
        """Variance of the velocity error that no other leg shares, fixes apart, shape (2, n) [m²/s²]."""
        return np.asarray(self.white[:, None] + self.walk / under_way)


@dataclass(frozen=True)
class SelectedLegs:
    """Some legs of a linearised log."""

    linear: LinearisedLegs
    """The log."""
    legs: MarkovCovariance
    """Covariance between the n legs."""
    joined: Array
    """Their columns and, last, data, shape (2, n, k + 1)."""
    _grams: dict[NoiseKey, tuple[Array, float]] = field(default_factory=dict)

    @property
    def count(self) -> int:
        """Number of data."""
        return 2 * int(self.joined.shape[1])

    def gram(self, noise: NoiseComponents) -> tuple[Array, float]:
        """Inner products of whitened columns and data, and ln |covariance|; those of the last few noises are kept."""
        if noise.key not in self._grams:
            while len(self._grams) >= KEPT_GRAMS:
                del self._grams[next(iter(self._grams))]
            independent = noise.independent(self.legs.under_way)
            self._grams[noise.key] = self.legs.gram(self.joined, independent, noise.fix_sd, noise.process)
        return self._grams[noise.key]

    def student(self, noise: NoiseComponents, prior_sd: Array) -> Marginal:
        """Marginalise the coefficients under errors with heavy tails."""
        if noise.dof <= MIN_DOF:
            raise np.linalg.LinAlgError("the variance of the errors does not exist")
        variance = noise.independent(self.legs.under_way) + noise.fix_sd**2 * self.legs.fix_variance()
        return student_marginal(self.joined[:, :, -1], self.joined[:, :, :-1], prior_sd, variance, noise.dof)
