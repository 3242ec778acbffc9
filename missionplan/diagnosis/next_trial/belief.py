"""What is believed after a diagnosis: the sets of causes that may hold, each with its parameters and its mission."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.diagnosis.coordinates import Coordinate
from missionplan.diagnosis.inference.model import CauseFit
from missionplan.diagnosis.inference.trials.experiment import Explanation
from missionplan.diagnosis.judgement import Judgement
from missionplan.diagnosis.pipeline import PipelineResult
from missionplan.mission import Mission
from missionplan.results.evidence import Causes

EXPLANATIONS = 5
"""Sets of causes that are considered, at most."""


@dataclass(frozen=True)
class Posterior:
    """What a fit says of all its model's coordinates.

    Attributes
    ----------
    places : array of int, shape (k,)
        Those of the causes and of the mission's own effects: known from one record to the next.
    mean : array, shape (K,)
        Of all coordinates; of the others as the mission expects them.
    covariance : array, shape (k, k)
        Of those in `places`.
    """

    places: NDArray[np.int_]
    mean: Array
    covariance: Array


@dataclass(frozen=True)
class Believed:
    """A set of causes that may hold.

    Attributes
    ----------
    fit : CauseFit
    posterior : Posterior
    explanation : Explanation
        Its probability, with mean and covariance of the parameters that stay.
    coordinates : tuple of Coordinate
        Of those parameters.
    mission : Mission
        Extended with these causes.
    """

    fit: CauseFit
    posterior: Posterior
    explanation: Explanation
    coordinates: tuple[Coordinate, ...]
    mission: Mission

    @property
    def causes(self) -> Causes:
        """The set."""
        return self.fit.causes


def possible_fits(found: PipelineResult, judgement: Judgement) -> list[tuple[CauseFit, float]]:
    """Return the sets of the credible set and the rivals with their probabilities, which add up to 1.

    A set that the data cannot separate from the claimed one, however the evidence falls, counts as much as that.
    """
    fits = {candidate.causes: candidate.fit for candidate in found.selection.ranking}
    fits[()] = found.selection.base
    claimed = found.posterior.get(found.best.causes, 1.0)
    named = dict.fromkeys((*judgement.credible_set, *judgement.rivals))
    likely = [(fits[causes], found.posterior.get(causes, claimed)) for causes in named if causes in fits]
    likely = sorted(likely, key=lambda pair: -pair[1])[:EXPLANATIONS] or [(found.best, 1.0)]
    total = sum(probability for _, probability in likely)
    return [(fit, probability / total) for fit, probability in likely]


def believe(
    fits: Sequence[tuple[CauseFit, float]],
    coordinates: Sequence[Coordinate],
    posterior_of: Callable[[CauseFit], Posterior],
    extended: Callable[[CauseFit], Mapping[str, object]],
) -> tuple[Believed, ...]:
    """Join fits with their parameters and their missions.

    Parameters
    ----------
    fits : sequence
        Fits with their probabilities.
    coordinates : sequence of Coordinate
        All of the model.
    posterior_of, extended : callable
        What a fit says of them, and the mission's data extended with its causes.

    Raises
    ------
    InputError
        When an extended mission is not valid.
    """
    found = []
    for fit, probability in fits:
        posterior = posterior_of(fit)
        explanation = Explanation(probability, posterior.mean[posterior.places], posterior.covariance)
        own = tuple(coordinates[index] for index in posterior.places)
        found.append(Believed(fit, posterior, explanation, own, Mission.from_data(extended(fit))))
    return tuple(found)
