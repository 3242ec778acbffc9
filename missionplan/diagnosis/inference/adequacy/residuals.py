"""Residuals: what a fitted model leaves, in the units of the data and as numbers that should be independent normals."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular

from missionplan.arrays import Array
from missionplan.diagnosis.inference.adequacy.axes import Axis


@dataclass(frozen=True)
class InnerProducts:
    """Inner products xᵀW⁻¹y of columns and residuals, W the residuals' covariance at one level of the model's noise."""

    log_weight: float
    """Log prior weight of that noise."""
    log_determinant: float
    """ln |W|."""
    gram: Array
    """Of m columns and, last, the residuals, shape (m + 1, m + 1)."""


@dataclass(frozen=True)
class Residuals:
    """Residuals of the base model and their joint distribution under a set of causes."""

    values: Array
    """Data less the prior mean of the (linearised) model, in the order of the record, shape (N,)."""
    covariance: Array
    """Of the values under the model, uncertain parameters included, shape (N, N)."""
    series: NDArray[np.int_]
    """Which series each value belongs to: runs and components, shape (N,)."""
    axes: Sequence[Axis]
    """Along which a discrepancy may be smooth."""
    groups: NDArray[np.str_]
    """Runs, which the search for outlying groups leaves out in turn, shape (N,)."""
    quantised: bool = False
    """Whether the residual tests ignore what alternates, as readings of a coarse sensor in quick succession do."""
    products_by_noise: Callable[[Array], Sequence[InnerProducts]] | None = None
    """From columns, shape (N, m), to their inner products at every noise over which the test for a discrepancy
    averages; default the one noise of the covariance."""

    @cached_property
    def _factor(self) -> Array:
        return np.asarray(np.linalg.cholesky(self.covariance), dtype=float)

    def innovations(self) -> Array:
        """Return one-step-ahead errors over their standard deviations, shape (N,): white noise if all is well.

        L⁻¹ r with W = L Lᵀ: the prediction-error decomposition (Harvey 1989, *Forecasting, Structural Time Series
        Models and the Kalman Filter*, section 3.4).
        """
        return np.asarray(solve_triangular(self._factor, self.values, lower=True, check_finite=False))

    def inner_products(self, columns: Array) -> Sequence[InnerProducts]:
        """Return inner products of columns, shape (N, m), and the values at every noise over which to average."""
        if self.products_by_noise is not None:
            return self.products_by_noise(columns)
        both = np.concatenate([columns, self.values[:, None]], axis=1)
        white = solve_triangular(self._factor, both, lower=True, check_finite=False)
        return [InnerProducts(0.0, 2.0 * float(np.log(np.diag(self._factor)).sum()), white.T @ white)]
