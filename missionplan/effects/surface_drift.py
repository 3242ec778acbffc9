"""Drift at the surface beyond the site's current: wind and waves."""

from dataclasses import dataclass

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.effects.finding import Finding
from missionplan.effects.info import EffectInfo, LegRecord, Parameter
from missionplan.phases.hooks import DriftParts, TransitEffect


@dataclass(frozen=True)
class SurfaceDrift(TransitEffect):
    """Steady drift (`east`, `north`) [m/s] while at the surface."""

    east: Scalars = 0.0
    north: Scalars = 0.0

    def surface_velocity(self, t: Array, duration: Array, position: Array) -> Array:
        """Return the drift velocity, shape (2, n) [m/s]."""
        return np.stack([self.east + 0.0 * t, self.north + 0.0 * t])

    def drift(self) -> DriftParts:
        """Return the velocity at the surface."""
        return DriftParts(surface=np.stack(np.broadcast_arrays(self.east, self.north)))


def _lacking(record: LegRecord) -> str:
    return "" if record.has_surface_time else "needs the time at the surface before each fix: column surface_s"


INFO = EffectInfo(
    id="surface-drift",
    phase="transit",
    tier="physical",
    effect=SurfaceDrift,
    parameters={
        "east": Parameter("m/s", "east component, toward positive", -3.0, 3.0, scale=0.25, spike=0.01),
        "north": Parameter("m/s", "north component, toward positive", -3.0, 3.0, scale=0.25, spike=0.01),
    },
    belongs_to="day",
    what="Windage and Stokes drift move the vehicle between surfacing and its fix, in addition to the current.",
    finding=Finding(
        "east",
        "at the surface the vehicle drifts at {size} toward {direction}",
        remedy="take the fix at once on surfacing, and dive at once after it",
        toward=("east", "north"),
    ),
    sizes="About 3 % of the wind's speed: 0.1 to 0.5 m/s.",
    confused_with=("mean-current",),
    distinguished_by="Surfacing times that vary; two fixes a few minutes apart at one surfacing.",
    lacking=_lacking,
)
