"""Result of `plan-legs`: how long a leg should be at each distance left, and what that saves."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pandas as pd

from missionplan.arrays import Array
from missionplan.results.base import Provenance, Result, to_csv, to_yaml
from missionplan.results.leg_cases import CandidatePlan, LegCase


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
    """

    report: ClassVar[str] = "leg_length.plan"

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
        """Whether the table does better in the mission's own trials by more than two standard errors."""
        if self.aim == "p95":
            fixed, *_, table = self.candidates
            gain = table.value - fixed.value if np.isfinite(self.deadline) else fixed.value - table.value
            return gain > 2.0 * float(np.hypot(fixed.standard_error, table.standard_error))
        saving, error = self.cases[0].saving_for(self.aim)
        return saving > 2.0 * error

    @property
    def adapts(self) -> bool:
        """Whether the table is more than a fixed d_max."""
        return self.left.size > 1

    @property
    def d_max(self) -> dict[str, list[list[str]]] | str:
        """The table as in a mission file, to 0.1 m; a single length where it does not adapt."""
        if not self.adapts:
            return f"{self.leg[0]:.1f} m"
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
        """One row per knot of the table."""
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
            "cases": [case.summary() for case in self.cases],
            "contenders": [candidate.summary() for candidate in self.candidates],
        }

    def _knots(self) -> list[dict[str, float]]:
        return [
            {"distance_left_m": float(left), "leg_m": float(leg)} for left, leg in zip(self.left, self.leg, strict=True)
        ]
