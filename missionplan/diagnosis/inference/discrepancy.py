"""Model discrepancy: whether a fitted model leaves something smooth along an axis, or innovations that are not white.

A Gaussian process δ(x) beside the model, as Kennedy & O'Hagan (2001, *J. R. Stat. Soc. B* 63) have it, but as a test
and not as a repair: its Bayes factor is computed and its shape shown; nothing of it enters the extended model. Marginal
likelihoods of Gaussian processes are those of Rasmussen & Williams (2006, *Gaussian Processes for Machine Learning*,
Eq. 2.30), with a covariance of low rank.
"""

import itertools
from collections.abc import Sequence

import numpy as np
from scipy.linalg import solve_triangular
from scipy.special import logsumexp

from missionplan.arrays import Array
from missionplan.diagnosis.inference.axes import Axis
from missionplan.diagnosis.inference.block_covariance import InnerProducts
from missionplan.diagnosis.inference.residual_tests import Residuals, rejects, residual_tests
from missionplan.results.learned.evidence import Discrepancy, DiscrepancyShape

THRESHOLD = 3.0
"""ln Bayes factor above which there is a discrepancy."""
LENGTHS = (0.06, 0.12, 0.25, 0.5, 1.0)
"""Correlation lengths over which the test averages, as shares of the axis' extent."""
SIZES = (0.25, 0.5, 1.0, 2.0, 4.0)
"""Standard deviations of the smooth part over which it averages, as multiples of the residuals' typical one."""
SCALES = (0.7, 0.8, 0.9, 1.0, 1.1, 1.2)
"""Factors on the model's own standard deviation over which it averages."""
SCALE_SPREAD = 0.12
"""Prior standard deviation of their logarithm."""
SCALE_PRIOR = -0.5 * (np.log(SCALES) / SCALE_SPREAD) ** 2
SCALE_PRIOR -= logsumexp(SCALE_PRIOR)
TOGETHER = 1000
"""Columns, at most, of axes that are whitened together."""
NEGLIGIBLE = 1e-7
"""Eigenvalues below this share of the greatest count as zero."""


def discrepancy(residuals: Residuals) -> Discrepancy:
    """Test what a model leaves, along every axis and by residual tests.

    Parameters
    ----------
    residuals : Residuals
        What it leaves, with their covariance and the axes to look along.
    """
    found = along_each_axis(residuals)
    together = float(logsumexp([value for _, value in found]) - np.log(len(found))) if found else 0.0
    tests = residual_tests(residuals, residuals.innovations())
    likeliest = found[0][0] if together > THRESHOLD else None
    by_axis = tuple((axis.description, value) for axis, value in found)
    if likeliest is not None:
        shape = _shape(likeliest, residuals)
        return Discrepancy(together, likeliest.name, by_axis, tests, likeliest.description, shape)
    return Discrepancy(together, "time" if rejects(tests) else None, by_axis, tests)


def along_each_axis(residuals: Residuals) -> list[tuple[Axis, float]]:
    """Return the ln Bayes factor of a smooth function along each axis over none, greatest first."""
    axes = residuals.axes
    if not axes:
        return []
    plain: list[float] = []
    with_it: list[float] = []
    for batch in _batches(axes):
        ends = np.cumsum([axis.response.shape[1] for axis in batch])
        parts = [slice(end - axis.response.shape[1], end) for axis, end in zip(batch, ends, strict=True)]
        bases = [_bases(axis, residuals) for axis in batch]
        plain, by_noise = [], []
        for found in residuals.inner_products(np.concatenate([axis.response for axis in batch], axis=1)):
            total, count = float(found.gram[-1, -1]), len(residuals.values)
            known = found.log_weight - 0.5 * found.log_determinant
            plain.append(known + float(logsumexp(_log_likelihoods(np.zeros(0), np.zeros(0), total, count))))
            by_noise.append(
                [
                    known + _averaged(found.gram[part, part], found.gram[part, -1], basis, total, count)
                    for part, basis in zip(parts, bases, strict=True)
                ]
            )
        with_it += logsumexp(by_noise, axis=0).tolist()
    logs = np.array(with_it) - logsumexp(plain)
    order = np.argsort(-logs, kind="stable")
    return [(axes[index], float(logs[index])) for index in order]


def _batches(axes: Sequence[Axis]) -> list[list[Axis]]:
    """Axes in their order, together as long as they have few columns: inner products are of each with every other."""
    found: list[list[Axis]] = [[]]
    for axis in axes:
        if found[-1] and sum(each.response.shape[1] for each in (*found[-1], axis)) > TOGETHER:
            found.append([])
        found[-1].append(axis)
    return found


def _shape(axis: Axis, residuals: Residuals) -> DiscrepancyShape | None:
    """Posterior of the function at the likeliest noise, length and size (Rasmussen & Williams 2006, Eq. 2.8)."""
    scale = axis.scale
    if scale is None:
        return None
    bases = _bases(axis, residuals)
    posteriors = (
        _function_posterior(products, basis, size)
        for products in residuals.inner_products(axis.response)
        for basis, size in itertools.product(bases, SIZES)
    )
    _, mean, sd = max(posteriors, key=lambda found: found[0])
    at = scale.low + (scale.high - scale.low) * axis.places[:, 0]
    return DiscrepancyShape(scale.place, scale.value, at, scale.factor * mean, scale.factor * sd)


def _function_posterior(products: InnerProducts, basis: Array, size: float) -> tuple[float, Array, Array]:
    """Log evidence of a function size·basis·z with z ~ N(0, I), and its posterior mean and sd at the places, (m,)."""
    gram, right = basis.T @ products.gram[:-1, :-1] @ basis, basis.T @ products.gram[:-1, -1]
    factor = np.linalg.cholesky(gram + np.eye(len(gram)) / size**2)
    half = solve_triangular(factor, np.column_stack([right, basis.T]), lower=True)
    evidence = products.log_weight - 0.5 * products.log_determinant + 0.5 * float(half[:, 0] @ half[:, 0])
    evidence -= 0.5 * float(products.gram[-1, -1]) + float(np.log(size * np.diag(factor)).sum())
    return evidence, half[:, 1:].T @ half[:, 0], np.sqrt(np.sum(half[:, 1:] ** 2, axis=0))


def _bases(axis: Axis, residuals: Residuals) -> list[Array]:
    """Columns of smooth functions of each length, scaled so that their mean variance in the data is the typical one."""
    typical = float(np.sqrt(np.median(residuals.covariance.variances)))
    inner, size = axis.response.T @ axis.response, len(axis.places)
    bases = []
    for length in LENGTHS:
        basis = np.kron(np.eye(axis.response.shape[1] // size), axis.smooth(length))
        variance = float(np.sum(basis * (inner @ basis))) / len(axis.response)
        bases.append(typical / np.sqrt(max(variance, 1e-300)) * basis)  # the data may not respond at all
    return bases


def _averaged(gram: Array, right: Array, bases: Sequence[Array], total: float, count: int) -> float:
    """Log evidence with a smooth function along one axis, averaged over lengths and sizes, up to a constant."""
    logs = []
    for basis in bases:
        values, vectors = np.linalg.eigh(basis.T @ gram @ basis)
        kept = values > NEGLIGIBLE * max(float(values.max(initial=0.0)), 1e-300)
        values, vectors = values[kept], vectors[:, kept]
        logs.append(_log_likelihoods(values, (vectors.T @ (basis.T @ right)) ** 2 / values, total, count))
    return float(logsumexp(logs)) - float(np.log(len(logs)))


def _log_likelihoods(values: Array, projected: Array, total: float, count: int) -> Array:
    """Log likelihood with covariance scale²·I + size²·values at each size and scale, with their priors.

    In the eigenbasis of the smooth function's covariance, where the determinant and the quadratic form of Rasmussen &
    Williams (2006, Eq. 2.30) are sums.

    Parameters
    ----------
    values, projected : array, shape (r,)
        Eigenvalues, and squares of the data's components along their vectors.
    total : float
        Squared length of the data.
    count : int
        Number of data.
    """
    variance = np.array(SCALES)[:, None] ** 2
    along = variance + np.array(SIZES)[:, None, None] ** 2 * values
    rest = (count - len(values)) * np.log(variance[:, 0]) + (total - projected.sum()) / variance[:, 0]
    logs = -0.5 * (rest + np.log(along).sum(axis=2) + (projected / along).sum(axis=2))
    return np.asarray(logs + SCALE_PRIOR - np.log(len(SIZES)))
