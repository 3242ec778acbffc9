"""Whitening leg by leg: likelihoods of n legs in time proportional to n.

An error that persists from leg to leg is a Markov process (Ornstein–Uhlenbeck, random walk), and a fix is shared by
two consecutive legs at most. A leg's error is the mean of the process over its time under way: a share of the sum of
its values at both ends, and a rest that is independent of all others. So each leg is predicted from those before it by
a Kalman filter (Durbin & Koopman 2012, Section 4.3), whose state is the process at the end of a leg and the fix after
it. What legs have beyond their predictions is independent; it solves a triangular system with two diagonals below the
main one, one where only fixes are shared.
"""

import itertools
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import blas, lapack

from missionplan.arrays import Array, Scalars
from missionplan.phases.hooks import MarkovProcess

LegSelection = slice | NDArray[np.int_]


@dataclass(frozen=True)
class WhitenedColumns:
    """Columns X of legs of covariance Σ, as V and weights w of each axis with Xᵀ Σ⁻¹ X = Σ Vᵀ w V."""

    ahead: Array
    """V: what each leg has beyond its prediction from those before it, shape (2, n, m)."""
    weights: Array
    """w under each of c covariances, shape (2, c, n)."""
    log_determinant: float
    """ln |Σ|, both axes together."""

    def products(self, other: "WhitenedColumns") -> Array:
        """Inner products xᵀ Σ⁻¹ y of these columns and others under the first covariance."""
        if other is self:  # a matrix by its own transpose takes half the time
            scaled = self.ahead * np.sqrt(self.weights[:, 0, :, None])
            return np.asarray(np.sum([columns.T @ columns for columns in scaled], axis=0))
        pairs = zip(self.ahead, self.weights[:, 0], other.ahead, strict=True)
        return np.asarray(np.sum([(mine.T * weight) @ theirs for mine, weight, theirs in pairs], axis=0))

    def products_of_blocks(self, size: int) -> Array:
        """Inner products within each of b consecutive blocks of columns of the same size q, shape (c, b, q, q)."""
        pairs = zip(self.ahead, self.weights, strict=True)
        return np.asarray(np.sum([_of_blocks(columns, size, weights) for columns, weights in pairs], axis=0))


IN_CACHE, FEW = 32768, 3
"""Numbers whose products are added up together, to stay in a processor's cache, and columns of many small blocks."""


def _of_blocks(columns: Array, size: int, weights: Array) -> Array:
    """Inner products within blocks of columns, (N, b·q), under weights, (c, N) → (c, b, q, q)."""
    if size > FEW:
        blocks = columns.reshape(len(columns), -1, size).swapaxes(0, 1)
        return np.asarray(blocks.swapaxes(1, 2) @ (weights[:, None, :, None] * blocks))
    products = np.zeros((len(weights), columns.shape[1] // size, size, size))
    together = max(IN_CACHE // columns.shape[1], 1)
    for first in range(0, len(columns), together):
        rows, row_weights = columns[first : first + together], weights[:, first : first + together]
        for i, j in itertools.combinations_with_replacement(range(size), 2):
            products[:, :, j, i] += row_weights @ (rows[:, i::size] * rows[:, j::size])
    return np.asarray(np.tril(products) + np.swapaxes(np.tril(products, -1), -1, -2))


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
        """Σ over axes of valuesᵀ Σ⁻¹ values, shape (m, m), and ln |Σ|, both axes together; noise as in `prediction`."""
        columns = self.prediction(white, fix_sd, process).whitened(values)
        return columns.products(columns), columns.log_determinant

    def prediction(self, white: Array, fix_sd: float, process: MarkovProcess | None) -> "Prediction":
        """Return how each leg is predicted from those before it.

        Raises numpy.linalg.LinAlgError when a variance is not positive.

        `white`, shape (2,) or (2, n): variance of the independent velocity error on each axis [m²/s²]. `fix_sd`:
        standard deviation of a fix, each axis [m]. `process`: error that persists from leg to leg.
        """
        share, rest = (np.zeros(1),) * 2 if process is None else process.mean_over(self.under_way)
        variance = white.reshape(2, -1) + fix_sd**2 * self._unshared_fix_variance + rest
        if not np.all(variance > 0.0):
            raise np.linalg.LinAlgError("a variance is not positive")
        if process is not None:
            return _by_process(variance, fix_sd * self._shared_fix_loads, share, *_transitions(self, process))
        return _by_fixes(variance, fix_sd * self._shared_fix_loads) if self.in_common.any() else Prediction(variance)

    @cached_property
    def _unshared_fix_variance(self) -> Array:
        """Variance of a leg's velocity error from fixes of 1 m that no other leg shares, shape (n,) [1/s²]."""
        starts = self.start_scale**2 * (1.0 - self.in_common)
        ends = self.end_scale**2 * (1.0 - np.append(self.in_common[1:], 0.0))
        return np.asarray((starts + ends) / self.under_way**2)

    @cached_property
    def _shared_fix_loads(self) -> Array:
        """Velocity error of a leg for 1 m of error of the fix before it and after it, if shared, shape (2, n) [1/s]."""
        loads = np.sqrt(self.in_common)
        start = -self.start_scale * loads / self.under_way
        return np.stack([start, self.end_scale * np.append(loads[1:], 0.0) / self.under_way])

    def dense(self, white: Array, fix_sd: float, process: MarkovProcess | None) -> Array:
        """Return Σ of each axis written out, shape (2, n, n) [m²/s²]; arguments of `prediction`."""
        n = len(self.under_way)
        total = np.zeros((n, n)) if process is None else self._of_process(process)
        total[np.diag_indices(n)] += fix_sd**2 * self.fix_variance()
        start, end = (fix_sd * np.broadcast_to(size, n) / self.under_way for size in (self.start_scale, self.end_scale))
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


LEAST_ELAPSED = 1.0
"""Least time between two legs [s]."""


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


def _by_fixes(variance: Array, fixes: Array) -> "Prediction":
    """Predict legs by the fixes that they share alone: their covariance is tridiagonal.

    `fixes`: error of a leg for a unit of the fix before it and after it, shape (2, n).
    """
    bands = [lapack.dpttrf(diagonal, fixes[0, 1:] * fixes[1, :-1]) for diagonal in variance + np.sum(fixes**2, axis=0)]
    return Prediction(np.stack([diag for diag, *_ in bands]), np.stack([np.append(0.0, sub) for _, sub, _ in bands]))


def _by_process(variance: Array, fixes: Array, share: Array, kept: Array, added: Array) -> "Prediction":
    """Predict legs by a process, by what it keeps and gains to their starts and ends in turn, and by their fixes."""
    (until, over), (before, under_way) = kept.reshape(-1, 2).T, added.reshape(-1, 2).T
    start, end = fixes
    of_process, through = share * (1.0 + over) * until, 1.0 + over
    comes_up = share**2 * (through**2 * before + under_way) + end**2
    with_process = share * (through * over * before + under_way)
    columns = (of_process, start, end, comes_up, with_process, until * over, over**2 * before + under_way)
    rows = np.stack(columns, axis=1).tolist()
    unlike = variance if np.any(variance[0] != variance[1]) else variance[:1]
    predictions = np.broadcast_to([_filtered(rows, variances) for variances in unlike.tolist()], (2, len(rows), 3))
    return Prediction(predictions[:, :, 0], predictions[:, :, 1], (of_process, until * over, predictions[:, :, 2]))


def _filtered(rows: list[list[float]], variances: list[float]) -> list[tuple[float, float, float]]:
    """Variance of each leg beyond its prediction, and what of it goes to the next leg by their fix and to the process.

    `rows`: of each leg its error for a unit of the process, of the fix before it and of the fix after it; the variance
    that comes up on the leg, what of it goes with the process, the share that this keeps, and the variance that is
    added to it. `variances`: what no state explains [m²/s²].
    """
    predictions, after, spread, tied, left = [], 0.0, 0.0, 0.0, 1.0
    for (of_process, before, end, added, both, kept, grown), rest in zip(rows, variances, strict=True):
        with_process, with_fix = spread * of_process + tied * before, tied * of_process + left * before
        total = of_process * with_process + before * with_fix + added + rest
        gain = (kept * with_process + both) / total
        predictions.append((total, before * after, gain))
        after = end / total
        spread, tied, left = kept * kept * spread + grown - gain * gain * total, -gain * end, 1.0 - after * end
    return predictions


MANY = 256
"""Columns from which they are whitened side by side, leg after leg, and not one after the other."""


@dataclass(frozen=True)
class Prediction:
    """How each leg is predicted from those before it."""

    variance: Array
    """Of what it has beyond that, shape (2, n) [m²/s²]."""
    of_fix: Array | None = None
    """Its error for a unit of what the leg before has beyond its own prediction, by their fix; None where no leg tells
    of another, shape (2, n)."""
    of_process: tuple[Array, Array, Array] | None = None
    """Its error for a unit of the process at the end of the leg before, the share of this that is left at its own end,
    and what it has beyond its prediction adds to it, shapes (n,), (n,) and (2, n)."""

    def whitened(self, values: Array) -> WhitenedColumns:
        """Whiten columns, shape (2, n, m)."""
        if self.of_fix is not None:
            values = self._side_by_side(values) if values.shape[2] > MANY else self._one_by_one(values, self.of_fix)
        return WhitenedColumns(values, 1.0 / self.variance[:, None], float(np.log(self.variance).sum()))

    def _one_by_one(self, values: Array, of_fix: Array) -> Array:
        """Solve for what legs have beyond their predictions, in turn with the process where there is one."""
        _, n, m = values.shape
        states = 1 if self.of_process is None else 2
        solution = np.zeros((2, m, states * n))
        solution[:, :, ::states] = np.swapaxes(values, 1, 2)
        for axis, columns in enumerate(solution):
            band = np.zeros((states * n, states + 1))
            band[:-states:states, -1] = of_fix[axis, 1:]
            if self.of_process is not None:
                of_process, kept, gain = self.of_process
                band[::2, 1], band[1:-1:2, 1], band[1:-1:2, 2] = -gain[axis], of_process[1:], -kept[1:]
            lapack.dtbtrs(band.T, columns.T, uplo="L", diag="U", overwrite_b=1)  # in place
        return np.swapaxes(solution, 1, 2)[:, ::states]

    def _side_by_side(self, values: Array) -> Array:
        """The same, the cost of a leg hardly growing with the number of columns."""
        assert self.of_fix is not None
        solution = np.array(values, order="C")
        for axis, columns in enumerate(solution):
            before, state = np.zeros((2, columns.shape[1]))
            of_fix = self.of_fix[axis].tolist()
            if self.of_process is None:
                for row, by_fix in zip(columns, of_fix, strict=True):
                    before = blas.daxpy(before, row, a=-by_fix)
                continue
            of_process, kept, gain = self.of_process
            steps = zip(columns, of_fix, of_process.tolist(), kept.tolist(), gain[axis].tolist(), strict=True)
            for row, by_fix, by_process, left, gained in steps:
                blas.daxpy(before, row, a=-by_fix)
                before = blas.daxpy(state, row, a=-by_process)
                state *= left
                blas.daxpy(row, state, a=gained)
        return solution
