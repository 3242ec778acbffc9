"""The made-up sea and the figures of its campaigns."""

import math

import numpy as np
import pytest

from missionplan.diagnosis.next_trial.belief import to_do
from tests.calibration import truths
from tests.calibration.voyages import Truth as Off

from .__main__ import slope, told
from .campaign import HIDDEN, Campaign, done_about_vehicle, draw_causes, legs_of
from .sea import Truth, Vehicle, sail
from .voyage import Voyage, mean_loss

CALM = Vehicle(speed=1.0, sigma=0.0, fix=0.0)


def test_a_leg_by_a_compass_that_is_off_ends_beside_where_it_was_reckoned() -> None:
    (row,) = sail(Truth(compass=np.radians(5.0)), CALM, np.zeros(1), np.array([1000.0]), 0.0, np.random.default_rng(1))
    reckoned, end = np.array(row[5:7], dtype=float), np.array(row[7:9], dtype=float)
    nuisances = 3.0 * (1000.0 * np.radians(0.15) + 0.004 * 1000.0)
    assert reckoned == pytest.approx([0.0, 1000.0])
    assert end == pytest.approx([1000.0 * math.sin(np.radians(5.0)), 1000.0 * math.cos(np.radians(5.0))], abs=nuisances)


def test_a_voyage_in_still_water_takes_its_legs_and_surfacings() -> None:
    """3 km in four legs of 800 m at most, there and back; the last is shorter."""
    found = mean_loss(Off(), CALM, Voyage(3000.0, 100.0, 60.0), 800.0, 50, 1e6, np.random.default_rng(1))
    assert found == pytest.approx(2.0 * (3000.0 + 4 * 60.0) / 60.0, rel=0.02)


def test_a_current_that_nothing_stems_ends_no_voyage() -> None:
    torrent = Off(current=(lambda t, place: np.array([2.0, 0.0]),))
    assert mean_loss(torrent, CALM, Voyage(3000.0, 100.0, 60.0), 800.0, 2, 77.0, np.random.default_rng(1)) == 77.0


def test_many_vehicles_wander_as_one_does() -> None:
    """By the variance of the difference over 1000 s, of a walk and of an error that persists."""
    for name in ("random-walk", "persistent-error"):
        off = truths.truth((name,), np.random.default_rng(3), 50.0)
        rng, apart = np.random.default_rng(4), np.full(20_000, 1000.0)
        first = off.onward(rng, None, 0.0 * apart)  # type: ignore[misc]
        many = np.var(off.onward(rng, first, apart) - first)  # type: ignore[misc]
        one = np.var([np.diff(off.wander(rng, np.array([0.0, 1000.0]))) for _ in range(4000)])  # type: ignore[misc]
        assert many == pytest.approx(one, rel=0.08)


def test_truths_weigh_as_the_prior_has_them() -> None:
    sets, prior = truths.prior()
    drawn = [draw_causes(np.random.default_rng(seed)) for seed in range(3000)]
    for wanted in ((), ("compass-bias",), ("mean-current",)):
        share = sum(weight for causes, weight in drawn if causes == wanted) / len(drawn)
        assert share == pytest.approx(prior[sets.index(wanted)], rel=0.25)
    assert np.mean([bool(to_do(causes)) for causes, _ in drawn]) == pytest.approx(HIDDEN["vehicle"], abs=0.04)


def test_the_legs_of_a_trial_are_read_from_its_mission() -> None:
    trial = {
        "phases": [
            {"transit": {"from": ["0 m", "0 m"], "to": ["0 m", "400 m"], "speed": "1.1 m/s"}},
            {"transit": {"to": ["300 m", "400 m"], "speed": "0.77 m/s"}},
        ]
    }
    plan = legs_of(trial)
    assert plan.headings == pytest.approx([0.0, 0.5 * math.pi])
    assert plan.lengths == pytest.approx([400.0, 300.0])
    assert plan.speeds == pytest.approx([1.1, 0.77])


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
