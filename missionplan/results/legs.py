"""The answer of a plan of legs: how long a leg should be at each distance left, and what that saves."""

from copy import deepcopy
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import pandas as pd

from missionplan.arrays import Array
from missionplan.montecarlo.statistics import Probability, Statistic
from missionplan.physics.energy import JOULES_PER_WATT_HOUR
from missionplan.results.base import Provenance, Result, to_csv, to_yaml


@dataclass(frozen=True)
class SampledCost:
    """What a plan costs in the mission's Monte Carlo.

    Attributes
    ----------
    cost, standard_error : float
        Mean of c (Briggs et al., Eq. 25) of the trials that arrived by both plans.
    surfacings : float
        Mean number, the arrival's included.
    arrived : Probability
    """

    cost: float
    standard_error: float
    surfacings: float
    arrived: Probability


@dataclass(frozen=True)
class LegCase:
    """Both plans on the same trials, in the mission as it is or with a navigation error that is not as planned.

    Attributes
    ----------
    name : str
        In what the case differs from the mission; empty for the mission itself.
    sigma : float
        σ_v of the trials [m/s].
    mean_error : tuple of float
        v̄ of the trials beyond the mission's, east and north [m/s].
    fixed, adaptive : SampledCost
        With the best fixed d_max and with the table of legs.
    saving, saving_error : float
        Mean time that the table saves, and its standard error, paired trial by trial [s].
    energy_saving, energy_saving_error : float
        Mean energy that it saves, likewise; nan where the mission has no energy budget [J].
    """

    name: str
    sigma: float
    mean_error: tuple[float, float]
    fixed: SampledCost
    adaptive: SampledCost
    saving: float
    saving_error: float
    energy_saving: float
    energy_saving_error: float

    def saving_for(self, aim: str) -> tuple[float, float]:
        """Give what the table saves, with its standard error: energy for the aim ``energy`` [J], else time [s]."""
        if aim == "energy":
            return self.energy_saving, self.energy_saving_error
        return self.saving, self.saving_error


@dataclass(frozen=True)
class CandidatePlan:
    """A plan of legs judged by what the legs are chosen for, on trials other than those that it was chosen on.

    Attributes
    ----------
    name : str
    speed : float
        [m/s]
    duration : Statistic
        Of the transit, of the trials that arrived, the arrival's surfacing included [s].
    energy : Statistic
        [J]
    on_time : Probability
        Of arriving by the deadline; of arriving where there is none.
    value, standard_error : float
        What the aim makes least [s, or J]; for a deadline the probability of meeting it, which it makes greatest.
    """

    name: str
    speed: float
    duration: Statistic
    energy: Statistic
    on_time: Probability
    value: float
    standard_error: float


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
        What the legs are best for: ``mean``, the expected time; ``p95``, the time that 95 % of the trials keep, or a
        deadline of the mission; ``energy``.
    how_found : str
        How the table was found, in a sentence.
    deadline : float
        By which the transit is to be done, for ``p95``; infinite without one [s].
    distance, speed, arrival_radius, surfacing_time, sigma : float
        Of the transit, distributions at their means; the speed is chosen for ``energy`` [m, m/s, m, s, m/s].
    mission_speed : float
        The mission's own [m/s].
    planned_sigma, base_spread : float
        Spread of legs that the table reckons with: of the velocity, and of any leg [m/s, m].
    goal : tuple of float
        Where the transit goes [m].
    left, leg : array, shape (k,)
        Knots of the table: distance left and leg length [m].
    expected_cost : float
        Of the table, from the integral equation.
    least_cost : float
        Of any legs.
    expected_surfacings : float
        Of the table, the arrival's included.
    fixed_d_max : float
        Best fixed d_max [m].
    fixed_cost, one_leg_cost : float
        Expected cost of that, and of a single leg.
    cases : tuple of LegCase
        The mission itself, then others for robustness.
    candidates : tuple of CandidatePlan
        The best fixed d_max, the best legs for the mean time, and the table; empty for the aim ``mean``.
    fixed_tracks, adaptive_tracks : array, shape (2, m, j)
        Tracks of the same few trials by both plans: the start, where they surfaced and dived; nan after arrival [m].
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
        """Whether the integral equation knows all that the mission has, so that its costs are the trials'."""
        return self.planned_sigma == self.sigma and self.base_spread == 0.0

    @property
    def recommended(self) -> bool:
        """Whether the table does better in the mission's own trials, by more than two standard errors."""
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
        """The table as a mission file writes it, to 0.1 m; a length where it does not adapt."""
        if not self.adapts:
            return f"{self.leg[0]:.1f} m"
        return {"table": [[f"{left:.1f} m", f"{leg:.1f} m"] for left, leg in zip(self.left, self.leg, strict=True)]}

    @property
    def changes(self) -> dict[str, Any]:
        """What the plan changes of the transit, as a mission file writes it."""
        speed = {"speed": f"{self.speed:.3f} m/s"} if self.speed != self.mission_speed else {}
        return {**speed, "d_max": self.d_max}

    def mission_with_legs(self) -> dict[str, Any]:
        """Give the mission's data with the transit as planned."""
        data = deepcopy(dict(self.provenance.data))
        data["phases"][self.phase_index]["transit"].update(self.changes)
        return data

    def to_frame(self) -> pd.DataFrame:
        """One row a knot."""
        return pd.DataFrame({"distance_left_m": self.left, "leg_m": self.leg, "aim_short_m": self.left - self.leg})

    def files(self) -> dict[str, str | bytes]:
        """Give ``legs.csv``, ``legs.yaml`` (what changes of the transit) and ``mission-with-legs.yaml``."""
        return {
            "legs.csv": to_csv(self.to_frame()),
            "legs.yaml": to_yaml(self.changes),
            "mission-with-legs.yaml": to_yaml(self.mission_with_legs()),
        }

    def summary(self) -> dict[str, Any]:
        """Give the dictionary of ``summary.json``."""
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
                "table": [
                    {"distance_left_m": float(left), "leg_m": float(leg)}
                    for left, leg in zip(self.left, self.leg, strict=True)
                ],
            },
            "saving_s": self.saving,
            "recommended": "adaptive" if self.recommended else "fixed",
            "cases": [_case_summary(case) for case in self.cases],
            "contenders": [_candidate_summary(candidate) for candidate in self.candidates],
        }


def _candidate_summary(candidate: CandidatePlan) -> dict[str, Any]:
    return {
        "name": candidate.name,
        "speed_m_s": candidate.speed,
        "duration_s": candidate.duration.summary(),
        "energy_wh": {
            key: value if value is None else value / JOULES_PER_WATT_HOUR
            for key, value in candidate.energy.summary().items()
        },
        "on_time": candidate.on_time.summary(),
    }


def _case_summary(case: LegCase) -> dict[str, Any]:
    return {
        "name": case.name or "as the mission",
        "sigma_m_s": case.sigma,
        "mean_error_m_s": list(case.mean_error),
        "fixed": _cost_summary(case.fixed),
        "adaptive": _cost_summary(case.adaptive),
        "saving_s": {"mean": case.saving, "standard_error": case.saving_error},
        "energy_saving_wh": {
            "mean": case.energy_saving / JOULES_PER_WATT_HOUR,
            "standard_error": case.energy_saving_error / JOULES_PER_WATT_HOUR,
        },
    }


def _cost_summary(sampled: SampledCost) -> dict[str, Any]:
    return {
        "cost": sampled.cost,
        "standard_error": sampled.standard_error,
        "surfacings": sampled.surfacings,
        "arrived": sampled.arrived.summary(),
    }
