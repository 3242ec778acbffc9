"""Effects on a descent by their closed forms and limits."""

import numpy as np
import pytest

from missionplan.effects.dive_forces import (
    ATMOSPHERE,
    BroadsideStart,
    DragBias,
    DragCrisis,
    SlowFlooding,
    Stratification,
    TrappedGas,
)
from missionplan.effects.dive_log import ClockOffset, LinePayout, SensorLag


def test_drag_bias_acts_on_both_phases_of_the_fall():
    assert DragBias(0.2).lone_drag_factor() == DragBias(0.2).drag_factor(3.0, 1.0) == 1.2


def test_flooding_starts_light_and_ends_at_the_wet_weight():
    flooding = SlowFlooding(0.4, 3.0)
    assert flooding.wet_weight_factor(0.0) == pytest.approx(0.6)
    assert flooding.wet_weight_factor(3.0) == pytest.approx(1.0 - 0.4 / np.e)
    assert flooding.wet_weight_factor(1e3) == 1.0


def test_gas_is_halved_under_one_atmosphere_of_water():
    gas = TrappedGas(2.0)
    assert gas.lift(0.0) == 2.0
    assert gas.lift(ATMOSPHERE) == 1.0


def test_gas_in_the_tail_is_compressed_later():
    """Boyle's law at the gas, not at the nose."""
    gas = TrappedGas(2.0, height=0.5)
    assert gas.lift(0.4) == 2.0
    assert gas.lift(ATMOSPHERE + 0.5) == pytest.approx(1.0)
    assert gas.lift(5.0) == TrappedGas(2.0).lift(4.5)


def test_stratification_is_a_step_of_given_thickness():
    step = Stratification(1.0, depth=8.0, thickness=2.0)
    assert step.lift(8.0) == 0.5
    assert step.lift(9.0) - step.lift(7.0) == pytest.approx(np.tanh(1.0))
    assert step.lift(30.0) == pytest.approx(1.0)


def test_broadside_drag_falls_off():
    start = BroadsideStart(5.0, 2.0)
    assert start.drag_factor(0.0, 1.0) == 6.0
    assert start.drag_factor(2.0, 1.0) == pytest.approx(1.0 + 5.0 / np.cosh(1.0) ** 3)


def test_drag_falls_beyond_the_critical_speed():
    crisis = DragCrisis(0.4, speed=1.2, width=0.1)
    assert crisis.drag_factor(0.0, 1.2) == pytest.approx(0.8)
    assert crisis.drag_factor(0.0, 0.3) == pytest.approx(1.0)
    assert crisis.drag_factor(0.0, 3.0) == pytest.approx(0.6)


def test_delays():
    assert LinePayout(0.2).delay(6.0) == pytest.approx(1.2)
    assert ClockOffset(-0.3).delay(6.0) == -0.3


@pytest.mark.parametrize("step", [0.02, 0.5])
def test_lag_behind_a_steady_fall(step):
    """On a ramp the exact answer is z − v·τ·(1 − exp(−t/τ)), whatever the grid."""
    t = np.arange(0.0, 6.0, step)
    lags = np.array([0.0, 0.3, 1.5])
    depth = 1.4 * t[:, None] * np.ones(3)
    safe = np.where(lags > 0.0, lags, 1.0)
    expected = depth - 1.4 * lags * -np.expm1(-t[:, None] / safe)
    np.testing.assert_allclose(SensorLag(lags).reading(t, depth), expected, atol=1e-12)


@pytest.mark.parametrize(("lag", "averaging"), [(0.5, 0.4), (5.0, 0.4), (5.0, 30.0)])
def test_a_logger_that_averages_a_slow_sensor(lag, averaging):
    """Against the mean of the sensor's own output by the trapezoidal rule; far from the start it is late by the lag."""
    t = np.arange(0.0, 40.0, 0.01)
    depth = np.maximum(t - 2.0, 0.0) * 1.2
    window = 2.0 * lag * averaging / (1.0 + averaging)
    sensor = SensorLag(lag / (1.0 + averaging)).reading(t, depth[:, None])[:, 0]
    integral = np.concatenate([[0.0], np.cumsum(0.005 * (sensor[1:] + sensor[:-1]))])
    expected = (integral - np.interp(t - window, t, integral, left=0.0)) / window
    found = SensorLag(lag, averaging).reading(t, depth[:, None])[:, 0]
    np.testing.assert_allclose(found, expected, atol=2e-4)
    assert found[-1] == pytest.approx(depth[-1] - 1.2 * lag, abs=0.01)


def test_trials_are_lagged_each_by_itself():
    rng = np.random.default_rng(1)
    depth = np.cumsum(rng.random((60, 5)), axis=0)
    lags, averaging = np.array([0.0, 0.3, 0.3, 2.0, 4.0]), np.array([0.5, 0.0, 0.5, 0.5, 50.0])
    together = SensorLag(lags, averaging).reading(0.16 * np.arange(60), depth)
    for trial in range(5):
        alone = SensorLag(lags[trial], averaging[trial]).reading(0.16 * np.arange(60), depth[:, [trial]])
        np.testing.assert_array_equal(together[:, [trial]], alone)
    np.testing.assert_array_equal(together[:, 0], depth[:, 0])
