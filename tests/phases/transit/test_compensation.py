import numpy as np
import pytest
from transit_examples import GOAL, FixedNormals, normals, run, start

from missionplan.phases.currents import Current, LayeredCurrent
from missionplan.phases.transit.compensation import (
    AsPrinted,
    CompletedLeg,
    Forecast,
    LastLeg,
    PlannedLeg,
    RunningMean,
    compensation_named,
)
from missionplan.phases.transit.plan import TransitNormals, VelocityError

DRIFT = np.array([0.03, -0.04])
STILL = Forecast(None, np.zeros(2), 0.0, 60.0)


def behind(velocity_error, seconds):
    zero = np.zeros((2, 1))
    return CompletedLeg(velocity_error, np.array([seconds]), zero, zero, np.zeros(1), zero, zero)


def two_layers():
    return LayeredCurrent(np.array([2.0, 50.0]), np.array([0.1, 0.02]), np.array([0.1, -0.05]))


@pytest.mark.parametrize(
    "compensation", [LastLeg(), RunningMean(np.zeros((2, 2)), 0.0), RunningMean(1e-4 * np.eye(2), 3.0)]
)
def test_a_steady_drift_is_aimed_off_from_the_second_leg_on(compensation):
    error = VelocityError.isotropic(0.0, DRIFT)
    _, record = run(
        {"d_max": 500.0, "velocity_error": error, "arrival_radius": 0.6}, compensation=compensation, tracked=1
    )
    after_first = record.track[:, 2, 0]
    assert after_first == pytest.approx([500.0 + 500.0 * DRIFT[0], 500.0 * DRIFT[1]])
    left = np.array([1000.0, 0.0]) - after_first
    planned = np.linalg.norm(left)
    aimed = left - DRIFT * planned
    assert record.track[:, 4, 0] == pytest.approx(after_first + aimed + DRIFT * np.linalg.norm(aimed))


def test_forecast_is_right_from_the_first_leg_on():
    error = VelocityError.isotropic(0.0, DRIFT)
    compensation = Forecast(two_layers(), DRIFT, depth=10.0, surfacing_time=60.0)
    changes = {"d_max": 250.0, "velocity_error": error, "depth": 10.0, "arrival_radius": 30.0}
    _, record = run(changes, compensation=compensation, current=two_layers(), tracked=1)
    under_way = DRIFT + np.array([0.02, -0.05])
    carried = under_way * 250.0 + np.array([0.1, 0.1]) * 60.0
    aimed = np.array([250.0, 0.0]) - carried
    moved = aimed + under_way * np.linalg.norm(aimed) + np.array([0.1, 0.1]) * 60.0
    assert record.track[:, 2, 0] == pytest.approx(moved)
    assert record.arrived.all()


class Sloping(Current):
    """A current toward east, linear in time, depth and place: its mean over a straight leg is that of its middle."""

    def velocity(self, t, depth, position):
        east = 1e-4 * t + 0.02 * depth + 3e-4 * position[1]
        return np.stack((east, 0.0 * east))


def test_forecast_is_of_the_moment_the_depth_and_the_place_of_each_part():
    """Under way in the middle of the leg at run depth; then at the surface, after the leg and where it ends."""
    leg = PlannedLeg(
        np.array([100.0]), np.zeros((2, 1)), np.array([[0.0], [300.0]]), np.array([400.0]), GOAL[:, None], 10.0
    )
    under_way = 0.01 + 1e-4 * 300.0 + 0.02 * 5.0 + 3e-4 * 150.0
    surface = 1e-4 * (500.0 + 30.0) + 3e-4 * 300.0
    found = Forecast(Sloping(), np.array([0.01, 0.0]), depth=5.0, surfacing_time=60.0).offset((), leg)
    assert found[:, 0] == pytest.approx([under_way * 400.0 + surface * 60.0, 0.0])


def test_surface_drift_is_learnt_apart_from_the_velocity_error():
    current = LayeredCurrent(np.array([2.0, 50.0]), np.array([0.0, 0.0]), np.array([0.2, 0.0]))
    for compensation in (LastLeg(), RunningMean(np.zeros((2, 2)), 0.0)):
        changes = {"d_max": 400.0, "depth": 10.0, "max_legs": 2}
        _, record = run(changes, compensation=compensation, current=current, tracked=1)
        nominal_end = record.track[:, 2, 0]
        left = np.array([1000.0, 0.0]) - nominal_end
        expected = nominal_end + 400.0 * left / np.linalg.norm(left)
        assert nominal_end == pytest.approx([400.0, 12.0])
        assert record.track[:, 4, 0] == pytest.approx(expected)


def test_as_printed_subtracts_the_miss_of_the_nominal_destination():
    """Eq. 21 to the letter, by hand: the same error each leg is corrected, forgotten, corrected, forgotten."""
    error = VelocityError.isotropic(0.0, np.array([0.0, 0.05]))
    changes = {"d_max": 200.0, "velocity_error": error, "max_legs": 2}
    _, record = run(changes, compensation=AsPrinted(), tracked=1)
    first = record.track[:, 2, 0]
    assert first == pytest.approx([200.0, 10.0])
    left = np.array([1000.0, 0.0]) - first
    adjusted = 200.0 * left / np.linalg.norm(left) - np.array([0.0, 10.0])
    second = first + adjusted + np.array([0.0, 0.05]) * np.linalg.norm(adjusted)
    assert record.track[:, 4, 0] == pytest.approx(second)


def test_as_printed_does_not_converge():
    """Some 23 % of runs arrive within 400 legs at d_max = 1 (4 nmi, 1.25 m/s, sigma 0.035 m/s, r_x 50 m)."""
    changes = {
        "goal": np.array([7408.0, 0.0]),
        "speed": 1.25,
        "d_max": 7408.0,
        "arrival_radius": 50.0,
        "velocity_error": VelocityError.isotropic(0.035),
    }
    _, record = run(changes, start(1500), compensation=AsPrinted())
    assert record.arrived.mean() == pytest.approx(0.23, abs=3 * np.sqrt(0.23 * 0.77 / 1500) + 0.005)


def test_running_mean_weights_short_legs_less():
    sigma, fix = 0.02, 5.0
    compensation = RunningMean(sigma**2 * np.eye(2), fix)
    memory = compensation.begin(1)
    legs = [(np.array([[0.1], [0.0]]), 100.0), (np.array([[0.3], [0.2]]), 1000.0), (np.array([[9.0], [9.0]]), 0.0)]
    for velocity, seconds in legs:
        memory = compensation.update(memory, behind(velocity, seconds))
    weights = [1.0 / (sigma**2 + 2.0 * fix**2 / seconds**2) for _, seconds in legs[:2]]
    expected = (0.1 * weights[0] + 0.3 * weights[1]) / sum(weights)

    class Ahead:
        duration = np.array([1.0])

    assert compensation.offset(memory, Ahead())[0, 0] == pytest.approx(expected)


def test_running_mean_of_correlated_errors_is_generalised_least_squares():
    covariance, fix = np.array([[4e-4, 1.5e-4], [1.5e-4, 1e-4]]), 4.0
    compensation = RunningMean(covariance, fix)
    memory = compensation.begin(1)
    errors, times = np.array([[0.1, -0.05], [0.02, 0.07], [0.0, 0.01]]), [200.0, 900.0, 400.0]
    information, weighted = np.zeros((2, 2)), np.zeros(2)
    for error, seconds in zip(errors, times, strict=True):
        memory = compensation.update(memory, behind(error[:, None], seconds))
        weight = np.linalg.inv(covariance + 2.0 * fix**2 / seconds**2 * np.eye(2))
        information, weighted = information + weight, weighted + weight @ error

    class Ahead:
        duration = np.array([1.0])

    assert compensation.offset(memory, Ahead())[:, 0] == pytest.approx(np.linalg.solve(information, weighted))


def test_measured_velocity_error_is_from_the_aim_to_the_fix_on_surfacing():
    class Listening(LastLeg):
        heard = None

        def update(self, memory, leg):
            self.heard = self.heard or leg
            return super().update(memory, leg)

    compensation, trials = Listening(), 3
    draws = TransitNormals(
        FixedNormals(np.ones((2, trials))), FixedNormals(np.full((2, trials), 0.5)), FixedNormals(np.zeros((2, trials)))
    )
    changes = {"velocity_error": VelocityError.isotropic(0.01), "fix_error": 2.0, "max_legs": 1}
    run(
        changes,
        draws=draws,
        compensation=compensation,
        current=LayeredCurrent(np.ones(1), np.zeros(1), np.array([0.1])),
    )
    assert compensation.heard.velocity_error[:, 0] == pytest.approx([0.01 + 0.001, 0.01 + 0.1 + 0.001])
    assert compensation.heard.surface_drift[:, 0] == pytest.approx([-1.0, 0.1 * 60.0 - 1.0])
    assert compensation.heard.duration == pytest.approx(1000.0)


def test_independent_errors_are_best_left_alone_and_persistent_ones_are_not():
    trials = 2048
    independent = {"d_max": 480.0, "velocity_error": VelocityError.isotropic(0.05)}
    means = np.stack([0.2 * np.cos(np.linspace(0, 6.28, trials)), 0.2 * np.sin(np.linspace(0, 6.28, trials))])
    drifting = {**independent, "velocity_error": VelocityError.isotropic(0.01, means)}
    compensation = RunningMean(1e-4 * np.eye(2), 0.0)
    for changes, better, worse in ((independent, None, LastLeg()), (drifting, compensation, None)):
        good, bad = (run(changes, start(trials), normals(), compensation=c)[1] for c in (better, worse))
        assert good.duration.mean() < bad.duration.mean()


def test_compensations_go_by_the_names_of_the_mission_file():
    assert compensation_named("none", STILL, np.eye(2), 1.0) is None
    assert isinstance(compensation_named("as-printed", STILL, np.eye(2), 1.0), AsPrinted)
    with pytest.raises(ValueError, match="there are none, last-leg, mean, forecast, as-printed"):
        compensation_named("magic", STILL, np.eye(2), 1.0)


def test_dropping_trials_keeps_what_they_have_learnt():
    changes = {"d_max": 700.0, "velocity_error": VelocityError.isotropic(0.1, DRIFT), "fix_error": 2.0}
    for compensation in (LastLeg(), RunningMean(0.01 * np.eye(2), 2.0), AsPrinted()):
        dropped = run({**changes, "max_legs": 40}, start(1024), compensation=compensation)[1]
        kept = run({**changes, "max_legs": 40}, start(1024), compensation=compensation, tracked=1)[1]
        assert np.array_equal(dropped.duration, kept.duration)
