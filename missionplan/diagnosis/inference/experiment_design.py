"""Next measurement: the cheapest on a menu that would tell two sets of causes apart (T-optimality)."""

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial

from missionplan.diagnosis.inference.model import CauseFit, Model
from missionplan.montecarlo.parallel_map import parallel_map
from missionplan.results.diagnosis import Causes

ENOUGH = 5.0
"""Expected nats at which two sets count as told apart."""
HARDLY = 1.0
"""Expected nats of the data in hand below which two sets cannot be told apart by them."""


@dataclass(frozen=True)
class DirectMeasurement:
    """An instrument that sees one effect by itself.

    Attributes
    ----------
    what : str
        In words.
    parameter : str
        What it measures.
    sd : float
        How well, in the parameter's unit.
    """

    what: str
    parameter: str
    sd: float


DIRECT = {
    "depth-scale": DirectMeasurement("readings at two known depths (a lead line)", "fraction", 0.005),
    "clock-offset": DirectMeasurement("the separation heard or filmed against the log's clock", "time", 0.05),
    "sensor-lag": DirectMeasurement("a dip of the sensor by hand, sampled fast", "time", 0.05),
    "stratification": DirectMeasurement("a density profile (CTD) at the place of the dives", "lift", 0.15),
    "vertical-current": DirectMeasurement("a current profiler beside the dives", "speed", 0.02),
    "compass-bias": DirectMeasurement("a swing of the compass on land, all round", "angle", 0.009),
    "compass-deviation": DirectMeasurement("a swing of the compass on land, all round", "amplitude", 0.009),
    "fix-error": DirectMeasurement("an hour of fixes with the vehicle at a known place in the water", "sd", 3.0),
}


@dataclass(frozen=True)
class ProposedMeasurement:
    """A measurement and what it is expected to bring."""

    first: Causes
    second: Causes
    measurement: str
    expected_log_bayes_factor: float


@dataclass(frozen=True)
class Discrimination:
    """A rival of the first set: what would separate it, and whether data like those in hand cannot."""

    discrimination: ProposedMeasurement
    alike: bool


def discriminations(
    model: Model, first: CauseFit, others: Sequence[CauseFit], jobs: int = 1
) -> tuple[Discrimination, ...]:
    """For each rival, the cheapest measurement that separates it from the first set, else the best there is.

    Alike are sets that data like those in hand would not tell apart: expected ln Bayes factor below 1 nat.
    """
    asked = [(other, alike) for other in others for alike in (False, True)]
    found = parallel_map(partial(_answers, model, first), asked, jobs=jobs)
    return tuple(
        Discrimination(cheapest, in_hand.expected_log_bayes_factor < HARDLY)
        for cheapest, in_hand in zip(found[::2], found[1::2], strict=True)
    )


def _answers(model: Model, first: CauseFit, asked: Sequence[tuple[CauseFit, bool]]) -> list[ProposedMeasurement]:
    """For each other set, what separates it from the first: the data in hand, or the cheapest measurement."""
    return [_in_hand(model, first, other) if alike else _cheapest(model, first, other) for other, alike in asked]


def _in_hand(model: Model, first: CauseFit, second: CauseFit) -> ProposedMeasurement:
    return ProposedMeasurement(
        first.causes, second.causes, "data like those in hand", model.discrimination(first, second, None)
    )


def _cheapest(model: Model, first: CauseFit, second: CauseFit) -> ProposedMeasurement:
    best = ProposedMeasurement(first.causes, second.causes, "none on the menu tells them apart", 0.0)
    for what, bring in itertools.chain(_with_more_data(model, first, second), _direct(first, second)):
        if bring > best.expected_log_bayes_factor:
            best = ProposedMeasurement(first.causes, second.causes, what, bring)
        if bring >= ENOUGH:
            break
    return best


def _with_more_data(model: Model, first: CauseFit, second: CauseFit) -> Iterator[tuple[str, float]]:
    """Give what each entry of the menu would bring, reckoned only when it is asked for."""
    return ((what, model.discrimination(first, second, index)) for index, what in enumerate(model.designs))


def _direct(first: CauseFit, second: CauseFit) -> list[tuple[str, float]]:
    """Instruments that see an effect which only one of the sets has."""
    found = []
    for fit, other in ((first, second), (second, first)):
        for estimate in fit.estimates:
            known = DIRECT.get(estimate.effect)
            if known and known.parameter == estimate.name and estimate.effect not in other.causes:
                found.append((known.what, 0.5 * (estimate.value / known.sd) ** 2))
    return found
