"""A velocity error that is correlated from leg to leg."""

from dataclasses import dataclass

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.effects.finding import Finding
from missionplan.effects.info import EffectInfo, Parameter
from missionplan.effects.markov_velocity import MarkovVelocity
from missionplan.phases.hooks import DriftParts

SHORT = 1e-3
"""Time over the correlation time below which the first term of a series replaces a difference, to 1e-7 of it."""


@dataclass(frozen=True)
class PersistentError(MarkovVelocity):
    """Ornstein–Uhlenbeck velocity of standard deviation `sigma` [m/s] on each axis and correlation time `time` [s]."""

    sigma: Scalars = 0.0
    time: Scalars = 7200.0

    def transition(self, elapsed: Array) -> tuple[Array, Array]:
        """Return the transition factor exp(−Δt/time) and the added variance sigma²·(1 − exp(−2Δt/time)) [m²/s²]."""
        factor = np.asarray(np.exp(-elapsed / self.time))
        return factor, np.asarray(-np.square(self.sigma) * np.expm1(-2.0 * elapsed / self.time))

    def drift(self) -> DriftParts:
        """Return the velocity's standard deviation and correlation time."""
        return DriftParts(persistent=(self.sigma, self.time))

    @property
    def first_variance(self) -> Scalars:
        """Variance where a run begins: the process is stationary [m²/s²]."""
        return np.square(self.sigma)

    def mean_over(self, duration: Array) -> tuple[Array, Array]:
        """Return the mean given both ends: the share tanh(½a)/a of their sum, a = Δt/time, and its variance [m²/s²].

        The variance is sigma²·(2/a²)·(a − 2 tanh ½a), the process being a bridge between both values.
        """
        a = duration / self.time
        known, half = np.maximum(a, SHORT), np.tanh(0.5 * np.maximum(a, SHORT))
        rest = np.where(a < SHORT, a / 6.0, 2.0 * (known - 2.0 * half) / np.square(known))
        return np.where(a < SHORT, 0.5, half / known), np.asarray(np.square(self.sigma) * rest)


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
