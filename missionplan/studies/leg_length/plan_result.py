"""Result of `plan-legs`: how long a leg should be at each distance left, and what that saves or loses."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, ClassVar

import numpy as np

from missionplan.arrays import Array
from missionplan.montecarlo.statistics import Probability, Statistic
from missionplan.phases.transit.plan import LegTable
from missionplan.physics.propulsion import JOULES_PER_WATT_HOUR
from missionplan.results import Provenance, Result, to_csv, to_yaml
from missionplan.results.decision import MemberOutcome
from missionplan.results.entries import Entry, Record
from missionplan.results.simulation import JUDGED, Outcome

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class SampledCost(Record):
    """Cost of a plan in the mission's Monte Carlo, of the trials that arrived by both plans."""

    cost: Annotated[float, Entry("mean of c (Briggs et al., Eq. 25)")]
    standard_error: Annotated[float, Entry("of the cost")]
    surfacings: Annotated[float, Entry("mean number, the arrival's included")]
    arrived: Annotated[Probability, Entry("of arriving")]


@dataclass(frozen=True)
class MeanAndError(Record):
    """A mean difference of paired trials, and its standard error."""

    mean: Annotated[float, Entry("mean difference")]
    standard_error: Annotated[float, Entry("of the mean")]

    def __iter__(self) -> Iterator[float]:
        """Yield both, to be taken apart."""
        return iter((self.mean, self.standard_error))


UNKNOWN = MeanAndError(float("nan"), float("nan"))


@dataclass(frozen=True)
class LegCase(Record):
    """Both plans on the same trials: in the mission as it is, or with a navigation error that is not as planned."""

    name: str
    """How the case differs from the mission; empty for the mission itself."""
    sigma: Annotated[float, Entry("σ_v of the trials", "m/s")]
    mean_error: Annotated[
        tuple[float, float], Entry("velocity under way in addition to the mission's, east and north", "m/s")
    ]
    surface_drift: Annotated[
        tuple[float, float], Entry("velocity at the surface in addition to the mission's, east and north", "m/s")
    ]
    fixed: Annotated[SampledCost, Entry("with the best fixed d_max")]
    adaptive: Annotated[SampledCost, Entry("with the table of legs")]
    saved: Annotated[MeanAndError, Entry("mean time that the table saves, paired trial by trial", "s", "saving")]
    saved_energy: MeanAndError
    """The same of energy; nan where the mission has no energy budget [J]."""
    late: MeanAndError = UNKNOWN
    """For the aim ``p95`` alone: by how much sooner 95 % of all trials arrive [s], or how much likelier in time."""
    probability: Annotated[
        float | None,
        Entry("of the explanation that the case takes to hold", key="explanation", optional=True),
    ] = None

    @property
    def title(self) -> Annotated[str, Entry(key="name")]:
        """How the case differs from the mission."""
        return self.name or "as the mission"

    @property
    def saved_in_wh(self) -> Annotated[MeanAndError, Entry(unit="W h", key="energy_saving")]:
        """Mean energy that the table saves; null where the mission has no energy budget."""
        return MeanAndError(*(value / JOULES_PER_WATT_HOUR for value in self.saved_energy))

    @property
    def gain_p95(self) -> Annotated[MeanAndError | None, Entry(optional=True)]:
        """By how much sooner 95 % of all trials arrive [s], or how much likelier in time, for the aim ``p95``."""
        return self.late if np.isfinite(self.late.standard_error) else None

    def saving_for(self, aim: str) -> tuple[float, float]:
        """Return what the table saves by an aim, and its standard error [J for energy, s, or a probability]."""
        mean, error = self.saved_energy if aim == "energy" else self.late if aim == "p95" else self.saved
        return mean, error


@dataclass(frozen=True)
class CandidatePlan(Record):
    """A plan of legs judged by its aim, on trials other than those on which it was chosen."""

    name: Annotated[str, Entry("of the plan")]
    speed: Annotated[float, Entry("through the water", "m/s")]
    duration: Annotated[
        Statistic, Entry("of the transit, of the trials that arrived, the arrival's surfacing included", "s")
    ]
    energy: Statistic
    """Energy [J]."""
    on_time: Annotated[Probability, Entry("of arriving by the deadline; of arriving where there is none")]
    value: float
    standard_error: float
    """What the aim minimises [s, or J]; for a deadline the probability of meeting it, which is maximised."""

    @property
    def energy_in_wh(self) -> Annotated[dict[str, float | None], Entry(unit="W h", key="energy")]:
        """Energy of the transit, of the trials that arrived."""
        energy = self.energy.summary().items()
        return {key: value if value is None else value / JOULES_PER_WATT_HOUR for key, value in energy}


LEAST_SHARE = 0.01
"""Share of what the fixed d_max takes that a table must save to be worth its complication."""
LEAST_ERRORS = 3.0
"""Standard errors of the saving that a table must save."""


@dataclass(frozen=True)
class LegKnot(Record):
    """A knot of a table of legs."""

    distance_left: Annotated[float, Entry("distance left", "m")]
    leg: Annotated[float, Entry("length of the leg", "m")]


@dataclass(frozen=True)
class FoundLegs(Record):
    """Legs for an aim: a table that adapts to the distance left, beside the best fixed d_max.

    Costs are c (Briggs et al., Eq. 25) at their speed with that spread, from the integral equation.
    """

    how_found: Annotated[str, Entry("how the table was found, in a sentence", key="machinery")]
    speed_factor: float
    """Speed of both over the mission's own."""
    planned_sigma: Annotated[float, Entry("of a leg's velocity, planned for", "m/s", "planned.sigma")]
    base_spread: Annotated[float, Entry("of a leg's end whatever its length, planned for", "m", "planned.base_spread")]
    left: Array
    leg: Array
    """Knots of the table: distance left and leg length, shape (k,) [m]."""
    expected_cost: Annotated[float, Entry("of the table, from the integral equation", key="adaptive.cost")]
    least_cost: Annotated[float, Entry("least expected cost of any legs", key="adaptive.least_cost")]
    expected_surfacings: Annotated[float, Entry("of the table, the arrival's included", key="adaptive.surfacings")]
    fixed_d_max: Annotated[float, Entry("best fixed d_max", "m", "fixed.d_max")]
    fixed_cost: Annotated[float, Entry("expected cost with that d_max", key="fixed.cost")]
    one_leg_cost: Annotated[float, Entry("expected cost of a single leg", key="one_leg.cost")]

    @property
    def table(self) -> LegTable:
        """The table."""
        return LegTable(self.left, self.leg)


@dataclass(frozen=True)
class LegPlan(FoundLegs, Result):
    """Legs that adapt to the distance left, beside the best fixed d_max.

    Attributes
    ----------
    arrival_radius, surfacing_time : float
        Of the transit, distributions at their means [m, s].
    """

    report: ClassVar[str] = "missionplan.studies.leg_length.plan_page"

    provenance: Provenance
    phase: Annotated[str, Entry("name of the transit")]
    phase_index: int
    """Place of the transit among the mission's phases."""
    aim: Annotated[
        str,
        Entry(
            "what the legs minimise: ``mean``, the expected time; ``p95``, the time that 95 % of the trials keep "
            "(or, with a deadline of the mission, the risk of missing it); ``energy``"
        ),
    ]
    deadline: Annotated[float, Entry("for the end of the transit, for ``p95``; null without one", "s")]
    distance: Annotated[float, Entry("length of the transit", "m")]
    mission_speed: float
    """The mission's own [m/s]."""
    arrival_radius: float
    required_arrival: Annotated[
        float, Entry("probability of arriving that legs must have to be recommended: the mission's requirement on it")
    ]
    surfacing_time: float
    sigma: Annotated[float, Entry("velocity error of the transit", "m/s")]
    goal: tuple[float, float]
    """Of the transit, east and north [m]."""
    cases: Annotated[tuple[LegCase, ...], Entry("the mission itself, then others for robustness")]
    candidates: Annotated[
        tuple[CandidatePlan, ...],
        Entry(
            "the best fixed d_max, the best legs for the mean time, and the table; empty for the aim ``mean``",
            key="contenders",
        ),
    ]
    fixed_tracks: Array
    adaptive_tracks: Array
    """The same few trials by both plans: the start, then where they surfaced and dived; nan after arrival, shape (2, m,
    j) [m]."""
    members: tuple[LegCase, ...] = ()
    """Both plans in each member of the current's ensemble; empty without one."""
    judged: Annotated[Outcome | None, JUDGED] = None

    @property
    def speed(self) -> Annotated[float, Entry(unit="m/s")]:
        """Speed of the transit; chosen for ``energy``."""
        return self.mission_speed * self.speed_factor

    @property
    def nominal_time(self) -> Annotated[float, Entry(unit="s")]:
        """t_nom = ‖x_f − x_0‖/U [s]."""
        return self.distance / self.speed

    @property
    def saving(self) -> Annotated[float, Entry(unit="s")]:
        """Expected time that the legs save against the best fixed d_max [s]."""
        return (self.fixed_cost - self.expected_cost) * self.nominal_time

    @property
    def integral_applies(self) -> bool:
        """Whether the integral equation covers all that the mission has, so that its costs are those of the trials."""
        return self.planned_sigma == self.sigma and self.base_spread == 0.0

    @property
    def recommended(self) -> bool:
        """Whether to take the table: it saves enough for certain, under every doubt, and arrives as often."""
        return self.adapts and self.saves_for_certain and self.saves_enough and self.keeps_arrivals and not self.losing

    @property
    def saves_for_certain(self) -> bool:
        """Whether the table saves more than three standard errors in the mission's own trials."""
        saving, error = self.cases[0].saving_for(self.aim)
        return saving > LEAST_ERRORS * error

    @property
    def saves_enough(self) -> bool:
        """Whether the table saves more than a hundredth of what the fixed d_max takes."""
        return self.cases[0].saving_for(self.aim)[0] > LEAST_SHARE * self.whole

    @property
    def keeps_arrivals(self) -> bool:
        """Whether the table arrives as often as required, or as the fixed d_max where that does not either."""
        case = self.cases[0]
        return case.adaptive.arrived.value >= min(self.required_arrival, case.fixed.arrived.value)

    @property
    def losing(self) -> tuple[LegCase, ...]:
        """The doubts under which the table does not save."""
        return tuple(case for case in self.cases[1:] if not case.saving_for(self.aim)[0] > 0.0)

    @property
    def whole(self) -> float:
        """What the best fixed d_max takes by the aim, of which the table saves a part [s, J, or 1 for a deadline]."""
        if self.aim == "energy" or (self.aim == "p95" and not np.isfinite(self.deadline)):
            return self.candidates[0].value
        return 1.0 if self.aim == "p95" else (1.0 + self.cases[0].fixed.cost) * self.nominal_time

    @property
    def chosen(self) -> SampledCost:
        """Trials of the plan that is recommended."""
        return self.cases[0].adaptive if self.recommended else self.cases[0].fixed

    @property
    def arrivals(self) -> Annotated[tuple[MemberOutcome, ...], Entry(key="members")]:
        """How often the plan that is recommended arrives in each member of the current's ensemble."""
        return tuple(
            MemberOutcome(
                case.name, case.probability or 0.0, (case.adaptive if self.recommended else case.fixed).arrived
            )
            for case in self.members
        )

    @property
    def reaches(self) -> Annotated[bool, Entry(key="reaches_required_arrival")]:
        """Whether the plan that is recommended arrives as often as required."""
        return self.chosen.arrived.value >= self.required_arrival

    @property
    def adapts(self) -> bool:
        """Whether the table is more than a fixed d_max."""
        return self.left.size > 1

    @property
    def d_max(self) -> dict[str, list[list[str]]] | str:
        """What is recommended as in a mission file: the table to 0.1 m, else the fixed d_max."""
        if not self.recommended:
            return f"{self.fixed_d_max:.1f} m"
        return {"table": [[f"{left:.1f} m", f"{leg:.1f} m"] for left, leg in zip(self.left, self.leg, strict=True)]}

    @property
    def changes(self) -> dict[str, object]:
        """Keys of the transit that the plan changes, as in a mission file."""
        speed = {"speed": f"{self.speed:.3f} m/s"} if self.speed != self.mission_speed else {}
        return {**speed, "d_max": self.d_max}

    @property
    def recommended_values(self) -> Mapping[str, object]:
        """The changed keys of the transit, by their paths; none where no legs arrive."""
        changes = self.changes if np.isfinite(self.chosen.cost) else {}
        return {f"{self.phase}.{key}": value for key, value in changes.items()}

    def mission_with_legs(self) -> dict[str, object]:
        """Return the mission's data with the transit as planned."""
        phases = self.provenance.data["phases"]
        if not isinstance(phases, list):
            raise TypeError("the mission's phases are not a list")
        planned = [
            {"transit": {**entry["transit"], **self.changes}} if index == self.phase_index else entry
            for index, entry in enumerate(phases)
        ]
        return {**self.provenance.data, "phases": planned}

    def to_frame(self) -> "pd.DataFrame":
        """One row per knot of the table where it is recommended; else one row, the fixed d_max."""
        from pandas import DataFrame

        return DataFrame(self._rows())

    def _rows(self) -> list[dict[str, float]]:
        if not self.recommended:
            return [{"distance_left_m": self.distance, "leg_m": self.fixed_d_max}]
        knots = zip(self.left.tolist(), self.leg.tolist(), strict=True)
        return [{"distance_left_m": left, "leg_m": leg, "aim_short_m": left - leg} for left, leg in knots]

    def files(self) -> dict[str, str | bytes]:
        """Return ``legs.csv``, and the mission with what is recommended: a table of legs, or one ``d_max``.

        The changed keys of the transit stand alone in ``legs.yaml`` or ``d_max.yaml``.
        """
        name = "legs" if self.recommended else "d_max"
        return {
            "legs.csv": to_csv(self._rows()),
            f"{name}.yaml": to_yaml(self.changes),
            f"mission-with-{name}.yaml": to_yaml(self.mission_with_legs()),
        }

    @property
    def choice(self) -> Annotated[str, Entry(key="recommended")]:
        """``adaptive`` or ``fixed``."""
        return "adaptive" if self.recommended else "fixed"

    @property
    def knots(self) -> Annotated[tuple[LegKnot, ...], Entry(key="adaptive.table")]:
        """Knots of the table."""
        return tuple(LegKnot(float(left), float(leg)) for left, leg in zip(self.left, self.leg, strict=True))
