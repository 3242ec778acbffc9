"""Nonlinear least squares with normal priors: the damped Gauss–Newton method, from many starts at once.

Maximum a posteriori estimates for a model with Gaussian noise. The method is that of Nocedal & Wright (2006),
*Numerical Optimization*, section 10.3 (their Eq. 10.23 with step lengths below 1 where a full step does not descend),
and Björck (1996), *Numerical Methods for Least Squares Problems*, chapter 9. Priors are further rows of the least
squares problem (Tarantola 2005, *Inverse Problem Theory*, chapter 3): in coordinates scaled by their prior standard
deviations they add the identity to the normal equations. That has the form of Levenberg's (1944) and Marquardt's
(1963) damping, but it is part of the model and stays the same. For a Student-t prior the normal prior that touches it
is used (iteratively reweighted least squares).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.diagnosis.inference.block_covariance import BlockCovariance
from missionplan.diagnosis.inference.prior import Prior

COMPARED_AFTER, ABANDONED_BEYOND = 3, 3.0
"""Iterations after which starts of a group are compared, and excess of the objective that ends the worse [nats]."""


@dataclass(frozen=True)
class LeastSquares:
    """Objective ½|L⁻¹(y − f(θ))|²/φ² + N ln φ + ½Σ((θ − μ)/s)², with LLᵀ the covariance of the noise."""

    predict: Callable[[Array], Array]
    """f, of m settings of the coordinates at once: (k, m) → (N, m)."""
    y: Array
    """Data, shape (N,)."""
    noise: Array | BlockCovariance
    """Standard deviations of independent noise, shape (N,), or the covariance of the noise."""
    centre: Array
    prior_sd: Array
    """Prior means μ and standard deviations s. Steps and differences are measured in these standard deviations, shape
    (k,)."""
    noise_factors: tuple[float, float] = (1.0, 1.0)
    """Range of φ. At each θ it takes its likeliest value, the root mean square of the whitened residuals (concentrated
    likelihood; Seber & Wild 1989, *Nonlinear Regression*, chapter 2)."""


@dataclass(frozen=True)
class GaussNewtonOptions:
    """How to search."""

    iterations: int
    """Steps that are tried at most, rejected ones included."""
    tolerance: float
    """Decrease of the objective below which a search has converged [nats]."""
    difference: float
    """Step of the finite differences, in prior standard deviations."""
    central: bool = False
    """Whether the differences are central or forward."""
    step_lengths: tuple[float, ...] = (1.0, 0.25)
    """Shares of a Gauss–Newton step, each tried when the one before did not descend."""
    longest_step: float = np.inf
    """Bound on each coordinate of a step, in prior standard deviations."""


@dataclass(frozen=True)
class Start:
    """One point to search from."""

    at: Array
    """All coordinates, shape (k,)."""
    free: NDArray[np.int_]
    """Coordinates that are fitted, shape (a,)."""
    group: int
    """Starts of the same fit share a number; those that fall behind are abandoned."""
    rows: NDArray[np.int_] | None = None
    """Data to fit; default all."""
    prior: Prior | None = None
    """Of all coordinates; default the problem's."""


@dataclass(frozen=True)
class GaussNewtonResult:
    """The model where a search ended."""

    at: Array
    """Coordinates, shape (k,)."""
    objective: float
    """There [nats]; infinite where the model or its derivatives are not finite."""
    prediction: Array
    """The model there, shape (N,)."""
    jacobian: Array
    """Its derivatives along the free coordinates, shape (N, a)."""


def gauss_newton(
    problem: LeastSquares, starts: Sequence[Start], options: GaussNewtonOptions
) -> list[GaussNewtonResult]:
    """Minimise from every start; each iteration calls the model once for all searches that still go on.

    Raises numpy.linalg.LinAlgError when the covariance of the noise is not positive definite.
    """
    if not starts:
        return []
    evaluator = _Evaluator(problem, starts, options)
    points = evaluator([(start, start.at) for start in starts])
    searches = [_Search(start, point) for start, point in zip(starts, points, strict=True)]
    for iteration in range(1, options.iterations + 1):
        running = [search for search in searches if search.running]
        if not running:
            break
        tried = evaluator([(search.start, search.next_trial(evaluator, options)) for search in running])
        for search, point in zip(running, tried, strict=True):
            search.advance(point, options)
        if iteration >= COMPARED_AFTER:
            _abandon(searches)
    return [search.point for search in searches]


def perturbed(at: Array, free: NDArray[np.int_], steps: Array) -> Array:
    """Settings with one of the free coordinates moved in each, (k,) → (k, a).

    `at`, shape (k,): coordinates. `free`, shape (a,): those that are moved. `steps`, shape (a,): by how much.
    """
    settings = np.repeat(at[:, None], len(free), axis=1)
    settings[free, np.arange(len(free))] += steps
    return settings


@dataclass(frozen=True)
class _Point(GaussNewtonResult):
    """A point on the way; residuals and scaled derivatives of the n data that are fitted, whitened by the noise."""

    white_residual: Array
    white_jacobian: Array


class _Evaluator:
    """The model at points of several searches: one call for all, derivatives by finite differences included."""

    def __init__(self, problem: LeastSquares, starts: Sequence[Start], options: GaussNewtonOptions) -> None:
        self._problem, self._options = problem, options
        self._noises: dict[bytes, BlockCovariance] = {}

    def __call__(self, wanted: Sequence[tuple[Start, Array]]) -> list[_Point]:
        """Evaluate searches, given by their starts, at coordinates."""
        settings = [self._settings(start, at) for start, at in wanted]
        ends = np.cumsum([block.shape[1] for block in settings])
        predictions = np.split(self._problem.predict(np.concatenate(settings, axis=1)), ends[:-1], axis=1)
        return [self._point(start, at, block) for (start, at), block in zip(wanted, predictions, strict=True)]

    def _settings(self, start: Start, at: Array) -> Array:
        """The point itself, and one setting a free coordinate for the differences ahead, then for those behind."""
        steps = self._options.difference * self._problem.prior_sd[start.free]
        blocks = [at[:, None], perturbed(at, start.free, steps)]
        if self._options.central:
            blocks.append(perturbed(at, start.free, -steps))
        return np.concatenate(blocks, axis=1)

    def _point(self, start: Start, at: Array, predictions: Array) -> _Point:
        problem, free = self._problem, start.free
        prediction, columns = predictions[:, 0], self._differences(predictions, len(free))
        white = self._whitened(start, np.concatenate([(problem.y - prediction)[:, None], columns], axis=1))
        # factor on the noise that makes whitened residuals of unit size, within its range
        low, high = problem.noise_factors
        factor = low if low == high else float(np.clip(np.sqrt(np.mean(white[:, 0] ** 2)), low, high))
        white = white / factor
        misfit = self._prior(start).misfit(at[free])
        objective = 0.5 * float(white[:, 0] @ white[:, 0]) + misfit + len(white) * np.log(factor)
        objective = float(objective) if np.all(np.isfinite(white)) else np.inf
        return _Point(at, objective, prediction, columns / problem.prior_sd[free], white[:, 0], white[:, 1:])

    def _prior(self, start: Start) -> Prior:
        """Prior of a start's free coordinates."""
        return (start.prior or Prior(self._problem.centre, self._problem.prior_sd)).of(start.free)

    def _differences(self, predictions: Array, count: int) -> Array:
        """Derivatives along the free coordinates in prior standard deviations, shape (N, a)."""
        ahead = predictions[:, 1 : 1 + count]
        if self._options.central:
            return np.asarray((ahead - predictions[:, 1 + count :]) / (2.0 * self._options.difference))
        return np.asarray((ahead - predictions[:, :1]) / self._options.difference)

    def _whitened(self, start: Start, columns: Array) -> Array:
        """Rows of the data that are fitted, over the noise."""
        rows, noise = slice(None) if start.rows is None else start.rows, self._problem.noise
        if not isinstance(noise, BlockCovariance):
            return np.asarray(columns[rows] / noise[rows, None])
        if start.rows is None:
            return noise.whitened(columns)
        key = start.rows.tobytes()
        if key not in self._noises:
            self._noises[key] = noise.restricted(start.rows)
        return self._noises[key].whitened(columns[rows])

    def step(self, start: Start, point: _Point) -> Array:
        """Gauss–Newton step, shape (k,): the solution of the normal equations in scaled coordinates, bounded."""
        free, unit = start.free, self._problem.prior_sd[start.free]
        prior = self._prior(start)
        move = np.zeros(len(point.at))
        centre, sd = prior.centre, np.sqrt(prior.variance(point.at[free]))
        jacobian, pull = point.white_jacobian, (centre - point.at[free]) / sd
        precision = np.square(unit / sd)
        right = jacobian.T @ point.white_residual + precision * (centre - point.at[free]) / unit
        try:
            scaled = np.linalg.solve(jacobian.T @ jacobian + np.diag(precision), right)
        except np.linalg.LinAlgError:  # columns so much alike, and so far above the prior, that rounding hides it
            stacked = np.concatenate([jacobian, np.diag(unit / sd)])
            scaled = np.linalg.lstsq(stacked, np.concatenate([point.white_residual, pull]), rcond=None)[0]
        move[free] = unit * np.clip(scaled, -self._options.longest_step, self._options.longest_step)
        return move


class _Search:
    """Progress of the search from one start."""

    def __init__(self, start: Start, point: _Point) -> None:
        self.start, self.point = start, point
        self.running = bool(np.isfinite(point.objective)) and len(start.free) > 0
        self._trial = 0

    def next_trial(self, evaluator: _Evaluator, options: GaussNewtonOptions) -> Array:
        """Coordinates to try next."""
        return self.point.at + options.step_lengths[self._trial] * evaluator.step(self.start, self.point)

    def advance(self, tried: _Point, options: GaussNewtonOptions) -> None:
        """Move to the point tried if it descends, else shorten the step; end when neither helps."""
        gain = self.point.objective - tried.objective
        if gain > 0.0:
            self.point = tried
        if gain > options.tolerance:
            self._trial = 0
        elif gain > 0.0 or self._trial + 1 == len(options.step_lengths):
            self.running = False
        else:
            self._trial += 1


def _abandon(searches: Sequence[_Search]) -> None:
    """End searches that are far behind the best of their group."""
    best: dict[int, float] = {}
    for search in searches:
        best[search.start.group] = min(best.get(search.start.group, np.inf), search.point.objective)
    for search in searches:
        if search.point.objective >= best[search.start.group] + ABANDONED_BEYOND:
            search.running = False
