"""Coverage of prediction intervals, and the factor that would mend it."""

import numpy as np
import pytest

from missionplan.diagnosis.inference.model import HeldOutScore, interval_coverage


def scores(factor, groups=8, size=30, seed=1):
    z = factor * np.random.default_rng(seed).normal(size=(groups, size))
    return [HeldOutScore(str(k), 0.0, 0.0, 0, size, tuple(row)) for k, row in enumerate(z.tolist())]


def test_intervals_that_hold_are_left_alone():
    found = interval_coverage(scores(1.0))
    assert found.scale == 1.0
    assert not found.is_off
    assert found.inside == found.inside_scaled
    assert found.count == 240


@pytest.mark.parametrize("factor", [0.5, 1.6, 3.0])
def test_the_factor_is_found_and_assessed_on_other_groups(factor):
    found = interval_coverage(scores(factor))
    assert found.is_off
    assert found.scale == pytest.approx(factor, rel=0.15)
    assert found.inside_scaled / found.count == pytest.approx(0.9, abs=0.04)


def test_few_values_say_nothing():
    assert interval_coverage([]) is None
    assert interval_coverage(scores(5.0, groups=1)) is None
    assert not interval_coverage(scores(1.3, groups=4, size=2)).is_off
