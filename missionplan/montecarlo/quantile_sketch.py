"""Quantiles of a stream in bounded memory: counts in bins of nearly equal ratio, merged exactly in any order."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

_CUT = 42  # of the 52 bits of a mantissa: 1024 bins between a power of 2 and the next
_SMALLEST = 2.0**-30  # magnitudes below count as zero
_BELOW = (int(np.float64(_SMALLEST).view(np.int64)) >> _CUT) - 1  # makes the numbers of positive bins positive
_DENSE = 8  # times as many bins as values are counted without sorting them


@dataclass(frozen=True)
class QuantileSketch:
    """Counts in bins of nearly equal ratio: quantiles to 0.05 % of their value.

    A bin is what shares sign, exponent and the first ten bits of the mantissa, 1024 bins between a power of 2 and the
    next (DDSketch of Masson, Rim & Lee 2019 with their linear interpolation for the logarithm): its middle is within
    2⁻¹¹ of all that it holds. Finding a bin takes no logarithm, only whole numbers, so that it is fast and the same on
    every machine. Counts are integers too: merging is exact in any order. Only bins in use are kept: some ten thousand
    a decade-spanning quantity, however many the trials.

    Attributes
    ----------
    bins : integers, shape (k,)
        Bin numbers in use, ascending: negative values, zero, positive values.
    counts : integers, shape (k,)
    """

    bins: Integers
    counts: Integers

    @classmethod
    def of(cls, values: Array) -> "QuantileSketch":
        """Sketch one block, shape (n,); nan is left out."""
        missing = np.isnan(values)
        return cls._of_all(values[~missing] if missing.any() else values)

    @classmethod
    def _of_all(cls, values: Array) -> "QuantileSketch":
        """Sketch values none of which is nan."""
        magnitude = np.abs(values, dtype=np.float64)
        numbers = (magnitude.view(np.int64) >> _CUT) - _BELOW
        np.copyto(numbers, 0, where=magnitude < _SMALLEST)
        np.negative(numbers, out=numbers, where=values < 0.0)
        return cls._counted(numbers)

    @classmethod
    def _counted(cls, numbers: Integers) -> "QuantileSketch":
        if not numbers.size:
            return cls(numbers, numbers)
        lowest, highest = int(numbers.min()), int(numbers.max())
        if highest - lowest < _DENSE * numbers.size:  # counting is faster than sorting
            counts = np.bincount(numbers - lowest)
            used = np.flatnonzero(counts)
            return cls(used + lowest, counts[used])
        return cls(*np.unique(numbers, return_counts=True))

    def merge(self, other: "QuantileSketch") -> "QuantileSketch":
        """Add another block."""
        if not (self.bins.size and other.bins.size):
            return self if self.bins.size else other
        lowest = min(self.bins[0], other.bins[0])
        size = int(max(self.bins[-1], other.bins[-1]) - lowest) + 1
        if size < _DENSE * (self.bins.size + other.bins.size):
            counts = np.zeros(size, dtype=np.int64)
            counts[self.bins - lowest] = self.counts
            counts[other.bins - lowest] += other.counts
            used = np.flatnonzero(counts)
            return QuantileSketch(used + lowest, counts[used])
        bins, place = np.unique(np.concatenate((self.bins, other.bins)), return_inverse=True)
        counts = np.zeros(len(bins), dtype=np.int64)
        np.add.at(counts, place, np.concatenate((self.counts, other.counts)))
        return QuantileSketch(bins, counts)

    def bounds(self) -> tuple[Array, Array]:
        """Give the ends of each bin in use, ascending, shape (k,) each."""
        near, far = _ends(np.abs(self.bins))
        low = np.where(self.bins > 0, near, np.where(self.bins < 0, -far, -_SMALLEST))
        high = np.where(self.bins > 0, far, np.where(self.bins < 0, -near, _SMALLEST))
        return low, high

    def quantile(self, probability: float) -> float:
        """Give a quantile, within 0.05 % of an order statistic next to it; nan when empty."""
        return self.quantiles((probability,))[0]

    def quantiles(self, probabilities: Sequence[float]) -> list[float]:
        """Give several quantiles, each within 0.05 % of an order statistic next to it; nan when empty."""
        if not len(self.bins):
            return [math.nan] * len(probabilities)
        reached = np.cumsum(self.counts)
        ranks = np.asarray(probabilities) * (reached[-1] - 1)
        numbers = self.bins[np.searchsorted(reached, ranks, side="right")]
        near, far = _ends(np.abs(numbers))
        middles = np.where(numbers == 0, 0.0, np.copysign(0.5 * (near + far), numbers))
        return [float(middle) for middle in middles]


def _ends(number: Integers) -> tuple[Array, Array]:
    """Ends of the bins of positive values."""
    first = (np.asarray(number, dtype=np.int64) + _BELOW) << _CUT
    return first.view(np.float64), (first + (1 << _CUT)).view(np.float64)
