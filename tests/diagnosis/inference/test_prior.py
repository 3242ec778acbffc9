"""Slabs with heavy tails: their density, and the evidence integrated over their scales, by quadrature."""

import numpy as np
import pytest
from scipy import integrate, optimize, stats

from missionplan.diagnosis.inference.gauss_newton import GaussNewtonOptions, LeastSquares, Start, gauss_newton
from missionplan.diagnosis.inference.marginal_likelihood import LOG_2PI, gaussian_marginal
from missionplan.diagnosis.inference.prior import DOF, Prior, inside_range, integrated, likeliest_scales

BOTH = Prior(np.array([1.0, -2.0]), np.array([0.5, 3.0]), np.array([True, False]))


def test_density_is_a_students_where_heavy_else_normal():
    at = np.array([[1.0, -2.0], [3.0, 4.0]])
    expected = stats.t(DOF, 1.0, 0.5).logpdf(at[:, 0]) + stats.norm(-2.0, 3.0).logpdf(at[:, 1])
    np.testing.assert_allclose(BOTH.log_density(at), expected)
    assert BOTH.misfit(at[1]) == pytest.approx(expected[0] - expected[1])


def test_the_normal_that_touches_it_has_its_slope():
    at, step = np.array([3.0, 4.0]), 1e-6
    slope = [(BOTH.misfit(at + each) - BOTH.misfit(at - each)) / (2.0 * step) for each in step * np.eye(2)]
    np.testing.assert_allclose((at - BOTH.centre) / BOTH.variance(at), slope, rtol=1e-6)


@pytest.mark.parametrize("noise", [pytest.param(0.05, marks=pytest.mark.slow), 1.0, 5.0])
@pytest.mark.parametrize("value", [0.0, 0.7, 8.0])
def test_evidence_over_the_scales_is_the_integral_over_the_slab(value, noise):
    """One coordinate, measured as `value` slabs with an error of `noise` slabs."""
    sd = 0.3
    gram = np.array([[1.0, value * sd], [value * sd, (value * sd) ** 2]]) / (noise * sd) ** 2
    log_determinant = 2.0 * np.log(noise * sd)
    prior = Prior(np.zeros(1), np.array([sd]), np.array([True]))

    def marginal(spread):
        return gaussian_marginal(gram, spread, log_determinant, 1)

    scales = likeliest_scales(marginal, prior)
    found = marginal(scales.sd)
    whole = integrated(
        lambda spread: np.array([marginal(spread).log_density]), lambda _, spread: marginal(spread), prior
    )
    error, slab = stats.norm(value * sd, noise * sd), stats.t(DOF, 0.0, sd)

    x = np.linspace(-60.0 * sd, 60.0 * sd, 60_001)
    joint = error.pdf(x) * slab.pdf(x)
    exact = integrate.simpson(joint, x)
    assert found.log_density + scales.log_factor == pytest.approx(np.log(exact), abs=0.06)
    assert whole.log_evidence == pytest.approx(np.log(exact), abs=0.06)
    mean = integrate.simpson(x * joint, x) / exact
    assert abs(found.mean[0] - mean) < 0.25 * noise * sd


def test_a_strong_effect_is_measured_and_a_weak_one_pays_for_its_parameter():
    """Ten slabs measured to a tenth of one: a normal slab would shrink it by a whole standard deviation."""
    gram = np.array([[1.0, 10.0], [10.0, 100.0]]) / 0.1**2
    prior = Prior(np.zeros(1), np.ones(1), np.array([True]))
    scales = likeliest_scales(lambda spread: gaussian_marginal(gram, spread, 0.0, 1), prior)
    mean = gaussian_marginal(gram, scales.sd, 0.0, 1).mean[0]
    assert 10.0 - mean < 0.1 * 0.1
    assert 10.0 - gaussian_marginal(gram, np.ones(1), 0.0, 1).mean[0] > 0.9 * 0.1
    nothing = np.array([[1.0, 0.0], [0.0, 0.0]]) / 0.1**2
    scales = likeliest_scales(lambda spread: gaussian_marginal(nothing, spread, 0.0, 1), prior)
    penalty = gaussian_marginal(nothing, scales.sd, 0.0, 1).log_density + scales.log_factor + 0.5 * LOG_2PI
    assert penalty == pytest.approx(np.log(0.1 * stats.t(DOF).pdf(0.0) * np.sqrt(2.0 * np.pi)), abs=0.05)


def test_the_search_ends_at_the_mode_under_a_heavy_slab():
    y, sd = np.array([7.0, 9.0]), 0.8
    prior = Prior(np.zeros(1), np.ones(1), np.array([True]))
    problem = LeastSquares(
        lambda at: np.concatenate([at, at + 0.02 * at**2]), y, np.full(2, sd), np.zeros(1), np.ones(1)
    )
    start = Start(np.zeros(1), np.array([0]), 0, prior=prior)
    (found,) = gauss_newton(problem, [start], GaussNewtonOptions(60, 1e-10, 1e-4, longest_step=3.0))

    def objective(at):
        model = np.array([at, at + 0.02 * at**2])
        return 0.5 * np.sum(((y - model) / sd) ** 2) - stats.t(DOF).logpdf(at)

    mode = optimize.minimize_scalar(objective, bounds=(0.0, 12.0), method="bounded", options={"xatol": 1e-9}).x
    assert found.at[0] == pytest.approx(mode, abs=1e-3)


@pytest.mark.parametrize(("low", "high"), [(0.0, np.inf), (-1.0, 2.0), (3.0, np.inf), (-np.inf, -4.0), (9.0, 9.5)])
def test_one_range_cuts_a_normal_distribution_exactly(low, high):
    cut = inside_range(np.array([0.3]), np.array([[4.0]]), np.array([low]), np.array([high]))
    ends = (low - 0.3) / 2.0, (high - 0.3) / 2.0
    exact = stats.truncnorm(*ends, 0.3, 2.0)
    assert cut.mean[0] == pytest.approx(exact.mean(), rel=1e-6)
    assert cut.covariance[0, 0] == pytest.approx(exact.var(), rel=1e-3)
    mass = stats.norm.sf(ends[0]) - stats.norm.sf(ends[1]) if low > 0.3 else np.diff(stats.norm.cdf(ends))[0]
    assert cut.log_mass == pytest.approx(np.log(mass), abs=1e-6)


def test_two_ranges_of_correlated_coordinates_by_draws():
    mean, covariance = np.array([0.4, -0.2, 1.0]), np.array([[1.0, 0.6, 0.3], [0.6, 1.0, -0.2], [0.3, -0.2, 2.0]])
    low, high = np.array([0.0, 0.0, -np.inf]), np.full(3, np.inf)
    cut = inside_range(mean, covariance, low, high)
    drawn = np.random.default_rng(1).multivariate_normal(mean, covariance, 400_000)
    inside = drawn[np.all(drawn >= low, axis=1)]
    assert cut.log_mass == pytest.approx(np.log(len(inside) / len(drawn)), abs=0.05)
    np.testing.assert_allclose(cut.mean, inside.mean(axis=0), atol=0.05)
    np.testing.assert_allclose(cut.covariance, np.cov(inside.T), atol=0.12)


def test_a_slab_that_is_cut_is_a_density_inside_its_range():
    prior = Prior(np.zeros(1), np.array([0.3]), np.array([True]), low=np.zeros(1), high=np.array([0.9]))

    def density(x):
        return float(np.exp(prior.log_density(np.array([x])) - prior.log_mass))

    assert integrate.quad(density, 0.0, 0.9)[0] == pytest.approx(1.0)
    assert density(-0.1) == density(1.0) == 0.0
