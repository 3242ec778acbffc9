"""A discrepancy is significant when something smooth is left, and seldom otherwise."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.special import logsumexp
from scipy.stats import multivariate_normal

from missionplan.diagnosis.inference.axes import Axis, AxisScale, around, differing, pointwise
from missionplan.diagnosis.inference.block_covariance import BlockCovariance, InnerProducts
from missionplan.diagnosis.inference.discrepancy import (
    LENGTHS,
    MOST_COLUMNS,
    USUAL,
    Residuals,
    discrepancy,
    outlying_groups,
)
from missionplan.diagnosis.inference.marginal_likelihood import SCALE_PRIOR, SCALES

N = 80


def residuals(values, axis=None, **others):
    axis = axis or pointwise("time", "values against time", np.linspace(0.0, 1.0, N)[:, None])
    groups = np.repeat([f"dive-{k + 1}" for k in range(4)], N // 4)
    return Residuals(values, BlockCovariance.of(np.eye(N)), np.zeros(N, dtype=int), [axis], groups, **others)


def test_runs_that_differ_all_alike_say_more_than_each_otherwise():
    own = np.repeat(np.eye(4), N // 4, axis=0)
    axis = replace(differing("a shift in some runs", own), in_some_runs=True)
    alike, otherwise, none = (
        discrepancy(residuals(own @ shifts, axis)).log_bayes_factor
        for shifts in ([1.0, 0.0, 1.0, 0.0], [1.0, 0.0, -1.0, 0.0], [0.0, 0.0, 0.0, 0.0])
    )
    assert alike > otherwise + 0.3
    assert otherwise > 0.0 > none


def test_white_residuals_leave_nothing():
    rng = np.random.default_rng(2)
    alarms = [discrepancy(residuals(rng.normal(size=N))).significant for _ in range(60)]
    assert np.mean(alarms) <= 0.07


@pytest.mark.parametrize("strength", [0.0, 1.0])
def test_the_bayes_factor_is_that_of_normal_densities(strength):
    """Densities under W + size²·K, K of the leading components of mean variance 1 in the data, averaged."""
    rng = np.random.default_rng(14)
    where = np.linspace(0.0, 1.0, 20)[:, None]
    noise = np.diag(np.linspace(0.5, 1.5, 20) ** 2)
    values = rng.multivariate_normal(np.zeros(20), noise) + strength * np.sin(6.0 * where[:, 0])
    axis = pointwise("time", "values against time", where)
    given = Residuals(values, BlockCovariance.of(noise), np.zeros(20, dtype=int), [axis], np.repeat("dive-1", 20))
    usual = USUAL * np.sqrt(np.median(np.diag(noise)))
    sd = np.sqrt(np.diag(noise))

    def kernel(length):
        variance, along = np.linalg.eigh(np.exp(-0.5 * ((where - where.T) / length) ** 2) / np.outer(sd, sd))
        leading = (along[:, -MOST_COLUMNS:] * variance[-MOST_COLUMNS:]) @ along[:, -MOST_COLUMNS:].T * np.outer(sd, sd)
        return leading / np.mean(np.diag(leading))

    def density(smooth):
        return multivariate_normal.logpdf(values, cov=noise + smooth)

    parts = [[density((scale * usual) ** 2 * kernel(length)) for scale in SCALES] for length in LENGTHS]
    expected = logsumexp(parts, b=np.array(SCALE_PRIOR) / len(LENGTHS)) - density(0.0)
    assert discrepancy(given).log_bayes_factor == pytest.approx(expected, abs=0.001)


def test_an_axis_given_twice_says_no_more_than_once():
    values = np.random.default_rng(15).normal(size=N) + np.sin(np.linspace(0.0, 9.0, N))
    once = residuals(values)
    twice = Residuals(values, once.covariance, once.series, [*once.axes, *once.axes], once.groups)
    assert discrepancy(twice).log_bayes_factor == pytest.approx(discrepancy(once).log_bayes_factor, abs=1e-9)


def test_a_smooth_discrepancy_is_found_on_its_axis():
    rng = np.random.default_rng(3)
    found = discrepancy(residuals(rng.normal(size=N) + 2.0 * np.sin(np.linspace(0.0, 9.0, N))))
    assert found.significant
    assert found.axis == "time"
    assert found.log_bayes_factor > 10.0


def test_changing_spread_fails_a_residual_test():
    rng = np.random.default_rng(4)
    spread = np.exp(np.repeat([-2.0, 1.0, -2.0, 1.0], N // 4))
    tests = discrepancy(residuals(rng.normal(size=N) * spread)).tests
    assert min(test.p_value for test in tests if test.name.startswith("changing")) < 0.01


@pytest.mark.parametrize("period", [2, 4, 5])
def test_the_beat_of_a_coarse_sensor_with_its_sampling_is_no_discrepancy(period):
    rng = np.random.default_rng(8)
    values = rng.normal(size=N) + 2.0 * np.cos(2.0 * np.pi * np.arange(N) / period)
    assert discrepancy(residuals(values)).significant
    assert not discrepancy(residuals(values, quantised=True)).significant


def test_errors_that_last_show_on_a_coarse_sensor_too():
    rng = np.random.default_rng(9)
    values = lfilter([1.0], [1.0, -0.95], rng.normal(size=N))
    tests = discrepancy(residuals(values / values.std(), quantised=True)).tests
    assert min(test.p_value for test in tests if test.name.startswith("autocorrelation")) < 0.001


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


def test_a_response_that_builds_up_is_found_better_than_by_its_place():
    """A rate that changes at some place shows in all that follows."""
    rng = np.random.default_rng(7)
    places = np.linspace(0.0, 1.0, 11)[:, None]
    rate = np.sin(2.0 * np.pi * places[:, 0])
    builds_up = np.cumsum(np.repeat(np.eye(11), N // 10, axis=0)[:N], axis=0) / 10.0
    found = residuals(rng.normal(size=N) + 2.0 * builds_up @ rate, axis=Axis("time", "rate", places, builds_up))
    elsewhere = residuals(found.values, axis=Axis("time", "rate", places, builds_up[rng.permutation(N)]))
    assert discrepancy(found).log_bayes_factor > 3.0
    assert discrepancy(elsewhere).log_bayes_factor < discrepancy(found).log_bayes_factor - 3.0


def test_the_shape_of_a_discrepancy_is_the_function_that_is_left():
    rng = np.random.default_rng(12)
    left = np.sin(np.linspace(0.0, 9.0, N))
    plain = pointwise("time", "values against time", np.linspace(0.0, 1.0, N)[:, None])
    axis = Axis("time", "values", plain.places, plain.response, AxisScale(0.0, 9.0, "Time (s)", "Error (cm)", 100.0))
    shape = discrepancy(residuals(2.0 * left + rng.normal(size=N), axis=axis)).shape
    assert shape is not None
    assert (shape.place, shape.value) == ("Time (s)", "Error (cm)")
    off = (shape.mean - 200.0 * np.sin(shape.at)) / shape.sd
    assert np.abs(off).max() < 3.0
    assert 20.0 < shape.sd.mean() < 60.0  # of single values with a standard deviation of 100
    assert discrepancy(residuals(rng.normal(size=N), axis=axis)).shape is None


def test_what_no_value_responds_to_is_no_discrepancy():
    axis = Axis("run", "drag", np.zeros((1, 1)), np.zeros((N, 1)))
    found = discrepancy(residuals(np.random.default_rng(13).normal(size=N), axis=axis))
    assert found.log_bayes_factor == pytest.approx(0.0, abs=1e-9)


def test_a_discrepancy_is_judged_against_noise_that_is_not_known():
    """A noise that may be greater hides less than the greater noise alone: both sides are averaged over it."""
    rng = np.random.default_rng(8)
    values = rng.normal(size=N) + 1.5 * np.sin(np.linspace(0.0, 9.0, N))

    def at(scales):
        def averaged(columns):
            both = np.column_stack([columns, values])
            return [InnerProducts(0.0, 2.0 * N * np.log(scale), both.T @ both / scale**2) for scale in scales]

        return discrepancy(residuals(values, products_by_noise=averaged)).log_bayes_factor

    assert at([1.0]) == pytest.approx(discrepancy(residuals(values)).log_bayes_factor, abs=1e-9)
    assert at([1.0, 2.0]) > at([2.0]) + 3.0


def test_smooth_functions_have_the_squared_exponential_covariance():
    """Of places that repeat, too, and along a direction of each value's own."""
    places = np.array([[0.0], [0.2], [0.2], [0.7], [1.0]])
    directions = np.array([[1.0], [2.0], [-1.0], [0.5], [1.0]])
    axis = pointwise("time", "values against time", places, directions)
    basis = axis.smooth_columns(0.4)
    covariance = np.exp(-0.5 * ((places - places.T) / 0.4) ** 2) * (directions @ directions.T)
    np.testing.assert_allclose(basis @ basis.T, covariance, atol=1e-6)


@pytest.mark.parametrize("length", [0.06, 0.25, 1.0])
def test_nodes_stand_for_the_places_between_them(length):
    inputs = np.sort(np.random.default_rng(9).uniform(size=200))[:, None]
    axis = pointwise("depth", "values against depth", inputs)
    basis = axis.smooth_columns(length)
    covariance = np.exp(-0.5 * ((inputs - inputs.T) / length) ** 2)
    np.testing.assert_allclose(basis @ basis.T, covariance, atol=0.005 * (0.25 / length) ** 2 + 0.001)


def test_functions_in_two_dimensions_are_given_at_every_place():
    inputs = np.random.default_rng(10).normal(size=(40, 2))
    axis = pointwise("place", "values against place", inputs, np.ones((40, 2)))
    assert axis.functions == 2
    smooth = axis.smooth_columns(0.5)
    expected = 2.0 * np.exp(-2.0 * ((inputs[:, None] - inputs) ** 2).sum(2))
    np.testing.assert_allclose(smooth @ smooth.T, expected, atol=4e-4)


def test_functions_of_an_angle_go_on_where_the_circle_closes():
    """Squared-exponential in the chord of a circle of diameter one, whether at the angles themselves or between nodes."""
    angles = np.radians([-179.0, 179.0, 0.0, 40.0])
    chords = np.abs(np.sin(0.5 * (angles[:, None] - angles)))
    few = around("heading", "", angles[:, None], np.ones((4, 1)))
    many = np.concatenate([angles, np.linspace(-3.0, 3.0, 60)])
    between = around("heading", "", many[:, None], np.ones((len(many), 1)))
    for axis, allowed in ((few, 1e-3), (between, 0.03)):
        smooth = axis.smooth_columns(0.4)[:4]
        np.testing.assert_allclose(smooth @ smooth.T, np.exp(-0.5 * (chords / 0.4) ** 2), atol=allowed)
