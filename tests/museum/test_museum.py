"""The first pair of the museum, and that its recipes are what they say."""

from dataclasses import replace

import numpy as np
import pytest

from tests.learned import moments

from .__main__ import diagnosed, figures, is_described, is_flagged, lines_of
from .faults import CURRENT, PAIRS, errors_of, log_of_pair, still_speed, through_water
from .outside import SEEN, beyond_the_named, sized
from .sailing import Log, Recipe, drawn, velocity_errors


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


@pytest.mark.slow
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


def test_named_effects_of_any_size_hold_nothing_beyond_the_named():
    log = drawn(np.random.default_rng(4), 40)
    large = Recipe(turn=lambda m: 0.4 + 0.5 * np.cos(m.heading), pace=lambda m: 1.2, water=lambda m: CURRENT)
    assert beyond_the_named(log, velocity_errors(log, large)) < 1e-6
    log = replace(log, speeds=np.resize([1.0, 1.3, 1.6], len(log.speeds)))
    slips = Recipe(turn=lambda m: 0.2 / m.speed**2 - 0.1, water=lambda m: CURRENT, along=0.4)
    assert beyond_the_named(log, velocity_errors(log, slips)) < 1e-6
    loses = Recipe(pace=lambda m: 1.0 - 0.3 * max(m.speed - 1.3, 0.0) / m.speed)
    assert beyond_the_named(log, velocity_errors(log, loses)) < 1e-6
    twice = Recipe(turn=lambda m: 0.1 * np.cos(2.0 * m.heading))
    assert beyond_the_named(log, velocity_errors(log, twice)) > 20.0


@pytest.mark.slow
def test_what_goes_by_heading_and_depth_together_is_seen():
    """A deviation that fades with depth is no effect with a name."""
    log = drawn(np.random.default_rng(2), 60)
    log = replace(log, depths=np.random.default_rng(3).uniform(5.0, 150.0, 60))
    errors = sized(SEEN["deviation that fades with depth"], log, 60.0, 5)
    found = diagnosed(log, errors, seed=5)
    assert is_flagged(found)
    assert found.none_of_these > 0.95


@pytest.mark.slow
def test_a_named_effect_is_still_named():
    assert figures(lines_of([("named", k) for k in range(4)], 7, None)) == ["with a named effect: named 4 of 4"]


@pytest.mark.slow
def test_an_answer_to_the_current_beyond_what_the_effect_knows_is_no_deviation_of_the_compass():
    """A hull that turns into the current answers along its course with far more than across it."""
    found = diagnosed(*fossen(Recipe(water=lambda m: CURRENT, along=3.0)), seed=5)
    assert is_flagged(found)
    assert "compass-deviation" not in found.causes
    assert found.none_of_these > 0.95


@pytest.mark.slow
def test_a_compass_that_is_off_until_a_moment_is_no_bias_that_a_jump_takes_back():
    found = diagnosed(*fossen(Recipe(turn=lambda m: 0.07 if m.t < 15000.0 else 0.0)), seed=5)
    assert found.causes == ("response",)
    sizes = {each.name: each for each in found.best.parameters}
    assert abs(sizes["abeam_before"].value - 0.07) < 3.0 * sizes["abeam_before"].sd
    assert sizes["moment"].value == pytest.approx(15000.0, abs=1000.0)


@pytest.mark.slow
def test_what_is_beside_a_heading_error_by_depth_is_seen():
    log = drawn(np.random.default_rng(8), 60)
    log = replace(log, depths=np.random.default_rng(3).uniform(5.0, 150.0, 60))
    errors = sized(SEEN["heading by the square of depth"], log, 50.0, 5)
    found = diagnosed(log, errors, seed=5)
    assert is_flagged(found)
    assert found.none_of_these > 0.5


@pytest.mark.slow
def test_speed_that_goes_by_the_course_is_no_answer_to_a_current():
    """Of a faint current an answer many times as large as the effect's is the same: a fit of it settles elsewhere."""
    log = drawn(np.random.default_rng(10), 80)
    log = replace(log, speeds=np.full_like(log.speeds, 1.4), depths=np.full_like(log.depths, 20.0))
    found = diagnosed(log, velocity_errors(log, Recipe(pace=lambda m: 1.0 + 0.3 * np.cos(m.heading - 4.0))), seed=5)
    assert is_flagged(found)
    assert "current-response" not in found.causes
    assert found.none_of_these > 0.95
