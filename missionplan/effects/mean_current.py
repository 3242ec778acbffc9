"""A steady current beyond that of the mission."""

from dataclasses import dataclass

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.effects.finding import Finding
from missionplan.effects.info import EffectInfo, Parameter
from missionplan.phases.hooks import DriftParts, Leg, TransitEffect


@dataclass(frozen=True)
class MeanCurrent(TransitEffect):
    """Steady velocity (`east`, `north`) [m/s] at the run depth."""

    east: Scalars = 0.0
    north: Scalars = 0.0

    def velocity(self, leg: Leg) -> Array:
        """Return the velocity error of each leg, shape (2, n) [m/s]."""
        return np.stack([self.east + 0.0 * leg.t_start, self.north + 0.0 * leg.t_start])

    def drift(self) -> DriftParts:
        """Return the steady velocity."""
        return DriftParts(velocity=np.stack(np.broadcast_arrays(self.east, self.north)))


_COMPONENT = "component of the current, toward positive"
INFO = EffectInfo(
    id="mean-current",
    phase="transit",
    tier="physical",
    effect=MeanCurrent,
    parameters={
        "east": Parameter("m/s", f"east {_COMPONENT}", -3.0, 3.0, scale=0.15, spike=0.004),
        "north": Parameter("m/s", f"north {_COMPONENT}", -3.0, 3.0, scale=0.15, spike=0.004),
    },
    belongs_to="place",
    what="A current that is constant over the whole record, in addition to the site's current.",
    finding=Finding(
        "east",
        "a current of {size} toward {direction} is not in the mission",
        remedy="enter it as the site's current, or let the vehicle correct for its drift",
        toward=("east", "north"),
    ),
    sizes="0.02 to 0.5 m/s in coastal water.",
    confused_with=("speed-scale", "compass-bias", "current-shear", "persistent-error"),
    distinguished_by=(
        "Legs on several headings: a current has the same direction on all, a sensor error turns with the vehicle."
    ),
    is_steady_current=True,
)
