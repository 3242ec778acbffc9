"""Model of a navigation log: legs' velocity errors, linear in the causes, with a covariance of a few hyperparameters.

The effects' own hooks give the columns, their own covariance functions the covariance: nothing is modelled twice.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import cast

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular
from scipy.stats import norm

from missionplan.diagnose import transit_menu
from missionplan.diagnose.coordinates import (
    Coordinate,
    Estimate,
    coordinates_of,
    estimates,
    is_possible,
    parameters_from,
)
from missionplan.diagnose.likelihood import (
    LOG_2PI,
    Laplace,
    Marginal,
    expected_log_ratio,
    gaussian_marginal,
    laplace,
    student_marginal,
)
from missionplan.diagnose.model import Causes, Failure, Fit, Score, Wanted
from missionplan.diagnose.residuals import Residuals
from missionplan.diagnose.transit_axes import transit_axes
from missionplan.diagnose.transit_data import TransitData
from missionplan.effects import CATALOGUE, effects_of
from missionplan.effects.persistent_error import PersistentError
from missionplan.effects.random_walk import RandomWalk
from missionplan.effects.tidal_current import resolvable
from missionplan.phases.hooks import Leg, TransitEffect

Array = NDArray[np.float64]
Rows = slice | NDArray[np.int_]
ALL = slice(None)

RANDOM = ("persistent-error", "random-walk", "fix-error", "heavy-tails")
"""Effects that enter the covariance and not the mean."""
ALTERNATIVES = (frozenset({"persistent-error", "random-walk", "heavy-tails"}),)

SIGMA_SPREAD = 0.7
"""How far the velocity error's size may lie from the mission's: standard deviation of its logarithm."""
FIX_SPREAD = 0.4
FIX_UNSTATED = (3.0, 0.7)
"""Median [m] and log-spread of the fix error where neither data set nor mission states one."""
TEST_LEVEL = 0.01
"""Level of the residual tests, all together."""
LEAST_DOF = 2.02
STEP = 1e-3
"""Step of the finite differences, in prior standard deviations of a cause."""


@dataclass(frozen=True)
class Hyper:
    """A hyperparameter of the covariance, by its logarithm: normal prior about `centre` with `spread`."""

    effect: str
    name: str
    centre: float
    spread: float


@dataclass(frozen=True)
class TransitState:
    """A fitted transit: hyperparameters by Laplace, coefficients of all coordinates at their mode."""

    hypers: tuple[Hyper, ...]
    posterior: Laplace
    marginal: Marginal
    about: Array


@dataclass(frozen=True)
class TransitModel:
    """Base model of a mission's transit and every cause that the record could show.

    Attributes
    ----------
    data : TransitData
        The log.
    base : array, shape (2, n)
        Velocity error that the mission expects: site's current and mean of the velocity error [m/s].
    covariance : array, shape (2, 2)
        Σ_v of the mission [m²/s²].
    fix_error : float
        The mission's standard deviation of a fix [m]; 0 when not given.
    current_sd : tuple of float
        How unsure the mission itself is of the steady current, east and north [m/s].
    only : tuple of Coordinate, optional
        Coordinates to use; default those that the record can resolve.
    """

    data: TransitData
    base: Array
    covariance: Array
    fix_error: float
    current_sd: tuple[float, float] = (0.0, 0.0)
    only: tuple[Coordinate, ...] | None = None

    @property
    def alternatives(self) -> Sequence[frozenset[str]]:
        """Descriptions of the errors' randomness that exclude each other."""
        return ALTERNATIVES

    @cached_property
    def untestable(self) -> Mapping[str, str]:
        """Effects that this record cannot show, and why."""
        why = {}
        if not math.isfinite(self.data.latitude):
            why["inertial-current"] = "needs the latitude: site.origin in the mission, or positions by latitude"
        if not self.data.has_surface_time:
            why["surface-drift"] = "needs the time at the surface before each fix: column surface_s"
        if not resolvable(self._length):
            why["tidal-current"] = "needs a record of at least half a tidal period"
        return why

    @property
    def _length(self) -> float:
        return float(np.ptp(self.data.middle))

    @cached_property
    def candidates(self) -> Causes:
        """Effects of the catalogue that this record could show."""
        return tuple(info.id for info in effects_of("transit") if info.id not in self.untestable)

    @cached_property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """Coordinates of all causes of the mean."""
        if self.only is not None:
            return self.only
        found: list[Coordinate] = []
        for name in self.candidates:
            if name == "tidal-current":
                tides = resolvable(self._length)
                names = [key for key in CATALOGUE[name].parameters if key.split("_")[0] in tides]
                found += coordinates_of(CATALOGUE[name], names)
            elif name not in RANDOM:
                found += coordinates_of(CATALOGUE[name])
        return tuple(found)

    @cached_property
    def axes(self) -> Array:
        """Principal axes of Σ_v as columns, shape (2, 2); east and north when it is isotropic."""
        if np.allclose(self.covariance, self.covariance[0, 0] * np.eye(2)):
            return np.eye(2)
        return cast(Array, np.linalg.eigh(self.covariance)[1])

    @cached_property
    def y(self) -> Array:
        """Velocity errors less what the mission expects, on the principal axes, shape (2, n) [m/s]."""
        return self.axes.T @ (self.data.velocity_error - self.base)

    @cached_property
    def leg(self) -> Leg:
        """The legs as an effect sees them: the course is the one dead-reckoned."""
        data = self.data
        path = data.dead_reckoned - data.start
        length = np.hypot(*path)
        return Leg(
            data.t_start,
            data.under_way,
            data.start,
            path / np.maximum(length, 1e-9),
            length / data.under_way,
            data.latitude,
        )

    def mean_error(self, values: Array) -> Array:
        """Velocity errors that the causes of the mean give, on the principal axes, shape (2, n) [m/s]."""
        total = np.zeros((2, self.data.n))
        data = self.data
        for name, parameters in parameters_from(self.coordinates, values).items():
            effect = cast(TransitEffect, CATALOGUE[name].make(parameters))
            total += effect.velocity(self.leg)
            drift = effect.surface_velocity(data.t_start + data.under_way, data.surface, data.end)
            total += drift * data.surface / data.under_way
        return self.axes.T @ total

    def columns(self, about: Array) -> Array:
        """Columns of the coordinates by central differences through the effects' hooks, shape (2, n, k)."""
        steps = np.diag([STEP * coordinate.slab for coordinate in self.coordinates])
        rows = [(self.mean_error(about + step) - self.mean_error(about - step)) / (2.0 * step.sum()) for step in steps]
        return np.stack(rows, axis=2)

    @cached_property
    def _columns_at_zero(self) -> Array:
        return self.columns(np.zeros(len(self.coordinates)))

    def prior_sd(self, causes: Causes) -> Array:
        """Prior standard deviation of each coordinate: its slab when its effect is a cause, else its spike."""
        values = [c.slab if c.effect in causes else c.spike for c in self.coordinates]
        for index, coordinate in enumerate(self.coordinates):
            if coordinate.effect == "mean-current":
                values[index] = math.hypot(values[index], self.current_sd[coordinate.name == "north"])
        return np.array(values)

    def hypers(self, causes: Causes) -> tuple[Hyper, ...]:
        """Hyperparameters under a set of causes."""
        sigma = math.sqrt(max(0.5 * float(np.trace(self.covariance)), 1e-6))
        stated = self.data.fix_sd or self.fix_error
        fix, spread = (stated, FIX_SPREAD) if stated > 0.0 else FIX_UNSTATED
        found = [Hyper("", "sigma_v", math.log(sigma), SIGMA_SPREAD), Hyper("", "fix_sd", math.log(fix), spread)]
        for name in RANDOM:
            if name in causes:
                parameters = CATALOGUE[name].parameters
                found += [Hyper(name, key, math.log(p.median), math.log(p.factor)) for key, p in parameters.items()]
        return tuple(found)

    @cached_property
    def _fix_pattern(self) -> Array:
        """Covariance of the errors for a fix error of 1 m, shape (n,) or, with fixes that two legs share, (n, n)."""
        data = self.data
        variance: Array = 2.0 / data.under_way**2
        shared = np.all(data.end[:, :-1] == data.start[:, 1:], axis=0) & (data.run[:-1] == data.run[1:])
        if not shared.any():
            return variance
        beside = np.where(shared, -1.0 / (data.under_way[:-1] * data.under_way[1:]), 0.0)
        return np.asarray(np.diag(variance) + np.diag(beside, 1) + np.diag(beside, -1))

    def noise(self, values: Mapping[tuple[str, str], float]) -> Array:
        """Covariance of the velocity errors beside the causes of the mean [m²/s²].

        Shape (2, n) where legs are independent, (1, n, n) where both axes share it, else (2, n, n).

        Parameters
        ----------
        values : mapping
            Hyperparameters by effect and name, not their logarithms.
        """
        shape = np.linalg.eigvalsh(self.covariance) if np.any(self.covariance) else np.ones(2)
        shape = np.maximum(shape / max(shape.mean(), 1e-12), 1e-6)
        white: Array = values["", "sigma_v"] ** 2 * shape[:, None] * np.ones(self.data.n)
        fix = (values["", "fix_sd"] ** 2 + values.get(("fix-error", "sd"), 0.0) ** 2) * self._fix_pattern
        lasting = self._lasting(values)
        if fix.ndim == 1 and lasting is None:
            return np.asarray(white + fix)
        full: Array = (np.diag(fix) if fix.ndim == 1 else fix) + (0.0 if lasting is None else lasting)
        if np.ptp(shape) == 0.0:
            return np.asarray(full[None] + np.diag(white[0]))
        return np.asarray(full[None] + white[:, :, None] * np.eye(self.data.n))

    def _lasting(self, values: Mapping[tuple[str, str], float]) -> Array | None:
        effects: list[PersistentError | RandomWalk] = []
        if ("persistent-error", "sigma") in values:
            effects.append(PersistentError(values["persistent-error", "sigma"], values["persistent-error", "time"]))
        if ("random-walk", "rate") in values:
            effects.append(RandomWalk(values["random-walk", "rate"]))
        if not effects:
            return None
        total = np.zeros((self.data.n, self.data.n))
        for run in np.unique(self.data.run):
            legs = np.flatnonzero(self.data.run == run)
            total[np.ix_(legs, legs)] += sum(effect.covariance(self.data.middle[legs]) for effect in effects)
        return total

    def linearised(self, about: Array) -> tuple[Array, Array]:
        """Data and columns of the model linearised about coordinates: y ≈ columns·coordinates, (2, n), (2, n, k)."""
        if not np.any(about):
            return self.y, self._columns_at_zero
        columns = self.columns(about)
        return self.y - self.mean_error(about) + columns @ about, columns

    def marginal(self, causes: Causes, at: Array, linear: tuple[Array, Array], rows: Rows = ALL) -> Marginal:
        """Marginalise the causes of the mean at given hyperparameters (their logarithms), from some of the legs.

        Raises
        ------
        numpy.linalg.LinAlgError
            When the hyperparameters give no covariance.
        """
        values = self.values(causes, at)
        y, columns = linear[0][:, rows], linear[1][:, rows]
        dof = values.get(("heavy-tails", "dof"))
        noise = self.noise(values)[:, rows]
        noise = noise[:, :, rows] if noise.ndim == 3 else noise
        if dof is None:
            return gaussian_marginal(y, columns, self.prior_sd(causes), noise)
        if dof <= LEAST_DOF:
            raise np.linalg.LinAlgError("the variance of the errors does not exist")
        variance = noise if noise.ndim == 2 else np.diagonal(noise, axis1=1, axis2=2) * np.ones((2, 1))
        return student_marginal(y, columns, self.prior_sd(causes), variance, dof)

    def values(self, causes: Causes, at: Array) -> dict[tuple[str, str], float]:
        """Hyperparameters by effect and name, from their logarithms."""
        return {(h.effect, h.name): math.exp(value) for h, value in zip(self.hypers(causes), at, strict=True)}

    def fit(self, causes: Causes, near: Sequence[Fit] = (), rows: Rows = ALL, *, integrate: bool = True) -> Fit:
        """Fit a set of causes: hyperparameters by Laplace, coefficients exactly, angles linearised where they end up.

        Parameters
        ----------
        causes : tuple of str
            The set.
        near : sequence of Fit
            Fits to start from.
        rows : slice or array
            Legs to fit; default all.
        integrate : bool
            Whether the evidence is wanted; without it only the mode is.

        Raises
        ------
        numpy.linalg.LinAlgError
            When no covariance near the start is positive definite.
        """
        hypers = self.hypers(causes)
        starts, spread = _starts(hypers, near)
        about = np.zeros(len(self.coordinates))
        turns = bool({"compass-bias", "compass-deviation"} & set(causes))
        for _ in range(3 if turns else 1):
            linear = self.linearised(about)
            found = self._climb(causes, hypers, starts, spread, linear, rows, integrate=integrate)
            best = self.marginal(causes, found.mode, linear, rows)
            state = TransitState(hypers, found, best, about)
            about, starts, spread = best.mean, [found.mode], found.covariance
        return self._described(causes, state)

    def fit_all(self, wanted: Sequence[Wanted]) -> list[Fit | Failure]:
        """Fit several sets of causes; one that cannot be fitted says why."""
        found: list[Fit | Failure] = []
        for causes, near in wanted:
            try:
                found.append(self.fit(causes, near))
            except np.linalg.LinAlgError as error:
                found.append(Failure(causes, str(error)))
        return found

    def promise(self, causes: Causes, parent: Fit) -> float:
        """What the causes beyond a parent's would add to its log density, its hyperparameters held; inf if unknown."""
        if any(name in RANDOM for name in causes if name not in parent.causes):
            return math.inf
        linear = self.linearised(np.zeros(len(self.coordinates)))
        mode = parent.state.posterior.mode
        with_it, without = (self.marginal(names, mode, linear) for names in (causes, parent.causes))
        return with_it.log_density - without.log_density

    def residuals(self, fit: Fit) -> Residuals:
        """Velocity errors leg by leg (first axis, second axis, next leg) and their covariance under a fit."""
        linear = self.linearised(fit.state.about)
        covariance = self._total_covariance(fit, linear[1])
        n = self.data.n
        order = np.arange(2 * n).reshape(2, n).T.ravel()
        return Residuals(
            linear[0].ravel()[order],
            covariance[np.ix_(order, order)],
            np.tile([0, 1], n),
            transit_axes(self.data, self.leg, self.axes),
            np.repeat(self.data.labels, 2),
            TEST_LEVEL,
        )

    def _total_covariance(self, fit: Fit, columns: Array, random: Fit | None = None) -> Array:
        """Covariance of all errors with the coefficients' priors, first axis then second, shape (2n, 2n).

        `random` says whose hyperparameters give the noise, the fit's own by default.
        """
        source = random or fit
        noise = self.noise(self.values(source.causes, source.state.posterior.mode))
        full = noise if noise.ndim == 3 else noise[:, :, None] * np.eye(self.data.n)
        n = self.data.n
        scaled = (columns * self.prior_sd(fit.causes)).reshape(2 * n, -1)
        total = scaled @ scaled.T
        total[:n, :n] += full[0]
        total[n:, n:] += full[-1]
        return total

    def predictor(self, fit: Fit) -> Callable[[NDArray[np.int_], NDArray[np.int_]], tuple[Array, Array]]:
        """Predict legs from others under a fit.

        Parameters
        ----------
        fit : Fit
            Hyperparameters to use: those of a fit to the legs seen, or of an earlier part of them.

        Returns
        -------
        callable
            Of the legs seen and the legs asked for: mean, shape (2, m), and covariance, shape (2m, 2m), first axis
            then second, of the velocity errors beyond the base model's mean [m/s].
        """
        y, columns = self.linearised(fit.state.about)
        total = self._total_covariance(fit, columns)
        n = self.data.n

        def predict(seen: NDArray[np.int_], asked: NDArray[np.int_]) -> tuple[Array, Array]:
            have, want = (np.concatenate([legs, legs + n]) for legs in (seen, asked))
            weights = np.linalg.solve(total[np.ix_(have, have)], total[np.ix_(have, want)]).T
            mean = (weights @ y.ravel()[have]).reshape(2, -1) + (self.y - y)[:, asked]
            return mean, total[np.ix_(want, want)] - weights @ total[np.ix_(have, want)]

        return predict

    def one_step_errors(self, fit: Fit) -> Array:
        """Error of each leg's prediction from the legs before it, on the principal axes, shape (2, n) [m/s]."""
        residuals = self.residuals(fit)
        factor = np.linalg.cholesky(residuals.covariance)
        innovations = solve_triangular(factor, residuals.values, lower=True, check_finite=False).reshape(-1, 2)
        places = 2 * np.arange(self.data.n)
        own = np.stack([[factor[places + i, places + j] for j in (0, 1)] for i in (0, 1)])
        return np.asarray(np.einsum("ijn,nj->in", own, innovations))

    def blocks(self) -> list[NDArray[np.int_]]:
        """Blocks of consecutive legs that are held out in turn."""
        count = int(np.clip(self.data.n // 5, 4, 8))
        return [np.asarray(block) for block in np.array_split(np.arange(self.data.n), count)]

    def held_out(self, fits: Sequence[Fit]) -> list[list[Score]]:
        """Predict each block of legs from the others, hyperparameters fitted to the others alone."""
        return [self._block_scores(fit) for fit in fits]

    def _block_scores(self, fit: Fit) -> list[Score]:
        scores = []
        for block in self.blocks():
            others = np.setdiff1d(np.arange(self.data.n), block)
            trained = self.fit(fit.causes, (fit,), others, integrate=False)
            linear = self.linearised(trained.state.about)
            mode = trained.state.posterior.mode
            log_score = (
                self.marginal(fit.causes, mode, linear).log_density
                - self.marginal(fit.causes, mode, linear, others).log_density
            )
            mean, covariance = self.predictor(trained)(others, block)
            error = (self.y[:, block] - mean).ravel()
            half = norm.ppf(0.95) * np.sqrt(np.diag(covariance))
            name = f"legs {self.data.labels[block[0]]} to {self.data.labels[block[-1]]}"
            inside = int((np.abs(error) <= half).sum())
            scores.append(Score(name, log_score, float(error @ error), inside, error.size))
        return scores

    @property
    def menu(self) -> Sequence[str]:
        """Further legs, in words, cheapest first."""
        names = [what for what, _ in transit_menu.MENU]
        return names if self.data.has_surface_time else [name for name in names if "fix 15" not in name]

    def separation(self, first: Fit, second: Fit, entry: int | None) -> float:
        """Expected ln Bayes factor under the first set's fit; see `expected_log_ratio`."""
        model = self
        if entry is not None:
            names = [what for what, _ in transit_menu.MENU]
            data = transit_menu.planned(self.data, names.index(self.menu[entry]))
            added = np.repeat(self.base.mean(axis=1, keepdims=True), data.n - self.data.n, axis=1)
            model = replace(self, data=data, base=np.concatenate([self.base, added], axis=1), only=self.coordinates)
        columns = model.columns(np.zeros(len(self.coordinates)))
        own = np.array([coordinate.effect in first.causes for coordinate in self.coordinates])
        mean = (columns @ np.where(own, first.state.marginal.mean, 0.0)).ravel()
        truth = model._total_covariance(replace(first, causes=()), columns, first)
        wide = [model._total_covariance(fit, columns, fit) for fit in (first, second)]
        return max(expected_log_ratio(mean, truth, *wide), 0.0)

    def _climb(
        self,
        causes: Causes,
        hypers: tuple[Hyper, ...],
        starts: list[Array],
        guess: Array,
        linear: tuple[Array, Array],
        rows: Rows,
        *,
        integrate: bool,
    ) -> Laplace:
        centre = np.array([hyper.centre for hyper in hypers])
        spread = np.array([hyper.spread for hyper in hypers])

        def log_posterior(at: Array) -> float:
            scaled = (at - centre) / spread
            prior = -0.5 * float(scaled @ scaled) - float(np.log(spread).sum()) - 0.5 * len(at) * LOG_2PI
            return prior + self.marginal(causes, at, linear, rows).log_density

        return laplace(log_posterior, starts, guess, integrate=integrate)

    def _described(self, causes: Causes, state: TransitState) -> Fit:
        chosen = [i for i, coordinate in enumerate(self.coordinates) if coordinate.effect in causes]
        marginal = state.marginal
        found = estimates(
            [self.coordinates[i] for i in chosen], marginal.mean[chosen], marginal.covariance[np.ix_(chosen, chosen)]
        )
        found += _hyper_estimates(state)
        calibration = {
            f"{h.name}_{'m' if h.name == 'fix_sd' else 'm_s'}": math.exp(value)
            for h, value in zip(state.hypers, state.posterior.mode, strict=True)
            if not h.effect
        }
        return Fit(causes, state.posterior.log_evidence, found, calibration, is_possible(found), state)


def _starts(hypers: tuple[Hyper, ...], near: Sequence[Fit]) -> tuple[list[Array], Array]:
    """Where to climb from, and a guess of the posterior covariance.

    The parts' fits where there are any, else the priors' centres; a new hyperparameter also a spread up and down.
    """
    known: dict[tuple[str, str], tuple[float, float]] = {}
    for fit in near:
        modes, variances = fit.state.posterior.mode, np.diag(fit.state.posterior.covariance)
        for hyper, mode, variance in zip(fit.state.hypers, modes, variances, strict=True):
            known.setdefault((hyper.effect, hyper.name), (float(mode), float(variance)))
    guesses = [known.get((h.effect, h.name), (h.centre, min(0.1, h.spread**2))) for h in hypers]
    first = np.array([guess[0] for guess in guesses])
    starts = [first]
    for index, hyper in enumerate(hypers):
        if hyper.effect and (hyper.effect, hyper.name) not in known:
            for shift in (-1.0, 1.0):
                moved = first.copy()
                moved[index] += shift * hyper.spread
                starts.append(moved)
    return starts, np.diag([guess[1] for guess in guesses])


def _hyper_estimates(state: TransitState) -> tuple[Estimate, ...]:
    chosen = [i for i, hyper in enumerate(state.hypers) if hyper.effect]
    shapes = [Coordinate(h.effect, h.name, "shape", h.centre, h.spread, 0.0) for h in (state.hypers[i] for i in chosen)]
    return estimates(shapes, state.posterior.mode[chosen], state.posterior.covariance[np.ix_(chosen, chosen)])
