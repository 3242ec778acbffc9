"""Sensitivities against closed forms."""

import math

import numpy as np
import pytest
from scipy import stats

from missionplan.montecarlo.sensitivity import MIN_TRIALS, Source, first_order_index, sensitivities


def index_of(x, y):
    return first_order_index(Source.of(x), y)


def test_linear_model_has_the_shares_of_its_coefficients():
    random = np.random.default_rng(1)
    x = random.standard_normal((3, 20_000))
    found = sensitivities({"a": x[0], "b": x[1], "c": x[2]}, {"y": 3.0 * x[0] - 2.0 * x[1] + 1.0 * x[2]})
    assert [influence.source for influence in found] == ["a", "b", "c"]
    for influence, share, sign in zip(found, (9 / 14, 4 / 14, 1 / 14), (1, -1, 1), strict=True):
        assert influence.first_order == pytest.approx(share, abs=4.0 * influence.standard_error)
        assert influence.standard_error < 0.01
        # Spearman's correlation of a bivariate normal with Pearson's r: (6/pi) asin(r/2).
        pearson = sign * math.sqrt(share)
        assert influence.rank_correlation == pytest.approx(6.0 / math.pi * math.asin(pearson / 2.0), abs=0.02)


def test_ishigami_function():
    """First-order indices of Ishigami & Homma (1990): 0.3139, 0.4424, 0; rank correlation misses the second."""
    a, b = 7.0, 0.1
    random = np.random.default_rng(2)
    x1, x2, x3 = random.uniform(-math.pi, math.pi, (3, 40_000))
    y = np.sin(x1) + a * np.sin(x2) ** 2 + b * x3**4 * np.sin(x1)
    variance = a**2 / 8 + b * math.pi**4 / 5 + b**2 * math.pi**8 / 18 + 0.5
    exact = {"x1": 0.5 * (1 + b * math.pi**4 / 5) ** 2 / variance, "x2": a**2 / 8 / variance, "x3": 0.0}
    found = {influence.source: influence for influence in sensitivities({"x1": x1, "x2": x2, "x3": x3}, {"y": y})}
    for name, share in exact.items():
        assert found[name].first_order == pytest.approx(share, abs=4.0 * found[name].standard_error + 1e-3)
    assert abs(found["x2"].rank_correlation) < 0.02


def test_an_input_without_influence_has_an_index_of_zero_on_average_and_a_cautious_standard_error():
    random = np.random.default_rng(3)
    samples = [index_of(*random.standard_normal((2, 1_000))) for _ in range(300)]
    index, error = np.array(samples).T
    assert abs(index.mean()) < 4.0 * index.std() / math.sqrt(len(index))
    # The jackknife doubles the variance of a degenerate quadratic statistic (Efron & Stein 1981).
    assert 1.0 < error.mean() / index.std() < 1.1 * math.sqrt(2.0)


def test_the_standard_error_is_the_spread_of_repeated_estimates():
    random = np.random.default_rng(4)
    samples = []
    for _ in range(300):
        x, noise = random.standard_normal((2, 2_000))
        samples.append(index_of(x, x + noise))
    index, error = np.array(samples).T
    assert index.mean() == pytest.approx(0.5, abs=0.005)
    assert error.mean() == pytest.approx(index.std(), rel=0.2)


def test_choices_are_classes():
    random = np.random.default_rng(5)
    x = random.choice([1.0, 2.0, 5.0], 5_000)
    y = np.where(x == 2.0, 1.0, 0.0) + random.standard_normal(5_000)
    index, error = index_of(x, y)
    assert index == pytest.approx((2 / 9) / (1 + 2 / 9), abs=4.0 * error)


def test_classes_are_of_equal_counts_but_for_equal_values():
    """Half of the draws are nil: they are one class, and the others have as many each as they would have alone."""
    draws = np.append(np.zeros(2_000), np.random.default_rng(8).random(2_000) + 1.0)
    _, counts = np.unique(Source.of(draws).classes, return_counts=True)
    assert counts.tolist() == pytest.approx([2_000] + [200] * 10, abs=1)


@pytest.mark.parametrize(("scale", "shift"), [(1.0, 0.0), (1e-6, 1e3), (1e6, -1e9)])
def test_units_do_not_matter(scale, shift):
    random = np.random.default_rng(6)
    x, noise = random.standard_normal((2, 1_000))
    assert index_of(x * 1e3 + 5e5, (x + noise) * scale + shift) == pytest.approx(index_of(x, x + noise), rel=1e-4)


def test_trials_that_never_reached_an_output_are_left_out_of_it():
    random = np.random.default_rng(7)
    x = random.standard_normal(2_000)
    y = np.where(np.arange(2_000) % 2, x, np.nan)
    (found,) = sensitivities({"x": x}, {"y": y})
    assert found.first_order == pytest.approx(1.0)


def test_what_does_not_vary_or_was_hardly_reached_is_left_out():
    x = np.random.default_rng(8).standard_normal(MIN_TRIALS)
    outputs = {"constant": 1.5 + 1e-12 * x, "rare": np.where(np.arange(MIN_TRIALS), x, np.nan), "y": x}
    found = sensitivities({"x": x, "fixed": np.zeros_like(x)}, outputs)
    assert [(influence.output, influence.source) for influence in found] == [("y", "x")]


def test_rank_correlation_of_ties_is_spearmans():
    random = np.random.default_rng(9)
    x = random.choice([1.0, 2.0, 5.0], 400, p=[0.6, 0.3, 0.1])
    y = np.round(x + random.standard_normal(400))
    (found,) = sensitivities({"x": x}, {"y": y})
    assert found.rank_correlation == pytest.approx(stats.spearmanr(x, y).statistic)


def test_an_event_of_one_trial_has_an_index_with_an_error():
    """Left out with its group, nothing of the event varies any more."""
    x = np.random.default_rng(10).standard_normal(MIN_TRIALS)
    for event in (0.0, 1.0):
        y = np.full(MIN_TRIALS, 1.0 - event)
        y[17] = event
        (found,) = sensitivities({"x": x}, {"y": y})
        assert np.isfinite([found.first_order, found.standard_error]).all()
