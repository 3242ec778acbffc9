"""Effects on a transit by their closed forms."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad, solve_ivp

from missionplan.effects.course_and_speed import (
    CompassBias,
    CompassDeviation,
    CompassJump,
    CurrentResponse,
    Sideslip,
    SpeedLoss,
    SpeedScale,
)
from missionplan.effects.currents import CurrentShear, InertialCurrent, MeanCurrent, SurfaceDrift
from missionplan.effects.response import Response
from missionplan.effects.tidal_current import PERIODS, TidalCurrent, resolvable_constituents
from missionplan.phases.hooks import Leg, velocity_error
from missionplan.physics.water import angular_frequencies


def leg(t=0.0, duration=1000.0, start=(0.0, 0.0), heading=0.0, speed=1.5, latitude=np.nan):
    return Leg(
        np.array([t]),
        np.array([duration]),
        np.array(start)[:, None],
        np.array([[np.sin(heading)], [np.cos(heading)]]),
        speed,
        latitude,
    )


def error(effect, legs):
    return velocity_error((effect,), legs)


def test_compass_bias_turns_clockwise():
    northward = error(CompassBias(np.radians(90.0)), leg(speed=2.0))
    np.testing.assert_allclose(np.array([[0.0], [2.0]]) + northward, [[2.0], [0.0]], atol=1e-12)


@given(st.floats(-0.5, 0.5), st.floats(0.0, 6.28))
def test_compass_bias_keeps_the_speed(angle, heading):
    one = leg(heading=heading)
    made = one.speed * one.along + error(CompassBias(angle), one)
    assert np.hypot(*made)[0] == pytest.approx(1.5)


def test_deviation_is_a_cosine_of_the_heading():
    deviation = CompassDeviation(0.1, phase=np.radians(30.0))
    at_phase = error(deviation, leg(heading=np.radians(30.0)))
    np.testing.assert_allclose(at_phase, error(CompassBias(0.1), leg(heading=np.radians(30.0))))
    np.testing.assert_allclose(error(deviation, leg(heading=np.radians(120.0))), 0.0, atol=1e-12)


def test_speed_scale_is_along_the_course():
    np.testing.assert_allclose(error(SpeedScale(0.1), leg(heading=np.pi / 2)), [[0.15], [0.0]], atol=1e-12)


@given(*(st.floats(-0.5, 0.5) for _ in range(3)), st.floats(0.0, 6.28), st.permutations(range(4)))
def test_turns_and_scales_of_the_course_multiply_and_currents_add(angle, amplitude, fraction, heading, order):
    one = leg(heading=heading)
    effects = (CompassBias(angle), CompassDeviation(amplitude, 0.3), SpeedScale(fraction), MeanCurrent(0.2, -0.1))
    made = one.speed * one.along + velocity_error([effects[index] for index in order], one)
    course = heading + angle + amplitude * np.cos(heading - 0.3)
    expected = (1.0 + fraction) * 1.5 * np.array([np.sin(course), np.cos(course)]) + [0.2, -0.1]
    np.testing.assert_allclose(made[:, 0], expected, atol=1e-12)


@given(st.floats(0.0, 6.28), st.floats(-0.3, 0.3), st.floats(-0.3, 0.3))
def test_a_vehicle_that_holds_its_speed_over_the_ground_goes_with_a_current_across_alone(heading, east, north):
    one = leg(heading=heading)
    ahead, abeam = one.along[:, 0], np.array([one.along[1, 0], -one.along[0, 0]])
    made = velocity_error((MeanCurrent(east, north), CurrentResponse(-1.0)), one)[:, 0]
    assert made @ ahead == pytest.approx(0.0, abs=1e-12)
    assert made @ abeam == pytest.approx(np.array([east, north]) @ abeam, abs=1e-12)
    by_site = velocity_error((CurrentResponse(-1.0),), one, np.array([[east], [north]]))[:, 0]
    np.testing.assert_allclose(by_site, made - [east, north], atol=1e-12)


def test_sideslip_falls_with_the_square_of_the_speed():
    slow, fast = (error(Sideslip(0.04), leg(speed=speed))[0, 0] / speed for speed in (1.0, 2.0))
    assert np.arcsin(slow) == pytest.approx(4.0 * np.arcsin(fast))


def test_a_jump_of_the_compass_turns_the_part_of_a_leg_after_it():
    jump = CompassJump(0.1, moment=1500.0)
    turns = [np.arcsin(error(jump, leg(t=t, duration=1000.0))[0, 0] / 1.5) for t in (0.0, 1000.0, 1500.0)]
    np.testing.assert_allclose(turns, [0.0, 0.05, 0.1], atol=1e-12)


def test_speed_beyond_a_threshold_is_lost():
    lost = SpeedLoss(0.5, threshold=1.2)
    np.testing.assert_allclose([error(lost, leg(speed=v))[1, 0] for v in (1.0, 1.6)], [0.0, -0.2], atol=1e-12)


@pytest.mark.parametrize(
    ("term", "heading", "expected"),
    [
        ({"ahead_by_time_under_way": 1e-5}, 0.0, [0.0, 0.015]),
        ({"abeam_by_course_sine": 0.1, "times": 2.0}, np.pi / 4, np.array([1.0, -1.0]) * 0.15 / np.sqrt(2.0)),
        ({"east_each_leg": 20.0}, 1.0, [0.02, 0.0]),
        ({"ahead_each_leg": -30.0}, np.pi / 2, [-0.03, 0.0]),
        ({"north_changed": 0.1, "moment": 250.0}, 0.0, [0.0, 0.075]),
        ({"abeam_before": 0.1, "moment": 250.0}, 0.0, [0.0375, 0.0]),
        ({"ahead_in_turns_sine": 0.1, "period": 2000.0}, 0.0, [0.0, 0.15 * 2.0 / np.pi]),
        ({"abeam_in_turns_cosine": 0.1, "period": 1000.0}, 0.0, [0.0, 0.0]),
        ({"ahead_by_course_cosine": 0.1, "times": 4.0}, np.pi / 4, np.array([-1.0, -1.0]) * 0.15 / np.sqrt(2.0)),
        ({"ahead_while": 0.1, "moment": 250.0, "until": 750.0}, 0.0, [0.0, 0.075]),
        ({"east_while": 0.1, "moment": -500.0, "until": 250.0}, 0.0, [0.025, 0.0]),
        ({"abeam_fast": 0.1, "above": 1.4}, 0.0, [0.15, 0.0]),
        ({"abeam_fast": 0.1, "above": 1.6}, 0.0, [0.0, 0.0]),
    ],
)
def test_a_response_is_a_direction_times_a_factor(term, heading, expected):
    np.testing.assert_allclose(error(Response(**term), leg(heading=heading))[:, 0], expected, atol=1e-12)


@pytest.mark.parametrize(("depth", "expected"), [(30.0, 0.1), (10.0, 0.0), (np.nan, 0.0)])
def test_a_response_below_a_depth_is_none_above_it(depth, expected):
    legs = replace(leg(), depth=np.array([depth]))
    np.testing.assert_allclose(error(Response(north_deep=0.1, below=20.0), legs)[:, 0], [0.0, expected], atol=1e-12)


def test_inertial_current_turns_clockwise_in_the_north_with_the_period_of_the_latitude():
    latitude = np.radians(27.4)
    quarter = 25.97 * 3600.0 / 4.0
    north = InertialCurrent(0.2, 0.0).velocity(leg(t=quarter, duration=1e-3, latitude=latitude))
    np.testing.assert_allclose(north, [[0.0], [-0.2]], atol=2e-3)
    south = InertialCurrent(0.2, 0.0).velocity(leg(t=quarter, duration=1e-3, latitude=-latitude))
    np.testing.assert_allclose(south, [[0.0], [0.2]], atol=2e-3)


def test_inertial_current_needs_a_latitude():
    with pytest.raises(ValueError, match=r"site\.origin"):
        InertialCurrent(0.2).velocity(leg())


def test_tide_is_the_mean_over_the_leg():
    tide = TidalCurrent(m2_east=0.3, m2_east_phase=0.4, o1_north=0.1, o1_north_phase=2.0)
    start, duration = 5000.0, 9000.0
    result = tide.velocity(leg(t=start, duration=duration))

    def mean(amplitude, phase, period):
        integral = quad(lambda t: amplitude * np.cos(2 * np.pi * t / period - phase), start, start + duration)[0]
        return integral / duration

    np.testing.assert_allclose(result[0], mean(0.3, 0.4, PERIODS["m2"]))
    np.testing.assert_allclose(result[1], mean(0.1, 2.0, PERIODS["o1"]))


def test_periods_are_those_of_utide():
    names = [name.upper() for name in PERIODS]
    np.testing.assert_allclose(2.0 * np.pi / angular_frequencies(names), list(PERIODS.values()), rtol=5e-9)


@pytest.mark.parametrize(
    ("days", "names"),
    [
        (0.1, ()),
        (0.5, ("m2",)),
        (2.0, ("m2", "k1")),
        (14.0, ("m2", "k1", "o1")),
        (15.0, ("m2", "s2", "k1", "o1", "m4")),
        (28.0, ("m2", "s2", "n2", "k1", "o1", "q1", "m4")),
        (183.0, tuple(PERIODS)),
    ],
)
def test_constituents_by_record_length(days, names):
    assert resolvable_constituents(days * 86400.0) == names


def test_shear_acts_at_the_middle_of_the_leg():
    shear = CurrentShear(east_by_north=1e-5)
    result = shear.velocity(leg(start=(100.0, 2000.0), heading=0.0, duration=1000.0, speed=1.5))
    np.testing.assert_allclose(result, [[1e-5 * 2750.0], [0.0]])


@pytest.mark.parametrize(("size", "error"), [(3e-5, 2e-3), (1.5e-4, 8e-3)])
def test_a_strong_shear_is_that_along_the_way_it_carries_the_vehicle(size, error):
    """Against the solution of ẋ = w + G x: at the middle through the water alone it would be ½GT off, 6 % of it."""
    gradient = size * np.array([[0.8, -1.2], [0.5, 1.1]])
    one = leg(start=(2000.0, -1500.0), heading=0.7, duration=800.0, speed=1.2)
    through = (one.speed * one.along)[:, 0]
    way = solve_ivp(lambda t, x: through + gradient @ x, (0.0, 800.0), one.start[:, 0], rtol=1e-10)
    exact = (way.y[:, -1] - one.start[:, 0]) / 800.0 - through
    found = CurrentShear(*gradient.ravel()).velocity(one)[:, 0]
    np.testing.assert_allclose(found, exact, rtol=0.0, atol=error * np.hypot(*exact))


def test_surface_drift_is_steady():
    one = leg()
    drift = SurfaceDrift(0.2, -0.1).surface_velocity(one.t_start, one.duration, one.start)
    np.testing.assert_allclose(drift, [[0.2], [-0.1]])
