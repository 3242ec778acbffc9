"""Streaming statistics: bounded memory, merged in the fixed order of the blocks, so that bits do not depend on jobs.

A value that is nan belongs to a trial that never reached the quantity: it is left out and counted.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

_CUT = 42  # of the 52 bits of a mantissa: 1024 bins between a power of 2 and the next
_SMALLEST = 2.0**-30  # magnitudes below count as zero
_BELOW = (int(np.float64(_SMALLEST).view(np.int64)) >> _CUT) - 1  # makes the numbers of positive bins positive
_DENSE = 8  # times as many bins as values are counted without sorting them
_Z95 = 1.959963984540054


@dataclass(frozen=True)
class Statistic:
    """What is reported of a quantity; nan where no trial, or for the sd fewer than two, reached it.

    Attributes
    ----------
    mean, sd, p05, p50, p95 : float
        In the quantity's unit.
    standard_error : float
        Of the mean.
    count, missing : int
        Trials that reached the quantity, and that did not.
    """

    mean: float
    sd: float
    p05: float
    p50: float
    p95: float
    standard_error: float
    count: int
    missing: int = 0

    def summary(self) -> dict[str, float | None]:
        """Give the form of ``summary.json``; None for what is not known."""
        names = ("mean", "sd", "p05", "p50", "p95", "standard_error")
        values = {name: getattr(self, name) for name in names}
        return {name: value if math.isfinite(value) else None for name, value in values.items()}


@dataclass(frozen=True)
class Probability:
    """A probability with its 95 % Wilson interval."""

    value: float
    low: float
    high: float

    def summary(self) -> dict[str, float]:
        """Give the form of ``summary.json``."""
        return {"value": self.value, "low": self.low, "high": self.high}


def wilson(successes: int, trials: int) -> Probability:
    """Estimate a probability with its 95 % Wilson score interval (Wilson 1927).

    With no trials the value is nan and the interval all of [0, 1].
    """
    if trials == 0:
        return Probability(math.nan, 0.0, 1.0)
    share, spread = successes / trials, _Z95**2 / trials
    centre = (share + 0.5 * spread) / (1.0 + spread)
    half = _Z95 * math.sqrt(share * (1.0 - share) / trials + 0.25 * spread / trials) / (1.0 + spread)
    low = 0.0 if successes == 0 else max(0.0, centre - half)
    high = 1.0 if successes == trials else min(1.0, centre + half)
    return Probability(share, low, high)


@dataclass(frozen=True)
class Count:
    """Trials in which something happened, of those in which it could."""

    successes: int = 0
    trials: int = 0

    @classmethod
    def of(cls, happened: NDArray[np.bool_]) -> "Count":
        """Count one block, shape (n,)."""
        return cls(int(np.count_nonzero(happened)), int(happened.size))

    def merge(self, other: "Count") -> "Count":
        """Add another block."""
        return Count(self.successes + other.successes, self.trials + other.trials)

    def probability(self) -> Probability:
        """Estimate the probability."""
        return wilson(self.successes, self.trials)


@dataclass(frozen=True)
class Moments:
    """Count, mean, variance and range along the last axis, of one quantity or of an array of them.

    Attributes
    ----------
    count : integers, shape (...)
        Values that are not nan.
    missing : integers, shape (...)
        Values that are.
    mean : array, shape (...)
    squares : array, shape (...)
        Sum of squared deviations from the mean.
    low, high : array, shape (...)
        Smallest and largest value; infinite (wrong way round) where there is none.
    """

    count: Integers
    missing: Integers
    mean: Array
    squares: Array
    low: Array
    high: Array

    @classmethod
    def of(cls, values: Array) -> "Moments":
        """Take the moments of one block, shape (..., n)."""
        reached = ~np.isnan(values)
        if values.size and reached.all():
            return cls._of_all(values)
        count = np.count_nonzero(reached, axis=-1)
        kept = np.where(reached, values, 0.0)
        mean = kept.sum(axis=-1) / np.maximum(count, 1)
        deviations = np.where(reached, values - mean[..., None], 0.0)
        return cls(
            count=np.asarray(count, dtype=np.int64),
            missing=np.asarray(values.shape[-1] - count, dtype=np.int64),
            mean=np.asarray(mean),
            squares=np.asarray(np.square(deviations).sum(axis=-1)),
            low=np.asarray(np.min(np.where(reached, values, math.inf), axis=-1, initial=math.inf)),
            high=np.asarray(np.max(np.where(reached, values, -math.inf), axis=-1, initial=-math.inf)),
        )

    @classmethod
    def _of_all(cls, values: Array) -> "Moments":
        """Take the moments of values none of which is nan, in fewer passes."""
        count = np.full(values.shape[:-1], values.shape[-1], dtype=np.int64)
        mean = values.mean(axis=-1)
        deviations = values - mean[..., None]
        squares = np.einsum("...t,...t->...", deviations, deviations)
        low, high = values.min(axis=-1), values.max(axis=-1)
        return cls(count, np.zeros_like(count), *map(np.asarray, (mean, squares, low, high)))

    def merge(self, other: "Moments") -> "Moments":
        """Add another block (Chan, Golub & LeVeque 1983, Eq. 2.1)."""
        count = self.count + other.count
        total = np.maximum(count, 1)
        step = other.mean - self.mean
        return Moments(
            count=count,
            missing=self.missing + other.missing,
            mean=self.mean + step * (other.count / total),
            squares=self.squares + other.squares + step**2 * (self.count * (other.count / total)),
            low=np.minimum(self.low, other.low),
            high=np.maximum(self.high, other.high),
        )

    def take(self, which: slice | int) -> "Moments":
        """Select some of an array of quantities."""
        return Moments(
            self.count[which],
            self.missing[which],
            self.mean[which],
            self.squares[which],
            self.low[which],
            self.high[which],
        )

    @property
    def variance(self) -> Array:
        """Unbiased variance; nan below two values."""
        return np.where(self.count > 1, self.squares / np.maximum(self.count - 1, 1), math.nan)

    @property
    def standard_error(self) -> Array:
        """Standard error of the mean; nan below two values."""
        return np.sqrt(self.variance / np.maximum(self.count, 1))


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
        if missing.any():
            values = values[~missing]
        magnitude = np.abs(values)
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
        if not len(self.bins):
            return math.nan
        reached = np.cumsum(self.counts)
        rank = probability * (reached[-1] - 1)
        place = np.searchsorted(reached, rank, side="right")
        number = self.bins[place]
        if number == 0:
            return 0.0
        near, far = _ends(np.abs(number))
        return math.copysign(0.5 * (float(near) + float(far)), number)


def _ends(number: Integers) -> tuple[Array, Array]:
    """Ends of the bins of positive values."""
    first = (np.asarray(number, dtype=np.int64) + _BELOW) << _CUT
    return first.view(np.float64), (first + (1 << _CUT)).view(np.float64)


@dataclass(frozen=True)
class RunningStatistic:
    """Moments and quantiles of one quantity so far."""

    moments: Moments
    sketch: QuantileSketch

    @classmethod
    def of(cls, values: Array) -> "RunningStatistic":
        """Take one block, shape (n,)."""
        return cls(Moments.of(values), QuantileSketch.of(values))

    @classmethod
    def of_each(cls, quantities: Mapping[str, Array]) -> "dict[str, RunningStatistic]":
        """Take one block of several quantities, shape (n,) each, at once: the same as one by one, and quicker."""
        if not quantities:
            return {}
        rows = np.stack(list(quantities.values()))
        complete = ~np.isnan(rows).any(axis=-1)
        found = {}
        for alike in (complete, ~complete):  # rows that nan is missing from take fewer passes
            moments = Moments.of(rows[alike])
            for place, index in enumerate(np.flatnonzero(alike)):
                found[int(index)] = cls(moments.take(place), QuantileSketch.of(rows[index]))
        return {name: found[index] for index, name in enumerate(quantities)}

    def merge(self, other: "RunningStatistic") -> "RunningStatistic":
        """Add the next block."""
        return RunningStatistic(self.moments.merge(other.moments), self.sketch.merge(other.sketch))

    def quantile(self, probability: float) -> float:
        """Give a quantile, within the values' range; nan when no trial reached the quantity."""
        value = self.sketch.quantile(probability)
        return min(max(value, float(self.moments.low)), float(self.moments.high)) if math.isfinite(value) else value

    def statistic(self) -> Statistic:
        """Give what is reported."""
        moments, any_reached = self.moments, bool(self.moments.count)
        return Statistic(
            mean=float(moments.mean) if any_reached else math.nan,
            sd=math.sqrt(float(moments.variance)),
            p05=self.quantile(0.05),
            p50=self.quantile(0.50),
            p95=self.quantile(0.95),
            standard_error=float(moments.standard_error),
            count=int(moments.count),
            missing=int(moments.missing),
        )
