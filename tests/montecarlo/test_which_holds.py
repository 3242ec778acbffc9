"""Which explanation holds: a number drawn with given probabilities, from one normal."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from missionplan.montecarlo.distributions import WhichHolds

SHARES = st.lists(st.floats(0.01, 1.0), min_size=1, max_size=5).map(
    lambda found: tuple(np.array(found) / max(1.0, sum(found)))
)


@given(SHARES)
def test_the_numbers_have_their_probabilities(shares):
    which = WhichHolds(shares)
    left = 1.0 - sum(shares)
    for number, share in enumerate(shares):
        assert which.cdf(number) - which.cdf(number - 1) == pytest.approx(share, abs=1e-8)
    assert which.cdf(len(shares)) == 1.0
    assert which.mean == np.argmax([*shares, left])
    numbers = np.arange(len(shares) + 1)
    moments = np.array([*shares, max(left, 0.0)])
    assert which.sd == pytest.approx(
        np.sqrt(np.average((numbers - np.average(numbers, weights=moments)) ** 2, weights=moments))
    )


@given(SHARES, st.floats(-8.0, 8.0))
def test_a_draw_is_the_quantile_of_its_normal(shares, z):
    which = WhichHolds(shares)
    (drawn,) = which.from_normal(np.array([z]))
    assert drawn in range(len(shares) + 1)
    assert which.from_normal(np.array([z + 1.0]))[0] >= drawn


def test_probabilities_that_leave_rounding_alone_always_hold_one():
    drawn = WhichHolds((0.1,) * 10).from_normal(np.array([-38.0, 0.0, 38.0]))
    assert drawn[[0, 2]].tolist() == [0.0, 9.0]
