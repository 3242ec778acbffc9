"""Sensitivity to uncertain inputs: rank correlations and first-order Sobol indices from the trials of a run.

No further model runs are needed: the conditional mean of a result, given one input, is fitted to the trials
themselves. Correlated inputs share what they explain, so that their indices may sum to more than one.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array

MIN_TRIALS = 100
"""Number of trials below which no sensitivity is estimated."""
_MAX_BINS = 20
_TRIALS_PER_BIN = 50
_GROUPS = 20


@dataclass(frozen=True)
class Influence:
    """Influence of one uncertain input on one result."""

    output: str
    source: str
    """Names of the result and of the input."""
    rank_correlation: float
    """Spearman's coefficient."""
    first_order: float
    """First-order Sobol index, the share of the variance that knowing the input removes; an estimate of a small share
    may be slightly negative."""
    standard_error: float
    """Of the index."""


def sensitivities(inputs: Mapping[str, Array], outputs: Mapping[str, Array]) -> tuple[Influence, ...]:
    """Rank the inputs by the share of each output's variance that they explain.

    `inputs`, shape (n,): draws of each uncertain input. `outputs`, shape (n,): results of the same trials; nan where a
    trial never reached one, which excludes that trial from it.

    Returns
    -------
    tuple of Influence
        Output by output, most important input first. Inputs and outputs that do not vary, and outputs that fewer
        than `MIN_TRIALS` trials reached, are omitted.
    """
    prepared: dict[bytes, dict[str, Source]] = {}  # by trials that reached the output: mostly the same
    influences: list[Influence] = []
    for output, values in outputs.items():
        reached = np.isfinite(values)
        y = values[reached]
        if len(y) < MIN_TRIALS or _constant(y):
            continue
        sources = prepared.setdefault(reached.tobytes(), {})
        if not sources:
            sources |= {name: Source.of(draws[reached]) for name, draws in inputs.items()}
        influences += sorted(_influences(sources, output, y), key=lambda influence: -influence.first_order)
    return tuple(influences)


@dataclass(frozen=True)
class Source:
    """Values, ranks and classes of equal counts of an input, shape (n,) each, for all outputs.

    Equal values share a rank and a class, so that each of several choices is a class.
    """

    values: Array
    ranks: Array
    classes: NDArray[np.int64]

    @classmethod
    def of(cls, values: Array) -> "Source":
        """Rank and classify draws, shape (n,)."""
        different, place, count = np.unique(values, return_inverse=True, return_counts=True)
        ranks = _shared_ranks(count)[place]
        bins = min(_MAX_BINS, max(1, len(values) // _TRIALS_PER_BIN))
        if len(different) <= bins:
            return cls(values, ranks, np.asarray(place, dtype=np.int64))
        edges = np.quantile(np.repeat(different, count), np.arange(1, bins) / bins)
        classes = np.searchsorted(edges, different, side="left")[place]
        return cls(values, ranks, np.asarray(classes, dtype=np.int64))


def _influences(sources: Mapping[str, Source], output: str, y: Array) -> Iterator[Influence]:
    _, place, count = np.unique(y, return_inverse=True, return_counts=True)
    ranks = _shared_ranks(count)[place]
    for name, source in sources.items():
        if not _constant(source.values):
            yield Influence(output, name, _correlation(source.ranks, ranks), *first_order_index(source, y))


def _shared_ranks(count: NDArray[np.int64]) -> Array:
    """Ranks from 1 of ascending values, mean ranks for ties; importing scipy.stats would cost a second."""
    shared: Array = np.cumsum(count) - 0.5 * (count - 1)
    return shared


def _correlation(x: Array, y: Array) -> float:
    """Pearson's correlation, without BLAS, whose rounding depends on its threads."""
    dx, dy = x - x.mean(), y - y.mean()
    return float(np.sum(dx * dy) / np.sqrt(np.sum(dx * dx) * np.sum(dy * dy)))


def _constant(values: Array) -> bool:
    """Whether values differ by rounding alone."""
    return bool(np.ptp(values) <= 1e-9 * np.max(np.abs(values)))


def first_order_index(source: Source, y: Array) -> tuple[float, float]:
    """Estimate the first-order Sobol index Var(E[y|x]) / Var(y), and its standard error.

    E[y|x] is fitted by a straight line in each of up to 20 classes of x with equal counts (Plischke, Borgonovo &
    Smith 2013 take class means; lines remove most of the error due to a class's width). The share explained is
    corrected for the fitted parameters like an adjusted R², so that an input without influence has zero on average.
    The standard error is that of the delete-a-group jackknife with 20 groups; for an index near zero, where the
    estimate is a quadratic form of the residuals, it is too large by up to √2 (Efron & Stein 1981). Both are finite
    and not constant.
    """
    # Centred, so that the sums of squares keep their digits.
    x = source.values - source.values.mean()
    sums = _class_sums(source.classes, x, (y - y.mean()) / y.std())
    whole = sums.sum(axis=2, keepdims=True)
    # of all, then with each group left out: what a line in each class explains, corrected for the fitted parameters
    count, sum_x, sum_y, sum_xx, sum_xy, sum_yy = np.concatenate((whole, whole - sums), axis=2)
    n, used = np.maximum(count, 1.0), count > 0.0
    within_xx = sum_xx - sum_x**2 / n
    within_xy = sum_xy - sum_x * sum_y / n
    within_yy = sum_yy - sum_y**2 / n
    sloped = (count > 2) & (within_xx > 1e-12 * (sum_xx + sum_x**2 / n))
    explained = np.where(sloped, within_xy**2 / np.where(sloped, within_xx, 1.0), 0.0)
    residual = np.sum(within_yy - explained, axis=0)
    trials = count.sum(axis=0)
    total = sum_yy.sum(axis=0) - sum_y.sum(axis=0) ** 2 / trials
    freedom = trials - np.count_nonzero(used, axis=0) - np.count_nonzero(sloped, axis=0)
    varies = total > 1e-9 * sum_yy.sum(axis=0)  # without the one trial that differs it may not
    explained = (residual / freedom) / (np.where(varies, total, 1.0) / (trials - 1))
    shares = np.where(varies, 1.0 - explained, 0.0)
    return float(shares[0]), math.sqrt((_GROUPS - 1) * float(np.var(shares[1:])))


def _class_sums(classes: NDArray[np.int64], x: Array, y: Array) -> Array:
    """Sums of 1, x, y, x², xy, y² by class and jackknife group, shape (6, classes, groups)."""
    group = np.arange(len(x)) % _GROUPS
    cell, cells = classes * _GROUPS + group, (int(classes.max()) + 1) * _GROUPS
    weights = (None, x, y, x * x, x * y, y * y)
    return np.array([np.bincount(cell, weight, cells).reshape(-1, _GROUPS) for weight in weights], dtype=float)
