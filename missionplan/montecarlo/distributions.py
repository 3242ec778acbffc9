"""Distributions of uncertain quantities, each a non-decreasing transform of one standard normal.

Drawing through normals makes common random numbers, correlations (a Cholesky factor on the normals) and truncation
(restricting the normal) the same few lines for every distribution.
"""

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import cast

import numpy as np
import scipy
from typing_extensions import override

from missionplan.arrays import Array
from missionplan.montecarlo.restricted_normal import (
    normal_cdf,
    normal_quantile,
    restricted_cdf,
    restricted_moments,
    restricted_normal,
    restricted_quantile,
)

NEGLIGIBLE = 1e-20
"""Probability of a draw that no run will ever contain."""


class NormalTransform(ABC):
    """Interface of every distribution, beside its `mean` and `sd`, which are those after any truncation."""

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

    def truncated(self, low: float = -math.inf, high: float = math.inf) -> "Distribution":
        """Truncate to the physical range of a quantity.

        Returns the distribution itself where the probability outside is below `NEGLIGIBLE`; else it is `mass_cut`.

        Raises
        ------
        ValueError
            When no part of the distribution lies inside.
        """
        whole = cast("Distribution", self)
        below, above = _tails(whole, low, high)
        if below + above < NEGLIGIBLE:
            return whole
        if below + above >= 1.0:
            raise ValueError(f"no part of the distribution lies between {low:g} and {high:g}")
        return Truncated(whole, low, high)


@dataclass(frozen=True)
class Normal(NormalTransform):
    """Normal distribution of given mean and standard deviation."""

    mean: float
    sd: float

    @override
    def from_normal(self, z: Array) -> Array:
        return self.mean + self.sd * z

    @override
    def cdf(self, value: float) -> float:
        return normal_cdf((value - self.mean) / self.sd) if self.sd > 0.0 else float(self.mean <= value)


@dataclass(frozen=True)
class TruncatedNormal(NormalTransform):
    """Normal distribution restricted to an interval, as a mission writes it.

    Attributes
    ----------
    parent_mean, parent_sd : float
        Mean and standard deviation before truncation; `mean` and `sd` are those after it.
    low, high : float
        Interval; infinite where it has no bound.
    """

    parent_mean: float
    parent_sd: float
    low: float = -math.inf
    high: float = math.inf

    @property
    def _bounds(self) -> tuple[float, float]:
        return (self.low - self.parent_mean) / self.parent_sd, (self.high - self.parent_mean) / self.parent_sd

    @property
    def mean(self) -> float:
        """Mean after any truncation."""
        return restricted_moments(Normal(self.parent_mean, self.parent_sd).from_normal, *self._bounds)[0]

    @property
    def sd(self) -> float:
        """Standard deviation after any truncation."""
        return restricted_moments(Normal(self.parent_mean, self.parent_sd).from_normal, *self._bounds)[1]

    @override
    def from_normal(self, z: Array) -> Array:
        inside = self.parent_mean + self.parent_sd * restricted_normal(z, *self._bounds)
        return np.clip(inside, self.low, self.high)

    @override
    def cdf(self, value: float) -> float:
        return restricted_cdf((value - self.parent_mean) / self.parent_sd, *self._bounds)

    @override
    def quantile(self, probability: float) -> float:
        value = self.parent_mean + self.parent_sd * restricted_quantile(probability, *self._bounds)
        return min(max(value, self.low), self.high)


@dataclass(frozen=True)
class Uniform(NormalTransform):
    """Uniform distribution between two bounds."""

    low: float
    high: float

    @property
    def mean(self) -> float:
        """Mean after any truncation."""
        return 0.5 * (self.low + self.high)

    @property
    def sd(self) -> float:
        """Standard deviation after any truncation."""
        return (self.high - self.low) / math.sqrt(12.0)

    @override
    def from_normal(self, z: Array) -> Array:
        return self.low + (self.high - self.low) * scipy.special.ndtr(z)

    @override
    def cdf(self, value: float) -> float:
        return min(1.0, max(0.0, (value - self.low) / (self.high - self.low)))

    @override
    def quantile(self, probability: float) -> float:
        return self.low + (self.high - self.low) * probability


@dataclass(frozen=True)
class LogNormal(NormalTransform):
    """Log-normal distribution: 68 % of draws lie within × or ÷ `factor` of the median."""

    median: float
    factor: float

    @property
    def mean(self) -> float:
        """Mean after any truncation."""
        return self.median * math.exp(0.5 * math.log(self.factor) ** 2)

    @property
    def sd(self) -> float:
        """Standard deviation after any truncation."""
        return self.mean * math.sqrt(math.expm1(math.log(self.factor) ** 2))

    @override
    def from_normal(self, z: Array) -> Array:
        return self.median * np.exp(math.log(self.factor) * z)

    @override
    def cdf(self, value: float) -> float:
        return normal_cdf(math.log(value / self.median) / math.log(self.factor)) if value > 0.0 else 0.0


@dataclass(frozen=True)
class Choices(NormalTransform):
    """One of several values, all equally likely (a value given twice is twice as likely).

    Attributes
    ----------
    values : tuple of float
    cut : float
        Probability of the values that earlier truncations have removed.
    """

    values: tuple[float, ...]
    cut: float = 0.0

    @property
    def mean(self) -> float:
        """Mean after any truncation."""
        return math.fsum(self.values) / len(self.values)

    @property
    def sd(self) -> float:
        """Standard deviation after any truncation."""
        return float(np.std(self.values))

    @override
    def from_normal(self, z: Array) -> Array:
        ordered = np.sort(np.asarray(self.values, dtype=float))
        index = np.minimum((scipy.special.ndtr(z) * len(ordered)).astype(np.intp), len(ordered) - 1)
        return ordered[index]

    @override
    def cdf(self, value: float) -> float:
        return sum(choice <= value for choice in self.values) / len(self.values)

    @property
    @override
    def mass_cut(self) -> float:
        return self.cut

    @override
    def truncated(self, low: float = -math.inf, high: float = math.inf) -> "Distribution":
        kept = tuple(value for value in self.values if low <= value <= high)
        if not kept:
            raise ValueError(f"no part of the distribution lies between {low:g} and {high:g}")
        return Choices(kept, 1.0 - (1.0 - self.cut) * len(kept) / len(self.values))


@dataclass(frozen=True)
class Truncated(NormalTransform):
    """A distribution truncated to the physical range of its quantity."""

    parent: "Distribution"
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


Distribution = Normal | TruncatedNormal | Uniform | LogNormal | Choices | Truncated
"""A scalar distribution: one draw per trial."""

Quantity = float | Distribution
"""A quantity of a mission file: a number, or a distribution of it."""


def mean_of(quantity: Quantity) -> float:
    """Return the mean of a distribution, or the number itself."""
    return quantity if isinstance(quantity, (float, int)) else quantity.mean  # faster to check than a distribution


def sd_of(quantity: Quantity) -> float:
    """Return the standard deviation of a distribution; 0 for a number."""
    return quantity.sd if isinstance(quantity, Distribution) else 0.0


def _tails(distribution: Distribution, low: float, high: float) -> tuple[float, float]:
    """Probabilities strictly below `low` and above `high`."""
    below = distribution.cdf(math.nextafter(low, -math.inf)) if low > -math.inf else 0.0
    above = 1.0 - distribution.cdf(high) if high < math.inf else 0.0
    return below, above
