"""Result of `sweep-dmax`: cost against the maximum leg length d_max, for each velocity error."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar

import numpy as np
import pandas as pd

from missionplan.montecarlo.statistics import Probability
from missionplan.results.base import Provenance, Result, to_csv, to_grid
from missionplan.results.members import MemberOutcome

if TYPE_CHECKING:
    import xarray


SAME_COST = 0.01
"""Share of the best duration that a choice may lose and still be as good."""


@dataclass(frozen=True)
class SweepPoint:
    """One d_max.

    Attributes
    ----------
    d_max : float
        Maximum leg length [m].
    d_max_over_distance : float
    cost : float
        Mean of c = (t_f − t_nom)/t_nom (Briggs et al., Eq. 25) over the trials that arrived, the surfacing on arrival
        not charged; the analytic cost where no trials were run. nan where no trial arrived.
    standard_error : float
        Of `cost`; 0 where no trials were run.
    sd : float
        Of the cost, from trial to trial.
    surfacings : float
        Mean number, that on arrival included, over the trials that arrived.
    arrived : Probability
        Of arriving within the mission's `max_legs`.
    cost_analytic : float or None
        From the integral equation; None where it does not apply.
    excess_error : float
        Standard error of the difference between this cost and the best one, on the same trials.
    as_good : bool
        Whether the cost exceeds the best one by no more than two such standard errors.
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

    def row(self) -> dict[str, object]:
        """Return the row of the table."""
        return {
            "d_max_m": self.d_max,
            "d_max_over_distance": self.d_max_over_distance,
            "cost": self.cost,
            "standard_error": self.standard_error,
            "sd": self.sd,
            "surfacings": self.surfacings,
            "arrived": self.arrived.value,
            "cost_analytic": np.nan if self.cost_analytic is None else self.cost_analytic,
            "excess_standard_error": self.excess_error,
            "as_good_as_best": self.as_good,
        }

    def summary(self) -> dict[str, object]:
        """Return the entry of ``summary.json``."""
        entry = {**self.row(), "arrived": self.arrived.summary()}
        if self.cost_analytic is None:
            del entry["cost_analytic"]
        return entry

    def cost_summary(self) -> dict[str, object]:
        """Return the entry of ``summary.json`` for a d_max of the curve or for one leg: the cost alone."""
        row = self.row()
        return {key: row[key] for key in ("d_max_m", "d_max_over_distance", "cost", "standard_error")}


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
        Index of the point of least cost, among those where practically as many trials arrive as anywhere.
    one_leg : SweepPoint
        The naive choice: d_max equal to the whole distance.
    table : SweepPoint or None
        The transit's own table of legs, where it has one; its `d_max` is nan.
    required_arrival : float
        Probability of arriving that a d_max must have to be recommended: the mission's requirement on it.
    """

    sigma: float
    points: tuple[SweepPoint, ...]
    best_index: int
    one_leg: SweepPoint
    table: SweepPoint | None
    required_arrival: float

    @property
    def best(self) -> SweepPoint:
        """The point of least cost."""
        return self.points[self.best_index]

    @property
    def recommended_index(self) -> int:
        """Index of the point of least cost among those that arrive as often as required; else of the likeliest to."""
        reaching = [index for index, point in enumerate(self.points) if self.reaches(point)]
        if reaching:
            return min(reaching, key=lambda index: self.points[index].cost)
        return max(range(len(self.points)), key=lambda index: self._likeliest(self.points[index]))

    @property
    def recommended(self) -> SweepPoint:
        """The point to choose."""
        return self.points[self.recommended_index]

    def reaches(self, point: SweepPoint) -> bool:
        """Whether a plan arrives as often as required."""
        return point.arrived.value >= self.required_arrival

    @staticmethod
    def _likeliest(point: SweepPoint) -> tuple[float, float]:
        return point.arrived.value, -point.cost if np.isfinite(point.cost) else -np.inf

    @property
    def as_good(self) -> tuple[SweepPoint, ...]:
        """Points that the trials cannot distinguish from the best."""
        return tuple(point for point in self.points if point.as_good)


@dataclass(frozen=True)
class ExplainedSweep:
    """Costs of every d_max when one explanation holds.

    Attributes
    ----------
    causes : tuple of str
        Its effects; empty for none.
    probability : float
    curve : SweepCurve
    chosen : SweepPoint
        What is recommended over all explanations.
    """

    causes: tuple[str, ...]
    probability: float
    curve: SweepCurve
    chosen: SweepPoint

    @property
    def excess(self) -> float:
        """Duration that the choice over all explanations loses against the best for this one, as a share of it."""
        return (1.0 + self.chosen.cost) / (1.0 + self.curve.recommended.cost) - 1.0

    @property
    def keeps_choice(self) -> bool:
        """Whether the choice over all explanations is as good as this one's own, and arrives as often as required."""
        reaches = self.curve.reaches(self.chosen) or not self.curve.reaches(self.curve.recommended)
        return reaches and self.excess <= SAME_COST

    def summary(self) -> dict[str, object]:
        """Return the entry of ``summary.json``."""
        own = self.curve.recommended
        return {
            "causes": list(self.causes),
            "probability": self.probability,
            "recommended": {**own.cost_summary(), "arrived": own.arrived.summary()},
            "chosen": {**self.chosen.cost_summary(), "arrived": self.chosen.arrived.summary()},
            "excess": self.excess,
            "keeps_choice": self.keeps_choice,
        }


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
    members : tuple of MemberOutcome
        Arrival with the recommended d_max in each member of the current's ensemble; empty without one.
    explanations : tuple of ExplainedSweep
        The middle curve under each explanation of the mission; empty for a mission without doubts.
    """

    report: ClassVar[str] = "missionplan.report.leg_length.sweep"

    provenance: Provenance
    phase: str
    method: str
    distance: float
    speed: float
    surfacing_time: float
    arrival_radius: float
    curves: tuple[SweepCurve, ...]
    explanations: tuple[ExplainedSweep, ...] = ()
    members: tuple[MemberOutcome, ...] = ()

    @property
    def nominal_time(self) -> float:
        """t_nom = ‖x_f − x_0‖/U [s]."""
        return self.distance / self.speed

    @property
    def middle(self) -> SweepCurve:
        """The curve that the answer is about: that of the middle velocity error."""
        return sorted(self.curves, key=lambda curve: curve.sigma)[(len(self.curves) - 1) // 2]

    @cached_property
    def critical_points(self) -> tuple[float, ...]:
        """The d_max/L = 1/a (Briggs et al., Eq. 27) within the range swept."""
        ratios = [point.d_max_over_distance for curve in self.curves for point in curve.points]
        return tuple(1.0 / a for a in range(1, int(1.0 / min(ratios)) + 1) if 1.0 / a <= max(ratios) + 1e-12)

    def saving(self, curve: SweepCurve, point: SweepPoint) -> float:
        """Mean time that a d_max saves against a single leg [s]."""
        return (curve.one_leg.cost - point.cost) * self.nominal_time

    def to_frame(self) -> pd.DataFrame:
        """One row per velocity error and d_max."""
        rows = [{"sigma_m_s": curve.sigma, **point.row()} for curve in self.curves for point in curve.points]
        frame = pd.DataFrame(rows)
        return frame if frame["cost_analytic"].notna().any() else frame.drop(columns="cost_analytic")

    def to_xarray(self) -> "xarray.Dataset":
        """Return the table as arrays over velocity error and d_max; needs the extra ``netcdf``."""
        unit = {"sigma_m_s": "m/s", "d_max_m": "m"}
        return to_grid(self.to_frame(), ("sigma_m_s", "d_max_m"), unit)

    def files(self) -> dict[str, str | bytes]:
        """Return ``sweep.csv``."""
        return {"sweep.csv": to_csv(self.to_frame())}

    def summary(self) -> dict[str, object]:
        """Return the contents of ``summary.json``."""
        return {
            **self.provenance.summary(),
            "method": self.method,
            "phase": self.phase,
            "distance_m": self.distance,
            "nominal_time_s": self.nominal_time,
            "sweep": [self._curve_summary(curve) for curve in self.curves],
            **({"members": [each.summary() for each in self.members]} if self.members else {}),
            **({"explanations": [each.summary() for each in self.explanations]} if self.explanations else {}),
        }

    def _curve_summary(self, curve: SweepCurve) -> dict[str, object]:
        return {
            "sigma_m_s": curve.sigma,
            "curve": [point.summary() for point in curve.points],
            "best": curve.best.cost_summary(),
            "recommended": {
                **curve.recommended.cost_summary(),
                "arrived": curve.recommended.arrived.summary(),
                "required_arrival": curve.required_arrival,
                "reaches_required_arrival": curve.reaches(curve.recommended),
                "saving_s": self.saving(curve, curve.recommended),
            },
            "one_leg": curve.one_leg.cost_summary(),
            "as_good_as_best": [point.d_max for point in curve.as_good],
            "saving_s": self.saving(curve, curve.best),
            **({} if curve.table is None else {"table": _without_d_max(curve.table.summary())}),
        }


def _without_d_max(summary: Mapping[str, object]) -> dict[str, object]:
    return {key: value for key, value in summary.items() if not key.startswith("d_max")}
