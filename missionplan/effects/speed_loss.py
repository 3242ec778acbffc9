"""Speed that is lost above a threshold."""

from dataclasses import dataclass

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.effects.finding import Finding
from missionplan.effects.info import EffectInfo, LegRecord, Parameter, Term
from missionplan.phases.hooks import Leg, TransitEffect


@dataclass(frozen=True)
class SpeedLoss(TransitEffect):
    """Of the speed beyond `threshold` [m/s] the part `fraction` is lost."""

    fraction: Scalars = 0.0
    threshold: Scalars = 0.0

    def velocity(self, leg: Leg) -> Array:
        """Return the velocity error of each leg, shape (2, n) [m/s]: backwards along its course."""
        return np.asarray(-self.fraction * np.maximum(leg.speed - self.threshold, 0.0) * leg.along)


def _needs_speeds(record: LegRecord) -> str:
    return "" if record.speeds > 0.1 else "needs legs at different speeds: at one speed it is a speed scale"


INFO = EffectInfo(
    id="speed-loss",
    phase="transit",
    tier="physical",
    effect=SpeedLoss,
    parameters={
        "fraction": Parameter(
            "", "part of the speed beyond the threshold that is lost", 0.0, 1.2, scale=0.5, spike=0.002
        ),
        "threshold": Parameter("m/s", "speed from which it is", 0.0, 20.0, median=1.2, factor=1.5, searched="speed"),
    },
    what="A motor or battery at its limit, cavitation, air drawn in: beyond some speed the vehicle gets no faster.",
    finding=Finding(
        "fraction",
        "of the speed beyond {at} the vehicle loses {size}",
        "of the speed beyond {at} the vehicle gains {size}",
        remedy="plan with the speed that it reaches",
        in_percent=True,
    ),
    sizes="20 to 100 % of what is asked beyond the limit.",
    confused_with=("speed-scale",),
    distinguished_by="Legs at several speeds below and above the threshold, both ways along a line.",
    lacking=_needs_speeds,
    terms=(Term(("fraction",), "threshold"),),
)
