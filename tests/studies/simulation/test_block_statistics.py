from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from simulate_missions import chesapeake

from missionplan.montecarlo.statistics import Count, RunningStatistic, RunningStatistics
from missionplan.phases.place import Cause, Contact
from missionplan.results.failures import MET, SUCCESS, Counted, CountedKind, Failure
from missionplan.studies.simulation.block_statistics import (
    BlockStatistics,
    Sampled,
    _contacts,
    _summed,
    requirement_key,
    statistics_of_block,
)
from missionplan.studies.simulation.outcome_builder import OutcomeBuilder, histogram_from_sketch
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


@pytest.mark.parametrize(
    ("side", "unit", "required", "reached"),
    [
        ("at_most", "s", 0.9, 900.0),
        ("at_least", "s", 0.9, 51.0),
        ("at_most", "J", 0.9, 900.0 * 3600.0),
        ("at_most", "s", 0.96, None),
        (None, None, 0.9, None),
    ],
)
def test_what_a_share_of_all_trials_reaches_counts_those_that_never_do(side, unit, required, reached):
    """Of a thousand trials the numbers 1 to 950 are known: of at least so many nine hundred are 51 and more."""
    running = RunningStatistic.of(np.append(np.arange(1.0, 951.0), np.full(50, np.nan)))
    builder = SimpleNamespace(totals=SimpleNamespace(statistics={"a.x": running}))
    found = OutcomeBuilder._reached(builder, "a.x", unit or "", side, required, 1000)
    assert found == (None if reached is None else pytest.approx(reached, rel=0.02))


def test_contacts_are_summed_by_phase_cause_and_leg_and_lie_where_they_do_on_average():
    """On land on legs 2, 2 and 1 of the second phase, aground once in the first; the last trial had failed before."""

    def phase(name, cause, leg, where, failed):
        contact = Contact(np.array(cause, dtype=np.int8), np.array(leg), np.array(where, dtype=float), np.empty((0, 5)))
        failures = {Failure.NOT_ARRIVED: np.array(failed)} | {reason: contact.of(each) for each, reason in MET.items()}
        return SimpleNamespace(name=name, contact=contact, failures=failures)

    no, land, ground = Cause.NONE, Cause.ON_LAND, Cause.AGROUND
    first = phase(
        "out", [no, no, no, ground, no], [0, 0, 0, 4, 0], [[0, 0, 0, 7, 0], [0, 0, 0, 8, 0]], [False] * 4 + [True]
    )
    second = phase(
        "back", [land, land, land, no, land], [2, 2, 1, 0, 3], [[1, 2, 6, 0, 9], [10, 20, 60, 0, 90]], [False] * 5
    )
    trials = SimpleNamespace(phases=(first, second), success=np.zeros(5, dtype=bool))
    rows = _summed(_contacts(trials))
    mission = SimpleNamespace(phases=[SimpleNamespace(label="out"), SimpleNamespace(label="back")])
    found = list(
        OutcomeBuilder._contacts(SimpleNamespace(totals=SimpleNamespace(contacts=rows, trials=5), mission=mission))
    )
    told = {(each.phase, str(each.cause)): (each.lost.value, each.legs, each.east, each.north) for each in found}
    assert told == {
        ("out", str(MET[ground])): (0.2, {"4": 1}, 7.0, 8.0),
        ("back", str(MET[land])): (0.6, {"1": 1, "2": 2}, 3.0, 30.0),
    }
