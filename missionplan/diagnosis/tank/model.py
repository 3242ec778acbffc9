"""Model of tank data: fits of sets of causes, what they leave, and how well they predict data held out or to come."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import logsumexp

from missionplan.arrays import Array
from missionplan.diagnosis.inference.axes import Axis, pointwise, scaled
from missionplan.diagnosis.inference.block_covariance import BlockCovariance, InnerProducts
from missionplan.diagnosis.inference.discrepancy import Residuals, Responses
from missionplan.diagnosis.inference.evidence_approximations import SampledEvidence, sampled_evidence
from missionplan.diagnosis.inference.marginal_likelihood import LOG_2PI
from missionplan.diagnosis.inference.model import CauseFit, HeldOutScore
from missionplan.diagnosis.inference.prior import inside_range
from missionplan.diagnosis.inference.weighing import LinearisedModel, NeutralResponses
from missionplan.diagnosis.tank.fitting import LinearData, TankFitting, fitted_root

COVARIANCE_INFLATION = 9.0
"""Factor on the posterior covariance with which fitted coordinates enter the residuals: as good as unknown there."""
USUAL_SHARE = 0.2
"""Usual size of a smooth error, of the data's root mean square."""
SAME = 1e-9
"""Size of a combination of the coordinates, over the greatest, below which the data do not show it."""


@dataclass(frozen=True)
class TankModel(TankFitting, LinearisedModel):
    """Base model of a tank experiment and the effects that it may lack, bound to data."""

    alternatives: Sequence[frozenset[str]] = ()
    """Groups of effects of which a set holds at most one."""

    @property
    def untestable(self) -> Mapping[str, str]:
        """Effects that these data could not show, and why."""
        return self.forward.untestable

    def responses_beside(self, fits: Sequence[CauseFit]) -> NeutralResponses:
        """Return errors that are smooth along each axis, and what they add to the log evidence of each fit.

        In what a fit leaves, its coordinates as good as unknown, in the metric of the sensor's noise. Their usual size
        is that of the catalogue's effects.
        """
        size = USUAL_SHARE * float(np.sqrt(np.mean(self.forward.y**2)))
        axes = [replace(axis, size=size) for axis in self._axes]
        sensor = BlockCovariance.independent(self.forward.sd, np.zeros((len(self.forward.sd), 0)))
        responses = Responses.of(axes, sensor)
        gains = np.array([responses.log_gains(self._products(fit, responses.joined)) for fit in fits])
        return NeutralResponses([(axis.name, axis.description) for axis in axes], gains)

    def _products(self, fit: CauseFit, columns: Array) -> list[InnerProducts]:
        """Inner products of columns and residuals at each noise, beside all that the fit's coordinates could do."""
        state, sd = fit.state, self.forward.sd
        left, sizes, _ = np.linalg.svd(state.columns * state.prior_sd / sd[:, None], full_matrices=False)
        span = left[:, sizes > SAME * max(float(sizes.max(initial=0.0)), 1e-300)]
        both = np.concatenate([columns, state.residuals[:, None]], axis=1) / sd[:, None]
        free = both - span @ (span.T @ both)
        gram, count = free.T @ free, len(sd) - span.shape[1]
        noises = zip(self.noise_log_prior.tolist(), self.noise_factors.tolist(), strict=True)
        return [InnerProducts(prior, 2.0 * count * np.log(factor), gram / factor**2) for prior, factor in noises]

    def sampled_evidence(self, fit: CauseFit) -> SampledEvidence:
        """Evidence by importance sampling of nuisance parameters and causes with the model itself, not linearised."""
        state, sd = fit.state, self.forward.sd
        centre, prior = self.prior(fit.causes).centre, self.prior(fit.causes).of(state.active)
        log_weights = self.noise_log_prior - len(sd) * np.log(self.noise_factors)
        constant = -float(np.log(sd).sum()) - 0.5 * len(sd) * LOG_2PI

        def log_joint(at: Array) -> Array:
            settings = np.repeat(centre[:, None], len(at), axis=1)
            settings[state.active] = at.T
            residuals = (self.forward.y[:, None] - self.predict(fit.causes, settings)) / sd[:, None]
            quadratic = -0.5 * np.sum(residuals**2, axis=0)[:, None] / self.noise_factors**2
            density = prior.log_density(at) - prior.log_mass
            return np.asarray(logsumexp(quadratic + log_weights, axis=1) + constant + density)

        inside = inside_range(state.marginal.mean, state.marginal.covariance, *prior.bounds)
        return sampled_evidence(log_joint, inside.mean, inside.covariance)

    def residuals(self, fit: CauseFit) -> Residuals:
        """Residuals of a fit; its coordinates enter their covariance as good as unknown."""
        state, count = fit.state, len(fit.state.residuals)
        sd = state.factor * self.forward.sd
        root = fitted_root(state.columns, state.prior_sd, sd)
        covariance = BlockCovariance.independent(sd, np.sqrt(COVARIANCE_INFLATION) * root)
        # rows of a table are no series: only a record in time is tested for errors that follow one another
        series = np.zeros(count, dtype=int) if "time" in self.forward.axes else np.arange(count)
        return Residuals(state.residuals, covariance, series, self._axes, self.forward.groups)

    @property
    def _axes(self) -> list[Axis]:
        """Axes along which a discrepancy may be smooth."""
        return [
            pointwise(name, f"an error that changes with {name}", scaled(values))
            for name, values in self.forward.axes.items()
        ]

    def held_out(self, fits: Sequence[CauseFit]) -> list[list[HeldOutScore]]:
        """Predict each group from the others under several fits, linearised about each fit.

        Coordinates of effects that are no causes of a set are not estimated from the other groups
        (`LinearData.predicted`). Squared errors are of the model itself, with such effects at their prior means.
        """
        return [self._scores(fit) for fit in fits]

    def _scores(self, fit: CauseFit) -> list[HeldOutScore]:
        state, forward, active = fit.state, self.forward, fit.state.active
        shared = np.array([index < self.fixed or self.is_of(fit.causes, int(index)) for index in active], dtype=bool)
        centre = self.prior(fit.causes).centre
        y = state.residuals + state.columns @ (state.at - centre)[active]
        noise = state.factor * forward.sd
        predicted = LinearData(y, noise, state.columns, state.prior_sd, shared, forward.groups).predicted()
        settings = np.repeat(centre[:, None], len(predicted), axis=1)
        settings[active[shared]] += np.stack([group.estimated for group in predicted], axis=1)
        errors = forward.y[:, None] - self.predict(fit.causes, settings)
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
        """Expected ln Bayes factor of the first set over the second, with the data of a design or as measured."""
        forward = self.forward if entry is None else self.forward.designs[entry][1]
        expected = replace(self, forward=forward).predict(first.causes, first.state.at[:, None])[:, 0]
        noise_free = replace(forward, y=expected, sd=first.state.factor * self.forward.sd)
        planned = replace(self, forward=noise_free, noise_known=True)
        evidence = [
            fit.log_evidence if isinstance(fit, CauseFit) else -np.inf
            for fit in planned.fit_all([(fit.causes, (fit,)) for fit in (first, second)])
        ]
        return float(max(evidence[0] - evidence[1], 0.0))
