"""Shaft, flow and surge: closed forms against the stepped model, energy, and the speed error of a shaft rate."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import trapezoid

from missionplan.physics import propeller as p
from missionplan.physics import propulsion as pr
from tests.physics import propeller_example as example

HULL = example.TABLE_1_RESISTANCE


def held(shaft_rate, duration, step=0.02):
    """Run table 1's vehicle with an endless flywheel on the shaft, its flow settled at the start."""
    propeller = replace(example.table_1(), shaft_inertia=np.inf)
    flow = p.steady_axial_flow(propeller, shaft_rate, 0.0)
    return example.simulate_propulsion(
        propeller, HULL, np.zeros(round(duration / step)), step, (shaft_rate, float(flow), 0.0)
    )


@pytest.mark.parametrize("torque", [2.0, -5.0])
def test_steady_state_of_the_stepped_model_is_the_closed_form(torque):
    propeller = example.table_1()
    run = example.simulate_propulsion(propeller, HULL, np.full(6000, torque), 0.02)
    rate, flow, speed = run.shaft_rate[-1], run.axial_flow[-1], run.speed[-1]
    assert run.torque[-1] == pytest.approx(torque, rel=1e-6)
    assert flow == pytest.approx(float(p.steady_axial_flow(propeller, rate, speed)), rel=1e-6)
    surge = pr.quasi_steady_surge(propeller, HULL, abs(rate))
    assert abs(speed) == pytest.approx(float(surge.speed), rel=1e-6)
    assert flow == pytest.approx(propeller.flow_ratio * speed, rel=1e-6)


def test_a_run_astern_mirrors_a_run_ahead():
    ahead, astern = (example.simulate_propulsion(example.table_1(), HULL, np.full(500, q), 0.02) for q in (5.0, -5.0))
    np.testing.assert_array_equal(ahead.speed, -astern.speed)


def test_shaft_work_pays_for_every_motion():
    propeller, step = example.table_1(), 0.005
    torque = example.eq_36_torque(step, 40.0)
    run = example.simulate_propulsion(propeller, HULL, torque, step)
    work = np.sum(torque * (run.shaft_rate[1:] + run.shaft_rate[:-1]) / 2.0) * step
    kinetic = 0.5 * (propeller.shaft_inertia * run.shaft_rate[-1] ** 2 + HULL.mass * run.speed[-1] ** 2)
    resisted = trapezoid(HULL.force(run.speed) * run.speed, run.time)
    assert work > kinetic + resisted


def test_halving_the_step_divides_the_error_by_sixteen():
    def end(step):
        return example.simulate_propulsion(example.table_1(), HULL, np.full(round(2.0 / step), 5.0), step).shaft_rate[
            -1
        ]

    coarse, middle, fine = end(0.02), end(0.01), end(0.005)
    assert (coarse - middle) / (middle - fine) == pytest.approx(16.0, rel=0.2)


def test_trials_run_side_by_side():
    torque = np.array([5.0, -5.0, 2.5])
    together = example.simulate_propulsion(example.table_1(), HULL, np.tile(torque, (300, 1)), 0.02)
    alone = example.simulate_propulsion(example.table_1(), HULL, np.full(300, -5.0), 0.02)
    np.testing.assert_allclose(together.speed[:, 1], alone.speed, rtol=1e-12)


def test_too_long_a_step_is_refused():
    with pytest.raises(FloatingPointError, match="step of 2"):
        example.simulate_propulsion(example.table_1(), HULL, np.full(200, 500.0), 2.0)


def test_speeding_up_against_the_stepped_model():
    """Same cruising speed; the stepped flow in the disc runs ahead of (1 + a)(1 - w)u at first and costs thrust."""
    run = held(40.0, 40.0)
    closed = pr.speed_up(example.table_1(), HULL, 40.0, run.time[1:])
    assert run.speed[-1] == pytest.approx(closed.speed[-1], rel=1e-4)
    np.testing.assert_allclose(run.speed[1:], closed.speed, atol=0.10 * run.speed[-1])
    travelled = trapezoid(run.speed, run.time)
    assert travelled == pytest.approx(closed.distance[-1], rel=0.04)


@given(rate=st.floats(5.0, 100.0), time=st.floats(0.1, 200.0))
def test_speeding_up_integrates(rate, time):
    h = 1e-4 * time
    now, before, after = (pr.speed_up(example.table_1(), HULL, rate, t) for t in (time, time - h, time + h))
    assert (after.distance - before.distance) / (2 * h) == pytest.approx(float(now.speed), rel=1e-4, abs=1e-9)
    assert (after.work - before.work) / (2 * h) == pytest.approx(
        float(pr.shaft_power(example.table_1(), rate, now.speed)), rel=1e-3
    )


def test_distance_lost_is_the_limit_of_speeding_up():
    steady = pr.quasi_steady_surge(example.table_1(), HULL, 40.0).speed
    far = pr.speed_up(example.table_1(), HULL, 40.0, 1000.0)
    lost = float(pr.distance_lost(example.table_1(), HULL, 40.0))
    assert steady * 1000.0 - far.distance == pytest.approx(lost, rel=1e-9)


@settings(max_examples=30)
@given(rate=st.floats(5.0, 200.0), exponent=st.floats(1.7, 2.1))
def test_cruise_speed_and_shaft_rate_are_inverse(rate, exponent):
    def drag(speed):
        return 300.0 * speed**exponent

    speed = pr.cruise_speed(example.table_1(), rate, drag)
    assert pr.shaft_rate_for(example.table_1(), drag(speed), speed) == pytest.approx(rate, rel=1e-8)


def test_a_true_vehicle_like_the_nominal_one_differs_only_by_its_start():
    error = pr.speed_error(example.table_1(), HULL, 40.0, 300.0)
    assert error == pytest.approx(-float(pr.distance_lost(example.table_1(), HULL, 40.0)) / 300.0, rel=1e-9)


def test_more_drag_makes_the_inferred_speed_too_high():
    errors = pr.speed_error(example.table_1(), HULL, 40.0, 1e6, drag_factor=np.array([0.9, 1.0, 1.2]))
    assert errors[0] > 0.0 > errors[2]
    assert errors[1] == pytest.approx(0.0, abs=1e-4)
    thrust = pr.speed_error(example.table_1(), HULL, 40.0, 1e6, thrust_factor=1.2)
    assert thrust > 0.0


@pytest.mark.parametrize("given", ["rate", "torque"])
def test_following_a_measured_run_gives_its_flow(given):
    step, every = 0.005, 20
    at = step * np.arange(3000)
    torque = 4.0 + 4.0 * np.sin(0.8 * at) - 3.0 * np.cos(2.3 * at)
    run = example.simulate_propulsion(example.table_1("momentum"), HULL, torque, step)
    pick = slice(0, -1, every)
    drive = {"shaft_rate": run.shaft_rate[pick]} if given == "rate" else {"motor_torque": torque[::every]}
    rate, flow = pr.propeller_response(example.table_1("momentum"), run.time[pick], run.speed[pick], **drive)
    np.testing.assert_allclose(rate, run.shaft_rate[pick], atol=2e-3 * run.shaft_rate.max())
    np.testing.assert_allclose(flow, run.axial_flow[pick], atol=0.01 * run.axial_flow.max())


def test_flow_that_settles_within_a_sample_follows_the_shaft():
    """Against steps thirty times as short, for flow that settles in a third to a twentieth of the time between samples."""
    propeller = replace(example.table_1("momentum"), flow_mass=20.0)
    time, fine = 0.1 * np.arange(60), np.linspace(0.0, 5.9, 59 * 30 + 1)
    rate, speed = 40.0 + 15.0 * np.sin(3.0 * time), 0.9 - 0.7 * np.exp(-time / 4.0)
    _, flow = pr.propeller_response(propeller, time, speed, shaft_rate=rate)
    drive = {"shaft_rate": np.interp(fine, time, rate)}
    _, exact = pr.propeller_response(propeller, fine, np.interp(fine, time, speed), **drive)
    np.testing.assert_allclose(flow, exact[::30], atol=1e-3 * np.ptp(exact))


def test_following_needs_one_drive():
    with pytest.raises(ValueError, match="either"):
        pr.propeller_response(example.table_1(), np.arange(3.0), np.zeros(3))
