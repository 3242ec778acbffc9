import functools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy import stats

from missionplan.montecarlo.quantile_sketch import QuantileSketch
from missionplan.montecarlo.statistics import Count, Moments, RunningStatistic, RunningStatistics, Statistic, wilson
from missionplan.montecarlo.streams import stream

VALUES = st.floats(-1e6, 1e6, allow_subnormal=False)


@given(st.lists(arrays(float, st.integers(1, 30), elements=VALUES), min_size=1, max_size=6))
def test_merged_moments_are_those_of_all_values(parts):
    merged = functools.reduce(Moments.merge, map(Moments.of, parts))
    values = np.concatenate(parts)
    assert merged.count == values.size
    assert merged.mean == pytest.approx(values.mean(), rel=1e-9, abs=1e-6)
    assert (merged.low, merged.high) == (values.min(), values.max())
    if values.size > 1:
        assert merged.variance == pytest.approx(values.var(ddof=1), rel=1e-6, abs=1e-3)


def test_moments_of_many_quantities_at_once():
    values = stream(1, "x", 0).standard_normal((3, 5, 400))
    merged = Moments.of(values[..., :100]).merge(Moments.of(values[..., 100:]))
    assert merged.mean == pytest.approx(values.mean(axis=-1))
    assert merged.standard_error == pytest.approx(values.std(axis=-1, ddof=1) / 20.0)


def test_trials_that_never_reached_the_quantity_are_left_out_and_counted():
    running = RunningStatistic.of(np.array([1.0, math.nan, 3.0])).merge(RunningStatistic.of(np.full(4, math.nan)))
    statistic = running.statistic()
    assert (statistic.count, statistic.missing, statistic.mean) == (2, 5, 2.0)
    nobody = RunningStatistic.of(np.full(4, math.nan)).statistic()
    assert set(nobody.summary().values()) == {None}
    assert nobody.missing == 4


@pytest.mark.parametrize("constant", [0.0, 12.5, -3e-4, 1e11])
def test_a_constant_gives_itself(constant):
    statistic = RunningStatistic.of(np.full(500, constant)).statistic()
    assert statistic.summary() == {
        "mean": pytest.approx(constant, rel=1e-12),
        "sd": pytest.approx(0.0, abs=1e-12 * abs(constant)),
        "p05": constant,
        "p50": constant,
        "p95": constant,
        "standard_error": pytest.approx(0.0, abs=1e-12 * abs(constant)),
    }


@pytest.mark.parametrize("theory", [stats.norm(0.0, 30.0), stats.lognorm(1.5, scale=100.0), stats.uniform(-5.0, 4.0)])
def test_quantiles_are_those_of_the_sample(theory):
    values = theory.ppf(stream(2, "q", 0).uniform(size=40_000))
    running = functools.reduce(RunningStatistic.merge, map(RunningStatistic.of, np.split(values, 10)))
    for probability in (0.01, 0.05, 0.5, 0.95, 0.999):
        rank = np.sort(values)[int(probability * (values.size - 1))]
        assert running.quantile(probability) == pytest.approx(rank, rel=0.0011)


@given(arrays(float, st.integers(1, 60), elements=VALUES), st.floats(0, 1))
def test_a_quantile_lies_next_to_an_order_statistic(values, probability):
    found = RunningStatistic.of(values).quantile(probability)
    rank = np.sort(values)[math.floor(probability * (values.size - 1))]
    assert found == pytest.approx(rank, rel=0.0011, abs=1e-8)


def test_sketches_merge_exactly_in_any_order():
    parts = [QuantileSketch.of(stream(3, "m", block).standard_normal(1000)) for block in range(4)]
    forwards, backwards = (functools.reduce(QuantileSketch.merge, some) for some in (parts, parts[::-1]))
    assert forwards.first == backwards.first
    assert np.array_equal(forwards.counts, backwards.counts)


@given(st.lists(arrays(float, 20, elements=VALUES | st.just(math.nan)), min_size=1, max_size=5))
def test_several_quantities_at_once_are_as_one_by_one(rows):
    found = RunningStatistics.of({str(index): row for index, row in enumerate(rows)})
    merged = found.merge(found)
    for index, row in enumerate(rows):
        alone = RunningStatistic.of(row)
        for several, one in ((found, alone), (merged, alone.merge(alone))):
            assert several[str(index)].statistic().summary() == one.statistic().summary()
            assert several[str(index)].sketch.first == one.sketch.first
            assert several[str(index)].sketch.counts.tobytes() == one.sketch.counts.tobytes()
    with pytest.raises(KeyError):
        found["another"]


@given(arrays(float, st.integers(1, 60), elements=st.floats(-1e12, 1e12)))
def test_the_middle_of_a_bin_is_within_half_a_thousandth_of_what_it_holds(values):
    sketch = QuantileSketch.of(values)
    low, high = sketch.bounds()
    assert np.all(low[1:] >= high[:-1])
    for value in values:
        held = (low <= value) & (value <= high)
        assert held.any()
        near = np.min(np.abs(0.5 * (low + high) - value)[held])
        assert near <= max(2.0**-11 * abs(value), 2.0**-30)


@given(arrays(float, st.integers(1, 60), elements=VALUES), st.lists(VALUES, min_size=1, max_size=9))
def test_values_below_a_limit_are_counted_but_for_those_in_its_bin(values, limits):
    found = RunningStatistic.of(values).count_below(np.array(limits))
    for limit, below in zip(limits, found, strict=True):
        width = max(1.001 * abs(limit) / 1024.0, 2.0**-29)
        assert np.count_nonzero(values < limit - width) - 1e-9 <= below
        assert below <= np.count_nonzero(values <= limit + width) + 1e-9


def test_within_a_bin_values_are_taken_to_lie_evenly():
    running = RunningStatistic.of(np.array([1024.0, 1024.2, 1024.6, 1024.8, 2000.0]))
    assert running.count_below(np.array([1024.0, 1024.25, 1024.5, 1025.0, 1500.0])) == pytest.approx([0, 1, 2, 4, 4])


@pytest.mark.parametrize(("value", "trials"), [(0.0, 1), (12.5, 4096), (-3.0, 7)])
def test_many_trials_of_the_same_value(value, trials):
    found, one_by_one = Statistic.of_constant(value, trials), RunningStatistic.of(np.full(trials, value)).statistic()
    assert found.summary() == one_by_one.summary()
    assert (found.count, found.missing) == (trials, 0)


def test_memory_is_bounded_however_many_the_trials():
    running = RunningStatistic.of(np.zeros(1))
    for block in range(40):
        running = running.merge(RunningStatistic.of(stream(4, "wide", block).lognormal(5.0, 3.0, 4096)))
    assert running.sketch.counts.nbytes < 500_000


def test_extreme_values_are_kept_within_range():
    running = RunningStatistic.of(np.array([1e140, 1e140, -1e-300, 5e-324]))
    assert running.quantile(0.0) <= 0.0
    assert running.quantile(0.999) == pytest.approx(1e140, rel=0.0011)


@pytest.mark.parametrize(("successes", "trials"), [(0, 10), (3, 10), (10, 10), (9500, 10_000)])
def test_wilson_interval_is_scipys(successes, trials):
    theory = stats.binomtest(successes, trials).proportion_ci(method="wilson")
    found = Count(successes, trials).probability()
    assert found.value == successes / trials
    assert (found.low, found.high) == pytest.approx((theory.low, theory.high), abs=1e-12)


def test_probability_of_nothing_is_unknown():
    assert math.isnan(wilson(0, 0).value)
    assert (wilson(0, 0).low, wilson(0, 0).high) == (0.0, 1.0)


def test_counts_add():
    merged = Count.of(np.array([True, False])).merge(Count.of(np.array([True, True, True])))
    assert merged == Count(4, 5)
