"""Whitening by a banded Cholesky factor: likelihoods of n legs in time proportional to n.

An error that persists from leg to leg is a Markov process (Ornstein–Uhlenbeck, random walk), and a fix is shared by
two consecutive legs at most. A leg's error is the mean of the process over its time under way: a share of the sum of
its values at both ends, and a rest that is independent of all others. With such states x of banded precision Q, and
errors e = H x + ε with independent ε ~ N(0, R), Σ⁻¹ = R⁻¹ − R⁻¹ H M⁻¹ Hᵀ R⁻¹ and ln |Σ| = ln |R| + ln |M| − ln |Q| for
M = Q + Hᵀ R⁻¹ H (matrix inversion lemma: Rasmussen & Williams 2006, Eqs. A.9 and A.10). With both ends of a leg and the
fix after it in their order, M has three diagonals on either side of the main one, so that its Cholesky factor has three
(Rue & Held 2005, Section 2.4), and one where only the process or only fixes are shared; a Kalman filter would give the
same (Durbin & Koopman 2012, Section 7.2).
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack

from missionplan.arrays import Array, Scalars
from missionplan.phases.hooks import MarkovProcess

LegSelection = slice | NDArray[np.int_]


@dataclass(frozen=True)
class WhitenedColumns:
    """Columns X of legs of covariance Σ, as A and B of each axis with Xᵀ Σ⁻¹ X = Σ A Aᵀ − Σ B Bᵀ."""

    added: Array
    """A, shape (2, m, n)."""
    removed: tuple[Array, ...]
    """B, shape (m, s) each: what is known of the states that legs share."""
    log_determinant: float
    """ln |Σ|, both axes together."""

    def products(self, other: "WhitenedColumns") -> Array:
        """Inner products xᵀ Σ⁻¹ y of these columns and others."""
        found = np.sum([mine @ theirs.T for mine, theirs in zip(self.added, other.added, strict=True)], axis=0)
        for mine, theirs in zip(self.removed, other.removed, strict=True):
            found -= mine @ theirs.T
        return np.asarray(found)

    def products_of_blocks(self, size: int) -> Array:
        """Inner products within each of b consecutive blocks of columns of the same size q, shape (b, q, q)."""
        found = np.sum([_of_blocks(each, size) for each in self.added], axis=0)
        for each in self.removed:
            found -= _of_blocks(each, size)
        return np.asarray(found)


def _of_blocks(columns: Array, size: int) -> Array:
    """Inner products within blocks of columns, (b·q, N) → (b, q, q)."""
    blocks = columns.reshape(-1, size, columns.shape[1])
    return np.asarray(blocks @ blocks.swapaxes(1, 2))


@dataclass(frozen=True)
class MarkovCovariance:
    """Covariance of the velocity errors of consecutive legs, never written out."""

    under_way: Array
    """Time under way, shape (n,) [s]."""
    since: Array
    """Time from the start of the first leg of the leg's run to its own start, shape (n,) [s]."""
    elapsed: Array
    """Shape (n,). Time from the end of the previous selected leg's way to its start; nan where a run begins [s]."""
    in_common: Array
    """Correlation of the error of the fix before a leg with that of the fix after the previous selected one: 1 where it
    is the same fix, shape (n,)."""
    start_scale: Scalars = 1.0
    end_scale: Scalars = 1.0
    """Standard deviation of the fix before and after each leg, over the typical one, shape (n,)."""

    def fix_variance(self) -> Array:
        """Variance of a leg's velocity error for independent fix errors, 1 m typically, shape (n,) [1/s²]."""
        return np.asarray((self.start_scale**2 + self.end_scale**2) / self.under_way**2)

    def gram(self, values: Array, white: Array, fix_sd: float, process: MarkovProcess | None) -> tuple[Array, float]:
        """Σ over axes of valuesᵀ Σ⁻¹ values, shape (m, m), and ln |Σ|, both axes together; arguments of `whitened`."""
        found = self.whitened(values, white, fix_sd, process)
        return found.products(found), found.log_determinant

    def whitened(self, values: Array, white: Array, fix_sd: float, process: MarkovProcess | None) -> WhitenedColumns:
        """Whiten columns.

        Raises numpy.linalg.LinAlgError when the covariance is not positive definite.

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
        """
        prior = None if process is None else _ProcessStates.of(self, process)
        variance = white.reshape(2, -1) + fix_sd**2 * self._unshared_fix_variance
        variance = variance if prior is None else variance + prior.rest
        if not np.all(variance > 0.0):
            raise np.linalg.LinAlgError("a variance is not positive")
        columns = np.ascontiguousarray(np.swapaxes(values, 1, 2))
        independent = WhitenedColumns(columns / np.sqrt(variance)[:, None], (), float(np.log(variance).sum()))
        if prior is None and not self._shares_any_fix:
            return independent
        states, log_determinant = self._states(columns / variance[:, None], variance, fix_sd, prior), 0.0
        removed = []
        for axis in (0, 1):
            factor, failed = lapack.dpbtrf(states.band[axis].T, lower=1)
            if failed:
                raise np.linalg.LinAlgError("the covariance is not positive definite")
            whitened, _ = lapack.dtbtrs(factor, states.right[axis].T, uplo="L", overwrite_b=1)
            removed.append(whitened.T)
            log_determinant += 2.0 * float(np.log(factor[0]).sum()) + states.log_determinant
        return WhitenedColumns(independent.added, tuple(removed), independent.log_determinant + log_determinant)

    @cached_property
    def _unshared_fix_variance(self) -> Array:
        """Variance of a leg's velocity error from fixes of 1 m that no other leg shares, shape (n,) [1/s²]."""
        starts = self.start_scale**2 * (1.0 - self.in_common)
        ends = self.end_scale**2 * (1.0 - np.append(self.in_common[1:], 0.0))
        return np.asarray((starts + ends) / self.under_way**2)

    @cached_property
    def _shared_fix_loads(self) -> tuple[Array, Array]:
        """Velocity error of a leg for a fix error of 1 m before it and after it that another leg shares [1/s]."""
        loads = np.sqrt(self.in_common)
        start = -self.start_scale * loads / self.under_way
        return start, self.end_scale * np.append(loads[1:], 0.0) / self.under_way

    @cached_property
    def _shares_any_fix(self) -> bool:
        return bool(self.in_common.any())

    def dense(self, white: Array, fix_sd: float, process: MarkovProcess | None) -> Array:
        """Return Σ of each axis written out, shape (2, n, n) [m²/s²]; arguments of `whitened`."""
        n = len(self.under_way)
        total = np.zeros((n, n)) if process is None else self._of_process(process)
        total[np.diag_indices(n)] += fix_sd**2 * self.fix_variance()
        start, end = (fix_sd * np.broadcast_to(each, n) / self.under_way for each in (self.start_scale, self.end_scale))
        after, shared = np.arange(1, n), self.in_common[1:] * start[1:] * end[:-1]
        total[after - 1, after] -= shared
        total[after, after - 1] -= shared
        both = np.stack([total, total])
        both[:, np.arange(n), np.arange(n)] += white.reshape(2, -1)
        return both

    def _of_process(self, process: MarkovProcess) -> Array:
        """Covariance of one component of the legs' errors by a process alone, shape (n, n) [m²/s²]."""
        kept, added = _transitions(self, process)
        share, rest = process.mean_over(self.under_way)
        total, with_state, variance = np.zeros((len(share), len(share))), np.zeros(len(share)), 0.0
        for leg in range(len(share)):  # the mean over each leg with those before, by way of the values at its ends
            start = kept[2 * leg] * with_state
            at_start = kept[2 * leg] ** 2 * variance + added[2 * leg]
            across, with_state = kept[2 * leg + 1] * at_start, kept[2 * leg + 1] * start
            variance = kept[2 * leg + 1] * across + added[2 * leg + 1]
            total[leg, :leg] = total[:leg, leg] = (share[leg] * (start + with_state))[:leg]
            total[leg, leg] = share[leg] ** 2 * (at_start + 2.0 * across + variance)
            with_state[leg] = share[leg] * (across + variance)
        return total + np.diag(rest)

    def _states(self, weighted: Array, variance: Array, fix_sd: float, prior: "_ProcessStates | None") -> "_States":
        """States of both axes: the process at both ends of each leg, the fix after it over its standard deviation.

        `weighted`, shape (2, m, n): columns over the variance, those of a leg apart. `variance`, shape (2, n): that no
        state explains.
        """
        if prior is None:
            return self._fixes(weighted, variance, fix_sd)
        of_process = prior.states(weighted, variance)
        if not self._shares_any_fix:
            return of_process
        start, end = (fix_sd * loads for loads in self._shared_fix_loads)
        both = of_process.followed(self._fixes(weighted, variance, fix_sd))
        share = prior.share / variance
        for place in (0, 1):  # the values at the start and at the end of a leg, in the same leg as the fix after it
            present = prior.present[place::2]
            both.band[:, place::3, 2 - place] = present * share * end
            both.band[:, 2:-3:3, 1 + place] = (present * share * start)[:, 1:]
        return both

    def _fixes(self, weighted: Array, variance: Array, fix_sd: float) -> "_States":
        """Fixes that legs share, as states."""
        start, end = (fix_sd * loads for loads in self._shared_fix_loads)
        diagonal = 1.0 + end**2 / variance
        diagonal[:, :-1] += start[1:] ** 2 / variance[:, 1:]
        right = end * weighted
        right[:, :, :-1] += start[1:] * weighted[:, :, 1:]
        return _States.tridiagonal(diagonal, (end * start / variance)[:, 1:], right, 0.0)


@dataclass(frozen=True)
class _States:
    """States x of both axes: M = Q + Hᵀ R⁻¹ H and Hᵀ R⁻¹ times columns."""

    band: Array
    """The main diagonal of M and those below it, each column's elements together, shape (2, s, w)."""
    right: Array
    """Of m columns, shape (2, m, s)."""
    log_determinant: float
    """Minus ln |Q| of one axis."""

    @classmethod
    def tridiagonal(cls, diagonal: Array, off_diagonal: Array, right: Array, log_determinant: float) -> "_States":
        """Make one state a leg, tied to those of the legs before and after."""
        band = np.zeros((*diagonal.shape, 2))
        band[:, :, 0], band[:, :-1, 1] = diagonal, off_diagonal
        return cls(band, right, log_determinant)

    def followed(self, fixes: "_States") -> "_States":
        """Set after each two of these states, which are tridiagonal, one of the fixes, none tied to these yet."""
        axes, columns, n = fixes.right.shape
        band, right = np.zeros((axes, 3 * n, 4)), np.empty((axes, columns, 3 * n))
        band[:, ::3, :2] = self.band[:, ::2]
        band[:, 1::3, 0], band[:, 1::3, 2] = self.band[:, 1::2, 0], self.band[:, 1::2, 1]
        band[:, 2::3, 0], band[:, 2::3, 3] = fixes.band[:, :, 0], fixes.band[:, :, 1]
        right[:, :, ::3], right[:, :, 1::3], right[:, :, 2::3] = (
            self.right[:, :, ::2],
            self.right[:, :, 1::2],
            fixes.right,
        )
        return _States(band, right, self.log_determinant + fixes.log_determinant)


LEAST_ELAPSED = 1.0
"""Least time between two legs [s], so that the values at the end of one and at the start of the next are two states."""


def _transitions(legs: MarkovCovariance, process: MarkovProcess) -> tuple[Array, Array]:
    """Shares that a process keeps from each of its 2n values to the next, and variances that are added on the way."""
    begins, n = np.isnan(legs.elapsed), len(legs.under_way)
    kept, variance = np.empty(2 * n), np.empty(2 * n)
    kept[::2], variance[::2] = process.transition(np.where(begins, legs.since, np.maximum(legs.elapsed, LEAST_ELAPSED)))
    kept[1::2], variance[1::2] = process.transition(legs.under_way)
    variance[::2] += np.where(begins, kept[::2] ** 2 * process.first_variance, 0.0)
    kept[::2] *= ~begins
    kept[1:] *= variance[:-1] > 0.0
    return kept, variance


@dataclass(frozen=True)
class _ProcessStates:
    """A process at the starts and ends of n legs, in turn: tridiagonal precision, and the legs' means of it."""

    diagonal: Array
    off_diagonal: Array
    """Of the precision [s²/m²]."""
    present: Array
    """1 where the process has a variance, else 0: a random walk is zero where a run begins, shape (2n,)."""
    log_determinant: float
    """ln |precision|."""
    share: Array
    rest: Array
    """The mean over a leg is a share of the sum of both values, and a rest of this variance [m²/s²], shape (n,)."""

    @classmethod
    def of(cls, legs: MarkovCovariance, process: MarkovProcess) -> "_ProcessStates":
        kept, variance = _transitions(legs, process)
        present = (variance > 0.0).astype(float)
        precision = 1.0 / np.where(present > 0.0, variance, 1.0)
        diagonal = precision.copy()
        diagonal[:-1] += kept[1:] ** 2 * precision[1:]
        share, rest = process.mean_over(legs.under_way)
        return cls(diagonal, -kept[1:] * precision[1:], present, float(np.log(precision).sum()), share, rest)

    def states(self, weighted: Array, variance: Array) -> "_States":
        """States of both axes, of columns over the variance that no state explains; see `MarkovCovariance._states`."""
        information = self.share**2 / variance
        diagonal = self.diagonal + self.present * np.repeat(information, 2, axis=1)
        off_diagonal = np.repeat(self.off_diagonal[None], 2, axis=0)
        off_diagonal[:, ::2] += self.present[::2] * self.present[1::2] * information
        right = self.present * np.repeat(self.share * weighted, 2, axis=2)
        return _States.tridiagonal(diagonal, off_diagonal, right, -self.log_determinant)
