"""Whitening by a banded Cholesky factor: likelihoods of n legs in time proportional to n.

An error that persists from leg to leg is a Markov process (Ornstein–Uhlenbeck, random walk), and a fix is shared by
two consecutive legs at most. With such states x of banded precision Q, and errors e = H x + ε with independent
ε ~ N(0, R), Σ⁻¹ = R⁻¹ − R⁻¹ H M⁻¹ Hᵀ R⁻¹ and ln |Σ| = ln |R| + ln |M| − ln |Q| for M = Q + Hᵀ R⁻¹ H (matrix inversion
lemma: Rasmussen & Williams 2006, Eqs. A.9 and A.10). M has two diagonals on either side of the main one, so that its
Cholesky factor has two (Rue & Held 2005, Section 2.4); a Kalman filter would give the same (Durbin & Koopman 2012,
Section 7.2).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack

from missionplan.arrays import Array, Scalars
from missionplan.phases.hooks import MarkovProcess

LegSelection = slice | NDArray[np.int_]


@dataclass(frozen=True)
class MarkovCovariance:
    """Covariance of the velocity errors of consecutive legs, never written out.

    Attributes
    ----------
    under_way : array, shape (n,)
        Time under way [s].
    since : array, shape (n,)
        Time since the middle of the first leg of the leg's run [s].
    elapsed : array, shape (n,)
        Time since the middle of the previous selected leg; nan where a run begins [s].
    shares_fix : array of bool, shape (n,)
        Whether a leg starts from the same fix with which the previous selected leg ended.
    start_scale, end_scale : array, shape (n,), or float
        Standard deviation of the fix before and after each leg, over the typical one.
    """

    under_way: Array
    since: Array
    elapsed: Array
    shares_fix: NDArray[np.bool_]
    start_scale: Scalars = 1.0
    end_scale: Scalars = 1.0

    def fix_variance(self) -> Array:
        """Variance of a leg's velocity error for independent fix errors, 1 m typically, shape (n,) [1/s²]."""
        return np.asarray((self.start_scale**2 + self.end_scale**2) / self.under_way**2)

    def gram(self, values: Array, white: Array, fix_sd: float, process: MarkovProcess | None) -> tuple[Array, float]:
        """Inner products of whitened columns, both axes together.

        Parameters
        ----------
        values : array, shape (2, n, m)
            Columns.
        white : array, shape (2,) or (2, n)
            Variance of the independent velocity error on each axis [m²/s²].
        fix_sd : float
            Standard deviation of a fix, each axis [m].
        process : MarkovProcess, optional
            Error that persists from leg to leg.

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
        variance = white.reshape(2, -1) + fix_sd**2 * self._unshared_fix_variance
        if not np.all(variance > 0.0):
            raise np.linalg.LinAlgError("a variance is not positive")
        weighted = values / variance[:, :, None]
        gram = sum(weighted[axis].T @ values[axis] for axis in (0, 1))
        log_determinant = float(np.log(variance).sum())
        if process is None and not self.shares_fix.any():
            return gram, log_determinant
        prior = _ProcessPrecision.of(self, process)
        for axis in (0, 1):
            correction, added = self._state_terms(weighted[axis], variance[axis], fix_sd, prior)
            gram -= correction
            log_determinant += added
        return gram, log_determinant

    @property
    def _unshared_fix_variance(self) -> Array:
        """Variance of a leg's velocity error from fixes of 1 m that no other leg shares, shape (n,) [1/s²]."""
        ends = np.append(self.shares_fix[1:], False)
        starts, ends = self.start_scale**2 * (1.0 - self.shares_fix), self.end_scale**2 * (1.0 - ends)
        return np.asarray((starts + ends) / self.under_way**2)

    def _state_terms(
        self, weighted: Array, variance: Array, fix_sd: float, prior: "_ProcessPrecision"
    ) -> tuple[Array, float]:
        """What the states subtract from the Gram matrix of one axis, and add to ln |Σ|.

        States alternate: the process on a leg, then the fix at its end in units of its standard deviation.
        """
        n = len(variance)
        loads = fix_sd / self.under_way
        start = -loads * self.start_scale * self.shares_fix
        end = loads * self.end_scale * np.append(self.shares_fix[1:], False)
        band = np.zeros((3, 2 * n))
        band[0, ::2] = prior.diagonal + prior.present / variance
        band[2, 0 : 2 * n - 2 : 2] = prior.off_diagonal
        band[1, ::2] = prior.present * end / variance
        band[0, 1::2] = 1.0 + end**2 / variance
        band[0, 1:-1:2] += start[1:] ** 2 / variance[1:]
        band[1, 1:-1:2] = (prior.present * start / variance)[1:]
        band[2, 1:-1:2] = (end * start / variance)[1:]
        right = np.zeros((2 * n, weighted.shape[1]), order="F")
        right[::2] = prior.present[:, None] * weighted
        right[1::2] = end[:, None] * weighted
        right[1:-1:2] += start[1:, None] * weighted[1:]
        factor, failed = lapack.dpbtrf(band, lower=1)
        if failed:
            raise np.linalg.LinAlgError("the covariance is not positive definite")
        whitened, _ = lapack.dtbtrs(factor, right, uplo="L")
        return whitened.T @ whitened, 2.0 * float(np.log(factor[0]).sum()) - prior.log_determinant


@dataclass(frozen=True)
class _ProcessPrecision:
    """Tridiagonal precision of the process on n legs.

    Attributes
    ----------
    diagonal, off_diagonal : array, shapes (n,) and (n - 1,)
        Of the precision [s²/m²].
    present : array, shape (n,)
        1 where the process has a variance, else 0: a random walk is zero on the first leg.
    log_determinant : float
        ln |precision|.
    """

    diagonal: Array
    off_diagonal: Array
    present: Array
    log_determinant: float

    @classmethod
    def of(cls, legs: MarkovCovariance, process: MarkovProcess | None) -> "_ProcessPrecision":
        n = len(legs.since)
        if process is None:
            return cls(np.ones(n), np.zeros(n - 1), np.zeros(n), 0.0)
        begins = np.isnan(legs.elapsed)
        kept, added = process.transition(np.where(begins, legs.since, legs.elapsed))
        variance = added + np.where(begins, kept**2 * process.first_variance, 0.0)
        present = (variance > 0.0).astype(float)
        kept = kept * ~begins * np.append(0.0, present[:-1])
        precision = 1.0 / np.where(present > 0.0, variance, 1.0)
        diagonal = precision.copy()
        diagonal[:-1] += kept[1:] ** 2 * precision[1:]
        return cls(diagonal, -kept[1:] * precision[1:], present, float(np.log(precision).sum()))
