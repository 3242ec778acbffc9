"""Evidence of linear models, coefficients integrated out: normal errors exactly, Student-t by Laplace, many sets.

Given the noise, a set of causes differs from another by the prior of the coefficients alone, so that all sets share the
inner products of the whitened columns (Rasmussen & Williams 2006, *Gaussian Processes for Machine Learning*, Eqs. 2.8
and 2.30; Bishop 2006, *Pattern Recognition and Machine Learning*, Eq. 3.86; Lange, Little & Taylor 1989, *J. Am. Stat.
Assoc.* 84).

Shapes: two independent components of each of n errors, k coefficients.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
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
    Eqs. 3.49 to 3.51 and 3.86), from inner products of whitened columns. Raises numpy.linalg.LinAlgError when the
    posterior has no covariance.

    `gram`, shape (k + 1, k + 1): inner products of the whitened columns and, last, the whitened data; those of parts of
    the data add up. `prior_sd`, shape (k,) or (k, k): prior standard deviations of the coefficients; a factor R of the
    covariance R Rᵀ where they are tied. `log_determinant`: ln |covariance| of the noise. `count`: of data.
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

    `y`, shape (2, n): data. `design`, shape (2, n, k), and `prior_sd`, shape (k,): columns of the coefficients, and
    their prior standard deviations. `variance`, shape (2, n): for each axis. `dof`: degrees of freedom ν, above 2.
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


SCALES = (0.75, 1.13, 1.9, 4.5)
"""Factors √λ on a slab, λ inverse-gamma (3/2, 3/2): with them a slab is a Student-t law of three degrees of freedom, so
that a strong effect is not shrunk (Gelman et al. 2013, section 17.2). Medians of its parts of probability
`SCALE_PRIOR`."""
SCALE_PRIOR = (0.3, 0.35, 0.25, 0.1)
AT_ONCE = 500_000
"""Numbers in the largest array of sets, noises and columns."""


@dataclass(frozen=True)
class GramMatrix:
    """Whitened data and columns of a linear model under one noise, and blocks of further columns, each at most once."""

    products: Array
    """Inner products of the columns and, last, the data, shape (k + 1, k + 1)."""
    log_normaliser: float
    """ln density of the data where all of them are nil."""
    further: Array | None = None
    """Inner products of these with the blocks' columns, those of smaller blocks first, shape (k + 1, m)."""
    inner: tuple[Array, ...] = ()
    """Of the blocks of each size q, the smallest first, those of their own columns, shape (b, q, q)."""

    def joined(self, first: int, size: int) -> "GramMatrix":
        """Return that with the columns of a block, one of `blocks_by_size`, after the others."""
        assert self.further is not None
        own = self.further[:, first : first + size]
        alike = next(each for each in self.inner if each.shape[1] == size)
        before = sum(each.shape[0] * each.shape[1] for each in self.inner if each.shape[1] < size)
        inner = alike[(first - before) // size]
        k = len(self.products) - 1
        rows = [
            [self.products[:k, :k], own[:k], self.products[:k, k:]],
            [own[:k].T, inner, own[k:].T],
            [self.products[k:, :k], own[k:], self.products[k:, k:]],
        ]
        return GramMatrix(np.block(rows), self.log_normaliser)


def blocks_by_size(sizes: NDArray[np.int_]) -> NDArray[np.int_]:
    """Return first column and size of blocks as they stand in `GramMatrix.further`: smaller ones first, (b,) → (b, 2).

    Those of one size stand in their order.
    """
    order = np.argsort(sizes, kind="stable")
    firsts = np.empty(len(sizes), dtype=int)
    firsts[order] = np.cumsum(sizes[order]) - sizes[order]
    return np.stack([firsts, sizes], axis=1)


@dataclass(frozen=True)
class SetPriors:
    """Normal priors of k coefficients under s sets: means (s, k), and factors L of the covariances L Lᵀ, (s, k, k)."""

    mean: Array
    factor: Array

    def of(self, chosen: NDArray[np.int_]) -> "SetPriors":
        """Return those of some of the sets."""
        return SetPriors(self.mean[chosen], self.factor[chosen])

    def log_densities(self, grams: Sequence[GramMatrix]) -> Array:
        """Log density of the data under each set with each of j noises, shape (j, s)."""
        products, normalisers = _stacked(grams)
        return self._solved(products, normalisers)[0]

    def _solved(self, products: Array, normalisers: Array) -> tuple[Array, Array, Array]:
        """Log densities (j, s), Cholesky factors of the precisions (j, s, k, k), whitened right sides (j, s, k)."""
        columns, with_data = products[:, None, :-1, :-1], products[:, :-1, -1]
        turned = np.swapaxes(self.factor, 1, 2)
        precision = turned @ columns @ self.factor
        precision += np.eye(precision.shape[-1])
        moved = self.mean @ products[:, :-1, :-1]
        right = ((with_data[:, None] - moved)[:, :, None, :] @ self.factor)[:, :, 0]
        factor = np.linalg.cholesky(precision)
        white = np.linalg.solve(factor, right[..., None])[..., 0]
        squared = products[:, -1, -1, None] - 2.0 * (with_data @ self.mean.T) + np.sum(moved * self.mean, axis=-1)
        logs = normalisers[:, None] - 0.5 * (squared - np.sum(white**2, axis=-1))
        logs -= np.log(np.diagonal(factor, axis1=-2, axis2=-1)).sum(axis=-1)
        return np.asarray(logs), np.asarray(factor, dtype=float), np.asarray(white)

    def gains(self, grams: Sequence[GramMatrix], blocks: NDArray[np.int_], scale: float) -> Array:
        """What blocks of further columns, one at a time, add to the log densities, shape (j, s, b).

        `blocks`: of `blocks_by_size`. `scale`: standard deviation of the normal prior of each of their coefficients.
        """
        sets, k, _ = self.factor.shape
        together = max(AT_ONCE // (k * max(int(blocks[:, 1].sum()), 1)), 1)
        of_sets = [self.of(some) for some in np.array_split(np.arange(sets), math.ceil(sets / together))]
        noises = max(together // sets, 1)
        parts = [grams[first : first + noises] for first in range(0, len(grams), noises)]
        return np.concatenate(
            [np.concatenate([own._gains(part, blocks, scale) for own in of_sets], axis=1) for part in parts]
        )

    def _gains(self, grams: Sequence[GramMatrix], blocks: NDArray[np.int_], scale: float) -> Array:
        _, factor, white = self._solved(*_stacked(grams))
        further = np.stack([gram.further for gram in grams if gram.further is not None])
        half = (np.linalg.inv(factor) @ np.swapaxes(self.factor, 1, 2)) @ further[:, None, :-1]
        right = further[:, None, -1] - self.mean @ further[:, :-1] - (white[..., None, :] @ half)[..., 0, :]
        found = np.empty((*white.shape[:2], len(blocks)))
        for place, size in enumerate(np.unique(blocks[:, 1]).tolist()):
            alike = np.flatnonzero(blocks[:, 1] == size)
            first = int(blocks[alike[0], 0])
            own = slice(first, first + size * len(alike))
            inner = np.stack([gram.inner[place] for gram in grams])
            halves = half[..., own].reshape(*half.shape[:3], len(alike), size).swapaxes(2, 3)
            left = inner[:, None] - np.swapaxes(halves, -1, -2) @ halves
            rights = right[..., own].reshape(*left.shape[:-1])
            found[..., alike] = log_factor(scale**2 * left, scale * rights)
        return found

    def posterior(self, grams: Sequence[GramMatrix]) -> tuple[Array, Array]:
        """Posterior means (j, s, k) and factors R, (j, s, k, k), of the covariances R Rᵀ."""
        _, factor, white = self._solved(*_stacked(grams))
        root = self.factor @ np.swapaxes(np.linalg.inv(factor), -1, -2)
        return self.mean + (root @ white[..., None])[..., 0], root


def log_factor(inner: Array, right: Array) -> Array:
    """Ln of the factor by which q coefficients N(0, 1) change a density, of inner products (…, q, q) and (…, q)."""
    size = right.shape[-1]
    if size == 1:
        precision = np.maximum(inner[..., 0, 0], 0.0) + 1.0
        return np.asarray(0.5 * (right[..., 0] ** 2 / precision - np.log(precision)))
    bordered = np.empty((*inner.shape[:-2], size + 1, size + 1))
    bordered[..., :size, :size] = inner + np.eye(size)
    bordered[..., size, :size] = bordered[..., :size, size] = right
    bordered[..., size, size] = 1.0 + np.sum(right**2, axis=-1)  # more than rightᵀ (inner + 1)⁻¹ right
    factor = np.linalg.cholesky(bordered)
    logs = np.log(np.diagonal(factor, axis1=-2, axis2=-1)[..., :size]).sum(axis=-1)
    return np.asarray(0.5 * np.sum(factor[..., size, :size] ** 2, axis=-1) - logs)


def log_slab_factor(inner: Array, right: Array) -> Array:
    """The same for coefficients with a slab of unit size, a mean over its scales."""
    scales = np.array(SCALES)
    logs = log_factor(np.multiply.outer(scales**2, inner), np.multiply.outer(scales, right))
    shares = np.log(SCALE_PRIOR).reshape(-1, *(1,) * (logs.ndim - 1))
    return np.asarray(np.logaddexp.reduce(logs + shares, axis=0))


def _stacked(grams: Sequence[GramMatrix]) -> tuple[Array, Array]:
    return np.stack([gram.products for gram in grams]), np.array([gram.log_normaliser for gram in grams])
