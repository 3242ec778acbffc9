"""Result of `identify`: parameters from tank data with their errors, fitted models, a fragment of a vehicle file."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, ClassVar

import pandas as pd

from missionplan.arrays import Array
from missionplan.results.base import Provenance, Result, to_csv, to_yaml
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

    def interval_in_words(self, digits: str) -> str:
        """Write `` (90 % interval 1.2 to 1.4 kg)`` in a format such as ``.3g``; empty where there is none."""
        unit = f" {self.unit}" if self.unit else ""
        return f" (90 % interval {self.low:{digits}} to {self.high:{digits}}{unit})" if self.has_interval else ""

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

    def residuals(self) -> pd.DataFrame:
        """Data, preferred model and residuals, one row per point."""
        residual = self.y - self.fitted
        columns = {"panel": self.name, "x": self.x, "y": self.y, "fitted": self.fitted, "residual": residual}
        return pd.DataFrame(columns)


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
        return pd.concat([panel.residuals() for panel in self.panels], ignore_index=True)

    def files(self) -> dict[str, str | bytes]:
        """Return the tables and the vehicle fragment."""
        return {
            "parameters.csv": to_csv(self.to_frame()),
            "residuals.csv": to_csv(self.residuals()),
            "vehicle-fragment.yaml": to_yaml(self.fragment),
        }
