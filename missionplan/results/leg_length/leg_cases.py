"""Costs of plans of legs on common trials: when errors are not as planned, and of each candidate plan."""

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from missionplan.montecarlo.statistics import Probability, Statistic
from missionplan.physics.energy import JOULES_PER_WATT_HOUR
from missionplan.results.entries import Entry, Record


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


@dataclass(frozen=True)
class LegCase(Record):
    """Both plans on the same trials: in the mission as it is, or with a navigation error that is not as planned.

    Attributes
    ----------
    name : str
        How the case differs from the mission; empty for the mission itself.
    saving, saving_error : float
        Mean time that the table saves, and its standard error, paired trial by trial [s].
    energy_saving, energy_saving_error : float
        Mean energy that the table saves, likewise; nan where the mission has no energy budget [J].
    late_saving, late_saving_error : float
        For the aim ``p95`` alone: by how much sooner 95 % of all trials arrive, and its standard error [s]; where the
        mission has a deadline, by how much its probability is greater.
    """

    name: str
    sigma: Annotated[float, Entry("σ_v of the trials", "m/s")]
    mean_error: Annotated[
        tuple[float, float], Entry("velocity under way in addition to the mission's, east and north", "m/s")
    ]
    surface_drift: Annotated[
        tuple[float, float], Entry("velocity at the surface in addition to the mission's, east and north", "m/s")
    ]
    fixed: Annotated[SampledCost, Entry("with the best fixed d_max")]
    adaptive: Annotated[SampledCost, Entry("with the table of legs")]
    saving: float
    saving_error: float
    energy_saving: float
    energy_saving_error: float
    late_saving: float = float("nan")
    late_saving_error: float = float("nan")
    probability: Annotated[
        float | None,
        Entry("of the explanation that the case takes to hold", key="explanation", optional=True),
    ] = None

    @property
    def title(self) -> Annotated[str, Entry(key="name")]:
        """How the case differs from the mission."""
        return self.name or "as the mission"

    @property
    def saved_time(self) -> Annotated[MeanAndError, Entry(unit="s", key="saving")]:
        """Mean time that the table saves, paired trial by trial."""
        return MeanAndError(self.saving, self.saving_error)

    @property
    def saved_energy(self) -> Annotated[MeanAndError, Entry(unit="W h", key="energy_saving")]:
        """Mean energy that the table saves; null where the mission has no energy budget."""
        return MeanAndError(self.energy_saving / JOULES_PER_WATT_HOUR, self.energy_saving_error / JOULES_PER_WATT_HOUR)

    @property
    def gain_p95(self) -> Annotated[MeanAndError | None, Entry(optional=True)]:
        """By how much sooner 95 % of all trials arrive [s], or how much likelier in time, for the aim ``p95``."""
        late = np.isfinite(self.late_saving_error)
        return MeanAndError(self.late_saving, self.late_saving_error) if late else None

    def saving_for(self, aim: str) -> tuple[float, float]:
        """Return what the table saves by an aim, and its standard error [J for energy, s, or a probability]."""
        if aim == "energy":
            return self.energy_saving, self.energy_saving_error
        if aim == "p95":
            return self.late_saving, self.late_saving_error
        return self.saving, self.saving_error


@dataclass(frozen=True)
class CandidatePlan(Record):
    """A plan of legs judged by its aim, on trials other than those on which it was chosen.

    Attributes
    ----------
    energy : Statistic
        [J]
    value, standard_error : float
        What the aim minimises [s, or J]; for a deadline the probability of meeting it, which is maximised.
    """

    name: Annotated[str, Entry("of the plan")]
    speed: Annotated[float, Entry("through the water", "m/s")]
    duration: Annotated[
        Statistic, Entry("of the transit, of the trials that arrived, the arrival's surfacing included", "s")
    ]
    energy: Statistic
    on_time: Annotated[Probability, Entry("of arriving by the deadline; of arriving where there is none")]
    value: float
    standard_error: float

    @property
    def energy_in_wh(self) -> Annotated[dict[str, float | None], Entry(unit="W h", key="energy")]:
        """Energy of the transit, of the trials that arrived."""
        energy = self.energy.summary().items()
        return {key: value if value is None else value / JOULES_PER_WATT_HOUR for key, value in energy}
