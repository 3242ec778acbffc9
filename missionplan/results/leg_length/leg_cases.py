"""Costs of plans of legs on common trials: when errors are not as planned, and of each candidate plan."""

from dataclasses import dataclass

import numpy as np

from missionplan.montecarlo.statistics import Probability, Statistic
from missionplan.physics.energy import JOULES_PER_WATT_HOUR


@dataclass(frozen=True)
class SampledCost:
    """Cost of a plan in the mission's Monte Carlo.

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

    def summary(self) -> dict[str, object]:
        """Return the entry of ``summary.json``."""
        return {
            "cost": self.cost,
            "standard_error": self.standard_error,
            "surfacings": self.surfacings,
            "arrived": self.arrived.summary(),
        }


@dataclass(frozen=True)
class LegCase:
    """Both plans on the same trials: in the mission as it is, or with a navigation error that is not as planned.

    Attributes
    ----------
    name : str
        How the case differs from the mission; empty for the mission itself.
    sigma : float
        σ_v of the trials [m/s].
    mean_error, surface_drift : tuple of float
        Velocity under way and at the surface in addition to the mission's, east and north [m/s].
    fixed, adaptive : SampledCost
        With the best fixed d_max and with the table of legs.
    saving, saving_error : float
        Mean time that the table saves, and its standard error, paired trial by trial [s].
    energy_saving, energy_saving_error : float
        Mean energy that the table saves, likewise; nan where the mission has no energy budget [J].
    late_saving, late_saving_error : float
        For the aim ``p95`` alone: by how much sooner 95 % of all trials arrive, and its standard error [s]; where the
        mission has a deadline, by how much its probability is greater.
    probability : float or None
        Of the mission's explanation that the case takes to hold; None for other cases.
    """

    name: str
    sigma: float
    mean_error: tuple[float, float]
    surface_drift: tuple[float, float]
    fixed: SampledCost
    adaptive: SampledCost
    saving: float
    saving_error: float
    energy_saving: float
    energy_saving_error: float
    late_saving: float = float("nan")
    late_saving_error: float = float("nan")
    probability: float | None = None

    def saving_for(self, aim: str) -> tuple[float, float]:
        """Return what the table saves by an aim, and its standard error [J for energy, s, or a probability]."""
        if aim == "energy":
            return self.energy_saving, self.energy_saving_error
        if aim == "p95":
            return self.late_saving, self.late_saving_error
        return self.saving, self.saving_error

    def summary(self) -> dict[str, object]:
        """Return the entry of ``summary.json``."""
        late = np.isfinite(self.late_saving_error)
        return {
            "name": self.name or "as the mission",
            **({} if self.probability is None else {"explanation": self.probability}),
            "sigma_m_s": self.sigma,
            "mean_error_m_s": list(self.mean_error),
            "surface_drift_m_s": list(self.surface_drift),
            "fixed": self.fixed.summary(),
            "adaptive": self.adaptive.summary(),
            "saving_s": {"mean": self.saving, "standard_error": self.saving_error},
            "energy_saving_wh": {
                "mean": self.energy_saving / JOULES_PER_WATT_HOUR,
                "standard_error": self.energy_saving_error / JOULES_PER_WATT_HOUR,
            },
            **({"gain_p95": {"mean": self.late_saving, "standard_error": self.late_saving_error}} if late else {}),
        }


@dataclass(frozen=True)
class CandidatePlan:
    """A plan of legs judged by its aim, on trials other than those on which it was chosen.

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
        What the aim minimises [s, or J]; for a deadline the probability of meeting it, which is maximised.
    """

    name: str
    speed: float
    duration: Statistic
    energy: Statistic
    on_time: Probability
    value: float
    standard_error: float

    def summary(self) -> dict[str, object]:
        """Return the entry of ``summary.json``."""
        energy = self.energy.summary().items()
        return {
            "name": self.name,
            "speed_m_s": self.speed,
            "duration_s": self.duration.summary(),
            "energy_wh": {key: value if value is None else value / JOULES_PER_WATT_HOUR for key, value in energy},
            "on_time": self.on_time.summary(),
        }
