"""Hyperparameters of a navigation log: sizes and times, each by its logarithm, under a prior of a stated law."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from missionplan.arrays import Array
from missionplan.diagnosis.given import GivenEffect, tied
from missionplan.diagnosis.inference.marginal_likelihood import LOG_2PI
from missionplan.diagnosis.inference.prior import DOF

SOFT = 0.1
"""Width over which the prior falls off above a ceiling: searches need a slope [logarithm]."""
HyperparameterValues = Mapping[tuple[str, str], float]
"""Hyperparameters by effect and name, not their logarithms."""
Law = Literal["normal", "student", "reciprocal", "slab scale"]

SLAB_SCALE = "slab scale"
"""Name of the factor on the slabs of a cause in the mean, which is no parameter of the effect."""
WANDERING = (0.27, 2.5)
"""Size of an oscillation that wanders, over its usual size when steady: prior median and factor, assumed; an inertial
current of 4 cm/s, 1.6 to 10 cm/s in two of three records."""


@dataclass(frozen=True)
class Hyperparameter:
    """A hyperparameter by its logarithm."""

    effect: str
    name: str
    """Effect and parameter; no effect for the base model's own."""
    centre: float
    spread: float
    """Of the prior."""
    law: Law = "normal"
    """``normal``; ``student``, a Student-t distribution with `inference.prior.DOF` degrees of freedom; ``reciprocal``,
    the value's reciprocal uniform from nil to twice that at the centre, where `spread` is a scale for searches; or
    ``slab scale``, that of √λ in `inference.prior`: a slab of √λ standard deviations is then such a distribution."""
    ceiling: float = math.inf
    """Logarithm above which it is none of this hyperparameter's values."""

    @property
    def key(self) -> tuple[str, str]:
        """Effect and name."""
        return self.effect, self.name

    def log_prior(self, logarithm: float) -> float:
        """Log prior density of the logarithm."""
        above = max(logarithm - self.ceiling, 0.0)
        return self._log_density(logarithm) - (above / SOFT) ** 2

    def _log_density(self, logarithm: float) -> float:
        if self.law == "slab scale":
            half = 0.5 * DOF
            return (
                math.log(2.0)
                + half * math.log(half)
                - math.lgamma(half)
                - DOF * logarithm
                - half * math.exp(-2.0 * logarithm)
            )
        if self.law == "reciprocal":
            above = logarithm - (self.centre - math.log(2.0))
            return -above if above > 0.0 else -math.inf
        away = (logarithm - self.centre) / self.spread
        if self.law == "normal":
            return -0.5 * away**2 - math.log(self.spread) - 0.5 * LOG_2PI
        constant = math.lgamma(0.5 * (DOF + 1.0)) - math.lgamma(0.5 * DOF) - 0.5 * math.log(DOF * math.pi)
        return constant - math.log(self.spread) - 0.5 * (DOF + 1.0) * math.log1p(away**2 / DOF)


def slab_scale(effect: str) -> Hyperparameter:
    """Return the factor on the slabs of a cause."""
    return Hyperparameter(effect, SLAB_SCALE, 0.0, (2.0 * DOF) ** -0.5, "slab scale")


def wandering_scale(effect: str) -> Hyperparameter:
    """Return the factor on the slabs of an oscillation that wanders, which is its size."""
    median, factor = WANDERING
    return Hyperparameter(effect, SLAB_SCALE, math.log(median), math.log(factor), "student")


@dataclass(frozen=True)
class HyperparameterPrior:
    """Prior of h hyperparameters, some of which the mission's correlations tie to each other."""

    hyperparameters: tuple[Hyperparameter, ...]
    precision: Array | None = None
    """Shape (h, h). Inverse of the matrix of correlations, less the unit matrix; None where there are none."""
    log_factor: float = 0.0
    """Minus half the log determinant of that matrix."""

    @classmethod
    def of(cls, hyperparameters: tuple[Hyperparameter, ...], priors: Iterable[GivenEffect]) -> "HyperparameterPrior":
        """Join hyperparameters that are parameters of given effects as these are."""
        rho, place = np.eye(len(hyperparameters)), {h.key: i for i, h in enumerate(hyperparameters)}
        for prior in tied(priors):
            keys, variance = [(c.effect, c.name) for c in prior.coordinates], np.diag(prior.here)
            if set(keys) <= set(place) and np.count_nonzero(prior.here) > len(keys):
                indices = [place[key] for key in keys]
                rho[np.ix_(indices, indices)] = prior.here / np.sqrt(np.outer(variance, variance))
        if np.count_nonzero(rho) == len(rho):
            return cls(hyperparameters)
        return cls(hyperparameters, np.linalg.inv(rho) - np.eye(len(rho)), -0.5 * float(np.linalg.slogdet(rho)[1]))

    def log_density(self, logarithms: Array) -> float:
        """Log prior density of the logarithms."""
        density = sum(h.log_prior(value) for h, value in zip(self.hyperparameters, logarithms.tolist(), strict=True))
        if self.precision is None:
            return density
        away = (logarithms - [h.centre for h in self.hyperparameters]) / [h.spread for h in self.hyperparameters]
        return density + self.log_factor - 0.5 * float(away @ self.precision @ away)


def values_of(hyperparameters: Sequence[Hyperparameter], logarithms: Array) -> dict[tuple[str, str], float]:
    """Return hyperparameters by effect and name, from their logarithms."""
    return {h.key: math.exp(value) for h, value in zip(hyperparameters, logarithms.tolist(), strict=True)}
