"""Kriging against the closed form of its predictor, and what it promises against a sample."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import norm

from missionplan.montecarlo.alternatives import Kriging, expected_improvement


def _matern(distance):
    scaled = np.sqrt(5.0) * distance
    return (1.0 + scaled + scaled**2 / 3.0) * np.exp(-scaled)


@pytest.fixture
def surface():
    rng = np.random.default_rng(3)
    places = rng.random((30, 2))
    values = np.sin(4.0 * places[:, 0]) + places[:, 1] ** 2
    return Kriging.fitted(places, np.array([0, 1]), values), places, values


def test_the_surface_is_the_predictor_in_closed_form(surface):
    """Rasmussen & Williams 2006, Eqs. 2.25 and 2.26, written out again with an inverse."""
    kriging, places, values = surface
    at = np.random.default_rng(4).random((50, 2))
    between = np.linalg.norm((places[:, None] - places[None]) / kriging.lengths, axis=2)
    across = _matern(np.linalg.norm((at[:, None] - places[None]) / kriging.lengths, axis=2))
    inverse = np.linalg.inv(_matern(between) + kriging.nugget * np.eye(30))
    standard = (values - values.mean()) / values.std()
    mean, spread = kriging.at(at)
    np.testing.assert_allclose(mean, values.mean() + values.std() * across @ inverse @ standard, atol=1e-7)
    variance = 1.0 - np.einsum("ij,jk,ik->i", across, inverse, across)
    np.testing.assert_allclose(spread, values.std() * np.sqrt(np.maximum(variance, 0.0)), atol=1e-5)


def test_a_smooth_surface_is_predicted_between_its_values(surface):
    kriging, *_ = surface
    at = 0.1 + 0.8 * np.random.default_rng(5).random((200, 2))
    mean, _ = kriging.at(at)
    np.testing.assert_allclose(mean, np.sin(4.0 * at[:, 0]) + at[:, 1] ** 2, atol=0.05)


def test_noise_is_told_from_the_surface():
    rng = np.random.default_rng(6)
    places = rng.random((120, 1))
    kriging = Kriging.fitted(places, np.array([0]), np.sin(6.0 * places[:, 0]) + rng.normal(0.0, 0.3, 120))
    mean, _ = kriging.at(np.linspace(0.05, 0.95, 50)[:, None])
    assert np.std(mean - np.sin(6.0 * np.linspace(0.05, 0.95, 50))) < 0.15
    assert kriging.nugget * kriging.scale**2 == pytest.approx(0.09, rel=0.9)  # nuggets go in steps of four


@pytest.mark.parametrize(("mean", "spread"), [(1.0, 0.5), (0.2, 0.1), (-0.3, 0.4), (2.0, 0.3)])
def test_expected_improvement_is_the_integral(mean, spread):
    integral, _ = quad(lambda x: max(0.5 - x, 0.0) * norm.pdf(x, mean, spread), -10.0, 0.5)
    assert expected_improvement(0.5, np.array([mean]), np.array([spread]))[0] == pytest.approx(integral, rel=1e-6)
