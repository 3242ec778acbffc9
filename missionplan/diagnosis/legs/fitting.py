"""Fits of sets of causes to a navigation log: hyperparameters by Laplace's method, coefficients exactly."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from missionplan.arrays import Array
from missionplan.diagnosis.coordinates import Coordinate, estimates, is_possible
from missionplan.diagnosis.given_effects import held
from missionplan.diagnosis.inference.importance_sampling import SampledEvidence, sampled_evidence
from missionplan.diagnosis.inference.laplace import Laplace, laplace
from missionplan.diagnosis.inference.marginal_likelihood import LOG_2PI
from missionplan.diagnosis.inference.model import CauseFit
from missionplan.diagnosis.legs.covariance import ALL_LEGS, Hyperparameter, TransitCovariance
from missionplan.diagnosis.legs.markov_covariance import LegSelection
from missionplan.diagnosis.legs.mean import LinearisedLegs
from missionplan.effects import CATALOGUE
from missionplan.results.evidence import Causes, ParameterEstimate

MAX_LINEARISATIONS = 5
"""Times, at most, that a nonlinear model is linearised anew."""
CONVERGED = 0.005
"""Move of the coordinates, in slabs, below which it is not."""


@dataclass(frozen=True)
class TransitState:
    """State of a fit: Laplace approximation of the hyperparameters, and the coefficients at their mode.

    Attributes
    ----------
    hyperparameters : tuple of Hyperparameter
        Those of the set of causes.
    posterior : Laplace
        Of their logarithms.
    mean : array, shape (k,)
        Posterior mean of all coordinates, the hyperparameters at their mode.
    covariance : array, shape (k, k)
        Posterior covariance of them.
    linear : LinearisedLegs
        The model as linearised last.
    """

    hyperparameters: tuple[Hyperparameter, ...]
    posterior: Laplace
    mean: Array
    covariance: Array
    linear: LinearisedLegs


@dataclass(frozen=True)
class TransitFitting(TransitCovariance):
    """The likelihood of the legs, with fits of sets of causes."""

    def fit(
        self, causes: Causes, near: Sequence[CauseFit] = (), rows: LegSelection = ALL_LEGS, *, integrate: bool = True
    ) -> CauseFit:
        """Fit a set of causes, linearised about its own posterior mean.

        The hyperparameters' posterior is approximated by Laplace's method (Tierney & Kadane 1986); a set with causes
        that are not linear is linearised anew until its mean settles (Gauss–Newton).

        Parameters
        ----------
        causes : tuple of str
            The set.
        near : sequence of CauseFit
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
        hyperparameters = self.hyperparameters(causes)
        starts, covariance = _starts(hyperparameters, near)
        slabs = np.array([coordinate.slab for coordinate in self.coordinates])
        nonlinear = any(CATALOGUE[name].modulation or not CATALOGUE[name].linear for name in causes)
        about = self._starting_mean(causes, near) if nonlinear else self.expected
        for iteration in range(MAX_LINEARISATIONS):
            linear = self.linearised(causes, about)
            posterior = self._posterior(causes, hyperparameters, starts, covariance, linear, rows, integrate=integrate)
            mean, spread = linear.prior.posterior(self.marginal(causes, posterior.mode, linear, rows))
            state = TransitState(hyperparameters, posterior, mean, spread, linear)
            moved, about = np.abs(mean - about), mean
            starts, covariance = [posterior.mode], posterior.covariance
            if not nonlinear or (iteration and np.max(moved / slabs) < CONVERGED):
                break
        return self._fit_of(causes, state)

    def _starting_mean(self, causes: Causes, near: Sequence[CauseFit]) -> Array:
        """Coordinates of a set's causes from fits of its subsets; else as the mission expects."""
        mean = self.expected.copy()
        for fit in reversed(near):
            own = [i for i, c in enumerate(self.coordinates) if c.effect in fit.causes and c.effect in causes]
            mean[own] = fit.state.mean[own]
        return mean

    def _posterior(
        self,
        causes: Causes,
        hyperparameters: tuple[Hyperparameter, ...],
        starts: list[Array],
        covariance: Array,
        linear: LinearisedLegs,
        rows: LegSelection,
        *,
        integrate: bool,
    ) -> Laplace:
        def log_posterior(logarithms: Array) -> float:
            likelihood = self.marginal(causes, logarithms, linear, rows).log_density
            return _log_prior(hyperparameters, logarithms) + likelihood

        return laplace(log_posterior, starts, covariance, integrate=integrate)

    def sampled_evidence(self, fit: CauseFit) -> SampledEvidence:
        """Evidence of a fit by importance sampling of the hyperparameters; the coefficients exactly, as in the fit."""
        state, linear = fit.state, fit.state.linear

        def log_joint(logarithms: Array) -> float:
            try:
                likelihood = self.marginal(fit.causes, logarithms, linear).log_density
            except np.linalg.LinAlgError:
                return -math.inf
            return _log_prior(state.hyperparameters, logarithms) + likelihood

        def log_joint_of_all(draws: Array) -> Array:
            return np.array([log_joint(logarithms) for logarithms in draws])

        return sampled_evidence(log_joint_of_all, state.posterior.mode, state.posterior.covariance)

    def _fit_of(self, causes: Causes, state: TransitState) -> CauseFit:
        chosen = [i for i, coordinate in enumerate(self.coordinates) if coordinate.effect in causes]
        own = [self.coordinates[i] for i in chosen]
        # a cause adds to what varies from record to record in any case
        from_record_to_record = np.diag([coordinate.spike**2 for coordinate in own])
        covariance = state.covariance[np.ix_(chosen, chosen)] + from_record_to_record
        found = estimates(own, state.mean[chosen], covariance) + _hyperparameter_estimates(state, causes)
        calibration = {
            f"{h.name}_{'m' if h.name == 'fix_sd' else 'm_s'}": math.exp(value)
            for h, value in zip(state.hyperparameters, state.posterior.mode, strict=True)
            if not h.effect
        }
        evidence, possible = state.posterior.log_evidence, is_possible(found)
        return CauseFit(causes, evidence, found, calibration, possible, state, self._given_estimates(causes, state))

    def _given_estimates(self, causes: Causes, state: TransitState) -> tuple[ParameterEstimate, ...]:
        """What is known of the mission's own effects after this record, those that changed left out."""
        found: list[ParameterEstimate] = []
        for each in held(self.given_in_mean, causes):
            own = self.places(each)
            found += each.posterior(state.mean[own], state.covariance[np.ix_(own, own)])
        for each in held(self.given_in_covariance, causes):
            found += _hyperparameter_estimates(state, (each.effect,))
        return tuple(found)


def _log_prior(hyperparameters: tuple[Hyperparameter, ...], logarithms: Array) -> float:
    """Log prior density of the hyperparameters' logarithms."""
    spread = np.array([hyperparameter.spread for hyperparameter in hyperparameters])
    scaled = (logarithms - np.array([hyperparameter.centre for hyperparameter in hyperparameters])) / spread
    return -0.5 * float(scaled @ scaled) - float(np.log(spread).sum()) - 0.5 * len(logarithms) * LOG_2PI


def _starts(hyperparameters: tuple[Hyperparameter, ...], near: Sequence[CauseFit]) -> tuple[list[Array], Array]:
    """Starting points of the search for the mode, and a guess of the posterior covariance.

    From the fits given where there are any, else the priors' centres; a new hyperparameter of a cause also starts one
    prior standard deviation lower and higher.
    """
    known: dict[tuple[str, str], tuple[float, float]] = {}
    for fit in near:
        modes, variances = fit.state.posterior.mode, np.diag(fit.state.posterior.covariance)
        for hyperparameter, mode, variance in zip(fit.state.hyperparameters, modes, variances, strict=True):
            known.setdefault((hyperparameter.effect, hyperparameter.name), (float(mode), float(variance)))
    guesses = [known.get((h.effect, h.name), (h.centre, min(0.1, h.spread**2))) for h in hyperparameters]
    first = np.array([guess[0] for guess in guesses])
    starts = [first]
    for index, hyperparameter in enumerate(hyperparameters):
        if hyperparameter.effect and (hyperparameter.effect, hyperparameter.name) not in known:
            for shift in (-1.0, 1.0):
                moved = first.copy()
                moved[index] += shift * hyperparameter.spread
                starts.append(moved)
    return starts, np.diag([guess[1] for guess in guesses])


def _hyperparameter_estimates(state: TransitState, effects: Causes) -> tuple[ParameterEstimate, ...]:
    """Estimates of the hyperparameters that are parameters of some effects."""
    chosen = [i for i, hyperparameter in enumerate(state.hyperparameters) if hyperparameter.effect in effects]
    own = [state.hyperparameters[i] for i in chosen]
    shapes = [Coordinate(h.effect, h.name, "shape", h.centre, h.spread, 0.0) for h in own]
    return estimates(shapes, state.posterior.mode[chosen], state.posterior.covariance[np.ix_(chosen, chosen)])
