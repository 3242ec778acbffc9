import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from simulate_missions import chesapeake

from missionplan.montecarlo.statistics import Count, RunningStatistic, RunningStatistics
from missionplan.results.failures import SUCCESS, Counted, CountedKind, Failure
from missionplan.studies.simulation.block_statistics import (
    BlockStatistics,
    Sampled,
    requirement_key,
    statistics_of_block,
)
from missionplan.studies.simulation.outcome_builder import histogram_from_sketch
from missionplan.studies.simulation.simulate import simulate_block

VALUES = arrays(np.float64, st.integers(1, 60), elements=st.floats(-1e6, 1e6) | st.just(np.nan))


def statistics_of(values):
    lost = Counted(CountedKind.FAILURE, "a", Failure.NOT_ARRIVED)
    counts = {SUCCESS: Count.of(values > 0.0), lost: Count.of(values < 0.0)}
    return BlockStatistics(RunningStatistics.of({"a.x_m": values}), counts, {(Sampled.INPUT, "x"): values})


def same(one, other):
    return all(
        a.tobytes() == b.tobytes() for a, b in zip(one.to_arrays().values(), other.to_arrays().values(), strict=True)
    )


@given(VALUES)
def test_statistics_are_restored_from_their_arrays(values):
    found = statistics_of(values)
    again = BlockStatistics.from_arrays(found.to_arrays())
    assert same(found, again)
    assert again.counts == found.counts
    assert again.trials == values.size


@given(st.lists(VALUES, min_size=2, max_size=4))
def test_merging_restored_statistics_gives_the_same_bits(blocks):
    direct = stored = statistics_of(blocks[0])
    for values in blocks[1:]:
        direct = direct.merge(statistics_of(values))
        stored = BlockStatistics.from_arrays(stored.to_arrays()).merge(
            BlockStatistics.from_arrays(statistics_of(values).to_arrays())
        )
    assert same(direct, stored)
    assert np.array_equal(direct.sample[Sampled.INPUT, "x"], np.concatenate(blocks), equal_nan=True)
    assert direct.trials == sum(values.size for values in blocks)


@given(VALUES)
def test_a_histogram_holds_every_trial_that_reached_the_quantity(values):
    found = histogram_from_sketch(RunningStatistic.of(values))
    assert found.counts.sum() == pytest.approx(np.count_nonzero(~np.isnan(values)))
    assert np.all(found.counts >= -1e-9)
    assert len(found.edges) == len(found.counts) + 1
    assert np.all(np.diff(found.edges) > 0.0)


@pytest.mark.parametrize("mean", [100.0, 1000.0, -30.0, 0.0])
def test_a_histogram_follows_the_distribution(mean):
    values = np.random.default_rng(2).normal(mean, 10.0, 200_000)
    found = histogram_from_sketch(RunningStatistic.of(values))
    inner = slice(1, -1)
    expected, _ = np.histogram(values, found.edges)
    assert found.counts[inner] == pytest.approx(expected[inner], abs=0.03 * expected.max())


def test_steps_lose_each_trial_once(tmp_path):
    changes = {"navigation.max_legs": 5, "phases.1.moor.radius": "5 m", "vehicle.energy.capacity": "26 W*h"}
    mission = chesapeake(tmp_path, changes)
    trials = simulate_block(mission, seed=1, block=0, trials=1000)
    found = statistics_of_block(mission, trials, sampled=False)
    lost = sum(count.successes for step, count in found.counts.items() if step.kind == "failure")
    assert lost == 1000 - found.counts[SUCCESS].successes
    assert found.sample == {}


def test_requirements_are_judged_in_their_units(tmp_path):
    mission = chesapeake(tmp_path)
    assert requirement_key(mission, "moor.offset") == ("moor.offset_m", "m")
    assert requirement_key(mission, "total.energy") == ("total.energy_wh", "J")
    assert requirement_key(mission, "ingress.surfacings") == ("ingress.surfacings", "")
    assert requirement_key(mission, "ingress.arrived") == ("ingress.arrived", None)
