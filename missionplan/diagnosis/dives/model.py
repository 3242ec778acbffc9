"""Model of dive logs: fits of sets of causes, what they leave, and how well they predict dives held out or to come."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from scipy.ndimage import median_filter
from scipy.special import logsumexp

from missionplan.arrays import Array
from missionplan.datasets.records import DescentData
from missionplan.diagnosis.dives import designs as dive_designs
from missionplan.diagnosis.dives.consistency import EXCHANGED, ExchangedLabels, exchanged_labels
from missionplan.diagnosis.dives.discrepancy_axes import descent_axes, drag_of_each_dive
from missionplan.diagnosis.dives.fitting import DescentFitting, likely_noises
from missionplan.diagnosis.dives.forward import DescentForward
from missionplan.diagnosis.dives.linearised import DiveLinearisation
from missionplan.diagnosis.dives.noise import Noise, noise_grid
from missionplan.diagnosis.dives.preparation import PreparedDives
from missionplan.diagnosis.dives.supersets import log_gains
from missionplan.diagnosis.given import GivenEffect
from missionplan.diagnosis.given.priors import check_together, given_effects, given_priors
from missionplan.diagnosis.inference.axes import Axis
from missionplan.diagnosis.inference.block_covariance import BlockCovariance
from missionplan.diagnosis.inference.discrepancy import Residuals, Responses
from missionplan.diagnosis.inference.evidence_approximations import DRAWS, SampledEvidence, sampled_evidence
from missionplan.diagnosis.inference.marginal_likelihood import QUANTILE_95
from missionplan.diagnosis.inference.model import CauseFit, HeldOutScore
from missionplan.diagnosis.inference.prior import inside_range
from missionplan.diagnosis.inference.weighing import LinearisedModel, NeutralResponses
from missionplan.effects import effects_of
from missionplan.errors import InputError, Problem
from missionplan.mission import Mission
from missionplan.mission.views import MooringMission
from missionplan.phases.hooks import DescentEffect
from missionplan.phases.mooring.descent import descent_stages
from missionplan.phases.mooring.forces import DescentHooks, Dive
from missionplan.results.learned.evidence import Causes
from missionplan.scenario.phases import dive_of
from missionplan.scenario.scenario import Scenario

MOST_REFITTED = 8
"""Dives up to which the causes are searched anew without each."""
REFIT_ITERATIONS = 2
"""Gauss–Newton steps of a fit without one dive, from the fit with it."""


@dataclass(frozen=True)
class DescentModel(DescentFitting, LinearisedModel):
    """Base model of a mission's descent and every cause of the catalogue, bound to dive logs."""

    alternatives: Sequence[frozenset[str]] = ()
    """Groups of effects of which a set holds at most one."""

    def log_gains(self, fits: Sequence[CauseFit], supersets: Sequence[Sequence[Causes]]) -> list[Array]:
        """Return what further causes add to the log evidence of fits, for the supersets of each."""
        return log_gains(self, fits, supersets)

    def responses_beside(self, fits: Sequence[CauseFit]) -> NeutralResponses:
        """Return neutral responses by the axes of the first fit, and their gains beside every fit.

        Labels may be exchanged beside nothing.
        """
        responses = self.responses(fits[0])
        states = [fit.state for fit in fits]
        products = (self.products(s.linear, s.prior_sd, responses.joined, likely_noises(s)) for s in states)
        gains = np.array([responses.log_gains(list(by_noise)) for by_noise in products])
        described = [(axis.name, axis.description) for axis in responses.axes]
        base = next((fit for fit in fits if not fit.causes), None)
        exchanged = self.exchanged_labels(base) if base is not None else None
        if exchanged is None:
            return NeutralResponses(described, gains)
        added = np.array([exchanged.log_gain if fit is base else -np.inf for fit in fits])
        return NeutralResponses([*described, ("run", EXCHANGED)], np.column_stack([gains, added]))

    def responses(self, fit: CauseFit) -> Responses:
        """Return responses along the axes of a fit: all that they may do, also what a cause of its set would."""
        return Responses.of(self.response_axes(fit.state.linear), self._covariance(fit))

    def exchanged_labels(self, base: CauseFit) -> ExchangedLabels | None:
        """Return the likeliest exchange of labels beside the base model."""
        return exchanged_labels(self, base)

    def sampled_evidence(self, fit: CauseFit) -> SampledEvidence:
        """Evidence by importance sampling of the causes with the phase itself; the rest as in the linearised fit."""
        free, state, linear = self.searched(fit.causes), fit.state, fit.state.linear
        if not len(free):
            return SampledEvidence(fit.log_evidence, float(DRAWS))
        prior, narrow = self.prior(fit.causes), self.nuisance_sd(fit.causes)
        weights = np.array([noise.log_prior for noise in noise_grid()])

        def log_joint(at: Array) -> Array:
            settings = np.repeat(prior.centre[:, None], len(at), axis=1)
            settings[free] = at.T
            readings = self.forward.readings(self.coordinates, settings, delays=linear.release_delays)
            residuals = self.y[:, None] - readings + self.release_delay_shift(linear)[:, None]
            logs = weights[:, None] + self.log_densities(linear, narrow, residuals, noise_grid())
            return np.asarray(logsumexp(logs, axis=0) + prior.of(free).log_density(at) - prior.log_mass)

        inside = inside_range(linear.centre + state.marginal.mean, state.marginal.covariance, *prior.bounds)
        return sampled_evidence(log_joint, inside.mean[free], inside.covariance[np.ix_(free, free)])

    def residuals(self, fit: CauseFit) -> Residuals:
        """Readings less the linearised model at the prior means, and their covariance."""
        return self.residuals_along(fit, self.axes(fit.state.linear))

    def residuals_along(self, fit: CauseFit, axes: Sequence[Axis]) -> Residuals:
        """Return the residuals with other axes to look along."""
        logs = self.forward.logs
        return Residuals(
            fit.state.linear.y,
            self._covariance(fit),
            np.concatenate([np.full(len(log.t), k) for k, log in enumerate(logs)]),
            axes,
            np.concatenate([np.full(len(log.t), log.name) for log in logs]),
            quantised=True,
            products_by_noise=partial(self.products, fit.state.linear, fit.state.prior_sd, noises=noise_grid()),
        )

    def _covariance(self, fit: CauseFit) -> BlockCovariance:
        """Covariance of all readings under a fit, at its most likely noise [m²]."""
        return self.covariance(fit.state.linear, noise_grid()[fit.state.best_noise], fit.state.prior_sd)

    def axes(self, linear: DiveLinearisation) -> Sequence[Axis]:
        """Axes along which a discrepancy is sought."""
        return descent_axes(self, linear)

    def response_axes(self, linear: DiveLinearisation) -> Sequence[Axis]:
        """Axes along which a neutral response may be smooth."""
        axes = self.axes(linear)
        return [*axes, *drag_of_each_dive(self.forward.logs, axes)]

    def innovations(self, fit: CauseFit) -> Array:
        """One-step-ahead errors of the readings over their standard deviations, dive after dive, shape (N,)."""
        return self._covariance(fit).innovations(fit.state.linear.y)

    def held_out(self, fits: Sequence[CauseFit]) -> list[list[HeldOutScore]]:
        """Predict each dive from the others under several fits: causes and noise fitted to the others alone.

        Of many dives one alone hardly moves where the model is linearised.
        """
        count = len(self.parts)
        if count > MOST_REFITTED:
            return [self._scores(fit, fit.state.linear, range(count)) for fit in fits]
        others = [np.setdiff1d(np.arange(len(self.y)), rows) for rows in self.parts]
        folds = [(fit, dive) for fit in fits for dive in range(len(self.parts))]
        starts = [
            self.start(fit.causes, fit.state.linear.at, fold, others[dive]) for fold, (fit, dive) in enumerate(folds)
        ]
        points = self.best_coordinates(starts, REFIT_ITERATIONS)
        linears = self.linearise([(fit.causes, at) for (fit, _), at in zip(folds, points, strict=True)])
        pairs = zip(folds, linears, strict=True)
        scores = [score for (fit, dive), linear in pairs for score in self._scores(fit, linear, [dive])]
        return [scores[k * count : (k + 1) * count] for k in range(len(fits))]

    def _scores(self, fit: CauseFit, linear: DiveLinearisation, dives: Iterable[int]) -> list[HeldOutScore]:
        """Predict some dives, each from all others.

        Log scores (Gneiting & Raftery 2007) are averaged over the noises by their posterior from the other dives.
        Errors are those of the mean that the others leave of the coordinates at their most likely noise.
        """
        prior, likelihood, scores = fit.state.prior_sd, self.likelihood(linear), []
        whole, covariances = float(logsumexp(likelihood.log_joint(prior))), dict[Noise, BlockCovariance]()
        for dive in dives:
            seen = likelihood.log_joint(prior, np.delete(np.arange(len(self.parts)), dive))
            rows, best = self.parts[dive], noise_grid()[int(np.argmax(seen))]
            if best not in covariances:
                covariances[best] = self.covariance(linear, best, prior)
            error, covariance = next(covariances[best].left_out(linear.y, [rows]))
            scaled, log_score = error / self.units[rows], whole - float(logsumexp(seen))
            inside = int((np.abs(error) <= QUANTILE_95 * np.sqrt(np.diag(covariance))).sum())
            name = self.forward.logs[dive].name
            scores.append(HeldOutScore(name, log_score, float(scaled @ scaled), inside, len(error)))
        return scores

    @property
    def units(self) -> Array:
        """Scale of the readings' errors in a score, shape (N,): 1 m."""
        return np.ones(len(self.y))

    @property
    def designs(self) -> Sequence[str]:
        """Further dives, in words, cheapest first."""
        return [what for what, *_ in dive_designs.DESIGNS]

    def discrimination(self, first: CauseFit, second: CauseFit, entry: int | None) -> float:
        """Expected ln Bayes factor of the first set over the second, with the dives of a design or without."""
        further = dive_designs.design_dives(self.forward, entry) if entry is not None else ()
        forward = replace(self.forward.coarse, logs=self.forward.logs + further)
        return noise_free_discrimination(DescentModel(forward, self.given), first, second)

    def expected_log_bayes_factor(self, first: CauseFit, second: CauseFit) -> float:
        """Ln Bayes factor of the first set, whose noise-free readings these are, over the second, fitted anew."""
        (at,) = self.best_coordinates([self.start(second.causes, second.state.linear.at)])
        points = [(first.causes, first.state.linear.at), (second.causes, at)]
        linears = self.linearise(points)
        fitted = [self.integrated(causes, linear) for (causes, _), linear in zip(points, linears, strict=True)]
        evidence = [fit.log_evidence if isinstance(fit, CauseFit) else -np.inf for fit in fitted]
        return float(max(evidence[0] - evidence[1], 0.0))


def noise_free_discrimination(model: DescentModel, first: CauseFit, second: CauseFit) -> float:
    """Ln Bayes factor of the first set over the second by noise-free readings of the first.

    Parameters
    ----------
    model : DescentModel
        Of the dives; their depths are not used.
    first, second : CauseFit
        Fits of the sets.
    """
    forward = model.forward
    readings = forward.readings(model.coordinates, first.state.linear.at[:, None])[:, 0]
    forward = replace(forward, logs=dive_designs.with_depths(forward.logs, readings))
    return replace(model, forward=forward).expected_log_bayes_factor(first, second)


AT_SURFACE = 0.5
"""Depth that a vehicle at the surface is read at, at most: waves, trim and the offset of a sensor [m]."""
SMOOTHED = 5
"""Readings of which the median is taken."""


def descent_model(data: PreparedDives, mission: Mission) -> DescentModel:
    """Bind a mission's first mooring to dive logs.

    Raises
    ------
    InputError
        When the mission lacks what a descent needs.
    """
    return DescentModel(DescentForward(descent_builder(mission), data.dives), given_on_descent(mission))


def given_on_descent(mission: Mission) -> tuple[GivenEffect, ...]:
    """Return a mission's own effects on a descent, as its dives are diagnosed.

    Raises
    ------
    InputError
        When a diagnosis cannot hold them together.
    """
    priors = given_priors(mission, effects_of("descent"))
    check_together(priors, mission, "descent")
    return priors


def descent_builder(mission: Mission) -> Callable[[Array, Array], Dive]:
    """Return the mission's descent, without effects, as a function of wet weights [N] and line lengths [m].

    Raises
    ------
    InputError
        When the mission lacks what a descent needs.
    """
    MooringMission.of(mission, depth=False)
    scenario = Scenario.at_means(mission).at_depth(0.0)

    def build(weights: Array, lines: Array) -> Dive:
        phase = scenario.moor().model_copy(update={"line_length": lines, "lateral": "uncoupled"})
        return dive_of(scenario, phase, weights)

    return build


def check_leaves_surface(data: DescentData, mission: Mission) -> None:
    """Refuse dives in which the vehicle never leaves the surface, or whose log ends before it could.

    Raises
    ------
    InputError
        With each of them.
    """
    floating = [dive for dive in data.dives if float(median_filter(dive.depth, SMOOTHED).max()) < AT_SURFACE]
    if not floating:
        return
    problems = []
    # times from the separation to the taut line as the mission expects them, shape (n,) [s]
    weights, lines, depths = (
        np.array([getattr(expected, key) for expected in floating])
        for key in ("wet_weight", "line_length", "site_depth")
    )
    effects = [effect for effect in given_effects(mission) if isinstance(effect, DescentEffect)]
    expected = replace(descent_builder(mission)(weights, lines), site_depth=depths)
    for dive, taut in zip(
        floating, descent_stages(expected, DescentHooks(effects), len(floating)).taut_at, strict=True
    ):
        end = float(dive.t[-1])
        if end <= taut:
            words = f"the log ends {end:.3g} s after the separation, before the line is taut (at {taut:.3g} s)"
        else:
            words = (
                f"the vehicle never leaves the surface: its depths are at most {dive.depth.max():.3g} m, and the line "
                f"of {dive.line_length:.4g} m is taut {taut:.3g} s after the separation"
            )
        problems.append(Problem(f"{dive.name}: {words}", data.file, dive.line, "depth_m"))
    raise InputError(problems)
