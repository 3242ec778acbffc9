"""Interface of distributions that are transforms of one standard normal, and their truncation to a physical range.

The standard normal distribution restricted to an interval: draws, distribution function, moments of a transform.
"""

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property
from statistics import NormalDist

import numpy as np
import scipy
from typing_extensions import override

from missionplan.arrays import Array

_NORMAL_REACH = 12.0
"""Standard deviations beyond which the normal has no weight in double precision."""


def normal_cdf(z: float) -> float:
    """Distribution function of the standard normal, ½ erfc(-z/√2), of one number."""
    return 0.5 * math.erfc(-z / math.sqrt(2.0))


def normal_quantile(probability: float) -> float:
    """Quantile function of the standard normal, of one number (Wichura 1988, algorithm AS 241)."""
    if 0.0 < probability < 1.0:
        return NormalDist().inv_cdf(probability)
    return -math.inf if probability <= 0.0 else math.inf


def restricted_normal(z: Array, low: float, high: float) -> Array:
    """Map standard normals to normals restricted to [low, high], through their probabilities (inverse transform)."""
    if low > 0.0:  # the lower tail keeps digits that the upper one rounds away
        return -restricted_normal(-z, -high, -low)
    p_low, p_high = scipy.special.ndtr(low), scipy.special.ndtr(high)
    restricted: Array = scipy.special.ndtri(p_low + (p_high - p_low) * scipy.special.ndtr(z))
    return np.clip(restricted, low, high)


def restricted_cdf(z: float, low: float, high: float) -> float:
    """Distribution function at `z` of a standard normal restricted to [low, high]."""
    if low > 0.0:
        return 1.0 - restricted_cdf(-z, -high, -low)
    return (normal_cdf(min(max(z, low), high)) - normal_cdf(low)) / (normal_cdf(high) - normal_cdf(low))


def restricted_quantile(probability: float, low: float, high: float) -> float:
    """Quantile function of a standard normal restricted to [low, high], of one number."""
    if low > 0.0:
        return -restricted_quantile(1.0 - probability, -high, -low)
    p_low, p_high = normal_cdf(low), normal_cdf(high)
    return min(max(normal_quantile(p_low + (p_high - p_low) * probability), low), high)


@cache
def _gauss_legendre() -> tuple[Array, Array]:
    """Nodes and weights of a quadrature with 200 points."""
    return np.polynomial.legendre.leggauss(200)


def restricted_moments(transform: Callable[[Array], Array], low: float, high: float) -> tuple[float, float]:
    """Mean and standard deviation of a transform of a restricted normal, by 200-point Gauss–Legendre quadrature."""
    start, end = max(low, min(high, 0.0) - _NORMAL_REACH), min(high, max(low, 0.0) + _NORMAL_REACH)
    nodes, weights = _gauss_legendre()
    z = 0.5 * (start + end) + 0.5 * (end - start) * nodes
    nearest = min(max(0.0, start), end)
    weight = weights * np.exp(0.5 * (nearest**2 - z**2))
    weight /= weight.sum()
    values = transform(z)
    mean = float(weight @ values)
    return mean, math.sqrt(float(weight @ (values - mean) ** 2))


NEGLIGIBLE = 1e-20
"""Probability of a draw that no run will ever contain."""


class NormalTransform(ABC):
    """Interface of every distribution; `mean` and `sd` are those after any truncation."""

    @abstractmethod
    def from_normal(self, z: Array) -> Array:
        """Transform standard normals, any shape, into draws of the same shape."""

    @abstractmethod
    def cdf(self, value: float) -> float:
        """Probability of a draw at or below a value."""

    def quantile(self, probability: float) -> float:
        """Value that a draw stays below with a probability, of one number."""
        return float(self.from_normal(np.array(normal_quantile(probability))))

    @property
    def mass_cut(self) -> float:
        """Probability that truncation to the physical range has removed; 0 where there was none."""
        return 0.0

    def truncated(self, low: float = -math.inf, high: float = math.inf) -> "NormalTransform":
        """Truncate to the physical range of a quantity.

        Returns the distribution itself where the probability outside is below `NEGLIGIBLE`; else it is `mass_cut`.
        Raises ValueError when no part of the distribution lies inside.
        """
        below, above = _tails(self, low, high)
        if below + above < NEGLIGIBLE:
            return self
        if below + above >= 1.0:
            raise ValueError(f"no part of the distribution lies between {low:g} and {high:g}")
        return Truncated(self, low, high)


@dataclass(frozen=True)
class Truncated(NormalTransform):
    """A distribution truncated to the physical range of its quantity."""

    parent: NormalTransform
    low: float
    high: float

    @cached_property
    def _bounds(self) -> tuple[float, float]:
        below, above = _tails(self.parent, self.low, self.high)
        return float(scipy.special.ndtri(below)), -float(scipy.special.ndtri(above))

    @property
    @override
    def mass_cut(self) -> float:
        return sum(_tails(self.parent, self.low, self.high))

    @property
    def mean(self) -> float:
        """Mean after any truncation."""
        return restricted_moments(self.parent.from_normal, *self._bounds)[0]

    @property
    def sd(self) -> float:
        """Standard deviation after any truncation."""
        return restricted_moments(self.parent.from_normal, *self._bounds)[1]

    @override
    def from_normal(self, z: Array) -> Array:
        return np.clip(self.parent.from_normal(restricted_normal(z, *self._bounds)), self.low, self.high)

    @override
    def cdf(self, value: float) -> float:
        low, high = self._bounds
        return restricted_cdf(float(scipy.special.ndtri(self.parent.cdf(value))), low, high)

    @override
    def quantile(self, probability: float) -> float:
        below, above = _tails(self.parent, self.low, self.high)
        value = self.parent.quantile(below + (1.0 - below - above) * probability)
        return min(max(value, self.low), self.high)


def _tails(distribution: NormalTransform, low: float, high: float) -> tuple[float, float]:
    """Probabilities strictly below `low` and above `high`."""
    below = distribution.cdf(math.nextafter(low, -math.inf)) if low > -math.inf else 0.0
    above = 1.0 - distribution.cdf(high) if high < math.inf else 0.0
    return below, above
