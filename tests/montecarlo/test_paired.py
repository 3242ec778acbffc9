"""Alternatives as good as the best on common random numbers, and the front."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.stats import binomtest, ttest_rel

from missionplan.montecarlo.alternatives import compare_with_best, paired_difference, pareto_front


def test_events_are_compared_by_the_sign_test():
    rng = np.random.default_rng(1)
    first, second = rng.random(500) < 0.9, rng.random(500) < 0.85
    found = compare_with_best([first, second], 0, most=True)
    losses, wins = int((first & ~second).sum()), int((second & ~first).sum())
    expected = binomtest(losses, losses + wins, 0.5, alternative="greater").pvalue
    assert found.as_good[1] == (expected >= 0.05)
    assert found.worse[1] == pytest.approx(first.mean() - second.mean())


def test_numbers_are_compared_by_their_mean_difference():
    rng = np.random.default_rng(2)
    common = rng.normal(size=400)
    first, second = common, common + 0.01 + 0.001 * rng.normal(size=400)
    found = compare_with_best([first, second], 0, most=False)
    result = ttest_rel(second, first)
    assert found.worse[1] / found.error[1] == pytest.approx(result.statistic)
    assert found.as_good.tolist() == [True, False]


def test_a_value_that_one_lacks_leaves_the_pair_out():
    first, second = np.array([1.0, 2.0, np.nan]), np.array([1.0, 2.5, 7.0])
    assert compare_with_best([first, second], 0, most=False).worse[1] == 0.25


def test_the_truly_best_is_left_out_in_at_most_five_percent_of_runs():
    rng = np.random.default_rng(3)
    left_out = 0
    for _ in range(400):  # ten alternatives, all alike: any may be the best
        values = list(rng.random((10, 120)) < 0.8)
        best = int(np.argmax([each.mean() for each in values]))
        left_out += not compare_with_best(values, best, most=True).as_good[0]
    assert left_out <= 0.05 * 400 + 2 * np.sqrt(0.05 * 0.95 * 400)


@given(arrays(float, st.tuples(st.integers(1, 12), st.just(3)), elements=st.sampled_from([0.0, 1.0, 2.0, np.nan])))
def test_nothing_beats_the_front_and_something_beats_the_rest(costs):
    front = pareto_front(costs)
    for index, cost in enumerate(costs):
        beaten = any((other <= cost).all() and (other < cost).any() for other in costs)
        assert front[index] == (bool(np.isfinite(cost).all()) and not beaten)


def test_one_pair_tells_no_difference_from_chance():
    mean, error, chance = paired_difference(np.array([27.1]), np.array([27.8]), most=False)
    assert (mean, chance) == (pytest.approx(0.7), 1.0)
    assert np.isnan(error)
