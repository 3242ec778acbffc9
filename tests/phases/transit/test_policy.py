"""The optimal legs: reference values, optimality against perturbations, Monte Carlo, and the table's form."""

from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from missionplan.phases.transit import policy
from missionplan.phases.transit.expectation import expected_transit
from missionplan.phases.transit.plan import LegTable
from missionplan.phases.transit.policy import TABLE_LOSS, best_d_max, best_legs, simplify_table

SURFACING = 90.0
SHORT = (2000.0, 1.0, 50.0, 0.08)
SHORTER = (300.0, 1.0, 50.0, 0.1)
JUMPS = (2000.0, 1.0, 10.0, 0.01)

# distance [m], speed [m/s], arrival radius [m], sigma [m/s]: best fixed d_max, best legs, both ± 0.0002.
CHECK_VALUES = {
    (7408.0, 1.25, 50.0, 0.035): (0.0203, 0.0178),
    (20000.0, 1.0, 50.0, 0.035): (0.0160, 0.0109),
    (7408.0, 1.25, 50.0, 0.055): (0.0327, 0.0276),
    (14816.0, 1.2, 10.0, 0.035): (0.0217, 0.0184),
}
FIG8 = next(iter(CHECK_VALUES))
CASES = [pytest.param(case, marks=[] if case == FIG8 else pytest.mark.slow, id=str(case)) for case in CHECK_VALUES]


@cache
def policy_of(case):
    return best_legs(*case, SURFACING)


@pytest.mark.parametrize("case", CASES)
def test_check_values(case):
    _, best = CHECK_VALUES[case]
    policy = policy_of(case)
    assert policy.bound == pytest.approx(best, abs=2e-4)
    assert policy.bound - 1e-6 <= policy.transit.cost <= policy.bound + TABLE_LOSS


@pytest.mark.parametrize("case", CASES)
def test_no_fixed_d_max_does_better(case):
    d_max, fixed = best_d_max(*case, SURFACING)
    assert 0.0 < d_max <= case[0]
    assert fixed.cost > policy_of(case).transit.cost + 0.002


def test_best_fixed_d_max_of_fig8():
    d_max, fixed = best_d_max(7408.0, 1.25, 50.0, 0.035, SURFACING)
    assert d_max / 7408.0 == pytest.approx(0.915, abs=0.01)
    assert fixed.cost == pytest.approx(0.0203, abs=2e-4)


@settings(max_examples=10)
@given(
    case=st.sampled_from([SHORT, (7408.0, 1.25, 50.0, 0.035)]),
    where=st.floats(0.0, 1.0),
    width=st.floats(0.02, 2.0),
    size=st.floats(-0.6, 0.6),
)
def test_no_perturbation_does_better(case, where, width, size):
    """A bump of the aim, of any place on a logarithmic axis, width and size relative to the distance or the leg."""
    distance, _, arrival_radius, _ = case
    policy = policy_of(case)
    left = np.geomspace(arrival_radius, distance, 60)
    centre = np.log(arrival_radius) + where * np.log(distance / arrival_radius)
    bump = np.exp(-0.5 * ((np.log(left) - centre) / width) ** 2)
    leg = np.maximum(policy.legs(left) * (1.0 + size * bump), 0.1)
    perturbed = expected_transit(case[0], LegTable(left, leg), *case[1:], SURFACING).cost
    assert perturbed >= policy.bound - TABLE_LOSS


@given(seed=st.integers(0, 2**32 - 1), size=st.floats(0.001, 0.3))
def test_no_random_table_does_better(seed, size):
    policy = policy_of(SHORT)
    noise = np.random.default_rng(seed).standard_normal(policy.legs.leg.size)
    perturbed = LegTable(policy.legs.left, policy.legs.leg * np.exp(size * noise))
    assert expected_transit(SHORT[0], perturbed, *SHORT[1:], SURFACING).cost >= policy.bound - TABLE_LOSS


@pytest.mark.parametrize("case", [SHORT, pytest.param((400.0, 1.0, 50.0, 0.25), marks=pytest.mark.slow)])
def test_agrees_with_monte_carlo(case):
    distance, speed, arrival_radius, sigma = case
    policy = policy_of(case)
    rng = np.random.default_rng(11)
    trials = 10_000
    position = np.zeros((2, trials))
    position[0] = distance
    left = np.hypot(*position)
    duration = np.zeros(trials)
    while np.any(left > arrival_radius):
        under_way = left > arrival_radius
        leg = np.where(under_way, policy.legs(left), 0.0)
        position += -position / left * leg + sigma * leg / speed * rng.standard_normal((2, trials))
        duration += leg / speed + SURFACING * under_way
        left = np.hypot(*position)
    assert duration.mean() == pytest.approx(policy.transit.duration, abs=3 * duration.std() / np.sqrt(trials))


@pytest.mark.parametrize("base_spread", [20.0, *(pytest.param(each, marks=pytest.mark.slow) for each in (10.0, 40.0))])
def test_a_spread_that_no_leg_escapes_agrees_with_monte_carlo(base_spread):
    distance, speed, arrival_radius, sigma = SHORTER
    policy = best_legs(*SHORTER, SURFACING, base_spread)
    rng = np.random.default_rng(12)
    trials = 15_000
    position = np.zeros((2, trials))
    position[0] = distance
    left = np.hypot(*position)
    duration = np.zeros(trials)
    while np.any(left > arrival_radius):
        under_way = left > arrival_radius
        leg = np.where(under_way, policy.legs(left), 0.0)
        scale = np.where(under_way, np.hypot(sigma * leg / speed, base_spread), 0.0)
        position += -position / np.maximum(left, 1.0) * leg + scale * rng.standard_normal((2, trials))
        duration += leg / speed + SURFACING * under_way
        left = np.hypot(*position)
    assert duration.mean() == pytest.approx(policy.transit.duration, abs=3 * duration.std() / np.sqrt(trials))
    _, fixed = best_d_max(*SHORTER, SURFACING, base_spread)
    assert policy.bound <= fixed.cost
    assert policy.bound > policy_of(SHORTER).bound


def test_refining_the_grid_changes_nothing(monkeypatch):
    case = (800.0, 1.0, 50.0, 0.06)
    coarse = best_legs(*case, SURFACING).bound
    monkeypatch.setattr(policy, "MAX_PANEL_WIDTH", 0.08)
    monkeypatch.setattr(policy, "CANDIDATES", 60)
    assert best_legs(*case, SURFACING).bound == pytest.approx(coarse, abs=1e-5)


def test_a_jump_is_two_knots_a_metre_apart():
    legs = policy_of(JUMPS).legs
    jump = np.argmin(np.diff(legs.leg))
    assert np.diff(legs.left)[jump] <= policy.JUMP
    assert legs.leg[jump] - legs.leg[jump + 1] > 50.0


def test_last_legs_end_just_inside_the_arrival_circle():
    """Where the error of a leg is small compared with the circle, the aim is as near its edge as that error allows."""
    _, speed, arrival_radius, sigma = case = (7408.0, 1.25, 50.0, 0.035)
    left = np.array([80.0, 150.0, 300.0])
    leg = policy_of(case).legs(left)
    margin = (arrival_radius - (left - leg)) / (sigma / speed * leg)
    assert np.all((margin > 1.5) & (margin < 4.0))


@pytest.mark.parametrize("scale", [pytest.param(0.1, marks=pytest.mark.slow), 7.0])
def test_costs_have_no_dimension(scale):
    distance, speed, arrival_radius, sigma = SHORTER
    scaled = best_legs(distance * scale, speed, arrival_radius * scale, sigma, SURFACING * scale)
    assert scaled.transit.cost == pytest.approx(policy_of(SHORTER).transit.cost, abs=2e-5)


def test_without_error_one_leg_just_enters_the_circle():
    policy = best_legs(7408.0, 1.25, 50.0, 0.0, SURFACING)
    assert policy.transit.surfacings == 1.0
    assert policy.transit.cost == pytest.approx(-50.0 / 7408.0, abs=5e-5)


def test_a_start_just_outside_the_circle():
    policy = best_legs(60.0, 1.25, 50.0, 0.035, SURFACING)
    assert policy.transit.surfacings == pytest.approx(1.0, abs=0.02)
    assert 10.0 < policy.transit.distance_run < 12.0


@pytest.mark.parametrize("change", [{"surfacing_time": 0.0}, {"distance": 40.0}, {"sigma": 2.0}])
def test_arguments_out_of_range(change):
    arguments = {"distance": 2000.0, "speed": 1.0, "arrival_radius": 50.0, "sigma": 0.05, "surfacing_time": 90.0}
    with pytest.raises(ValueError):
        best_legs(**arguments | change)


@pytest.mark.parametrize("change", [{"surfacing_time": 0.0}, {"distance": 50.0}])
def test_legs_without_a_price_or_a_way_are_refused_in_words(change):
    arguments = {"distance": 2000.0, "speed": 1.0, "arrival_radius": 50.0, "sigma": 0.05, "surfacing_time": 90.0}
    with pytest.raises(ValueError, match="need a surfacing time and a start outside the arrival radius"):
        best_legs(**arguments | change)


def test_the_table_is_as_short_as_what_it_may_cost_allows():
    """A tenth of the grid's knots, at no more than what is allowed for it."""
    distance, speed, arrival_radius, sigma = SHORT
    found = policy_of(SHORT)
    left, _ = policy.Bellman.on_grid(distance, arrival_radius, sigma / speed, SURFACING, 0.0).solve()
    assert found.legs.left.size < 0.4 * left.size
    assert found.bound <= found.transit.cost <= found.bound + TABLE_LOSS


def test_simplification_keeps_ends_kinks_and_jumps():
    left = np.concatenate([np.linspace(50.0, 400.0, 36), np.linspace(401.0, 1000.0, 50)])
    leg = np.concatenate([np.linspace(10.0, 360.0, 36), np.full(50, 250.0)])
    thin = simplify_table(LegTable(left, leg), np.full(left.size, 0.5))
    np.testing.assert_allclose(thin.left, [50.0, 400.0, 401.0, 1000.0])
    np.testing.assert_allclose(thin.leg, [10.0, 360.0, 250.0, 250.0])


@given(st.lists(st.floats(1.0, 1000.0), min_size=2, max_size=40), st.floats(0.1, 100.0))
def test_simplification_stays_within_its_tolerance(leg, tolerance):
    table = LegTable(np.arange(len(leg)) * 500.0, np.array(leg))
    thin = simplify_table(table, np.full(len(leg), tolerance))
    assert np.all(np.abs(np.interp(table.left, thin.left, thin.leg) - table.leg) <= tolerance)


def test_what_is_left_to_go_is_what_the_same_legs_are_expected_to_take():
    distance, speed, radius, sigma = SHORTER
    bellman = policy.Bellman.on_grid(distance, radius, sigma / speed, SURFACING * speed, 20.0)
    nodes = bellman.panels.nodes
    expected = expected_transit(distance, LegTable(nodes, nodes), *SHORTER[1:], SURFACING, 20.0)
    found = np.interp(distance, nodes, bellman._evaluate(nodes))
    assert found == pytest.approx(speed * expected.duration, rel=2e-3)
