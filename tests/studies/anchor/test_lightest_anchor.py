"""The search for the lightest anchor against shares in closed form, wherever the worst case's weight lies."""

from types import SimpleNamespace

import pytest

from missionplan.studies.anchor.lightest_anchor import Demand, _Tried, lightest_anchor


@pytest.mark.parametrize("start", [0.8, 3.0, 12.0, 60.0, 104.0, 500.0])
@pytest.mark.parametrize("has_height", [True, False])
def test_the_lightest_is_found_where_a_tenth_of_the_worst_case_is_too_heavy(start, has_height):
    """An anchor holds from 1 N on, and its dive is high enough up to 5.5 N, each in all dives or in none."""
    holds = Demand("holds", 0.8, lambda found: float(found.weight >= 1.0))
    high = Demand("high enough", 0.7, lambda found: float(1.0 <= found.weight <= 5.5), needs_height=True)
    demands = (holds, high) if has_height else (holds,)
    found = lightest_anchor(lambda weight, _line: SimpleNamespace(weight=weight), demands, start, 5.0)
    assert found.weight is not None
    assert 1.0 <= found.weight < 1.01


def test_of_weights_that_do_as_well_at_best_the_lightest_is_told():
    found = {
        weight: SimpleNamespace(share=share, within=SimpleNamespace(value=within))
        for weight, share, within in ((9.0, 0.5, 0.9), (11.0, 0.7, 0.95), (12.5, 0.7, 0.85), (14.0, 0.6, 0.8))
    }
    demand = Demand("dives succeed", 0.9, lambda each: each.share)
    tried = _Tried(None, [demand], None, 0.1, dict(found))
    assert tried._at_best(demand) == "dives succeed in 70.0 % of dives at best, with 11 N"
    assert "radius" not in tried.why_none(11.0)
    far = Demand("dives succeed", 0.96, lambda each: each.share)
    why = _Tried(None, [far, demand, far], None, 0.1, dict(found)).why_none(11.0)
    assert why == (
        "dives succeed in 70.0 % of dives at best, with 11 N; 95.0 % come down within the radius at best: drift before "
        "the line is taut. The best compromise, 11 N: dives succeed in 70.0 % of dives (96 % asked)"
    )


def test_what_no_weight_changes_is_not_told_of_one_and_the_compromise_does_the_rest():
    """An empty battery fails every dive: the anchor that comes nearest is one that comes down within the radius."""
    within = Demand("within", 0.9, lambda each: each.within.value)
    empty = Demand("success", 0.9, lambda each: 0.0)
    near = Demand("near", 0.9, lambda each: 0.89996)
    tried = _Tried(
        lambda weight, _line: SimpleNamespace(within=SimpleNamespace(value=0.95 if weight > 5.0 else 0.1)),
        *([within, empty, near], None, 0.1),
    )
    tried.slacks(1.0), tried.slacks(9.0), tried.slacks(20.0)
    assert 5.0 < tried.compromise() < 5.2
    why = tried.why_none(9.0)
    assert why.startswith("success in 0.0 % of dives, whatever the anchor weighs; near in 89.996 % of dives, whatever")
    assert "come down within" not in why


def test_of_weights_that_miss_by_as_much_the_lightest_is_the_compromise():
    demand = Demand("dives succeed", 0.9, lambda found: found.share)
    tried = _Tried(lambda weight, _line: SimpleNamespace(share=0.5 if weight > 4.5 else 0.3), [demand], 5.0, 0.1)
    tried.slacks(4.0), tried.slacks(5.0), tried.slacks(9.0)
    assert 4.5 < tried.compromise() < 4.6
