"""A vehicle that does not go with a current along its course as it goes with one across."""

from dataclasses import dataclass

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.effects.finding import Finding
from missionplan.effects.info import EffectInfo, Parameter, Term
from missionplan.phases.hooks import Leg, TransitEffect


@dataclass(frozen=True)
class CurrentResponse(TransitEffect):
    """A current along the course moves the vehicle by ``1 + along`` of itself, one across by all of itself.

    At −1 the speed over the ground is held. Thrust that depends on the speed over the ground holds a part of it.
    """

    along: Scalars = 0.0

    def answer_to_current(self, leg: Leg, water: Array) -> Array:
        """Return the velocity error of each leg, shape (2, n) [m/s]."""
        return np.asarray(self.along * np.sum(water * leg.along, axis=0) * leg.along)


INFO = EffectInfo(
    id="current-response",
    phase="transit",
    tier="physical",
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
