"""Generators of navigation logs: kinematics, columns, and that the hidden effects are strong enough to be seen."""

import dataclasses
import math

import numpy as np
import pytest

from . import legs
from .legs.catalogue import CATALOGUE, HOUR, PERIODS
from .legs.files import columns, step_on_ellipsoid
from .legs.outside import OUTSIDE
from .legs.sailing import displacement, simulate_log
from .legs.strength import MINIMUM_STRENGTH, MINIMUM_STRENGTH_RANDOM, whiten
from .legs.survey import RANDOM, draw_survey


def test_legs_close():
    """Steering + errors + drift are the displacement, and a leg starts where the last one ended."""
    survey = draw_survey(np.random.default_rng(3), "single", ("mean-current",))
    effect, _ = CATALOGUE["mean-current"].build(0.1, np.random.default_rng(1), survey.conditions)
    log = simulate_log(survey, (effect,), np.random.default_rng(2))
    np.testing.assert_allclose(log.fix_end, log.reckoned + log.signal + log.noise, atol=1e-6)
    np.testing.assert_allclose(log.true_end[:-1], log.true_start[1:], atol=1e-9)
    assert np.all(log.t_end > log.t_start)
    assert np.all(log.t_start[1:] > log.t_end[:-1])
    np.testing.assert_allclose(displacement(survey, log, (effect,)), log.signal, atol=1e-6)


def test_errors_without_effect_have_the_covariance_assumed():
    chi_square, count = 0.0, 0
    for seed in range(12):
        survey = draw_survey(np.random.default_rng(seed), "single", ())
        log = simulate_log(survey, (), np.random.default_rng(seed))
        z = whiten(survey, log, log.noise)
        chi_square += float(z @ z)
        count += z.size
    assert chi_square / count == pytest.approx(1.0, abs=0.05)


def test_inertial_current_turns_clockwise_north_of_the_equator():
    for latitude, sign in ((45.0, -1.0), (-45.0, 1.0)):
        survey = draw_survey(np.random.default_rng(5), "single", ("inertial-current",))
        conditions = dataclasses.replace(survey, latitude=latitude).conditions
        effect, _ = CATALOGUE["inertial-current"].build(0.1, np.random.default_rng(8), conditions)
        t = 0.8 * conditions.span
        (e0, n0), (e1, n1) = effect.current(t, np.zeros(2)), effect.current(t + 600.0, np.zeros(2))
        turn = np.angle(complex(e1, n1) / complex(e0, n0))
        inertial = sign * 4.0 * np.pi / 86164.0905 * np.sin(np.radians(45.0)) * 600.0
        assert turn == pytest.approx(inertial, rel=0.025)


def _outside_leg(name: str, size: float, seed: int = 4):
    conditions = draw_survey(np.random.default_rng(5), "outside", (name,)).conditions
    return OUTSIDE[name].build(size, np.random.default_rng(seed), conditions)[0], conditions


def test_gyro_creep_is_the_integral_of_a_turning_course():
    """Halfway off to the side at first order, ½ U ω T², and by quadrature for a large angle."""
    rate = np.radians(12.0) / HOUR
    effect, _ = _outside_leg("gyro-creep", rate)
    first = effect.push(0.0, 1.2, 600.0)
    assert abs(first[0]) == pytest.approx(0.5 * 1.2 * rate * 600.0**2, rel=1e-3)
    heading, speed, time = 2.0, 0.8, 2.5 * HOUR
    course = heading + np.sign(first[0]) * rate * (np.arange(20000) + 0.5) * time / 20000
    made_good = speed * time * np.array([np.sin(course).mean(), np.cos(course).mean()])
    reckoned = speed * time * np.array([np.sin(heading), np.cos(heading)])
    np.testing.assert_allclose(effect.push(heading, speed, time), made_good - reckoned, atol=1e-3)


def test_weed_slows_once_and_for_a_while():
    effect, conditions = _outside_leg("weed", 0.2)
    pace = np.array([effect.pace(t) for t in np.linspace(0.0, 1.3 * conditions.span, 2000)])
    assert set(pace) == {1.0, 0.8}
    assert np.count_nonzero(np.diff(pace)) == 2
    assert 0.1 / 1.3 < np.mean(pace < 1.0) < 0.6 / 1.3 + 1e-3


def test_tidal_race_is_a_tide_and_only_near_one_place():
    effect, conditions = _outside_leg("tidal-race", 0.4)
    grid = 3.0 * conditions.extent * np.stack(np.meshgrid(*2 * [np.linspace(-1.0, 1.0, 31)]), axis=-1).reshape(-1, 2)
    speed = np.array([np.hypot(*effect.current(3.0 * HOUR, place)) for place in grid])
    assert np.median(speed) < 0.05 * speed.max()
    place = grid[np.argmax(speed)]
    series = np.array([effect.current(t, place) for t in np.arange(0.0, 60.0 * PERIODS["M2"], HOUR)])
    assert np.abs(series.mean(axis=0)).max() < 0.02 * np.abs(series).max()
    assert np.abs(series).max() < 0.4 * 1.4


def test_degrees_keep_the_length_of_a_step():
    """Against the great circle of the local radius at 60° north, and across the date line."""
    latitude, longitude = step_on_ellipsoid(60.0, 179.99, np.array([5000.0, 0.0]))
    parallel = math.radians((longitude - 179.99) % 360.0) * 6378137.0 * math.cos(math.radians(60.0))
    assert parallel / math.sqrt(1.0 - 6.69437999014e-3 * 0.75) == pytest.approx(5000.0, rel=1e-6)
    assert latitude == pytest.approx(60.0)
    back = step_on_ellipsoid(*step_on_ellipsoid(-35.0, 20.0, np.array([0.0, 4e3])), [0.0, -4e3])
    assert back == pytest.approx((-35.0, 20.0), abs=1e-9)


@pytest.mark.parametrize(
    "effect",
    [pytest.param(each, marks=pytest.mark.slow if each == "persistent-error" else ()) for each in sorted(CATALOGUE)],
)
def test_effect_moves_the_legs(effect):
    least = MINIMUM_STRENGTH_RANDOM if effect in RANDOM else MINIMUM_STRENGTH
    assert legs.draw(101, "single", effect).strength >= least


@pytest.mark.parametrize("form", ["x_start_m", "lat_start"])
def test_columns_give_back_the_errors_of_the_legs(form):
    """End fix minus dead-reckoned position, decoded from the text, against what the generator moved."""
    rng = np.random.default_rng(9)
    survey = draw_survey(rng, "single", ("compass-bias",))
    log = simulate_log(survey, (), np.random.default_rng(4))
    header, rows = next(
        (header, rows)
        for header, rows, _ in (columns(survey, log, rng, True) for _ in range(40))
        if form in header and "ok" not in header and len(rows) == log.heading.size
    )
    table = np.array(rows, dtype=float)
    error = table[:, [7, 8]] - table[:, [5, 6]]
    assert header[5:9] == (
        ["x_dr_m", "y_dr_m", "x_end_m", "y_end_m"]
        if form == "x_start_m"
        else ["lat_dr_end", "lon_dr_end", "lat_end", "lon_end"]
    )
    if form == "lat_start":
        phi = np.radians(table[:, 5])
        w = 1.0 - 6.69437999014e-3 * np.sin(phi) ** 2
        north = np.radians(error[:, 0]) * 6378137.0 * (1.0 - 6.69437999014e-3) / w**1.5
        error = np.column_stack([np.radians(error[:, 1]) * 6378137.0 / np.sqrt(w) * np.cos(phi), north])
    np.testing.assert_allclose(error, log.fix_end - log.reckoned, atol=0.3, rtol=3e-3)
