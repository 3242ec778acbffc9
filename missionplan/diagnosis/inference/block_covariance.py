"""Covariance of data in independent blocks that a few shared coefficients tie, never written out as a whole.

W = B + R Rᵀ, with B = L Lᵀ of independent blocks, and R the columns of coefficients with standard normal priors. With
V = L⁻¹R and a triangle T for which TᵀT = 1 + VᵀV, W⁻¹ = B⁻¹ − B⁻¹R T⁻¹T⁻ᵀ RᵀB⁻¹ and ln |W| = ln |B| + 2 ln |T|
(matrix inversion lemma: Rasmussen & Williams 2006, *Gaussian Processes for Machine Learning*, Eqs. A.9 and A.10). T is
that of a QR decomposition: normal equations would square the condition number where data are much better than priors.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack, solve_triangular

from missionplan.arrays import Array
from missionplan.diagnosis.inference.marginal_likelihood import LOG_2PI, Normal

AT_ONCE = 64
"""Data that are predicted together from those before; even, so that pairs stay together."""


@dataclass(frozen=True)
class InnerProducts:
    """Inner products xᵀW⁻¹y of columns and data, W their covariance at one level of the model's noise."""

    log_weight: float
    """Log prior weight of that noise."""
    log_determinant: float
    """ln |W|."""
    gram: Array
    """Of m columns and, last, the data, shape (m + 1, m + 1)."""

    @property
    def log_density(self) -> float:
        """Log density of the data with that weight, up to what depends on their number alone."""
        return self.log_weight - 0.5 * (self.log_determinant + float(self.gram[-1, -1]))


@dataclass(frozen=True)
class BlockCovariance:
    """Covariance of N data: independent blocks, and what m standard normal coefficients do to all of them."""

    rows: tuple[NDArray[np.int_], ...]
    """Data of each block, in their order."""
    blocks: tuple[Array, ...]
    """Covariance of each."""
    root: Array
    """What the data respond to the coefficients, shape (N, m)."""

    @classmethod
    def of(cls, covariance: Array) -> "BlockCovariance":
        """Take a covariance that is written out, shape (N, N), as one block."""
        count = len(covariance)
        return cls((np.arange(count),), (covariance,), np.zeros((count, 0)))

    @classmethod
    def independent(cls, sd: Array, root: Array) -> "BlockCovariance":
        """Take errors of these standard deviations, shape (N,), that nothing but the coefficients ties."""
        return cls((np.arange(len(sd)),), (np.diag(sd**2),), root)

    def restricted(self, rows: NDArray[np.int_]) -> "BlockCovariance":
        """Return that of some of the data, in their order."""
        place = np.full(len(self.root), -1)
        place[rows] = np.arange(len(rows))
        kept = [place[block_rows] >= 0 for block_rows in self.rows]
        pairs = list(zip(self.rows, self.blocks, kept, strict=True))
        blocks = tuple(block[np.ix_(chosen, chosen)] for _, block, chosen in pairs if chosen.any())
        places = tuple(place[block_rows[chosen]] for block_rows, _, chosen in pairs if chosen.any())
        return BlockCovariance(places, blocks, self.root[rows])

    @property
    def variances(self) -> Array:
        """Variance of each datum, shape (N,)."""
        variances = np.sum(self.root**2, axis=1)
        for rows, block in zip(self.rows, self.blocks, strict=True):
            variances[rows] += np.diag(block)
        return np.asarray(variances)

    def dense(self) -> Array:
        """Return the matrix, shape (N, N)."""
        matrix = self.root @ self.root.T
        for rows, block in zip(self.rows, self.blocks, strict=True):
            matrix[np.ix_(rows, rows)] += block
        return np.asarray(matrix)

    @cached_property
    def _factors(self) -> tuple[Array, ...]:
        """Lower Cholesky factor L of each block."""
        return tuple(np.asarray(np.linalg.cholesky(block), dtype=float) for block in self.blocks)

    def in_blocks(self, values: Array) -> Array:
        """Whiten values, shape (N, c), by the blocks alone: L⁻¹ times them."""
        white = np.empty(values.shape)
        for rows, factor in zip(self.rows, self._factors, strict=True):
            white[rows] = lapack.dtrtrs(factor.T, values[rows], trans=1)[0]  # as it lies in memory, an upper triangle
        return white

    @cached_property
    def _white_root(self) -> Array:
        """V, shape (N, m)."""
        return self.in_blocks(self.root)

    @cached_property
    def _triangle(self) -> Array:
        """T, shape (m, m)."""
        count = self.root.shape[1]
        return np.asarray(np.linalg.qr(np.concatenate([self._white_root, np.eye(count)]), mode="r"))

    @cached_property
    def log_determinant(self) -> float:
        """Ln |W|."""
        triangles = (*self._factors, self._triangle)
        return 2.0 * sum(float(np.log(np.abs(np.diag(triangle))).sum()) for triangle in triangles)

    def gram(self, values: Array) -> Array:
        """Inner products xᵀW⁻¹y of columns, shape (N, c) → (c, c); what is nil in a block costs nothing there."""
        count = values.shape[1]
        gram, along = np.zeros((count, count)), np.zeros((self.root.shape[1], count))
        for rows, factor in zip(self.rows, self._factors, strict=True):
            here = values[rows]
            some = np.flatnonzero(here.any(axis=0))
            white = lapack.dtrtrs(factor.T, here[:, some], trans=1)[0]
            gram[np.ix_(some, some)] += white.T @ white
            along[:, some] += self._white_root[rows].T @ white
        projection = solve_triangular(self._triangle, along, trans=1, check_finite=False)
        return np.asarray(gram - projection.T @ projection)

    def products(self, columns: Array, y: Array, log_weight: float = 0.0) -> InnerProducts:
        """Inner products of columns, shape (N, c), and data, shape (N,)."""
        both = np.concatenate([columns, y[:, None]], axis=1)
        return InnerProducts(log_weight, self.log_determinant, self.gram(both))

    def log_densities(self, values: Array) -> Array:
        """Log density of data of mean nil, shape (N, s) → (s,)."""
        white = self.in_blocks(values)
        projection = solve_triangular(self._triangle, self._white_root.T @ white, trans=1, check_finite=False)
        squared = np.sum(white**2, axis=0) - np.sum(projection**2, axis=0)
        return np.asarray(-0.5 * (squared + self.log_determinant + len(values) * LOG_2PI))

    def whitened(self, values: Array) -> Array:
        """Whiten columns, shape (N, c), by the symmetric root of 1 + V Vᵀ: xᵀW⁻¹y are then inner products."""
        directions, sizes = self._directions
        white = self.in_blocks(values)
        return np.asarray(white - directions @ ((1.0 - 1.0 / np.hypot(1.0, sizes))[:, None] * (directions.T @ white)))

    @cached_property
    def _directions(self) -> tuple[Array, Array]:
        """Left singular vectors of V, and its singular values."""
        directions, sizes, _ = np.linalg.svd(self._white_root, full_matrices=False)
        return directions, sizes

    # predictions

    def innovations(self, values: Array) -> Array:
        """Return errors of predicting each datum from those before, over their standard deviations, shape (N,).

        The prediction-error decomposition (Harvey 1989, *Forecasting, Structural Time Series Models and the Kalman
        Filter*, section 3.4): white noise if all is well.
        """
        ahead = _forward(self._white_root, self.in_blocks(values[:, None])[:, 0])
        return np.concatenate([innovations for _, innovations in ahead])

    def left_out(self, values: Array, groups: Iterable[NDArray[np.int_]]) -> Iterator[Normal]:
        """Yield the error of predicting each group of data from all others, and its covariance.

        With the precision P = W⁻¹ these are (P_gg)⁻¹(P r)_g and (P_gg)⁻¹: for groups of one the leave-one-out formulas
        of Dubrule (1983, *Math. Geol.* 15); Rasmussen & Williams (2006, Eq. 5.12).
        """
        update, pulled = self._low_rank_update, np.empty(values.shape)
        block, place = np.empty(len(values), dtype=int), np.empty(len(values), dtype=int)
        for number, (rows, inverse) in enumerate(zip(self.rows, self._inverses, strict=True)):
            pulled[rows], block[rows], place[rows] = inverse @ values[rows], number, np.arange(len(rows))
        pulled -= update @ (update.T @ values)
        for group in groups:
            precision = -update[group] @ update[group].T
            for number in np.unique(block[group]):
                rows = np.flatnonzero(block[group] == number)
                places = place[group[rows]]
                precision[np.ix_(rows, rows)] += self._inverses[number][np.ix_(places, places)]
            covariance = np.asarray(np.linalg.inv(precision), dtype=float)
            yield covariance @ pulled[group], covariance

    def cross_entropy(self, truth: "BlockCovariance", away: Array) -> float:
        """Mean of −ln N(y; 0, W), up to a constant, over normal y of mean `away`, shape (N,), and another covariance.

        The difference of two is that of Kullback–Leibler divergences (Rasmussen & Williams 2006, Eq. A.23).
        """
        squared = float(np.trace(self.gram(np.concatenate([truth.root, away[:, None]], axis=1))))
        for rows, inverse, block in zip(self.rows, self._inverses, truth.blocks, strict=True):
            update = self._low_rank_update[rows]
            squared += float(np.sum(inverse * block) - np.sum(update * (block @ update)))
        return 0.5 * (squared + self.log_determinant)

    @cached_property
    def _inverses(self) -> tuple[Array, ...]:
        return tuple(np.asarray(np.linalg.inv(block)) for block in self.blocks)

    @cached_property
    def _low_rank_update(self) -> Array:
        """U = B⁻¹R T⁻¹, shape (N, m): W⁻¹ = B⁻¹ − U Uᵀ."""
        product = np.empty(self.root.shape)
        for rows, inverse in zip(self.rows, self._inverses, strict=True):
            product[rows] = inverse @ self.root[rows]
        return np.asarray(solve_triangular(self._triangle, product.T, trans=1, check_finite=False).T)


def errors_ahead(white_root: Array, white: Array, together: int) -> Array:
    """Return errors of predicting data, so many of a group in turn together, from the groups before, shape (N,).

    `white_root`, shape (N, m), `white`, shape (N,): the coefficients' root and the data, whitened by blocks of which
    none has two data of a group. Errors are over the standard deviations of what blocks alone leave open.
    """
    errors = []
    for factor, innovations in _forward(white_root, white):
        groups = (slice(begin, begin + together) for begin in range(0, len(innovations), together))
        errors += [factor[group, group] @ innovations[group] for group in groups]
    return np.concatenate(errors)


def _forward(white_root: Array, white: Array) -> Iterator[tuple[Array, Array]]:
    """Factor of the covariance of data in turn, whitened by their blocks, and their innovations.

    The coefficients are estimated from the data before by QR decompositions, a square-root information filter (Bierman
    1977, *Factorization Methods for Discrete Sequential Estimation*).
    """
    both, count = np.concatenate([white_root, white[:, None]], axis=1), white_root.shape[1]
    information = np.eye(count, count + 1)
    for first in range(0, len(white), AT_ONCE):
        here = both[first : first + AT_ONCE]
        gain = solve_triangular(information[:, :-1], here[:, :-1].T, trans=1, check_finite=False)
        factor = np.asarray(np.linalg.cholesky(gain.T @ gain + np.eye(len(here))), dtype=float)
        error = here[:, -1] - gain.T @ information[:, -1]
        yield factor, solve_triangular(factor, error, lower=True, check_finite=False)
        information = np.asarray(np.linalg.qr(np.concatenate([information, here]), mode="r")[:count], dtype=float)
