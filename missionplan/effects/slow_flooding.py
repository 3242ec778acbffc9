"""An anchor that floods slowly."""

from dataclasses import dataclass

import numpy as np

from missionplan.arrays import Scalars
from missionplan.effects.finding import Finding
from missionplan.effects.info import EffectInfo, Parameter
from missionplan.phases.hooks import DescentEffect


@dataclass(frozen=True)
class SlowFlooding(DescentEffect):
    """Anchor's wet weight times ``1 − fraction·exp(−t/time)``, t since the separation."""

    fraction: Scalars = 0.0
    time: Scalars = 5.0

    def wet_weight_factor(self, since_separation: Scalars) -> Scalars:
        """Return the factor on the anchor's wet weight."""
        return 1.0 - self.fraction * np.exp(-np.maximum(since_separation, 0.0) / self.time)


INFO = EffectInfo(
    id="slow-flooding",
    phase="descent",
    tier="physical",
    effect=SlowFlooding,
    parameters={
        "fraction": Parameter("", "share of the wet weight missing at first", 0.0, 1.0, scale=0.3, spike=0.005),
        "time": Parameter("s", "time constant of the flooding", 0.2, 60.0, median=4.0, factor=2.2, default=5.0),
    },
    what="The anchor's tube floods through small holes: it starts light and approaches its wet weight exponentially.",
    finding=Finding(
        "fraction",
        "{size} of the anchor's wet weight is missing when it separates, until it has flooded",
        remedy="open larger flooding holes, or wet the anchor before its release",
        in_percent=True,
    ),
    sizes=(
        "The tube's free volume relative to its wet weight allows 0 to 60 %; holes of a few mm flood it in 1 to 15 s."
    ),
    confused_with=("added-mass", "broadside-start", "trapped-gas"),
    distinguished_by="Anchors with large flooding holes, or a dive with the anchor flooded before release.",
)
