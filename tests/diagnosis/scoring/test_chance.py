"""What chance allows: the statistic against its published law, and missions whose σ is off by half."""

from pathlib import Path

import numpy as np
import pytest

import missionplan
from missionplan.diagnosis.scoring.yardsticks import anderson_darling, yardsticks
from tests.diagnosis.scoring.test_score_legs import Truth, made_legs, mission


def test_the_distance_has_its_published_law():
    """Anderson & Darling (1954): mean 1, and 2.492 is passed by one of twenty, 3.857 by one of a hundred."""
    found = anderson_darling(np.random.default_rng(3).uniform(size=(40_000, 80)))
    assert found.mean() == pytest.approx(1.0, abs=0.02)
    assert np.mean(found > 2.492) == pytest.approx(0.05, abs=0.005)
    assert np.mean(found > 3.857) == pytest.approx(0.01, abs=0.002)


def test_the_distance_of_three_values_by_hand():
    u = np.array([0.2, 0.5, 0.9])
    terms = [(2 * i - 1) * (np.log(u[i - 1]) + np.log(1.0 - u[3 - i])) for i in (1, 2, 3)]
    assert anderson_darling(u[None, ::-1])[0] == pytest.approx(-3.0 - sum(terms) / 3.0)


@pytest.mark.parametrize(("made", "stated"), [(0.03, 0.02), (0.02, 0.03)])
def test_a_sigma_off_by_half_is_found_in_sixty_legs(tmp_path: Path, made: float, stated: float):
    for seed in range(2):
        legs = made_legs(tmp_path / str(seed), Truth(sigma_v=made), 300 + seed, legs=60)
        found = missionplan.score(mission(stated), legs)
        assert not found.is_within_chance


def test_a_true_sigma_is_rarely_found_wrong(tmp_path: Path):
    """At most one of twenty in the long run: more than one of four in at most one of 70 such tests."""
    found = [
        missionplan.score(mission(0.02), made_legs(tmp_path / str(seed), Truth(sigma_v=0.02), 400 + seed, legs=60))
        for seed in range(4)
    ]
    assert sum(not each.is_within_chance for each in found) <= 1


def test_a_persistent_error_is_the_best_of_the_yardsticks_on_one():
    """An error that keeps 0.8 of itself from leg to leg, by its own recursion, seen through a little noise."""
    rng = np.random.default_rng(5)
    slow, values = np.zeros(2), []
    for _ in range(300):
        slow = 0.8 * slow + 0.6 * rng.standard_normal(2)
        values.append(slow + 0.2 * rng.standard_normal(2))
    found = yardsticks(values, lambda later, earlier: values[earlier], [np.ones(2)] * 300, 1.0)
    y = np.concatenate(values)
    error = {name: float(np.mean((y - point.mean) ** 2)) for name, point in found.items()}
    assert min(error, key=lambda name: error[name]) == "persistent"
    assert error["persistent"] < 0.95 * error["last_leg"]
    assert np.all(found["wider_sigma"].mean == 0.0)
    assert found["wider_sigma"].sd[-1] == pytest.approx(y.std(), rel=0.02)
