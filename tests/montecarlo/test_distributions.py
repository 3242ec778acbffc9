import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from missionplan.montecarlo.distributions import (
    Choices,
    LogNormal,
    Normal,
    TruncatedNormal,
    Uniform,
    mean_of,
    sd_of,
)
from missionplan.montecarlo.streams import stream

CASES = [
    (Normal(2.0, 3.0), stats.norm(2.0, 3.0)),
    (TruncatedNormal(10.0, 3.0, low=0.0), stats.truncnorm(-10.0 / 3.0, math.inf, 10.0, 3.0)),
    (TruncatedNormal(0.0, 1.0, -1.0, 3.0), stats.truncnorm(-1.0, 3.0)),
    (TruncatedNormal(0.0, 1.0, 5.0, 9.0), stats.truncnorm(5.0, 9.0)),
    (Uniform(-2.0, 5.0), stats.uniform(-2.0, 7.0)),
    (LogNormal(3.0, 1.5), stats.lognorm(math.log(1.5), scale=3.0)),
    (Normal(1.0, 1.0).truncated(low=0.0), stats.truncnorm(-1.0, math.inf, 1.0, 1.0)),
    (Uniform(-1.0, 3.0).truncated(low=0.0), stats.uniform(0.0, 3.0)),
]


@pytest.mark.parametrize(("distribution", "theory"), CASES, ids=lambda case: type(case).__name__)
def test_draws_follow_the_theory(distribution, theory):
    draws = distribution.from_normal(stream(7, "case", 0).standard_normal(50_000))
    assert stats.kstest(draws, theory.cdf).pvalue > 1e-3
    assert distribution.mean == pytest.approx(theory.mean(), rel=1e-9)
    assert distribution.sd == pytest.approx(theory.std(), rel=1e-6)
    for value in theory.ppf([0.001, 0.3, 0.9]):
        assert distribution.cdf(value) == pytest.approx(theory.cdf(value), rel=1e-9)
    for probability in (1e-6, 0.01, 0.4, 0.99):
        assert distribution.quantile(probability) == pytest.approx(theory.ppf(probability), rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("distribution", [*(each for each, _ in CASES), Choices((3.0, 1.0, 2.0))])
def test_a_quantile_of_one_number_is_what_normals_are_transformed_to(distribution):
    z = np.array([-3.0, -0.5, 0.0, 1.0, 2.0])
    found = [distribution.quantile(float(probability)) for probability in stats.norm.cdf(z)]
    np.testing.assert_allclose(found, distribution.from_normal(z), rtol=1e-9, atol=1e-9)
    assert distribution.quantile(0.0) <= distribution.quantile(1e-9)
    assert distribution.quantile(1.0) >= distribution.quantile(1.0 - 1e-9)


def test_lognormal_factor_holds_68_percent():
    distribution = LogNormal(0.4, 2.0)
    assert distribution.cdf(0.8) - distribution.cdf(0.2) == pytest.approx(0.6827, abs=1e-4)


def test_choices_are_equally_likely_and_ordered_with_the_normal():
    distribution = Choices((3.0, 1.0, 2.0))
    draws = distribution.from_normal(stream(7, "case", 0).standard_normal(60_000))
    values, counts = np.unique(draws, return_counts=True)
    assert values.tolist() == [1.0, 2.0, 3.0]
    assert stats.chisquare(counts).pvalue > 1e-3
    assert distribution.mean == 2.0
    assert distribution.from_normal(np.array([-40.0, 40.0])).tolist() == [1.0, 3.0]


def test_truncation_reports_the_probability_cut():
    assert Normal(1.0, 1.0).truncated(low=0.0).mass_cut == pytest.approx(stats.norm.sf(1.0))
    assert Choices((1.0, 2.0, 3.0, 4.0)).truncated(low=1.5).mass_cut == pytest.approx(0.25)
    assert Uniform(-1.0, 3.0).truncated(0.0, 2.0).mass_cut == pytest.approx(0.5)
    assert Normal(9.0, 1.0).truncated(low=0.0).mass_cut == pytest.approx(stats.norm.sf(9.0))
    assert Normal(9.5, 1.0).truncated(low=0.0) == Normal(9.5, 1.0)
    assert TruncatedNormal(10.0, 3.0, low=0.0).mass_cut == 0.0


def test_a_distribution_inside_its_range_is_left_alone():
    for distribution in (Uniform(0.0, 1.0), LogNormal(1.0, 2.0), Normal(0.5, 0.0)):
        assert distribution.truncated(0.0, math.inf) is distribution


@pytest.mark.parametrize("distribution", [Uniform(-2.0, -1.0), Choices((-1.0,)), Normal(-1.0, 0.0)])
def test_a_distribution_outside_its_range_is_refused(distribution):
    with pytest.raises(ValueError, match="no part"):
        distribution.truncated(low=0.0)


@given(st.floats(-50, 50), st.floats(0.01, 20), st.floats(-30, 30), st.floats(0.01, 30))
def test_truncated_draws_stay_inside_and_rise_with_the_normal(mean, sd, low, width):
    distribution = TruncatedNormal(mean, sd, low, low + width)
    draws = distribution.from_normal(np.linspace(-6.0, 6.0, 25))
    assert np.all((draws >= low) & (draws <= low + width))
    assert np.all(np.diff(draws) >= -1e-9 * (abs(low) + width))
    assert low <= distribution.mean <= low + width


def test_numbers_are_their_own_mean():
    assert (mean_of(3.0), sd_of(3.0)) == (3.0, 0.0)
    assert (mean_of(Normal(2.0, 1.0)), sd_of(Normal(2.0, 1.0))) == (2.0, 1.0)


@pytest.mark.parametrize(("low", "high"), [(5.0, 9.0), (9.0, 12.0), (10.0, math.inf), (-12.0, -9.0)])
def test_far_tails_keep_their_digits(low, high):
    distribution = TruncatedNormal(3.0, 2.0, 3.0 + 2.0 * low, 3.0 + 2.0 * high)
    z = np.array([-3.0, -1.0, 0.0, 1.0, 3.0])
    theory = stats.truncnorm(low, high, 3.0, 2.0)
    draws = distribution.from_normal(z)
    assert draws == pytest.approx(theory.isf(stats.norm.sf(z)), rel=1e-9)
    assert [distribution.cdf(value) for value in draws] == pytest.approx(theory.cdf(draws), rel=1e-6)


def test_an_upper_limit_cuts_the_upper_tail():
    cut = Normal(0.0, 1.0).truncated(high=1.0)
    z = np.array([-4.0, 0.0, 4.0])
    assert cut.mass_cut == pytest.approx(stats.norm.sf(1.0))
    assert cut.from_normal(z) == pytest.approx(stats.truncnorm(-math.inf, 1.0).ppf(stats.norm.cdf(z)), rel=1e-9)


def test_choices_cut_twice_have_lost_both_parts():
    twice = Choices((1.0, 2.0, 3.0, 4.0)).truncated(low=1.5).truncated(high=3.5)
    assert twice.values == (2.0, 3.0)
    assert twice.mass_cut == pytest.approx(0.5)
