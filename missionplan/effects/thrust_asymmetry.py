"""A thruster with different thrust ahead and astern."""

from dataclasses import dataclass

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.effects.finding import Finding
from missionplan.effects.info import EffectInfo, Parameter, TankEffect, TankRecord


@dataclass(frozen=True)
class ThrustAsymmetry(TankEffect):
    """Thrust for negative commands times 1 - `fraction`."""

    fraction: Scalars = 0.0

    def thrust_factor(self, command: Array, jet_ratio: Array) -> Array | float:
        """Return the factor on the static force."""
        return np.where(command < 0.0, 1.0 - np.asarray(self.fraction), 1.0)


def _lacking_in_tank(record: TankRecord) -> str:
    return "" if record.has_both_signs else "the commands have one sign"


INFO = EffectInfo(
    id="thrust-asymmetry",
    phase="tank",
    tier="physical",
    effect=ThrustAsymmetry,
    parameters={
        "fraction": Parameter(
            "", "share of the thrust ahead that is missing astern", -2.0, 0.95, scale=0.25, spike=0.01
        )
    },
    what="Blades, nozzle and hub are designed for one direction: the same command gives a different thrust astern.",
    finding=Finding(
        "fraction",
        "astern, {size} of the thrust ahead is missing",
        "astern, the thrust is {size} greater than ahead",
        remedy="enter the thrust astern in the vehicle file",
        in_percent=True,
    ),
    sizes="0 to 40 % less astern; a third for the thruster of Avila et al.",
    confused_with=("jet-suction",),
    distinguished_by="Bollard pull with the same commands ahead and astern.",
    changes_plan=False,
    tank=("thruster",),
    lacking_in_tank=_lacking_in_tank,
)
