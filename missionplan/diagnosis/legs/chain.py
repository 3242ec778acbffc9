"""Legs as links of a chain: Gram matrices of whitened columns in time proportional to the number of legs.

What lasts from leg to leg (a persistent error, a walk) is a Markov process, and a fix is shared by two neighbours at
most. With such states x, of banded precision Q, and errors e = H x + ε with ε ~ N(0, R) independent, Woodbury's
identities give Σ⁻¹ = R⁻¹ − R⁻¹ H M⁻¹ Hᵀ R⁻¹ and ln |Σ| = ln |R| + ln |M| − ln |Q| for M = Q + Hᵀ R⁻¹ H. M has two
diagonals on either side of the main one: no n × n matrix is factorised.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack

from missionplan.arrays import Array, Scalars

Rows = slice | NDArray[np.int_]


class Lasting(Protocol):
    """A velocity error that is a Markov process in time."""

    def transition(self, elapsed: Array) -> tuple[Array, Array]:
        """Share of the velocity that is kept over a time, and the variance that is gathered [m²/s²]."""
        ...

    @property
    def first_variance(self) -> Scalars:
        """Variance on the first leg of a run [m²/s²]."""
        ...

    def covariance(self, t: Array) -> Array:
        """Covariance of one component between the middles of a run's legs, shape (n, n) [m²/s²]."""
        ...


@dataclass(frozen=True)
class Chain:
    """Some legs of a log, in order.

    Attributes
    ----------
    under_way : array, shape (n,)
        Time under way [s].
    since : array, shape (n,)
        Time since the middle of the first leg of the leg's run [s].
    elapsed : array, shape (n,)
        Time since the middle of the leg before, of those chosen; nan where a run begins [s].
    shares : array of bool, shape (n,)
        Whether a leg starts from the very fix with which the leg before it, of those chosen, ended.
    """

    under_way: Array
    since: Array
    elapsed: Array
    shares: NDArray[np.bool_]

    def fix_variance(self) -> Array:
        """Variance of a leg's velocity error for independent fix errors of 1 m, shape (n,) [1/s²]."""
        return np.asarray(2.0 / self.under_way**2)

    def gram(self, values: Array, white: Array, fix_sd: float, lasting: Lasting | None) -> tuple[Array, float]:
        """Inner products of whitened columns, both axes together.

        Parameters
        ----------
        values : array, shape (2, n, m)
            Columns.
        white : array, shape (2,)
            Variance of the independent velocity error on each axis [m²/s²].
        fix_sd : float
            Standard deviation of a fix, each axis [m].
        lasting : Lasting, optional
            What lasts from leg to leg, the same on both axes and independent.

        Returns
        -------
        gram : array, shape (m, m)
            Σ over axes of valuesᵀ Σ⁻¹ values.
        log_determinant : float
            ln |Σ|, both axes together.

        Raises
        ------
        numpy.linalg.LinAlgError
            When the covariance is not positive definite.
        """
        own = white[:, None] + fix_sd**2 * self._unshared
        if not np.all(own > 0.0):
            raise np.linalg.LinAlgError("a variance is not positive")
        weighted = values / own[:, :, None]
        gram = np.tensordot(weighted, values, axes=((0, 1), (0, 1)))
        log_determinant = float(np.log(own).sum())
        if lasting is None and not self.shares.any():
            return gram, log_determinant
        prior = _Prior.of(self, lasting)
        for axis in (0, 1):
            inner, extra = self._absorbed(weighted[axis], own[axis], fix_sd, prior)
            gram -= inner
            log_determinant += extra
        return gram, log_determinant

    @property
    def _unshared(self) -> Array:
        """Variance of a leg's velocity error from fixes of 1 m that no other leg shares, shape (n,) [1/s²]."""
        ends = np.append(self.shares[1:], False)
        return np.asarray((2.0 - self.shares - ends) / self.under_way**2)

    def _absorbed(self, weighted: Array, own: Array, fix_sd: float, prior: "_Prior") -> tuple[Array, float]:
        """What the states take from the Gram matrix of one axis, and add to ln |Σ|.

        States alternate: what lasts on a leg, then the fix at its end in units of its standard deviation.
        """
        n = len(own)
        loads = fix_sd / self.under_way
        start, end = -loads * self.shares, loads * np.append(self.shares[1:], False)
        band = np.zeros((3, 2 * n))
        band[0, ::2] = prior.diagonal + prior.present / own
        band[2, 0 : 2 * n - 2 : 2] = prior.beside
        band[1, ::2] = prior.present * end / own
        band[0, 1::2] = 1.0 + end**2 / own
        band[0, 1:-1:2] += start[1:] ** 2 / own[1:]
        band[1, 1:-1:2] = (prior.present * start / own)[1:]
        band[2, 1:-1:2] = (end * start / own)[1:]
        right = np.zeros((2 * n, weighted.shape[1]), order="F")
        right[::2] = prior.present[:, None] * weighted
        right[1::2] = end[:, None] * weighted
        right[1:-1:2] += start[1:, None] * weighted[1:]
        factor, failed = lapack.dpbtrf(band, lower=1)
        if failed:
            raise np.linalg.LinAlgError("the covariance is not positive definite")
        inner, _ = lapack.dtbtrs(factor, right, uplo="L")
        return inner.T @ inner, 2.0 * float(np.log(factor[0]).sum()) - prior.log_determinant


@dataclass(frozen=True)
class _Prior:
    """Precision of what lasts: its diagonal (n,), beside it (n − 1,); legs where there is anything, as 0 or 1."""

    diagonal: Array
    beside: Array
    present: Array
    log_determinant: float

    @classmethod
    def of(cls, chain: Chain, lasting: Lasting | None) -> "_Prior":
        n = len(chain.since)
        if lasting is None:
            return cls(np.ones(n), np.zeros(n - 1), np.zeros(n), 0.0)
        begins = np.isnan(chain.elapsed)
        kept, gathered = lasting.transition(np.where(begins, chain.since, chain.elapsed))
        variance = gathered + np.where(begins, kept**2 * lasting.first_variance, 0.0)
        present = (variance > 0.0).astype(float)
        kept = kept * ~begins * np.append(0.0, present[:-1])
        precision = 1.0 / np.where(present > 0.0, variance, 1.0)
        diagonal = precision.copy()
        diagonal[:-1] += kept[1:] ** 2 * precision[1:]
        return cls(diagonal, -kept[1:] * precision[1:], present, float(np.log(precision).sum()))
