"""What is believed after a diagnosis: the sets of causes that may hold, each with its parameters and its mission."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.diagnosis.coordinates import Coordinate
from missionplan.diagnosis.data_kind import DataKind
from missionplan.diagnosis.explanations import Weighed, possible_fits
from missionplan.diagnosis.extended_mission import Hypothesis, extended_mission
from missionplan.diagnosis.inference.model import CauseFit
from missionplan.diagnosis.next_trial.experiment import Draws
from missionplan.diagnosis.next_trial.prediction import Explanation
from missionplan.diagnosis.pipeline import PipelineResult
from missionplan.effects import CATALOGUE
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


def likely_fits(explanations: Sequence[Weighed], pipeline_result: PipelineResult) -> tuple[Fits, Fits]:
    """Return the likeliest fits that may hold with probabilities that add up to 1, and those that are left out.

    The probabilities of those are of all that may hold, as the extended mission has it.
    """
    possible = possible_fits(explanations, pipeline_result)
    likely = sum(weight for *_, weight in possible[:EXPLANATIONS])
    kept = [row for row in possible[:EXPLANATIONS] if row[2] > NEGLIGIBLE * likely]
    left = possible[len(kept) :]
    total, of_all = sum(weight for *_, weight in kept), sum(weight for *_, weight in possible)
    return (
        [(one, fit, weight / total) for one, fit, weight in kept],
        [(one, fit, weight / of_all) for one, fit, weight in left],
    )


def causes_of(one: Weighed, fit: CauseFit) -> Causes:
    """Return the effects of the mission's own explanation and those found."""
    return (*one.explained.causes, *fit.causes)


def believe(fits: Fits, posterior_of: Callable[[DataKind, CauseFit], Posterior], scale: float) -> tuple[Believed, ...]:
    """Join fits with their parameters and their missions.

    Raises InputError when an extended mission is not valid.

    `fits`: with their probabilities. `posterior_of`: what a fit to data bound to a mission says of the parameters.
    `scale`: of the random errors; see `DataKind.carried`.
    """
    beliefs = []
    for one, fit, probability in fits:
        bound = one.bound
        posterior = posterior_of(bound, fit)
        explanation = Explanation(probability, posterior.mean[posterior.places], posterior.covariance)
        coordinates = tuple(bound.model_coordinates[index] for index in posterior.places)
        causes = causes_of(one, fit)
        carried, shown = bound.carried(fit, scale), tuple(prior.effect for prior in bound.given)
        data = bound.extended_mission(carried)
        rest = replace(carried, posterior=carried.posterior.without(("",)))  # σ_v is drawn apart from the parameters
        hypothesis = Hypothesis(causes, 1.0, one.explained.mission, shown, rest, data)
        mission = Mission.from_data(extended_mission([hypothesis]))
        beliefs.append(Believed(causes, bound, fit, posterior, explanation, coordinates, mission))
    return tuple(beliefs)


def to_do(causes: Causes) -> frozenset[str]:
    """Return what causes ask of the crew: the remedies of what the vehicle has itself; of all else nothing."""
    infos = [CATALOGUE[cause] for cause in causes]
    vehicle_infos = [info for info in infos if info.belongs_to == "vehicle" and info.tier == "physical"]
    return frozenset(info.finding.remedy for info in vehicle_infos if info.finding is not None)


def right_about_vehicle(asked: Sequence[frozenset[str]], draws: Draws, probabilities: Array) -> float:
    """Return the probability that the crew does what is right about the vehicle, if it does the likeliest.

    `asked`: what each set of causes asks for; see `to_do`. `draws`: of what is true. `probabilities`, shape (n, s) or
    (s,): of the sets, as they are known then.
    """
    things = list(dict.fromkeys(asked))
    same = np.array([[remedies == thing for thing in things] for remedies in asked], dtype=float)
    done = np.broadcast_to(np.argmax(probabilities @ same, axis=-1), draws.weight.shape)
    return float(draws.weight @ same[draws.explanation, done])
