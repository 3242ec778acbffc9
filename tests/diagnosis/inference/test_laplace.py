"""Laplace's approximation against integrals that are known."""

import numpy as np
import pytest
from scipy.integrate import quad

from missionplan.diagnosis.inference.evidence_approximations import laplace


def test_laplace_is_exact_for_a_gaussian():
    precision = np.array([[4.0, 1.0], [1.0, 2.0]])

    def log_posterior(at):
        return 3.0 - 0.5 * (at - 1.0) @ precision @ (at - 1.0)

    found = laplace(log_posterior, [np.zeros(2)], np.eye(2))
    assert found.log_evidence == pytest.approx(
        3.0 + np.log(2.0 * np.pi) - 0.5 * np.linalg.slogdet(precision)[1], abs=0.02
    )
    np.testing.assert_allclose(found.mode, 1.0, atol=0.05)
    np.testing.assert_allclose(found.covariance, np.linalg.inv(precision), rtol=1e-3)


def test_laplace_of_a_gamma_density_is_close():
    """ln ∫ e^(a·u − e^u) du = ln Γ(a): Laplace is Stirling's formula."""
    exact = np.log(quad(lambda u: np.exp(30.0 * u - np.exp(u)), 0.0, 6.0)[0])
    found = laplace(lambda at: float(30.0 * at[0] - np.exp(at[0])), [np.array([3.0])], np.eye(1))
    assert found.log_evidence == pytest.approx(exact, abs=0.02)


def test_laplace_takes_shorter_steps_at_a_boundary():
    """Beyond the boundary there is no density: steps across it would look like an infinite curvature."""

    def log_posterior(at):
        return -0.5 * float((at[0] / 0.01) ** 2) if at[0] > -0.03 else -np.inf

    found = laplace(log_posterior, [np.array([0.001])], 1e-4 * np.eye(1))
    assert np.sqrt(found.covariance[0, 0]) == pytest.approx(0.01, rel=0.01)
    assert found.log_evidence == pytest.approx(0.5 * np.log(2.0 * np.pi) + np.log(0.01), abs=0.02)


def test_laplace_fails_where_the_mode_is_on_the_boundary():
    def log_posterior(at):
        return -float(at[0]) if at[0] >= 0.0 else -np.inf

    with pytest.raises(np.linalg.LinAlgError, match="edge"):
        laplace(log_posterior, [np.array([0.0])], np.eye(1))


def test_laplace_draws_about_a_mode_on_the_boundary_from_just_inside_it():
    """A normal law of standard deviation 0.5 whose peak lies beyond the boundary."""

    def log_posterior(at):
        return -0.5 * float(((at[0] + 0.1) / 0.5) ** 2) if at[0] >= 0.0 else -np.inf

    found = laplace(log_posterior, [np.array([0.0])], np.eye(1), keep_inside=True)
    assert 0.0 <= found.mode[0] < 0.01
    assert np.sqrt(found.covariance[0, 0]) == pytest.approx(0.5, rel=0.01)
