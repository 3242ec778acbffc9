import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from missionplan.phases.transit.plan import LegTable, LegTables


def test_one_length_kinks_where_the_target_comes_within_reach():
    table = LegTable(np.array([0.0]), np.array([300.0]))
    assert table(np.array([10.0, 300.0, 900.0])).tolist() == [10.0, 300.0, 300.0]
    assert 300.0 in table.kinks


@given(st.lists(st.floats(1.0, 100.0), min_size=1, max_size=6), st.lists(st.floats(1.0, 300.0), min_size=6, max_size=6))
def test_the_leg_is_straight_between_kinks(steps, lengths):
    table = LegTable(np.cumsum(steps), np.array(lengths[: len(steps)]))
    edges = np.concatenate(([0.0], table.kinks, [max(table.kinks[-1], 300.0) + 50.0]))
    for low, high in itertools.pairwise(edges):
        low_, middle, high_ = table(np.array([low, 0.5 * (low + high), high]))
        assert middle == pytest.approx(0.5 * (low_ + high_), rel=1e-6, abs=1e-6)


def test_several_tables_give_each_trial_its_own_also_when_few_are_left():
    first, second = (
        LegTable(np.array([0.0]), np.array([300.0])),
        LegTable(np.array([100.0, 400.0]), np.array([50.0, 200.0])),
    )
    both = LegTables([first, second, first], np.array([2, 4, 6]))
    left = np.array([10.0, 900.0, 250.0, 900.0, 500.0, 200.0])
    assert both(left).tolist() == [10.0, 300.0, 125.0, 200.0, 300.0, 200.0]
    kept = np.array([1, 4, 5])
    fewer = both.take(kept)
    assert len(fewer.tables) == 2
    assert fewer(left[kept]).tolist() == both(left)[kept].tolist()
