"""Tests of residuals against reference values and against distributions under the null hypothesis."""

import numpy as np
import pytest
from scipy import stats

from missionplan.diagnosis.inference.block_covariance import BlockCovariance
from missionplan.diagnosis.inference.discrepancy import (
    OUTLYING,
    TEST_LEVEL,
    Residuals,
    ResidualTest,
    arch_p_value,
    ljung_box_p_value,
    outlying_groups,
    rejects,
)

SERIES = np.random.default_rng(20).standard_normal(60)
"""Its p-values below were computed once by statsmodels 0.15.0: acorr_ljungbox and het_arch."""


@pytest.mark.parametrize(("lags", "expected"), [(3, 0.33656035192277783), (8, 0.4856902236724019)])
def test_ljung_box_is_statsmodels(lags, expected):
    assert ljung_box_p_value(SERIES, lags) == pytest.approx(expected, rel=1e-10)


@pytest.mark.parametrize(("lags", "expected"), [(2, 0.8802346715678576), (4, 0.04635669498648701)])
def test_arch_is_statsmodels(lags, expected):
    assert arch_p_value(SERIES, lags) == pytest.approx(expected, rel=1e-10)


@pytest.mark.parametrize("test", [lambda z: ljung_box_p_value(z, 4), lambda z: arch_p_value(z, 3)])
def test_p_values_of_white_noise_are_uniform(test):
    rng = np.random.default_rng(3)
    found = [test(rng.standard_normal(400)) for _ in range(600)]
    assert stats.kstest(found, "uniform").pvalue > 1e-3


def test_the_level_is_shared_among_all_tests():
    just = 0.6 * TEST_LEVEL
    assert rejects((ResidualTest("a", just),))
    assert not rejects((ResidualTest("a", just), ResidualTest("b", 0.5)))
    assert not rejects(())


def groups(count: int, off: float) -> Residuals:
    """Groups of one value each, standard normal, the first of which is off."""
    values = np.zeros(count)
    values[0] = off
    names = np.array([f"dive-{k}" for k in range(count)])
    return Residuals(values, BlockCovariance.of(np.eye(count)), np.zeros(count, dtype=int), (), names)


def test_an_outlying_groups_p_value_allows_for_their_number():
    off = float(stats.norm.isf(0.5 * 0.2 * OUTLYING))
    assert outlying_groups(groups(2, off)) == (("dive-0", pytest.approx(0.4 * OUTLYING)),)
    assert outlying_groups(groups(8, off)) == ()
    assert outlying_groups(groups(1, off)) == ()
