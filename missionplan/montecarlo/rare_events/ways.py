"""Ways to fail, each driven for itself, and their probabilities combined with what they share.

A failure comes about in several ways i, each with a margin mᵢ that is negative where it does. One scalar over all of
them, such as the least of the margins over their standard deviations, is no measure of nearness: where a margin is
skewed or bounded, a pilot on it follows one way and never meets another that is more probable. So subset simulation is
run on each margin by itself, whose order among trials is all that it uses, so that neither unit nor distribution of a
margin matters. With K(u) the number of ways in which trial u fails,

    P(F) = Σᵢ E[1{mᵢ ≤ 0} / K],

so that what several ways share counts once. What fails with no margin negative, K = 0, is a further way: it is led by
all margins together, each as a reliability index −Φ⁻¹ of its rank among plain trials.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.montecarlo.rare_events.strata import StrataView, Stratum
from missionplan.montecarlo.rare_events.subset_simulation import Groups, NormalPopulation

_LEAST = float(np.finfo(float).tiny)
"""Margin of a trial that does not fail in a way whose margin is not positive."""


@dataclass(frozen=True)
class TrialMargins:
    """How near trials came to each way to fail."""

    by_way: Array
    """Negative or zero where the trial fails so, the smaller the nearer; nan where it never came so far; shape (ways,
    n)."""
    failed: NDArray[np.bool_]
    """Whether it fails at all, shape (n,)."""

    @property
    def fails_by(self) -> NDArray[np.bool_]:
        """Whether each trial fails in each way, shape (ways, n)."""
        return np.asarray(self.failed & (self.by_way <= 0.0))


Model = Callable[[StrataView], TrialMargins]
"""Runs one trial for each of a population."""


@dataclass(frozen=True)
class ReliabilityIndices:
    """Margins as standard deviations of a normal, by their ranks among plain trials."""

    margins: Sequence[Array]
    scores: Sequence[Array]
    """Of each way: margins of plain trials in ascending order, without ties, and the normal scores of their ranks;
    empty where fewer than two differ."""

    @classmethod
    def of(cls, plain: TrialMargins) -> "ReliabilityIndices":
        """Rank the margins of plain trials; those that are not finite do not count."""
        found = [np.unique(row[np.isfinite(row)], return_counts=True) for row in plain.by_way]
        ranked = [(values, (np.cumsum(counts) - 0.5 * counts) / counts.sum()) for values, counts in found]
        useful = [(values, shares) if values.size > 1 else (values[:0], shares[:0]) for values, shares in ranked]
        return cls(
            tuple(values for values, _ in useful),
            tuple(np.asarray(scipy.special.ndtri(shares)) for _, shares in useful),
        )

    def nearest(self, by_way: Array) -> Array:
        """Return the least distance of trials from a margin of zero, shape (n,); infinite without any margin.

        Parameters
        ----------
        by_way : array, shape (ways, n)
        """
        least = np.full(by_way.shape[1], np.inf)
        for row, margins, scores in zip(by_way, self.margins, self.scores, strict=True):
            if margins.size:
                least = np.fmin(least, _score(row, margins, scores) - _score(np.zeros(1), margins, scores))
        return least


def _score(values: Array, margins: Array, scores: Array) -> Array:
    """Normal score of margins; below the least of plain trials on the line through it and the lower decile."""
    tenth = min(max(1, margins.size // 10), margins.size - 1)
    slope = (scores[tenth] - scores[0]) / (margins[tenth] - margins[0])
    inside = np.interp(values, margins, scores)
    scored = np.where(values < margins[0], scores[0] + slope * (values - margins[0]), inside)
    return np.where(np.isnan(values), np.nan, scored)


@dataclass(frozen=True, eq=False)
class WayDrive:
    """Drives groups of trials, each in a stratum and towards one way to fail."""

    model: Model
    strata: Sequence[Stratum]
    """Of each group."""
    ways: Sequence[int]
    """Number of each group's margin; as many as there are for what fails with no margin negative."""
    indices: ReliabilityIndices

    def __call__(self, population: NormalPopulation, groups: Groups) -> tuple[Array, Array]:
        """Return the margin of each trial, and what it counts: one over the ways in which it fails."""
        trials = self.model(StrataView(population, [self.strata[group] for group in groups]))
        fails_by, chains = trials.fails_by, population.trials // groups.size
        count = fails_by.sum(axis=0)
        margins, fails = np.empty(population.trials), np.empty(population.trials, dtype=bool)
        for place, group in enumerate(groups):
            own, way = slice(place * chains, (place + 1) * chains), self.ways[group]
            if way == len(trials.by_way):
                fails[own] = trials.failed[own] & (count[own] == 0)
                margins[own] = self.indices.nearest(trials.by_way[:, own])
            else:
                fails[own], margins[own] = fails_by[way, own], trials.by_way[way, own]
        margins = np.where(np.isnan(margins), np.inf, np.maximum(margins, _LEAST))
        return np.where(fails, 0.0, margins), np.where(fails, 1.0 / np.maximum(count, 1), 0.0)
