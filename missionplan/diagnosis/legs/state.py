"""State of a fit to a navigation log, and what it says of the causes that are random."""

from dataclasses import dataclass

import numpy as np

from missionplan.arrays import Array
from missionplan.diagnosis.coordinates import Coordinate, correlations, estimates
from missionplan.diagnosis.inference.laplace import Laplace
from missionplan.diagnosis.legs.likelihood.hyperparameters import Hyperparameter, values_of
from missionplan.diagnosis.legs.likelihood.linearised import LinearisedLegs
from missionplan.diagnosis.legs.likelihood.modulation import Forms
from missionplan.effects import CATALOGUE
from missionplan.montecarlo.draws import Correlation
from missionplan.results.learned.evidence import Causes, ParameterEstimate


@dataclass(frozen=True)
class TransitState:
    """State of a fit: Laplace approximation of the hyperparameters, and the coefficients at their mode.

    Attributes
    ----------
    forms : Forms
        Oscillations among the causes that are not steady.
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

    forms: Forms
    hyperparameters: tuple[Hyperparameter, ...]
    posterior: Laplace
    mean: Array
    covariance: Array
    linear: LinearisedLegs

    @property
    def values(self) -> dict[tuple[str, str], float]:
        """Hyperparameters at their mode."""
        return values_of(self.hyperparameters, self.posterior.mode)

    def estimates(self, effects: Causes) -> tuple[ParameterEstimate, ...]:
        """Estimates of the hyperparameters that are parameters of some effects."""
        return estimates(*self._posterior_of(effects))

    def correlations(self, effects: Causes) -> tuple[Correlation, ...]:
        """Correlations of these."""
        return correlations(*self._posterior_of(effects))

    def _posterior_of(self, effects: Causes) -> tuple[list[Coordinate], Array, Array]:
        """Coordinates of the hyperparameters of some effects, with the mean and the covariance of their posterior."""
        of_effects = enumerate(self.hyperparameters)
        chosen = [i for i, h in of_effects if h.effect in effects and h.name in CATALOGUE[h.effect].parameters]
        own = [self.hyperparameters[i] for i in chosen]
        shapes = [Coordinate(h.effect, h.name, "shape", h.centre, h.spread, 0.0) for h in own]
        return shapes, self.posterior.mode[chosen], self.posterior.covariance[np.ix_(chosen, chosen)]
