"""Evidence of linear models with normal errors, coefficients integrated out: one set of causes, or many at once.

Given the noise, a set of causes differs from another by the prior of the coefficients alone, so that all sets share the
inner products of the whitened columns (Rasmussen & Williams 2006, *Gaussian Processes for Machine Learning*, Eqs. 2.8
and 2.30; Bishop 2006, *Pattern Recognition and Machine Learning*, Eq. 3.86).

Shapes: two independent components of each of n errors, k coefficients.
"""

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack

from missionplan.arrays import Array

LOG_2PI = math.log(2.0 * math.pi)
QUANTILE_95 = 1.6448536269514722
"""95 % quantile of the standard normal distribution: half the width of a 90 % interval, in standard deviations."""
Normal = tuple[Array, Array]
"""A normal distribution: mean, shape (N,), and covariance, shape (N, N)."""


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


SCALES = (0.75, 1.13, 1.9, 4.5)
"""Factors √λ on a slab, λ inverse-gamma (3/2, 3/2): with them a slab is a Student-t law of three degrees of freedom, so
that a strong effect is not shrunk (Gelman et al. 2013, section 17.2). Medians of its parts of probability
`SCALE_PRIOR`."""
SCALE_PRIOR = (0.3, 0.35, 0.25, 0.1)
FEW = 4
"""Columns of a block up to which many blocks are worked on entry by entry."""
AT_ONCE = 120_000
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
        cross_products = self.further[:, first : first + size]
        alike = next(blocks for blocks in self.inner if blocks.shape[1] == size)
        before = sum(blocks.shape[0] * blocks.shape[1] for blocks in self.inner if blocks.shape[1] < size)
        inner = alike[(first - before) // size]
        k = len(self.products) - 1
        rows = [
            [self.products[:k, :k], cross_products[:k], self.products[:k, k:]],
            [cross_products[:k].T, inner, cross_products[k:].T],
            [self.products[k:, :k], cross_products[k:], self.products[k:, k:]],
        ]
        return GramMatrix(np.block(rows), self.log_normaliser)

    def log_density(self, mean: Array, factor: Array) -> float:
        """Log density of the data under one set: priors of the columns' coefficients as in `SetPriors`."""
        left = self.products[:, -1] - self.products[:, :-1] @ mean
        products = self.products.copy()
        products[:-1, -1] = products[-1, :-1] = left[:-1]
        products[-1, -1] = left[-1] - mean @ left[:-1]
        return gaussian_log_density(products, factor, -2.0 * self.log_normaliser, 0)


def blocks_by_size(sizes: NDArray[np.int_]) -> NDArray[np.int_]:
    """Return first column and size of blocks as they stand in `GramMatrix.further`: smaller ones first, (b,) → (b, 2).

    Those of one size stand in their order.
    """
    order = np.argsort(sizes, kind="stable")
    firsts = np.empty(len(sizes), dtype=int)
    firsts[order] = np.cumsum(sizes[order]) - sizes[order]
    return np.stack([firsts, sizes], axis=1)


NO_BLOCKS = blocks_by_size(np.empty(0, dtype=int))


@dataclass(frozen=True)
class _Integrated:
    """Inner products with coefficients integrated out that all sets share, at each of j noises."""

    products: Array
    """Of the columns and, last, the data, shape (j, k + 1, k + 1)."""
    log_normalisers: Array
    """Shape (j,)."""
    further: Array
    """Of these with the columns of the blocks, shape (j, k + 1, m)."""
    inner: Sequence[Array]
    """Of the blocks of each size q, those of their own columns, lower triangles alone, shape (j, 1, b, q, q)."""

    @classmethod
    def of(cls, grams: Sequence[GramMatrix], base: Array, sizes: Sequence[int]) -> "_Integrated":
        """Integrate out coefficients of covariance B Bᵀ, of B, shape (k, c). `sizes`: of the blocks, none for none."""
        products = np.stack([gram.products for gram in grams])
        factor = np.linalg.cholesky(base.T @ products[:, :-1, :-1] @ base + np.eye(base.shape[1]))
        turned = np.linalg.inv(factor) @ base.T
        half = turned @ products[:, :-1]
        logs = np.array([gram.log_normaliser for gram in grams])
        logs = logs - np.log(np.diagonal(factor, axis1=-2, axis2=-1)).sum(axis=-1)
        products = products - np.swapaxes(half, 1, 2) @ half
        if not sizes:
            return cls(products, logs, np.empty((*products.shape[:2], 0)), ())
        further = np.stack([gram.further for gram in grams if gram.further is not None])
        halves = turned @ further[:, :-1]
        further = further - np.swapaxes(half, 1, 2) @ halves
        inner, first = [], 0
        for place, size in enumerate(sizes):
            blocks = np.stack([gram.inner[place] for gram in grams])
            last = first + size * blocks.shape[1]
            inner.append(_less(blocks, halves[..., first:last])[:, None])
            first = last
        return cls(products, logs, further, tuple(inner))

    def log_densities(self, mean: Array, factor: Array, scales: Array) -> Array:
        """Log densities of s sets whose further covariance has a factor of r columns, shape (j, s, 1 + blocks).

        `mean`, shape (s, k). `factor`, shape (s, k, r). `scales`, shape (s,): of the coefficients of the blocks.
        """
        turned = np.swapaxes(factor, 1, 2)
        columns = self.products[:, :-1, :-1]
        moved, data = mean @ columns, self.products[:, None, :-1, -1]
        lower = np.linalg.cholesky(turned @ columns[:, None] @ factor + np.eye(factor.shape[2]))
        turned = np.linalg.inv(lower) @ turned
        white = (turned @ (data - moved)[..., None])[..., 0]
        squared = self.products[:, None, -1, -1] + np.sum((moved - 2.0 * data) * mean, axis=-1)
        logs = self.log_normalisers[:, None] - 0.5 * (squared - np.sum(white**2, axis=-1))
        logs -= np.log(np.diagonal(lower, axis1=-2, axis2=-1)).sum(axis=-1)
        halves = turned @ self.further[:, None, :-1]
        right = self.further[:, None, -1] - mean @ self.further[:, :-1] - (white[..., None, :] @ halves)[..., 0, :]
        parts, first = [logs[..., None]], 0
        for inner in self.inner:
            size, scale = inner.shape[-1], scales[:, None, None]
            last = first + size * inner.shape[2]
            left = scale[..., None] ** 2 * _less(inner, halves[..., first:last])
            parts.append(logs[..., None] + log_factor(left, scale * right[..., first:last].reshape(*left.shape[:-1])))
            first = last
        return np.concatenate(parts, axis=-1)


def _less(inner: Array, halves: Array) -> Array:
    """Inner products of blocks, (…, b, q, q), less those of their whitened columns, (…, r, b·q); lower triangles."""
    size = inner.shape[-1]
    if size > FEW:
        blocks = halves.reshape(*halves.shape[:-1], inner.shape[-3], size).swapaxes(-3, -2)
        return np.asarray(inner - blocks.swapaxes(-1, -2) @ blocks)
    parts = [np.ascontiguousarray(halves[..., i::size]) for i in range(size)]
    remainder = np.zeros((size, size, *halves.shape[:-2], inner.shape[-3]))
    for i, j in itertools.combinations_with_replacement(range(size), 2):
        remainder[j, i] = inner[..., j, i] - (parts[i] * parts[j]).sum(axis=-2)
    return np.moveaxis(remainder, (0, 1), (-2, -1))


@dataclass(frozen=True)
class SetPriors:
    """Normal priors of k coefficients under s sets: means (s, k), and factors L of the covariances L Lᵀ, (s, k, k)."""

    mean: Array
    factor: Array

    @cached_property
    def _parts(self) -> tuple[Array, Array, NDArray[np.int_]]:
        """What the covariances have in common, and what each has beyond it.

        A factor, (k, k), and factors, (s, k, k), whose columns that are not nil stand first, and their numbers, (s,).
        """
        same = np.all(self.factor == self.factor[0], axis=(0, 1))
        alone = ~np.any(self.factor * (1.0 - np.eye(len(same))), axis=(0, 1))
        sd = np.abs(np.diagonal(self.factor, axis1=1, axis2=2))
        least = np.where(alone & ~same, sd.min(axis=0), 0.0)
        rest = np.where(same, 0.0, self.factor)
        rest = np.where(alone & ~same, np.eye(len(same)) * np.sqrt(np.maximum(sd**2 - least**2, 0.0))[:, None], rest)
        empty = ~np.any(rest, axis=1)
        order = np.argsort(empty, axis=1, kind="stable")
        first = np.take_along_axis(rest, order[:, None], axis=2)
        return np.where(same, self.factor[0], np.diag(least)), first, np.count_nonzero(~empty, axis=1)

    def log_densities(
        self, grams: Sequence[GramMatrix], blocks: NDArray[np.int_] = NO_BLOCKS, scales: Array | None = None
    ) -> Array:
        """Log density of the data under each set with each of j noises, without and with blocks, (j, s, 1 + b).

        Sets differ in the priors of a few coefficients: what they have in common is integrated out once.

        `blocks`: further columns, one block of `blocks_by_size` at a time. `scales`: standard deviations of the normal
        prior of their coefficients under each set, shape (s,); default 1.
        """
        base, rest, ranks = self._parts
        sizes = np.unique(blocks[:, 1]).tolist()
        scales = np.ones(len(ranks)) if scales is None else scales
        order = np.argsort(blocks[:, 0])  # as the blocks stand in their columns
        together = max(AT_ONCE // max(int(blocks[:, 1].sum()), len(base)), 1)
        noises = max(together // len(base), 1)
        densities = np.empty((len(grams), len(ranks), 1 + len(blocks)))
        by_rank = np.argsort(ranks, kind="stable")
        for start in range(0, len(grams), noises):
            some = _Integrated.of(grams[start : start + noises], base, sizes)
            count = math.ceil(int(np.maximum(ranks, 1).sum()) * len(some.products) / together)
            for sets in np.array_split(by_rank, min(count, len(by_rank))):
                logs = some.log_densities(self.mean[sets], rest[sets, :, : ranks[sets[-1]]], scales[sets])
                densities[start : start + noises, sets[:, None], 1 + order] = logs[..., 1:]
                densities[start : start + noises, sets, 0] = logs[..., 0]
        return densities

    def posterior(self, grams: Sequence[GramMatrix]) -> tuple[Array, Array]:
        """Posterior means (j, s, k) and factors R, (j, s, k, k), of the covariances R Rᵀ."""
        products = np.stack([gram.products for gram in grams])[:, None]
        turned = np.swapaxes(self.factor, 1, 2)
        factor = np.linalg.cholesky(turned @ products[..., :-1, :-1] @ self.factor + np.eye(self.factor.shape[2]))
        root = self.factor @ np.swapaxes(np.linalg.inv(factor), -1, -2)
        right = products[..., :-1, -1] - (products[..., :-1, :-1] @ self.mean[..., None])[..., 0]
        return self.mean + (root @ (np.swapaxes(root, -1, -2) @ right[..., None]))[..., 0], root


def log_factor(inner: Array, right: Array) -> Array:
    """Ln of the factor by which q coefficients N(0, 1) change a density, of inner products (…, q, q) and (…, q).

    By Cholesky's method, of few coefficients entry by entry for all matrices at once; lower triangles are read alone.
    """
    size = right.shape[-1]
    if size > FEW:
        return np.asarray(nested_log_factors(inner, right)[..., -1])
    rows = [[inner[..., i, j] for j in range(i + 1)] for i in range(size)]
    last: list[Array] = [right[..., i] for i in range(size)]
    logs: Array | float = 0.0
    for i, row in enumerate(rows):
        pivot = np.maximum(row[i], 0.0) + 1.0
        logs = logs + 0.5 * (last[i] ** 2 / pivot - np.log(pivot))
        for lower_row in (*rows[i + 1 :], last):
            share = lower_row[i] / pivot
            for j in range(i + 1, min(len(lower_row), size)):
                lower_row[j] = lower_row[j] - share * rows[j][i]
    return np.asarray(logs)


def nested_log_factors(inner: Array, right: Array) -> Array:
    """The same for the first coefficient, for the first two, and so on, shape (…, q): of one Cholesky factor."""
    size = right.shape[-1]
    bordered = np.empty((*inner.shape[:-2], size + 1, size + 1))
    bordered[..., :size, :size] = inner + np.eye(size)
    bordered[..., size, :size] = right
    bordered[..., size, size] = 1.0 + np.sum(right**2, axis=-1)  # more than rightᵀ (inner + 1)⁻¹ right
    factor = np.linalg.cholesky(bordered)
    pivots = np.diagonal(factor, axis1=-2, axis2=-1)[..., :size]
    return np.asarray(np.cumsum(0.5 * factor[..., size, :size] ** 2 - np.log(pivots), axis=-1))


def log_slab_factor(inner: Array, right: Array, factor: Callable[[Array, Array], Array] = log_factor) -> Array:
    """The same for coefficients with a slab of unit size, a mean over its scales."""
    scales = np.array(SCALES)
    logs = factor(np.multiply.outer(scales**2, inner), np.multiply.outer(scales, right))
    shares = np.log(SCALE_PRIOR).reshape(-1, *(1,) * (logs.ndim - 1))
    return np.asarray(np.logaddexp.reduce(logs + shares, axis=0))
