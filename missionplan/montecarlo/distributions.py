"""Distributions of uncertain quantities, each a non-decreasing transform of one standard normal.

Drawing through normals makes common random numbers, correlations (a Cholesky factor on the normals) and truncation
(restricting the normal) the same few lines for every distribution.
"""

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import scipy
from typing_extensions import override

from missionplan.arrays import Array
from missionplan.montecarlo.normal_transform import (
    NormalTransform,
    Truncated,
    normal_cdf,
    restricted_cdf,
    restricted_moments,
    restricted_normal,
    restricted_quantile,
)
from missionplan.montecarlo.posterior import DrawnColumn

ROUNDING = 1e-9
"""By how much probabilities written in a file may miss their sum."""


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
    """Normal distribution restricted to an interval, as a mission writes it."""

    parent_mean: float
    parent_sd: float
    """Mean and standard deviation before truncation; `mean` and `sd` are those after it."""
    low: float = -math.inf
    high: float = math.inf
    """Interval; infinite where it has no bound."""

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
    """One of several values, all equally likely (a value given twice is twice as likely)."""

    values: tuple[float, ...]
    cut: float = 0.0
    """Probability of the values that earlier truncations have removed."""

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
    def intervals(self) -> dict[float, tuple[float, float]]:
        """Where the probability of the normal gives each value."""
        ordered = np.sort(np.asarray(self.values, dtype=float))
        ends = {value: self.cdf(value) for value in ordered.tolist()}
        return dict(zip(ends, pairwise([0.0, *ends.values()]), strict=True))

    @property
    @override
    def mass_cut(self) -> float:
        return self.cut

    @override
    def truncated(self, low: float = -math.inf, high: float = math.inf) -> NormalTransform:
        kept = tuple(value for value in self.values if low <= value <= high)
        if not kept:
            raise ValueError(f"no part of the distribution lies between {low:g} and {high:g}")
        return Choices(kept, 1.0 - (1.0 - self.cut) * len(kept) / len(self.values))


@dataclass(frozen=True)
class WhichHolds(NormalTransform):
    """Which of several explanations of a mission holds, of which one at most does."""

    probabilities: tuple[float, ...]
    """Of each explanation; what they leave to 1 is the probability that none holds, drawn as their number."""

    @property
    def mean(self) -> float:
        """The likeliest: numbers of explanations have no mean, and a mission at its means must hold one of them."""
        left = 1.0 - math.fsum(self.probabilities)
        return float(np.argmax([*self.probabilities, left]))

    @property
    def sd(self) -> float:
        """Standard deviation of the number."""
        shares = np.array([*self.probabilities, max(1.0 - math.fsum(self.probabilities), 0.0)])
        numbers = np.arange(len(shares))
        return float(np.sqrt(np.sum(shares * numbers**2) - np.sum(shares * numbers) ** 2))

    @override
    def from_normal(self, z: Array) -> Array:
        ends = self._ends
        last = len(ends) - (ends[-1] == 1.0)  # where no draw may have none of them, not even one whose Φ rounds to 1
        return np.minimum(np.searchsorted(ends, scipy.special.ndtr(z), side="right"), last).astype(float)

    @override
    def cdf(self, value: float) -> float:
        if value < 0.0:
            return 0.0
        return self._ends[int(value)] if value < len(self._ends) else 1.0

    @property
    def intervals(self) -> dict[float, tuple[float, float]]:
        """Where the probability of the normal gives each number."""
        ends = self._ends if self._ends[-1] == 1.0 else [*self._ends, 1.0]
        return dict(zip(map(float, range(len(ends))), pairwise([0.0, *ends]), strict=True))

    @property
    def _ends(self) -> list[float]:
        """Cumulative probabilities; of the last 1 where the explanations leave nothing but rounding."""
        ends = np.cumsum(self.probabilities).tolist()
        return [*ends[:-1], 1.0 if ends[-1] > 1.0 - ROUNDING else ends[-1]]


@dataclass(frozen=True)
class Shifted(NormalTransform):
    """A distribution moved by a constant."""

    parent: "Distribution"
    by: float

    @property
    def mean(self) -> float:
        """Mean of the parent, moved."""
        return self.parent.mean + self.by

    @property
    def sd(self) -> float:
        """That of the parent."""
        return self.parent.sd

    @override
    def from_normal(self, z: Array) -> Array:
        return self.parent.from_normal(z) + self.by

    @override
    def cdf(self, value: float) -> float:
        return self.parent.cdf(value - self.by)


Distribution = Normal | TruncatedNormal | Uniform | LogNormal | Choices | Truncated | WhichHolds | DrawnColumn | Shifted
"""A scalar distribution: one draw per trial."""

Quantity = float | Distribution
"""A quantity of a mission file: a number, or a distribution of it."""


def mean_of(quantity: Quantity) -> float:
    """Return the mean of a distribution, or the number itself."""
    return quantity if isinstance(quantity, (float, int)) else quantity.mean  # faster to check than a distribution


def sd_of(quantity: Quantity) -> float:
    """Return the standard deviation of a distribution; 0 for a number."""
    return quantity.sd if isinstance(quantity, Distribution) else 0.0
