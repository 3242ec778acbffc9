"""A position error that walks randomly while the vehicle is under way."""

from dataclasses import dataclass

import numpy as np

from missionplan.arrays import Scalars
from missionplan.effects.finding import Finding
from missionplan.effects.info import EffectInfo, Parameter
from missionplan.phases.hooks import TransitEffect


@dataclass(frozen=True)
class PositionRandomWalk(TransitEffect):
    """Position error whose variance grows by ``rate²`` per second under way on each axis, independently of the past.

    Over a leg of duration T the mean velocity error has the variance rate²/T: a velocity error that forgets itself
    within a small part of a leg (Gardiner 2009, *Stochastic Methods*, section 3.8.1: the Wiener process).
    """

    rate: Scalars = 0.0

    @property
    def is_random(self) -> bool:
        """It needs standard normals for each leg."""
        return bool(np.any(self.rate))

    def position_variance_rate(self) -> Scalars:
        """Return rate² [m²/s]."""
        return np.square(self.rate)


INFO = EffectInfo(
    id="position-random-walk",
    phase="transit",
    tier="statistical",
    effect=PositionRandomWalk,
    parameters={
        "rate": Parameter(
            "m/s**0.5",
            "growth: standard deviation of the position after one second, each axis",
            0.0,
            100.0,
            median=1.0,
            factor=3.0,
            is_random_size=True,
        )
    },
    what="The position error gathers within a leg, step by step: gusts, small eddies, a heading that yaws.",
    finding=Finding(
        "rate",
        "the position wanders by {size} within a leg",
        remedy="surface more often; a better speed sensor would mend it",
    ),
    sizes=(
        "0.1 to 3 m per root second: 6 to 180 m in an hour, an eddy diffusivity rate²/2 of 0.005 to 5 m²/s as at "
        "scales of 100 m to 10 km (Okubo 1971, Deep-Sea Res. 18)."
    ),
    confused_with=("fix-error", "heavy-tails"),
    distinguished_by=(
        "Legs of very different duration: a velocity error is the same on all, this one falls as 1/√T, a fix error as "
        "1/T, and neighbouring legs share a fix."
    ),
    part="covariance",
)
