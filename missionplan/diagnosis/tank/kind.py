"""Tank data as a kind of data."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Self

import pandas as pd

from missionplan.datasets.tank import TANK_FORMATS, TankData
from missionplan.diagnosis.data_kind import DataKind
from missionplan.diagnosis.given.effects import GivenEffect
from missionplan.diagnosis.inference.model import CauseFit
from missionplan.diagnosis.learned_data import unlearned
from missionplan.diagnosis.plan_gain import anchor_choice, plan_gain
from missionplan.diagnosis.tank.data import read_tank
from missionplan.diagnosis.tank.extended_mission import extended_tank_mission, vehicle_keys
from missionplan.diagnosis.tank.given import given_in_tank
from missionplan.diagnosis.tank.model import TankModel
from missionplan.diagnosis.tank.model_factory import tank_forward
from missionplan.diagnosis.tank.tables import tank_misfit, tank_residuals, tank_share
from missionplan.effects import exclusive_groups
from missionplan.mission import Mission
from missionplan.results.learned.diagnosis import PlanGain


@dataclass(frozen=True)
class TankKind(DataKind):
    """Drag, free oscillations, thrusters and propeller transients."""

    ids = tuple(TANK_FORMATS)

    kind: str
    mission: Mission
    data: TankData
    model: TankModel

    @classmethod
    def bind(cls, kind: str, folder: Path, mission: Mission, seed: int) -> Self:
        """Read the data and bind the base model of their kind to them."""
        data = unlearned(read_tank(folder), mission)
        forward = tank_forward(data, mission)
        given = given_in_tank(data, mission, forward.candidates)
        return cls(kind, mission, data, TankModel(forward, given=given, alternatives=exclusive_groups("tank")))

    @property
    def given(self) -> tuple[GivenEffect, ...]:
        """The mission's own effects that the data could show."""
        return self.model.given

    def residual_table(self, base: CauseFit, best: CauseFit) -> pd.DataFrame:
        """Return one row a datum."""
        return tank_residuals(self.model, best)

    def misfit(self, residuals: pd.DataFrame) -> str:
        """Describe the root mean square of the residuals beside the sensor's noise."""
        return tank_misfit(self.model, residuals)

    def shares_explained(self, base: CauseFit, fits: Sequence[CauseFit], residuals: pd.DataFrame) -> list[float]:
        """Return the share of the squared residuals that goes with each fit."""
        return [tank_share(residuals, fit) for fit in fits]

    def extended_mission(self, best: CauseFit) -> dict[str, object]:
        """Write the causes into the vehicle where it has keys for them, else as effects."""
        return extended_tank_mission(self.mission, best, self.data)

    def carried(self, best: CauseFit, scale: float) -> CauseFit:
        """Return a fit without the causes that keys of the vehicle state."""
        return replace(best, posterior=best.posterior.without(vehicle_keys(self.mission, best)))

    def plan_gain(self, base: Mission, extended: Mapping[str, object], *, seed: int, jobs: int) -> PlanGain:
        """Compare the anchors chosen, where the mission has a mooring and an anchor."""
        vehicle = self.mission.vehicle
        if not (self.mission.moors and vehicle and vehicle.anchor):
            return PlanGain(reason="no mooring's anchor, whose choice the tank's data could change")
        return plan_gain(anchor_choice, base, extended, seed=seed, jobs=jobs)
