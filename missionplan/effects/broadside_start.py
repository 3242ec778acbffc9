"""Broadside drag at the start of the pull-down, until the vehicle has pitched nose down."""

from dataclasses import dataclass

import numpy as np

from missionplan.arrays import Scalars
from missionplan.effects.finding import Finding
from missionplan.effects.info import EffectInfo, Parameter
from missionplan.phases.hooks import DescentEffect


@dataclass(frozen=True)
class BroadsideStart(DescentEffect):
    """Both bodies' drag times ``1 + extra_drag·exp(−t/time)``, t since the line is taut."""

    extra_drag: Scalars = 0.0
    time: Scalars = 1.5

    def drag_factor(self, since_taut: Scalars, speed: Scalars) -> Scalars:
        """Return the factor on both bodies' drag."""
        return 1.0 + self.extra_drag * np.exp(-np.maximum(since_taut, 0.0) / self.time)


INFO = EffectInfo(
    id="broadside-start",
    phase="descent",
    tier="physical",
    effect=BroadsideStart,
    parameters={
        "extra_drag": Parameter(
            "", "extra drag when the line goes taut, as a factor", 0.0, 60.0, scale=4.0, spike=0.05
        ),
        "time": Parameter("s", "time constant of the pitching", 0.1, 8.0, median=2.0, factor=1.9, default=1.5),
    },
    what="The line pulls a level vehicle down: until it pitches nose down, the water meets its side and not its nose.",
    finding=Finding(
        "extra_drag",
        "while the line goes taut the vehicle lies across its way, with {size} more drag",
        remedy="give the line more room to pay out before it goes taut, or plan with the longer dive",
        in_percent=True,
    ),
    sizes=(
        "The cross-flow drag of a slender hull is 10 to 30 times its axial drag; it pitches nose down in 1 to 5 s. A "
        "hull that takes longer has sunk by several lengths meanwhile, and is not about to pitch down."
    ),
    confused_with=("added-mass", "slow-flooding"),
    distinguished_by="Pitch in the log; a dive released nose down; anchors of different weight.",
)
