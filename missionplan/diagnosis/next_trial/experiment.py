"""An experiment that several explanations predict, each linear and Gaussian, and what the choice after it would save.

Information: Lindley (1956), *Ann. Math. Stat.* 27; Chaloner & Verdinelli (1995), *Statistical Science* 10: mutual
information between the unknowns and the data. Savings: preposterior analysis by regression of the losses of each
alternative on summaries of the data that draws of the unknowns would give (Strong, Oakley, Brennan & Breeze 2015,
*Medical Decision Making* 35, doi 10.1177/0272989X15575286). Each fifth of the draws is decided by regressions on the
others: the saving is then that of a rule that could be followed, and no over-fitting raises it.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp

from missionplan.arrays import Array
from missionplan.diagnosis.next_trial.prediction import Explanation, Prediction, Updated, normalised

CURVED = 3
"""Directions of a summary that enter squared and multiplied with each other; the rest enter linearly."""


@dataclass(frozen=True)
class Draws:
    """Unknowns drawn from what is believed."""

    explanation: NDArray[np.int_]
    """Which explanation holds, shape (n,)."""
    parameters: tuple[Array, ...]
    """Its parameters, for the draws of each explanation in their order, shape (n_s, k_s)."""
    weight: Array
    """Shape (n,). Of each draw; they add up to 1."""


def drawn(explanations: Sequence[Explanation], counts: Sequence[int], generator: np.random.Generator) -> Draws:
    """Draw parameters under each explanation, whose probabilities add up to 1, so many of each."""
    parameters = tuple(
        explanation.mean
        + generator.standard_normal((count, len(explanation.mean))) @ square_root(explanation.covariance).T
        for explanation, count in zip(explanations, counts, strict=True)
    )
    which = np.repeat(np.arange(len(counts)), counts)
    share = np.array([explanation.probability / count for explanation, count in zip(explanations, counts, strict=True)])
    return Draws(which, parameters, share[which])


def square_root(covariance: Array) -> Array:
    """Return a factor L with L Lᵀ the covariance, which may be singular."""
    values, vectors = np.linalg.eigh(covariance)
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)))


@dataclass(frozen=True)
class Experiment:
    """An experiment as every explanation predicts it."""

    explanations: tuple[Explanation, ...]
    """Whose probabilities add up to 1."""
    predictions: tuple[Prediction, ...]
    """In the same order."""

    @cached_property
    def _updated(self) -> tuple[Updated, ...]:
        return tuple(map(Updated, self.explanations, self.predictions))

    def data(self, draws: Draws, generator: np.random.Generator) -> Array:
        """Simulate the experiment for every draw, shape (n, N)."""
        parts = []
        for update, theta in zip(self._updated, draws.parameters, strict=True):
            predicted = update.prediction.centre + (theta - update.explanation.mean) @ update.prediction.columns.T
            normals = generator.standard_normal(predicted.shape)
            ends = np.round(np.cumsum(update.prediction.shares) * len(theta)).astype(int)  # so many draws of each noise
            for noise, end, count in zip(update.prediction.noises, ends, np.diff(ends, prepend=0), strict=True):
                predicted[end - count : end] += normals[end - count : end] @ square_root(noise).T
            parts.append(predicted)
        return np.concatenate(parts)

    def probabilities(self, data: Array) -> Array:
        """Probability of each explanation after data, shape (n, N) → (n, s)."""
        return normalised(self._log_joint(data))

    def _log_joint(self, data: Array) -> Array:
        """Ln p(y, explanation) of data, shape (n, N) → (n, s)."""
        logs = [
            np.log(update.explanation.probability) + logsumexp(update.log_densities(data), 1)
            for update in self._updated
        ]
        return np.stack(logs, axis=1)

    def means(self, data: Array) -> tuple[Array, ...]:
        """Posterior means of the parameters under each explanation, shape (n, k_s) each."""
        return tuple(update.means(data) for update in self._updated)

    @property
    def covariances(self) -> tuple[Array, ...]:
        """Posterior covariances under each explanation, shape (k_s, k_s) each; no data change them."""
        return tuple(update.covariance for update in self._updated)

    def summaries(self, data: Array) -> Array:
        """Numbers that say of data what they mean, for regressions, shape (n, q).

        The probability of each explanation, alone and times the changes of its parameters' means, whitened, and their
        products: the expected value of any quantity that is quadratic in the parameters is linear in these.
        """
        probabilities = self.probabilities(data)
        columns = []
        for update, probability in zip(self._updated, probabilities.T, strict=True):
            changes = (update.means(data) - update.explanation.mean) @ update.directions
            columns += [probability * column for column in polynomial(changes)]
        return np.stack(columns, axis=1)

    def expected_information(self, draws: Draws, data: Array) -> float:
        """Mutual information between all that is unknown and the data [nats].

        Of the parameters half a log determinant where the noise is known; of which explanation holds the mean of its
        gain in log probability over the draws.
        """
        after = self.probabilities(data)[np.arange(len(data)), draws.explanation]
        before = np.array([explanation.probability for explanation in self.explanations])[draws.explanation]
        which = float(draws.weight @ np.log(np.maximum(after, 1e-300) / before))
        within, end = 0.0, 0
        for update, theta in zip(self._updated, draws.parameters, strict=True):
            begin, end = end, end + len(theta)
            within += update.explanation.probability * update.information(theta, data[begin:end])
        return max(which, 0.0) + within


def polynomial(changes: Array) -> list[Array]:
    """Columns of a polynomial: 1, every direction, and squares and products of the first few; from shape (n, q)."""
    columns = [np.ones(len(changes)), *changes.T]
    for i in range(min(CURVED, changes.shape[1])):
        columns += [changes[:, i] * changes[:, j] for j in range(i + 1)]
    return columns


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
    """What knowing more saves."""

    mean: float
    error: float
    """Expected saving over the choice of now, and its standard error [of the losses]."""
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

    `summaries`, shape (n, q): for each draw, the columns of the regressions.
    """
    n = len(summaries)
    fold = np.arange(n) % FOLDS
    chosen = np.full(n, problem.choice)
    against = problem.losses - problem.losses[:, [problem.choice]]
    for part in range(FOLDS):
        draws = fold == part
        fitted = _fit(summaries[~draws], against[~draws], problem.weight[~draws])
        chosen[draws] = np.argmin(summaries[draws] @ fitted, axis=1)
    saved = -against[np.arange(n), chosen]
    mean = float(problem.weight @ saved)
    error = float(np.sqrt(np.sum(np.square(problem.weight * (saved - mean)))))
    return Saving(max(mean, 0.0), error, chosen)


def _fit(columns: Array, values: Array, weight: Array) -> Array:
    """Coefficients of weighted least squares with a slight ridge, shape (q, a)."""
    scale = np.sqrt(np.maximum(weight @ columns**2 / weight.sum(), 1e-300))
    scaled = columns / scale
    gram = scaled.T @ (weight[:, None] * scaled) / weight.sum() + RIDGE * np.eye(columns.shape[1])
    right = scaled.T @ (weight[:, None] * values) / weight.sum()
    return np.asarray(np.linalg.solve(gram, right) / scale[:, None])
