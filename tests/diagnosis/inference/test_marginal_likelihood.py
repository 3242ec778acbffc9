"""Marginal likelihoods against a library or a closed form."""

import numpy as np
import pytest
from scipy import stats

from missionplan.diagnosis.inference.evidence_approximations import student_marginal
from missionplan.diagnosis.inference.marginal_likelihood import gaussian_marginal

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


def test_student_marginal_is_the_integral_over_the_coefficient():
    """Laplace's approximation against quadrature, with tails heavy enough that weights and curvature differ."""
    rng, dof, prior_sd = np.random.default_rng(21), 3.0, 2.0
    design = rng.normal(size=(2, 40, 1))
    y = 0.7 * design[:, :, 0] + rng.standard_t(dof, size=(2, 40))
    at = np.linspace(-3.0, 4.0, 2001)
    shape = np.eye(2) * (dof - 2.0) / dof  # of unit variance
    density = [stats.multivariate_t.logpdf((y - c * design[:, :, 0]).T, shape=shape, df=dof).sum() for c in at]
    log_integrand = np.array(density) + stats.norm.logpdf(at, scale=prior_sd)
    expected = np.logaddexp.reduce(log_integrand) + np.log(at[1] - at[0])
    found = student_marginal(y, design, np.array([prior_sd]), np.ones((2, 40)), dof)
    assert found.log_density == pytest.approx(expected, abs=0.02)
