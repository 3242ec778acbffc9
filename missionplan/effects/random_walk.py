"""A velocity error that walks randomly from leg to leg."""

from dataclasses import dataclass

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.effects.finding import Finding
from missionplan.effects.info import EffectInfo, Parameter
from missionplan.phases.hooks import DriftParts, Leg, TransitEffect


@dataclass(frozen=True)
class RandomWalk(TransitEffect):
    """Velocity that is zero on the first leg and whose variance grows by ``rate²`` per second on each axis."""

    rate: Scalars = 0.0

    @property
    def is_random(self) -> bool:
        """It needs standard normals for each leg."""
        return True

    def step(self, memory: Array | None, elapsed: Array, normals: Array, leg: Leg) -> tuple[Array, Array]:
        """Advance the velocity over the time between the middles of the legs."""
        velocity = 0.0 * normals if memory is None else memory + np.sqrt(self.transition(elapsed)[1]) * normals
        return velocity, velocity

    def transition(self, elapsed: Array) -> tuple[Array, Array]:
        """Return the transition factor 1 and the added variance rate²·Δt [m²/s²]."""
        return np.ones_like(elapsed), np.asarray(np.square(self.rate) * elapsed)

    def drift(self) -> DriftParts:
        """Return the growth of the velocity's deviation."""
        return DriftParts(walk=self.rate)

    @property
    def first_variance(self) -> Scalars:
        """Variance on the first leg: zero [m²/s²]."""
        return 0.0

    def covariance(self, t: Array) -> Array:
        """Covariance of one component between the middles of legs, ``rate²·min(t, t′)``, shape (n, n) [m²/s²]."""
        since = t - np.min(t)
        return np.asarray(self.rate**2 * np.minimum(since[:, None], since[None, :]))


INFO = EffectInfo(
    id="random-walk",
    phase="transit",
    tier="statistical",
    effect=RandomWalk,
    parameters={
        "rate": Parameter(
            "m/s**1.5",
            "growth: standard deviation after one second",
            0.0,
            1.0,
            median=5e-4,
            factor=3.0,
            is_random_size=True,
        )
    },
    what="The error drifts without bound: an ageing gyro or calibration, water that changes along the way.",
    finding=Finding(
        "rate",
        "the velocity error wanders by {size}",
        remedy="correct for the drift of the last leg (drift_compensation: filter), or surface more often",
    ),
    sizes="0.01 to 0.1 m/s after an hour: 2e-4 to 2e-3 m/s per root second.",
    confused_with=("persistent-error", "current-shear", "mean-current", "tidal-current"),
    distinguished_by="A record several times as long: a persistent error stays within bounds, a walk does not.",
    part="covariance",
    exclusive_group="velocity error from leg to leg",
)
