"""The answer of a sweep of the maximum leg length: cost against d_max for each velocity error."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
import pandas as pd

from missionplan.montecarlo.statistics import Probability
from missionplan.results.base import Provenance, Result, to_csv


@dataclass(frozen=True)
class SweepPoint:
    """One d_max.

    Attributes
    ----------
    d_max : float
        Maximum leg length [m].
    d_max_over_distance : float
    cost : float
        Mean of c = (t_f − t_nom)/t_nom (Briggs et al., Eq. 25) of the trials that arrived, the arrival surfacing not
        charged; the analytic one where no trials were run. nan where no trial arrived.
    standard_error : float
        Of `cost`; 0 where no trials were run.
    sd : float
        Of the cost of a trial.
    surfacings : float
        Mean number, the arrival's included, of the trials that arrived.
    arrived : Probability
        Of arriving within the mission's `max_legs`.
    cost_analytic : float or None
        From the integral equation; None where it does not apply.
    excess_error : float
        Standard error of the difference between this cost and the best one, on the same trials.
    as_good : bool
        Whether it costs no more than the best by over two such standard errors.
    """

    d_max: float
    d_max_over_distance: float
    cost: float
    standard_error: float
    sd: float
    surfacings: float
    arrived: Probability
    cost_analytic: float | None
    excess_error: float
    as_good: bool


@dataclass(frozen=True)
class SweepCurve:
    """Cost against d_max for one velocity error.

    Attributes
    ----------
    sigma : float
        σ_v [m/s]; of an anisotropic Σ_v the root mean of its variances.
    points : tuple of SweepPoint
        By increasing d_max.
    best_index : int
        Of the point of least cost, among those at which practically as many trials arrive as at any.
    one_leg : SweepPoint
        The naive choice: d_max the whole distance.
    table : SweepPoint or None
        The transit's own table of legs, where it has one; its `d_max` is nan.
    """

    sigma: float
    points: tuple[SweepPoint, ...]
    best_index: int
    one_leg: SweepPoint
    table: SweepPoint | None = None

    @property
    def best(self) -> SweepPoint:
        """The point of least cost."""
        return self.points[self.best_index]

    @property
    def as_good(self) -> tuple[SweepPoint, ...]:
        """Points that the trials cannot tell from the best."""
        return tuple(point for point in self.points if point.as_good)


@dataclass(frozen=True)
class Sweep(Result):
    """Cost of each d_max for each velocity error.

    Attributes
    ----------
    provenance : Provenance
    phase : str
        Name of the transit.
    method : str
        ``both``, ``analytic`` or ``monte-carlo``.
    distance, speed, surfacing_time, arrival_radius : float
        Of the transit, distributions at their means [m, m/s, s, m].
    curves : tuple of SweepCurve
    """

    report: ClassVar[str] = "leg_length.sweep"

    provenance: Provenance
    phase: str
    method: str
    distance: float
    speed: float
    surfacing_time: float
    arrival_radius: float
    curves: tuple[SweepCurve, ...]

    @property
    def nominal_time(self) -> float:
        """t_nom = ‖x_f − x_0‖/U [s]."""
        return self.distance / self.speed

    @cached_property
    def critical_points(self) -> tuple[float, ...]:
        """The d_max/L = 1/a (Briggs et al., Eq. 27) within the range swept."""
        ratios = [point.d_max_over_distance for curve in self.curves for point in curve.points]
        return tuple(1.0 / a for a in range(1, int(1.0 / min(ratios)) + 1) if 1.0 / a <= max(ratios) + 1e-12)

    def saving(self, curve: SweepCurve) -> float:
        """Time that the best d_max saves against one leg, on the mean [s]."""
        return (curve.one_leg.cost - curve.best.cost) * self.nominal_time

    def to_frame(self) -> pd.DataFrame:
        """One row a velocity error and d_max."""
        rows = [{"sigma_m_s": curve.sigma, **_row(point)} for curve in self.curves for point in curve.points]
        frame = pd.DataFrame(rows)
        return frame if frame["cost_analytic"].notna().any() else frame.drop(columns="cost_analytic")

    def files(self) -> dict[str, str | bytes]:
        """Give ``sweep.csv``."""
        return {"sweep.csv": to_csv(self.to_frame())}

    def summary(self) -> dict[str, Any]:
        """Give the dictionary of ``summary.json``."""
        return {
            **self.provenance.summary(),
            "method": self.method,
            "phase": self.phase,
            "distance_m": self.distance,
            "nominal_time_s": self.nominal_time,
            "sweep": [self._curve_summary(curve) for curve in self.curves],
        }

    def _curve_summary(self, curve: SweepCurve) -> dict[str, Any]:
        return {
            "sigma_m_s": curve.sigma,
            "curve": [_point_summary(point) for point in curve.points],
            "best": _short(curve.best),
            "one_leg": _short(curve.one_leg),
            "as_good_as_best": [point.d_max for point in curve.as_good],
            "saving_s": self.saving(curve),
            **({} if curve.table is None else {"table": _table_summary(curve.table)}),
        }


def _row(point: SweepPoint) -> dict[str, Any]:
    return {
        "d_max_m": point.d_max,
        "d_max_over_distance": point.d_max_over_distance,
        "cost": point.cost,
        "standard_error": point.standard_error,
        "sd": point.sd,
        "surfacings": point.surfacings,
        "arrived": point.arrived.value,
        "cost_analytic": np.nan if point.cost_analytic is None else point.cost_analytic,
        "excess_standard_error": point.excess_error,
        "as_good_as_best": point.as_good,
    }


def _point_summary(point: SweepPoint) -> dict[str, Any]:
    row = _row(point)
    if point.cost_analytic is None:
        del row["cost_analytic"]
    row["arrived"] = point.arrived.summary()
    return row


def _table_summary(point: SweepPoint) -> dict[str, Any]:
    summary = _point_summary(point)
    return {key: value for key, value in summary.items() if not key.startswith("d_max")}


def _short(point: SweepPoint) -> dict[str, Any]:
    keys = ("d_max_m", "d_max_over_distance", "cost", "standard_error")
    row = _row(point)
    return {key: row[key] for key in keys}
