"""The made-up sea and the figures of its campaigns."""

import math

import numpy as np
import pytest

from .__main__ import slope, told
from .campaign import Campaign, done_about_vehicle, legs_of
from .sea import Truth, Vehicle, sail
from .voyage import Voyage, mean_minutes

CALM = Vehicle(speed=1.0, sigma=0.0, fix=0.0)


def test_a_leg_by_a_compass_that_is_off_ends_beside_where_it_was_reckoned() -> None:
    (row,) = sail(Truth(compass=np.radians(5.0)), CALM, np.zeros(1), np.array([1000.0]), 0.0, np.random.default_rng(1))
    reckoned, end = np.array(row[5:7], dtype=float), np.array(row[7:9], dtype=float)
    nuisances = 3.0 * (1000.0 * np.radians(0.15) + 0.004 * 1000.0)
    assert reckoned == pytest.approx([0.0, 1000.0])
    assert end == pytest.approx([1000.0 * math.sin(np.radians(5.0)), 1000.0 * math.cos(np.radians(5.0))], abs=nuisances)


def test_a_voyage_in_still_water_takes_its_legs_and_surfacings() -> None:
    """3 km in four legs of 800 m at most, there and back; the last is shorter."""
    found = mean_minutes(Truth(), CALM, Voyage(3000.0, 100.0, 60.0), 800.0, 50, np.random.default_rng(1))
    assert found == pytest.approx(2.0 * (3000.0 + 4 * 60.0) / 60.0, rel=0.02)


def test_the_legs_of_a_trial_are_read_from_its_mission() -> None:
    trial = {
        "phases": [
            {"transit": {"from": ["0 m", "0 m"], "to": ["0 m", "400 m"]}},
            {"transit": {"to": ["300 m", "400 m"]}},
        ]
    }
    courses, lengths = legs_of(trial)
    assert courses == pytest.approx([0.0, 0.5 * math.pi])
    assert lengths == pytest.approx([400.0, 300.0])


def test_figures_of_campaigns() -> None:
    assert slope([1.0, 2.0], [2.0, 4.0], [1, 2]) == pytest.approx((2.0, 0.0))
    assert slope([1.0] * 4, [0.0, 0.0, 2.0, 2.0], [1, 1, 2, 2])[1] == pytest.approx(2.0**-0.5)  # two groups, not four
    assert slope([1.0] * 4, [0.0, 0.0, 2.0, 2.0], [1, 2, 3, 4])[1] == pytest.approx(0.5)
    made = [Campaign(k, "nothing", "a box", True, 1.0, 1.0 + 0.1 * k, 2.0, 0.1, 1.0) for k in (-1, 1)]
    assert "slope 1.00" in told(made)
    assert "predicted 2.00, realised 1.00" in told(made)
    saying = [
        Campaign(k, "nothing", "a box", True, *[0.0] * 5, said=0.95, right=right) for k, right in enumerate((1, 1, 0))
    ]
    assert "said to settle with 0.95: 0.67 of 3 did" in told([*made, *saying])


def test_what_the_crew_does_is_what_the_likeliest_causes_ask_for_together() -> None:
    sets = [("compass-bias",), ("mean-current",), ()]
    assert done_about_vehicle(sets, np.array([0.4, 0.3, 0.3])) == frozenset()
    assert len(done_about_vehicle(sets, np.array([0.6, 0.2, 0.2]))) == 1
