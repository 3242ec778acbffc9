"""Weighted draws of what was learned from data: the effects that hold together, their parameters, and how likely.

A posterior is kept as its draws, so that nothing between a diagnosis and a plan reduces it to moments. A trial draws
the number of one of them, from one normal: all its columns are then of that draw, and joint.
"""

import math
from collections.abc import Collection
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy
from numpy.typing import NDArray
from typing_extensions import override

from missionplan.arrays import Array
from missionplan.montecarlo.normal_transform import NormalTransform

Causes = tuple[str, ...]
Column = tuple[str, str]
"""Effect and parameter; of what belongs to no effect, an empty name and the quantity."""
Place = tuple[float, float, float]
"""Latitude, longitude [rad] and date [s since 1970]; nan where they are not known."""
NOWHERE: Place = (math.nan, math.nan, math.nan)


@dataclass(frozen=True, eq=False)
class DrawnColumn(NormalTransform):
    """One parameter of a posterior, as a distribution: a draw is picked by one normal, the same for all columns."""

    values: Array
    """Shape (n,)."""
    ends: Array
    """Shape (n,). Cumulative weights; the last is 1."""
    typical: float
    """What stands for it in a mission at its means: of an angle, and of a set of effects, there is no mean."""

    @property
    def mean(self) -> float:
        """What stands for it in a mission at its means."""
        return self.typical

    @property
    def weights(self) -> Array:
        """Of the draws."""
        return np.diff(self.ends, prepend=0.0)

    @property
    def sd(self) -> float:
        """Standard deviation of the draws about their mean."""
        centre = float(self.weights @ self.values)
        return math.sqrt(float(self.weights @ (self.values - centre) ** 2))

    @override
    def from_normal(self, z: Array) -> Array:
        places = np.searchsorted(self.ends, scipy.special.ndtr(z), side="right")
        return np.asarray(self.values[np.minimum(places, len(self.values) - 1)])

    @override
    def cdf(self, value: float) -> float:
        return float(self.weights[self.values <= value].sum())

    @override
    def quantile(self, probability: float) -> float:
        order = np.argsort(self.values)
        place = int(np.searchsorted(np.cumsum(self.weights[order]), probability))
        return float(self.values[order[min(place, len(order) - 1)]])


@dataclass(frozen=True, eq=False)
class Tied(NormalTransform):
    """A quantity that keeps its own distribution, and has the ranks of a posterior's column: the two are then joint."""

    own: NormalTransform
    """Its distribution."""
    scores: DrawnColumn
    """Normals by the ranks of the column."""

    @override
    def from_normal(self, z: Array) -> Array:
        return self.own.from_normal(self.scores.from_normal(z))

    @override
    def cdf(self, value: float) -> float:
        return self.own.cdf(value)


@dataclass(frozen=True, eq=False)
class WeightedDraws:
    """Draws of a posterior over sets of effects and their parameters, n of them."""

    sets: tuple[Causes, ...]
    """The effects that hold together, by the number of the set."""
    which: NDArray[np.int_]
    """Set of each draw, in ascending order, shape (n,)."""
    columns: tuple[Column, ...]
    """Length k."""
    values: Array
    """Shape (n, k). In SI; nan where the effect of the column does not hold."""
    weights: Array
    """Their sum is 1, shape (n,)."""

    @property
    def effects(self) -> Causes:
        """Every effect of a set."""
        return tuple(dict.fromkeys(effect for held in self.sets for effect in held))

    @cached_property
    def probabilities(self) -> tuple[float, ...]:
        """Of each set."""
        return tuple(np.bincount(self.which, self.weights, len(self.sets)).tolist())

    def probability(self, effect: str) -> float:
        """Probability that an effect holds."""
        return sum(p for held, p in zip(self.sets, self.probabilities, strict=True) if effect in held)

    def of_set(self, number: int) -> "WeightedDraws":
        """Return the draws of one set alone."""
        own = self.which == number
        weights = self.weights[own]
        which = np.zeros(len(weights), dtype=int)
        return WeightedDraws((self.sets[number],), which, self.columns, self.values[own], weights / weights.sum())

    def without(self, effects: Collection[str]) -> "WeightedDraws":
        """Return the draws without some effects: sets that differ in nothing else are one."""
        kept = [tuple(effect for effect in held if effect not in effects) for held in self.sets]
        sets = tuple(dict.fromkeys(kept))
        which = np.array([sets.index(held) for held in kept])[self.which]
        order = np.argsort(which, kind="stable")
        columns = [index for index, (effect, _) in enumerate(self.columns) if effect not in effects]
        return WeightedDraws(
            sets,
            which[order],
            tuple(self.columns[index] for index in columns),
            self.values[order][:, columns],
            self.weights[order],
        )

    def column(self, column: Column) -> tuple[Array, Array]:
        """Values of a column where it is known, and their weights, not normalised."""
        values = self.values[:, self.columns.index(column)]
        known = np.isfinite(values)
        return values[known], self.weights[known]

    def distribution(self, column: Column, typical: float) -> DrawnColumn:
        """Return a column as a distribution; a draw without its effect has some value of another draw."""
        values = self.values[:, self.columns.index(column)].astype(float)
        known = np.flatnonzero(np.isfinite(values))
        unknown = np.flatnonzero(~np.isfinite(values))
        values[unknown] = values[known[np.arange(len(unknown)) % len(known)]]
        ends = np.cumsum(self.weights)
        return DrawnColumn(values, ends / ends[-1], typical)

    def scores(self, column: Column) -> DrawnColumn:
        """Return a column as the normals by its ranks."""
        values = self.values[:, self.columns.index(column)]
        order = np.argsort(values)
        before = np.cumsum(self.weights[order]) - 0.5 * self.weights[order]
        normals = np.empty(len(values))
        normals[order] = scipy.special.ndtri(before)
        ends = np.cumsum(self.weights)
        return DrawnColumn(normals, ends / ends[-1], 0.0)
