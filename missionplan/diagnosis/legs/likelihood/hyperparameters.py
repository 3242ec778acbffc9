"""Hyperparameters of a navigation log: sizes and times, each by its logarithm, under a prior of a stated law."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from missionplan.arrays import Array
from missionplan.diagnosis.inference.marginal_likelihood import LOG_2PI
from missionplan.diagnosis.inference.prior import DOF

HyperparameterValues = Mapping[tuple[str, str], float]
"""Hyperparameters by effect and name, not their logarithms."""
Law = Literal["normal", "student", "slab scale"]

SLAB_SCALE = "slab scale"
"""Name of the factor on the slabs of a cause in the mean, which is no parameter of the effect."""
WANDERING = (0.27, 2.5)
"""Size of an oscillation that wanders, over its usual size when steady: prior median and factor, assumed; an inertial
current of 4 cm/s, 1.6 to 10 cm/s in two of three records."""


@dataclass(frozen=True)
class Hyperparameter:
    """A hyperparameter by its logarithm.

    Attributes
    ----------
    effect, name : str
        Effect and parameter; no effect for the base model's own.
    centre, spread : float
        Of the prior.
    law : str
        ``normal``; ``student``, a Student-t distribution with `inference.prior.DOF` degrees of freedom; or ``slab
        scale``, that of √λ in `inference.prior`: a slab of √λ standard deviations is then such a distribution.
    """

    effect: str
    name: str
    centre: float
    spread: float
    law: Law = "normal"

    @property
    def key(self) -> tuple[str, str]:
        """Effect and name."""
        return self.effect, self.name

    def log_prior(self, logarithm: float) -> float:
        """Log prior density of the logarithm."""
        if self.law == "slab scale":
            half = 0.5 * DOF
            return (
                math.log(2.0)
                + half * math.log(half)
                - math.lgamma(half)
                - DOF * logarithm
                - half * math.exp(-2.0 * logarithm)
            )
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


def log_prior(hyperparameters: Sequence[Hyperparameter], logarithms: Array) -> float:
    """Log prior density of the logarithms."""
    return sum(h.log_prior(value) for h, value in zip(hyperparameters, logarithms.tolist(), strict=True))


def values_of(hyperparameters: Sequence[Hyperparameter], logarithms: Array) -> dict[tuple[str, str], float]:
    """Return hyperparameters by effect and name, from their logarithms."""
    return {h.key: math.exp(value) for h, value in zip(hyperparameters, logarithms.tolist(), strict=True)}
