"""Random velocity errors: what `step` draws has the covariance that the diagnosis fits."""

import numpy as np
import pytest
from scipy import stats

from missionplan.effects.fix_error import FixError
from missionplan.effects.heavy_tails import HeavyTails
from missionplan.effects.persistent_error import PersistentError
from missionplan.effects.position_random_walk import PositionRandomWalk
from missionplan.effects.random_walk import RandomWalk
from missionplan.phases.hooks import Leg

LEG = Leg(np.zeros(1), np.ones(1), np.zeros((2, 1)), np.array([[0.0], [1.0]]), 1.0)
TIMES = np.array([0.0, 700.0, 1500.0, 4000.0, 4600.0])
DRAWS = 40_000


@pytest.mark.parametrize("effect", [PersistentError(0.08, 2500.0), RandomWalk(9e-4)], ids=["persistent", "walk"])
def test_sampled_covariance_is_the_one_of_the_diagnosis(effect):
    rng = np.random.default_rng(7)
    memory, path = None, []
    for elapsed in np.diff(TIMES, prepend=-350.0):
        memory, velocity = effect.step(memory, np.full(DRAWS, elapsed), rng.normal(size=(2, DRAWS)), LEG)
        path.append(velocity)
    east, north = np.stack(path).transpose(1, 0, 2)
    expected = effect.covariance(TIMES)
    spread = np.sqrt((np.outer(np.diag(expected), np.diag(expected)) + expected**2) / DRAWS)
    assert np.all(np.abs(np.cov(east) - expected) <= 4.5 * spread + 1e-15)
    assert np.all(np.abs(np.cov(north) - expected) <= 4.5 * spread + 1e-15)
    cross = np.cov(east, north)[: len(TIMES), len(TIMES) :]
    assert np.all(np.abs(cross) <= 4.5 * np.sqrt(np.outer(np.diag(expected), np.diag(expected)) / DRAWS) + 1e-15)


def test_persistent_error_has_an_exact_step():
    """Two steps of half the time are distributed as one: transition factors multiply and variances add."""
    effect = PersistentError(0.1, 1000.0)
    zero, one = np.zeros((2, 1)), np.ones((2, 1))
    kept_half = effect.step(one, np.array([300.0]), zero, LEG)[1]
    kept_full = effect.step(one, np.array([600.0]), zero, LEG)[1]
    np.testing.assert_allclose(kept_half**2, kept_full)
    spread_half = effect.step(zero, np.array([300.0]), one, LEG)[1]
    spread_full = effect.step(zero, np.array([600.0]), one, LEG)[1]
    np.testing.assert_allclose(spread_half**2 * (1.0 + kept_half**2), spread_full**2)


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
