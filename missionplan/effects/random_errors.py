"""Errors that are random from leg to leg: velocities that persist or wander, fixes, heavy tails."""

from dataclasses import dataclass

import numpy as np
import scipy

from missionplan.arrays import Array, Scalars
from missionplan.effects.info import EffectInfo, Finding, Instrument, Parameter
from missionplan.phases.hooks import DriftParts, Leg, MarkovProcess, TransitEffect


@dataclass(frozen=True)
class MarkovVelocity(TransitEffect, MarkovProcess):
    """Velocity error of one Markov process in time on each axis, felt as its mean over each leg.

    A leg's mean does not tell the process at the leg's end: what is known of that, the means so far given, is carried
    from leg to leg by the Kalman filter without measurement noise, so that one normal an axis draws each leg's mean
    from its distribution given all those before (innovations form: Durbin & Koopman 2012, *Time Series Analysis by
    State Space Methods*, section 4.3).
    """

    @property
    def is_random(self) -> bool:
        """It needs standard normals for each leg."""
        return True

    def step(self, memory: Array | None, elapsed: Array, normals: Array, leg: Leg) -> tuple[Array, Array]:
        """Draw the mean over a leg given those before it.

        Memory: mean (two rows) and variance of the velocity at the end of the last leg, and that leg's duration.
        """
        expected, variance = self._at_start(memory, elapsed, normals, leg)
        kept, added = self.transition(leg.duration)
        share, rest = self.mean_over(leg.duration)
        of_mean = np.square(share) * (np.square(1.0 + kept) * variance + added) + rest
        of_end = share * ((1.0 + kept) * kept * variance + added)
        innovation = np.sqrt(of_mean) * normals
        gain = of_end / np.where(of_mean > 0.0, of_mean, 1.0)
        end = kept * expected + gain * innovation
        left = np.maximum(np.square(kept) * variance + added - gain * of_end, 0.0)
        return np.stack([*end, left, leg.duration]), share * (1.0 + kept) * expected + innovation

    def _at_start(self, memory: Array | None, elapsed: Array, normals: Array, leg: Leg) -> tuple[Array, Array]:
        """Mean, shape (2, n), and variance, shape (n,), of the velocity at a leg's start, the means so far given."""
        if memory is None:
            return np.zeros_like(normals), np.broadcast_to(self.first_variance, leg.duration.shape)
        between = np.maximum(elapsed - 0.5 * (memory[3] + leg.duration), 0.0)
        kept, added = self.transition(between)
        return kept * memory[:2], np.square(kept) * memory[2] + added


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
        ratio, half = np.maximum(a, SHORT), np.tanh(0.5 * np.maximum(a, SHORT))
        rest = np.where(a < SHORT, a / 6.0, 2.0 * (ratio - 2.0 * half) / np.square(ratio))
        return np.where(a < SHORT, 0.5, half / ratio), np.asarray(np.square(self.sigma) * rest)


PERSISTENT_ERROR = EffectInfo(
    id="persistent-error",
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


RANDOM_WALK = EffectInfo(
    id="random-walk",
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


POSITION_RANDOM_WALK = EffectInfo(
    id="position-random-walk",
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


@dataclass(frozen=True)
class FixError(TransitEffect):
    """Extra standard deviation `sd` [m] of every fix, each axis."""

    sd: Scalars = 0.0

    def fix_variance(self) -> Scalars:
        """Return the extra variance of a fix, each axis [m²]."""
        return np.square(self.sd)


FIX_ERROR = EffectInfo(
    id="fix-error",
    tier="statistical",
    effect=FixError,
    parameters={
        "sd": Parameter("m", "extra standard deviation of a fix, each axis", 0.0, 2000.0, median=25.0, factor=2.0)
    },
    what="Few satellites, waves over the antenna, outdated ephemerides: fixes scatter more than assumed.",
    finding=Finding(
        "sd",
        "a fix errs by {size} more than stated",
        remedy="wait longer at the surface for better fixes, or raise the antenna",
    ),
    sizes="10 to 100 m for a first fix with a wet antenna at the waterline.",
    confused_with=("heavy-tails",),
    distinguished_by=(
        "Legs of very different duration, as a fix error matters on short legs alone; a minute of fixes on land."
    ),
    part="covariance",
    instrument=Instrument("an hour of fixes with the vehicle at a known place in the water", "sd", 3.0),
)


@dataclass(frozen=True)
class HeavyTails(TransitEffect):
    """Student-t velocity error with `dof` degrees of freedom (above 2), of the same covariance as before.

    A leg's error is a normal one times √((ν − 2)/χ²_ν), one χ² for both components.
    """

    dof: Scalars = np.inf

    @property
    def is_random(self) -> bool:
        """It needs normals of its own for each leg."""
        return bool(np.any(np.isfinite(self.dof)))

    def tail_dof(self) -> Scalars:
        """Return the degrees of freedom."""
        return self.dof

    def error_scale(self, normals: Array) -> Array:
        """Return the factor on each leg's random velocity error, shape (n,), from the first of its normals."""
        every, normal = np.broadcast_arrays(self.dof, normals[0])
        factor, finite = np.ones(normal.shape), np.isfinite(every)
        dof = every[finite]
        chi_squared = 2.0 * scipy.special.gammaincinv(0.5 * dof, scipy.special.ndtr(normal[finite]))
        factor[finite] = np.sqrt((dof - 2.0) / chi_squared)
        return factor


HEAVY_TAILS = EffectInfo(
    id="heavy-tails",
    tier="statistical",
    effect=HeavyTails,
    parameters={
        "dof": Parameter(
            "",
            "degrees of freedom; normal errors at infinity",
            2.05,
            1e6,
            median=4.0,
            factor=1.6,
            reciprocal_is_uniform=True,
            default=np.inf,
        )
    },
    what="Most legs are as accurate as expected and a few are bad: fronts, a bad fix, a propeller fouled for one leg.",
    finding=Finding(
        "",
        "some legs err far more than the others",
        remedy="look at the worst legs one by one: a current, a wrong fix or a bad record",
    ),
    sizes="3 to 6 degrees of freedom in navigation logs with occasional bad legs.",
    confused_with=("fix-error", "persistent-error"),
    distinguished_by="The log of the bad legs: number of satellites, currents, revolutions.",
    part="covariance",
    exclusive_group="velocity error from leg to leg",
)
