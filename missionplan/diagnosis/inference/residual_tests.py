"""What a model leaves: residuals of its fit, and tests of them."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc, ndtri

from missionplan.arrays import Array
from missionplan.diagnosis.inference.axes import Axis
from missionplan.diagnosis.inference.block_covariance import BlockCovariance, InnerProducts
from missionplan.results.learned.evidence import ResidualTest


@dataclass(frozen=True)
class Residuals:
    """Residuals of the base model and their joint distribution under a set of causes."""

    values: Array
    """Data less the prior mean of the (linearised) model, in the order of the record, shape (N,)."""
    covariance: BlockCovariance
    """Of the values under the model, uncertain parameters included."""
    series: NDArray[np.int_]
    """Which series each value belongs to: runs and components, shape (N,)."""
    axes: Sequence[Axis]
    """Along which a discrepancy may be smooth."""
    groups: NDArray[np.str_]
    """Runs, which the search for outlying groups leaves out in turn, shape (N,)."""
    quantised: bool = False
    """Whether the residual tests ignore what alternates, as readings of a coarse sensor in quick succession do."""
    products_by_noise: Callable[[Array], Iterable[InnerProducts]] | None = None
    """From columns, shape (N, m), to their inner products at every noise over which the test for a discrepancy
    averages; default the one noise of the covariance."""

    def innovations(self) -> Array:
        """Return one-step-ahead errors over their standard deviations, shape (N,)."""
        return self.covariance.innovations(self.values)

    def inner_products(self, columns: Array) -> Iterable[InnerProducts]:
        """Return inner products of columns, shape (N, m), and the values at every noise over which to average."""
        if self.products_by_noise is not None:
            return self.products_by_noise(columns)
        return [self.covariance.products(columns, self.values)]


OUTLYING = 0.01
"""Level at which a group is outlying, for all groups together."""
TEST_LEVEL = 0.001
"""Level of the residual tests, for all of them together."""
SHORTEST = 16
"""Values that a series needs to be tested."""
UNSEEN = 0.01
"""Innovations that are all smaller are no errors: rounding follows a pattern, but far below the noise."""


def residual_tests(residuals: Residuals, innovations: Array) -> tuple[ResidualTest, ...]:
    """Test each series for autocorrelation (`ljung_box_p_value`) and for changing spread (`arch_p_value`).

    Innovations enter by their normal scores (van der Waerden 1952, *Indag. Math.* 14), so that a heavy tail alone
    rejects nothing.

    Parameters
    ----------
    residuals : Residuals
        Which say what makes a series. The quantisation steps of a coarse sensor beat with the sampling: of quantised
        residuals, neighbours are added together, and only a positive sum of autocorrelations counts.
    innovations : array, shape (N,)
        Their innovations.
    """
    tests = []
    for number in np.unique(residuals.series):
        z = innovations[residuals.series == number]
        if residuals.quantised:
            z = z[: len(z) // 2 * 2].reshape(-1, 2).sum(axis=1)
        if len(z) < SHORTEST or float(np.max(np.abs(z))) < UNSEEN:
            continue
        ranks = np.argsort(np.argsort(z))
        scores = ndtri((ranks + 0.5) / len(z))
        lags = min(8, len(z) // 4)
        portmanteau = ljung_box_p_value(scores, lags)
        if residuals.quantised and sum(float(scores[k:] @ scores[:-k]) for k in range(1, lags + 1)) <= 0.0:
            portmanteau = 1.0
        tests.append(ResidualTest(f"autocorrelation {number + 1}", portmanteau))
        tests.append(ResidualTest(f"changing spread {number + 1}", arch_p_value(scores, min(4, lags))))
    return tuple(tests)


def ljung_box_p_value(series: Array, lags: int) -> float:
    """P-value of the portmanteau test that the first autocorrelations of a series are zero.

    Q = n(n + 2) Σ_k r_k²/(n - k) is χ² with as many degrees of freedom as lags (Ljung & Box 1978, Eq. 1.3).

    Parameters
    ----------
    series : array, shape (n,)
    lags : int
        Fewer than n.
    """
    n, centred = len(series), series - series.mean()
    lag = np.arange(1, lags + 1)
    correlation = np.array([centred[k:] @ centred[:-k] for k in lag]) / (centred @ centred)
    return float(chdtrc(lags, n * (n + 2.0) * np.sum(correlation**2 / (n - lag))))


def arch_p_value(series: Array, lags: int) -> float:
    """P-value of the test that the spread of a series does not depend on its past.

    Regress the squares on the squares before them: n·R² is χ² with as many degrees of freedom as lags, n the number
    of squares regressed (Engle 1982, section 8).

    Parameters
    ----------
    series : array, shape (n,)
    lags : int
        Fewer than (n - 1)/2.
    """
    squares = series**2
    past = np.stack([squares[lags - k - 1 : -k - 1] for k in range(lags)], axis=1)
    design = np.column_stack([np.ones(len(past)), past])
    present = squares[lags:]
    left = present - design @ np.linalg.lstsq(design, present, rcond=None)[0]
    determination = 1.0 - float(left @ left) / float(np.sum((present - present.mean()) ** 2))
    return float(chdtrc(lags, len(past) * determination))


def rejects(tests: tuple[ResidualTest, ...]) -> bool:
    """Whether any of the tests rejects, at a level for all of them together (Bonferroni)."""
    return any(test.p_value < TEST_LEVEL / len(tests) for test in tests)


def outlying_groups(residuals: Residuals) -> tuple[tuple[str, float], ...]:
    """Return groups that the others do not predict, with their p-values (Bonferroni over groups).

    The squared Mahalanobis length of a group's error is χ² with as many degrees of freedom as the group has values.
    """
    names = list(dict.fromkeys(residuals.groups.tolist()))
    groups = [np.flatnonzero(residuals.groups == name) for name in names]
    found = []
    for name, (error, covariance) in zip(names, residuals.covariance.left_out(residuals.values, groups), strict=True):
        squared = float(error @ np.linalg.solve(covariance, error))
        p_value = min(1.0, float(chdtrc(len(error), squared)) * len(names))
        if p_value < OUTLYING and len(names) > 1:
            found.append((name, p_value))
    return tuple(found)
