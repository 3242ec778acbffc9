"""Evidence of many sets of causes at once: a linear model under one noise and many priors of its coefficients.

Given the noise, a set of causes differs from another by the prior of the coefficients alone, so that all sets share the
inner products of the whitened columns (Rasmussen & Williams 2006, Eqs. 2.8 and 2.30; Bishop 2006, Eq. 3.86).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.diagnosis.inference.marginal_likelihood import LOG_2PI, gaussian_log_density

SCALES = (0.75, 1.13, 1.9, 4.5)
"""Factors √λ on a slab, λ inverse-gamma (3/2, 3/2): with them a slab is a Student-t law of three degrees of freedom, so
that a strong effect is not shrunk (Gelman et al. 2013, section 17.2). Medians of its parts of probability
`SCALE_PRIOR`."""
SCALE_PRIOR = (0.3, 0.35, 0.25, 0.1)


@dataclass(frozen=True)
class GramMatrix:
    """Whitened data and columns of a linear model under one noise."""

    products: Array
    """Inner products of the columns and, last, the data, shape (k + 1, k + 1)."""
    log_normaliser: float
    """ln density of the data where all of them are nil."""

    @classmethod
    def of(cls, products: Array, log_determinant: float, count: int) -> "GramMatrix":
        """Make one of a normal noise with ln |covariance| and so many data."""
        return cls(products, -0.5 * (log_determinant + count * LOG_2PI))

    def part(self, chosen: NDArray[np.int_]) -> "GramMatrix":
        """Return that of some of the columns."""
        kept = np.append(chosen, len(self.products) - 1)
        return GramMatrix(self.products[np.ix_(kept, kept)], self.log_normaliser)


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

    def gains(self, grams: Sequence[GramMatrix], blocks: Sequence["Block"], scale: float) -> Array:
        """What blocks of further columns, one at a time, add to the log densities, shape (j, s, b).

        Each of a block's coefficients has a normal prior of standard deviation `scale`. The products are those of the k
        coefficients' columns, then the blocks', then the data.
        """
        products, normalisers = _stacked(grams)
        k, count = self.mean.shape[1], products.shape[1] - 1
        core = np.append(np.arange(k), count)
        _, factor, white = self._solved(products[np.ix_(np.arange(len(grams)), core, core)], normalisers)
        further = products[:, :k, k:count]
        turned = np.swapaxes(self.factor, 1, 2) @ further[:, None]
        half = np.linalg.solve(factor, turned)
        right = products[:, None, k:count, -1] - self.mean @ further - (white[..., None, :] @ half)[..., 0, :]
        found = np.empty((*white.shape[:2], len(blocks)))
        diagonal = np.diagonal(products, axis1=-2, axis2=-1)[:, None, k:count] - np.sum(half**2, axis=-2)
        single = [index for index, block in enumerate(blocks) if block.size == 1]
        if single:
            first = np.array([blocks[index].first for index in single])
            inner = scale**2 * np.maximum(diagonal[..., first], 0.0) + 1.0
            found[..., single] = -0.5 * (np.log(inner) - (scale * right[..., first]) ** 2 / inner)
        for index, block in enumerate(blocks):
            if block.size == 1:
                continue
            own = np.arange(block.first, block.first + block.size)
            inner = products[:, None, k + own[:, None], k + own] - np.swapaxes(half[..., own], -1, -2) @ half[..., own]
            found[..., index] = log_factor(scale**2 * inner, scale * right[..., own])
        return found

    def posterior(self, grams: Sequence[GramMatrix]) -> tuple[Array, Array]:
        """Posterior means (j, s, k) and factors R, (j, s, k, k), of the covariances R Rᵀ."""
        _, factor, white = self._solved(*_stacked(grams))
        root = self.factor @ np.swapaxes(np.linalg.inv(factor), -1, -2)
        return self.mean + (root @ white[..., None])[..., 0], root


@dataclass(frozen=True)
class Block:
    """Columns that act together: the first of them and their number."""

    first: int
    size: int


def log_factor(inner: Array, right: Array) -> Array:
    """Ln of the factor by which q coefficients N(0, 1) change a density, of inner products (…, q, q) and (…, q)."""
    factor = np.linalg.cholesky(inner + np.eye(right.shape[-1]))
    white = np.linalg.solve(factor, right[..., None])[..., 0]
    return np.asarray(0.5 * np.sum(white**2, axis=-1) - np.log(np.diagonal(factor, axis1=-2, axis2=-1)).sum(axis=-1))


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
