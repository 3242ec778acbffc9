"""Evidence of many sets of causes at once: a linear model under one noise and many priors of its coefficients.

Given the noise, a set of causes differs from another by the prior of the coefficients alone, so that all sets share the
inner products of the whitened columns (Rasmussen & Williams 2006, Eqs. 2.8 and 2.30; Bishop 2006, Eq. 3.86).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.diagnosis.inference.marginal_likelihood import gaussian_log_density

SCALES = (0.75, 1.13, 1.9, 4.5)
"""Factors √λ on a slab, λ inverse-gamma (3/2, 3/2): with them a slab is a Student-t law of three degrees of freedom, so
that a strong effect is not shrunk (Gelman et al. 2013, section 17.2). Medians of its parts of probability
`SCALE_PRIOR`."""
SCALE_PRIOR = (0.3, 0.35, 0.25, 0.1)
AT_ONCE = 2_000_000
"""Numbers in the largest array of sets, noises and columns."""


@dataclass(frozen=True)
class Block:
    """Columns that act together: the first of them and their number."""

    first: int
    size: int


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

    def joined(self, block: Block) -> "GramMatrix":
        """Return that with a block's columns after the others."""
        assert self.further is not None
        own = self.further[:, block.first : block.first + block.size]
        alike = next(each for each in self.inner if each.shape[1] == block.size)
        before = sum(each.shape[0] * each.shape[1] for each in self.inner if each.shape[1] < block.size)
        inner = alike[(block.first - before) // block.size]
        k = len(self.products) - 1
        rows = [
            [self.products[:k, :k], own[:k], self.products[:k, k:]],
            [own[:k].T, inner, own[k:].T],
            [self.products[k:, :k], own[k:], self.products[k:, k:]],
        ]
        return GramMatrix(np.block(rows), self.log_normaliser)


def blocks_by_size(sizes: Sequence[int]) -> list[Block]:
    """Return blocks of given sizes as they stand in `GramMatrix.further`: smaller ones first, else in their order."""
    order = np.argsort(sizes, kind="stable")
    firsts = np.empty(len(sizes), dtype=int)
    firsts[order] = np.cumsum([0, *np.array(sizes, dtype=int)[order]])[:-1]
    return [Block(int(first), int(size)) for first, size in zip(firsts, sizes, strict=True)]


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

    def log_density(self, gram: GramMatrix) -> float:
        """Log density of the data under the first set."""
        moved = _moved(gram.products, self.mean[0])
        return gaussian_log_density(moved, self.factor[0], 0.0, 0) + gram.log_normaliser

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

    def gains(self, grams: Sequence[GramMatrix], blocks: Sequence[Block], scale: float) -> Array:
        """What blocks of further columns, one at a time, add to the log densities, shape (j, s, b).

        Each of a block's coefficients has a normal prior of standard deviation `scale`.
        """
        columns = sum(block.size for block in blocks)
        together = max(AT_ONCE // (self.factor.size * max(columns, 1) // self.factor.shape[-1] + 1), 1)
        parts = [grams[first : first + together] for first in range(0, len(grams), together)]
        return np.concatenate([self._gains(part, blocks, scale) for part in parts])

    def _gains(self, grams: Sequence[GramMatrix], blocks: Sequence[Block], scale: float) -> Array:
        _, factor, white = self._solved(*_stacked(grams))
        further = np.stack([gram.further for gram in grams if gram.further is not None])
        half = (np.linalg.inv(factor) @ np.swapaxes(self.factor, 1, 2)) @ further[:, None, :-1]
        right = further[:, None, -1] - self.mean @ further[:, :-1] - (white[..., None, :] @ half)[..., 0, :]
        found = np.empty((*white.shape[:2], len(blocks)))
        sizes = np.array([block.size for block in blocks])
        for place, size in enumerate(np.unique(sizes).tolist()):
            alike = np.flatnonzero(sizes == size).tolist()
            first = min(blocks[index].first for index in alike)
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


def _moved(products: Array, mean: Array) -> Array:
    """Inner products with the data less the columns times a mean."""
    if not mean.any():
        return products
    change = np.eye(len(products))
    change[:-1, -1] = -mean
    return np.asarray(change.T @ products @ change)
