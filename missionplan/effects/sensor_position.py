"""A depth sensor that is not at the nose."""

from dataclasses import dataclass

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.effects.finding import Finding
from missionplan.effects.info import EffectInfo, Instrument, Parameter
from missionplan.phases.hooks import DescentEffect


@dataclass(frozen=True)
class SensorPosition(DescentEffect):
    """The sensor is `aft` [m] behind the nose: nose down it is higher by as much, though not above the surface."""

    aft: Scalars = 0.0

    def reading(self, t: Array, depth: Array) -> Array:
        """Return the sensor's depth [m]."""
        return np.maximum(depth - self.aft, np.minimum(depth, 0.0))


INFO = EffectInfo(
    id="sensor-position",
    phase="descent",
    tier="physical",
    effect=SensorPosition,
    parameters={"aft": Parameter("m", "distance of the sensor behind the nose", 0.0, 5.0, scale=0.4, spike=0.01)},
    what="The depth sensor sits in the hull or the tail, and the vehicle goes down nose first.",
    finding=Finding(
        "aft",
        "the depth sensor sits {size} behind the nose",
        remedy="measure where it is and correct the log; the plan stays as it is",
    ),
    sizes="Up to the vehicle's length; never ahead of the nose.",
    confused_with=("clock-offset", "sensor-lag"),
    distinguished_by="A tape measure; dives with anchors of two weights (a delay grows to more depth at more speed).",
    changes_plan=False,
    follows_law=True,
    instrument=Instrument("the sensor's distance from the nose, by tape", "aft", 0.02, 5.0),
)
