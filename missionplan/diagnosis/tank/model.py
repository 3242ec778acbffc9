"""Model of tank data: fits of sets of causes, what they leave, and how well they predict data held out or to come."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import logsumexp

from missionplan.arrays import Array
from missionplan.diagnosis.coordinates import has_shape
from missionplan.diagnosis.inference.adequacy.axes import pointwise, scaled
from missionplan.diagnosis.inference.adequacy.residuals import Residuals
from missionplan.diagnosis.inference.importance_sampling import SampledEvidence, sampled_evidence
from missionplan.diagnosis.inference.marginal_likelihood import LOG_2PI
from missionplan.diagnosis.inference.model import MINIMUM_EVIDENCE_GAIN, CauseFit, HeldOutScore
from missionplan.diagnosis.tank.fitting import TankFitting
from missionplan.diagnosis.tank.linearised import LinearData, fitted_root
from missionplan.results.learned.evidence import Causes

COVARIANCE_INFLATION = 9.0
"""Factor on the posterior covariance with which fitted coordinates enter the residuals: as good as unknown there."""


@dataclass(frozen=True)
class TankModel(TankFitting):
    """Base model of a tank experiment and the effects that it may lack, bound to data.

    Attributes
    ----------
    alternatives : sequence of frozenset of str
        Groups of effects of which a set holds at most one.
    """

    alternatives: Sequence[frozenset[str]] = ()

    @property
    def untestable(self) -> Mapping[str, str]:
        """Effects that these data could not show, and why."""
        return self.forward.untestable

    def minimum_evidence_gain(self, causes: Causes) -> float:
        """The default: the catalogue's effects are nearly linear in their strengths, and of known shape."""
        return MINIMUM_EVIDENCE_GAIN

    def may_be_multimodal(self, causes: Causes) -> bool:
        """Whether a cause has a shape parameter."""
        return has_shape(causes)

    def estimated_gain(self, causes: Causes, parent: CauseFit) -> float:
        """Unknown: all sets of a tank's few effects are fitted."""
        return float("inf")

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
            return np.asarray(logsumexp(quadratic + log_weights, axis=1) + constant + prior.log_density(at))

        return sampled_evidence(log_joint, state.marginal.mean, state.marginal.covariance)

    def residuals(self, fit: CauseFit) -> Residuals:
        """Residuals of a fit; its coordinates enter their covariance as good as unknown."""
        state, count = fit.state, len(fit.state.residuals)
        sd = state.factor * self.forward.sd
        known = fitted_root(state.columns, state.prior_sd, sd)
        covariance = np.diag(sd**2) + COVARIANCE_INFLATION * known @ known.T
        axes = [
            pointwise(name, f"an error that changes with {name}", scaled(values))
            for name, values in self.forward.axes.items()
        ]
        # rows of a table are no series: only a record in time is tested for errors that follow one another
        series = np.zeros(count, dtype=int) if "time" in self.forward.axes else np.arange(count)
        return Residuals(state.residuals, covariance, series, axes, self.forward.groups)

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
