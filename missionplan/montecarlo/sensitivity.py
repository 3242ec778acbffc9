"""Which uncertainty matters: rank correlations and first-order Sobol indices from the sample that was run anyway.

No further model runs are needed: the conditional mean of a key figure, given one input, is fitted to the trials
themselves. Correlated inputs share what they explain, so that their indices may add up to more than one.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

LEAST_TRIALS = 100
"""Below this many trials nothing is said."""
_MOST_BINS = 20
_TRIALS_PER_BIN = 50
_GROUPS = 20


@dataclass(frozen=True)
class Influence:
    """How much one uncertain input matters for one key figure.

    Attributes
    ----------
    output, source : str
        Names of the key figure and of the input.
    rank_correlation : float
        Spearman's.
    first_order : float
        First-order Sobol index, the share of the variance that knowing the input removes; an estimate of a small
        share may be slightly negative.
    standard_error : float
        Of the index.
    """

    output: str
    source: str
    rank_correlation: float
    first_order: float
    standard_error: float


def sensitivities(inputs: Mapping[str, Array], outputs: Mapping[str, Array]) -> tuple[Influence, ...]:
    """Rank the inputs by what they explain of each output.

    Parameters
    ----------
    inputs : mapping of str to array, shape (n,)
        Draws of each uncertain input.
    outputs : mapping of str to array, shape (n,)
        Key figures of the same trials; nan where a trial never reached one, which leaves that trial out of it.

    Returns
    -------
    tuple of Influence
        Output by output, most important input first. Inputs and outputs that do not vary, and outputs that fewer
        than `LEAST_TRIALS` trials reached, are left out.
    """
    return tuple(
        influence
        for output, values in outputs.items()
        for influence in sorted(_influences(inputs, output, values), key=lambda found: -found.first_order)
    )


def _influences(inputs: Mapping[str, Array], output: str, values: Array) -> Iterator[Influence]:
    reached = np.isfinite(values)
    y = values[reached]
    if len(y) < LEAST_TRIALS or _constant(y):
        return
    ranks = _ranks(y)
    for source, draws in inputs.items():
        x = draws[reached]
        if not _constant(x):
            correlation = float(np.corrcoef(_ranks(x), ranks)[0, 1])
            yield Influence(output, source, correlation, *first_order_index(x, y))


def _ranks(values: Array) -> Array:
    """Ranks from 1, equal values sharing the mean of theirs; importing scipy.stats for it would cost a second."""
    _, place, count = np.unique(values, return_inverse=True, return_counts=True)
    shared: Array = np.cumsum(count) - 0.5 * (count - 1)
    return shared[place]


def _constant(values: Array) -> bool:
    """Whether values differ by no more than rounding."""
    return bool(np.ptp(values) <= 1e-9 * np.max(np.abs(values)))


def first_order_index(x: Array, y: Array) -> tuple[float, float]:
    """Estimate the first-order Sobol index Var(E[y|x]) / Var(y), and its standard error.

    E[y|x] is fitted by a straight line in each of up to 20 classes of x with equal counts (Plischke, Borgonovo &
    Smith 2013 take class means; lines remove most of the error that a class's width makes). The share explained is
    corrected for the parameters fitted as an adjusted R² is, so that an input without influence gives zero on
    average. The standard error is the delete-a-group jackknife's, 20 groups; where the index is near zero, and so a
    quadratic form of what is left, it is too large by up to √2 (Efron & Stein 1981).

    Parameters
    ----------
    x, y : array, shape (n,)
        An input and an output of the same trials, both finite and not constant.

    Returns
    -------
    index, standard_error : float
    """
    # Centred, so that the sums of squares keep their digits.
    sums = _class_sums(_classes(x), x - x.mean(), (y - y.mean()) / y.std())
    whole = sums.sum(axis=2)
    left_out = [_adjusted_share(whole - sums[:, :, group]) for group in range(_GROUPS)]
    spread = math.sqrt((_GROUPS - 1) * float(np.var(left_out)))
    return _adjusted_share(whole), spread


def _classes(x: Array) -> NDArray[np.int64]:
    """Class of each value, shape (n,): equal counts; equal values share a class, so that choices are classes."""
    bins = min(_MOST_BINS, max(1, len(x) // _TRIALS_PER_BIN))
    values, place = np.unique(x, return_inverse=True)
    if len(values) <= bins:
        return np.asarray(place, dtype=np.int64)
    edges = np.quantile(x, np.arange(1, bins) / bins)
    return np.asarray(np.searchsorted(edges, x, side="left"), dtype=np.int64)


def _class_sums(classes: NDArray[np.int64], x: Array, y: Array) -> Array:
    """Sums of 1, x, y, x², xy, y² by class and jackknife group, shape (6, classes, groups)."""
    group = np.arange(len(x)) % _GROUPS
    cell, cells = classes * _GROUPS + group, (int(classes.max()) + 1) * _GROUPS
    weights = (None, x, y, x * x, x * y, y * y)
    return np.array([np.bincount(cell, weight, cells).reshape(-1, _GROUPS) for weight in weights], dtype=float)


def _adjusted_share(sums: Array) -> float:
    """Share of the variance that a line in each class explains, corrected for the parameters; sums (6, classes)."""
    n, sum_x, sum_y, sum_xx, sum_xy, sum_yy = sums[:, sums[0] > 0]
    within_xx = sum_xx - sum_x**2 / n
    within_xy = sum_xy - sum_x * sum_y / n
    within_yy = sum_yy - sum_y**2 / n
    sloped = (n > 2) & (within_xx > 1e-12 * (sum_xx + sum_x**2 / n))
    explained = np.where(sloped, within_xy**2 / np.where(sloped, within_xx, 1.0), 0.0)
    residual = float(np.sum(within_yy - explained))
    total = float(sum_yy.sum() - sum_y.sum() ** 2 / n.sum())
    freedom = n.sum() - len(n) - np.count_nonzero(sloped)
    return float(1.0 - (residual / freedom) / (total / (n.sum() - 1)))
