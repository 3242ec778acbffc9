"""Which of several alternatives are as good as the best, by paired differences; and where a better one may lie.

Kriging: a smooth surface through values at some places, with how sure it is of itself anywhere.
A Gaussian process with a constant mean, a Matérn covariance (ν = 5/2) with a length along each axis, and a nugget for
the noise of the values; lengths and nugget are the likeliest of a lattice of powers of two (Rasmussen & Williams 2006,
Gaussian Processes for Machine Learning, chapters 2, 4 and 5). Values are standardised, so that prior deviations are 1.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from missionplan.arrays import Array

LEVEL = 0.05
"""Probability that the truly best is not among those called as good, for all alternatives together."""


@dataclass(frozen=True)
class PairedDifferences:
    """Alternatives against the one that looks best."""

    best: int
    worse: NDArray[np.float64]
    error: NDArray[np.float64]
    """Shape (k,). Mean of the differences trial by trial, positive where an alternative is worse, and its standard
    error."""
    as_good: NDArray[np.bool_]
    """Whether the trials leave open that an alternative is the best, shape (k,)."""


def compare_with_best(values: Sequence[NDArray[np.generic]], best: int, *, most: bool) -> PairedDifferences:
    """Compare alternatives with the one that looks best, trial by trial.

    Each of the other k − 1 is tested at the level LEVEL/(k − 1) (Bonferroni): the truly best is left out only where the
    one that looks best beats it significantly. Events are compared by the exact sign test of the trials that differ
    (McNemar 1947, Psychometrika 12, 153–157), numbers by the normal approximation of their mean difference.

    Parameters
    ----------
    values : sequence of array, shape (n,)
        By alternative, a trial in the same place: bool for events, else float, nan for a trial without a value. A pair
        counts where both have one.
    best : int
        The alternative that looks best.
    most : bool
        Whether more is better.
    """
    count = len(values)
    worse, error, p_values = (np.zeros(count) for _ in range(3))
    p_values[best] = 1.0
    for index in (index for index in range(count) if index != best):
        worse[index], error[index], p_values[index] = paired_difference(values[best], values[index], most=most)
    return PairedDifferences(best, worse, error, p_values >= LEVEL / max(count - 1, 1))


def paired_difference(
    best: NDArray[np.generic], other: NDArray[np.generic], *, most: bool
) -> tuple[float, float, float]:
    """Return by how much the other is worse, the standard error, and the one-sided p-value of its being as good."""
    sign = 1.0 if most else -1.0
    size = min(best.size, other.size)
    difference = sign * (best[:size].astype(float) - other[:size].astype(float))
    difference = difference[np.isfinite(difference)]
    if not difference.size:
        return float("nan"), float("nan"), 0.0  # nothing speaks for it
    mean = float(difference.mean())
    error = float(difference.std(ddof=1) / np.sqrt(difference.size)) if difference.size > 1 else float("nan")
    if best.dtype == bool:
        losses, wins = int((difference > 0.0).sum()), int((difference < 0.0).sum())
        return mean, error, float(scipy.special.bdtrc(losses - 1, losses + wins, 0.5)) if losses else 1.0
    if not error > 0.0:  # of one trial nan: nothing tells
        return mean, error, 0.0 if error == 0.0 and mean > 0.0 else 1.0
    return mean, error, float(scipy.special.ndtr(-mean / error))


def pareto_front(costs: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return which no other beats: costs, shape (k, m), as low in each and lower in one; nan is never one of them."""
    is_finite = np.asarray(np.isfinite(costs).all(axis=1))
    front = np.array(is_finite)
    for index in np.flatnonzero(is_finite):
        no_higher = (costs <= costs[index]).all(axis=1) & is_finite
        front[index] = not np.any(no_higher & (costs < costs[index]).any(axis=1))
    return front


_SHORTEST, _LONGEST = 1.0 / 16.0, 8.0
"""Lengths, of an axis that runs from 0 to 1."""
_LEAST_NUGGET, _MOST_NUGGET = 4.0**-10, 0.25
"""Variance of the noise, of that of the values."""
_SWEEPS = 8


@dataclass(frozen=True)
class Kriging:
    """A surface through values at some places."""

    places: Array
    """Places, shape (n, k)."""
    axis: NDArray[np.intp]
    """Axis of each column: a word has a column for each of its values, which have one length; shape (k,)."""
    lengths: Array
    """By axis, shape (d,)."""
    nugget: float
    centre: float
    scale: float
    """Mean and standard deviation of the values."""
    factor: Array
    """Lower Cholesky factor of the covariance of the standardised values, shape (n, n)."""
    weights: Array
    """Weights, shape (n,)."""

    @classmethod
    def fitted(cls, places: Array, axis: NDArray[np.intp], values: Array, start: "Kriging | None" = None) -> "Kriging":
        """Fit lengths and nugget by steps that make the values likelier, from those of an earlier fit.

        Parameters
        ----------
        places : array, shape (n, k)
        axis : array of int, shape (k,)
        values : array, shape (n,)
        start : Kriging, optional
        """
        log = np.full(int(axis.max()) + 2, -1.0) if start is None else np.log2([*start.lengths, start.nugget])
        log[-1] = -10.0 if start is None else log[-1]
        low = np.array([math.log2(_SHORTEST)] * (log.size - 1) + [math.log2(_LEAST_NUGGET)])
        high = np.array([math.log2(_LONGEST)] * (log.size - 1) + [math.log2(_MOST_NUGGET)])
        best, likelihood = cls._with(places, axis, values, log)
        for _ in range(_SWEEPS):
            before = likelihood
            for index in range(log.size):
                for step in (-1.0, 1.0) if index < log.size - 1 else (-2.0, 2.0):
                    moved = log.copy()
                    moved[index] = min(max(log[index] + step, low[index]), high[index])
                    surface, log_likelihood = cls._with(places, axis, values, moved)
                    if log_likelihood > likelihood + 1e-9:
                        best, likelihood, log = surface, log_likelihood, moved
            if likelihood <= before:
                break
        return best

    @classmethod
    def _with(cls, places: Array, axis: NDArray[np.intp], values: Array, log: Array) -> "tuple[Kriging, float]":
        """Return the surface with given logarithms of lengths and nugget, and its log-likelihood."""
        lengths, nugget = 2.0 ** log[:-1], float(2.0 ** log[-1])
        centre, scale = float(values.mean()), max(float(values.std()), 1e-12)
        covariance = _covariance(places / lengths[axis], places / lengths[axis]) + nugget * np.eye(len(values))
        factor = scipy.linalg.cholesky(covariance, lower=True)
        standard = (values - centre) / scale
        weights = scipy.linalg.cho_solve((factor, True), standard)
        likelihood = -0.5 * float(standard @ weights) - float(np.log(np.diag(factor)).sum())
        likelihood -= 0.5 * float(((log + 1.0) ** 2)[:-1].sum()) / 9.0  # lengths of half an axis, give or take 2³
        return cls(places, axis, lengths, nugget, centre, scale, factor, weights), likelihood

    def at(self, places: Array) -> tuple[Array, Array]:
        """Return mean and standard deviation at some places, shape (m, k), without the noise of values there."""
        across = _covariance(places / self.lengths[self.axis], self.places / self.lengths[self.axis])
        solved = scipy.linalg.solve_triangular(self.factor, across.T, lower=True)
        spread = np.sqrt(np.maximum(1.0 - (solved * solved).sum(axis=0), 0.0))
        return self.centre + self.scale * (across @ self.weights), self.scale * spread

    def alike(self, place: Array, places: Array) -> Array:
        """Return the correlation of one place, shape (k,), with others, shape (m, k), before any value is known."""
        lengths = self.lengths[self.axis]
        return _covariance(places / lengths, place[None] / lengths)[:, 0]


def _covariance(one: Array, two: Array) -> Array:
    """Matérn covariance with ν = 5/2 between places in units of their lengths."""
    squared = (one * one).sum(axis=1)[:, None] + (two * two).sum(axis=1) - 2.0 * one @ two.T
    distance = np.sqrt(5.0 * np.maximum(squared, 0.0))
    return np.asarray((1.0 + distance + distance * distance / 3.0) * np.exp(-distance))


def expected_improvement(low: float, mean: Array, spread: Array) -> Array:
    """Mean of how much a value falls below `low` (Jones, Schonlau & Welch 1998, eq. 15)."""
    safe = np.maximum(spread, 1e-12)
    z = (low - mean) / safe
    return np.asarray((low - mean) * scipy.special.ndtr(z) + safe * np.exp(-0.5 * z * z) / math.sqrt(2.0 * math.pi))
