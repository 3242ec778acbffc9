"""Growth on the hull: the vehicle is slower than it believes, by a share that grows from day to day."""

from dataclasses import dataclass

from missionplan.arrays import Array, Scalars
from missionplan.effects.info import EffectInfo, Parameter
from missionplan.phases.hooks import Leg, TransitEffect

DAY = 86400.0
"""[s]."""


@dataclass(frozen=True)
class Fouling(TransitEffect):
    """Speed through the water that falls by `rate` [1/day] of itself, from the mission's start on."""

    rate: Scalars = 0.0

    def velocity(self, leg: Leg) -> Array:
        """Return the velocity error of each leg, shape (2, n) [m/s]: backwards along its course."""
        days = (leg.t_start + 0.5 * leg.duration) / DAY
        return -self.rate * days * leg.speed * leg.along


INFO = EffectInfo(
    id="fouling",
    effect=Fouling,
    parameters={"rate": Parameter("", "share of the speed lost in a day", 0.0, 0.2, scale=0.02, spike=1e-4)},
    what="Biofilm and barnacles roughen the hull: at the same thrust the vehicle is slower from day to day.",
    sizes="1 to 5 % a day in warm shallow water; speed is lost, never gained.",
    confused_with=("speed-scale", "current-shear", "persistent-error"),
    distinguished_by="Legs in opposite directions at the beginning and at the end of the record; a look at the hull.",
)
