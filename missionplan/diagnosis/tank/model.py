"""Model of tank data: least squares with normal priors, linearised at its best; the noise's size is summed over."""

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp
from scipy.stats import norm

from missionplan.arrays import Array
from missionplan.diagnosis.coordinates import (
    Coordinate,
    coordinates_of,
    estimates,
    has_shape,
    is_possible,
    parameters_from,
)
from missionplan.diagnosis.inference.axes import pointwise, scaled
from missionplan.diagnosis.inference.importance_sampling import SampledEvidence, sampled_evidence
from missionplan.diagnosis.inference.marginal_likelihood import LOG_2PI, Marginal
from missionplan.diagnosis.inference.model import MINIMUM_EVIDENCE_GAIN, CauseFit, FailedFit, FitRequest, HeldOutScore
from missionplan.diagnosis.inference.residuals import Residuals
from missionplan.diagnosis.tank.forward import TankForward, build_effects
from missionplan.diagnosis.tank.gauss_newton import Climb
from missionplan.diagnosis.tank.linearised import LinearData, marginal
from missionplan.effects import CATALOGUE
from missionplan.results.diagnosis import Causes, ParameterEstimate

STATED_SPREAD, UNSTATED_SPREAD = 0.4, 2.3
"""Standard deviation of ln(noise over what is stated), where it is stated and where it is not."""
SPIKES = {("drag-bias", "fraction"): 0.02}
"""Doubts of a tank where they are not those of a descent: a drag measured in one tank holds in another to 2 %."""
COVARIANCE_INFLATION = 9.0
"""Factor on the posterior covariance with which fitted coordinates enter the residuals: as good as unknown there."""


@dataclass(frozen=True)
class TankState:
    """A fitted set: coordinates there, what is left, derivatives, noise factor and the posterior of the coordinates."""

    at: Array
    left: Array
    columns: Array
    active: NDArray[np.int_]
    factor: float
    marginal: Marginal


@dataclass(frozen=True)
class TankModel:
    """Base model of a tank experiment and the effects that it may lack, bound to data."""

    forward: TankForward
    noise_known: bool = False
    alternatives: Sequence[frozenset[str]] = ()

    @property
    def candidates(self) -> Causes:
        """Effects that these data could show."""
        return self.forward.candidates

    def minimum_evidence_gain(self, causes: Causes) -> float:
        """The usual: what the catalogue adds is as good as linear in its strengths, and of known shape."""
        return MINIMUM_EVIDENCE_GAIN

    @property
    def untestable(self) -> Mapping[str, str]:
        """Effects that they could not, and why."""
        return self.forward.untestable

    @cached_property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """Coordinates of the candidates; those of the nuisances come before them in every array."""
        found = (c for name in self.candidates for c in coordinates_of(CATALOGUE[name]))
        return tuple(replace(c, spike=SPIKES.get((c.effect, c.name), c.spike)) for c in found)

    @cached_property
    def centre(self) -> Array:
        """Prior means, shape (k,)."""
        return np.array([n.centre for n in self.forward.nuisances] + [c.centre for c in self.coordinates])

    def prior_sd(self, causes: Causes) -> Array:
        """Prior standard deviations, shape (k,): slab for a cause, spike otherwise (0 for a shape)."""
        own = [c.slab if c.effect in causes else c.spike for c in self.coordinates]
        return np.array([n.sd for n in self.forward.nuisances] + own)

    def predict(self, causes: Causes, places: Array) -> Array:
        """Data that coordinates predict, (k, m) → (N, m); an effect with a shape alone is there as a cause only."""
        fixed = len(self.forward.nuisances)
        parameters = parameters_from(self.coordinates, list(places[fixed:]))
        there = {
            name: values
            for name, values in parameters.items()
            if name in causes or any(c.kind != "shape" for c in self.coordinates if c.effect == name)
        }
        return self.forward.predict(places[:fixed], build_effects(there))

    def fit_all(self, wanted: Sequence[FitRequest]) -> list[CauseFit | FailedFit]:
        """Fit several sets, one after the other."""
        return [self._fit(causes, near) for causes, near in wanted]

    def relinearised(self, fits: Sequence[CauseFit | FailedFit], best: float) -> list[CauseFit | FailedFit]:
        """Fits are where they should be."""
        return list(fits)

    def _fit(self, causes: Causes, near: Sequence[CauseFit]) -> CauseFit | FailedFit:
        active = np.flatnonzero(self.prior_sd(causes) > 0.0)
        climb = self._climb(causes, active)
        best = min((climb.climb(start) for start in self._starts(causes, near)), key=lambda reached: reached.objective)
        if not np.isfinite(best.objective):
            return FailedFit(causes, "the model has no value at any of its starts")
        at, left, columns = best.at, self.forward.y - best.here, best.columns
        try:
            logs, marginals = self._integrated(causes, left, columns, at, active)
        except np.linalg.LinAlgError as error:
            return FailedFit(causes, str(error))
        likely = int(np.argmax(logs))
        state = TankState(at, left, columns, active, float(self._factors[likely]), marginals[likely])
        return CauseFit(causes, float(logsumexp(logs)), *self._described(causes, state), state)

    def plain_residuals(self) -> Array:
        """What the base model alone leaves, its nuisances fitted and every effect at nothing, shape (N,)."""
        climb = self._climb((), np.arange(len(self.forward.nuisances)))
        return np.asarray(self.forward.y - climb.climb(self.centre).here)

    def _climb(self, causes: Causes, active: NDArray[np.int_]) -> Climb:
        forward, factors = self.forward, (float(self._factors[0]), float(self._factors[-1]))
        predict, prior = partial(self.predict, causes), self.prior_sd(causes)[active]
        return Climb(predict, forward.y, forward.sd, self.centre, active, prior, factors)

    def _described(
        self, causes: Causes, state: TankState
    ) -> tuple[tuple[ParameterEstimate, ...], dict[str, float], bool]:
        fixed = len(self.forward.nuisances)
        rows = [k for k, index in enumerate(state.active) if self._is_of(causes, int(index))]
        chosen = [self.coordinates[int(state.active[k]) - fixed] for k in rows]
        found = estimates(chosen, state.marginal.mean[rows], state.marginal.covariance[np.ix_(rows, rows)])
        calibration = {n.name: float(v) for n, v in zip(self.forward.nuisances, state.at, strict=False)}
        noise = float(np.median(self.forward.sd)) * state.factor
        return found, calibration | {f"noise_{self.forward.quantity}": noise}, is_possible(found)

    def _is_of(self, causes: Causes, index: int) -> bool:
        fixed = len(self.forward.nuisances)
        return index >= fixed and self.coordinates[index - fixed].effect in causes

    def _starts(self, causes: Causes, near: Sequence[CauseFit]) -> list[Array]:
        begin = self.centre.copy()
        for fit in reversed(near):
            begin[fit.state.active] = fit.state.at[fit.state.active]
        fixed, choices = len(self.forward.nuisances), []
        for k, c in enumerate(self.coordinates):
            guesses = self.forward.guesses.get((c.effect, c.name), ()) if c.effect in causes else ()
            choices.append((*guesses, begin[fixed + k]) if guesses else (begin[fixed + k],))
        return [np.concatenate([begin[:fixed], own]) for own in itertools.product(*choices)]

    @property
    def _spread(self) -> float:
        return STATED_SPREAD if self.forward.stated else UNSTATED_SPREAD

    @cached_property
    def _factors(self) -> Array:
        """Factors on the sensor's noise over which the evidence is summed, evenly in their logarithm."""
        if self.noise_known:
            return np.ones(1)
        reach = 5.0 if self.forward.stated else 3.0
        count = 121 if self.forward.stated else 241
        return np.exp(np.linspace(-reach * self._spread, reach * self._spread, count))

    def _integrated(
        self, causes: Causes, left: Array, columns: Array, at: Array, active: NDArray[np.int_]
    ) -> tuple[Array, list[Marginal]]:
        """Log evidence at each noise factor, its prior included, and the posterior there."""
        prior, sd = self.prior_sd(causes)[active], self.forward.sd
        y = left + columns @ (at - self.centre)[active]
        log_prior = -0.5 * (np.log(self._factors) / self._spread) ** 2
        log_prior -= logsumexp(log_prior)
        found = [marginal(y, columns, prior, sd * factor) for factor in self._factors]
        logs = log_prior + np.array([each.log_density for each in found])
        return logs, [replace(each, mean=self.centre[active] + each.mean) for each in found]

    def may_be_multimodal(self, causes: Causes) -> bool:
        """Whether a cause has a shape of its own."""
        return has_shape(causes)

    def estimated_gain(self, causes: Causes, parent: CauseFit) -> float:
        """Unknown: the few effects of a tank are all fitted."""
        return float("inf")

    def sampled_evidence(self, fit: CauseFit) -> SampledEvidence:
        """Integrate over nuisances and causes by the model itself, not linearised."""
        state, sd = fit.state, self.forward.sd
        prior, centre = self.prior_sd(fit.causes)[state.active], self.centre[state.active]
        log_weights = -0.5 * (np.log(self._factors) / self._spread) ** 2
        log_weights -= logsumexp(log_weights) + len(sd) * np.log(self._factors)
        constant = -float(np.log(sd).sum()) - 0.5 * len(sd) * LOG_2PI

        def log_joint(at: Array) -> Array:
            places = np.repeat(self.centre[:, None], len(at), axis=1)
            places[state.active] = at.T
            left = (self.forward.y[:, None] - self.predict(fit.causes, places)) / sd[:, None]
            quadratic = -0.5 * np.sum(left**2, axis=0)[:, None] / self._factors**2
            log_prior = np.asarray(norm.logpdf(at, centre, prior)).sum(axis=1)
            return np.asarray(logsumexp(quadratic + log_weights, axis=1) + constant + log_prior)

        return sampled_evidence(log_joint, state.marginal.mean, state.marginal.covariance)

    def residuals(self, fit: CauseFit) -> Residuals:
        """What the fit leaves, the fitted coordinates as good as unknown."""
        state = fit.state
        noise = np.diag((state.factor * self.forward.sd) ** 2)
        covariance = noise + COVARIANCE_INFLATION * state.columns @ state.marginal.covariance @ state.columns.T
        count = len(state.left)
        axes = [
            pointwise(name, f"an error that changes with {name}", scaled(values))
            for name, values in self.forward.axes.items()
        ]
        # rows of a table are no series: only a record in time is tested for errors that follow one another
        series = np.zeros(count, dtype=int) if "time" in self.forward.axes else np.arange(count)
        return Residuals(state.left, covariance, series, axes, self.forward.groups)

    def held_out(self, fits: Sequence[CauseFit]) -> list[list[HeldOutScore]]:
        """Predict each group from the others under several fits, linearised where the fits are.

        Of what is no cause of a set, nothing is learnt from the other groups (`LinearData.predicted`). Squared errors
        are of the model itself with such effects at their centres.
        """
        return [self._scores(fit) for fit in fits]

    def _scores(self, fit: CauseFit) -> list[HeldOutScore]:
        state, forward = fit.state, self.forward
        active, fixed = state.active, len(forward.nuisances)
        learnt = np.array([index < fixed or self._is_of(fit.causes, int(index)) for index in active], dtype=bool)
        y = state.left + state.columns @ (state.at - self.centre)[active]
        prior = self.prior_sd(fit.causes)[active]
        linear = LinearData(y, state.factor * forward.sd, state.columns, prior, learnt, forward.groups)
        predicted = linear.predicted()
        places = np.repeat(self.centre[:, None], len(predicted), axis=1)
        places[active[learnt]] += np.stack([group.learnt for group in predicted], axis=1)
        errors = forward.y[:, None] - self.predict(fit.causes, places)
        return [
            HeldOutScore(
                str(forward.groups[group.rows][0]),
                group.log_score,
                float(np.sum(errors[group.rows, k] ** 2)),
                group.inside,
                int(group.rows.sum()),
            )
            for k, group in enumerate(predicted)
        ]

    @property
    def designs(self) -> Sequence[str]:
        """Further measurements, in words."""
        return [what for what, _ in self.forward.designs]

    def discrimination(self, first: CauseFit, second: CauseFit, entry: int | None) -> float:
        """Fit both sets to noise-free data of the first, as measured or as an entry of the menu would."""
        forward = self.forward if entry is None else self.forward.designs[entry][1]
        expected = replace(self, forward=forward).predict(first.causes, first.state.at[:, None])[:, 0]
        told = replace(forward, y=expected, sd=first.state.factor * self.forward.sd)
        fitted = replace(self, forward=told, noise_known=True).fit_all([(f.causes, (f,)) for f in (first, second)])
        evidence = [fit.log_evidence if isinstance(fit, CauseFit) else -np.inf for fit in fitted]
        return float(max(evidence[0] - evidence[1], 0.0))
