"""What is believed after a diagnosis: the sets of causes that may hold, each with its parameters and its mission."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.diagnosis.coordinates import Coordinate
from missionplan.diagnosis.data_kind import DataKind
from missionplan.diagnosis.explanations import Weighed, possible_fits
from missionplan.diagnosis.extended_mission import extended_mission
from missionplan.diagnosis.hypotheses import Hypothesis
from missionplan.diagnosis.inference.model import CauseFit
from missionplan.diagnosis.next_trial.prediction import Explanation
from missionplan.diagnosis.pipeline import PipelineResult
from missionplan.mission import Mission
from missionplan.results.learned.evidence import Causes

EXPLANATIONS, NEGLIGIBLE = 5, 0.02
"""Sets of causes that are considered, at most, and the probability below which none is."""


@dataclass(frozen=True)
class Posterior:
    """What a fit says of all its model's coordinates."""

    places: NDArray[np.int_]
    """Those of the causes and of the mission's own effects: known from one record to the next, shape (k,)."""
    mean: Array
    """Shape (K,). Of all coordinates; of the others as the mission expects them."""
    covariance: Array
    """Of those in `places`, shape (k, k)."""


@dataclass(frozen=True)
class Believed:
    """What may hold: a set of causes beside what the mission knows."""

    causes: Causes
    """Effects of the mission's own explanation, where it is in doubt, and those found."""
    bound: DataKind
    """The data so far, bound to the mission under that explanation."""
    fit: CauseFit
    posterior: Posterior
    explanation: Explanation
    """Its probability, with mean and covariance of the parameters that stay."""
    coordinates: tuple[Coordinate, ...]
    """Of those parameters."""
    mission: Mission
    """Extended with these causes."""


Fits = list[tuple[Weighed, CauseFit, float]]
"""Explanations of the mission, fits beside them, and their probabilities."""


def likely_fits(explanations: Sequence[Weighed], found: PipelineResult) -> Fits:
    """Return the likeliest fits that may hold with probabilities that add up to 1, as the extended mission has them.

    Parameters
    ----------
    explanations : sequence of Weighed
        Of the mission, the likeliest first.
    found : PipelineResult
        With that one.
    """
    likely = possible_fits(explanations, found)[:EXPLANATIONS]
    total = sum(weight for *_, weight in likely)
    kept = [each for each in likely if each[2] > NEGLIGIBLE * total]
    total = sum(weight for *_, weight in kept)
    return [(one, fit, weight / total) for one, fit, weight in kept]


def believe(fits: Fits, posterior_of: Callable[[DataKind, CauseFit], Posterior], scale: float) -> tuple[Believed, ...]:
    """Join fits with their parameters and their missions.

    Parameters
    ----------
    fits : list
        With their probabilities.
    posterior_of : callable
        What a fit to data bound to a mission says of the parameters.
    scale : float
        Of the random errors; see `DataKind.carried`.

    Raises
    ------
    InputError
        When an extended mission is not valid.
    """
    found = []
    for one, fit, probability in fits:
        bound = one.bound
        posterior = posterior_of(bound, fit)
        explanation = Explanation(probability, posterior.mean[posterior.places], posterior.covariance)
        own = tuple(bound.model_coordinates[index] for index in posterior.places)
        causes = (*one.explained.causes, *fit.causes)
        carried, shown = bound.carried(fit, scale), tuple(each.effect for each in bound.given)
        data = bound.extended_mission(carried)
        known = replace(carried, posterior=carried.posterior.without(("",)))  # σ_v is drawn apart from the parameters
        held = Hypothesis(causes, 1.0, one.explained.mission, shown, known, data)
        mission = Mission.from_data(extended_mission([held]))
        found.append(Believed(causes, bound, fit, posterior, explanation, own, mission))
    return tuple(found)
