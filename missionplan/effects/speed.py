"""Effects on the speed through the water."""

from dataclasses import dataclass

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.effects.info import EffectInfo, Finding, LegRecord, Parameter, Term
from missionplan.phases.hooks import Leg, TransitEffect


@dataclass(frozen=True)
class SpeedScale(TransitEffect):
    """True speed through the water is the assumed one times ``1 + fraction``."""

    fraction: Scalars = 0.0

    def course_factor(self, leg: Leg) -> Scalars:
        """Return the true speed of each leg over the assumed one, shape (n,)."""
        return 1.0 + self.fraction


SPEED_SCALE = EffectInfo(
    id="speed-scale",
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
    upkeep=("check the log's calibration", "clean the hull and the propeller"),
    confused_with=("mean-current", "compass-deviation"),
    distinguished_by="Legs in both directions along one line.",
)


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


SPEED_LOSS = EffectInfo(
    id="speed-loss",
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


@dataclass(frozen=True)
class CurrentResponse(TransitEffect):
    """A current along the course moves the vehicle by ``1 + along`` of itself, one across by all of itself.

    At −1 the speed over the ground is held. Thrust that depends on the speed over the ground holds a part of it.
    """

    along: Scalars = 0.0

    def answer_to_current(self, leg: Leg, water: Array) -> Array:
        """Return the velocity error of each leg, shape (2, n) [m/s]."""
        return np.asarray(self.along * np.sum(water * leg.along, axis=0) * leg.along)


CURRENT_RESPONSE = EffectInfo(
    id="current-response",
    effect=CurrentResponse,
    parameters={
        "along": Parameter(
            "",
            "what the vehicle answers to a current along its course, over its answer across, less 1",
            -1.3,
            1.0,
            scale=0.5,
            spike=0.005,
        )
    },
    what=(
        "Something holds the speed over the ground, wholly or in part: a loop on a Doppler log, thrust or revolutions "
        "that follow the speed over the ground."
    ),
    finding=Finding(
        "along",
        "the vehicle answers to a current along its course with {size} of what it answers across, as where something "
        "holds its speed over the ground",
        remedy="find out what holds it; till then plan with the extended mission, which does so too",
        beyond=1.0,
    ),
    sizes="−1 for a loop that holds the speed over the ground, −0.2 to −0.6 for thrust that follows it.",
    confused_with=("compass-deviation", "mean-current"),
    distinguished_by="Legs all round the compass in a current that is known, or is twice as strong.",
    linear=False,
    terms=(Term(("along",)),),
)
