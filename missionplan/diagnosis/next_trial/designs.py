"""What a trial is to the valuation, whatever is tried: a design with its mission, and its cost by the planner."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from missionplan.diagnosis.data_kind import DataKind
from missionplan.diagnosis.inference.model import CauseFit
from missionplan.diagnosis.next_trial.belief import Believed, Posterior
from missionplan.diagnosis.next_trial.losses import Alternatives
from missionplan.diagnosis.next_trial.prediction import Prediction
from missionplan.errors import MissionplanError
from missionplan.mission import Mission
from missionplan.scenario.scenario import Scenario
from missionplan.scenario.site_current import recorded_current
from missionplan.studies.simulation.trial_block import run_block

COSTING_TRIALS = 16
"""Runs of a trial's mission of which its cost is the mean."""


@dataclass(frozen=True)
class Cost:
    """Time [min], and energy [W h] where it is known."""

    minutes: float
    energy_wh: float | None


class TrialKind(ABC):
    """Trials that can be made from one kind of data: designs, what they would show, what they decide."""

    @property
    @abstractmethod
    def designs(self) -> Sequence[str]:
        """Designs in words."""

    @abstractmethod
    def posterior(self, bound: DataKind, fit: CauseFit) -> Posterior:
        """Return what a fit of the data, bound to a mission, says of its parameters."""

    @abstractmethod
    def predictions(self, design: int, believed: Sequence[Believed]) -> list[Prediction]:
        """Return the data of a design as each set of causes predicts them."""

    @abstractmethod
    def trial(self, design: int) -> Mapping[str, object]:
        """Return the mission file's data of a design."""

    def cost(self, design: int, seed: int) -> "Cost | None":
        """Return what a design takes by the planner's model; None where it cannot be made."""
        return cost_of(self.trial(design), seed)

    @abstractmethod
    def alternatives(self) -> Alternatives:
        """Return what the planner may choose."""


def cost_of(trial: Mapping[str, object], seed: int) -> Cost | None:
    """Time and energy of a trial's mission, the mean of a few runs of it; None where it cannot be made.

    Parameters
    ----------
    trial : mapping
        Mission file's data.
    seed : int
        Of the runs.
    """
    try:
        mission = Mission.from_data(trial)
        means = Scenario.at_means(mission, recorded_current(mission))
        found = run_block(means.sampled(seed=seed, block=0, size=COSTING_TRIALS), seed, 0, COSTING_TRIALS, inputs=False)
    except (MissionplanError, FloatingPointError):
        return None
    duration, energy = (found.total[key] for key in ("duration_s", "energy_wh"))
    ended = np.isfinite(duration)
    if np.count_nonzero(ended) < 0.5 * COSTING_TRIALS:
        return None
    known = np.isfinite(energy[ended]).all()
    return Cost(float(duration[ended].mean()) / 60.0, float(energy[ended].mean()) if known else None)
