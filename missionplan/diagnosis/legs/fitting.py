"""Fits of sets of causes to a navigation log: hyperparameters by Laplace's method, coefficients exactly."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Self, cast

import numpy as np

from missionplan.arrays import Array
from missionplan.diagnosis.coordinates import SIGMA_V, Coordinate, JointPosterior, estimates, is_possible
from missionplan.diagnosis.given import RecordPosterior, held, tied
from missionplan.diagnosis.inference.evidence_approximations import Laplace, laplace
from missionplan.diagnosis.inference.marginal_likelihood import QUANTILE_95
from missionplan.diagnosis.inference.model import CauseFit
from missionplan.diagnosis.legs.likelihood.covariance import ALL_LEGS, TransitCovariance
from missionplan.diagnosis.legs.likelihood.hyperparameters import (
    SLAB_SCALE,
    Hyperparameter,
    HyperparameterPrior,
    values_of,
)
from missionplan.diagnosis.legs.likelihood.linearised import LinearisedLegs, SelectedLegs
from missionplan.diagnosis.legs.likelihood.markov_covariance import LegSelection
from missionplan.diagnosis.legs.likelihood.mean import ActingTerm
from missionplan.diagnosis.legs.likelihood.modulation import Forms, variance_of_mean
from missionplan.effects import CATALOGUE
from missionplan.effects.oscillation import MODULATION
from missionplan.results.learned.evidence import Causes, ParameterEstimate


@dataclass(frozen=True)
class TransitState:
    """State of a fit: Laplace approximation of the hyperparameters, and the coefficients at their mode."""

    forms: Forms
    """Oscillations among the causes that are not steady."""
    hyperparameters: tuple[Hyperparameter, ...]
    """Those of the set of causes."""
    posterior: Laplace
    """Of their logarithms."""
    mean: Array
    """Posterior mean of all coordinates, the hyperparameters at their mode, shape (k,)."""
    covariance: Array
    """Posterior covariance of them, shape (k, k)."""
    linear: LinearisedLegs
    """The model as linearised last."""
    term: ActingTerm | None = None
    """Whose strengths are coordinates beside those of the model."""

    @property
    def values(self) -> dict[tuple[str, str], float]:
        """Hyperparameters at their mode."""
        return values_of(self.hyperparameters, self.posterior.mode)

    def estimates(self, effects: Causes) -> tuple[ParameterEstimate, ...]:
        """Estimates of the hyperparameters that are parameters of some effects."""
        noise = self.noise(effects)
        rows = [i for i, coordinate in enumerate(noise.coordinates) if coordinate.effect]
        return estimates([noise.coordinates[i] for i in rows], noise.mean[rows], noise.covariance[np.ix_(rows, rows)])

    def noise(self, effects: Causes) -> JointPosterior:
        """Joint posterior of σ_v and of the hyperparameters that are parameters of some effects."""
        chosen, shapes = [], []
        for index, h in enumerate(self.hyperparameters):
            if h.key == ("", SIGMA_V.name):
                shapes.append(SIGMA_V)
            elif h.effect in effects and h.name in CATALOGUE[h.effect].parameters:
                shapes.append(Coordinate(h.effect, h.name, "shape", h.centre, h.spread, 0.0))
            else:
                continue
            chosen.append(index)
        return JointPosterior(
            tuple(shapes), self.posterior.mode[chosen], self.posterior.covariance[np.ix_(chosen, chosen)]
        )


MAX_LINEARISATIONS = 5
"""Times, at most, that a nonlinear model is linearised anew."""
CLEARLY = 0.5
"""Log evidence by which an oscillation must be likelier modulated than steady to be taken so."""
PAIR = 2
"""Coordinates of an oscillation of one amplitude and phase."""
LARGEST_RATIO = 1.9
"""Largest size of an oscillation that wanders, over its mean amplitude in the record, that the effect can carry."""
CONVERGED = 0.005
"""Move of the coordinates, in slabs, below which it is not."""


@dataclass(frozen=True)
class TransitFitting(TransitCovariance):
    """The likelihood of the legs, with fits of sets of causes."""

    _with_terms: list["TransitFitting"] = field(default_factory=list, init=False, repr=False, compare=False)

    @property
    def given_forms(self) -> Forms:
        """The mission's own oscillations that are modulated."""
        return Forms(
            modulated=tuple(prior.effect for prior in self.given_in_covariance if CATALOGUE[prior.effect].is_modulated)
        )

    def fit(self, causes: Causes, near: Sequence[CauseFit] = ()) -> CauseFit:
        """Fit a set of causes, linearised about its own posterior mean.

        The hyperparameters' posterior is approximated by Laplace's method (Tierney & Kadane 1986); a set with causes
        that are not linear is linearised anew until its mean settles (Gauss–Newton). Each oscillation of the set is
        steady or not, equally likely before; the fit is that of the likelier case. Raises numpy.linalg.LinAlgError when
        no covariance near the start is positive definite.
        """
        evidence, _, state = self.over_forms(causes, near)
        return self.fit_of(causes, state, evidence)

    def over_forms(self, causes: Causes, near: Sequence[CauseFit] = ()) -> tuple[float, float, TransitState]:
        """Log evidence of a set whose oscillations need not be steady, what that adds, and its likeliest state.

        It is a plainer one where another is hardly likelier.
        """
        states: list[TransitState] = []
        variants = self._variants(causes)
        for forms, _ in variants:
            starts = [fit.state for fit in near] + states[-1:]
            states.append(self._fitted(causes, forms, starts, ALL_LEGS, integrate=True))
        evidences = np.array([state.posterior.log_evidence for state in states])
        together = float(np.logaddexp.reduce(evidences + np.log([weight for _, weight in variants])))
        likeliest = states[int(np.argmax(evidences - CLEARLY * np.arange(len(states))))]
        return together, together - float(evidences[0]), likeliest

    def _variants(self, causes: Causes) -> list[tuple[Forms, float]]:
        """Forms of the oscillations with their prior probabilities.

        One of one amplitude and phase may wander, though alone it seems steady, where the mission has none like it.
        """
        mission_effects = {prior.effect for prior in self.given}
        variants = [(Forms(), 1.0)]
        for name in (name for name in causes if CATALOGUE[name].is_modulated):
            may_wander = len(self.by_effect[name]) == PAIR and name not in mission_effects
            share = 0.25 if may_wander else 0.5
            forms = [(forms, 0.5 * weight) for forms, weight in variants]
            forms += [(replace(f, modulated=(*f.modulated, name)), share * weight) for f, weight in variants]
            if may_wander:
                forms += [(replace(f, wandering=(*f.wandering, name)), share * weight) for f, weight in variants]
            variants = forms
        return variants

    def with_term(self, term: ActingTerm | None) -> Self:
        """Return the model with the strengths of a term among its coordinates; those asked for are kept."""
        if term == self.acting:
            return self
        model = next((model for model in self._with_terms if model.acting == term), None)
        if model is None:
            model = replace(self, acting=term)
            self._with_terms.append(model)
        return cast(Self, model)

    def from_last(self, term: ActingTerm) -> list[int]:
        """Places of the coordinates where those of its term stand after all others."""
        keys = {coordinate.key for coordinate in term.coordinates}
        others = iter(range(len(self.coordinates) - len(keys)))
        lasts = iter(range(len(self.coordinates) - len(keys), len(self.coordinates)))
        return [next(lasts if coordinate.key in keys else others) for coordinate in self.coordinates]

    def settled(self, causes: Causes, state: TransitState) -> TransitState:
        """Return a state with a term linearised anew about its mean, at its noise, until it settles."""
        slabs = np.array([coordinate.slab for coordinate in self.coordinates])
        for _ in range(MAX_LINEARISATIONS):
            linear = self.linearised(causes, state.mean, state.forms)
            marginal = self.marginal(state.hyperparameters, state.posterior.mode, linear)
            mean, covariance = linear.prior.posterior(marginal)
            moved = np.max(np.abs(mean - state.mean) / slabs)
            state = replace(state, mean=mean, covariance=covariance, linear=linear)
            if moved < CONVERGED:
                break
        return state

    def refitted(self, fit: CauseFit, rows: LegSelection) -> CauseFit:
        """Fit the same set to some of the legs: the mode alone, without evidence."""
        model = self.with_term(fit.state.term)
        state = model._fitted(fit.causes, fit.state.forms, [fit.state], rows, integrate=False)
        return model.fit_of(fit.causes, state, math.nan)

    def _fitted(
        self, causes: Causes, forms: Forms, near: Sequence[TransitState], rows: LegSelection, *, integrate: bool
    ) -> TransitState:
        mission_effects = (
            prior.effect for prior in held(self.given_in_covariance, causes) if CATALOGUE[prior.effect].is_modulated
        )
        forms = replace(forms, modulated=tuple(dict.fromkeys((*forms.modulated, *mission_effects))))
        hyperparameters = self.hyperparameters(causes, forms)
        starts, covariance = _starts(hyperparameters, near)
        slabs = np.array([coordinate.slab for coordinate in self.coordinates])
        nonlinear = bool(forms.modulated) or any(not CATALOGUE[name].linear for name in causes)
        about = self.expected.copy()
        for other in reversed(near) if nonlinear else ():  # where fits have the causes under slabs
            indices = [i for name in causes for i in other.linear.slabs.get(name, ())]
            about[indices] = other.mean[indices]
        prior = HyperparameterPrior.of(hyperparameters, self.given_in_covariance)
        for iteration in range(MAX_LINEARISATIONS):
            linear = self.linearised(causes, about, forms)
            selected = self.selected(linear, rows)

            def log_posterior(logarithms: Array, selected: SelectedLegs = selected) -> float:
                return prior.log_density(logarithms) + self.log_density(hyperparameters, logarithms, selected)

            posterior = laplace(log_posterior, starts, covariance, integrate=integrate)
            mean, spread = linear.prior.posterior(self.marginal(hyperparameters, posterior.mode, linear, rows))
            state = TransitState(forms, hyperparameters, posterior, mean, spread, linear, self.acting)
            moved, about = np.abs(mean - about), mean
            starts, covariance = [posterior.mode], posterior.covariance
            if not nonlinear or (iteration and np.max(moved / slabs) < CONVERGED):
                break
        return state

    def fit_of(self, causes: Causes, state: TransitState, evidence: float) -> CauseFit:
        """Return the fit of a set with a state."""
        chosen = [i for i, coordinate in enumerate(self.coordinates) if coordinate.effect in causes]
        coordinates, covariance = [self.coordinates[i] for i in chosen], self._spread(causes, state)
        parameters = estimates(coordinates, state.mean[chosen], covariance[np.ix_(chosen, chosen)])
        parameters += state.estimates(causes)
        wandering = self._relative_sizes(state, parameters)
        parameters += estimates(wandering.coordinates, wandering.mean, wandering.covariance)
        calibration = {
            f"{h.name}_{'m' if h.name == 'fix_sd' else 'm_s'}": math.exp(value)
            for h, value in zip(state.hyperparameters, state.posterior.mode, strict=True)
            if not h.effect
        }
        place = [h.key for h in state.hyperparameters].index(("", "sigma_v"))
        calibration["sigma_v_factor"] = math.exp(math.sqrt(state.posterior.covariance[place, place]))
        together = RecordPosterior(self.coordinates, state.mean, covariance).afterwards(
            tied(held(self.given_in_mean, causes)), chosen
        )
        random = (*causes, *(prior.effect for prior in held(self.given_in_covariance, causes)))
        together = together.joined(state.noise(random)).joined(wandering)
        # what is known of the mission's own effects after this record, those that changed left out
        after = RecordPosterior(self.coordinates, state.mean, covariance).known(tied(held(self.given_in_mean, causes)))
        for prior in held(self.given_in_covariance, causes):
            after += state.estimates((prior.effect,))
        return CauseFit(causes, evidence, parameters, calibration, is_possible(parameters), state, after, together)

    def _spread(self, causes: Causes, state: TransitState) -> Array:
        """Covariance of the coordinates as far as the next record is concerned, shape (k, k).

        A cause adds to what varies from record to record in any case.
        """
        spikes = [coordinate.spike if coordinate.effect in causes else 0.0 for coordinate in self.coordinates]
        # covariance of the usual amplitudes about those of this record, of oscillations that are modulated, (k, k)
        variance = np.zeros(len(state.mean))
        for modulation in state.linear.modulations:
            if modulation.wanders_over is not None:
                continue
            of_mean = variance_of_mean(self.data.middle, *(state.values[key] for key in modulation.keys))
            indices = self.by_effect[modulation.effect]
            squared = state.mean[indices[::2]] ** 2 + state.mean[indices[1::2]] ** 2
            variance[indices] = of_mean * np.repeat(squared, 2)
        return np.asarray(state.covariance + np.diag(variance) + np.diag(np.square(spikes)))

    def _relative_sizes(self, state: TransitState, parameters: Sequence[ParameterEstimate]) -> JointPosterior:
        """Sizes of oscillations that wander over their mean amplitudes in the record, as the effect has them."""
        shapes, logs, variances = [], [], []
        for name in state.forms.wandering:
            mean = next(parameter for parameter in parameters if parameter.effect == name)
            place = [h.key for h in state.hyperparameters].index((name, SLAB_SCALE))
            size = state.values[name, SLAB_SCALE] * self.coordinates[self.by_effect[name][0]].slab
            sd = math.hypot(math.sqrt(state.posterior.covariance[place, place]), mean.sd / max(mean.value, 1e-9))
            ratio = min(size / max(mean.value, 1e-9), LARGEST_RATIO)
            shapes.append(Coordinate(name, MODULATION, "shape", 0.0, sd, 0.0))
            logs.append(math.log(ratio))
            variances.append(min(sd, 1.0) ** 2)
        return JointPosterior(tuple(shapes), np.array(logs), np.diag(variances).reshape(len(logs), len(logs)))


def by_quantiles(estimate: ParameterEstimate, quantiles: Array | None) -> ParameterEstimate:
    """Give an estimate the 5, 50 and 95 % quantiles of its posterior, if it has any."""
    if quantiles is None:
        return estimate
    low, median, high = quantiles.tolist()
    sd = median * math.log(high / low) / (2.0 * QUANTILE_95)
    return replace(estimate, value=median, sd=sd, low=low, high=high)


def _starts(hyperparameters: tuple[Hyperparameter, ...], near: Sequence[TransitState]) -> tuple[list[Array], Array]:
    """Starting points of the search for the mode, and a guess of the posterior covariance.

    From the fits given where there are any, else the priors' centres; a new size or time of a cause also starts one
    prior standard deviation lower and higher.
    """
    marginals: dict[tuple[str, str], tuple[float, float]] = {}
    for state in near:
        modes, variances = state.posterior.mode, np.diag(state.posterior.covariance)
        for hyperparameter, mode, variance in zip(state.hyperparameters, modes, variances, strict=True):
            marginals.setdefault(hyperparameter.key, (float(mode), float(variance)))
    guesses = [marginals.get(h.key, (h.centre, min(0.1, h.spread**2))) for h in hyperparameters]
    first = np.array([guess[0] for guess in guesses])
    starts = [first]
    for index, hyperparameter in enumerate(hyperparameters):
        if hyperparameter.law in ("student", "reciprocal") and hyperparameter.key not in marginals:
            for shift in (-1.0, 1.0):
                moved = first.copy()
                moved[index] += shift * hyperparameter.spread
                starts.append(moved)
    return starts, np.diag([guess[1] for guess in guesses])
