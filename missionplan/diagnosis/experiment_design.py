"""Next measurement: the cheapest design that discriminates between two sets of causes.

T-optimality (Atkinson & Fedorov 1975, *Biometrika* 62): with the first set taken as true, the value of a design is the
lack of fit of the second set to what the first predicts. Here lack of fit is the expected log Bayes factor.
"""

from collections.abc import Iterator, Sequence
from functools import partial

from missionplan.diagnosis.inference.model import CauseFit, Model
from missionplan.effects import CATALOGUE
from missionplan.montecarlo.blocks import parallel_map
from missionplan.results.learned.evidence import NextMeasurement

SUFFICIENT = 5.0
"""Expected nats from which a design discriminates well enough: no more expensive one is considered."""
INDISTINGUISHABLE_BELOW = 1.0
"""Expected nats of data like those in hand below which these cannot discriminate between two sets."""


def discriminations(
    model: Model, first: CauseFit, rivals: Sequence[CauseFit], jobs: int = 1
) -> list[tuple[NextMeasurement, bool]]:
    """Find the cheapest sufficient measurement that separates each rival from the first set, else the best there is.

    The first set is taken as true. With each comes whether data like those in hand cannot discriminate between the two.
    """
    asked = [(rival, in_hand) for rival in rivals for in_hand in (False, True)]
    measurements = parallel_map(partial(_measurements, model, first), asked, jobs=jobs)
    return [
        (cheapest, in_hand.expected_log_bayes_factor < INDISTINGUISHABLE_BELOW)
        for cheapest, in_hand in zip(measurements[::2], measurements[1::2], strict=True)
    ]


def _measurements(model: Model, first: CauseFit, asked: Sequence[tuple[CauseFit, bool]]) -> list[NextMeasurement]:
    """For each rival, the data in hand if asked for, else the cheapest measurement."""
    return [_in_hand(model, first, rival) if in_hand else _cheapest(model, first, rival) for rival, in_hand in asked]


def _in_hand(model: Model, first: CauseFit, rival: CauseFit) -> NextMeasurement:
    expected = model.discrimination(first, rival, None)
    return NextMeasurement((first.causes, rival.causes), "data like those in hand", expected)


def _cheapest(model: Model, first: CauseFit, rival: CauseFit) -> NextMeasurement:
    separates = (first.causes, rival.causes)
    best = NextMeasurement(separates, "no measurement considered separates them", 0.0)
    for description, expected in _designs(model, first, rival):
        if expected > best.expected_log_bayes_factor:
            best = NextMeasurement(separates, description, expected)
        if expected >= SUFFICIENT:
            break
    return best


def _designs(model: Model, first: CauseFit, rival: CauseFit) -> Iterator[tuple[str, float]]:
    """Designs, cheapest first, then instruments, with their expected log Bayes factor, computed when asked for."""
    for index, description in enumerate(model.designs):
        yield description, model.discrimination(first, rival, index)
    for fit, other in ((first, rival), (rival, first)):
        for estimate in fit.estimates:
            instrument = CATALOGUE[estimate.effect].instrument
            if instrument and instrument.parameter == estimate.name and estimate.effect not in other.causes:
                yield instrument.description, 0.5 * (estimate.value / instrument.sd) ** 2
