"""Fits of sets of causes to dive logs: most likely coordinates at nominal noise, then evidence about them."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp

from missionplan.arrays import Array
from missionplan.diagnosis.coordinates import Coordinate, estimates, is_approximate, is_possible
from missionplan.diagnosis.dives.likelihood import DescentLikelihood, NoiseGridLikelihood
from missionplan.diagnosis.dives.linearised import DIFFERENCE, DiveLinearisation
from missionplan.diagnosis.dives.noise import EDDY_TIMES, FORM_SD, NOMINAL_NOISE, Noise, noise_grid
from missionplan.diagnosis.given import RecordPosterior, held, tied
from missionplan.diagnosis.inference.block_covariance import BlockCovariance
from missionplan.diagnosis.inference.gauss_newton import GaussNewtonOptions, LeastSquares, Start, gauss_newton
from missionplan.diagnosis.inference.marginal_likelihood import Marginal
from missionplan.diagnosis.inference.model import CauseFit, FailedFit, FitRequest
from missionplan.diagnosis.inference.prior import integrated
from missionplan.effects import CATALOGUE
from missionplan.phases.hooks import DescentEffect
from missionplan.results.learned.evidence import Causes

INITIAL_STRENGTH = 0.5
"""Strength at a fresh start of an effect of approximate form, in prior standard deviations."""
SHAPE_SHIFTS = (-1.2, 0.0, 1.2)
"""Its first shape parameter there, in prior standard deviations about its prior mean."""
LATE_STARTS = (-8.0, -4.0, 4.0, 8.0)
"""Further starts of an effect that delays the dive or its readings, in prior standard deviations: to a search from no
delay a vehicle that starts seconds late looks like one that sinks slowly."""


def starting_points(
    coordinates: Sequence[Coordinate], expected: Array, effects: Sequence[str], causes: Causes, near: Sequence[CauseFit]
) -> list[Array]:
    """Points from which to search for the best coordinates of a set.

    Causes start where fits of other sets have them. A cause that was fitted only alone also starts afresh: beside
    other causes its best coordinates may be far from there. So does an effect of the mission that may have changed,
    besides the start where the mission has it.

    `coordinates`: of all causes, k. `expected`, (k,): as the mission expects them. `effects`: its own effects. `near`:
    fits of parts of the set, the one that it extends, then causes alone.
    """
    start, fitted = _from_fits(coordinates, expected, effects, causes, near)
    fresh = [name for name in causes if name not in fitted]
    points = _spread_over_shapes(coordinates, fresh, start)
    points += [moved for name in fresh for moved in _late(coordinates, name, start)]
    if {*effects} & {*causes} - fitted and len(points) > 1:
        points.append(start)
    start, extended = _from_fits(coordinates, expected, effects, causes, near[:1])
    if extended != fitted:
        points += _spread_over_shapes(coordinates, [name for name in causes if name not in extended], start)
    return points


def _late(coordinates: Sequence[Coordinate], name: str, start: Array) -> Iterator[Array]:
    """Points about one at which an effect that delays the dive or its readings is strong, inside its physical range."""
    info = CATALOGUE[name]
    delays = getattr(info.effect, "delay", DescentEffect.delay) is not DescentEffect.delay
    for i, coordinate in enumerate(coordinates):
        parameter = info.parameters.get(coordinate.name)
        if (
            coordinate.effect == name
            and coordinate.kind == "strength"
            and parameter
            and (delays or parameter.unit == "s")
        ):
            for shift in LATE_STARTS:
                if parameter.low < shift * coordinate.slab < parameter.high:
                    moved = start.copy()
                    moved[i] = shift * coordinate.slab
                    yield moved


def _from_fits(
    coordinates: Sequence[Coordinate], expected: Array, effects: Sequence[str], causes: Causes, near: Sequence[CauseFit]
) -> tuple[Array, set[str]]:
    """Coordinates of causes from fits, the first that has a cause first; and the causes that were found so."""
    start = expected.copy()
    fitted: set[str] = set()
    possible = [fit for fit in near if fit.possible]  # skip infeasible fits as starting points
    for fit in possible:
        for i, coordinate in enumerate(coordinates):
            if coordinate.effect in fit.causes and coordinate.effect in causes and coordinate.effect not in fitted:
                start[i] = fit.state.linear.at[i]
        fitted |= set(fit.causes)
    if possible:
        places = [
            i
            for i, coordinate in enumerate(coordinates)
            if coordinate.effect in effects and coordinate.effect not in fitted
        ]
        start[places] = possible[0].state.linear.at[places]
    return start, fitted


def _spread_over_shapes(coordinates: Sequence[Coordinate], fresh: Sequence[str], start: Array) -> list[Array]:
    """Points about one, several for each of the fresh effects of approximate form."""
    points = [start]
    for name in fresh:
        places = [i for i, coordinate in enumerate(coordinates) if coordinate.effect == name]
        shapes = [i for i in places if coordinates[i].kind == "shape"]
        if is_approximate(name):
            points = [
                _shifted(coordinates, places, shapes[0], shift, point) for point in points for shift in SHAPE_SHIFTS
            ]
    return points


def _shifted(coordinates: Sequence[Coordinate], places: Sequence[int], shape: int, shift: float, point: Array) -> Array:
    """A point with an effect at its initial strength and one shape parameter shifted."""
    moved = point.copy()
    for i in places:
        if coordinates[i].kind != "shape":
            moved[i] = INITIAL_STRENGTH * coordinates[i].slab
    moved[shape] += shift * coordinates[shape].slab
    return moved


SEARCH = GaussNewtonOptions(iterations=9, tolerance=0.05, difference=DIFFERENCE, longest_step=3.0)
"""The posterior is integrated about where the search ends, so that a fall of 0.05 nats is converged."""
RELINEARISE_BEYOND = 0.5
"""Distance from the linearisation to the posterior's mean that calls for another [posterior standard deviations]."""
RELINEARISATIONS, RELINEARISE_WITHIN = 2, 15.0
"""Further linearisations, of fits whose evidence is so near the best of those fitted together [nats]."""
LEAST_LIKELY = 0.01
"""Probability from which a noise is considered beside a response."""
STEP_REDUCTION = 0.25
"""Factor on the next step of a fit when a linearisation was no improvement."""


@dataclass(frozen=True)
class DescentState:
    """State of a fit."""

    linear: DiveLinearisation
    """The model, linearised about the best coordinates."""
    likelihood: NoiseGridLikelihood
    """Its likelihood, all dives as one."""
    best_noise: int
    """Most likely noise of the grid."""
    prior_sd: Array
    """Shape (k,) or (k, k). Prior standard deviations of the coordinates, the slabs at their likeliest scales; see
    `Prior.root`."""
    marginal: Marginal
    """Posterior of the coordinates at that noise."""


@dataclass(frozen=True)
class DescentFitting(DescentLikelihood):
    """The likelihood of dive logs, with fits of sets of causes."""

    @cached_property
    def _nominal_covariance(self) -> BlockCovariance:
        """Covariance for the search, the same for all sets so that their objectives compare [m²]."""
        return self.covariance(self.base, NOMINAL_NOISE, self.nuisance_sd(()))

    def start(self, causes: Causes, at: Array, group: int = 0, rows: NDArray[np.int_] | None = None) -> Start:
        """Start of a search for the best coordinates of a set; those that are not searched are at their prior means."""
        prior, searched = self.prior(causes), self.searched(causes)
        point = prior.centre.copy()
        point[searched] = at[searched]
        return Start(point, searched, group, rows, prior)

    def best_coordinates(self, starts: Sequence[Start], iterations: int = SEARCH.iterations) -> list[Array]:
        """Most likely coordinates at nominal noise for each group of starts, by the phase in coarse steps.

        Parameters
        ----------
        starts : sequence of Start
            Groups numbered in the order of their first starts.
        iterations : int
            Of Gauss–Newton, at most.
        """
        readings = partial(self.forward.coarse.readings, self.coordinates)
        problem = LeastSquares(readings, self.y, self._nominal_covariance, self.centre, self.slab)
        results = gauss_newton(problem, starts, replace(SEARCH, iterations=iterations))
        best: dict[int, tuple[float, Array]] = {}
        for start, result in zip(starts, results, strict=True):
            if start.group not in best or result.objective < best[start.group][0]:
                best[start.group] = result.objective, result.at
        return [at for _, at in best.values()]

    def fit_all(self, wanted: Sequence[FitRequest]) -> list[CauseFit | FailedFit]:
        """Fit several sets at once: search from all their starting points together, linearise, integrate."""
        effects = [prior.effect for prior in self.given]
        starts = [
            self.start(causes, at, group)
            for group, (causes, near) in enumerate(wanted)
            if causes or effects
            for at in starting_points(self.coordinates, self.expected, effects, causes, near)
        ]
        optima = iter(self.best_coordinates(starts)) if starts else iter(())
        points = [(causes, next(optima) if causes or effects else self.expected) for causes, _ in wanted]
        points = [(causes, self._inside(causes, at)) for causes, at in points]
        linears = self.linearise(points) if starts else [self.base] * len(points)
        return [self.integrated(causes, linear) for (causes, _), linear in zip(points, linears, strict=True)]

    def integrated(self, causes: Causes, linear: DiveLinearisation) -> CauseFit | FailedFit:
        """Evidence of a set in a linearisation, and the posterior of its parameters."""
        if not np.all(np.isfinite(linear.y)) or not np.all(np.isfinite(linear.columns)):
            return FailedFit(causes, "the descent does not go down with these parameters")
        try:
            likelihood = self.likelihood(linear).as_one  # of each dive they are too large to keep with every fit
            whole = integrated(likelihood.log_joint, likelihood.marginal, self.prior(causes))
        except np.linalg.LinAlgError as error:
            return FailedFit(causes, str(error))
        free, marginal, mean = self.free(causes), whole.marginal, whole.inside.mean
        reported = self._spread(causes, whole.inside.covariance, mean)
        parameters = estimates([self.coordinates[i] for i in free], mean[free], reported[np.ix_(free, free)])
        priors = tied(held(self.given, causes))
        state = DescentState(linear, likelihood, whole.noise, whole.prior_sd, marginal)
        after = RecordPosterior(self.coordinates, mean, reported).known(priors)
        uncut = linear.centre + marginal.mean  # draws of it are cut, and so must not be of what is cut already
        record = RecordPosterior(self.coordinates, uncut, self._spread(causes, marginal.covariance, uncut))
        together, noise = record.afterwards(priors, free.tolist()), _calibration(whole.noise)
        return CauseFit(causes, whole.log_evidence, parameters, noise, is_possible(parameters), state, after, together)

    def _spread(self, causes: Causes, covariance: Array, mean: Array) -> Array:
        """Covariance of the coordinates as they are reported, shape (k, k).

        The posterior is of strengths that act just as the catalogue has them. A form that no law gives has the same
        error in every dive, in proportion to the effect, which more dives do not make less: an error of the model and
        not of the data (Kennedy & O'Hagan 2001). It leaves the evidence, which is that of the form as it is.
        """
        is_by_law = [c.kind == "shape" or CATALOGUE[c.effect].follows_law for c in self.coordinates]
        of_form = [i for i in self.free(causes) if not is_by_law[i]]
        reported = covariance.copy()
        reported[of_form, of_form] += np.square(FORM_SD * mean[of_form])
        return reported

    def _inside(self, causes: Causes, at: Array) -> Array:
        """Coordinates inside the causes' physical ranges, where the phase follows them; without a strength no shape."""
        prior, point = self.prior(causes), at.copy()
        free = self.free(causes)
        low, high = (end[free] for end in prior.bounds)
        point[free] = np.clip(at[free], low, high - 2.0 * DIFFERENCE * self.slab[free])
        for i in free:
            if self.coordinates[i].kind == "strength" and point[i] == 0.0:
                shapes = [j for j in self.free((self.coordinates[i].effect,)) if self.coordinates[j].kind == "shape"]
                point[shapes] = prior.centre[shapes]
        return point

    def relinearised(self, fits: Sequence[CauseFit | FailedFit], best: float) -> list[CauseFit | FailedFit]:
        """Fits linearised anew where the posterior's mean lies off the point found at nominal noise.

        Gauss–Newton steps, as in an iterated extended Kalman filter (Bell & Cathey 1993). A step towards the mean is
        taken if the joint density there is greater; if not, a shorter one is tried.
        """
        refits = list(fits)
        lengths = {
            i: 1.0
            for i, fit in enumerate(fits)
            if isinstance(fit, CauseFit) and fit.log_evidence > best - RELINEARISE_WITHIN
        }
        for _ in range(RELINEARISATIONS):
            wanted = [(i, refits[i], length) for i, length in lengths.items()]
            moved = {i: self._towards_mean(fit, length) for i, fit, length in wanted if isinstance(fit, CauseFit)}
            points = {i: at for i, at in moved.items() if at is not None}
            linears = self.linearise([(refits[i].causes, at) for i, at in points.items()]) if points else []
            for i, linear in zip(points, linears, strict=True):
                other = self.integrated(refits[i].causes, linear)
                if self._log_joint(other) > self._log_joint(refits[i]):
                    refits[i] = other
                else:
                    lengths[i] *= STEP_REDUCTION
        return refits

    def _towards_mean(self, fit: CauseFit, length: float) -> Array | None:
        """Coordinates a share of the way to a fit's posterior mean; None if that is near enough or out of range."""
        free, state = self.searched(fit.causes), fit.state
        move = np.zeros(len(self.coordinates))
        move[free] = (state.marginal.mean + state.linear.centre - state.linear.at)[free]
        sd = np.sqrt(np.diag(state.marginal.covariance)[free])
        at = self._inside(fit.causes, state.linear.at + length * move)
        is_off = np.any(np.abs(at - state.linear.at)[free] > RELINEARISE_BEYOND * length * sd)
        return at if is_off else None

    def _log_joint(self, fit: CauseFit | FailedFit) -> float:
        """Ln p(readings, causes' coordinates) where a fit is linearised, at its noise; -inf of a failed one."""
        if isinstance(fit, FailedFit):
            return -np.inf
        free, linear = self.searched(fit.causes), fit.state.linear
        away = (linear.at - linear.centre)[free]
        noise = noise_grid()[fit.state.best_noise]
        residuals = (linear.y - linear.columns[:, free] @ away)[:, None]
        density = self.log_densities(linear, self.nuisance_sd(fit.causes), residuals, (noise,))
        return float(density[0, 0] + self.prior(fit.causes).of(free).log_density(linear.at[free]))


def _calibration(best: int) -> dict[str, float]:
    """Noise of the grid in the keys of a diagnosis."""
    noise = noise_grid()[best]
    return {"dive_scatter": noise.scatter, "depth_walk_m2_s": noise.diffusion, "eddy_time_s": noise.eddy_time}


def likely_noises(state: DescentState) -> tuple[Noise, ...]:
    """Return noises that are likely under a fit, of any scatter: what differs between dives may be a response's."""
    logs = state.likelihood.log_joint(state.prior_sd)
    likely = logs - logsumexp(logs) > np.log(LEAST_LIKELY)
    turbulent = {(n.diffusion, n.eddy_time) for n, kept in zip(noise_grid(), likely, strict=True) if kept}
    turbulent |= {(NOMINAL_NOISE.diffusion, time) for time in EDDY_TIMES}
    return tuple(noise for noise in noise_grid() if (noise.diffusion, noise.eddy_time) in turbulent)
