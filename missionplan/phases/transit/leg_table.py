"""Leg length as a table against the distance left."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array


@dataclass(frozen=True)
class LegTable:
    """Leg length against distance left: linear between the knots, held at the ends, never beyond the target (Eq. 19).

    Attributes
    ----------
    left : array, shape (k,)
        Distance left, increasing [m].
    leg : array, shape (k,)
        Leg length, positive [m].
    """

    left: Array
    leg: Array

    def __call__(self, left: Array) -> Array:
        """Leg length for each distance left [m]."""
        return np.minimum(left, np.interp(left, self.left, self.leg))

    @property
    def kinks(self) -> Array:
        """Distances left at which the leg length changes its slope, ascending [m]."""
        knots = np.concatenate((self.left, [max(self.left[-1], self.leg[-1]) + 1.0]))
        excess = knots - np.interp(knots, self.left, self.leg)
        before, after = excess[:-1], excess[1:]
        crossed = before * after < 0.0
        share = before[crossed] / (before[crossed] - after[crossed])
        crossings = knots[:-1][crossed] + share * np.diff(knots)[crossed]
        below = [self.leg[0]] if 0.0 < self.leg[0] < self.left[0] else []
        return np.unique(np.concatenate((self.left, crossings, below)))


@dataclass(frozen=True)
class LegTables:
    """Several tables, each for some of the trials: what lets many plans of legs run at once.

    Attributes
    ----------
    tables : sequence of LegTable
    ends : array of int, shape (k,)
        Trial before which each table's trials end, the next table's begin; increasing.
    """

    tables: Sequence[LegTable]
    ends: NDArray[np.intp]

    def __call__(self, left: Array) -> Array:
        """Leg length for each distance left, one per trial [m]."""
        parts = np.split(left, self.ends[:-1])
        return np.concatenate([table(part) for table, part in zip(self.tables, parts, strict=True)])

    def take(self, trials: NDArray[np.intp]) -> "LegTables":
        """Select trials, given in ascending order; tables that are left without trials are dropped."""
        ends = np.searchsorted(trials, self.ends)
        used = np.flatnonzero(np.diff(ends, prepend=0))
        return LegTables([self.tables[index] for index in used.tolist()], ends[used])
