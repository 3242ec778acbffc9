"""Quantiles of a stream in bounded memory: counts in bins of nearly equal ratio, merged exactly in any order."""

import math
import struct
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array

Integers = NDArray[np.int64]

_CUT = 42  # of the 52 bits of a mantissa: 1024 bins between a power of 2 and the next
_BINS = 1 << (52 - _CUT)
_BIAS = 1023 + 52 - _CUT  # of the exponent, and of a mantissa in whole bins
_SMALLEST = 2.0**-30  # smaller magnitudes count as zero
_BELOW = (int(np.float64(_SMALLEST).view(np.int64)) >> _CUT) - 1  # makes the numbers of positive bins positive


@dataclass(frozen=True)
class QuantileSketch:
    """Counts in bins of nearly equal ratio: quantiles to 0.05 % of their value.

    The values of a bin share sign, exponent and the first ten bits of the mantissa: 1024 bins between a power of 2 and
    the next (DDSketch of Masson, Rim & Lee 2019 with their linear interpolation for the logarithm), the middle of each
    within 2⁻¹¹ of its values. Finding a bin takes integer operations but no logarithm, so that it is fast and the same
    on every machine. Counts are integers too: merging is exact in any order. All bins from the lowest in use to the
    highest are kept: about three thousand per decade, however many the trials.
    """

    first: int
    """Number of the first bin. Bins are numbered from negative values through zero (bin 0) to positive values."""
    counts: Integers
    """Counts from that bin on; neither the first nor the last is 0; shape (k,)."""

    @classmethod
    def of(cls, values: Array) -> "QuantileSketch":
        """Sketch one block, shape (n,); nan is ignored."""
        kept = np.asarray(values[~np.isnan(values)], dtype=np.float64)
        if not kept.size:
            return EMPTY_SKETCH
        return cls.between(bin_number(kept.min()), bin_number(kept.max()), kept)

    @classmethod
    def between(cls, first: int, last: int, values: Array) -> "QuantileSketch":
        """Sketch values, at least one and none of them nan, whose lowest and highest bins are known."""
        if first == last:
            return cls(first, np.array([values.size], dtype=np.int64))
        if first > 0:  # all values positive, none counted as zero
            numbers = values.view(np.int64) >> _CUT
            numbers -= _BELOW + first
        else:
            numbers = _bin_numbers(values)
            numbers -= first
        return cls(first, np.bincount(numbers))

    def merge(self, other: "QuantileSketch") -> "QuantileSketch":
        """Merge another block."""
        if not (self.counts.size and other.counts.size):
            return self if self.counts.size else other
        first = min(self.first, other.first)
        counts = np.zeros(max(self.first + self.counts.size, other.first + other.counts.size) - first, dtype=np.int64)
        for part in (self, other):
            start = part.first - first
            counts[start : start + part.counts.size] += part.counts
        return QuantileSketch(first, counts)

    def bins_in_use(self) -> tuple[Integers, Integers]:
        """Return the numbers of the bins in use, ascending, and their counts."""
        used = np.flatnonzero(self.counts)
        return used + self.first, self.counts[used]

    @classmethod
    def from_bins(cls, bins: Integers, counts: Integers) -> "QuantileSketch":
        """Build a sketch from the result of `bins_in_use`."""
        if not bins.size:
            return EMPTY_SKETCH
        spread = np.zeros(int(bins[-1] - bins[0]) + 1, dtype=np.int64)
        spread[bins - bins[0]] = counts
        return cls(int(bins[0]), spread)

    def bounds(self) -> tuple[Array, Array]:
        """Return the ends of each bin in use, ascending, shape (k,) each."""
        return _bounds(self.bins_in_use()[0])

    def count_below(self, limits: Array, low: float = -math.inf, high: float = math.inf) -> Array:
        """Count the values below each limit, in any order, as if each bin were filled evenly between low and high.

        `limits`, shape (m,). `low`, `high`: range of the values, where known.
        """
        last = self.first + self.counts.size - 1
        numbers = np.minimum(np.maximum(_bin_numbers(limits), self.first), last)
        start, end = (np.minimum(np.maximum(side, low), high) for side in _bounds(numbers))
        filled = np.minimum(np.maximum(limits, start), end) - start
        share = np.divide(filled, end - start, out=(limits >= start).astype(float), where=end > start)
        place = numbers - self.first
        below: Array = self._up_to[place] - self.counts[place] * (1.0 - share)
        return below

    @cached_property
    def _up_to(self) -> Integers:
        """Counts up to each bin, its own included."""
        return self.counts.cumsum()

    def quantiles(self, probabilities: Sequence[float]) -> list[float]:
        """Several quantiles, each within 0.05 % of an order statistic next to it; nan when empty."""
        if not self.counts.size:
            return [math.nan] * len(probabilities)
        last = int(self._up_to[-1]) - 1
        places = self._up_to.searchsorted([probability * last for probability in probabilities], side="right")
        return [_middle(self.first + place) for place in places.tolist()]


EMPTY_SKETCH = QuantileSketch(0, np.empty(0, dtype=np.int64))
"""Sketch of no values."""


def bin_number(value: float) -> int:
    """Number of the bin of one value that is not nan: as `_bin_numbers`, but faster."""
    bits: int = struct.unpack("<q", struct.pack("<d", abs(value)))[0]
    number = max((bits >> _CUT) - _BELOW, 0)
    return -number if value < 0.0 else number


def _bin_numbers(values: Array) -> Integers:
    """Numbers of the bins of values, any shape, none of them nan."""
    numbers: Integers = np.abs(values).view(np.int64) >> _CUT
    numbers -= _BELOW
    np.maximum(numbers, 0, out=numbers)  # magnitudes that count as zero
    np.negative(numbers, out=numbers, where=values < 0.0)
    return numbers


def _middle(number: int) -> float:
    """Middle of a bin."""
    if number == 0:
        return 0.0
    exponent, mantissa = divmod(abs(number) + _BELOW, _BINS)
    return math.copysign(math.ldexp(_BINS + mantissa + 0.5, exponent - _BIAS), number)


def _bounds(numbers: Integers) -> tuple[Array, Array]:
    """Ends of bins."""
    if numbers.size and numbers.min() > 0:
        return _ends(numbers)
    near, far = _ends(np.abs(numbers))
    low = np.where(numbers > 0, near, np.where(numbers < 0, -far, -_SMALLEST))
    high = np.where(numbers > 0, far, np.where(numbers < 0, -near, _SMALLEST))
    return low, high


def _ends(number: Integers) -> tuple[Array, Array]:
    """Ends of the bins of positive values."""
    first = (np.asarray(number, dtype=np.int64) + _BELOW) << _CUT
    return first.view(np.float64), (first + (1 << _CUT)).view(np.float64)
