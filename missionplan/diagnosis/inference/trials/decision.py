"""A decision under uncertainty, and what knowing more would save: the value of perfect and of sample information.

Preposterior analysis by regression: the expected loss of each alternative after an experiment is a regression of its
losses, one for each draw of the unknowns, on summaries of the data that the draws would give (Strong, Oakley, Brennan &
Breeze 2015, *Medical Decision Making* 35, doi 10.1177/0272989X15575286). Each fifth of the draws is decided by
regressions on the others: the saving is then that of a rule that could be followed, and no over-fitting raises it.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array

FOLDS = 5
"""Parts of the draws, each decided by regressions on the others."""
SIGNIFICANT = 3.0
"""Standard errors above which a saving is no chance."""
RIDGE = 1e-6
"""Ridge of a regression, of the mean square of its columns."""


@dataclass(frozen=True)
class DecisionProblem:
    """What is to be chosen, and what each alternative costs."""

    alternatives: Array
    """What is chosen: a length, a weight, shape (a,)."""
    losses: Array
    """Shape (n, a). Loss of each alternative under each draw of the unknowns; they may be noisy, with common random
    numbers."""
    weight: Array
    """Shape (n,). Of each draw; they add up to 1."""

    @property
    def expected(self) -> Array:
        """Expected loss of each alternative with what is known now, shape (a,)."""
        return np.asarray(self.weight @ self.losses)

    @cached_property
    def choice(self) -> int:
        """Index of the best alternative with what is known now."""
        return int(np.argmin(self.expected))


@dataclass(frozen=True)
class Saving:
    """What knowing more saves.

    Attributes
    ----------
    mean, error : float
        Expected saving over the choice of now, and its standard error [of the losses].
    """

    mean: float
    error: float
    chosen: NDArray[np.int_]
    """Alternative chosen for each draw, shape (n,)."""

    @property
    def changes(self) -> bool:
        """Whether the saving is more than chance makes of the best of many designs."""
        return self.mean > SIGNIFICANT * self.error


def value_of_information(problem: DecisionProblem, summaries: Array) -> Saving:
    """Return what is saved on average if the choice may depend on summaries of what will be known.

    Of the data of an experiment this is the expected value of sample information; of the unknowns themselves that of
    perfect information.

    Parameters
    ----------
    problem : DecisionProblem
    summaries : array, shape (n, q)
        For each draw, the columns of the regressions.
    """
    n = len(summaries)
    fold = np.arange(n) % FOLDS
    chosen = np.full(n, problem.choice)
    against = problem.losses - problem.losses[:, [problem.choice]]
    for part in range(FOLDS):
        own = fold == part
        fitted = _fit(summaries[~own], against[~own], problem.weight[~own])
        chosen[own] = np.argmin(summaries[own] @ fitted, axis=1)
    saved = -against[np.arange(n), chosen]
    mean = float(problem.weight @ saved)
    error = float(np.sqrt(np.sum(np.square(problem.weight * (saved - mean)))))
    return Saving(max(mean, 0.0), error, chosen)


def choice_after(problem: DecisionProblem, summaries: Array, seen: Array) -> int:
    """Return the index of the best alternative once data have been seen.

    Parameters
    ----------
    problem : DecisionProblem
    summaries : array, shape (n, q)
        For each draw, as of `value_of_information`.
    seen : array, shape (1, q)
        Of the data.
    """
    against = problem.losses - problem.losses[:, [problem.choice]]
    return int(np.argmin(seen @ _fit(summaries, against, problem.weight)))


def _fit(columns: Array, values: Array, weight: Array) -> Array:
    """Coefficients of weighted least squares with a slight ridge, shape (q, a)."""
    scale = np.sqrt(np.maximum(weight @ columns**2 / weight.sum(), 1e-300))
    scaled = columns / scale
    gram = scaled.T @ (weight[:, None] * scaled) / weight.sum() + RIDGE * np.eye(columns.shape[1])
    right = scaled.T @ (weight[:, None] * values) / weight.sum()
    return np.asarray(np.linalg.solve(gram, right) / scale[:, None])
