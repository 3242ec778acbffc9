"""Likelihoods against what a library or a closed form gives."""

import numpy as np
import pytest
from scipy import stats
from scipy.integrate import quad

from missionplan.diagnosis.inference.laplace import laplace
from missionplan.diagnosis.inference.marginal_likelihood import expected_log_ratio, gaussian_marginal, student_marginal

RNG = np.random.default_rng(5)


def problem(n=6, k=3):
    y = RNG.normal(size=(2, n))
    design = RNG.normal(size=(2, n, k))
    prior = np.array([0.5, 1.0, 2.0])[:k]
    return y, design, prior


def dense(design, prior, noise):
    """Covariance of both axes' data with the coefficients integrated out."""
    flat = (design * prior).reshape(noise.size, -1)
    return flat @ flat.T + np.diag(noise.ravel())


def whitened_gram(y, design, noise):
    """Inner products of columns and data over independent errors."""
    flat = np.concatenate([design, y[:, :, None]], axis=2).reshape(2 * y.shape[1], -1)
    return flat.T @ (flat / noise.ravel()[:, None])


def test_marginal_is_the_density_of_the_data():
    y, design, prior = problem()
    noise = RNG.uniform(0.5, 2.0, (2, 6))
    found = gaussian_marginal(whitened_gram(y, design, noise), prior, float(np.log(noise).sum()), 12)
    expected = stats.multivariate_normal(np.zeros(12), dense(design, prior, noise)).logpdf(y.ravel())
    assert found.log_density == pytest.approx(expected)


def test_posterior_of_the_coefficients_is_ridge_regression():
    y, design, prior = problem()
    found = gaussian_marginal(whitened_gram(y, design, np.full((2, 6), 0.25)), prior, 12.0 * np.log(0.25), 12)
    flat = design.reshape(12, 3)
    precision = flat.T @ flat / 0.25 + np.diag(1.0 / prior**2)
    np.testing.assert_allclose(found.mean, np.linalg.solve(precision, flat.T @ y.ravel() / 0.25))
    np.testing.assert_allclose(found.covariance, np.linalg.inv(precision))


def test_student_marginal_is_a_bivariate_t():
    """Without coefficients to speak of, the density of each leg is scipy's multivariate t."""
    y, design, _ = problem()
    variance = np.full((2, 6), 0.7)
    found = student_marginal(y, design, np.full(3, 1e-9), variance, 5.0)
    law = stats.multivariate_t(np.zeros(2), 0.7 * np.eye(2) * 3.0 / 5.0, df=5.0)
    assert found.log_density == pytest.approx(law.logpdf(y.T).sum())


def test_student_marginal_tends_to_the_gaussian():
    y, design, prior = problem()
    variance = np.full((2, 6), 0.7)
    student = student_marginal(y, design, prior, variance, 1e6)
    gaussian = gaussian_marginal(whitened_gram(y, design, variance), prior, float(np.log(variance).sum()), 12)
    assert student.log_density == pytest.approx(gaussian.log_density, abs=1e-3)


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


def test_laplace_keeps_clear_of_an_edge():
    """Beyond the edge there is no density: steps across it would look like an endless curvature."""

    def log_posterior(at):
        return -0.5 * float((at[0] / 0.01) ** 2) if at[0] > -0.03 else -np.inf

    found = laplace(log_posterior, [np.array([0.001])], 1e-4 * np.eye(1))
    assert np.sqrt(found.covariance[0, 0]) == pytest.approx(0.01, rel=0.01)
    assert found.log_evidence == pytest.approx(0.5 * np.log(2.0 * np.pi) + np.log(0.01), abs=0.02)


def test_laplace_says_when_the_mode_is_an_edge():
    def log_posterior(at):
        return -float(at[0]) if at[0] >= 0.0 else -np.inf

    with pytest.raises(np.linalg.LinAlgError, match="edge"):
        laplace(log_posterior, [np.array([0.0])], np.eye(1))


def test_expected_ratio_is_the_mean_over_draws():
    first, second = np.diag([1.0, 2.0]), np.diag([3.0, 1.0])
    mean, truth = np.array([0.5, -0.2]), np.diag([1.5, 1.0])
    draws = mean + RNG.normal(size=(40_000, 2)) * np.sqrt(np.diag(truth))
    laws = [stats.multivariate_normal(np.zeros(2), covariance) for covariance in (first, second)]
    sampled = laws[0].logpdf(draws) - laws[1].logpdf(draws)
    error = 4.0 * sampled.std() / 200.0
    assert expected_log_ratio(mean, truth, first, second) == pytest.approx(sampled.mean(), abs=error)
