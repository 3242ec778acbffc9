"""The best fit of tank data: by its closed form where the model is linear, and where full steps would not get there."""

import numpy as np
import pytest

from missionplan.diagnosis.tank.gauss_newton import Climb


def test_a_linear_model_reaches_its_closed_form():
    rng = np.random.default_rng(4)
    columns, y, sd = rng.normal(0.0, 1.0, (9, 2)), rng.normal(0.0, 1.0, 9), rng.uniform(0.5, 1.0, 9)
    centre, prior = np.array([0.3, 7.0, -0.2]), np.array([1.0, 2.0])
    active = np.array([0, 2])
    climb = Climb(lambda places: columns @ places[active], y, sd, centre, active, prior, (1.0, 1.0))
    reached = climb.climb(centre)
    precision = np.diag(prior**-2.0) + (columns.T / sd**2) @ columns
    expected = np.linalg.solve(precision, columns.T @ (y / sd**2) + centre[active] / prior**2)
    assert reached.at == pytest.approx([expected[0], 7.0, expected[1]], rel=1e-6)
    assert reached.columns == pytest.approx(columns, rel=1e-6)
    left, away = (y - columns @ expected) / sd, (expected - centre[active]) / prior
    assert reached.objective == pytest.approx(0.5 * left @ left + 0.5 * away @ away)


def test_steps_that_overshoot_are_halved():
    climb = Climb(np.arctan, np.zeros(1), np.full(1, 1e-3), np.full(1, 2.0), np.array([0]), np.full(1, 9.0), (1.0, 1.0))
    assert climb.climb(np.array([2.0])).at == pytest.approx([0.0], abs=1e-5)


def test_the_noise_follows_what_is_left():
    y = np.array([2.0, -2.0, 2.0, -2.0])
    climb = Climb(
        lambda places: 0.0 * y[:, None] + places, y, np.ones(4), np.zeros(1), np.array([0]), np.ones(1), (0.1, 9)
    )
    assert climb.climb(np.zeros(1)).objective == pytest.approx(2.0 + 4 * np.log(2.0))


def test_a_model_without_a_value_ends_at_infinity():
    climb = Climb(
        lambda at: np.full((3, at.shape[1]), np.nan), *np.ones((2, 3)), np.zeros(1), np.array([0]), np.ones(1), (1, 1)
    )
    assert climb.climb(np.zeros(1)).objective == np.inf
