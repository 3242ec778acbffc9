"""What `identify` finds in a data set of the tank: parameters with errors, fits, and a fragment of a vehicle file."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar

import pandas as pd

from missionplan.arrays import Array
from missionplan.results.base import Provenance, Result, to_csv, to_yaml


@dataclass(frozen=True)
class IdentifiedParameter:
    """A parameter: SI `value`, standard deviation `sd`, 90 % interval from `low` to `high`, `unit` and symbol."""

    name: str
    symbol: str
    value: float
    sd: float
    low: float
    high: float
    unit: str


@dataclass(frozen=True)
class FittedModel:
    """A model fitted to data by weighted least squares.

    Attributes
    ----------
    name : str
        The model in words: "constant drag coefficient".
    estimates : tuple of IdentifiedParameter
        Its parameters.
    chi_squared : float
        Weighted sum of squared residuals, with the stated errors; nan where none were stated.
    degrees_of_freedom : int
        Data less parameters.
    widened : float
        Factor by which the standard errors were widened for scatter beyond the stated errors, or for residuals
        that follow one another; 1 for none.
    fitted : array, shape (points,)
        The model at the data.
    residual_sd : float
        Root mean square of data less model, with the degrees of freedom taken off, in the data's unit.
    covariance : array, shape (parameters, parameters)
        Of the estimates, widened.
    """

    name: str
    estimates: tuple[IdentifiedParameter, ...]
    chi_squared: float
    degrees_of_freedom: int
    widened: float
    fitted: Array
    residual_sd: float
    covariance: Array

    def __getitem__(self, name: str) -> IdentifiedParameter:
        """Estimate of a parameter by name."""
        return next(estimate for estimate in self.estimates if estimate.name == name)

    def __contains__(self, name: object) -> bool:
        """Whether the fit has a parameter of that name."""
        return any(estimate.name == name for estimate in self.estimates)


@dataclass(frozen=True)
class FitCurve:
    """A line to draw: a model between the data, or another set of points (`dots`)."""

    label: str
    x: Array
    y: Array
    dots: bool = False


@dataclass(frozen=True)
class FitPanel:
    """Data and fits that share two axes; `fitted` is the preferred model at the data, `ticks` name the places on x."""

    name: str
    x_label: str
    y_label: str
    x: Array
    y: Array
    y_sd: Array
    fitted: Array
    curves: tuple[FitCurve, ...]
    alt: str
    ticks: tuple[str, ...] = ()


@dataclass(frozen=True)
class TankAnalysis:
    """What the fitting of one kind of data set hands to the result."""

    answer: str
    fits: tuple[FittedModel, ...]
    panels: tuple[FitPanel, ...]
    remarks: tuple[str, ...]
    fragment: Mapping[str, Any]
    derived: tuple[IdentifiedParameter, ...] = ()


@dataclass(frozen=True)
class Identification(Result):
    """Result of `identify`.

    Attributes
    ----------
    kind, name, source : str
        Of the data set.
    analysis : TankAnalysis
        Fits (the preferred one first), panels, remarks and fragment.
    """

    report: ClassVar[str] = "identification"
    provenance: Provenance
    kind: str
    name: str
    source: str
    analysis: TankAnalysis = field(repr=False)

    @property
    def fits(self) -> tuple[FittedModel, ...]:
        """Fits, the preferred one first."""
        return self.analysis.fits

    @property
    def estimates(self) -> tuple[IdentifiedParameter, ...]:
        """Parameters of the preferred fit, then what follows from them."""
        return (*self.fits[0].estimates, *self.analysis.derived)

    def __getitem__(self, name: str) -> IdentifiedParameter:
        """Parameter of the preferred fit, or derived from it, by name."""
        return next(estimate for estimate in self.estimates if estimate.name == name)

    def summary(self) -> dict[str, Any]:
        """The dictionary of `summary.json`; keys of parameters are their names, units beside them."""
        return {
            **self.provenance.summary(),
            "kind": self.kind,
            "dataset": self.name,
            "preferred": self.fits[0].name,
            "parameters": [_entry(estimate) for estimate in self.estimates],
            "fits": [
                {
                    "model": fit.name,
                    "chi_squared": fit.chi_squared,
                    "degrees_of_freedom": fit.degrees_of_freedom,
                    "widened": fit.widened,
                    "parameters": [_entry(estimate) for estimate in fit.estimates],
                }
                for fit in self.fits
            ],
            "remarks": list(self.analysis.remarks),
            "vehicle_fragment": dict(self.analysis.fragment),
        }

    def to_frame(self) -> pd.DataFrame:
        """Parameters of every fit, one a row."""
        rows = [{"model": fit.name, **_entry(estimate)} for fit in self.fits for estimate in fit.estimates]
        rows += [{"model": "derived", **_entry(estimate)} for estimate in self.analysis.derived]
        return pd.DataFrame(rows)

    def residuals(self) -> pd.DataFrame:
        """Data, preferred model and residuals of every panel."""
        frames = [
            pd.DataFrame(
                {
                    "panel": panel.name,
                    "x": panel.x,
                    "y": panel.y,
                    "fitted": panel.fitted,
                    "residual": panel.y - panel.fitted,
                }
            )
            for panel in self.analysis.panels
        ]
        return pd.concat(frames, ignore_index=True)

    def files(self) -> dict[str, str | bytes]:
        """Tables and the vehicle fragment."""
        return {
            "parameters.csv": to_csv(self.to_frame()),
            "residuals.csv": to_csv(self.residuals()),
            "vehicle-fragment.yaml": to_yaml(self.analysis.fragment),
        }


def _entry(estimate: IdentifiedParameter) -> dict[str, Any]:
    return {
        "name": estimate.name,
        "value": estimate.value,
        "sd": estimate.sd,
        "low": estimate.low,
        "high": estimate.high,
        "unit": estimate.unit,
    }
