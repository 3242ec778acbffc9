"""What one explanation believes and predicts of an experiment, linear and Gaussian, at one noise or at several."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy.linalg import solve_triangular
from scipy.special import logsumexp

from missionplan.arrays import Array
from missionplan.diagnosis.inference.marginal_likelihood import LOG_2PI

SMALLEST_SHARE = 1e-9
"""Share of a parameter's variance below which an experiment is taken to say nothing of a direction."""


@dataclass(frozen=True)
class Explanation:
    """What is believed if one explanation is true."""

    probability: float
    """Of the explanation."""
    mean: Array
    """Of its parameters, shape (k,)."""
    covariance: Array
    """Of them, shape (k, k)."""


@dataclass(frozen=True)
class Prediction:
    """The data of an experiment if one explanation is true: y ~ N(centre + columns·(θ − mean), noise)."""

    centre: Array
    """Data at the parameters' mean, shape (N,)."""
    columns: Array
    """Sensitivities to the parameters, shape (N, k)."""
    noise: Array
    """Shape (N, N) or (g, N, N). Covariance of everything else; several where it is not known which it is."""
    shares: Array = field(default_factory=lambda: np.ones(1))
    """Shape (g,). Their probabilities; default one that is known."""

    @property
    def noises(self) -> Array:
        """Every covariance, shape (g, N, N)."""
        return self.noise.reshape(-1, *self.noise.shape[-2:])


@dataclass(frozen=True)
class AtNoise:
    """One explanation at one noise, prepared for conditioning (Rasmussen & Williams 2006, Eq. A.6)."""

    explanation: Explanation
    prediction: Prediction
    noise: Array

    @cached_property
    def factor(self) -> Array:
        """Lower Cholesky factor of the data's covariance, shape (N, N)."""
        prediction = self.prediction
        total = prediction.columns @ self.explanation.covariance @ prediction.columns.T + self.noise
        return np.asarray(np.linalg.cholesky(total))

    @cached_property
    def gain(self) -> Array:
        """Posterior mean's change a unit of data, shape (k, N)."""
        cross = self.prediction.columns @ self.explanation.covariance
        return np.asarray(np.linalg.solve(self.factor.T, np.linalg.solve(self.factor, cross)).T)

    def log_density(self, data: Array) -> Array:
        """Ln p(y) of data, shape (n, N) → (n,)."""
        return _log_normal(data - self.prediction.centre, self.factor)

    @cached_property
    def spread(self) -> Array:
        """Covariance of the posterior means over the data to come, shape (k, k)."""
        return np.asarray(self.gain @ self.prediction.columns @ self.explanation.covariance)

    @cached_property
    def information(self) -> float:
        """Half the log determinant of the data's covariance over the noise's [nats]."""
        noise = np.linalg.slogdet(self.noise)[1]
        return max(float(np.log(np.diag(self.factor)).sum()) - 0.5 * float(noise), 0.0)


def _log_normal(errors: Array, factor: Array) -> Array:
    """Ln N(error; 0, L Lᵀ) of errors, shape (n, N) → (n,)."""
    white = solve_triangular(factor, errors.T, lower=True, check_finite=False)
    constant = 0.5 * len(factor) * LOG_2PI + float(np.log(np.diag(factor)).sum())
    return np.asarray(-0.5 * np.sum(white**2, axis=0) - constant)


@dataclass(frozen=True)
class Updated:
    """One explanation with its prediction at every noise."""

    explanation: Explanation
    prediction: Prediction

    @cached_property
    def at_noise(self) -> tuple[AtNoise, ...]:
        """The explanation at each noise."""
        return tuple(AtNoise(self.explanation, self.prediction, noise) for noise in self.prediction.noises)

    def _with_noise(self, logs: Sequence[Array]) -> Array:
        """Ln p(y, noise) of logs of p(y | noise), shape (n,) each → (n, g)."""
        return np.asarray(np.log(self.prediction.shares) + np.stack(logs, axis=1))

    def log_densities(self, data: Array) -> Array:
        """Ln p(y, noise) of data, shape (n, N) → (n, g)."""
        return self._with_noise([case.log_density(data) for case in self.at_noise])

    def log_likelihoods(self, parameters: Array, data: Array) -> Array:
        """Ln p(y, noise | θ) of data, shape (n, N), at parameters, shape (n, k) → (n, g)."""
        prediction = self.prediction
        errors = data - (prediction.centre + (parameters - self.explanation.mean) @ prediction.columns.T)
        return self._with_noise([_log_normal(errors, np.linalg.cholesky(noise)) for noise in prediction.noises])

    def means(self, data: Array) -> Array:
        """Posterior means, shape (n, k), over the noises as the data leave them."""
        shares = normalised(self.log_densities(data)) if len(self.at_noise) > 1 else np.ones((len(data), 1))
        changes = np.zeros((len(data), len(self.explanation.mean)))
        for case, share in zip(self.at_noise, shares.T, strict=True):
            changes += share[:, None] * ((data - self.prediction.centre) @ case.gain.T)
        return np.asarray(self.explanation.mean + changes)

    def _averaged(self, values: Sequence[Array]) -> Array:
        """Mean over the noises of one value each."""
        return np.asarray(sum(share * value for share, value in zip(self.prediction.shares, values, strict=True)))

    @cached_property
    def covariance(self) -> Array:
        """Posterior covariance, the mean over the noises, shape (k, k)."""
        return self.explanation.covariance - self._averaged([case.spread for case in self.at_noise])

    def information(self, parameters: Array, data: Array) -> float:
        """Information about the parameters, noise not known [nats].

        That with the noise known, exactly, less what is so learned more of the noise where the parameters are known
        than where they are not: a mean over draws, of nothing where there is one noise.

        `parameters`, shape (n, k): drawn. `data`, shape (n, N): simulated with them.
        """
        information = float(self.prediction.shares @ [case.information for case in self.at_noise])
        if len(self.at_noise) == 1:
            return information
        left, left_with = self.log_densities(data), self.log_likelihoods(parameters, data)
        return max(information - float(np.mean(_entropy(left) - _entropy(left_with))), 0.0)

    @cached_property
    def directions(self) -> Array:
        """Columns that whiten the posterior mean's changes, most informative first, shape (k, q)."""
        spread = self._averaged([case.spread for case in self.at_noise])
        sd = np.sqrt(np.maximum(np.diag(self.explanation.covariance), 1e-300))
        values, vectors = np.linalg.eigh(spread / np.outer(sd, sd))
        kept = np.flatnonzero(values > SMALLEST_SHARE)[::-1]
        return np.asarray(vectors[:, kept] / np.sqrt(values[kept]) / sd[:, None])


def normalised(logs: Array) -> Array:
    """Probabilities in proportion to logs, shape (n, g), that add up to 1 over the last axis."""
    return np.asarray(np.exp(logs - logsumexp(logs, axis=1, keepdims=True)))


def _entropy(logs: Array) -> Array:
    """Entropy of such probabilities, shape (n, g) → (n,) [nats]."""
    shares = normalised(logs)
    return np.asarray(-np.sum(shares * np.log(np.maximum(shares, 1e-300)), axis=1))
