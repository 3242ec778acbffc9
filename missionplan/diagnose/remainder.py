"""Remainder: is anything smooth left? A Gaussian process, as a test and not as a repair (Kennedy & O'Hagan 2001)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack, solve_triangular
from scipy.spatial.distance import cdist
from scipy.special import logsumexp

from missionplan.diagnose.residuals import Axis, Residuals, ResidualTest, rejects, residual_tests

Array = NDArray[np.float64]

THRESHOLD = 3.0
"""ln Bayes factor above which a remainder is claimed."""
LENGTHS = (0.06, 0.12, 0.25, 0.5, 1.0)
"""Correlation lengths, of the axis' extent."""
SIZES = (0.25, 0.5, 1.0, 2.0, 4.0)
"""Standard deviations of the smooth part, of the model's own typical one."""
SCALES = (0.7, 0.8, 0.9, 1.0, 1.1, 1.2)
"""Factors by which the model's own standard deviation may be off."""
SCALE_SPREAD = 0.12
NEGLIGIBLE = 1e-7


@dataclass(frozen=True)
class Remainder:
    """What is left after the causes.

    Attributes
    ----------
    log_bayes_factor : float
        Of a smooth remainder along some axis over none; the axes share the prior equally.
    axis : str or None
        Along which, when there is one.
    by_axis : tuple
        Axis and its own ln Bayes factor, greatest first.
    tests : tuple of ResidualTest
        Tests of the innovations.
    speaks : bool
        Whether there is a remainder.
    """

    log_bayes_factor: float
    axis: str | None
    by_axis: tuple[tuple[str, float], ...]
    tests: tuple[ResidualTest, ...]
    speaks: bool


def remainder(residuals: Residuals) -> Remainder:
    """Test what a model leaves, along every axis and by residual tests at the strict level."""
    factor = np.asarray(np.linalg.cholesky(residuals.covariance), dtype=float)
    innovations = solve_triangular(factor, residuals.values, lower=True, check_finite=False)
    typical = float(np.sqrt(np.median(np.diag(residuals.covariance))))
    found = [(axis.name, _log_bayes_factor(axis, factor, innovations, typical)) for axis in residuals.axes.values()]
    found.sort(key=lambda item: -item[1])
    together = float(logsumexp([value for _, value in found]) - np.log(len(found))) if found else 0.0
    tests = residual_tests(residuals, innovations)
    failed = rejects(tests, residuals.level)
    speaks = together > THRESHOLD or failed
    axis = None
    if speaks:
        axis = found[0][0] if together > THRESHOLD else "time"
    return Remainder(together, axis, tuple(found), tests, speaks)


def _log_bayes_factor(axis: Axis, factor: Array, innovations: Array, typical: float) -> float:
    """Mean over lengths, sizes and scales of the evidence with the smooth part, over that without."""
    with_it, prior = [], -0.5 * (np.log(SCALES) / SCALE_SPREAD) ** 2
    prior -= logsumexp(prior)
    total = float(innovations @ innovations)
    count = len(innovations)
    plain = _log_likelihoods(np.zeros(0), np.zeros(0), total, count, 0.0)
    for length in LENGTHS:
        low_rank = _smooth_functions(axis, length)
        whitened = solve_triangular(factor, low_rank * typical, lower=True, check_finite=False)
        values, vectors = np.linalg.eigh(whitened.T @ whitened)
        kept = values > NEGLIGIBLE * max(float(values.max(initial=0.0)), 1e-300)
        values, vectors = values[kept], vectors[:, kept]
        projected = (vectors.T @ (whitened.T @ innovations)) ** 2 / values
        with_it += [_log_likelihoods(values, projected, total, count, size) + prior for size in SIZES]
    averaged = float(logsumexp(np.stack(with_it))) - np.log(len(with_it))
    return float(averaged - logsumexp(plain + prior))


def _log_likelihoods(values: Array, projected: Array, total: float, count: int, size: float) -> Array:
    """Log likelihood at each scale, up to a constant, with covariance scale²·I + size²·values in the eigenbasis."""
    variance = np.array(SCALES)[:, None] ** 2
    along = variance + size**2 * values[None, :]
    rest = (count - len(values)) * np.log(variance[:, 0]) + (total - projected.sum()) / variance[:, 0]
    return np.asarray(-0.5 * (rest + np.log(along).sum(axis=1) + (projected[None, :] / along).sum(axis=1)))


def _smooth_functions(axis: Axis, length: float) -> Array:
    """Columns B with B Bᵀ the squared-exponential covariance of the axis' smooth functions, shape (N, m)."""
    places, index = np.unique(axis.inputs, axis=0, return_inverse=True)
    kernel = np.exp(-0.5 * cdist(places, places, "sqeuclidean") / length**2)
    factor, pivots, rank, _ = lapack.dpstrf(kernel, tol=NEGLIGIBLE, lower=1)
    basis = np.empty((len(places), rank))
    basis[pivots - 1] = np.tril(factor)[:, :rank]
    basis = basis[index.ravel()]
    return np.concatenate([basis * direction[:, None] for direction in axis.directions.T], axis=1)
