"""The answer of a plan of legs: how long a leg should be at each distance left, and what that saves."""

from copy import deepcopy
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from missionplan.montecarlo.statistics import Probability
from missionplan.results.base import Provenance, Result, to_csv, to_yaml

Array = NDArray[np.float64]


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
    """

    name: str
    sigma: float
    mean_error: tuple[float, float]
    fixed: SampledCost
    adaptive: SampledCost
    saving: float
    saving_error: float


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
        What the legs are best for: ``mean``, the expected time.
    distance, speed, arrival_radius, surfacing_time, sigma : float
        Of the transit, distributions at their means [m, m/s, m, s, m/s].
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
    fixed_tracks, adaptive_tracks : array, shape (2, m, j)
        Tracks of the same few trials by both plans: the start, where they surfaced and dived; nan after arrival [m].
    """

    report: ClassVar[str] = "legs"

    provenance: Provenance
    phase: str
    phase_index: int
    aim: str
    distance: float
    speed: float
    arrival_radius: float
    surfacing_time: float
    sigma: float
    left: Array
    leg: Array
    expected_cost: float
    least_cost: float
    expected_surfacings: float
    fixed_d_max: float
    fixed_cost: float
    one_leg_cost: float
    cases: tuple[LegCase, ...]
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
    def recommended(self) -> bool:
        """Whether the table saves time in the mission's own trials, by more than two standard errors."""
        return self.cases[0].saving > 2.0 * self.cases[0].saving_error

    @property
    def d_max(self) -> dict[str, list[list[str]]]:
        """The table as a mission file writes it, to 0.1 m."""
        return {"table": [[f"{left:.1f} m", f"{leg:.1f} m"] for left, leg in zip(self.left, self.leg, strict=True)]}

    def mission_with_legs(self) -> dict[str, Any]:
        """Give the mission's data with the table as the transit's d_max."""
        data = deepcopy(dict(self.provenance.data))
        data["phases"][self.phase_index]["transit"]["d_max"] = self.d_max
        return data

    def to_frame(self) -> pd.DataFrame:
        """One row a knot."""
        return pd.DataFrame({"distance_left_m": self.left, "leg_m": self.leg, "aim_short_m": self.left - self.leg})

    def files(self) -> dict[str, str | bytes]:
        """Give ``legs.csv``, ``legs.yaml`` (the transit's d_max) and ``mission-with-legs.yaml``."""
        return {
            "legs.csv": to_csv(self.to_frame()),
            "legs.yaml": to_yaml({"d_max": self.d_max}),
            "mission-with-legs.yaml": to_yaml(self.mission_with_legs()),
        }

    def summary(self) -> dict[str, Any]:
        """Give the dictionary of ``summary.json``."""
        return {
            **self.provenance.summary(),
            "aim": self.aim,
            "phase": self.phase,
            "distance_m": self.distance,
            "nominal_time_s": self.nominal_time,
            "sigma_m_s": self.sigma,
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
        }


def _case_summary(case: LegCase) -> dict[str, Any]:
    return {
        "name": case.name or "as the mission",
        "sigma_m_s": case.sigma,
        "mean_error_m_s": list(case.mean_error),
        "fixed": _cost_summary(case.fixed),
        "adaptive": _cost_summary(case.adaptive),
        "saving_s": {"mean": case.saving, "standard_error": case.saving_error},
    }


def _cost_summary(sampled: SampledCost) -> dict[str, Any]:
    return {
        "cost": sampled.cost,
        "standard_error": sampled.standard_error,
        "surfacings": sampled.surfacings,
        "arrived": sampled.arrived.summary(),
    }
