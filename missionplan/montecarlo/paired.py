"""Which of several alternatives are as good as the best: paired differences on common random numbers."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

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
    if error == 0.0 or not np.isfinite(error):
        return mean, error, 0.0 if mean > 0.0 else 1.0
    return mean, error, float(scipy.special.ndtr(-mean / error))


def pareto_front(costs: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return which alternatives no other beats: as low in each cost and lower in one; nan is never on the front.

    Parameters
    ----------
    costs : array, shape (k, m)
    """
    known = np.asarray(np.isfinite(costs).all(axis=1))
    front = np.array(known)
    for index in np.flatnonzero(known):
        no_higher = (costs <= costs[index]).all(axis=1) & known
        front[index] = not np.any(no_higher & (costs < costs[index]).any(axis=1))
    return front
