"""A scale error of the speed through the water."""

from dataclasses import dataclass

from missionplan.arrays import Scalars
from missionplan.effects.finding import Finding
from missionplan.effects.info import EffectInfo, Parameter
from missionplan.phases.hooks import Leg, TransitEffect


@dataclass(frozen=True)
class SpeedScale(TransitEffect):
    """True speed through the water is the assumed one times ``1 + fraction``."""

    fraction: Scalars = 0.0

    def course_factor(self, leg: Leg) -> Scalars:
        """Return the true speed of each leg over the assumed one, shape (n,)."""
        return 1.0 + self.fraction


INFO = EffectInfo(
    id="speed-scale",
    phase="transit",
    tier="physical",
    effect=SpeedScale,
    parameters={
        "fraction": Parameter(
            "", "relative error, positive when faster than assumed", -0.6, 0.6, scale=0.08, spike=0.002
        )
    },
    what="Revolutions converted to speed with a wrong factor: fouling, propeller, battery voltage.",
    finding=Finding(
        "fraction",
        "the vehicle goes {size} faster than it reckons",
        "the vehicle goes {size} slower than it reckons",
        remedy="calibrate speed against shaft rate on a measured mile, or enter the correction",
        in_percent=True,
    ),
    sizes="2 to 20 %; either sign.",
    ageing="drifts",
    upkeep="clean the hull and the propeller",
    confused_with=("mean-current", "compass-deviation"),
    distinguished_by="Legs in both directions along one line.",
)
