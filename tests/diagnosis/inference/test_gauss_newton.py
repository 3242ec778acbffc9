"""Damped Gauss–Newton: closed forms of linear models, steps that are shortened, starts that are abandoned."""

import numpy as np
import pytest

from missionplan.diagnosis.inference.block_covariance import BlockCovariance
from missionplan.diagnosis.inference.gauss_newton import (
    GaussNewtonOptions,
    LeastSquares,
    Start,
    gauss_newton,
    perturbed,
)

HALVES = tuple(0.5**k for k in range(8))
COARSE = GaussNewtonOptions(iterations=9, tolerance=0.05, difference=0.01, longest_step=3.0)
FINE = GaussNewtonOptions(iterations=25, tolerance=1e-3, difference=1e-4, central=True, step_lengths=HALVES)
ONE = np.array([0])


def linear(seed=4):
    """A linear model of three coordinates, of which the first and the last are free, with independent noise."""
    rng = np.random.default_rng(seed)
    columns, y, sd = rng.normal(0.0, 1.0, (9, 3)), rng.normal(0.0, 1.0, 9), rng.uniform(0.5, 1.0, 9)
    return columns, LeastSquares(lambda at: columns @ at, y, sd, np.array([0.3, 7.0, -0.2]), np.array([1.0, 9.0, 2.0]))


@pytest.mark.parametrize("options", [COARSE, FINE])
def test_a_linear_model_reaches_its_closed_form(options):
    columns, problem = linear()
    free, prior, sd = np.array([0, 2]), problem.prior_sd[[0, 2]], problem.noise
    (found,) = gauss_newton(problem, [Start(problem.centre, free, 0)], options)
    y = problem.y - 7.0 * columns[:, 1]
    precision = np.diag(prior**-2.0) + (columns[:, free].T / sd**2) @ columns[:, free]
    expected = np.linalg.solve(precision, columns[:, free].T @ (y / sd**2) + problem.centre[free] / prior**2)
    assert found.at == pytest.approx([expected[0], 7.0, expected[1]], rel=1e-6)
    assert found.jacobian == pytest.approx(columns[:, free], rel=1e-6)
    assert found.prediction == pytest.approx(columns @ found.at)
    left, away = (y - columns[:, free] @ expected) / sd, (expected - problem.centre[free]) / prior
    assert found.objective == pytest.approx(0.5 * left @ left + 0.5 * away @ away)


def test_a_diagonal_covariance_is_independent_noise():
    _, plain = linear()
    dense = LeastSquares(
        plain.predict, plain.y, BlockCovariance.of(np.diag(plain.noise**2)), plain.centre, plain.prior_sd
    )
    rows = np.array([0, 2, 3, 5, 8])
    starts = [Start(plain.centre, np.array([0, 2]), 0), Start(plain.centre, np.array([0, 2]), 1, rows)]
    for one, other in zip(*(gauss_newton(problem, starts, FINE) for problem in (plain, dense)), strict=True):
        np.testing.assert_allclose(one.at, other.at, rtol=1e-9)
        assert one.objective == pytest.approx(other.objective)
    subset = LeastSquares(
        lambda at: plain.predict(at)[rows], plain.y[rows], plain.noise[rows], plain.centre, plain.prior_sd
    )
    (alone,) = gauss_newton(subset, starts[:1], FINE)
    np.testing.assert_allclose(gauss_newton(dense, starts, FINE)[1].at, alone.at, rtol=1e-9)


def test_steps_that_overshoot_are_shortened():
    problem = LeastSquares(np.arctan, np.zeros(1), np.full(1, 1e-3), np.full(1, 2.0), np.full(1, 9.0))
    (found,) = gauss_newton(problem, [Start(np.array([2.0]), ONE, 0)], FINE)
    assert found.at == pytest.approx([0.0], abs=1e-5)


def test_the_noise_takes_its_likeliest_size():
    y = np.array([2.0, -2.0, 2.0, -2.0])
    problem = LeastSquares(lambda at: 0.0 * y[:, None] + at, y, np.ones(4), np.zeros(1), np.ones(1), (0.1, 9.0))
    (found,) = gauss_newton(problem, [Start(np.zeros(1), ONE, 0)], FINE)
    assert found.objective == pytest.approx(2.0 + 4 * np.log(2.0))


def test_a_model_without_a_value_ends_at_infinity():
    problem = LeastSquares(lambda at: np.full((3, at.shape[1]), np.nan), np.ones(3), np.ones(3), np.ones(1), np.ones(1))
    (found,) = gauss_newton(problem, [Start(np.zeros(1), ONE, 0)], FINE)
    assert found.objective == np.inf


@pytest.mark.parametrize(("start", "end"), [(0.0, 0.5), (1.0, np.inf), (2.0, np.inf)])
def test_a_start_beside_a_cliff_is_given_up(start, end):
    """Data follow the coordinate up to 1 and do not exist beyond; nobody may ask for what is not a number."""

    def predict(values):
        assert np.all(np.isfinite(values))
        return np.where(values[0] <= 1.0, values[0], np.nan) * np.ones((3, 1))

    problem = LeastSquares(predict, np.full(3, 0.5), BlockCovariance.of(1e-4 * np.eye(3)), np.zeros(1), np.ones(1))
    (found,) = gauss_newton(problem, [Start(np.array([start]), ONE, 0)], COARSE)
    if np.isfinite(end):
        assert found.at[0] == pytest.approx(end, abs=1e-3)
    else:
        assert found.objective == end


@pytest.mark.parametrize(("groups", "calls"), [((0, 0), 3), ((0, 1), 9)])
def test_starts_that_fall_behind_their_group_are_abandoned(groups, calls):
    """Far away it converges slowly: short steps are bounded. Alone in its group it goes on."""
    asked = []

    def predict(at):
        asked.append(at.shape[1])
        return at**3 / 100.0 * np.ones((2, 1))

    problem = LeastSquares(predict, np.zeros(2), np.full(2, 1e-2), np.zeros(1), np.full(1, 1.0))
    starts = [Start(np.array([at]), ONE, group) for at, group in zip((0.01, 30.0), groups, strict=True)]
    near, far = gauss_newton(problem, starts, COARSE)
    assert near.objective < 1.0 < far.objective
    assert len(asked) == 1 + calls


def test_perturbed_settings_move_one_coordinate_each():
    found = perturbed(np.array([1.0, 2.0, 3.0]), np.array([0, 2]), np.array([0.1, 0.2]))
    np.testing.assert_allclose(found, [[1.1, 1.0], [2.0, 2.0], [3.0, 3.2]])


def test_no_starts_no_results():
    assert gauss_newton(linear()[1], [], COARSE) == []
