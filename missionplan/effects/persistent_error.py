"""A velocity error that is correlated from leg to leg."""

from dataclasses import dataclass

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.effects.finding import Finding
from missionplan.effects.info import EffectInfo, Parameter
from missionplan.phases.hooks import DriftParts, Leg, TransitEffect


@dataclass(frozen=True)
class PersistentError(TransitEffect):
    """Ornstein–Uhlenbeck velocity of standard deviation `sigma` [m/s] on each axis and correlation time `time` [s]."""

    sigma: Scalars = 0.0
    time: Scalars = 7200.0

    @property
    def is_random(self) -> bool:
        """It needs standard normals for each leg."""
        return True

    def step(self, memory: Array | None, elapsed: Array, normals: Array, leg: Leg) -> tuple[Array, Array]:
        """Advance the velocity over `elapsed` by the exact transition of the process; stationary on the first leg."""
        if memory is None:
            velocity = self.sigma * normals
        else:
            factor, variance = self.transition(elapsed)
            velocity = factor * memory + np.sqrt(variance) * normals
        return velocity, velocity

    def transition(self, elapsed: Array) -> tuple[Array, Array]:
        """Return the transition factor exp(−Δt/time) and the added variance sigma²·(1 − exp(−2Δt/time)) [m²/s²]."""
        factor = np.asarray(np.exp(-elapsed / self.time))
        return factor, np.asarray(-np.square(self.sigma) * np.expm1(-2.0 * elapsed / self.time))

    def drift(self) -> DriftParts:
        """Return the velocity's standard deviation and correlation time."""
        return DriftParts(persistent=(self.sigma, self.time))

    @property
    def first_variance(self) -> Scalars:
        """Variance on the first leg: the process is stationary [m²/s²]."""
        return np.square(self.sigma)

    def covariance(self, t: Array) -> Array:
        """Covariance of one component between the middles of legs, ``sigma²·exp(−|Δt|/time)``, shape (n, n) [m²/s²]."""
        return np.asarray(self.sigma**2 * np.exp(-np.abs(t[:, None] - t[None, :]) / self.time))


INFO = EffectInfo(
    id="persistent-error",
    phase="transit",
    tier="statistical",
    effect=PersistentError,
    parameters={
        "sigma": Parameter(
            "m/s", "standard deviation on each axis", 0.0, 3.0, median=0.06, factor=2.5, is_random_size=True
        ),
        "time": Parameter("s", "correlation time", 60.0, 1e7, median=30000.0, factor=6.0, default=7200.0),
    },
    what="The error of one leg resembles that of the leg before: eddies, slow currents, a compass that drifts.",
    finding=Finding(
        "sigma",
        "velocity errors of {size} last from one leg to the next",
        remedy="correct for the drift of the last legs (drift_compensation: filter), or surface more often",
    ),
    sizes="Mesoscale and tidal currents: 0.02 to 0.3 m/s over half an hour to weeks.",
    confused_with=("random-walk", "tidal-current", "inertial-current", "current-shear", "mean-current"),
    distinguished_by="A longer record, or a current meter near the track, which would show the physical cause.",
    part="covariance",
    exclusive_group="velocity error from leg to leg",
)
