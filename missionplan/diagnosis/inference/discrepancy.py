"""Discrepancy: is anything smooth left? A Gaussian process, as a test and not as a repair (Kennedy & O'Hagan 2001)."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_triangular
from scipy.special import logsumexp

from missionplan.arrays import Array
from missionplan.diagnosis.inference.axes import Axis
from missionplan.diagnosis.inference.residual_tests import ResidualTest, rejects, residual_tests
from missionplan.diagnosis.inference.residuals import Residuals

THRESHOLD = 3.0
"""ln Bayes factor above which a remainder is claimed."""
LENGTHS = (0.06, 0.12, 0.25, 0.5, 1.0)
"""Correlation lengths, of the axis' extent."""
SIZES = (0.25, 0.5, 1.0, 2.0, 4.0)
"""Standard deviations of the smooth part, of the model's own typical one."""
SCALES = (0.7, 0.8, 0.9, 1.0, 1.1, 1.2)
"""Factors by which the model's own standard deviation may be off."""
SCALE_SPREAD = 0.12
SCALE_PRIOR = -0.5 * (np.log(SCALES) / SCALE_SPREAD) ** 2
SCALE_PRIOR -= logsumexp(SCALE_PRIOR)
NEGLIGIBLE = 1e-7


@dataclass(frozen=True)
class Shape:
    """What a remainder would be along its axis, to first order: the likeliest smooth function and how unsure it is.

    Attributes
    ----------
    place, value : str
        Labels with units.
    at, mean, sd : array, shape (m,)
        Places on the axis, the function's posterior mean there and its standard deviation.
    """

    place: str
    value: str
    at: Array
    mean: Array
    sd: Array


@dataclass(frozen=True)
class Discrepancy:
    """What is left after the causes.

    Attributes
    ----------
    log_bayes_factor : float
        Of a smooth remainder along some axis over none; the axes share the prior equally.
    axis : str or None
        Along which, when there is one.
    by_axis : tuple
        What would be smooth along each axis, in words, and its own ln Bayes factor, greatest first.
    tests : tuple of ResidualTest
        Tests of the innovations.
    significant : bool
        Whether there is a remainder.
    resembles : str or None
        What it looks like most, in words, when it is smooth.
    shape : Shape or None
        That function, where it is a single one of one dimension.
    """

    log_bayes_factor: float
    axis: str | None
    by_axis: tuple[tuple[str, float], ...]
    tests: tuple[ResidualTest, ...]
    significant: bool
    resembles: str | None
    shape: Shape | None


def discrepancy(residuals: Residuals) -> Discrepancy:
    """Test what a model leaves, along every axis and by residual tests."""
    innovations = residuals.innovations()
    found = _by_axis(residuals)
    together = float(logsumexp([value for _, value in found]) - np.log(len(found))) if found else 0.0
    tests = residual_tests(residuals, innovations)
    failed = rejects(tests)
    significant = together > THRESHOLD or failed
    likeliest = found[0][0] if together > THRESHOLD else None
    axis = (likeliest.name if likeliest else "time") if significant else None
    by_axis = tuple((axis.words, value) for axis, value in found)
    words, shape = (likeliest.words, _shape(likeliest, residuals)) if likeliest else (None, None)
    return Discrepancy(together, axis, by_axis, tests, significant, words, shape)


def _by_axis(residuals: Residuals) -> list[tuple[Axis, float]]:
    """Ln Bayes factor of a smooth remainder along each axis over none, greatest first."""
    axes = residuals.axes
    if not axes:
        return []
    columns = np.concatenate([axis.response for axis in axes], axis=1)
    ends = np.cumsum([axis.response.shape[1] for axis in axes])
    parts = [slice(end - axis.response.shape[1], end) for axis, end in zip(axes, ends, strict=True)]
    bases = [_bases(axis, residuals) for axis in axes]
    plain, with_it = [], []
    for found in residuals.products(columns):
        total, count = float(found.gram[-1, -1]), len(residuals.values)
        known = found.log_weight - 0.5 * found.log_determinant
        plain.append(known + float(logsumexp(_log_likelihoods(np.zeros(0), np.zeros(0), total, count))))
        with_it.append(
            [
                known + _averaged(found.gram[part, part], found.gram[part, -1], basis, total, count)
                for part, basis in zip(parts, bases, strict=True)
            ]
        )
    logs = logsumexp(with_it, axis=0) - logsumexp(plain)
    order = np.argsort(-logs, kind="stable")
    return [(axes[index], float(logs[index])) for index in order]


def _shape(axis: Axis, residuals: Residuals) -> Shape | None:
    """Posterior of the function at the likeliest noise, length and size."""
    if axis.measure is None:
        return None
    best, mean, sd = -np.inf, np.zeros(len(axis.places)), np.zeros(len(axis.places))
    bases = _bases(axis, residuals)
    for found in residuals.products(axis.response):
        for basis in bases:
            gram, right = basis.T @ found.gram[:-1, :-1] @ basis, basis.T @ found.gram[:-1, -1]
            for size in SIZES:
                factor = np.linalg.cholesky(gram + np.eye(len(gram)) / size**2)
                half = solve_triangular(factor, np.column_stack([right, basis.T]), lower=True)
                log_likelihood = found.log_weight - 0.5 * found.log_determinant + 0.5 * float(half[:, 0] @ half[:, 0])
                log_likelihood -= 0.5 * float(found.gram[-1, -1]) + float(np.log(size * np.diag(factor)).sum())
                if log_likelihood > best:
                    best, mean, sd = (
                        log_likelihood,
                        half[:, 1:].T @ half[:, 0],
                        np.sqrt(np.sum(half[:, 1:] ** 2, axis=0)),
                    )
    measure = axis.measure
    at = measure.low + (measure.high - measure.low) * axis.places[:, 0]
    return Shape(measure.place, measure.value, at, measure.factor * mean, measure.factor * sd)


def _bases(axis: Axis, residuals: Residuals) -> list[Array]:
    """Smooth functions of each length: they move the data, on average over the record, by the model's typical sd."""
    typical = float(np.sqrt(np.median(np.diag(residuals.covariance))))
    inner, size = axis.response.T @ axis.response, len(axis.places)
    bases = []
    for length in LENGTHS:
        basis = np.kron(np.eye(axis.response.shape[1] // size), axis.smooth(length))
        variance = float(np.sum(basis * (inner @ basis))) / len(axis.response)
        bases.append(typical / np.sqrt(max(variance, 1e-300)) * basis)  # nothing may feel it at all
    return bases


def _averaged(gram: Array, right: Array, bases: Sequence[Array], total: float, count: int) -> float:
    """Log evidence with a smooth part along one axis, mean over lengths and sizes, up to a constant."""
    logs = []
    for basis in bases:
        values, vectors = np.linalg.eigh(basis.T @ gram @ basis)
        kept = values > NEGLIGIBLE * max(float(values.max(initial=0.0)), 1e-300)
        values, vectors = values[kept], vectors[:, kept]
        logs.append(_log_likelihoods(values, (vectors.T @ (basis.T @ right)) ** 2 / values, total, count))
    return float(logsumexp(logs)) - float(np.log(len(logs)))


def _log_likelihoods(values: Array, projected: Array, total: float, count: int) -> Array:
    """Log likelihood with covariance scale²·I + size²·values in the eigenbasis at each size and scale, with priors."""
    variance = np.array(SCALES)[:, None] ** 2
    along = variance + np.array(SIZES)[:, None, None] ** 2 * values
    rest = (count - len(values)) * np.log(variance[:, 0]) + (total - projected.sum()) / variance[:, 0]
    logs = -0.5 * (rest + np.log(along).sum(axis=2) + (projected / along).sum(axis=2))
    return np.asarray(logs + SCALE_PRIOR - np.log(len(SIZES)))
