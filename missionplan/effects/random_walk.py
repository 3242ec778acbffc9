"""A velocity error that walks randomly from leg to leg."""

from dataclasses import dataclass

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.effects.finding import Finding
from missionplan.effects.info import EffectInfo, Parameter
from missionplan.effects.markov_velocity import MarkovVelocity
from missionplan.phases.hooks import DriftParts


@dataclass(frozen=True)
class RandomWalk(MarkovVelocity):
    """Velocity that is zero when the first leg begins and whose variance grows by ``rate²`` per second on each axis."""

    rate: Scalars = 0.0

    def transition(self, elapsed: Array) -> tuple[Array, Array]:
        """Return the transition factor 1 and the added variance rate²·Δt [m²/s²]."""
        return np.ones_like(elapsed), np.asarray(np.square(self.rate) * elapsed)

    def drift(self) -> DriftParts:
        """Return the growth of the velocity's deviation."""
        return DriftParts(walk=self.rate)

    @property
    def first_variance(self) -> Scalars:
        """Variance where a run begins: zero [m²/s²]."""
        return 0.0

    def mean_over(self, duration: Array) -> tuple[Array, Array]:
        """Return the mean given both ends: half their sum, of variance rate²·Δt/12 (a Brownian bridge's) [m²/s²]."""
        return np.full_like(duration, 0.5), np.asarray(np.square(self.rate) * duration / 12.0)


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
