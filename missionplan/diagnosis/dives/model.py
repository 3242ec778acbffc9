"""Model of dive logs: fits of causes, linearised where each set fits best; what they leave, what they predict."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np
from scipy.linalg import solve_triangular
from scipy.special import logsumexp
from scipy.stats import norm

from missionplan.arrays import Array
from missionplan.diagnosis.coordinates import estimates, has_shape, is_possible
from missionplan.diagnosis.dives import designs as dive_designs
from missionplan.diagnosis.dives.axes import descent_axes
from missionplan.diagnosis.dives.evidence import Evidence
from missionplan.diagnosis.dives.forward import parameter_range
from missionplan.diagnosis.dives.gauss_newton import Ended, Lane, climb
from missionplan.diagnosis.dives.linearised import DiveLinearisation, LinearisedDescent
from missionplan.diagnosis.dives.noise import NOMINAL_NOISE, noise_grid
from missionplan.diagnosis.dives.starts import SHAPE_SHIFTS, starts
from missionplan.diagnosis.inference.axes import Axis
from missionplan.diagnosis.inference.importance_sampling import DRAWS, SampledEvidence, sampled_evidence
from missionplan.diagnosis.inference.marginal_likelihood import LOG_2PI, Marginal
from missionplan.diagnosis.inference.model import CauseFit, FailedFit, FitRequest, HeldOutScore
from missionplan.diagnosis.inference.residuals import Residuals
from missionplan.effects import CATALOGUE
from missionplan.results.diagnosis import Causes, ParameterEstimate

RELINEARISE_BEYOND = 0.5
"""Posterior standard deviations between the place of a linearisation and the posterior's mean that are too many."""
RELINEARISATIONS, RELINEARISE_WITHIN = 2, 15.0
"""Rounds in which fits may be moved there, if their evidence is so near the best of those fitted together [nats]."""
SHORTER = 0.25
"""Share of a step that is tried after one that was too long."""
REFIT_ITERATIONS = 2
"""Gauss–Newton steps of a refit without one dive, from the fit with it."""


@dataclass(frozen=True)
class DescentState:
    """A fitted set: its linearisation, the likelihood there, the grid's best noise and the coordinates' posterior."""

    linear: DiveLinearisation
    evidence: Evidence
    best: int
    marginal: Marginal


@dataclass(frozen=True)
class DescentModel(LinearisedDescent):
    """Base model of a mission's descent and every cause of the catalogue, fitted to dive logs."""

    alternatives: Sequence[frozenset[str]] = ()

    @cached_property
    def _nominal(self) -> Array:
        """Covariance for the climb, the same for all sets so that their objectives compare, shape (N, N) [m²]."""
        return self.total_covariance(self.base, NOMINAL_NOISE, self.prior_sd(()))

    def fit_all(self, wanted: Sequence[FitRequest]) -> list[CauseFit | FailedFit]:
        """Fit several sets at once: climb from all their starts together, linearise, integrate."""
        lanes = [
            (index, Lane(self.free(causes), start, index))
            for index, (causes, near) in enumerate(wanted)
            for start in starts(self.coordinates, causes, near)
        ]
        climbed = [lane for _, lane in lanes if len(lane.free)]
        nominal = self._nominal
        ended = iter(climb(self.forward.coarse, self.coordinates, self.y, nominal, climbed) if climbed else [])
        best: dict[int, Ended] = {}
        for index, lane in lanes:
            end = next(ended) if len(lane.free) else Ended(lane.start, 0.0)
            if index not in best or end.objective < best[index].objective:
                best[index] = end
        places = [(causes, best[index].at) for index, (causes, _) in enumerate(wanted)]
        linears = self.linearise(places) if any(causes for causes, _ in places) else [self.base] * len(places)
        return [self._integrated(causes, linear) for (causes, _), linear in zip(places, linears, strict=True)]

    def relinearised(self, fits: Sequence[CauseFit | FailedFit], best: float) -> list[CauseFit | FailedFit]:
        """Fits linearised anew where the posterior lies off the place that the climb, at nominal noise, ended at.

        A step towards the posterior's mean is taken if the joint density there is greater; if not, a shorter one.
        """
        found = list(fits)
        shares = {
            i: 1.0
            for i, fit in enumerate(fits)
            if isinstance(fit, CauseFit) and fit.log_evidence > best - RELINEARISE_WITHIN
        }
        for _ in range(RELINEARISATIONS):
            moving = {i: fit for i, fit in enumerate(found) if i in shares and isinstance(fit, CauseFit)}
            places = {i: at for i, fit in moving.items() if (at := self._off(fit, shares[i])) is not None}
            linears = self.linearise([(moving[i].causes, at) for i, at in places.items()]) if places else []
            for i, linear in zip(places, linears, strict=True):
                other = self._integrated(moving[i].causes, linear)
                if isinstance(other, CauseFit) and self._log_joint(other) > self._log_joint(moving[i]):
                    found[i] = other
                else:
                    shares[i] *= SHORTER
        return found

    def _off(self, fit: CauseFit, share: float) -> Array | None:
        """Where else to linearise a fit, a share of the way to its posterior's mean; None if that is near enough."""
        free, state = self.free(fit.causes), fit.state
        move = np.zeros(len(self.coordinates))
        move[free] = state.marginal.mean[free] + self.centre[free] - state.linear.at[free]
        sd = np.sqrt(np.diag(state.marginal.covariance)[free])
        at = state.linear.at + share * move
        if np.any(np.abs(move[free]) > RELINEARISE_BEYOND * sd) and all(self._inside(i, at[i]) for i in free):
            return np.asarray(at)
        return None

    def _log_joint(self, fit: CauseFit) -> float:
        """Ln p(readings, causes' coordinates) where a fit is linearised, at its noise."""
        free, linear = self.free(fit.causes), fit.state.linear
        at, narrow = linear.at[free] - self.centre[free], self.prior_sd(fit.causes)
        slab = narrow[free]
        narrow[free] = 0.0
        factor = _factor(self.total_covariance(linear, noise_grid()[fit.state.best], narrow))
        prior = np.asarray(norm.logpdf(at, 0.0, slab))
        return float(_log_normal((linear.y - linear.columns[:, free] @ at)[:, None], factor)[0] + prior.sum())

    def _integrated(self, causes: Causes, linear: DiveLinearisation) -> CauseFit | FailedFit:
        if not np.all(np.isfinite(linear.y)) or not np.all(np.isfinite(linear.columns)):
            return FailedFit(causes, "the descent does not go down with these parameters")
        try:
            evidence = self.evidence(linear)
            found = evidence.marginals(self.prior_sd(causes))
        except np.linalg.LinAlgError as error:
            return FailedFit(causes, str(error))
        logs = _weighted(found)
        best = int(np.argmax(logs))
        free = self.free(causes)
        mean = self.centre[free] + found[best].mean[free]
        parameters = estimates([self.coordinates[i] for i in free], mean, found[best].covariance[np.ix_(free, free)])
        noise = noise_grid()[best]
        calibration = {
            "dive_scatter": noise.scatter,
            "depth_walk_m2_s": noise.diffusion,
            "eddy_time_s": noise.eddy_time,
        }
        state = DescentState(linear, evidence, best, found[best])
        possible = (
            is_possible(parameters)
            and all(_is_told_from_zero(estimate) for estimate in parameters)
            and all(self._inside(i, linear.at[i]) for i in free)
        )
        return CauseFit(causes, float(logsumexp(logs)), parameters, calibration, possible, state)

    def _inside(self, index: int, at: float) -> bool:
        """Whether a coordinate ended inside what the phase was asked: at a limit the linearisation means nothing."""
        coordinate = self.coordinates[index]
        low, high = parameter_range(coordinate)
        return low < (float(np.exp(at)) if coordinate.kind == "shape" else at) < high

    def may_be_multimodal(self, causes: Causes) -> bool:
        """Whether a cause has a shape of its own."""
        return has_shape(causes)

    def estimated_gain(self, causes: Causes, parent: CauseFit) -> float:
        """What further causes add to a parent's log density in its linearisation, at the best of a few shapes."""
        wider, narrow = self.prior_sd(causes), self.prior_sd(parent.causes)
        evidences = [parent.state.evidence] if parent.causes else self._shapes
        best = parent.state.best
        return float(max(e.marginal(best, wider).log_density - e.marginal(best, narrow).log_density for e in evidences))

    @cached_property
    def _shapes(self) -> list[Evidence]:
        """The base model's, the shape that each effect has first where fits start from it."""
        first = np.zeros(len(self.coordinates))
        for name in self.candidates:
            shapes = [i for i in self.free((name,)) if self.coordinates[i].kind == "shape"]
            first[shapes[:1]] = 1.0
        slab = np.array([coordinate.slab for coordinate in self.coordinates])
        places = [((), self.centre + shift * first * slab) for shift in SHAPE_SHIFTS]
        return [self.evidence(linear) for linear in self.linearise(places)]

    def sampled_evidence(self, fit: CauseFit) -> SampledEvidence:
        """Integrate over the causes by the phase itself; narrow priors, noise and the dives' scatter as in the fit."""
        free, state, linear = self.free(fit.causes), fit.state, fit.state.linear
        if not len(free):
            return SampledEvidence(fit.log_evidence, float(DRAWS))
        slab, narrow = self.prior_sd(fit.causes)[free], self.prior_sd(fit.causes)
        narrow[free] = 0.0
        factors = [_factor(self.total_covariance(linear, noise, narrow)) for noise in noise_grid()]

        def log_joint(at: Array) -> Array:
            settings = np.repeat(self.centre[:, None], len(at), axis=1)
            settings[free] = at.T
            readings = self.forward.readings(self.coordinates, settings, delays=linear.release_delays)
            left = self.y[:, None] - readings + self.release_delay_shift(linear)[:, None]
            logs = [
                noise.log_prior + _log_normal(left, factor) for noise, factor in zip(noise_grid(), factors, strict=True)
            ]
            prior = np.asarray(norm.logpdf(at, self.centre[free], slab))
            return np.asarray(logsumexp(logs, axis=0) + prior.sum(axis=1))

        return sampled_evidence(
            log_joint, self.centre[free] + state.marginal.mean[free], state.marginal.covariance[np.ix_(free, free)]
        )

    def residuals(self, fit: CauseFit) -> Residuals:
        """Readings less the model at the priors' centres of the linearisation, and their covariance."""
        state = fit.state
        logs = self.forward.logs
        return Residuals(
            state.linear.y,
            self.total_covariance(state.linear, noise_grid()[state.best], self.prior_sd(fit.causes)),
            np.concatenate([np.full(len(log.t), k) for k, log in enumerate(logs)]),
            self.axes(state.linear),
            np.concatenate([np.full(len(log.t), log.name) for log in logs]),
            quantised=True,
            averaged=partial(self.products, state.linear, self.prior_sd(fit.causes)),
        )

    def axes(self, linear: DiveLinearisation) -> Sequence[Axis]:
        """Axes along which a remainder is sought."""
        return descent_axes(self, linear)

    def innovations(self, fit: CauseFit) -> Array:
        """One-step-ahead errors of the readings over their standard deviations, dive after dive, shape (N,)."""
        linear = fit.state.linear
        factor = _factor(self.total_covariance(linear, noise_grid()[fit.state.best], self.prior_sd(fit.causes)))
        return np.asarray(solve_triangular(factor, linear.y, lower=True, check_finite=False))

    def held_out(self, fits: Sequence[CauseFit]) -> list[list[HeldOutScore]]:
        """Predict each dive from the others under several fits: causes and noise fitted to the others alone."""
        others = [np.setdiff1d(np.arange(len(self.y)), rows) for rows in self.parts]
        folds = [(fit, dive) for fit in fits for dive in range(len(self.parts))]
        lanes = [
            Lane(self.free(fit.causes), fit.state.linear.at, family, others[dive])
            for family, (fit, dive) in enumerate(folds)
        ]
        ended = climb(self.forward.coarse, self.coordinates, self.y, self._nominal, lanes, steps=REFIT_ITERATIONS)
        linears = self.linearise([(fit.causes, end.at) for (fit, _), end in zip(folds, ended, strict=True)])
        scores = [self._score(fit, linear, dive) for (fit, dive), linear in zip(folds, linears, strict=True)]
        return [scores[k * len(others) : (k + 1) * len(others)] for k in range(len(fits))]

    def _score(self, fit: CauseFit, linear: DiveLinearisation, dive: int) -> HeldOutScore:
        """Predict one dive: its log score over all noises, weighed by the other dives; its errors at their best one."""
        prior, evidence = self.prior_sd(fit.causes), self.evidence(linear)
        others = np.delete(np.arange(len(self.parts)), dive)
        seen = _weighted(evidence.marginals(prior, others))
        log_score = float(logsumexp(_weighted(evidence.marginals(prior))) - logsumexp(seen))
        total = self.total_covariance(linear, noise_grid()[int(np.argmax(seen))], prior)
        own, rest = self.parts[dive], np.concatenate([self.parts[k] for k in others])
        weights = np.linalg.solve(total[np.ix_(rest, rest)], total[np.ix_(rest, own)]).T
        error = linear.y[own] - weights @ linear.y[rest]
        scaled = error / self.units[own]
        variance = np.diag(total[np.ix_(own, own)] - weights @ total[np.ix_(rest, own)])
        inside = int((np.abs(error) <= norm.ppf(0.95) * np.sqrt(variance)).sum())
        return HeldOutScore(self.forward.logs[dive].name, log_score, float(scaled @ scaled), inside, len(error))

    @property
    def units(self) -> Array:
        """What errors of the readings are counted in, shape (N,): metres."""
        return np.ones(len(self.y))

    @property
    def designs(self) -> Sequence[str]:
        """Further dives, in words, cheapest first."""
        return [what for what, *_ in dive_designs.DESIGNS]

    def discrimination(self, first: CauseFit, second: CauseFit, entry: int | None) -> float:
        """Fit both sets to noise-free readings of the first, with the dives of a menu entry or without."""
        logs = self.forward.logs + (dive_designs.design_dives(self.forward, entry) if entry is not None else ())
        forward = replace(self.forward.coarse, logs=logs)
        readings = forward.readings(self.coordinates, first.state.linear.at[:, None])[:, 0]
        return DescentModel(replace(forward, logs=dive_designs.with_depths(logs, readings))).expected_log_bayes_factor(
            first, second
        )

    def expected_log_bayes_factor(self, first: CauseFit, second: CauseFit) -> float:
        """Ln Bayes factor of the first set, whose readings these are without noise, over the second, fitted anew."""
        start = second.state.linear.at
        (end,) = climb(
            self.forward.coarse, self.coordinates, self.y, self._nominal, [Lane(self.free(second.causes), start, 0)]
        )
        places = [(first.causes, first.state.linear.at), (second.causes, end.at)]
        fitted = [
            self._integrated(causes, linear) for (causes, _), linear in zip(places, self.linearise(places), strict=True)
        ]
        evidence = [fit.log_evidence if isinstance(fit, CauseFit) else -np.inf for fit in fitted]
        return float(max(evidence[0] - evidence[1], 0.0))


def _is_told_from_zero(estimate: ParameterEstimate) -> bool:
    """Whether a strength's interval leaves out zero: evidence for what may be nil is its linearisation's error."""
    is_shape = CATALOGUE[estimate.effect].parameters[estimate.name].is_shape
    return is_shape or not estimate.low <= 0.0 <= estimate.high


def _weighted(marginals: Sequence[Marginal]) -> Array:
    """Log density at each noise of the grid with the noise's prior."""
    return np.array([noise.log_prior + found.log_density for noise, found in zip(noise_grid(), marginals, strict=True)])


def _factor(covariance: Array) -> Array:
    return np.asarray(np.linalg.cholesky(covariance), dtype=float)


def _log_normal(left: Array, factor: Array) -> Array:
    """Ln N(left; 0, L Lᵀ) of each column of left, shape (N, s) → (s,)."""
    white = solve_triangular(factor, left, lower=True, check_finite=False)
    return np.asarray(-0.5 * np.sum(white**2, axis=0) - np.log(np.diag(factor)).sum() - 0.5 * len(left) * LOG_2PI)
