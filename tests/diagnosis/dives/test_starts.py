"""Starting points of a fit: from fits of parts of the set, and afresh where a cause was fitted only alone."""

from types import SimpleNamespace
from typing import Any

import numpy as np

from missionplan.diagnosis.coordinates import coordinates_of
from missionplan.diagnosis.dives.fitting import INITIAL_STRENGTH, LATE_STARTS, SHAPE_SHIFTS, starting_points
from missionplan.diagnosis.inference.model import CauseFit
from missionplan.effects import effects_of
from missionplan.results.learned.evidence import Causes

COORDINATES = tuple(c for info in effects_of("descent") for c in coordinates_of(info))
NAMES = [coordinate.effect for coordinate in COORDINATES]
EXPECTED = np.array([coordinate.centre for coordinate in COORDINATES])
PAIR = ("slow-flooding", "stratification")


def fit(causes: Causes, value: float, *, possible: bool = True) -> CauseFit:
    """A fit with all its coordinates at one value."""
    at = np.full(len(COORDINATES), value)
    state: Any = SimpleNamespace(linear=SimpleNamespace(at=at))
    return CauseFit(causes, 0.0, (), {}, possible, state)


def own(start: np.ndarray, effect: str) -> list[float]:
    return [float(value) for value, name in zip(start, NAMES, strict=True) if name == effect]


def test_an_effect_with_a_shape_starts_afresh_at_several() -> None:
    found = starting_points(COORDINATES, EXPECTED, (), ("slow-flooding",), ())
    (strength, shape) = (c for c in COORDINATES if c.effect == "slow-flooding")
    assert [own(start, "slow-flooding") for start in found] == [
        [INITIAL_STRENGTH * strength.slab, shape.centre + shift * shape.slab] for shift in SHAPE_SHIFTS
    ]


def test_effects_without_a_shape_have_one_start_at_zero() -> None:
    (found,) = starting_points(COORDINATES, EXPECTED, (), ("drag-bias", "depth-scale"), ())
    assert np.array_equal(found, [coordinate.centre for coordinate in COORDINATES])


def test_a_cause_known_only_alone_starts_there_and_afresh_beside_its_parent() -> None:
    found = starting_points(COORDINATES, EXPECTED, (), PAIR, (fit(PAIR[:1], 3.0), fit(PAIR[1:], 4.0)))
    assert len(found) == 1 + len(SHAPE_SHIFTS)
    assert all(own(start, "slow-flooding") == [3.0, 3.0] for start in found)
    assert own(found[0], "stratification") == [4.0, 4.0, 4.0]
    assert all(own(start, "stratification") != [4.0, 4.0, 4.0] for start in found[1:])


def test_an_infeasible_fit_is_no_starting_point() -> None:
    alone = starting_points(COORDINATES, EXPECTED, (), PAIR, ())
    found = starting_points(
        COORDINATES, EXPECTED, (), PAIR, (fit(PAIR[:1], 3.0, possible=False), fit(PAIR[1:], 4.0, possible=False))
    )
    assert np.array_equal(alone, found)
    assert len(alone) == len(SHAPE_SHIFTS) ** 2


def test_a_set_that_was_fitted_is_the_only_start() -> None:
    (found,) = starting_points(COORDINATES, EXPECTED, (), PAIR, (fit(PAIR, 2.0),))
    assert own(found, "slow-flooding") + own(found, "stratification") == [2.0] * 5


def test_an_effect_of_the_mission_that_may_have_changed_starts_afresh_and_where_it_was() -> None:
    before = np.array([0.2, np.log(9.0)])
    expected = np.where(np.array(NAMES) == "slow-flooding", 7.0, EXPECTED)
    parent = fit((), 0.0)
    parent.state.linear.at[[i for i, name in enumerate(NAMES) if name == "slow-flooding"]] = before
    found = starting_points(COORDINATES, expected, ("slow-flooding",), ("slow-flooding",), (parent,))
    assert len(found) == 1 + len(SHAPE_SHIFTS)
    assert any(own(start, "slow-flooding") == before.tolist() for start in found)


def test_an_effect_that_delays_the_dive_also_starts_late() -> None:
    clock = [
        own(start, "clock-offset")[0] for start in starting_points(COORDINATES, EXPECTED, (), ("clock-offset",), ())
    ]
    assert clock == [0.0, *(0.5 * shift for shift in LATE_STARTS)]
    payout = [
        own(start, "line-payout")[0] for start in starting_points(COORDINATES, EXPECTED, (), ("line-payout",), ())
    ]
    assert min(payout) == 0.0 < max(payout)
