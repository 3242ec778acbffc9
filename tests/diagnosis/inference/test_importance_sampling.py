"""Importance sampling against integrals that are known."""

import numpy as np
import pytest
from scipy.stats import multivariate_normal, multivariate_t, norm

from missionplan.diagnosis.inference.evidence_approximations import (
    DRAWS,
    even_points,
    log_student_density,
    sampled_evidence,
)


def test_normal_joint_density_is_integrated():
    mean, covariance = np.array([1.0, -2.0]), np.array([[0.5, 0.2], [0.2, 0.3]])
    found = sampled_evidence(lambda at: 3.7 + multivariate_normal(mean, covariance).logpdf(at), mean, covariance)
    assert found.log_evidence == pytest.approx(3.7, abs=0.1)
    assert 0.4 * DRAWS < found.effective < DRAWS


def test_a_density_that_is_not_normal_is_integrated_too():
    """Half of a normal density: Laplace would be ln 2 too high."""

    def half(at):
        return np.where(at[:, 0] > 0.0, norm.logpdf(at[:, 0]), -np.inf)

    assert sampled_evidence(half, np.zeros(1), np.eye(1)).log_evidence == pytest.approx(-np.log(2.0), abs=0.15)


def test_a_posterior_elsewhere_shows_in_the_draws_that_count():
    found = sampled_evidence(lambda at: norm.logpdf(at[:, 0], 8.0, 0.5), np.zeros(1), np.eye(1))
    assert found.effective < 0.05 * DRAWS


def test_nothing_possible_is_no_evidence():
    found = sampled_evidence(lambda at: np.full(len(at), np.nan), np.zeros(1), np.eye(1))
    assert (found.log_evidence, found.effective) == (-np.inf, 0.0)


def test_student_density_is_scipys():
    rng = np.random.default_rng(5)
    mean, root = rng.normal(size=3), np.tril(rng.normal(size=(3, 3))) + 2.0 * np.eye(3)
    at = rng.normal(size=(9, 3))
    expected = multivariate_t(mean, root @ root.T, df=5).logpdf(at)
    assert log_student_density(at, mean, root, 5) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("dimension", [1, 3, 6])
def test_even_points_integrate_better_than_random_ones(dimension):
    """Mean of the product of 2u over the cube is 1; the standard error of as many random points is known."""
    points = even_points(DRAWS, dimension)
    error = abs(float(np.prod(2.0 * points, axis=1).mean()) - 1.0)
    assert error < 0.5 * np.sqrt(((4.0 / 3.0) ** dimension - 1.0) / DRAWS)
    assert points.min() > 0.0
    assert points.max() < 1.0
