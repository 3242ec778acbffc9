"""Streaming statistics: bounded memory, merged in the fixed order of the blocks, so that bits do not depend on jobs.

A nan belongs to a trial that never reached the quantity: it is excluded and counted.

Streaming statistics of several quantities of the same trials together: the overhead occurs once per block.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from missionplan.arrays import Array
from missionplan.montecarlo.quantile_sketch import EMPTY_SKETCH, QuantileSketch, bin_number

Integers = NDArray[np.int64]

_Z95 = 1.959963984540054


@dataclass(frozen=True)
class Statistic:
    """Reported statistics of a quantity; nan where no trial, or for the sd fewer than two, reached it."""

    mean: float
    sd: float
    p05: float
    p50: float
    p95: float
    """In the quantity's unit."""
    standard_error: float
    """Of the mean."""
    count: int
    missing: int = 0
    """Trials that reached the quantity, and that did not."""

    @classmethod
    def of_constant(cls, value: float, trials: int) -> "Statistic":
        """Statistics of one or more trials with the same value."""
        spread = 0.0 if trials > 1 else math.nan
        return cls(value, spread, value, value, value, spread, trials)

    def summary(self) -> dict[str, float | None]:
        """Entry of ``summary.json``; None for what is undefined."""
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
        """Entry of ``summary.json``."""
        return {"value": self.value, "low": self.low, "high": self.high}


def wilson(successes: int, trials: int) -> Probability:
    """Estimate a probability with its 95 % Wilson score interval (Wilson 1927).

    Without trials the value is nan and the interval [0, 1].
    """
    if trials == 0:
        return Probability(math.nan, 0.0, 1.0)
    share, spread = successes / trials, _Z95**2 / trials
    centre = (share + 0.5 * spread) / (1.0 + spread)
    half = _Z95 * math.sqrt(share * (1.0 - share) / trials + 0.25 * spread / trials) / (1.0 + spread)
    low = 0.0 if successes == 0 else max(0.0, centre - half)
    high = 1.0 if successes == trials else min(1.0, centre + half)
    return Probability(share, low, high)


def trials_to_decide(share: float, required: float) -> int | None:
    """Number of trials at which the Wilson interval about a share excludes a probability, if the share stays as it is.

    The interval is the score test's inverse: it excludes p where |share − p| > 1.96 √(p (1 − p)/n). None where the
    share is the probability itself, so that no number of trials would do.
    """
    if share == required:
        return None
    return math.floor(_Z95**2 * required * (1.0 - required) / (share - required) ** 2) + 1


def successes_to_decide(required: float, trials: int) -> int:
    """Least number of successes whose Wilson interval lies above a probability; may be more than there are trials.

    From the same test as `trials_to_decide`.
    """
    return math.floor(trials * required + _Z95 * math.sqrt(trials * required * (1.0 - required))) + 1


@dataclass(frozen=True)
class Count:
    """Number of trials in which an event happened, of those in which it could."""

    successes: int = 0
    trials: int = 0

    @classmethod
    def of(cls, happened: NDArray[np.generic]) -> "Count":
        """Count in one block, shape (n,)."""
        return cls(int(np.count_nonzero(happened)), int(happened.size))

    def merge(self, other: "Count") -> "Count":
        """Merge another block."""
        return Count(self.successes + other.successes, self.trials + other.trials)

    def probability(self) -> Probability:
        """Probability with its interval."""
        return wilson(self.successes, self.trials)


@dataclass(frozen=True)
class Moments:
    """Count, mean, variance and range along the last axis, of one quantity or of an array of them."""

    count: Integers
    """Values that are not nan, shape (...)."""
    missing: Integers
    """Values that are, shape (...)."""
    mean: Array
    """Mean, shape (...)."""
    squares: Array
    """Sum of squared deviations from the mean, shape (...)."""
    low: Array
    high: Array
    """Shape (...). Smallest and largest value; +∞ and −∞ where there is none."""

    @classmethod
    def of(cls, values: Array) -> "Moments":
        """Moments of one block, shape (..., n)."""
        sums = np.add.reduce(values, axis=-1)
        if not values.size:
            return cls._of_reached(values)
        moments = cls._of_all(values, sums)
        if any(map(math.isnan, sums.ravel().tolist())):  # faster than numpy for a handful
            broken = np.isnan(sums)
            moments._put(broken, cls._of_reached(values[broken]))
        return moments

    @classmethod
    def _of_all(cls, values: Array, sums: Array) -> "Moments":
        """Moments of values from their sums; nan where a value is."""
        mean = np.asarray(sums / values.shape[-1])
        deviations = values - mean[..., None]
        squares = np.einsum("...t,...t->...", deviations, deviations)
        low, high = np.minimum.reduce(values, axis=-1), np.maximum.reduce(values, axis=-1)
        count, missing = np.full(mean.shape, values.shape[-1]), np.zeros(mean.shape, dtype=np.int64)
        return cls(*map(np.asarray, (count, missing, mean, squares, low, high)))

    @classmethod
    def _of_reached(cls, values: Array) -> "Moments":
        """Moments of values some of which are nan, in more passes."""
        reached = ~np.isnan(values)
        count = np.asarray(np.count_nonzero(reached, axis=-1), dtype=np.int64)
        missing = values.shape[-1] - count
        if not count.any():
            zeros, infinite = np.zeros(count.shape), np.full(count.shape, math.inf)
            return cls(count, missing, zeros, zeros, infinite, -infinite)
        kept = np.where(reached, values, 0.0)
        mean = kept.sum(axis=-1) / np.maximum(count, 1)
        deviations = np.where(reached, values - mean[..., None], 0.0)
        return cls(
            count=count,
            missing=missing,
            mean=mean,
            squares=np.square(deviations).sum(axis=-1),
            low=np.min(np.where(reached, values, math.inf), axis=-1),
            high=np.max(np.where(reached, values, -math.inf), axis=-1),
        )

    def merge(self, other: "Moments") -> "Moments":
        """Merge another block (Chan, Golub & LeVeque 1983, Eq. 2.1)."""
        count = self.count + other.count
        share = other.count / np.maximum(count, 1)
        step = other.mean - self.mean
        return Moments(
            count=count,
            missing=self.missing + other.missing,
            mean=self.mean + step * share,
            squares=self.squares + other.squares + step * step * (self.count * share),
            low=np.minimum(self.low, other.low),
            high=np.maximum(self.high, other.high),
        )

    def take(self, which: slice | int) -> "Moments":
        """Select some of an array of quantities."""
        return Moments(*(getattr(self, field.name)[which] for field in fields(self)))

    def _put(self, which: NDArray[np.bool_], part: "Moments") -> None:
        """Write the moments of some quantities into the array, during construction."""
        for field in fields(self):
            getattr(self, field.name)[which] = getattr(part, field.name)

    @property
    def variance(self) -> Array:
        """Unbiased variance; nan below two values."""
        return np.where(self.count > 1, self.squares / np.maximum(self.count - 1, 1), math.nan)

    @property
    def standard_error(self) -> Array:
        """Standard error of the mean; nan below two values."""
        return np.sqrt(self.variance / np.maximum(self.count, 1))


@dataclass(frozen=True)
class RunningStatistic:
    """Moments and quantiles of one quantity so far."""

    moments: Moments
    sketch: QuantileSketch

    @classmethod
    def of(cls, values: Array) -> "RunningStatistic":
        """Statistics of one block, shape (n,)."""
        return cls(Moments.of(values), QuantileSketch.of(values))

    def merge(self, other: "RunningStatistic") -> "RunningStatistic":
        """Merge the next block."""
        return RunningStatistic(self.moments.merge(other.moments), self.sketch.merge(other.sketch))

    def quantile(self, probability: float) -> float:
        """Quantile, within the values' range; nan when no trial reached the quantity."""
        return self.quantiles((probability,))[0]

    def quantiles(self, probabilities: Sequence[float]) -> list[float]:
        """Several quantiles, within the values' range; nan when no trial reached the quantity."""
        values = self.sketch.quantiles(probabilities)
        low, high = float(self.moments.low), float(self.moments.high)
        return [min(max(value, low), high) if math.isfinite(value) else value for value in values]

    def count_below(self, limits: Array) -> Array:
        """Count the values below limits, as if each bin of the sketch were filled evenly: counts may be fractions.

        The part of a bin beyond the lowest or the highest value is empty.
        """
        return self.sketch.count_below(limits, float(self.moments.low), float(self.moments.high))

    def statistic(self) -> Statistic:
        """Statistics to report."""
        count = int(self.moments.count)
        p05, p50, p95 = self.quantiles((0.05, 0.50, 0.95))
        sd = math.sqrt(float(self.moments.squares) / (count - 1)) if count > 1 else math.nan
        return Statistic(
            mean=float(self.moments.mean) if count else math.nan,
            sd=sd,
            p05=p05,
            p50=p50,
            p95=p95,
            standard_error=sd / math.sqrt(max(count, 1)),
            count=count,
            missing=int(self.moments.missing),
        )


@dataclass(frozen=True)
class RunningStatistics(Mapping[str, RunningStatistic]):
    """Moments and quantiles so far of several quantities of the same trials, computed and merged together."""

    names: tuple[str, ...]
    moments: Moments
    """Moments, shape (k,)."""
    sketches: tuple[QuantileSketch, ...]

    @classmethod
    def of(cls, quantities: Mapping[str, Array]) -> "RunningStatistics":
        """Statistics of one block of quantities, shape (n,) each: the same as one by one, but faster."""
        rows = np.concatenate(list(quantities.values()), dtype=np.float64).reshape(len(quantities), -1)
        moments = Moments.of(rows)
        ranges = zip(moments.low.tolist(), moments.high.tolist(), moments.missing.tolist(), strict=True)
        sketches = (
            QuantileSketch.between(bin_number(low), bin_number(high), row[~np.isnan(row)] if missing else row)
            if low <= high
            else EMPTY_SKETCH
            for row, (low, high, missing) in zip(rows, ranges, strict=True)
        )
        return cls(tuple(quantities), moments, tuple(sketches))

    def merge(self, other: "RunningStatistics") -> "RunningStatistics":
        """Merge the next block, of the same quantities."""
        sketches = [mine.merge(theirs) for mine, theirs in zip(self.sketches, other.sketches, strict=True)]
        return RunningStatistics(self.names, self.moments.merge(other.moments), tuple(sketches))

    @override
    def __getitem__(self, name: str) -> RunningStatistic:
        try:
            place = self.names.index(name)
        except ValueError:
            raise KeyError(name) from None
        return RunningStatistic(self.moments.take(place), self.sketches[place])

    @override
    def __iter__(self) -> Iterator[str]:
        return iter(self.names)

    @override
    def __len__(self) -> int:
        return len(self.names)
