"""Result of `sweep-dmax`: cost against the maximum leg length d_max, for each velocity error."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Annotated, ClassVar

import numpy as np

from missionplan.montecarlo.statistics import Probability
from missionplan.results import Provenance, Result, to_csv, to_grid
from missionplan.results.decision import FAILURE_LOSS, MemberOutcome
from missionplan.results.entries import Entry, Record
from missionplan.results.simulation import JUDGED, Outcome

if TYPE_CHECKING:
    import pandas as pd
    import xarray


SAME_COST = 0.01
"""Share of the best duration that a choice may lose and still be as good."""


@dataclass(frozen=True)
class SweepPoint(Record):
    """One d_max."""

    d_max: Annotated[float, Entry("maximum leg length", "m")]
    d_max_over_distance: Annotated[float, Entry("as a share of the transit's length")]
    cost: Annotated[
        float,
        Entry(
            "mean of c = (t_f − t_nom)/t_nom (Briggs et al., Eq. 25) over the trials that arrived, the surfacing on "
            "arrival not charged; the analytic cost where no trials were run; null where no trial arrived"
        ),
    ]
    standard_error: Annotated[float, Entry("of the cost; 0 where no trials were run")]
    sd: Annotated[float, Entry("of the cost, from trial to trial")]
    surfacings: Annotated[float, Entry("mean number, that on arrival included, over the trials that arrived")]
    arrived: Annotated[Probability, Entry("of arriving within the mission's `max_legs`")]
    cost_analytic: Annotated[
        float | None, Entry("from the integral equation; absent where it does not apply", optional=True)
    ]
    excess_error: Annotated[
        float,
        Entry("of the difference between this cost and the best one, on the same trials", key="excess_standard_error"),
    ]
    as_good: Annotated[
        bool,
        Entry("whether the cost exceeds the best one by no more than two such standard errors", key="as_good_as_best"),
    ]


_COST = "d_max_m", "d_max_over_distance", "cost", "standard_error"
_ARRIVING = *_COST, "arrived"
_OF_TABLE = (
    *("cost", "standard_error", "sd", "surfacings", "arrived", "cost_analytic"),
    *("excess_standard_error", "as_good_as_best"),
)


@dataclass(frozen=True)
class SweepCurve(Record):
    """Cost against d_max for one velocity error."""

    sigma: Annotated[float, Entry("σ_v; of an anisotropic Σ_v the root mean of its variances", "m/s")]
    points: Annotated[tuple[SweepPoint, ...], Entry("by increasing d_max", key="curve")]
    best_index: int
    """Index of the point of least cost, among those where practically as many trials arrive as anywhere."""
    one_leg: Annotated[SweepPoint, Entry("the naive choice: d_max equal to the whole distance", parts=_COST)]
    table: Annotated[
        SweepPoint | None,
        Entry("the transit's own table of legs, where it has one", optional=True, parts=_OF_TABLE),
    ]
    required_arrival: Annotated[
        float,
        Entry(
            "probability of arriving that a d_max must have to be recommended: the mission's requirement on it",
            key="recommended.required_arrival",
        ),
    ]
    nominal_time: float
    """t_nom of the transit [s]."""

    @property
    def best(self) -> Annotated[SweepPoint, Entry(parts=_COST)]:
        """The point of least cost."""
        return self.points[self.best_index]

    @property
    def recommended_index(self) -> int:
        """Index of the point of least cost among those that arrive as often as required; else with failures counted."""
        reaching = [index for index, point in enumerate(self.points) if self.reaches(point)]
        if reaching:
            return min(reaching, key=lambda index: self.points[index].cost)
        failing = ((1.0 + p.cost) * (1.0 + FAILURE_LOSS * (1.0 - p.arrived.value)) for p in self.points)
        costs = [cost if np.isfinite(cost) else np.inf for cost in failing]
        return costs.index(min(costs))

    @property
    def recommended(self) -> Annotated[SweepPoint, Entry(parts=_ARRIVING)]:
        """The point to choose."""
        return self.points[self.recommended_index]

    @property
    def reaches_required_arrival(self) -> Annotated[bool, Entry(key="recommended.reaches_required_arrival")]:
        """Whether it arrives as often as required."""
        return self.reaches(self.recommended)

    @property
    def recommended_saves(self) -> Annotated[float, Entry(unit="s", key="recommended.saving")]:
        """Mean time that it saves against a single leg."""
        return (self.one_leg.cost - self.recommended.cost) * self.nominal_time

    @property
    def best_saves(self) -> Annotated[float, Entry(unit="s", key="saving")]:
        """Mean time that the point of least cost saves against a single leg."""
        return (self.one_leg.cost - self.best.cost) * self.nominal_time

    @property
    def d_max_as_good(self) -> Annotated[list[float], Entry(key="as_good_as_best")]:
        """Lengths that the trials cannot distinguish from the best [m]."""
        return [point.d_max for point in self.as_good]

    def reaches(self, point: SweepPoint) -> bool:
        """Whether a plan arrives as often as required."""
        return point.arrived.value >= self.required_arrival

    @property
    def as_good(self) -> tuple[SweepPoint, ...]:
        """Points that the trials cannot distinguish from the best."""
        return tuple(point for point in self.points if point.as_good)


@dataclass(frozen=True)
class ExplainedSweep(Record):
    """Costs of every d_max when one explanation holds."""

    causes: Annotated[tuple[str, ...], Entry("effects of the explanation; empty for none")]
    probability: Annotated[float, Entry("of the explanation")]
    curve: SweepCurve
    chosen: Annotated[SweepPoint, Entry("what is recommended over all explanations", parts=_ARRIVING)]

    @property
    def recommended(self) -> Annotated[SweepPoint, Entry(parts=_ARRIVING)]:
        """What is recommended for this one alone."""
        return self.curve.recommended

    @property
    def excess(self) -> Annotated[float, Entry()]:
        """Duration that the choice over all explanations loses against the best for this one, as a share of it."""
        return (1.0 + self.chosen.cost) / (1.0 + self.curve.recommended.cost) - 1.0

    @property
    def keeps_choice(self) -> Annotated[bool, Entry()]:
        """Whether the choice over all explanations is as good as this one's own, and arrives as often as required."""
        reaches = self.curve.reaches(self.chosen) or not self.curve.reaches(self.curve.recommended)
        return reaches and self.excess <= SAME_COST


@dataclass(frozen=True)
class Sweep(Result):
    """Cost of each d_max for each velocity error."""

    report: ClassVar[str] = "missionplan.studies.leg_length.sweep_page"

    provenance: Provenance
    phase: Annotated[str, Entry("name of the transit")]
    method: Annotated[str, Entry("``both``, ``analytic`` or ``monte-carlo``")]
    distance: Annotated[float, Entry("length of the transit", "m")]
    speed: float
    surfacing_time: float
    arrival_radius: float
    """Of the transit, distributions at their means [m/s, s, m]."""
    curves: Annotated[tuple[SweepCurve, ...], Entry("a curve for each velocity error", key="sweep")]
    explanations: Annotated[
        tuple[ExplainedSweep, ...],
        Entry("the middle curve under each explanation of a mission that has doubts", optional=True),
    ] = ()
    members: Annotated[
        tuple[MemberOutcome, ...],
        Entry("arrival with the recommended d_max in each member of the current's ensemble", optional=True),
    ] = ()
    judged: Annotated[Outcome | None, JUDGED] = None

    @property
    def recommended_values(self) -> Mapping[str, object]:
        """The d_max that is recommended for the middle velocity error; none where none arrives."""
        best = self.middle.recommended
        return {f"{self.phase}.d_max": f"{best.d_max:.1f} m"} if np.isfinite(best.cost) else {}

    @property
    def nominal_time(self) -> Annotated[float, Entry(unit="s")]:
        """t_nom = ‖x_f − x_0‖/U."""
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

    def to_frame(self) -> "pd.DataFrame":
        """One row per velocity error and d_max."""
        from pandas import DataFrame

        return DataFrame(self._rows())

    def _rows(self) -> list[dict[str, object]]:
        """Rows of `to_frame`, without a column for the analytic cost where there is none."""
        rows = [{"sigma_m_s": curve.sigma, **point.row()} for curve in self.curves for point in curve.points]
        unknown = {"cost_analytic"} if all(math.isnan(row["cost_analytic"]) for row in rows) else set()
        return [{name: value for name, value in row.items() if name not in unknown} for row in rows]

    def to_xarray(self) -> "xarray.Dataset":
        """Return the table as arrays over velocity error and d_max; needs the extra ``netcdf``."""
        unit = {"sigma_m_s": "m/s", "d_max_m": "m"}
        return to_grid(self.to_frame(), ("sigma_m_s", "d_max_m"), unit)

    def files(self) -> dict[str, str | bytes]:
        """Return ``sweep.csv``."""
        return {"sweep.csv": to_csv(self._rows())}
