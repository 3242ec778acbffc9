"""The loop's own parts: the score, and a mission in a sea that is known."""

import numpy as np
import pytest

from . import sea
from .__main__ import figures, made, ranked_probability_score


def test_the_score_is_that_of_a_normal_distribution():
    """Gneiting & Raftery 2007, section 4.2: at the mean of a standard normal (√2 − 1)/√π."""
    trials = np.random.default_rng(1).standard_normal(20_000)
    assert ranked_probability_score(trials, 0.0) == pytest.approx((np.sqrt(2.0) - 1.0) / np.sqrt(np.pi), rel=0.03)
    assert ranked_probability_score(np.full(10, 3.0), 5.0) == pytest.approx(2.0)


def test_a_mission_in_still_water_takes_its_way_and_its_surfacings():
    still = sea.Sea(0.0, 0.0, np.zeros(2), np.zeros(2), 0.0)
    took = [sea.sailed(still, 0.0, np.array([0.0, 6000.0]), np.random.default_rng(k)) for k in range(200)]
    assert np.mean(took) == pytest.approx(6000.0 / sea.SPEED + 6.3 * sea.SURFACING, rel=0.02)
    slow = sea.Sea(0.0, -0.1, np.zeros(2), np.zeros(2), 0.0)
    slower = [sea.sailed(slow, 0.0, np.array([0.0, 6000.0]), np.random.default_rng(k)) for k in range(200)]
    assert np.mean(slower) / np.mean(took) == pytest.approx(1.0 / 0.9, rel=0.05)


@pytest.mark.slow
def test_the_next_mission_is_what_was_planned():
    found = [made(seed) for seed in range(400, 420)]
    within, half, *_, ratio = figures(found)
    assert within >= 0.75  # 20 draws of 0.9: below in one of 400
    assert half >= 0.2
    assert ratio < 0.9
