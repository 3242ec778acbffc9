"""Random velocity errors: what `step` draws has the covariance that the diagnosis fits."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from missionplan.diagnosis.legs.likelihood.markov_covariance import MarkovCovariance
from missionplan.effects.random_errors import FixError, HeavyTails, PersistentError, PositionRandomWalk, RandomWalk
from missionplan.phases.hooks import Leg

LEG = Leg(np.zeros(1), np.ones(1), np.zeros((2, 1)), np.array([[0.0], [1.0]]), 1.0)
TIMES = np.array([0.0, 700.0, 1500.0, 4000.0, 4600.0])
DURATIONS = np.array([600.0, 650.0, 2400.0, 500.0, 900.0])
DRAWS = 40_000


@pytest.mark.parametrize("effect", [PersistentError(0.08, 2500.0), RandomWalk(9e-4)], ids=["persistent", "walk"])
def test_sampled_covariance_is_the_one_of_the_diagnosis(effect):
    rng = np.random.default_rng(7)
    memory, path, middle = None, [], TIMES + 0.5 * DURATIONS
    for elapsed, duration in zip(np.diff(middle, prepend=0.0), DURATIONS, strict=True):
        leg = replace(LEG, duration=np.full(DRAWS, duration))
        memory, velocity = effect.step(memory, np.full(DRAWS, elapsed), rng.normal(size=(2, DRAWS)), leg)
        path.append(velocity)
    east, north = np.stack(path).transpose(1, 0, 2)
    between = np.append(np.nan, TIMES[1:] - (TIMES + DURATIONS)[:-1])
    expected = MarkovCovariance(DURATIONS, TIMES, between, np.zeros(len(TIMES))).dense(np.zeros(2), 0.0, effect)[0]
    spread = np.sqrt((np.outer(np.diag(expected), np.diag(expected)) + expected**2) / DRAWS)
    assert np.all(np.abs(np.cov(east) - expected) <= 4.5 * spread + 1e-15)
    assert np.all(np.abs(np.cov(north) - expected) <= 4.5 * spread + 1e-15)
    cross = np.cov(east, north)[: len(TIMES), len(TIMES) :]
    assert np.all(np.abs(cross) <= 4.5 * np.sqrt(np.outer(np.diag(expected), np.diag(expected)) / DRAWS) + 1e-15)


@pytest.mark.parametrize("effect", [PersistentError(0.08, 2500.0), RandomWalk(9e-4)], ids=["persistent", "walk"])
def test_a_leg_in_two_parts_drifts_as_far(effect):
    """The mean over a leg, and that of the means over its halves without a pause, have the same variance."""
    rng = np.random.default_rng(8)
    whole, half = (replace(LEG, duration=np.full(DRAWS, duration)) for duration in (3000.0, 1500.0))
    together = effect.step(None, np.zeros(DRAWS), rng.normal(size=(2, DRAWS)), whole)[1]
    memory, first = effect.step(None, np.zeros(DRAWS), rng.normal(size=(2, DRAWS)), half)
    second = effect.step(memory, np.full(DRAWS, 1500.0), rng.normal(size=(2, DRAWS)), half)[1]
    assert np.var(0.5 * (first + second)) == pytest.approx(np.var(together), rel=6.0 * (2.0 * DRAWS) ** -0.5)


def test_persistent_error_has_an_exact_transition():
    """Two steps of half the time are distributed as one: what is kept multiplies, and variances add."""
    effect = PersistentError(0.1, 1000.0)
    (kept_half,), (added_half,) = effect.transition(np.array([300.0]))
    (kept,), (added,) = effect.transition(np.array([600.0]))
    assert kept_half**2 == pytest.approx(kept)
    assert added_half * (1.0 + kept_half**2) == pytest.approx(added)


def test_a_leg_of_no_duration_has_the_velocity_of_its_instant():
    """A vehicle that has arrived: no division by nil."""
    nothing = replace(LEG, duration=np.zeros(1))
    for effect, expected in ((PersistentError(0.1, 1000.0), 0.1), (RandomWalk(1e-3), 0.0)):
        memory, velocity = effect.step(None, np.zeros(1), np.ones((2, 1)), nothing)
        np.testing.assert_allclose(velocity, expected)
        np.testing.assert_allclose(memory[:2], expected)


def test_heavy_tails_are_student_t_of_the_same_covariance():
    rng = np.random.default_rng(11)
    dof = 5.0
    errors = rng.normal(size=(2, DRAWS)) * HeavyTails(dof).error_scale(rng.normal(size=(2, DRAWS)))
    scaled = errors[0] * np.sqrt(dof / (dof - 2.0))
    assert stats.kstest(scaled, stats.t(dof).cdf).pvalue > 1e-3
    np.testing.assert_allclose(np.cov(errors), np.eye(2), atol=0.06)


def test_heavy_tails_take_one_dof_a_trial():
    scale = HeavyTails(np.array([np.inf, 4.0])).error_scale(np.full((2, 2), 0.3))
    assert scale[0] == 1.0
    assert scale[1] != 1.0


def test_fix_error_adds_its_variance():
    assert FixError(20.0).fix_variance() == 400.0


def test_a_position_walk_draws_normals_where_it_has_a_rate():
    assert PositionRandomWalk(2.0).position_variance_rate() == 4.0
    assert PositionRandomWalk(2.0).is_random
    assert not PositionRandomWalk(0.0).is_random
