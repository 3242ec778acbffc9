"""The analytic expected transit, against closed forms, an independent Monte Carlo, and its own refinement."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import erfc

from missionplan.phases.transit import expectation
from missionplan.phases.transit.expectation import expected_transit
from missionplan.phases.transit.plan import LegTable

FIG8 = {"distance": 7408.0, "speed": 1.25, "arrival_radius": 50.0, "surfacing_time": 90.0}

# Independent high-precision values of the cost of FIG8, ± 0.0001: d_max/distance, then by sigma [m/s].
HIGH_PRECISION = {
    1.00: {0.015: 0.02736, 0.035: 0.04973, 0.055: 0.07200},
    0.92: {0.015: 0.01595, 0.035: 0.02036, 0.055: 0.03271},
    0.90: {0.015: 0.01578, 0.035: 0.02045, 0.055: 0.03233},
    0.47: {0.015: 0.03067, 0.035: 0.03223, 0.055: 0.03779},
    0.45: {0.015: 0.03056, 0.035: 0.03297, 0.055: 0.04066},
    0.30: {0.015: 0.04565, 0.035: 0.04757, 0.055: 0.05445},
}


def monte_carlo(distance, d_max, speed, arrival_radius, sigma, trials=20_000):
    """Distance run and surfacings of each trial, leg by leg in the plane."""
    rng = np.random.default_rng(8)
    position = np.zeros((2, trials))
    position[0] = distance
    run, surfacings = np.zeros(trials), np.zeros(trials)
    left = np.hypot(*position)
    while np.any(left > arrival_radius):
        longest = d_max(left) if isinstance(d_max, LegTable) else np.minimum(left, d_max)
        leg = np.where(left > arrival_radius, longest, 0.0)
        error = sigma * leg / speed * rng.standard_normal((2, trials))
        position += -position / left * leg + error
        run += leg
        surfacings += leg > 0
        left = np.hypot(*position)
    return run, surfacings


def fig8_cost(fraction, sigma):
    return expected_transit(d_max=fraction * FIG8["distance"], sigma=sigma, **FIG8).cost


@pytest.mark.parametrize("fraction", HIGH_PRECISION)
def test_cost_of_fig8(fraction):
    for sigma, cost in HIGH_PRECISION[fraction].items():
        assert fig8_cost(fraction, sigma) == pytest.approx(cost, abs=1e-4)


def test_paper_one_leg_and_minimum():
    assert fig8_cost(1.0, 0.035) == pytest.approx(0.050, abs=0.0005)
    fractions = np.linspace(0.8, 1.0, 41)
    costs = [fig8_cost(fraction, 0.035) for fraction in fractions]
    assert min(costs) == pytest.approx(0.0203, abs=0.0002)
    assert fractions[np.argmin(costs)] == pytest.approx(0.915, abs=0.01)


@pytest.mark.parametrize("sigma", [0.015, 0.035, 0.055])
@pytest.mark.parametrize("legs", [1, 2, 3, 4, 5])
def test_teeth_stand_at_one_over_a_where_errors_outgrow_the_circle(legs, sigma):
    """Just below 1/a, one more leg, a short and exact one, is planned: it pays if the a legs' error would miss."""
    change = fig8_cost(0.97 / legs, sigma) - fig8_cost(1.0 / legs, sigma)
    spread = sigma / FIG8["speed"] * FIG8["distance"] / np.sqrt(legs)
    if spread > 2.2 * FIG8["arrival_radius"]:
        assert change < 0
    elif legs > 1 and spread < 1.8 * FIG8["arrival_radius"]:
        assert change > 0


@pytest.mark.parametrize(
    ("d_max", "arrival_radius", "sigma"),
    [
        (950.0, 50.0, 0.03),  # nearly one leg
        (100.0, 20.0, 0.12),  # errors outgrow the arrival circle
        (300.0, 400.0, 0.10),  # d_max below the arrival radius
        (70.0, 50.0, 0.004),  # small errors, many legs
        (300.0, 50.0, 0.40),  # legs that may lead away
        (5000.0, 80.0, 0.40),  # d_max beyond the distance
        (30.0, 50.0, 0.60),  # large errors, short legs
    ],
)
def test_agrees_with_monte_carlo(d_max, arrival_radius, sigma):
    run, surfacings = monte_carlo(1000.0, d_max, 1.0, arrival_radius, sigma)
    transit = expected_transit(1000.0, d_max, 1.0, arrival_radius, sigma, 90.0)
    for sample, expected in [(run, transit.distance_run), (surfacings, transit.surfacings)]:
        standard_error = sample.std() / np.sqrt(len(sample))
        assert sample.mean() == pytest.approx(expected, abs=4 * standard_error + 1e-4 * expected)


@pytest.mark.parametrize(
    ("d_max", "surfacings", "run"), [(2000.0, 1, 1000.0), (1000.0, 1, 1000.0), (960.0, 1, 960.0), (300.0, 4, 1000.0)]
)
@pytest.mark.parametrize("sigma", [0.0, 1e-13])
def test_without_error_legs_are_counted(d_max, surfacings, run, sigma):
    transit = expected_transit(1000.0, d_max, 2.0, 50.0, sigma, 90.0)
    assert transit.surfacings == surfacings
    assert transit.distance_run == pytest.approx(run)
    assert transit.cost == pytest.approx((run + (surfacings - 1) * 180.0) / 1000.0 - 1.0)


def test_small_errors_approach_none():
    exact = expected_transit(d_max=1500.0, sigma=0.0, **FIG8).cost
    for sigma in (1e-4, 1e-6, 1e-8):
        assert expected_transit(d_max=1500.0, sigma=sigma, **FIG8).cost == pytest.approx(exact, abs=0.2 * sigma + 1e-7)


def test_one_leg_misses_with_rayleighs_probability():
    # Errors of a second leg, at most 300 m, are far smaller than the arrival circle: it never takes a third.
    distance, radius, scale = 5000.0, 50.0, 50.0
    transit = expected_transit(distance, distance, 1.0, radius, 0.01, 90.0)
    miss = np.exp(-0.5 * (radius / scale) ** 2)
    beyond = radius * miss + scale * np.sqrt(np.pi / 2) * erfc(radius / (scale * np.sqrt(2)))
    assert transit.surfacings == pytest.approx(1 + miss, abs=1e-6)
    assert transit.distance_run == pytest.approx(distance + beyond, rel=1e-7)
    assert transit.duration == pytest.approx(distance + beyond + 90.0 * (1 + miss), rel=1e-7)


def test_start_inside_the_arrival_circle():
    transit = expected_transit(40.0, 10.0, 1.0, 50.0, 0.1, 90.0)
    assert (transit.surfacings, transit.duration, transit.cost) == (0.0, 0.0, -1.0)


def test_refinement_changes_nothing(monkeypatch):
    cases = [(0.02, 0.015), (0.25, 0.015), (0.31, 0.035), (0.5, 0.055), (0.92, 0.055), (1.0, 0.3)]
    coarse = [fig8_cost(*case) for case in cases]
    monkeypatch.setattr(expectation, "PANEL_SCALES", 1.0)
    monkeypatch.setattr(expectation, "PANEL_RATIO", 0.2)
    np.testing.assert_allclose([fig8_cost(*case) for case in cases], coarse, atol=5e-6)


transits = st.fixed_dictionaries(
    {
        "distance": st.floats(200.0, 10_000.0),
        "speed": st.floats(0.5, 3.0),
        "arrival_radius": st.floats(20.0, 150.0),
        "sigma": st.floats(1e-3, 0.2),
        "surfacing_time": st.floats(0.0, 600.0),
    }
)


def in_other_units(transit, d_max, length, time):
    scaled = {
        "distance": transit["distance"] * length,
        "arrival_radius": transit["arrival_radius"] * length,
        "speed": transit["speed"] * length / time,
        "sigma": transit["sigma"] * length / time,
        "surfacing_time": transit["surfacing_time"] * time,
    }
    return expected_transit(d_max=d_max * length, **scaled).cost


@settings(max_examples=30)
@given(
    transit=transits,
    fraction=st.floats(0.1, 1.5),
    length=st.one_of(st.floats(0.1, 10.0), st.sampled_from([0.25, 2.0, 8.0])),
    time=st.one_of(st.floats(0.1, 10.0), st.sampled_from([0.5, 4.0])),
)
def test_cost_has_no_dimension(transit, fraction, length, time):
    """Powers of two change no digit; others may, by rounding, choose other panels, whose error is that of quadrature."""
    d_max = fraction * transit["distance"]
    cost = expected_transit(d_max=d_max, **transit).cost
    exact = math.frexp(length)[0] == math.frexp(time)[0] == 0.5
    tolerance = 1e-12 if exact else 1e-5 * (1.0 + cost)
    assert in_other_units(transit, d_max, length, time) == pytest.approx(cost, rel=1e-12, abs=tolerance)


@settings(max_examples=30)
@given(transit=transits, more=st.floats(1.01, 1.7))
def test_one_leg_costs_more_with_larger_errors_or_a_smaller_circle(transit, more):
    """With d_max ≥ distance J grows with d, so that by induction over legs it grows with σ and falls with r_x."""
    no_limit = 1e3 * transit["distance"]
    cost = expected_transit(d_max=no_limit, **transit).cost
    tolerance = 1e-5 * (1 + cost)
    noisier = transit | {"sigma": transit["sigma"] * more}
    wider = transit | {"arrival_radius": transit["arrival_radius"] * more}
    assert expected_transit(d_max=no_limit, **noisier).cost >= cost - tolerance
    assert expected_transit(d_max=no_limit, **wider).cost <= cost + tolerance


@settings(max_examples=30)
@given(transit=transits, fraction=st.floats(0.1, 1.5), more=st.floats(0.0, 300.0))
def test_cost_rises_with_the_surfacing_time_by_the_surfacings(transit, fraction, more):
    first = expected_transit(d_max=fraction * transit["distance"], **transit)
    later = transit | {"surfacing_time": transit["surfacing_time"] + more}
    second = expected_transit(d_max=fraction * transit["distance"], **later)
    assert second.surfacings == first.surfacings
    charged = max(first.surfacings - 1.0, 0.0) * more * transit["speed"] / transit["distance"]
    assert second.cost - first.cost == pytest.approx(charged, abs=1e-9)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"d_max": 0.0}, "d_max must be positive"),
        ({"distance": float("nan")}, "distance must be positive"),
        ({"sigma": -0.1}, "sigma must be finite and not negative"),
        ({"sigma": 1.0}, "too large compared with a speed"),
        ({"d_max": 1e-3}, "too short"),
        ({"d_max": 1e-3, "sigma": 0.0}, "too short"),
    ],
)
def test_arguments_out_of_range(change, message):
    with pytest.raises(ValueError, match=message):
        expected_transit(**{"d_max": 1000.0, "sigma": 0.035, **FIG8} | change)


@pytest.mark.parametrize("d_max", [400.0, 2500.0, 7000.0])
@pytest.mark.parametrize("sigma", [0.0, 0.035, 0.3])
def test_a_constant_table_is_a_fixed_d_max(d_max, sigma):
    table = LegTable(np.array([100.0, 3000.0]), np.array([d_max, d_max]))
    fixed = expected_transit(d_max=d_max, sigma=sigma, **FIG8).cost
    assert expected_transit(d_max=table, sigma=sigma, **FIG8).cost == pytest.approx(fixed, rel=2e-6, abs=5e-6)


def test_a_table_with_a_jump_agrees_with_monte_carlo():
    table = LegTable(np.array([20.0, 300.0, 301.0, 800.0]), np.array([15.0, 280.0, 150.0, 600.0]))
    run, surfacings = monte_carlo(1000.0, table, 1.0, 20.0, 0.05)
    transit = expected_transit(1000.0, table, 1.0, 20.0, 0.05, 90.0)
    assert run.mean() == pytest.approx(transit.distance_run, abs=4 * run.std() / np.sqrt(run.size))
    assert surfacings.mean() == pytest.approx(transit.surfacings, abs=4 * surfacings.std() / np.sqrt(run.size))
