"""Streaming statistics of several quantities of the same trials together: the overhead occurs once per block."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from typing_extensions import override

from missionplan.arrays import Array
from missionplan.montecarlo.quantile_sketch import EMPTY_SKETCH, QuantileSketch, bin_number
from missionplan.montecarlo.statistics import Moments, RunningStatistic


@dataclass(frozen=True)
class RunningStatistics(Mapping[str, RunningStatistic]):
    """Moments and quantiles so far of several quantities of the same trials, computed and merged together.

    Attributes
    ----------
    names : tuple of str
    moments : Moments, shape (k,)
    sketches : tuple of QuantileSketch
    """

    names: tuple[str, ...]
    moments: Moments
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
