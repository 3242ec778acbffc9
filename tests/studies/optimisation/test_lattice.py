"""What may be chosen, as a lattice: against a table of all combinations."""

import itertools

import numpy as np
import pytest

from missionplan.errors import InputError
from missionplan.results.decision import Axis
from missionplan.studies.optimisation import Lattice, _default_step

SPEED = Axis(("out.speed", "back.speed"), ("1 m/s", "2 m/s", "4 m/s"), ("1", "2", "4"), (1.0, 2.0, 4.0), "m/s")
ANCHOR = Axis(("vehicle",), ({"a": 1}, {"b": 2}, {"c": 3}, {"d": 4}), ("a", "b", "c", "d"))
HOLD = Axis(("moor.hold",), ("1 h",), ("1",), (1.0,), "h")
LATTICE = Lattice((SPEED, ANCHOR, HOLD))
POINTS = list(itertools.product(range(3), range(4), range(1)))


def test_numbers_run_through_all_combinations_the_last_axis_fastest():
    assert (LATTICE.shape, len(LATTICE)) == ((3, 4, 1), 12)
    assert [LATTICE.number(point) for point in POINTS] == list(range(12))
    for number, (speed, anchor, hold) in enumerate(POINTS):
        wanted = {
            "out.speed": SPEED.values[speed],
            "back.speed": SPEED.values[speed],
            "vehicle": ANCHOR.values[anchor],
            "moor.hold": HOLD.values[hold],
        }
        assert LATTICE[number] == LATTICE.values_at((speed, anchor, hold)) == wanted


def test_places_are_shares_of_a_range_and_names_are_one_apart():
    places, axes = LATTICE.places(POINTS)
    assert axes.tolist() == [0, 1, 1, 1, 1, 2]
    for (i, one), (j, other) in itertools.product(enumerate(POINTS), repeat=2):
        away = abs(SPEED.numbers[one[0]] - SPEED.numbers[other[0]]) / 3.0
        apart = float(one[1] != other[1])
        assert np.hypot(*(places[i] - places[j])[[0, 5]]) == pytest.approx(away)
        assert np.linalg.norm((places[i] - places[j])[1:5]) == pytest.approx(apart)
    assert (places[:, 0].min(), places[:, 0].max()) == (0.0, 1.0)


@pytest.mark.parametrize("point", POINTS)
def test_neighbours_are_a_step_away_in_one_axis_or_two_once_each(point):
    """A step along numbers, any other value where there are none."""
    near = [
        other
        for other in POINTS
        if other != point
        and abs(other[0] - point[0]) <= 1
        and sum(a != b for a, b in zip(point, other, strict=True)) <= 2
    ]
    found = list(LATTICE.neighbours(point))
    assert sorted(found) == sorted(near)
    alone = sum(sum(a != b for a, b in zip(point, other, strict=True)) == 1 for other in near)
    assert all(sum(a != b for a, b in zip(point, other, strict=True)) == 1 for other in found[:alone])


@pytest.mark.parametrize(
    ("low", "high", "step"),
    [
        ("1 m/s", "2 m/s", "0.025 m/s"),
        ("1 kn", "2 m/s", None),
        ("10", "50", "1"),
        ("-1 h", "1 h", "0.05 h"),
        ("0 min", "2 h", "0.05 h"),
    ],
)
def test_a_step_that_is_not_given_is_a_fortieth_of_the_range(low, high, step):
    step = step or f"{(2.0 - 1852.0 / 3600.0) / 40.0:.6g} m/s"
    assert _default_step("out.speed", low, high) == step


@pytest.mark.parametrize(
    ("name", "low", "high", "words"),
    [
        ("start", "04:00", "05:00", "without a step, expected one"),
        ("a", "2 m/s", "1 m/s", "expected `from` less than `to`"),
        ("a", "2", "2", "expected `from` less than `to`"),
        ("a", "x", "2", "without a step"),
        ("a", "1", "x", "without a step"),
        ("a", "1 kg", "2 m", "kg"),
    ],
)
def test_a_range_without_a_step_of_its_own_has_to_be_one(name, low, high, words):
    with pytest.raises(InputError, match=words):
        _default_step(name, low, high)
