"""Covariance of a navigation log's velocity errors: hyperparameters and the effects' covariance functions."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TypeGuard

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array, Scalars
from missionplan.diagnosis.given import GivenEffect, held
from missionplan.diagnosis.inference.marginal_likelihood import Marginal, gaussian_log_density, gaussian_marginal
from missionplan.diagnosis.legs.likelihood.hyperparameters import (
    Hyperparameter,
    HyperparameterValues,
    slab_scale,
    values_of,
    wandering_scale,
)
from missionplan.diagnosis.legs.likelihood.linearised import LinearisedLegs, NoiseComponents, SelectedLegs
from missionplan.diagnosis.legs.likelihood.markov_covariance import LegSelection, MarkovCovariance
from missionplan.diagnosis.legs.likelihood.mean import TransitMean
from missionplan.diagnosis.legs.likelihood.modulation import STEADY, Forms
from missionplan.effects import CATALOGUE, EffectInfo
from missionplan.effects.oscillation import COHERENCE_TIME, MODULATION_PARAMETERS
from missionplan.phases.hooks import MarkovProcess, TransitEffect
from missionplan.results.learned.evidence import Causes

ALL_LEGS = slice(None)

SIGMA_LOG_SD = 0.7
"""Prior standard deviation of the logarithm of the velocity error's size, about the mission's."""
FIX_LOG_SD = 0.15
"""The same for a fix error that data set or mission states: one that is worse is no calibration but `fix-error`."""
LONGEST = 3.0
"""Longest time of persistence, over the record's: two errors a record apart are then alike to 0.72, and beyond that the
record shows a mean."""
FIX_UNSTATED = (3.0, 0.7)
"""Prior median [m] and log-sd of the fix error where neither data set nor mission states one."""


@dataclass(frozen=True)
class TransitCovariance(TransitMean):
    """The legs with the covariance of their errors, and the likelihood at given hyperparameters."""

    def hyperparameters(self, causes: Causes, forms: Forms = STEADY) -> tuple[Hyperparameter, ...]:
        """Hyperparameters under a set of causes."""
        sigma = math.sqrt(max(0.5 * float(np.trace(self.covariance)), 1e-6))
        stated = self.data.typical_fix_sd or self.fix_error
        fix, spread = (stated, FIX_LOG_SD) if stated > 0.0 else FIX_UNSTATED
        hyperparameters = [
            Hyperparameter("", "sigma_v", math.log(sigma), SIGMA_LOG_SD),
            Hyperparameter("", "fix_sd", math.log(fix), spread),
        ]
        for info in (CATALOGUE[name] for name in causes):
            if info.id in forms.wandering:
                hyperparameters += [wandering_scale(info.id), *_of_shapes(info, (COHERENCE_TIME,))]
            elif info.part == "mean":
                hyperparameters.append(slab_scale(info.id))
            else:
                hyperparameters += self._random(info)
        priors = held(self.given_in_covariance, causes)
        mission_effects = {prior.effect for prior in priors}
        for name in forms.modulated:
            hyperparameters += _of_shapes(CATALOGUE[name], MODULATION_PARAMETERS) if name not in mission_effects else []
        for prior in priors:
            laws = zip(prior.coordinates, prior.mean, np.sqrt(np.diag(prior.here)), strict=True)
            hyperparameters += [Hyperparameter(c.effect, c.name, float(centre), float(sd)) for c, centre, sd in laws]
        return tuple(hyperparameters)

    def _random(self, info: EffectInfo) -> list[Hyperparameter]:
        """Sizes and times of a random cause: what persists for much longer than the record is a mean over it."""
        hyperparameters = _of_shapes(info, info.parameters)
        if not isinstance(info.make({}), MarkovProcess):
            return hyperparameters
        ceiling = math.log(LONGEST * max(float(np.ptp(self.data.middle)), 1.0))
        return [replace(h, ceiling=ceiling) if info.parameters[h.name].unit == "s" else h for h in hyperparameters]

    @cached_property
    def given_in_covariance(self) -> tuple[GivenEffect, ...]:
        """The mission's own random effects, and the modulation of its oscillations."""
        priors = []
        for prior in self.given:
            if CATALOGUE[prior.effect].part == "covariance":
                priors.append(prior)
            elif CATALOGUE[prior.effect].is_modulated and (part := prior.only(MODULATION_PARAMETERS)).coordinates:
                priors.append(part)
        return tuple(priors)

    @cached_property
    def _shares_fix(self) -> NDArray[np.bool_]:
        """Whether each leg starts from the same fix with which the previous one ended, shape (n,)."""
        data = self.data
        shared = np.all(data.end[:, :-1] == data.start[:, 1:], axis=0) & (data.run[:-1] == data.run[1:])
        return np.append(False, shared)

    def markov_covariance(self, rows: LegSelection = ALL_LEGS) -> MarkovCovariance:
        """Covariance between some of the legs, in banded form."""
        data, legs = self.data, np.arange(self.data.n)[rows]
        begins = np.array([data.t_start[data.run == run].min() for run in np.unique(data.run)])
        since = data.t_start[legs] - begins[np.searchsorted(np.unique(data.run), data.run[legs])]
        same_run = data.run[legs[1:]] == data.run[legs[:-1]]
        between = data.t_start[legs[1:]] - (data.t_start + data.under_way)[legs[:-1]]
        elapsed = np.append(np.nan, np.where(same_run, between, np.nan))
        in_common = np.where(np.append(False, np.diff(legs) == 1), self._fix_correlation[legs], 0.0)
        start, end = self._fix_scales
        return MarkovCovariance(data.under_way[legs], since, elapsed, in_common, start[legs], end[legs])

    @cached_property
    def _fix_correlation(self) -> Array:
        """Correlation of the error of the fix before each leg with that after the previous one, gaps known, (n,)."""
        of_gaps = self.fix_share / (1.0 - self.fix_share) if self.fix_share else 0.0
        return np.where(self._shares_fix, 1.0, of_gaps * self.gaps.is_gap if self.fix_share else 0.0)

    @cached_property
    def _fix_scales(self) -> tuple[Array, Array]:
        """Standard deviation of the fix before and after each leg over the typical one, shape (n,) each.

        The log states that of the fix after; the one before is the same fix where they share it, else a typical one.
        Less what a gap between them tells.
        """
        end = self.data.fix_scale
        start = np.where(self._shares_fix, np.append(1.0, end[:-1]), 1.0)
        if not self.fix_share:
            return start, end
        left = math.sqrt(1.0 - self.fix_share)
        return np.where(self.gaps.is_gap, left * start, start), np.where(self.gaps.after, left * end, end)

    @cached_property
    def _all_legs(self) -> MarkovCovariance:
        return self.markov_covariance()

    @cached_property
    def _anisotropy(self) -> Array:
        """Variance of the velocity error on each principal axis over their mean, shape (2,)."""
        shape = np.linalg.eigvalsh(self.covariance) if np.any(self.covariance) else np.ones(2)
        return np.asarray(np.maximum(shape / max(shape.mean(), 1e-12), 1e-6))

    def noise_components(self, values: HyperparameterValues) -> NoiseComponents:
        """Parts of the errors' covariance at given hyperparameters."""
        white = values["", "sigma_v"] ** 2 * self._anisotropy
        effects = _covariance_effects(values)
        extra = sum(float(effect.fix_variance()) for effect in effects)
        process = next(filter(_is_process, effects), None)
        dof = min((float(effect.tail_dof()) for effect in effects), default=math.inf)
        walk = sum(float(effect.position_variance_rate()) for effect in effects)
        return NoiseComponents(white, walk, math.hypot(values["", "fix_sd"], math.sqrt(extra)), process, dof)

    def noise(self, values: HyperparameterValues) -> Array:
        """Covariance of the velocity errors, causes of the mean apart, on each axis, shape (2, n, n) [m²/s²]."""
        parts, legs = self.noise_components(values), self._all_legs
        return legs.dense(parts.independent(legs.under_way), parts.fix_sd, parts.process)

    def marginal(
        self,
        hyperparameters: Sequence[Hyperparameter],
        logarithms: Array,
        linear: LinearisedLegs,
        rows: LegSelection = ALL_LEGS,
    ) -> Marginal:
        """Log density of some of the legs with the coefficients of the mean integrated out.

        Under an effect with heavy tails a leg's error is bivariate Student-t (Lange, Little & Taylor 1989), independent
        of the others'. Raises numpy.linalg.LinAlgError when the hyperparameters give no covariance.
        """
        values, selected = values_of(hyperparameters, logarithms), self.selected(linear, rows)
        prior_sd, noise = linear.prior_sd(values), self.noise_components(values)
        if not math.isinf(noise.dof):
            return selected.student(noise, prior_sd)
        gram, log_determinant = selected.gram(noise)
        return gaussian_marginal(gram, prior_sd, log_determinant, selected.joined[:, :, 0].size)

    def log_density(
        self,
        hyperparameters: Sequence[Hyperparameter],
        logarithms: Array,
        selected: SelectedLegs,
    ) -> float:
        """Log density of `marginal` for legs that are selected already, without the coefficients' posterior."""
        values = values_of(hyperparameters, logarithms)
        prior_sd, noise = selected.linear.prior_sd(values), self.noise_components(values)
        if not math.isinf(noise.dof):
            return selected.student(noise, prior_sd).log_density
        gram, log_determinant = selected.gram(noise)
        return gaussian_log_density(gram, prior_sd, log_determinant, selected.joined[:, :, 0].size)

    def selected(self, linear: LinearisedLegs, rows: LegSelection = ALL_LEGS) -> SelectedLegs:
        """Select legs of a linearised log, for likelihoods at many hyperparameters."""
        legs = self._all_legs if rows is ALL_LEGS else self.markov_covariance(rows)
        return SelectedLegs(linear, legs, linear.joined[:, rows])


def _of_shapes(info: EffectInfo, names: Iterable[str]) -> list[Hyperparameter]:
    """Parameters of a cause that are sizes or times, under the catalogue's priors."""
    parameters = ((name, info.parameters[name]) for name in names)
    return [
        Hyperparameter(
            info.id,
            name,
            math.log(p.median),
            math.log(p.factor),
            "reciprocal" if p.reciprocal_is_uniform else "student",
        )
        for name, p in parameters
    ]


def _covariance_effects(values: HyperparameterValues) -> list[TransitEffect]:
    """Effects of the catalogue at the values of their hyperparameters."""
    parameters: dict[str, dict[str, Scalars]] = {}
    for (effect, name), value in values.items():
        if effect and CATALOGUE[effect].part == "covariance":
            parameters.setdefault(effect, {})[name] = value
    made = (CATALOGUE[effect].make(arguments) for effect, arguments in parameters.items())
    return [effect for effect in made if isinstance(effect, TransitEffect)]


def _is_process(effect: TransitEffect) -> TypeGuard[MarkovProcess]:
    """Tell by its class, once for each: to check a protocol's members takes as long as a small likelihood."""
    kind = type(effect)
    if kind not in _is_of_process:
        _is_of_process[kind] = isinstance(effect, MarkovProcess)
    return _is_of_process[kind]


_is_of_process: dict[type[TransitEffect], bool] = {}
