"""Result of `plan-legs`: how long a leg should be at each distance left, and what that saves."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pandas as pd

from missionplan.arrays import Array
from missionplan.results.base import Provenance, Result, to_csv, to_yaml
from missionplan.results.leg_length.leg_cases import CandidatePlan, LegCase, SampledCost
from missionplan.results.members import MemberOutcome

LEAST_SHARE = 0.01
"""Share of what the fixed d_max takes that a table must save to be worth its complication."""
LEAST_ERRORS = 3.0
"""Standard errors of the saving that a table must save."""


@dataclass(frozen=True)
class LegPlan(Result):
    """Legs that adapt to the distance left, beside the best fixed d_max.

    Attributes
    ----------
    provenance : Provenance
    phase : str
        Name of the transit.
    phase_index : int
        Its place among the mission's phases.
    aim : str
        What the legs minimise: ``mean``, the expected time; ``p95``, the time that 95 % of the trials keep (or, with
        a deadline of the mission, the risk of missing it); ``energy``.
    how_found : str
        How the table was found, in a sentence.
    deadline : float
        For the end of the transit, for ``p95``; infinite without one [s].
    required_arrival : float
        Probability of arriving that legs must have to be recommended: the mission's requirement on it.
    distance, speed, arrival_radius, surfacing_time, sigma : float
        Of the transit, distributions at their means; the speed is chosen for ``energy`` [m, m/s, m, s, m/s].
    mission_speed : float
        The mission's own [m/s].
    planned_sigma, base_spread : float
        Spread that the table is planned for: of a leg's velocity, and of a leg's end whatever its length [m/s, m].
    goal : tuple of float
        Of the transit, east and north [m].
    left, leg : array, shape (k,)
        Knots of the table: distance left and leg length [m].
    expected_cost : float
        Of the table, from the integral equation.
    least_cost : float
        Least expected cost of any legs.
    expected_surfacings : float
        Of the table, the arrival's included.
    fixed_d_max : float
        Best fixed d_max [m].
    fixed_cost, one_leg_cost : float
        Expected cost with that d_max, and of a single leg.
    cases : tuple of LegCase
        The mission itself, then others for robustness.
    candidates : tuple of CandidatePlan
        The best fixed d_max, the best legs for the mean time, and the table; empty for the aim ``mean``.
    fixed_tracks, adaptive_tracks : array, shape (2, m, j)
        The same few trials by both plans: the start, then where they surfaced and dived; nan after arrival [m].
    members : tuple of LegCase
        Both plans in each member of the current's ensemble; empty without one.
    """

    report: ClassVar[str] = "missionplan.report.leg_length.plan"

    provenance: Provenance
    phase: str
    phase_index: int
    aim: str
    how_found: str
    deadline: float
    distance: float
    speed: float
    mission_speed: float
    arrival_radius: float
    required_arrival: float
    surfacing_time: float
    sigma: float
    planned_sigma: float
    base_spread: float
    goal: tuple[float, float]
    left: Array
    leg: Array
    expected_cost: float
    least_cost: float
    expected_surfacings: float
    fixed_d_max: float
    fixed_cost: float
    one_leg_cost: float
    cases: tuple[LegCase, ...]
    candidates: tuple[CandidatePlan, ...]
    fixed_tracks: Array
    adaptive_tracks: Array
    members: tuple[LegCase, ...] = ()

    @property
    def nominal_time(self) -> float:
        """t_nom = ‖x_f − x_0‖/U [s]."""
        return self.distance / self.speed

    @property
    def saving(self) -> float:
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
        own = self.cases[0]
        return own.adaptive.arrived.value >= min(self.required_arrival, own.fixed.arrived.value)

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
    def arrivals(self) -> tuple[MemberOutcome, ...]:
        """How often the plan that is recommended arrives in each member of the current's ensemble."""
        return tuple(
            MemberOutcome(
                case.name, case.probability or 0.0, (case.adaptive if self.recommended else case.fixed).arrived
            )
            for case in self.members
        )

    @property
    def reaches(self) -> bool:
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

    def to_frame(self) -> pd.DataFrame:
        """One row per knot of the table where it is recommended; else one row, the fixed d_max."""
        if not self.recommended:
            return pd.DataFrame({"distance_left_m": [self.distance], "leg_m": [self.fixed_d_max]})
        return pd.DataFrame({"distance_left_m": self.left, "leg_m": self.leg, "aim_short_m": self.left - self.leg})

    def files(self) -> dict[str, str | bytes]:
        """Return ``legs.csv``, ``legs.yaml`` (the changed keys of the transit) and ``mission-with-legs.yaml``."""
        return {
            "legs.csv": to_csv(self.to_frame()),
            "legs.yaml": to_yaml(self.changes),
            "mission-with-legs.yaml": to_yaml(self.mission_with_legs()),
        }

    def summary(self) -> dict[str, object]:
        """Return the contents of ``summary.json``."""
        return {
            **self.provenance.summary(),
            "aim": self.aim,
            "machinery": self.how_found,
            "deadline_s": self.deadline,
            "phase": self.phase,
            "distance_m": self.distance,
            "nominal_time_s": self.nominal_time,
            "speed_m_s": self.speed,
            "sigma_m_s": self.sigma,
            "planned": {"sigma_m_s": self.planned_sigma, "base_spread_m": self.base_spread},
            "fixed": {"d_max_m": self.fixed_d_max, "cost": self.fixed_cost},
            "one_leg": {"cost": self.one_leg_cost},
            "adaptive": {
                "cost": self.expected_cost,
                "least_cost": self.least_cost,
                "surfacings": self.expected_surfacings,
                "table": self._knots(),
            },
            "saving_s": self.saving,
            "recommended": "adaptive" if self.recommended else "fixed",
            "required_arrival": self.required_arrival,
            "reaches_required_arrival": self.reaches,
            "cases": [case.summary() for case in self.cases],
            "members": [each.summary() for each in self.arrivals],
            "contenders": [candidate.summary() for candidate in self.candidates],
        }

    def _knots(self) -> list[dict[str, float]]:
        return [
            {"distance_left_m": float(left), "leg_m": float(leg)} for left, leg in zip(self.left, self.leg, strict=True)
        ]
