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
from missionplan.diagnosis.inference.marginal_likelihood import LOG_2PI

SMALLEST_SHARE = 1e-9
"""Share of a parameter's variance below which an experiment is taken to say nothing of a direction."""
CURVED = 3
"""Directions of a summary that enter squared and multiplied with each other; the rest enter linearly."""


@dataclass(frozen=True)
class Explanation:
    """What is believed if one explanation is true.

    Attributes
    ----------
    probability : float
        Of the explanation.
    mean : array, shape (k,)
        Of its parameters.
    covariance : array, shape (k, k)
        Of them.
    """

    probability: float
    mean: Array
    covariance: Array


@dataclass(frozen=True)
class Prediction:
    """The data of an experiment if one explanation is true: y ~ N(centre + columns·(θ − mean), noise).

    Attributes
    ----------
    centre : array, shape (N,)
        Data at the parameters' mean.
    columns : array, shape (N, k)
        Sensitivities to the parameters.
    noise : array, shape (N, N)
        Covariance of everything else.
    """

    centre: Array
    columns: Array
    noise: Array


@dataclass(frozen=True)
class _Updated:
    """One explanation with its prediction, prepared for conditioning (Rasmussen & Williams 2006, Eq. A.6)."""

    explanation: Explanation
    prediction: Prediction

    @cached_property
    def factor(self) -> Array:
        """Lower Cholesky factor of the data's covariance, shape (N, N)."""
        prediction = self.prediction
        total = prediction.columns @ self.explanation.covariance @ prediction.columns.T + prediction.noise
        return np.asarray(np.linalg.cholesky(total))

    @cached_property
    def gain(self) -> Array:
        """Posterior mean's change a unit of data, shape (k, N)."""
        cross = self.prediction.columns @ self.explanation.covariance
        return np.asarray(np.linalg.solve(self.factor.T, np.linalg.solve(self.factor, cross)).T)

    def log_density(self, data: Array) -> Array:
        """Ln p(y) of data, shape (n, N) → (n,)."""
        white = np.linalg.solve(self.factor, (data - self.prediction.centre).T)
        constant = 0.5 * len(self.factor) * LOG_2PI + float(np.log(np.diag(self.factor)).sum())
        return np.asarray(-0.5 * np.sum(white**2, axis=0) - constant)

    def means(self, data: Array) -> Array:
        """Posterior means, shape (n, k)."""
        return np.asarray(self.explanation.mean + (data - self.prediction.centre) @ self.gain.T)

    @cached_property
    def covariance(self) -> Array:
        """Posterior covariance, shape (k, k)."""
        prior = self.explanation.covariance
        return np.asarray(prior - self.gain @ self.prediction.columns @ prior)

    @cached_property
    def information(self) -> float:
        """Half the log determinant of the data's covariance over the noise's [nats]."""
        noise = np.linalg.slogdet(self.prediction.noise)[1]
        return max(float(np.log(np.diag(self.factor)).sum()) - 0.5 * float(noise), 0.0)

    @cached_property
    def directions(self) -> Array:
        """Columns that whiten the posterior mean's changes, most informative first, shape (k, q)."""
        spread = self.gain @ self.prediction.columns @ self.explanation.covariance
        sd = np.sqrt(np.maximum(np.diag(self.explanation.covariance), 1e-300))
        values, vectors = np.linalg.eigh(spread / np.outer(sd, sd))
        kept = np.flatnonzero(values > SMALLEST_SHARE)[::-1]
        return np.asarray(vectors[:, kept] / np.sqrt(values[kept]) / sd[:, None])


@dataclass(frozen=True)
class Draws:
    """Unknowns drawn from what is believed.

    Attributes
    ----------
    explanation : array of int, shape (n,)
        Which explanation holds.
    parameters : tuple of array, shape (n_s, k_s) each
        Its parameters, for the draws of each explanation in their order.
    weight : array, shape (n,)
        Of each draw; they add up to 1.
    """

    explanation: NDArray[np.int_]
    parameters: tuple[Array, ...]
    weight: Array


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
    """An experiment as every explanation predicts it.

    Attributes
    ----------
    explanations : tuple of Explanation
        Whose probabilities add up to 1.
    predictions : tuple of Prediction
        In the same order.
    """

    explanations: tuple[Explanation, ...]
    predictions: tuple[Prediction, ...]

    @cached_property
    def _updated(self) -> tuple[_Updated, ...]:
        return tuple(map(_Updated, self.explanations, self.predictions))

    def data(self, draws: Draws, generator: np.random.Generator) -> Array:
        """Simulate the experiment for every draw, shape (n, N)."""
        parts = []
        for each, own in zip(self._updated, draws.parameters, strict=True):
            predicted = each.prediction.centre + (own - each.explanation.mean) @ each.prediction.columns.T
            normals = generator.standard_normal(predicted.shape)
            parts.append(predicted + normals @ square_root(each.prediction.noise).T)
        return np.concatenate(parts)

    def probabilities(self, data: Array) -> Array:
        """Probability of each explanation after data, shape (n, N) → (n, s)."""
        logs = np.stack([np.log(each.explanation.probability) + each.log_density(data) for each in self._updated], 1)
        return np.asarray(np.exp(logs - logsumexp(logs, axis=1, keepdims=True)))

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

        Of the parameters half a log determinant, exactly; of which explanation holds the mean of its gain in log
        probability over the draws.
        """
        after = self.probabilities(data)[np.arange(len(data)), draws.explanation]
        before = np.array([each.probability for each in self.explanations])[draws.explanation]
        which = float(draws.weight @ np.log(np.maximum(after, 1e-300) / before))
        within = sum(each.explanation.probability * each.information for each in self._updated)
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
        each, prediction = self._updated[which], self.predictions[which]
        error = data - prediction.centre - prediction.columns @ (parameters - each.explanation.mean)
        factor = np.linalg.cholesky(prediction.noise)
        white = np.linalg.solve(factor, error)
        constant = 0.5 * len(error) * LOG_2PI + float(np.log(np.diag(factor)).sum())
        likelihood = -0.5 * float(white @ white) - constant
        logs = [np.log(e.explanation.probability) + e.log_density(data[None])[0] for e in self._updated]
        return likelihood - float(logsumexp(logs))


def polynomial(changes: Array) -> list[Array]:
    """Columns of a polynomial: 1, every direction, and squares and products of the first few; from shape (n, q)."""
    columns = [np.ones(len(changes)), *changes.T]
    for i in range(min(CURVED, changes.shape[1])):
        columns += [changes[:, i] * changes[:, j] for j in range(i + 1)]
    return columns
