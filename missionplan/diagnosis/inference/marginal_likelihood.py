"""Marginal likelihoods of linear models, coefficients integrated out: normal errors exactly, Student-t by Laplace.

Rasmussen & Williams (2006), *Gaussian Processes for Machine Learning*; Bishop (2006), *Pattern Recognition and Machine
Learning*; Lange, Little & Taylor (1989), *J. Am. Stat. Assoc.* 84.

Shapes: two independent components of each of n errors, k coefficients.
"""

import math
from dataclasses import dataclass

import numpy as np
from scipy.linalg import lapack
from scipy.special import gammaln

from missionplan.arrays import Array

LOG_2PI = math.log(2.0 * math.pi)
QUANTILE_95 = 1.6448536269514722
"""95 % quantile of the standard normal distribution: half the width of a 90 % interval, in standard deviations."""
Normal = tuple[Array, Array]
"""A normal distribution: mean, shape (N,), and covariance, shape (N, N)."""
NEAR, TOLERANCE = 0.1, 1e-6
"""Last step below which Newton's is tried, and below which the mode is found [prior standard deviations]."""


def normal_log_pdf(x: Array, mean: Array | float, sd: Array | float) -> Array:
    """Log density of normal distributions of given means and standard deviations, shapes broadcast together."""
    return np.asarray(-0.5 * np.square((x - mean) / sd) - 0.5 * LOG_2PI - np.log(sd))


@dataclass(frozen=True)
class Marginal:
    """Log density of the data with the coefficients of a linear model integrated out, and their posterior."""

    log_density: float
    """ln p(y | covariance), priors of the coefficients included."""
    mean: Array
    """Posterior mean of the coefficients, shape (k,)."""
    covariance: Array
    """Posterior covariance, shape (k, k)."""


def gaussian_marginal(gram: Array, prior_sd: Array, log_determinant: float, count: int) -> Marginal:
    """Integrate out the coefficients of a linear model with normal errors and a normal prior about zero.

    Evidence and posterior of Bayesian linear regression (Rasmussen & Williams 2006, Eqs. 2.8 and 2.30; Bishop 2006,
    Eqs. 3.49 to 3.51 and 3.86), from inner products of whitened columns.

    Parameters
    ----------
    gram : array, shape (k + 1, k + 1)
        Inner products of the whitened columns and, last, the whitened data; those of parts of the data add up.
    prior_sd : array, shape (k,) or (k, k)
        Prior standard deviations of the coefficients; a factor R of their prior covariance R Rᵀ where they are tied.
    log_determinant : float
        ln |covariance| of the noise.
    count : int
        Number of data.

    Raises
    ------
    numpy.linalg.LinAlgError
        When the posterior has no covariance.
    """
    factor, white = _standardised_posterior(gram, prior_sd)
    inverse, _ = lapack.dtrtri(factor, lower=1)
    root = prior_sd[:, None] * inverse.T if prior_sd.ndim == 1 else prior_sd @ inverse.T
    return Marginal(_log_density(gram, factor, white, log_determinant, count), root @ white, root @ root.T)


def gaussian_log_density(gram: Array, prior_sd: Array, log_determinant: float, count: int) -> float:
    """Log density of `gaussian_marginal`, from the same arguments, in a third of its time."""
    return _log_density(gram, *_standardised_posterior(gram, prior_sd), log_determinant, count)


def standardised(columns: Array, prior_sd: Array) -> Array:
    """Columns, shape (m, k), of coefficients in prior standard deviations, shape (k,), or by a factor, shape (k, k)."""
    return np.asarray(columns * prior_sd if prior_sd.ndim == 1 else columns @ prior_sd)


def standardised_gram(gram: Array, prior_sd: Array) -> Array:
    """Inner products of columns, shape (k, k), as those of columns so standardised."""
    return np.asarray(prior_sd[:, None] * gram * prior_sd if prior_sd.ndim == 1 else prior_sd.T @ gram @ prior_sd)


def _standardised_posterior(gram: Array, prior_sd: Array) -> tuple[Array, Array]:
    """Lower Cholesky factor L of the posterior precision of the coefficients over their prior sds, and L⁻¹Xᵀy."""
    k = len(prior_sd)
    precision = standardised_gram(gram[:k, :k], prior_sd)
    precision.flat[:: k + 1] += 1.0
    factor, failed = lapack.dpotrf(precision, lower=1)
    if failed:
        raise np.linalg.LinAlgError("the coefficients' posterior has no covariance")
    white, _ = lapack.dtrtrs(factor, standardised(gram[None, :k, k], prior_sd)[0], lower=1)
    return factor, white


def _log_density(gram: Array, factor: Array, white: Array, log_determinant: float, count: int) -> float:
    quadratic = float(gram[-1, -1] - white @ white)
    determinant = log_determinant + 2.0 * float(np.log(factor.diagonal()).sum())
    return -0.5 * (quadratic + determinant + count * LOG_2PI)


def student_marginal(y: Array, design: Array, prior_sd: Array, variance: Array, dof: float) -> Marginal:
    """Integrate out the coefficients under bivariate Student-t errors, by Laplace's approximation.

    Errors of covariance diag(variance): ln p is −½(ν+2)·ln(1 + q/(ν−2)) + constant with q = Σ r²/variance. The mode is
    found by iteratively reweighted least squares with weights (ν+2)/(ν−2+q) (Lange, Little & Taylor 1989), near it
    by Newton's steps where they are shorter than the last step and lead uphill.

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
    sd = np.sqrt(variance)
    scaled_y = (y / sd).ravel()
    columns = (design * prior_sd / sd[:, :, None]).reshape(2 * n, k)
    transposed = np.ascontiguousarray(columns.T)
    coefficients, moved = np.zeros(k), math.inf
    for _ in range(60):
        residual = scaled_y - columns @ coefficients
        squared = np.square(residual).reshape(2, n).sum(axis=0)
        weight = (dof + 2.0) / (dof - 2.0 + squared)
        weighted = (transposed.reshape(k, 2, n) * weight).reshape(k, 2 * n)
        gradient = weighted @ residual - coefficients
        hessian = weighted @ columns
        hessian.flat[:: k + 1] += 1.0
        if moved < TOLERANCE:
            break
        _, step, _ = lapack.dposv(hessian, gradient)
        if moved < NEAR:
            newton = np.linalg.solve(_curvature(hessian, columns, residual, weight, dof), gradient)
            step = newton if newton @ gradient > 0.0 and np.abs(newton).max(initial=0.0) < moved else step
        coefficients, moved = coefficients + step, float(np.abs(step).max(initial=0.0))
    curvature = _curvature(hessian, columns, residual, weight, dof)
    if np.linalg.eigvalsh(curvature)[0] <= 0.0:
        curvature = hessian
    constant = gammaln(0.5 * dof + 1.0) - gammaln(0.5 * dof) - math.log(math.pi * (dof - 2.0))
    log_density = len(squared) * constant - 0.5 * (dof + 2.0) * float(np.log1p(squared / (dof - 2.0)).sum())
    log_density -= 0.5 * float(np.log(variance).sum()) + 0.5 * float(coefficients @ coefficients)
    log_density -= 0.5 * float(np.linalg.slogdet(curvature)[1])
    covariance = prior_sd[:, None] * np.linalg.inv(curvature) * prior_sd[None, :]
    return Marginal(log_density, prior_sd * coefficients, covariance)


def _curvature(hessian: Array, columns: Array, residual: Array, weight: Array, dof: float) -> Array:
    """Negative second derivatives of the log density, whose first part, `hessian`, takes the weights as given."""
    along = (residual[:, None] * columns).reshape(2, len(weight), -1).sum(axis=0)
    return np.asarray(hessian - along.T @ (along * (2.0 * weight**2 / (dof + 2.0))[:, None]))
