"""Importance sampling: evidences that assume neither linearity nor a normal posterior.

Geweke (1989), *Econometrica* 57; Owen (2013), *Monte Carlo Theory, Methods and Examples*, chapter 9.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_triangular
from scipy.special import gammaln

from missionplan.arrays import Array
from missionplan.montecarlo.streams import stream

DRAWS = 128

RAISED = (0.0, 1e-14, 1e-12, 1e-10)
"""Shares by which variances are raised in turn until their matrix has a factor."""


TAILS, WIDENED = 5, 1.2
"""Degrees of freedom of the law from which draws are made, and factor on the posterior's standard deviations: tails
heavier than the posterior's keep the weights bounded (Geweke 1989)."""


@dataclass(frozen=True)
class SampledEvidence:
    """Evidence by importance sampling."""

    log_evidence: float
    """ln p(data)."""
    effective: float
    """Effective number of draws, (Σw)²/Σw² (Owen 2013, section 9.3): small where the posterior is unlike the one
    assumed."""


def sampled_evidence(log_joint: Callable[[Array], Array], mean: Array, covariance: Array) -> SampledEvidence:
    """Integrate a joint density of data and parameters with draws from a Student-t about the assumed posterior.

    The evidence is the mean of the weights, joint density over proposal density (Owen 2013, section 9.1).

    Parameters
    ----------
    log_joint : callable
        ln p(data, parameters) of parameters, shape (s, k) → (s,); a value that is not finite counts as −∞.
    mean : array, shape (k,)
        Of the assumed posterior.
    covariance : array, shape (k, k)
        Of the assumed posterior.

    Raises
    ------
    numpy.linalg.LinAlgError
        When the covariance is not positive definite.
    """
    logs = _weighed(log_joint, mean, covariance)
    if np.all(np.isneginf(logs)):
        return SampledEvidence(-np.inf, 0.0)
    weights = np.exp(logs - logs.max())
    evidence = float(logs.max() + np.log(weights.mean()))
    return SampledEvidence(evidence, float(weights.sum() ** 2 / np.sum(weights**2)))


def _weighed(log_joint: Callable[[Array], Array], mean: Array, covariance: Array) -> Array:
    """Logs of the weights of draws from the proposal, shape (s,)."""
    shape, factor = _with_factor(WIDENED**2 * covariance)
    generator = stream(0, "diagnose.importance", 0)
    scale = generator.chisquare(TAILS, DRAWS) / TAILS
    normals = generator.multivariate_normal(np.zeros(len(mean)), shape, DRAWS)
    at: Array = mean + normals / np.sqrt(scale)[:, None]
    logs = log_joint(at) - log_student_density(at, mean, factor, TAILS)
    return np.where(np.isfinite(logs), logs, -np.inf)


def even_points(count: int, dimension: int) -> Array:
    """Points that fill the unit cube evenly, shape (count, dimension): a Kronecker sequence.

    Its steps are powers of the root of x^(d+1) = x + 1, the golden ratio in one dimension, of which fractions are poor
    approximations (Roberts 2018, *The Unreasonable Effectiveness of Quasirandom Sequences*).
    """
    root = 1.5
    for _ in range(60):
        root = (1.0 + root) ** (1.0 / (dimension + 1.0))
    steps = root ** -np.arange(1.0, dimension + 1.0)
    return np.asarray((0.5 + np.arange(1.0, count + 1.0)[:, None] * steps) % 1.0)


def _with_factor(shape: Array) -> tuple[Array, Array]:
    """A matrix with its lower Cholesky factor; where rounding has left none, its diagonal is raised until there is one.

    The draws are then wider than the posterior across the direction in which the data fix the parameters best.
    """
    for share in RAISED:
        try:
            raised = shape + share * np.diag(np.diag(shape)) if share else shape
            return raised, np.asarray(np.linalg.cholesky(raised), dtype=float)
        except np.linalg.LinAlgError:
            continue
    raise np.linalg.LinAlgError("the covariance is not positive definite")


def log_student_density(at: Array, mean: Array, factor: Array, dof: int) -> Array:
    """Log density of the multivariate Student-t distribution.

    Parameters
    ----------
    at : array, shape (s, k)
    mean : array, shape (k,)
    factor : array, shape (k, k)
        Lower Cholesky factor of its shape matrix.
    dof : int
        Degrees of freedom.

    Returns
    -------
    array, shape (s,)
    """
    dimension = len(mean)
    squared = np.sum(solve_triangular(factor, (at - mean).T, lower=True) ** 2, axis=0)
    constant = gammaln(0.5 * (dof + dimension)) - gammaln(0.5 * dof) - 0.5 * dimension * np.log(dof * np.pi)
    density: Array = constant - np.log(np.diag(factor)).sum() - 0.5 * (dof + dimension) * np.log1p(squared / dof)
    return density
