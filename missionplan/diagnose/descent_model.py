"""Model of dive logs: the descent phase with every cause, linearised where a set of causes fits best."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular
from scipy.special import logsumexp
from scipy.stats import norm

from missionplan.diagnose import descent_menu
from missionplan.diagnose.coordinates import Coordinate, coordinates_of, estimates, is_possible
from missionplan.diagnose.descent_axes import descent_axes
from missionplan.diagnose.descent_fit import Ended, Lane, climb, from_settings, jacobian_settings
from missionplan.diagnose.descent_forward import DescentForward, limits
from missionplan.diagnose.descent_noise import DIVE_SD, NOMINAL, Noise, caricature, dive_covariance, grid
from missionplan.diagnose.likelihood import Marginal, gaussian_marginal
from missionplan.diagnose.model import Causes, Failure, Fit, Score, Wanted
from missionplan.diagnose.residuals import Residuals
from missionplan.effects import CATALOGUE, effects_of

Array = NDArray[np.float64]

TEST_LEVEL = 1e-6
"""Level of the residual tests, all together: strict, for turbulence is no random walk to the letter and a quantised
reading's noise is not white."""
FIRST = 0.5
"""Where strengths start, in prior standard deviations; both signs for those of either sign and a shape."""
SHIFTS = (-1.2, 0.0, 1.2)
"""Where the first shape of an effect starts, in prior standard deviations about its centre."""
WEIGHT_STEP = 0.01
SHIFT = 0.3
"""Shift of the separation at which the readings' bend is taken [s]: 3 standard deviations of its scatter."""
REFITTED = 2
"""Gauss–Newton steps of a refit without one dive, from the fit with it."""


@dataclass(frozen=True)
class Linear:
    """The model linearised at a set's best coordinates.

    Attributes
    ----------
    at : array, shape (k,)
        Coordinates.
    y : array, shape (N,)
        Data less the model there, plus columns times the distance of `at` from the priors' centres.
    columns : array, shape (N, k)
        Of all coordinates; shapes of effects that are no causes have none (zero).
    sensitivities : array, shape (N, 4)
        Of the readings to what differs from dive to dive.
    readings : array, shape (N,)
        The model there [m].
    bend : array, shape (N,)
        What the scatter of the separation does to the readings beyond the linear: large where the line goes taut
        and the vehicle starts with a jerk [m]. Taken at a shift by `SHIFT`, so that it reaches far enough.
    """

    at: Array
    y: Array
    columns: Array
    sensitivities: Array
    readings: Array
    bend: Array


@dataclass(frozen=True)
class DescentState:
    """A fitted set: its linearisation, the best hyperparameters, and the coordinates' posterior."""

    linear: Linear
    noise: Noise
    marginal: Marginal


@dataclass(frozen=True)
class DescentModel:
    """Base model of a mission's descent and every cause of the catalogue, bound to dive logs."""

    forward: DescentForward
    alternatives: Sequence[frozenset[str]] = ()

    @cached_property
    def candidates(self) -> Causes:
        """Effects of the catalogue on a descent."""
        return tuple(info.id for info in effects_of("descent"))

    @property
    def untestable(self) -> Mapping[str, str]:
        """Every effect can show in a dive log."""
        return {}

    @cached_property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """Coordinates of all causes."""
        return tuple(c for info in effects_of("descent") for c in coordinates_of(info))

    @cached_property
    def y(self) -> Array:
        """Readings of all dives, one after the other, shape (N,) [m]."""
        return np.concatenate([log.depth for log in self.forward.logs])

    @cached_property
    def parts(self) -> tuple[NDArray[np.int_], ...]:
        """Rows of each dive."""
        lengths = [len(log.t) for log in self.forward.logs]
        return tuple(np.split(np.arange(sum(lengths)), np.cumsum(lengths)[:-1]))

    @cached_property
    def centre(self) -> Array:
        """Prior means of the coordinates, shape (k,)."""
        return np.array([coordinate.centre for coordinate in self.coordinates])

    def prior_sd(self, causes: Causes) -> Array:
        """Prior standard deviation of each coordinate: slab for a cause, spike otherwise (0 for a shape)."""
        return np.array([c.slab if c.effect in causes else c.spike for c in self.coordinates])

    def free(self, causes: Causes) -> NDArray[np.int_]:
        """Coordinates of the causes."""
        return np.flatnonzero([coordinate.effect in causes for coordinate in self.coordinates])

    @cached_property
    def base(self) -> Linear:
        """The base model, linearised."""
        return self.linearise([((), self.centre)])[0]

    def linearise(self, wanted: Sequence[tuple[Causes, Array]]) -> list[Linear]:
        """Linearise the phase for several sets in one call: all strengths, the causes' shapes, the dives' scatter."""
        settings, factors, plans = [], [], []
        for causes, at in wanted:
            chosen = [i for i, c in enumerate(self.coordinates) if c.kind != "shape" or c.effect in causes]
            ahead, steps = jacobian_settings(self.coordinates, at, np.array(chosen))
            shifted = np.repeat(at[:, None], 2, axis=1)
            shifted[self._clock] += np.array([SHIFT, -SHIFT])
            settings += [at[:, None], np.repeat(at[:, None], 2, axis=1), shifted, ahead]
            factors += [np.ones(1), 1.0 + WEIGHT_STEP * np.array([1.0, -1.0]), np.ones(2 + ahead.shape[1])]
            plans.append((chosen, steps))
        readings = self.forward.readings(self.coordinates, np.concatenate(settings, axis=1), np.concatenate(factors))
        found, column = [], 0
        for (causes, at), (chosen, steps) in zip(wanted, plans, strict=True):
            here = readings[:, column]
            weight = (readings[:, column + 1] - readings[:, column + 2]) / (2.0 * WEIGHT_STEP)
            columns = np.zeros((len(self.y), len(self.coordinates)))
            columns[:, chosen] = from_settings(readings[:, column + 5 : column + 5 + 2 * len(chosen)], steps)
            both = readings[:, column + 3] + readings[:, column + 4] - 2.0 * here
            bend = 0.5 * np.abs(both) * DIVE_SD["release"] / SHIFT
            column += 5 + 2 * len(chosen)
            found.append(self._linear(causes, at, here, columns, weight, bend))
        return found

    @cached_property
    def _clock(self) -> int:
        return [coordinate.effect for coordinate in self.coordinates].index("clock-offset")

    def _linear(self, causes: Causes, at: Array, here: Array, columns: Array, weight: Array, bend: Array) -> Linear:
        free = self.free(causes)
        y = self.y - here + columns[:, free] @ (at - self.centre)[free]
        names = [coordinate.effect for coordinate in self.coordinates]
        release, drag = columns[:, self._clock], columns[:, names.index("drag-bias")]
        return Linear(at, y, columns, np.stack([release, np.ones_like(release), drag, weight], axis=1), here, bend)

    def blocks(self, causes: Causes, linear: Linear, noise: Noise) -> list[Array]:
        """Covariance of each dive's readings beside the catalogue's coordinates.

        A cause with a shape of its own is a caricature of what it names: what it adds to the readings is uncertain
        by a smooth factor, `SHAPE_SD`.
        """
        shaped = any(CATALOGUE[name].parameters[key].is_shape for name in causes for key in CATALOGUE[name].parameters)
        added = linear.readings - self.base.readings if shaped else np.zeros(len(linear.readings))
        return [
            dive_covariance(log.t, log.sd, linear.sensitivities[rows], linear.bend[rows], noise)
            + caricature(log.t, added[rows])
            for log, rows in zip(self.forward.logs, self.parts, strict=True)
        ]

    def total_covariance(self, causes: Causes, linear: Linear, noise: Noise) -> Array:
        """Covariance of all readings with the coordinates' priors, shape (N, N) [m²]."""
        scaled = np.concatenate([linear.columns * self.prior_sd(causes), noise.scatter * linear.bend[:, None]], axis=1)
        total = scaled @ scaled.T
        for rows, block in zip(self.parts, self.blocks(causes, linear, noise), strict=True):
            total[np.ix_(rows, rows)] += block
        return np.asarray(total)

    def fit_all(self, wanted: Sequence[Wanted]) -> list[Fit | Failure]:
        """Fit several sets at once: climb from all their starts together, linearise, integrate."""
        lanes = [
            (index, lane) for index, (causes, near) in enumerate(wanted) for lane in self._lanes(causes, near, index)
        ]
        climbed = [lane for _, lane in lanes if len(lane.free)]
        nominal = self.total_covariance((), self.base, NOMINAL)
        ended = iter(climb(self.forward, self.coordinates, self.y, nominal, climbed) if climbed else [])
        best: dict[int, Ended] = {}
        for index, lane in lanes:
            end = next(ended) if len(lane.free) else Ended(lane.start, 0.0)
            if index not in best or end.objective < best[index].objective:
                best[index] = end
        places = [(causes, best[index].at) for index, (causes, _) in enumerate(wanted)]
        linears = self.linearise(places) if any(causes for causes, _ in places) else [self.base] * len(places)
        return [self._integrated(causes, linear) for (causes, _), linear in zip(places, linears, strict=True)]

    def fit(self, causes: Causes, near: Sequence[Fit] = ()) -> Fit:
        """Fit one set.

        Raises
        ------
        numpy.linalg.LinAlgError
            When it cannot be fitted.
        """
        found = self.fit_all([(causes, near)])[0]
        if isinstance(found, Failure):
            raise np.linalg.LinAlgError(found.reason)
        return found

    def _lanes(self, causes: Causes, near: Sequence[Fit], family: int) -> list[Lane]:
        free = self.free(causes)
        start = self.centre.copy()
        known: set[str] = set()
        for fit in near:
            for i in self.free(fit.causes):
                if self.coordinates[i].effect in causes and self.coordinates[i].effect not in known:
                    start[i] = fit.state.linear.at[i]
            known |= set(fit.causes)
        starts = [start]
        for name in causes:
            if name not in known:
                starts = [moved for begin in starts for moved in self._starts(name, begin)]
        return [Lane(free, begin, family) for begin in starts]

    def _starts(self, name: str, begin: Array) -> list[Array]:
        """Several starts for an effect with a shape, one for the others."""
        own = [i for i, c in enumerate(self.coordinates) if c.effect == name]
        strengths = [i for i in own if self.coordinates[i].kind != "shape"]
        shapes = [i for i in own if self.coordinates[i].kind == "shape"]
        if not shapes:
            return [begin]
        starts = []
        for shift in SHIFTS:
            moved = begin.copy()
            moved[strengths] = FIRST * np.array([self.coordinates[i].slab for i in strengths])
            moved[shapes[0]] += shift * self.coordinates[shapes[0]].slab
            starts.append(moved)
        return starts

    def _integrated(self, causes: Causes, linear: Linear) -> Fit | Failure:
        if not np.all(np.isfinite(linear.y)) or not np.all(np.isfinite(linear.columns)):
            return Failure(causes, "the descent does not go down with these parameters")
        found = []
        for noise in grid():
            try:
                found.append((noise, self._marginal(causes, linear, noise)))
            except np.linalg.LinAlgError as error:
                return Failure(causes, str(error))
        logs = np.array([noise.log_prior + marginal.log_density for noise, marginal in found])
        noise, marginal = found[int(np.argmax(logs))]
        free = self.free(causes)
        mean = self.centre[free] + marginal.mean[free]
        parameters = estimates([self.coordinates[i] for i in free], mean, marginal.covariance[np.ix_(free, free)])
        calibration = {"dive_scatter": noise.scatter, "depth_walk_m2_s": noise.walk}
        state = DescentState(linear, noise, marginal)
        possible = is_possible(parameters) and all(self._inside(i, linear.at[i]) for i in free)
        return Fit(causes, float(logsumexp(logs)), parameters, calibration, possible, state)

    def _inside(self, index: int, at: float) -> bool:
        """Whether a coordinate ended inside what the phase was asked: at a limit the linearisation means nothing."""
        coordinate = self.coordinates[index]
        low, high = limits(coordinate)
        return low < (float(np.exp(at)) if coordinate.kind == "shape" else at) < high

    def _marginal(self, causes: Causes, linear: Linear, noise: Noise) -> Marginal:
        """Marginalise all coordinates about a linearisation; dives are independent given them.

        The scatter of the separation smooths the jerk of every dive to the same side: a column that they share.
        """
        prior = np.append(self.prior_sd(causes), noise.scatter)
        whitened = []
        log_determinant = 0.0
        for rows, block in zip(self.parts, self.blocks(causes, linear, noise), strict=True):
            factor = np.linalg.cholesky(block)
            columns = [linear.columns[rows], linear.bend[rows, None], linear.y[rows, None]]
            both = np.concatenate(columns, axis=1)
            whitened.append(solve_triangular(factor, both, lower=True, check_finite=False))
            log_determinant += 2.0 * float(np.log(np.diag(factor)).sum())
        white = np.concatenate(whitened)
        unit = np.ones((1, len(white)))
        result = gaussian_marginal(white[None, :, -1], white[None, :, :-1], prior, unit)
        return Marginal(result.log_density - 0.5 * log_determinant, result.mean[:-1], result.covariance[:-1, :-1])

    def promise(self, causes: Causes, parent: Fit) -> float:
        """What further causes add to a parent's log density in its linearisation, shapes at their centres."""
        state = parent.state
        wider, narrow = (self._marginal(names, state.linear, state.noise) for names in (causes, parent.causes))
        return wider.log_density - narrow.log_density

    def residuals(self, fit: Fit) -> Residuals:
        """Readings less the model at the priors' centres of the linearisation, and their covariance."""
        state = fit.state
        logs = self.forward.logs
        return Residuals(
            state.linear.y,
            self.total_covariance(fit.causes, state.linear, state.noise),
            np.concatenate([np.full(len(log.t), k) for k, log in enumerate(logs)]),
            descent_axes(logs, state.linear.readings),
            np.concatenate([np.full(len(log.t), log.name) for log in logs]),
            TEST_LEVEL,
        )

    def held_out(self, fits: Sequence[Fit]) -> list[list[Score]]:
        """Predict each dive from the others under several fits, the causes fitted to the others alone."""
        others = [np.setdiff1d(np.arange(len(self.y)), rows) for rows in self.parts]
        folds = [(fit, seen) for fit in fits for seen in others]
        lanes = [
            Lane(self.free(fit.causes), fit.state.linear.at, family, seen) for family, (fit, seen) in enumerate(folds)
        ]
        nominal = self.total_covariance((), self.base, NOMINAL)
        ended = climb(self.forward, self.coordinates, self.y, nominal, lanes, steps=REFITTED)
        linears = self.linearise([(fit.causes, end.at) for (fit, _), end in zip(folds, ended, strict=True)])
        scores = []
        for k, fit in enumerate(fits):
            own = linears[k * len(others) : (k + 1) * len(others)]
            logs = self.forward.logs
            scores.append(
                [
                    self._score(log.name, fit, linear, seen, rows)
                    for log, linear, seen, rows in zip(logs, own, others, self.parts, strict=True)
                ]
            )
        return scores

    def _score(self, name: str, fit: Fit, linear: Linear, seen: NDArray[np.int_], rows: NDArray[np.int_]) -> Score:
        total = self.total_covariance(fit.causes, linear, fit.state.noise)
        weights = np.linalg.solve(total[np.ix_(seen, seen)], total[np.ix_(seen, rows)]).T
        error = linear.y[rows] - weights @ linear.y[seen]
        covariance = total[np.ix_(rows, rows)] - weights @ total[np.ix_(seen, rows)]
        factor = np.linalg.cholesky(covariance)
        white = np.linalg.solve(factor, error)
        log_score = -0.5 * float(white @ white) - float(np.log(np.diag(factor)).sum()) - 0.919 * len(error)
        inside = int((np.abs(error) <= norm.ppf(0.95) * np.sqrt(np.diag(covariance))).sum())
        return Score(name, log_score, float(error @ error), inside, len(error))

    @property
    def menu(self) -> Sequence[str]:
        """Further dives, in words, cheapest first."""
        return [what for what, *_ in descent_menu.MENU]

    def separation(self, first: Fit, second: Fit, entry: int | None) -> float:
        """Fit both sets to noise-free readings of the first, with the dives of a menu entry or without."""
        logs = self.forward.logs + (descent_menu.planned(self.forward, entry) if entry is not None else ())
        forward = replace(self.forward, logs=logs)
        readings = forward.readings(self.coordinates, first.state.linear.at[:, None])[:, 0]
        model = DescentModel(replace(forward, logs=descent_menu.filled(logs, readings)))
        fitted = model.fit_all([(first.causes, (first,)), (second.causes, (second,))])
        evidence = [fit.log_evidence if isinstance(fit, Fit) else -np.inf for fit in fitted]
        return float(max(evidence[0] - evidence[1], 0.0))
