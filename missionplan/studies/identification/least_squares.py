"""Weighted least squares with honest errors: the one fitting routine of `identify`."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats
from scipy.optimize import least_squares

from missionplan.arrays import Array
from missionplan.errors import RunError
from missionplan.results.identification import FittedModel, IdentifiedParameter

INTERVAL = 0.90
RANK_TOLERANCE = 1e-9
"""Least singular value over the largest, of the scaled Jacobian, below which a parameter is not in the data."""


@dataclass(frozen=True)
class Parameter:
    """A parameter to fit: name, symbol, unit, where to start and its bounds."""

    name: str
    symbol: str
    unit: str
    start: float
    low: float = -np.inf
    high: float = np.inf


def fit(
    name: str,
    model: Callable[[Array], Array],
    parameters: Sequence[Parameter],
    data: Array,
    data_sd: Array | None = None,
    *,
    in_sequence: bool = False,
) -> FittedModel:
    """Fit a model to data by least squares.

    Parameters
    ----------
    name : str
        The model in words.
    model : callable
        Parameters (in the given order) to the model at the data, shape (points,).
    parameters : sequence of Parameter
        What to fit.
    data : array, shape (points,)
        Measured.
    data_sd : array, shape (points,), optional
        Stated standard deviations. Where the scatter is wider than they say, the errors are widened by √(χ²/ν);
        without them the scatter itself is the error.
    in_sequence : bool
        Whether the data are samples of one record: errors are then widened for residuals that follow one
        another, by √((1 + r)/(1 - r)) of their lag-one correlation r.

    Returns
    -------
    FittedModel
        With 90 % intervals of Student's t.

    Raises
    ------
    RunError
        When there are too few data, the fit does not converge, or the data leave a combination of the parameters
        open.
    """
    dof = len(data) - len(parameters)
    if dof < 1:
        raise RunError(f"{name}: {len(data)} points do not suffice for {len(parameters)} parameters and an error")
    scale = np.ones_like(data) if data_sd is None else data_sd
    start = np.array([parameter.start for parameter in parameters])
    bounds = ([parameter.low for parameter in parameters], [parameter.high for parameter in parameters])

    def misfit(values: Array) -> Array:
        return (model(values) - data) / scale

    solution = least_squares(
        misfit,
        start,
        bounds=bounds,
        x_scale="jac",
        xtol=1e-12,
        ftol=1e-12,
        gtol=1e-12,
    )
    if not solution.success:
        raise RunError(f"{name}: the fit did not converge ({solution.message})")
    covariance = _covariance(name, np.asarray(solution.jac), parameters)
    chi_squared = float(2.0 * solution.cost)
    fitted = model(solution.x)
    widened = _widening(chi_squared / dof, data_sd is not None, data - fitted if in_sequence else None)
    spread = covariance * widened**2 * (1.0 if data_sd is not None else chi_squared / dof)
    deviations = np.sqrt(np.diag(spread))
    reach = float(stats.t.ppf(0.5 + INTERVAL / 2.0, dof))
    estimates = tuple(
        IdentifiedParameter(p.name, p.symbol, float(v), float(sd), float(v - reach * sd), float(v + reach * sd), p.unit)
        for p, v, sd in zip(parameters, solution.x, deviations, strict=True)
    )
    residual_sd = float(np.sqrt(np.sum((data - fitted) ** 2) / dof))
    stated = chi_squared if data_sd is not None else float("nan")
    return FittedModel(name, estimates, stated, dof, widened, fitted, residual_sd, spread)


def _widening(chi_squared_per_dof: float, stated: bool, residuals: Array | None) -> float:
    factor = float(np.sqrt(max(1.0, chi_squared_per_dof))) if stated else 1.0
    if residuals is not None and np.any(residuals != 0.0):
        follow = float(np.sum(residuals[1:] * residuals[:-1]) / np.sum(residuals**2))
        follow = min(max(follow, 0.0), 0.99)
        factor *= float(np.sqrt((1.0 + follow) / (1.0 - follow)))
    return factor


def _covariance(name: str, jacobian: Array, parameters: Sequence[Parameter]) -> Array:
    """Invert JᵀJ in scaled columns, and say which parameter the data leave open."""
    norms = np.linalg.norm(jacobian, axis=0)
    for norm, parameter in zip(norms, parameters, strict=True):
        if norm == 0.0:
            raise RunError(f"{name}: the data say nothing of {parameter.name}")
    _, singular, rows = np.linalg.svd(jacobian / norms, full_matrices=False)
    if singular[-1] < RANK_TOLERANCE * singular[0]:
        open_ = [p.name for p, weight in zip(parameters, rows[-1], strict=True) if abs(weight) > 0.1]
        raise RunError(f"{name}: {' and '.join(open_)} cannot be told apart with these data")
    inverse = (rows.T / singular**2) @ rows
    covariance: Array = inverse / np.outer(norms, norms)
    return covariance


def derived(
    name: str, symbol: str, unit: str, source: IdentifiedParameter, factor: float, offset: float = 0.0
) -> IdentifiedParameter:
    """Estimate of ``factor`` × a parameter + ``offset``, errors carried along."""
    ends = sorted((factor * source.low + offset, factor * source.high + offset))
    return IdentifiedParameter(
        name, symbol, factor * source.value + offset, abs(factor) * source.sd, ends[0], ends[1], unit
    )


def adds_something(simple: FittedModel, richer: FittedModel, level: float = 0.01) -> bool:
    """Whether a richer, nested model is worth its parameters: an F test of the residual sums, by default at 1 %."""
    extra = simple.degrees_of_freedom - richer.degrees_of_freedom
    sum_simple = simple.residual_sd**2 * simple.degrees_of_freedom
    sum_richer = richer.residual_sd**2 * richer.degrees_of_freedom
    if not np.isnan(simple.chi_squared):
        sum_simple, sum_richer = simple.chi_squared, richer.chi_squared
    if sum_richer <= 0.0:
        return sum_simple > 0.0
    ratio = (sum_simple - sum_richer) / extra / (sum_richer / richer.degrees_of_freedom)
    return bool(stats.f.sf(ratio, extra, richer.degrees_of_freedom) < level)
