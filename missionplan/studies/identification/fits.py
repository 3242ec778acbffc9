"""Result of `identify`: parameters from tank data with their errors, fitted models, a fragment of a vehicle file.

Models are fitted by weighted least squares, with errors that allow for the scatter: `fit`.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np
import pandas as pd
from scipy.optimize import OptimizeResult, least_squares
from scipy.special import chdtrc, fdtrc, stdtrit

from missionplan.arrays import Array
from missionplan.errors import RunError
from missionplan.report.wording import significant
from missionplan.results import Provenance, Result, to_csv, to_yaml
from missionplan.results.entries import Entry, Record


@dataclass(frozen=True)
class IdentifiedParameter(Record):
    """An estimated parameter; its unit stands beside its value, not in the key."""

    name: Annotated[str, Entry("of the parameter")]
    symbol: str
    value: Annotated[float, Entry("estimate, in `unit`")]
    sd: Annotated[float, Entry("its standard deviation, in `unit`")]
    low: Annotated[float, Entry("begin of the 90 % interval; null without one: no error is known, or no fit")]
    high: Annotated[float, Entry("end of the 90 % interval")]
    unit: Annotated[str, Entry("of all of them; empty for bare numbers")]

    @property
    def has_interval(self) -> bool:
        """Whether there is an interval."""
        return math.isfinite(self.low) and math.isfinite(self.high)

    @property
    def in_words(self) -> str:
        """Write ``1.31 kg (90 % interval 1.22 to 1.40 kg)``, to two digits of its error; no interval where none is."""
        unit, error = f" {self.unit}" if self.unit else "", self.sd if self.has_interval else math.nan
        value, low, high = (significant(number, error) for number in (self.value, self.low, self.high))
        return f"{value}{unit} (90 % interval {low} to {high}{unit})" if self.has_interval else f"{value}{unit}"

    @property
    def note(self) -> Annotated[str, Entry()]:
        """Why there is no interval; empty where there is one."""
        if self.has_interval:
            return ""
        return "the model does not fit: no interval" if math.isfinite(self.sd) else "the data state no error"


@dataclass(frozen=True)
class FittedModel(Record):
    """A model fitted to data by weighted least squares."""

    name: Annotated[str, Entry('in words, such as "constant drag coefficient"', key="model")]
    estimates: Annotated[tuple[IdentifiedParameter, ...], Entry("its parameters", key="parameters")]
    chi_squared: Annotated[
        float, Entry("weighted sum of squared residuals, with the stated errors; null where none were stated")
    ]
    degrees_of_freedom: Annotated[int, Entry("data less parameters")]
    does_not_fit: Annotated[
        bool, Entry("whether the residuals are so much larger than the stated errors that the model is wrong")
    ]
    widened: Annotated[
        float,
        Entry(
            "factor by which the standard errors were widened for scatter beyond the stated errors, or for "
            "autocorrelated residuals; 1 for none"
        ),
    ]
    fitted: Array
    """The model at the data, shape (points,)."""
    residual_sd: float
    """Residual standard deviation: root of the residual sum of squares over the degrees of freedom [data's unit]."""
    covariance: Array
    """Of the estimates, widened likewise, shape (parameters, parameters)."""

    def __getitem__(self, name: str) -> IdentifiedParameter:
        """Estimate of a parameter by name."""
        return next(estimate for estimate in self.estimates if estimate.name == name)

    def __contains__(self, name: object) -> bool:
        """Whether the model has a parameter of that name."""
        return any(estimate.name == name for estimate in self.estimates)


@dataclass(frozen=True)
class FitCurve:
    """A line to draw over the data: a model, or another set of points where `dots` is true."""

    label: str
    x: Array
    y: Array
    dots: bool = False


@dataclass(frozen=True)
class FitPanel:
    """Data and fits on common axes; `fitted` is the preferred model at the data, `ticks` are labels of the x values."""

    name: str
    x_label: str
    y_label: str
    x: Array
    y: Array
    fitted: Array
    curves: tuple[FitCurve, ...]
    alt: str
    ticks: tuple[str, ...] = ()
    y_sd: Array | float | None = None
    """Of the data, nan or None where it is not known."""


@dataclass(frozen=True)
class TankAnalysis(Record):
    """Analysis of one data set: the answer in words, fitted models (the preferred one first), and their figures."""

    answer: str
    """The main finding in a sentence."""
    fits: Annotated[tuple[FittedModel, ...], Entry("fitted models, the preferred one first")]
    panels: tuple[FitPanel, ...]
    remarks: Annotated[tuple[str, ...], Entry("on the quality of the data and the fits, in sentences")]
    fragment: Annotated[Mapping[str, object], Entry("keys of a vehicle file", key="vehicle_fragment")]
    derived: tuple[IdentifiedParameter, ...] = ()
    """Parameters that follow from those of the preferred model."""


@dataclass(frozen=True, kw_only=True)
class Identification(TankAnalysis, Result):
    """Result of `identify`."""

    report: ClassVar[str] = "missionplan.studies.identification.page"
    provenance: Provenance
    kind: Annotated[str, Entry("of the data set")]
    name: Annotated[str, Entry("name of the data set", key="dataset")]
    source: str
    """Of the data set."""

    @property
    def estimates(self) -> Annotated[tuple[IdentifiedParameter, ...], Entry(key="parameters")]:
        """Parameters of the preferred model, then those derived from them."""
        return (*self.fits[0].estimates, *self.derived)

    def __getitem__(self, name: str) -> IdentifiedParameter:
        """Parameter of the preferred model, or derived from it, by name."""
        return next(estimate for estimate in self.estimates if estimate.name == name)

    @property
    def preferred(self) -> Annotated[str, Entry()]:
        """Name of the preferred model."""
        return self.fits[0].name

    @property
    def does_not_fit(self) -> Annotated[bool, Entry()]:
        """Whether the preferred model does not fit."""
        return self.fits[0].does_not_fit

    def to_frame(self) -> pd.DataFrame:
        """Parameters of every fitted model, one per row."""
        rows = [{"model": fit.name, **estimate.summary()} for fit in self.fits for estimate in fit.estimates]
        rows += [{"model": "derived", **estimate.summary()} for estimate in self.derived]
        return pd.DataFrame(rows)

    def residuals(self) -> pd.DataFrame:
        """Data, preferred model and residuals of every panel."""
        columns = [
            {"panel": pane.name, "x": pane.x, "y": pane.y, "fitted": pane.fitted, "residual": pane.y - pane.fitted}
            for pane in self.panels
        ]
        return pd.concat(map(pd.DataFrame, columns), ignore_index=True)

    def files(self) -> dict[str, str | bytes]:
        """Return the tables and the vehicle fragment."""
        return {
            "parameters.csv": to_csv(self.to_frame()),
            "residuals.csv": to_csv(self.residuals()),
            "vehicle-fragment.yaml": to_yaml(self.fragment),
        }


INTERVAL = 0.90
"""Probability of the intervals."""
RANK_TOLERANCE = 1e-9
"""Least singular value over the largest, of the scaled Jacobian, below which a parameter is not identifiable."""
IMPROBABLE = 1e-3
"""Probability of a chi-squared as large below which it is no chance."""
STATED_WITHIN = 1.5
"""Factor by which stated errors may be too small: what is larger still is the model's.

Its parameters then have no interval. What the model leaves out shifts them by an amount that residuals do not tell: at
the least squares they are orthogonal to every parameter. Factors on the errors take the misfit for scatter (Birge 1932)
and hold where it is.
"""


@dataclass(frozen=True)
class FitParameter:
    """A parameter to fit: name, symbol, unit, starting value and bounds."""

    name: str
    symbol: str
    unit: str
    start: float
    low: float = -np.inf
    high: float = np.inf


def fit(
    name: str,
    model: Callable[[Array], Array],
    parameters: Sequence[FitParameter],
    data: Array,
    data_sd: Array | float | None = None,
    *,
    in_sequence: bool = False,
) -> FittedModel:
    """Fit a model to data by least squares (trust region reflective, Branch, Coleman & Li 1999).

    The covariance is that of the linearised model (Bates & Watts 1988, Nonlinear Regression Analysis and Its
    Applications, ch. 2).

    Parameters
    ----------
    name : str
        The model in words.
    model : callable
        From parameters, in the given order, to the model at the data, shape (points,).
    data : array, shape (points,)
        Measured.
    data_sd : array, shape (points,), or float, optional
        Stated standard deviations. Where the scatter is larger, the errors are widened by √(χ²/ν) (Birge 1932, Phys.
        Rev. 40, 207–227); without them the scatter itself is the error.
    in_sequence : bool
        Whether the data are samples of one record: errors are then widened for correlated residuals, by
        √((1 + r)/(1 - r)) of their lag-one correlation r (Bayley & Hammersley 1946, J. R. Stat. Soc. Suppl. 8,
        184–197).

    Returns
    -------
    FittedModel
        With 90 % intervals of Student's t; none where the model does not fit (`STATED_WITHIN`).

    Raises
    ------
    RunError
        When there are too few data, the fit does not converge, or the data do not determine a combination of the
        parameters.
    """
    dof = len(data) - len(parameters)
    if dof < 1:
        raise RunError(f"{name}: {len(data)} points do not suffice for {len(parameters)} parameters and an error")
    scale = 1.0 if data_sd is None else data_sd
    solution = _solution(name, lambda values: (model(values) - data) / scale, parameters)
    covariance = _covariance(name, np.asarray(solution.jac), parameters)
    chi_squared = float(2.0 * solution.cost)
    fitted = model(solution.x)
    # factor on the errors for scatter beyond the stated errors, and for correlated residuals where they are given
    residuals = data - fitted if in_sequence else None
    widened = float(np.sqrt(max(1.0, (chi_squared / dof)))) if (data_sd is not None) else 1.0
    if residuals is not None and np.any(residuals != 0.0):
        correlation = float(np.sum(residuals[1:] * residuals[:-1]) / np.sum(residuals**2))
        correlation = min(max(correlation, 0.0), 0.99)
        widened *= float(np.sqrt((1.0 + correlation) / (1.0 - correlation)))
    spread = covariance * widened**2 * (1.0 if data_sd is not None else chi_squared / dof)
    deviations = np.sqrt(np.diag(spread))
    wrong = data_sd is not None and bool(chdtrc(dof, chi_squared / STATED_WITHIN**2) < IMPROBABLE)
    quantile = np.nan if wrong else float(stdtrit(dof, 0.5 + INTERVAL / 2.0))
    estimates = tuple(
        with_interval(p.name, p.symbol, p.unit, float(value), float(sd), quantile)
        for p, value, sd in zip(parameters, solution.x, deviations, strict=True)
    )
    if not (np.all(np.isfinite(solution.x)) and np.all(np.isfinite(deviations))):
        raise RunError(f"{name}: the data do not determine the parameters")
    residual_sd = float(np.sqrt(np.sum((data - fitted) ** 2) / dof))
    stated = chi_squared if data_sd is not None else float("nan")
    return FittedModel(name, estimates, stated, dof, wrong, widened, fitted, residual_sd, spread)


def _solution(name: str, misfit: Callable[[Array], Array], parameters: Sequence[FitParameter]) -> OptimizeResult:
    """Minimise the misfit within the parameters' bounds.

    Raises RunError when it cannot start, fails or does not converge.
    """
    start, low, high = (np.array([getattr(p, key) for p in parameters]) for key in ("start", "low", "high"))
    if not (np.all((low <= start) & (start <= high)) and np.all(np.isfinite(misfit(start)))):
        raise RunError(f"{name}: the data are so large, so small or so uniform that no fit can start")
    try:
        solution = least_squares(misfit, start, bounds=(low, high), x_scale="jac", xtol=1e-12, ftol=1e-12, gtol=1e-12)
    except (ValueError, np.linalg.LinAlgError) as error:  # residuals that are not finite on the way
        raise RunError(f"{name}: the fit failed ({error})") from error
    if not solution.success:
        raise RunError(f"{name}: the fit did not converge ({solution.message})")
    return solution


def with_interval(name: str, symbol: str, unit: str, value: float, sd: float, quantile: float) -> IdentifiedParameter:
    """Return an estimate with the interval of so many standard deviations on either side."""
    return IdentifiedParameter(name, symbol, value, sd, value - quantile * sd, value + quantile * sd, unit)


def _covariance(name: str, jacobian: Array, parameters: Sequence[FitParameter]) -> Array:
    """Inverse of JᵀJ by a singular value decomposition of J with scaled columns.

    Raises RunError with the parameters that are not identifiable.
    """
    norms = np.linalg.norm(jacobian, axis=0)
    for norm, parameter in zip(norms, parameters, strict=True):
        if not 0.0 < norm < np.inf:
            raise RunError(f"{name}: the data do not depend on {parameter.name} in a way that numbers can hold")
    _, singular, rows = np.linalg.svd(jacobian / norms, full_matrices=False)
    if singular[-1] < RANK_TOLERANCE * singular[0]:
        confounded = [p.name for p, weight in zip(parameters, rows[-1], strict=True) if abs(weight) > 0.1]
        raise RunError(f"{name}: {' and '.join(confounded)} cannot be distinguished with these data")
    inverse = (rows.T / singular**2) @ rows
    return np.asarray(inverse / np.outer(norms, norms))


def scaled_estimate(
    name: str, symbol: str, unit: str, source: IdentifiedParameter, factor: float, offset: float = 0.0
) -> IdentifiedParameter:
    """Estimate of ``factor`` × a parameter + ``offset``, with its errors."""
    ends = sorted((factor * source.low + offset, factor * source.high + offset))
    return IdentifiedParameter(
        name, symbol, factor * source.value + offset, abs(factor) * source.sd, ends[0], ends[1], unit
    )


def preferred_first(simple: FittedModel, richer: FittedModel) -> tuple[FittedModel, FittedModel]:
    """Put the model first that an F test prefers."""
    return (richer, simple) if f_test_prefers(simple, richer) else (simple, richer)


def f_test_prefers(simple: FittedModel, richer: FittedModel) -> bool:
    """Whether an F test of the squares, at 1 %, prefers a richer model to the one within it (Bates & Watts, ch. 3)."""
    extra = simple.degrees_of_freedom - richer.degrees_of_freedom
    sum_simple = simple.residual_sd**2 * simple.degrees_of_freedom
    sum_richer = richer.residual_sd**2 * richer.degrees_of_freedom
    if not np.isnan(simple.chi_squared):
        sum_simple, sum_richer = simple.chi_squared, richer.chi_squared
    if sum_richer <= 0.0:
        return sum_simple > 0.0
    ratio = (sum_simple - sum_richer) / extra / (sum_richer / richer.degrees_of_freedom)
    return bool(fdtrc(extra, richer.degrees_of_freedom, ratio) < 0.01)
