"""Tests of residuals: independence, constant spread, and groups that the others do not predict."""

from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2, norm
from statsmodels.regression.linear_model import OLS
from statsmodels.stats.diagnostic import acorr_ljungbox
from statsmodels.tools import add_constant

from missionplan.arrays import Array
from missionplan.diagnosis.inference.residuals import Residuals

OUTLYING = 0.01
"""Level at which groups are outlying, all together."""
TEST_LEVEL = 0.001
"""Level of the residual tests, all together."""


@dataclass(frozen=True)
class ResidualTest:
    """A test that the innovations are independent and of constant spread."""

    name: str
    p_value: float


def residual_tests(residuals: Residuals, innovations: Array) -> tuple[ResidualTest, ...]:
    """Ljung–Box test of the innovations and Engle's ARCH test of their squares, for each series of 16 or more.

    Innovations enter by their normal scores, so that a heavy tail alone rejects nothing.

    Parameters
    ----------
    residuals : Residuals
        Which says what makes a series. The quantum of a coarse sensor beats with the sampling: of quantised ones
        neighbours are taken together, and autocorrelations must add up to more than zero.
    innovations : array, shape (N,)
        Its innovations.
    """
    tests = []
    for number in np.unique(residuals.series):
        z = innovations[residuals.series == number]
        if residuals.quantised:
            z = z[: len(z) // 2 * 2].reshape(-1, 2).sum(axis=1)
        if len(z) < 16:
            continue
        ranks = np.argsort(np.argsort(z))
        scores = norm.ppf((ranks + 0.5) / len(z))
        lags = min(8, len(z) // 4)
        portmanteau = float(acorr_ljungbox(scores, lags=[lags], return_df=True)["lb_pvalue"].iloc[0])
        if residuals.quantised and sum(float(scores[k:] @ scores[:-k]) for k in range(1, lags + 1)) <= 0.0:
            portmanteau = 1.0
        tests.append(ResidualTest(f"autocorrelation {number + 1}", portmanteau))
        tests.append(ResidualTest(f"changing spread {number + 1}", _arch_p_value(scores, min(4, lags))))
    return tuple(tests)


def _arch_p_value(scores: Array, lags: int) -> float:
    """Engle's test: regress the squares on their past; n·R² is χ² with as many degrees of freedom as lags."""
    squares = scores**2
    past = np.stack([squares[lags - k - 1 : -k - 1] for k in range(lags)], axis=1)
    fitted = OLS(squares[lags:], add_constant(past, has_constant="add")).fit()
    return float(chi2.sf(len(past) * fitted.rsquared, lags))


def rejects(tests: tuple[ResidualTest, ...]) -> bool:
    """Whether any of the tests fails at a level that holds for all of them together (Bonferroni)."""
    return any(test.p_value < TEST_LEVEL / len(tests) for test in tests)


def outlying_groups(residuals: Residuals) -> tuple[tuple[str, float], ...]:
    """Groups that the others do not predict, with their p-values (Bonferroni over groups).

    With the precision P = W⁻¹ a group's error against its prediction from all others is (P_gg)⁻¹(P r)_g, with
    covariance (P_gg)⁻¹: its squared length is χ² with as many degrees of freedom as the group has values.
    """
    names = list(dict.fromkeys(residuals.groups.tolist()))
    precision = np.linalg.inv(residuals.covariance)
    pulled = precision @ residuals.values
    found = []
    for name in names:
        own = np.flatnonzero(residuals.groups == name)
        squared = float(pulled[own] @ np.linalg.solve(precision[np.ix_(own, own)], pulled[own]))
        p_value = min(1.0, float(chi2.sf(squared, len(own))) * len(names))
        if p_value < OUTLYING and len(names) > 1:
            found.append((name, p_value))
    return tuple(found)
