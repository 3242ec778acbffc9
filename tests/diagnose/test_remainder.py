"""The remainder speaks when something smooth is left, and seldom otherwise."""

import numpy as np
import pytest

from missionplan.diagnose.remainder import _smooth_functions, remainder
from missionplan.diagnose.residuals import Axis, Residuals, outlying_groups

N = 80


def residuals(values, level=0.01):
    axis = Axis("time", np.linspace(0.0, 1.0, N)[:, None], np.ones((N, 1)))
    groups = np.repeat([f"dive-{k + 1}" for k in range(4)], N // 4)
    return Residuals(values, np.eye(N), np.zeros(N, dtype=int), {"time": axis}, groups, level)


def test_white_residuals_leave_nothing():
    rng = np.random.default_rng(2)
    alarms = [remainder(residuals(rng.normal(size=N))).speaks for _ in range(60)]
    assert np.mean(alarms) <= 0.07


def test_a_smooth_remainder_is_found_on_its_axis():
    rng = np.random.default_rng(3)
    found = remainder(residuals(rng.normal(size=N) + 2.0 * np.sin(np.linspace(0.0, 9.0, N))))
    assert found.speaks
    assert found.axis == "time"
    assert found.log_bayes_factor > 10.0


def test_changing_spread_fails_a_residual_test():
    rng = np.random.default_rng(4)
    spread = np.exp(np.repeat([-2.0, 1.0, -2.0, 1.0], N // 4))
    tests = remainder(residuals(rng.normal(size=N) * spread)).tests
    assert min(test.p_value for test in tests if test.name.startswith("changing")) < 0.01


def test_a_shifted_group_is_outlying():
    rng = np.random.default_rng(6)
    values = rng.normal(size=N)
    values[20:40] += 3.0
    found = outlying_groups(residuals(values))
    assert [name for name, _ in found] == ["dive-2"]
    assert found[0][1] < 0.01


@pytest.mark.parametrize("seed", range(3))
def test_no_group_is_outlying_among_equals(seed):
    assert outlying_groups(residuals(np.random.default_rng(seed).normal(size=N))) == ()


def test_smooth_functions_have_the_squared_exponential_covariance():
    """Of places that repeat, too, and along a direction of each value's own."""
    places = np.array([[0.0], [0.2], [0.2], [0.7], [1.0]])
    directions = np.array([[1.0], [2.0], [-1.0], [0.5], [1.0]])
    basis = _smooth_functions(Axis("time", places, directions), 0.4)
    covariance = np.exp(-0.5 * ((places - places.T) / 0.4) ** 2) * (directions @ directions.T)
    np.testing.assert_allclose(basis @ basis.T, covariance, atol=1e-6)
