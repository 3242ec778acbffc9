"""How many trials, and how many successes of them, decide whether a share is above a probability."""

import math

from hypothesis import given
from hypothesis import strategies as st

from missionplan.montecarlo.statistics import successes_to_decide, trials_to_decide, wilson


@given(share=st.integers(1, 99), required=st.integers(1, 99))
def test_the_interval_excludes_the_probability_from_that_number_on(share, required):
    trials = trials_to_decide(share / 100.0, required / 100.0)
    if share == required:
        assert trials is None
        return
    assert trials is not None
    above = 100 * math.ceil(trials / 100.0)  # so that the share is one of whole trials
    found = wilson(above * share // 100, above)
    assert not found.low <= required / 100.0 <= found.high
    below = 100 * ((trials - 1) // 100)
    found = wilson(below * share // 100, below)
    assert found.low <= required / 100.0 <= found.high


@given(required=st.integers(1, 999), trials=st.integers(1, 5000))
def test_the_interval_lies_above_the_probability_from_that_many_successes_on(required, trials):
    successes = successes_to_decide(required / 1000.0, trials)
    if successes <= trials:
        assert wilson(successes, trials).low > required / 1000.0
    assert wilson(successes - 1, trials).low <= required / 1000.0 + 1e-12
