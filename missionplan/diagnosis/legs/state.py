"""State of a fit to a navigation log, and what it says of the causes that are random."""

from dataclasses import dataclass

import numpy as np

from missionplan.arrays import Array
from missionplan.diagnosis.coordinates import SIGMA_V, Coordinate, JointPosterior, estimates
from missionplan.diagnosis.inference.evidence_approximations import Laplace
from missionplan.diagnosis.legs.likelihood.hyperparameters import Hyperparameter, values_of
from missionplan.diagnosis.legs.likelihood.linearised import LinearisedLegs
from missionplan.diagnosis.legs.likelihood.mean import ActingTerm
from missionplan.diagnosis.legs.likelihood.modulation import Forms
from missionplan.effects import CATALOGUE
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
        known = self.noise(effects)
        own = [i for i, coordinate in enumerate(known.coordinates) if coordinate.effect]
        return estimates([known.coordinates[i] for i in own], known.mean[own], known.covariance[np.ix_(own, own)])

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
