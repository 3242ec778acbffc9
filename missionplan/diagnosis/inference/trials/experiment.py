"""An experiment that several explanations predict, each linear and Gaussian: data, posterior, expected information.

Lindley (1956), *Ann. Math. Stat.* 27; Chaloner & Verdinelli (1995), *Statistical Science* 10: the worth of an
experiment as mutual information between the unknowns and the data.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp

from missionplan.arrays import Array
from missionplan.diagnosis.inference.trials.prediction import Explanation, Prediction, Updated, normalised

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
    """Draw parameters under each explanation, so many of each.

    Parameters
    ----------
    explanations : sequence of Explanation
    counts : sequence of int
        Draws of each.
    generator : Generator
    """
    parameters = tuple(
        each.mean + generator.standard_normal((count, len(each.mean))) @ square_root(each.covariance).T
        for each, count in zip(explanations, counts, strict=True)
    )
    which = np.repeat(np.arange(len(counts)), counts)
    share = np.array([each.probability / count for each, count in zip(explanations, counts, strict=True)])
    return Draws(which, parameters, share[which] / share[which].sum())


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
        for each, own in zip(self._updated, draws.parameters, strict=True):
            predicted = each.prediction.centre + (own - each.explanation.mean) @ each.prediction.columns.T
            normals = generator.standard_normal(predicted.shape)
            ends = np.round(np.cumsum(each.prediction.shares) * len(own)).astype(int)  # so many draws of each noise
            for noise, end, count in zip(each.prediction.noises, ends, np.diff(ends, prepend=0), strict=True):
                predicted[end - count : end] += normals[end - count : end] @ square_root(noise).T
            parts.append(predicted)
        return np.concatenate(parts)

    def probabilities(self, data: Array) -> Array:
        """Probability of each explanation after data, shape (n, N) → (n, s)."""
        return normalised(self._log_joint(data))

    def _log_joint(self, data: Array) -> Array:
        """Ln p(y, explanation) of data, shape (n, N) → (n, s)."""
        logs = [np.log(each.explanation.probability) + logsumexp(each.log_densities(data), 1) for each in self._updated]
        return np.stack(logs, axis=1)

    def means(self, data: Array) -> tuple[Array, ...]:
        """Posterior means of the parameters under each explanation, shape (n, k_s) each."""
        return tuple(each.means(data) for each in self._updated)

    @property
    def covariances(self) -> tuple[Array, ...]:
        """Posterior covariances under each explanation, shape (k_s, k_s) each; no data change them."""
        return tuple(each.covariance for each in self._updated)

    def summaries(self, data: Array) -> Array:
        """Numbers that say of data what they mean, for regressions, shape (n, q).

        The probability of each explanation, alone and times the changes of its parameters' means, whitened, and their
        products: the expected value of any quantity that is quadratic in the parameters is linear in these.
        """
        probabilities = self.probabilities(data)
        columns = []
        for each, probability in zip(self._updated, probabilities.T, strict=True):
            changes = (each.means(data) - each.explanation.mean) @ each.directions
            columns += [probability * column for column in polynomial(changes)]
        return np.stack(columns, axis=1)

    def expected_information(self, draws: Draws, data: Array) -> float:
        """Mutual information between all that is unknown and the data [nats].

        Of the parameters half a log determinant where the noise is known; of which explanation holds the mean of its
        gain in log probability over the draws.
        """
        after = self.probabilities(data)[np.arange(len(data)), draws.explanation]
        before = np.array([each.probability for each in self.explanations])[draws.explanation]
        which = float(draws.weight @ np.log(np.maximum(after, 1e-300) / before))
        within, end = 0.0, 0
        for each, own in zip(self._updated, draws.parameters, strict=True):
            begin, end = end, end + len(own)
            within += each.explanation.probability * each.information(own, data[begin:end])
        return max(which, 0.0) + within

    def realised_information(self, which: int, parameters: Array, data: Array) -> float:
        """Gain in log density of the truth by one experiment [nats]; its expected value is `expected_information`.

        Parameters
        ----------
        which : int
            The explanation that holds.
        parameters : array, shape (k,)
            Its parameters.
        data : array, shape (N,)
            What was measured.
        """
        likelihood = logsumexp(self._updated[which].log_likelihoods(parameters[None], data[None]))
        return float(likelihood - logsumexp(self._log_joint(data[None])))


def polynomial(changes: Array) -> list[Array]:
    """Columns of a polynomial: 1, every direction, and squares and products of the first few; from shape (n, q)."""
    columns = [np.ones(len(changes)), *changes.T]
    for i in range(min(CURVED, changes.shape[1])):
        columns += [changes[:, i] * changes[:, j] for j in range(i + 1)]
    return columns
