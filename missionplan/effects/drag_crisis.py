"""Drag crisis: drag that falls about a critical speed."""

from dataclasses import dataclass

import scipy

from missionplan.arrays import Scalars
from missionplan.effects.finding import Finding
from missionplan.effects.info import EffectInfo, Parameter
from missionplan.phases.hooks import DescentEffect


@dataclass(frozen=True)
class DragCrisis(DescentEffect):
    """Both bodies' drag falls by `fraction` about a critical `speed` through the water [m/s].

    The factor is ``1 − fraction·½(1 + tanh((U − speed)/width))``.
    """

    fraction: Scalars = 0.0
    speed: Scalars = 1.2
    width: Scalars = 0.1

    def drag_factor(self, since_taut: Scalars, speed: Scalars) -> Scalars:
        """Return the factor on both bodies' drag."""
        return 1.0 - self.fraction * scipy.special.expit(2.0 * (speed - self.speed) / self.width)


INFO = EffectInfo(
    id="drag-crisis",
    phase="descent",
    tier="physical",
    effect=DragCrisis,
    parameters={
        "fraction": Parameter("", "share of the drag lost above the critical speed", 0.0, 0.9, scale=0.3, spike=0.005),
        "speed": Parameter("m/s", "critical speed through the water", 0.1, 5.0, median=1.2, factor=1.5, default=1.2),
        "width": Parameter("m/s", "half width of the change", 0.01, 2.0, median=0.12, factor=2.0, default=0.1),
    },
    what="The boundary layer of the anchor's blunt nose turns turbulent and the wake narrows.",
    finding=Finding(
        "fraction",
        "above a critical speed {size} of the drag is lost",
        remedy="plan dives that stay clear of that speed, or with the extended mission",
        in_percent=True,
    ),
    sizes="Spheres lose up to 80 % near Re 3e5, blunt anchors 10 to 50 %, at 0.8 to 1.8 m/s for this size.",
    confused_with=("drag-bias", "stratification"),
    distinguished_by="Anchor weights whose terminal speeds lie well below and well above the critical speed.",
)
