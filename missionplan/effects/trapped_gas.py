"""A gas bubble in the vehicle, which is compressed with depth."""

from dataclasses import dataclass

import numpy as np

from missionplan.arrays import Scalars
from missionplan.effects.finding import Finding
from missionplan.effects.info import EffectInfo, Parameter
from missionplan.phases.hooks import DescentEffect

ATMOSPHERE = 10.1
"""Depth of water that adds one atmosphere of pressure [m]; 10.07 m in sea water, 10.33 m in fresh."""


@dataclass(frozen=True)
class TrappedGas(DescentEffect):
    """Upward force `lift_at_surface` [N], halved at about 10 m by Boyle's law (isothermal).

    The gas sits `height` [m] above the nose, whose depth is the vehicle's, where the hull hangs nose down.
    """

    lift_at_surface: Scalars = 0.0
    height: Scalars = 0.0

    def lift(self, depth: Scalars) -> Scalars:
        """Return the upward force at a depth of the nose [N]."""
        return self.lift_at_surface / (1.0 + np.maximum(depth - self.height, 0.0) / ATMOSPHERE)


INFO = EffectInfo(
    id="trapped-gas",
    phase="descent",
    tier="physical",
    effect=TrappedGas,
    parameters={
        "lift": Parameter(
            "N", "upward force of the bubble at the surface", 0.0, 20.0, scale=1.5, spike=0.02, field="lift_at_surface"
        ),
        "height": Parameter(
            "m", "height of the gas above the nose, when the vehicle hangs nose down", 0.0, 10.0, median=0.4, factor=2.0
        ),
    },
    what=(
        "Air under fairings or in the sail buoys the vehicle up and is compressed with depth: the descent accelerates."
    ),
    finding=Finding(
        "lift",
        "gas trapped in the vehicle lifts it by {size} at the surface",
        remedy="vent it before the dive, with the nose down",
    ),
    follows_law=True,
    sizes="0.1 to 0.4 L of air, 1 to 4 N; always upward.",
    confused_with=("stratification", "drag-bias", "slow-flooding"),
    distinguished_by=(
        "A dive twice as deep, or with the vehicle purged by hand; lighter anchors, with which a lift matters more."
    ),
)
