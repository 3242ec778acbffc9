"""The error of a forecast: its covariance in time and space against theory, over many trials."""

from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import kurtosis

from missionplan.phases.currents import Span, layers
from missionplan.phases.ensemble import NORMALS, WAVES, Ensemble, ErringCurrent, ErrorWaves, Statistics

TRIALS = 40_000
SIGMA, TIME, LENGTH = 0.12, 5400.0, 3000.0


@cache
def waves(length=LENGTH, sigma=SIGMA, trials=TRIALS, seed=1):
    normals = np.random.default_rng(seed).normal(size=(NORMALS, WAVES, trials))
    return ErrorWaves.drawn(Statistics(sigma, TIME, length), normals)


@pytest.mark.parametrize(
    ("elapsed", "away"),
    [
        (0.0, (0.0, 0.0)),
        (600.0, (0.0, 0.0)),
        (9000.0, (0.0, 0.0)),
        (0.0, (800.0, 600.0)),
        (0.0, (-4000.0, 3000.0)),
        (3000.0, (0.0, 2000.0)),
    ],
)
def test_its_covariance_is_exponential_in_time_and_space(elapsed, away):
    error = waves()
    here = np.full((2, 1), 700.0)
    first = error.at(1e4, here)
    second = error.at(1e4 + elapsed, here + np.array(away)[:, None])
    theory = SIGMA**2 * np.exp(-elapsed / TIME - np.hypot(*away) / LENGTH)
    for one, other in zip(first, second, strict=True):
        products = one * other
        assert products.mean() == pytest.approx(theory, abs=4.5 * products.std() / np.sqrt(TRIALS))
    across = first[0] * second[1]
    assert across.mean() == pytest.approx(0.0, abs=4.5 * across.std() / np.sqrt(TRIALS)), "the axes are independent"


def test_each_value_is_normal():
    values = waves().at(500.0, np.zeros((2, 1)))[0]
    assert values.std() == pytest.approx(SIGMA, rel=0.015)
    assert kurtosis(values) == pytest.approx(0.0, abs=0.1)


@pytest.mark.parametrize(("duration", "tails"), [(900.0, 0.15), (5400.0, 0.35), (54_000.0, 2.0)])
def test_its_mean_over_a_leg_has_the_variance_of_the_integrated_process(duration, tails):
    """Ornstein-Uhlenbeck: 2σ²(τ/T)²(T/τ − 1 + exp(−T/τ)), with 1/τ + U/L along a track at speed U."""
    speed = 1.2
    kept = 1.0 / (1.0 / TIME + speed / LENGTH)
    track = np.array([[speed * duration], [0.0]])
    mean = waves().mean(2000.0, duration, np.zeros((2, 1)), track)
    ratio = duration / kept
    theory = 2.0 * SIGMA**2 / ratio**2 * (ratio - 1.0 + np.exp(-ratio))
    assert mean.var(axis=1) == pytest.approx(theory, rel=0.05)
    assert np.abs(kurtosis(mean, axis=1)).max() < tails, "sums over thirty lengths of memory have heavier tails"


def test_the_mean_is_that_of_the_values_along_the_track():
    error = waves(trials=20)
    start, track = np.array([[100.0], [-50.0]]), np.array([[2000.0], [900.0]])
    shares = (np.arange(4000) + 0.5) / 4000
    along = np.mean([error.at(300.0 + share * 1800.0, start + share * track) for share in shares], axis=0)
    assert error.mean(300.0, 1800.0, start, track) == pytest.approx(along, abs=2e-4)


def test_without_a_length_it_is_the_same_everywhere():
    error = waves(length=None, trials=5)
    assert error.at(100.0, np.zeros((2, 1))).tolist() == error.at(100.0, np.full((2, 1), 1e6)).tolist()


def test_it_is_added_to_the_forecast_for_the_trials_that_are_left():
    current = ErringCurrent(layers([10.0], [0.3], [0.0]), waves(trials=6))
    place = np.arange(12.0).reshape(2, 6) * 300.0
    whole = current.velocity(50.0, 2.0, place)
    assert whole - current.error.at(50.0, place) == pytest.approx(np.array([[0.0], [0.3]]) + np.zeros((2, 6)))
    kept = np.array([4, 1])
    assert current.take(kept).velocity(50.0, 2.0, place[:, kept]) == pytest.approx(whole[:, kept])


def test_on_a_leg_it_is_met_where_the_forecast_carries_the_vehicle_too():
    """1 km through the water and 1 km with the current to the north-east: by small steps along the way over ground."""
    error, duration = waves(length=800.0, trials=20), 2000.0
    start, through, forecast = (
        np.array([[300.0], [-200.0]]),
        np.array([[1000.0], [0.0]]),
        layers([np.inf], [0.5], [np.pi / 4.0]),
    )
    over_ground = through + 0.5 * duration * np.sqrt(0.5)
    shares = (np.arange(400) + 0.5) / 400.0
    steps = np.mean([error.at(1e4 + share * duration, start + share * over_ground) for share in shares], axis=0)
    found = ErringCurrent(forecast, error).mean_velocity(1e4, duration, 2.0, start, through)
    assert found == pytest.approx(0.5 * np.sqrt(0.5) + steps, abs=2e-4)


def test_one_wave_by_hand_at_a_place_and_along_a_track():
    """0.1 rad/s, 0.01 and 0.02 rad/m: phase 1 at 5 s; along a track from 1 to 3, so 2 times sin(1) over 1."""
    wave = ErrorWaves(
        *(np.array(each) for each in ([[0.1]], [[[0.01]], [[0.02]]], [[[2.0]], [[0.0]]], [[[0.0]], [[3.0]]]))
    )
    here, through = np.array([[10.0], [20.0]]), np.array([[40.0], [30.0]])
    assert wave.at(5.0, here)[:, 0] == pytest.approx([2.0 * np.cos(1.0), 3.0 * np.sin(1.0)])
    mean = wave.mean(5.0, 10.0, here, through)[:, 0]
    assert mean == pytest.approx(np.sin(1.0) * np.array([2.0 * np.cos(2.0), 3.0 * np.sin(2.0)]))


def test_members_are_good_where_all_are_and_weigh_what_they_are_given():
    members = [
        SimpleNamespace(
            **{"time": np.array([begin, end]), "depths_covered": depths, "steady_for": steady},
            velocity=lambda *_, speed=speed: np.array([[speed], [0.0]]),
            covers=lambda span, begin=begin, end=end: np.array([begin <= span.start and span.end <= end]),
        )
        for begin, end, depths, steady, speed in (
            (0.0, 90.0, (0.0, 30.0), 600.0, 1.0),
            (10.0, 100.0, (2.0, 40.0), 300.0, 5.0),
        )
    ]
    both = Ensemble.of(members, ("a", "b"), (1.0, 3.0))
    assert (both.time.tolist(), both.depths_covered, both.steady_for) == ([10.0, 90.0], (2.0, 30.0), 300.0)
    assert both.velocity(0.0, 0.0, np.zeros((2, 1))).tolist() == [[4.0], [0.0]]
    covered = [
        both.covers(Span(start, end, 5.0, ())).tolist() for start, end in ((5.0, 80.0), (20.0, 80.0), (20.0, 95.0))
    ]
    assert covered == [[False], [True], [False]]
    assert both.drawn(np.array([-0.7, -0.6, 0.0])).chosen.tolist() == [0, 1, 1]  # a quarter lies below -0.674
