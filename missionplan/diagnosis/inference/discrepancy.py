"""Model discrepancy: whether a fitted model leaves something smooth along an axis, or innovations that are not white.

A Gaussian process δ(x) beside the model, as Kennedy & O'Hagan (2001, *J. R. Stat. Soc. B* 63) have it, but as a test
and not as a repair: its Bayes factor is computed and its shape shown; nothing of it enters the extended model. Marginal
likelihoods of Gaussian processes are those of Rasmussen & Williams (2006, *Gaussian Processes for Machine Learning*,
Eq. 2.30), with a covariance of low rank.
"""

import itertools
from collections.abc import Callable, Mapping, Sequence

import numpy as np
from scipy.linalg import solve_triangular
from scipy.special import logsumexp

from missionplan.arrays import Array
from missionplan.diagnosis.inference.axes import Axis, differing
from missionplan.diagnosis.inference.block_covariance import InnerProducts
from missionplan.diagnosis.inference.residual_tests import Residuals, rejects, residual_tests
from missionplan.diagnosis.inference.responses import LENGTHS, Responses
from missionplan.diagnosis.inference.set_evidence import SCALES
from missionplan.results.learned.evidence import Causes, Discrepancy, DiscrepancyShape

THRESHOLD = 3.0
"""ln Bayes factor above which there is a discrepancy."""
USUAL = 1.0 / 3.0
"""Usual size of the smooth part, of the residuals' typical standard deviation."""


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
    axes, covariance = residuals.axes, residuals.covariance
    if not axes:
        return []
    typical = float(np.sqrt(np.median(covariance.variances)))
    responses = Responses.of(axes, covariance, np.zeros((len(residuals.values), 0))).in_size(USUAL * typical)
    gains = responses.log_gains(list(residuals.inner_products(responses.joined)))
    return [(axes[index], float(gains[index])) for index in np.argsort(-gains, kind="stable")]


def differing_causes(
    residuals_along: Callable[[Sequence[Axis]], Residuals], columns: Mapping[str, Array], parts: Sequence[Array]
) -> Causes:
    """Return the causes whose strengths differ between parts of the data.

    A strength of each part beside the common one, independent normals of unknown size, against none: the Bayes factor
    is averaged over the sizes and over the noises, so that it says more than the scatter that every model allows.

    Parameters
    ----------
    residuals_along : callable
        Of axes to look along: what the claimed set leaves.
    columns : mapping
        Response of the data to the strengths of each cause, shape (N, c).
    parts : sequence of array, shape (N, p)
        Divisions of the data: 1 where a datum is of a part.
    """
    axes = [
        differing(name, (part[:, :, None] * own[:, None]).reshape(len(own), -1))
        for name, own in columns.items()
        for part in parts
    ]
    found = {axis.description for axis, value in along_each_axis(residuals_along(axes)) if value > THRESHOLD}
    return tuple(name for name in columns if name in found)


def _shape(axis: Axis, residuals: Residuals) -> DiscrepancyShape | None:
    """Posterior of the function at the likeliest noise, length and size (Rasmussen & Williams 2006, Eq. 2.8)."""
    scale = axis.scale
    if scale is None:
        return None
    typical = float(np.sqrt(np.median(residuals.covariance.variances)))
    bases = [axis.smooth(length) for length in LENGTHS]
    squares = [np.sum(axis.smooth_columns(length) ** 2, axis=1) for length in LENGTHS]
    usual = [USUAL * typical / float(np.sqrt(np.mean(each))) for each in squares]
    posteriors = (
        _function_posterior(products, basis, size * unit)
        for products in residuals.inner_products(axis.response)
        for (basis, unit), size in itertools.product(zip(bases, usual, strict=True), SCALES)
    )
    _, mean, sd = max(posteriors, key=lambda found: found[0])
    at = scale.low + (scale.high - scale.low) * axis.places[:, 0]
    return DiscrepancyShape(scale.place, scale.value, at, scale.factor * mean, scale.factor * sd)


def _function_posterior(products: InnerProducts, basis: Array, size: float) -> tuple[float, Array, Array]:
    """Log evidence of a function size·basis·z with z ~ N(0, I), and its posterior mean and sd at the places, (m,)."""
    own = size * basis
    gram, right = own.T @ products.gram[:-1, :-1] @ own, own.T @ products.gram[:-1, -1]
    factor = np.linalg.cholesky(gram + np.eye(len(gram)))
    half = solve_triangular(factor, np.column_stack([right, own.T]), lower=True)
    evidence = products.log_density + 0.5 * float(half[:, 0] @ half[:, 0]) - float(np.log(np.diag(factor)).sum())
    return evidence, half[:, 1:].T @ half[:, 0], np.sqrt(np.sum(half[:, 1:] ** 2, axis=0))
