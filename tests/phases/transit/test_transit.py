import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from transit_examples import GOAL, FixedNormals, normals, plan, run, start

from missionplan.effects.currents import CurrentShear
from missionplan.montecarlo.streams import LegNormals
from missionplan.phases.currents import LayeredCurrent
from missionplan.phases.hooks import TransitEffect, TrialState
from missionplan.phases.transit import transit
from missionplan.phases.transit.expectation import expected_transit
from missionplan.phases.transit.leg_loop import FARTHEST
from missionplan.phases.transit.plan import Environment, LegTable, TransitNormals, VelocityError


def uniform(east, north):
    return LayeredCurrent(np.array([1.0]), np.array([east]), np.array([north]))


def test_without_error_the_duration_is_closed_form():
    state, record = run({"d_max": 300.0, "speed": 1.25})
    assert record.duration == pytest.approx(1000.0 / 1.25 + 4 * 60.0, rel=1e-9)
    assert record.surfacings.tolist() == [4.0, 4.0, 4.0]
    assert record.distance == pytest.approx(1000.0)
    assert record.arrived.all()
    assert record.arrival_error == pytest.approx(0.0, abs=1e-9)
    assert state.position[:, 0] == pytest.approx(GOAL)
    assert state.clock == pytest.approx(record.duration)


@pytest.mark.parametrize("d_max", [1000.0, 5000.0])
def test_a_leg_never_goes_beyond_the_target(d_max):
    _, record = run({"d_max": d_max})
    assert record.surfacings.tolist() == [1.0] * 3
    assert record.distance == pytest.approx(1000.0)


def test_a_start_within_the_arrival_radius_has_arrived():
    state, record = run(state=start(at=(995.0, 0.0)))
    assert record.arrived.all()
    assert not record.duration.any()
    assert not record.surfacings.any()
    assert record.arrival_error == pytest.approx(5.0)
    assert np.array_equal(state.clock, np.zeros(3))


def test_legs_shorter_than_the_arrival_radius_work():
    _, record = run({"d_max": 7.0})
    assert record.surfacings.tolist() == [math.floor((1000.0 - 10.0) / 7.0) + 1.0] * 3


def test_arrival_is_within_the_radius_not_on_it():
    _, record = run({"d_max": 990.0})
    assert record.surfacings.tolist() == [2.0] * 3


def test_trials_that_never_arrive_are_counted_and_kept():
    state, record = run({"d_max": 100.0, "max_legs": 4})
    assert not record.arrived.any()
    assert record.surfacings.tolist() == [4.0] * 3
    assert record.arrival_error == pytest.approx(600.0)
    assert not state.alive.any()


def test_trials_that_failed_before_stay_where_they_are():
    state = start(4)
    state = TrialState(state.position, state.fix, state.clock, state.energy, np.array([True, False, True, False]))
    after, record = run(state=state)
    assert record.arrived.tolist() == [True, False, True, False]
    assert after.position[0].tolist() == [1000.0, 0.0, 1000.0, 0.0]
    assert record.duration[1] == 0.0


def test_a_velocity_error_displaces_by_its_duration():
    draws = TransitNormals(FixedNormals(np.tile([[0.0], [2.0]], 3)))
    _, record = run({"velocity_error": VelocityError.isotropic(0.01), "max_legs": 1}, draws=draws)
    assert record.arrival_error == pytest.approx(0.02 * 1000.0)


def test_full_covariance_is_that_of_the_positions():
    covariance = np.array([[4e-4, -2e-4], [-2e-4, 9e-4]])
    error = VelocityError.general(covariance, mean=np.array([0.01, -0.02]))
    state, _ = run({"velocity_error": error, "max_legs": 1, "arrival_radius": 1e-9}, state=start(4096))
    missed = (state.position - GOAL[:, None]) / 1000.0
    assert np.cov(missed) == pytest.approx(covariance, abs=4 * 9e-4 * math.sqrt(2 / 4096))
    assert missed.mean(axis=1) == pytest.approx([0.01, -0.02], abs=4 * 0.03 / 64)


def test_semidefinite_covariance_moves_along_one_axis_only():
    state, _ = run({"velocity_error": VelocityError.general(np.diag([0.0, 1e-4])), "max_legs": 1}, state=start(100))
    assert state.position[0] == pytest.approx(1000.0)
    assert state.position[1].std() > 1.0


@pytest.mark.parametrize(("d_max", "sigma"), [(1000.0, 0.05), (480.0, 0.05), (150.0, 0.02), (950.0, 0.3)])
def test_mean_time_and_surfacings_are_the_integral_equations(d_max, sigma):
    expected = expected_transit(1000.0, d_max, 1.0, 10.0, sigma, 60.0)
    durations, surfacings = [], []
    for block in range(6):
        _, record = run({"d_max": d_max, "velocity_error": VelocityError.isotropic(sigma)}, start(4096), normals(block))
        assert record.arrived.all()
        durations.append(record.duration)
        surfacings.append(record.surfacings)
    for found, theory in ((durations, expected.duration), (surfacings, expected.surfacings)):
        values = np.concatenate(found)
        assert (
            abs(values.mean() - theory) < 4.0 * values.std() / math.sqrt(values.size) + 1e-4
        )  # legs too rare to be sampled


def test_dropping_trials_that_have_arrived_changes_no_bit():
    """Keeping tracks keeps all trials in the arrays; the results must not depend on it."""
    changes = {"d_max": 900.0, "velocity_error": VelocityError.isotropic(0.2), "fix_error": 3.0}
    dropped = run(changes, start(4096))[1]
    kept = run(changes, start(4096), tracked=1)[1]
    for name in ("duration", "surfacings", "distance", "arrival_error", "arrived"):
        assert np.array_equal(getattr(dropped, name), getattr(kept, name)), name


def test_what_is_absent_and_what_is_zero_give_the_same():
    changes = {"d_max": 600.0, "velocity_error": VelocityError.isotropic(0.1)}
    plain = run(changes, start(512))[1]
    around = run(changes, start(512), current=uniform(0.0, 0.0), effects=(TransitEffect(),))[1]
    assert around.duration == pytest.approx(plain.duration, rel=1e-12)
    assert np.array_equal(around.arrived, plain.arrived)


def test_parameters_may_differ_from_trial_to_trial():
    speeds, radii = np.array([1.0, 2.0]), np.array([10.0, 30.0])
    times, reach = np.array([60.0, 90.0]), np.array([500.0, 980.0])
    changes = {"speed": speeds, "arrival_radius": radii, "surfacing_time": times, "d_max": reach}
    _, record = run(changes, start(2))
    assert record.duration == pytest.approx([1000.0 + 120.0, 490.0 + 90.0])


def test_parameters_follow_their_trials_when_others_are_dropped():
    trials = 1024
    sigma, goal = np.linspace(0.0, 0.4, trials), np.stack((np.linspace(900.0, 1100.0, trials), np.zeros(trials)))
    changes = {"velocity_error": VelocityError.isotropic(sigma), "goal": goal, "speed": np.linspace(1.0, 2.0, trials)}
    current = LayeredCurrent(np.array([5.0]), np.linspace(-0.1, 0.1, trials)[None], np.zeros((1, trials)))
    dropped = run(changes, start(trials), current=current)[1]
    kept = run(changes, start(trials), current=current, tracked=1)[1]
    assert np.array_equal(dropped.duration, kept.duration)
    assert np.array_equal(dropped.arrival_error, kept.arrival_error)


@settings(max_examples=30)
@given(st.floats(0.0, 2.0 * math.pi), st.floats(200.0, 1500.0), st.integers(0, 5))
def test_turning_the_whole_plan_turns_the_answer(angle, d_max, block):
    turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    source = LegNormals(3, "turned", block)

    class Turned:
        def leg(self, number):
            return np.stack([sum(row[i] * source.leg(number)[i, :64] for i in (0, 1)) for row in turn])

    error = VelocityError.isotropic(0.05)
    straight = run({"d_max": d_max, "velocity_error": error}, start(64), TransitNormals(source))[1]
    changes = {"d_max": d_max, "velocity_error": error, "goal": turn @ GOAL}
    turned = run(changes, start(64), TransitNormals(Turned()))[1]
    assert turned.duration == pytest.approx(straight.duration, rel=1e-6)


def test_a_leg_table_is_read_at_the_distance_left():
    table = LegTable(np.array([100.0, 400.0, 1000.0]), np.array([50.0, 200.0, 800.0]))
    assert table(np.array([20.0, 100.0, 250.0, 700.0, 5000.0])) == pytest.approx([20.0, 50.0, 125.0, 500.0, 800.0])
    _, record = run({"d_max": table, "arrival_radius": 95.0})
    assert record.surfacings[0] == 3.0  # 1000 → 200 → 100 → 50 m left
    assert record.distance[0] == pytest.approx(950.0)


def test_current_carries_under_way_and_at_the_surface():
    current = LayeredCurrent(np.array([2.0, 50.0]), np.array([0.0, 0.0]), np.array([0.3, 0.1]))
    state, _ = run({"depth": 10.0, "max_legs": 1}, current=current)
    assert state.position[1] == pytest.approx(0.1 * 1000.0 + 0.3 * 60.0)


def test_fix_errors_have_their_variance_and_arrival_is_judged_on_the_fix():
    state, record = run({"fix_error": 4.0, "max_legs": 1}, state=start(4096))
    noise = state.fix - state.position
    assert noise.std() == pytest.approx(4.0, rel=0.04)
    assert np.array_equal(record.arrived, np.hypot(*(state.fix - GOAL[:, None])) < 10.0)
    assert record.arrival_error == pytest.approx(0.0, abs=1e-9)


def test_fix_errors_need_normals():
    with pytest.raises(ValueError, match="fix_on_surfacing"):
        run({"fix_error": 4.0}, draws=TransitNormals(FixedNormals(np.zeros((2, 3)))))


def test_a_fix_before_the_first_dive_may_be_wrong_though_later_ones_are_not():
    position = np.zeros((2, 2))
    state = TrialState(position, position + np.array([[0.0], [30.0]]), np.zeros(2), np.zeros(2), np.ones(2, dtype=bool))
    after, record = run(state=state)
    assert record.surfacings.tolist() == [2.0, 2.0]
    assert after.position[:, 0] == pytest.approx(GOAL)
    assert np.array_equal(after.position, after.fix)


def test_energy_is_power_by_time_and_surfacings():
    changes = {"d_max": 500.0, "power_under_way": 20.0, "power_at_surface": 3.0, "surfacing_energy": 100.0}
    state, record = run(changes)
    assert record.energy == pytest.approx(1000.0 * 20.0 + 2 * 60.0 * 3.0 + 2 * 100.0)
    assert state.energy == pytest.approx(record.energy)


def test_tracks_are_the_fixes_of_each_leg_and_end_at_arrival():
    changes = {"d_max": 500.0, "velocity_error": VelocityError.isotropic(0.05)}
    _, record = run(changes, start(40), tracked=5, current=uniform(0.0, 0.02))
    track = record.track
    legs = int(record.surfacings.max())
    assert track.shape == (2, 1 + 2 * legs, 5)
    for trial in range(5):
        last = 2 * int(record.surfacings[trial])
        assert np.isfinite(track[:, : last + 1, trial]).all()
        assert np.isnan(track[:, last + 1 :, trial]).all()
        assert math.dist(track[:, last, trial], GOAL) == pytest.approx(record.arrival_error[trial])


class Everything(TransitEffect):
    """One of each hook, with values that can be computed by hand."""

    is_random = True

    def velocity(self, leg):
        self.legs = [*getattr(self, "legs", []), leg]
        return np.array([[0.0], [0.01]])

    def surface_velocity(self, t, duration, position):
        return np.array([[0.0], [0.1]])

    def error_scale(self, normals):
        return 2.0

    def step(self, memory, elapsed, normals, leg):
        self.elapsed = elapsed
        return 1.0, np.array([[0.0], [0.001 if memory is None else 0.002]])


def test_effects_enter_through_each_of_their_hooks():
    effect = Everything()
    draws = TransitNormals(FixedNormals(np.ones((2, 2))), effects=(FixedNormals(np.zeros((2, 2))),))
    changes = {"d_max": 500.0, "max_legs": 2, "velocity_error": VelocityError.isotropic(0.001)}
    state, _ = transit(plan(**changes), start(2), draws, Environment(effects=(effect,)))
    first = 500.0 * (0.01 + 0.001 + 2 * 0.001) + 60.0 * 0.1
    assert effect.legs[1].start[1] == pytest.approx(first)
    assert effect.legs[1].t_start == pytest.approx(560.0)
    assert effect.elapsed == pytest.approx(560.0, rel=1e-3)
    assert np.hypot(*effect.legs[1].along) == pytest.approx(1.0)
    left = np.array([1000.0 - 501.0, -first])
    leg = min(500.0, math.hypot(*left))
    expected = first + left[1] * leg / math.hypot(*left) + leg * (0.01 + 0.002 + 0.002) + 6.0
    assert state.position[1] == pytest.approx(expected)


@pytest.mark.parametrize("length", [100.0, 900.0])
def test_a_position_error_may_gather_within_a_leg(length):
    """Its variance grows with the time of the leg, whatever the velocity error; it is no drift that outruns."""

    class Gathering(TransitEffect):
        is_random = True

        def position_variance_rate(self):
            return 0.25

    rng = np.random.default_rng(4)
    draws = TransitNormals(FixedNormals(np.zeros((2, 4096))), effects=(FixedNormals(rng.normal(size=(2, 4096))),))
    changes = {"d_max": length, "max_legs": 1, "speed": 1.0, "surfacing_time": 0.0}
    state, record = transit(plan(**changes), start(4096), draws, Environment(effects=(Gathering(),)))
    assert not record.outrun.any()
    assert state.position[1].std() == pytest.approx(0.5 * np.sqrt(length), rel=0.04)
    assert state.position[0].mean() == pytest.approx(length, abs=0.2)


def test_an_effect_may_worsen_the_fixes():
    class Worse(TransitEffect):
        def fix_variance(self):
            return 9.0

    state, _ = run({"fix_error": 4.0, "max_legs": 1}, state=start(4096), effects=(Worse(),))
    assert (state.fix - state.position).std() == pytest.approx(5.0, rel=0.04)


@pytest.mark.parametrize("has_fix_error", [False, True])
def test_a_current_that_grows_with_the_distance_loses_the_vehicle_and_not_the_run(has_fix_error):
    """A gradient that holds everywhere doubles the distance every half an hour: 10¹⁵⁴ m after some hundred legs."""
    changes = {"d_max": 300.0, "max_legs": 1000, "fix_error": 3.0 if has_fix_error else 0.0}
    with np.errstate(over="raise", invalid="raise"):
        state, record = run(changes, start(at=(-5000.0, 0.0)), effects=(CurrentShear(east_by_east=4e-4),))
    assert not record.arrived.any()
    np.testing.assert_allclose(np.hypot(*(state.position - GOAL[:, None])), FARTHEST)
