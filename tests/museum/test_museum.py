"""The first pair of the museum, and that its recipes are what they say."""

import numpy as np
import pytest

from tests.learned import moments

from .__main__ import diagnosed, is_described, named_figures
from .faults import CURRENT, PAIRS, errors_of, log_of_pair, still_speed, through_water
from .sailing import Log, Recipe, velocity_errors


def fossen(recipe, seed=5):
    log = log_of_pair(np.random.default_rng(seed))
    log = Log(log.headings, log.under_way, np.full_like(log.speeds, still_speed()), log.depths, 0.015, 2.0)
    return log, velocity_errors(log, recipe)


def test_advance_speed_over_the_ground_undoes_a_part_of_a_current_along_the_course():
    """With a current the thrust falls as the speed over the ground rises, so that the speed through the water falls."""
    still = through_water(0.0, over_ground=True)
    with_it, against_it = (through_water(w, over_ground=True) for w in (0.15, -0.15))
    assert with_it < still < against_it
    assert through_water(0.15, over_ground=False) == pytest.approx(still)
    assert 0.3 < 1.0 - (still - with_it) / 0.15 < 0.8


def test_the_changed_term_is_described_before_the_mend():
    pair = PAIRS["advance speed over the ground"]
    found = diagnosed(*fossen(pair.before), seed=5)
    assert is_described(found, pair)
    sizes = {(each.effect, each.name): each for each in found.best.parameters}
    still, with_it = (through_water(w, over_ground=True) for w in (0.0, 0.15))
    answer = sizes["current-response", "along"]
    assert abs(answer.value - (with_it - still) / 0.15) < 3.0 * answer.sd
    current = [sizes["mean-current", side] for side in ("east", "north")]
    carried, _ = moments(found.extended, "current-response", "along")
    assert carried == pytest.approx(answer.value, abs=0.03)
    assert all(abs(each.value - true) < 3.0 * each.sd for each, true in zip(current, CURRENT, strict=True))


def test_a_fault_that_is_none_errs_nothing():
    log, errors = fossen(Recipe())
    assert errors_of(errors) < 1e-12
    assert log.headings.size == errors.shape[0]


@pytest.mark.slow
def test_a_named_effect_is_still_named():
    assert "named 4 of 4" in named_figures(4, 7)[0]
