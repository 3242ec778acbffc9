"""Interface of distributions that are transforms of one standard normal, and their truncation to a physical range."""

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy
from typing_extensions import override

from missionplan.arrays import Array
from missionplan.montecarlo.restricted_normal import (
    normal_quantile,
    restricted_cdf,
    restricted_moments,
    restricted_normal,
)

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

        Raises
        ------
        ValueError
            When no part of the distribution lies inside.
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
