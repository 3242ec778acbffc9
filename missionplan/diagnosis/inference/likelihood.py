"""Likelihoods: a linear Gaussian model with its coefficients marginalised exactly, and Laplace's evidence.

Shapes: two independent axes (east and north, or the principal axes of the velocity error), n legs, k coefficients.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack, solve_triangular
from scipy.optimize import minimize
from scipy.special import gammaln

from missionplan.arrays import Array

LOG_2PI = math.log(2.0 * math.pi)
SEARCH_STEP = 1e-4
GRADIENT = 0.1
"""Gradient at which the climb ends: within 0.005 nats of the top where the posterior's standard deviation is 1."""
CURVATURE_STEP = 0.05
HALVINGS = 8
"""Times that step is halved where the function does not exist on both sides."""
IMPOSSIBLE = 1e12
NEAR, TOLERANCE = 0.01, 1e-6
"""Steps below which Newton's are tried, and below which the mode is found, in prior standard deviations."""


@dataclass(frozen=True)
class Marginal:
    """Log density of the data with the coefficients integrated out, and their posterior.

    Attributes
    ----------
    log_density : float
        ln p(y | covariance), priors of the coefficients included.
    mean : array, shape (k,)
        Posterior mean of the coefficients.
    covariance : array, shape (k, k)
        Posterior covariance.
    """

    log_density: float
    mean: Array
    covariance: Array


def marginal_of(gram: Array, prior_sd: Array, log_determinant: float, count: int) -> Marginal:
    """Marginalise the coefficients of a linear model of whitened data.

    Parameters
    ----------
    gram : array, shape (k + 1, k + 1)
        Inner products of the whitened columns and, last, the whitened data; those of parts of the data add up.
    prior_sd : array, shape (k,)
        Prior standard deviations of the coefficients.
    log_determinant : float
        ln |covariance| of the noise.
    count : int
        Number of data.

    Raises
    ------
    numpy.linalg.LinAlgError
        When the posterior has no covariance.
    """
    k = len(prior_sd)
    right = prior_sd * gram[:k, k]
    factor, failed = lapack.dpotrf(prior_sd[:, None] * gram[:k, :k] * prior_sd + np.eye(k), lower=1)
    if failed:
        raise np.linalg.LinAlgError("the coefficients' posterior has no covariance")
    both, _ = lapack.dpotrs(factor, np.column_stack([right, np.eye(k)]), lower=1)
    scaled = both[:, 0]
    log_determinant += 2.0 * float(np.log(np.diag(factor)).sum())
    covariance = prior_sd[:, None] * both[:, 1:] * prior_sd
    quadratic = float(gram[k, k] - right @ scaled)
    return Marginal(-0.5 * (quadratic + log_determinant + count * LOG_2PI), prior_sd * scaled, covariance)


def student_marginal(y: Array, design: Array, prior_sd: Array, variance: Array, dof: float) -> Marginal:
    """Marginalise the coefficients under Student-t errors of a leg (both axes share the tail), by Laplace.

    Errors of a leg are bivariate t of covariance diag(variance): ln p is −½(ν+2)·ln(1 + q/(ν−2)) with
    q = Σ r²/variance. The mode is found by iteratively reweighted least squares, near it by Newton's steps.

    Parameters
    ----------
    y : array, shape (2, n)
        Data.
    design : array, shape (2, n, k)
        Columns of the coefficients.
    prior_sd : array, shape (k,)
        Their prior standard deviations.
    variance : array, shape (2, n)
        Variances for each axis.
    dof : float
        Degrees of freedom ν, above 2.
    """
    k, n = len(prior_sd), y.shape[1]
    scaled_y = (y / np.sqrt(variance)).ravel()
    columns = (design * prior_sd / np.sqrt(variance)[:, :, None]).reshape(2 * n, k)
    coefficients, moved = np.zeros(k), math.inf
    for _ in range(60):
        residual = (scaled_y - columns @ coefficients).reshape(2, n)
        squared = np.sum(residual**2, axis=0)
        weight = (dof + 2.0) / (dof - 2.0 + squared)
        weighted = columns * np.concatenate([weight, weight])[:, None]
        gradient = weighted.T @ residual.ravel() - coefficients
        hessian = weighted.T @ columns + np.eye(k)
        along = (residual.ravel()[:, None] * columns).reshape(2, n, k).sum(axis=0)
        curvature = hessian - along.T @ (along * (2.0 * weight**2 / (dof + 2.0))[:, None])
        if moved < TOLERANCE:
            break
        step = np.linalg.solve(hessian, gradient)
        if moved < NEAR:
            newton = np.linalg.solve(curvature, gradient)
            step = newton if newton @ gradient > 0.0 and np.max(np.abs(newton), initial=0.0) < moved else step
        coefficients, moved = coefficients + step, float(np.max(np.abs(step), initial=0.0))
    if np.linalg.eigvalsh(curvature)[0] <= 0.0:
        curvature = hessian
    constant = gammaln(0.5 * dof + 1.0) - gammaln(0.5 * dof) - math.log(math.pi * (dof - 2.0))
    log_density = len(squared) * constant - 0.5 * (dof + 2.0) * float(np.log1p(squared / (dof - 2.0)).sum())
    log_density -= 0.5 * float(np.log(variance).sum()) + 0.5 * float(coefficients @ coefficients)
    log_density -= 0.5 * float(np.linalg.slogdet(curvature)[1])
    covariance = prior_sd[:, None] * np.linalg.inv(curvature) * prior_sd[None, :]
    return Marginal(log_density, prior_sd * coefficients, covariance)


def expected_log_ratio(mean: Array, truth: Array, first: Array, second: Array) -> float:
    """Mean of ln N(y; 0, first) − ln N(y; 0, second) over y ~ N(mean, truth): what data are expected to say.

    Parameters
    ----------
    mean : array, shape (N,)
        Of the data under the truth.
    truth, first, second : array, shape (N, N)
        Covariances.
    """
    total = 0.0
    for sign, covariance in ((-1.0, first), (1.0, second)):
        factor = np.linalg.cholesky(covariance)
        both = np.concatenate([np.linalg.cholesky(truth), mean[:, None]], axis=1)
        white = solve_triangular(factor, both, lower=True, check_finite=False)
        total += sign * (0.5 * float(np.sum(white**2)) + float(np.log(np.diag(factor)).sum()))
    return total


@dataclass(frozen=True)
class Laplace:
    """Evidence about the mode of a few hyperparameters.

    Attributes
    ----------
    log_evidence : float
        ln ∫ exp(log posterior).
    mode : array, shape (h,)
        Where it is greatest.
    covariance : array, shape (h, h)
        Inverse of the negative curvature there.
    """

    log_evidence: float
    mode: Array
    covariance: Array


def laplace(
    log_posterior: Callable[[Array], float], starts: list[Array], spread: Array, *, integrate: bool = True
) -> Laplace:
    """Maximise a log posterior (normalised prior times likelihood) and integrate it about its mode.

    Parameters
    ----------
    log_posterior : callable
        Of an array of shape (h,), smooth.
    starts : list of array
        Where to start; the best of them is climbed.
    spread : array, shape (h, h)
        A guess of the posterior covariance, which sets the first steps.
    integrate : bool
        Whether the curvature is wanted; without it the evidence is nan and the covariance is the guess.

    Raises
    ------
    numpy.linalg.LinAlgError
        When the mode lies on the edge of what is possible, where there is no curvature.
    """

    def negative(at: NDArray[Any]) -> float:
        try:
            value = log_posterior(at)
        except np.linalg.LinAlgError:
            return IMPOSSIBLE
        return -value if math.isfinite(value) else IMPOSSIBLE

    best = min(starts, key=negative)
    options: dict[str, Any] = {"gtol": GRADIENT, "eps": SEARCH_STEP, "maxiter": 60, "hess_inv0": spread}
    found = cast(Any, minimize)(negative, best, method="BFGS", options=options)
    mode = found.x if found.fun <= negative(best) else best
    if not integrate:
        return Laplace(math.nan, mode, spread)
    curvature = _curvature(negative, mode)
    values, vectors = np.linalg.eigh(curvature)
    values = np.maximum(values, 1e-2)
    evidence = -negative(mode) + 0.5 * len(mode) * LOG_2PI - 0.5 * float(np.log(values).sum())
    covariance = (vectors / values) @ vectors.T
    return Laplace(evidence, mode, 0.5 * (covariance + covariance.T))


def _curvature(negative: Callable[[Array], float], mode: Array) -> Array:
    """Second derivatives by central differences, with shorter steps beside an edge of what is possible."""
    count = len(mode)
    centre = negative(mode)
    found = [_either_side(negative, mode, unit) for unit in CURVATURE_STEP * np.eye(count)]
    unit, ahead, behind = (np.array(values) for values in zip(*found, strict=True))
    steps = np.diag(unit)
    result = np.empty((count, count))
    for i in range(count):
        result[i, i] = (ahead[i] - 2.0 * centre + behind[i]) / steps[i] ** 2
        for j in range(i):
            both, neither = negative(mode + unit[i] + unit[j]), negative(mode - unit[i] - unit[j])
            mixed = both + neither - ahead[i] - ahead[j] - behind[i] - behind[j] + 2.0 * centre
            result[i, j] = result[j, i] = mixed / (2.0 * steps[i] * steps[j])
    return result


def _either_side(negative: Callable[[Array], float], mode: Array, step: Array) -> tuple[Array, float, float]:
    """Step, halved until both sides are possible, and the function there."""
    for _ in range(HALVINGS):
        ahead, behind = negative(mode + step), negative(mode - step)
        if max(ahead, behind) < IMPOSSIBLE:
            return step, ahead, behind
        step = 0.5 * step
    raise np.linalg.LinAlgError("the best fit lies on the edge of what is possible")
