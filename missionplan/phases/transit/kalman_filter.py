"""A Kalman filter of the drift, updated by the fixes of each leg: `drift_compensation: filter`.

The drift beyond the forecast is a linear model: a steady velocity (that may walk randomly), a displacement at each
surfacing, a persistent velocity (the means over the legs of an Ornstein–Uhlenbeck process), and oscillations of known
frequencies. Its prior is the mission's own uncertainty. With the model true and everything normal, the estimate is that
of least mean square; what the mission does not call uncertain is taken as known. Kalman 1960, J. Basic Eng. 82, 35–45.

The measurements are those of `compensation`: a leg's velocity error, of variance σ_v² + 2σ_fix²/T², and the drift
between the fixes on surfacing and on diving, of variance 2σ_fix². Both hold the error of the fix on surfacing; half the
drift's rate, added to the first, makes their errors independent, with σ_v² + 3σ_fix²/(2T²).
"""

from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray
from typing_extensions import override

from missionplan.arrays import Array, Scalars
from missionplan.phases.transit.compensation import Compensation, CompletedLeg, Forecast, Memory, PlannedLeg

STEADY, SURFACE, PERSISTENT, WAVES = 0, 2, 4, 6
"""First index of each part of the state: two components each, and four for each tidal frequency."""
SHORT = 1e-4
"""Least duration over the correlation time in a quotient of differences."""
MISS_UNDERSHOOT, MISS_REMAINDER = 2.0, 0.2724
"""How far short a leg that will miss is aimed, in standard deviations m, and what is then left, E[Rice(m, 1)] − m."""


@dataclass(frozen=True)
class DriftModel:
    """Linear model of the drift beyond the forecast.

    The state holds, east before north: the steady velocity [m/s], the displacement of one surfacing [m], the persistent
    velocity [m/s]; for each frequency of `tides` the coefficients of cos ωt and sin ωt toward east, then toward
    north; for `turning` A and B of (A cos ωt + B sin ωt, B cos ωt − A sin ωt), a current that turns clockwise [m/s].
    """

    mean: Array
    """Of the state before the first leg, shape (k,)."""
    prior: Array
    """Its covariance, shape (k, k)."""
    tides: tuple[float, ...]
    """Angular frequencies [rad/s]."""
    turning: float
    """Angular frequency; 0 for none [rad/s]."""
    persistence: float
    """Correlation time of the persistent velocity [s]."""
    walk: float
    """Growth of the steady velocity's deviation [m/s^1.5]."""
    growth: Array
    """Growth of the variance of the coefficients of waves that are modulated, shape (k,) [m²/s³]."""
    covariance: Array
    """Σ_v, of the velocity error drawn anew for each leg, shape (2, 2) [m²/s²]."""
    fix_error: float
    """σ_fix, each axis [m]."""

    def phasors(self, t: Array, duration: Array) -> Array:
        """Means over each leg of cos ωt and sin ωt for every frequency, shape (frequencies, 2, n)."""
        frequencies = np.array([*self.tides, *([self.turning] if self.turning else [])])[:, None]
        angle, damping = frequencies * (t + 0.5 * duration), np.sinc(frequencies * duration / (2.0 * np.pi))
        return np.stack([damping * np.cos(angle), damping * np.sin(angle)], axis=1)

    def under_way(self, t: Array, duration: Array) -> Array:
        """Measurement matrix: a leg's mean velocity from the state, shape (2, k, n)."""
        matrix = np.zeros((2, len(self.mean), t.size))
        for axis in (0, 1):
            matrix[axis, STEADY + axis] = 1.0
            matrix[axis, PERSISTENT + axis] = self._mean_over_leg(duration)[0]
        phasors = self.phasors(t, duration)
        for index in range(len(self.tides)):
            for axis in (0, 1):
                first = WAVES + 4 * index + 2 * axis
                matrix[axis, first : first + 2] = phasors[index]
        if self.turning:
            cosine, sine = phasors[-1]
            matrix[0, -2:] = cosine, sine
            matrix[1, -2:] = -sine, cosine
        return matrix

    def _mean_over_leg(self, duration: Array) -> tuple[Array, Array]:
        """Standard deviation of a leg's mean over that of the persistent velocity, and the mean of e^(−t/τ), (n,).

        The root of 2(a − 1 + e^(−a))/a², and (1 − e^(−a))/a, with a = T/τ.
        """
        a = np.maximum(duration / self.persistence, SHORT)
        return np.sqrt(2.0 * (a + np.expm1(-a))) / a, -np.expm1(-a) / a

    def kept(self, elapsed: Array, duration: Array) -> Array:
        """Correlation of a leg's mean of the persistent velocity with that of the last one, were that as long, (n,).

        Parameters
        ----------
        elapsed : array, shape (n,)
            Between the middles of the legs [s].
        duration : array, shape (n,)
            Of the leg [s].
        """
        deviation, decayed = self._mean_over_leg(duration)
        pause = np.maximum(elapsed - duration, 0.0)
        return np.asarray(np.minimum(np.square(decayed / deviation) * np.exp(-pause / self.persistence), 1.0))


@dataclass(frozen=True)
class DriftFilter(Compensation):
    """Expect the forecast and the filter's estimate beyond it."""

    forecast: Forecast
    model: DriftModel

    @override
    def begin(self, trials: int) -> Memory:
        """Return state (k, n), covariance (k, k, n) and time of the last leg's middle (n,), negative at first."""
        state = np.repeat(self.model.mean[:, None], trials, axis=1)
        return state, np.repeat(self.model.prior[:, :, None], trials, axis=2), np.full(trials, -1.0)

    @override
    def offset(self, memory: Memory, leg: PlannedLeg) -> Array:
        velocity, surface = self.expected(memory, leg)
        wanted = leg.nominal - self.undershoot(memory, leg) - surface
        return leg.nominal - wanted + velocity * time_over_ground(wanted, velocity, _speed(leg), leg.duration)

    def expected(self, memory: Memory, leg: PlannedLeg) -> tuple[Array, Array]:
        """Mean velocity expected over the coming leg [m/s] and displacement at the surface [m], shape (2, n) each."""
        state, _, last = memory
        state = state * self._transition(last, leg.t + 0.5 * leg.duration, leg.duration)
        velocity = np.einsum("akn,kn->an", self.model.under_way(leg.t, leg.duration), state)
        surface = self.forecast.at_surface(leg.t + leg.duration, leg.fix + leg.nominal) + state[SURFACE : SURFACE + 2]
        return velocity + self.forecast.under_way(leg.t, leg.duration, leg.fix, leg.nominal), surface

    def spread(self, memory: Memory, leg: PlannedLeg) -> tuple[Array, Array]:
        """Standard deviation of where the coming leg ends by its fix, along and across it, shape (n,) each [m]."""
        model, (_, covariance, last) = self.model, memory
        middle = leg.t + 0.5 * leg.duration
        kept = self._transition(last, middle, leg.duration)
        rows = model.under_way(leg.t, leg.duration) * leg.duration
        for axis in (0, 1):
            rows[axis, SURFACE + axis] += 1.0
        course = leg.nominal / np.maximum(np.hypot(*leg.nominal), 1e-300)
        across = np.stack((-course[1], course[0]))
        added, deviations = np.einsum("iin->in", self._process_noise(last, middle, leg.duration)), []
        for direction in (course, across):
            row = direction[0] * rows[0] + direction[1] * rows[1]
            carried = row * kept
            variance = np.einsum("in,in->n", np.einsum("ijn,jn->in", covariance, carried), carried)
            variance += np.einsum("in,in->n", added, row**2)
            drawn = np.einsum("an,an->n", np.einsum("ab,bn->an", model.covariance, direction), direction)
            deviations.append(np.sqrt(variance + drawn * leg.duration**2 + 2.0 * model.fix_error**2))
        return deviations[0], deviations[1]

    @override
    def undershoot(self, memory: Memory, leg: PlannedLeg) -> Array:
        """How far short of the target it pays to end, beyond the shortfall of the plan itself."""
        along, across = self.spread(memory, leg)
        surfacing_cost = _speed(leg) * self.forecast.surfacing_time
        planned = np.hypot(*(leg.goal - leg.fix - leg.nominal))
        more = np.maximum(stop_short(leg.radius, along, across, surfacing_cost) - planned, 0.0)
        length = np.hypot(*leg.nominal)
        more = np.minimum(more, 0.5 * length)  # at least half of the leg is run, however large the error
        short: Array = leg.nominal * (more / np.where(length > 0.0, length, 1.0))
        return short

    @override
    def update(self, memory: Memory, leg: CompletedLeg) -> Memory:
        model, (state, covariance, last) = self.model, memory
        moved = leg.duration > 0.0
        seconds, middle = np.where(moved, leg.duration, 1.0), leg.t + 0.5 * leg.duration
        kept, added = self._transition(last, middle, seconds), self._process_noise(last, middle, seconds)
        state, covariance = state * kept, covariance * kept * kept[:, None] + added
        drift = leg.surface_drift - self.forecast.at_surface(leg.t + leg.duration, leg.start + leg.through)
        share = 0.5 / seconds if model.fix_error > 0.0 else np.zeros_like(seconds)
        error = leg.velocity_error - self.forecast.under_way(leg.t, leg.duration, leg.start, leg.through)
        velocity, rows = error + share * drift, model.under_way(leg.t, leg.duration)
        surface = np.zeros_like(rows)
        for axis in (0, 1):
            surface[axis, SURFACE + axis] = 1.0
        rows = rows + share * surface
        variances, axes = np.linalg.eigh(model.covariance)
        for index in (0, 1):
            row = axes[0, index] * rows[0] + axes[1, index] * rows[1]
            measured = axes[0, index] * velocity[0] + axes[1, index] * velocity[1]
            noise = max(float(variances[index]), 0.0) + 1.5 * model.fix_error**2 / seconds**2
            state, covariance = _measurement_update(state, covariance, row, measured, noise, moved)
        for axis in (0, 1):
            noise = np.full_like(seconds, 2.0 * model.fix_error**2)
            state, covariance = _measurement_update(state, covariance, surface[axis], drift[axis], noise, moved)
        return state, covariance, np.where(moved, middle, last)

    def _transition(self, last: Array, now: Array, duration: Array) -> Array:
        """Diagonal of the transition matrix from the middle of the last leg to that of the next, shape (k, n)."""
        kept = np.ones((len(self.model.mean), now.size))
        kept[PERSISTENT : PERSISTENT + 2] = np.where(last >= 0.0, self.model.kept(now - last, duration), 1.0)
        return kept

    def _process_noise(self, last: Array, now: Array, duration: Array) -> Array:
        """Covariance of the process noise between the middles of two legs, shape (k, k, n)."""
        added = np.zeros((*self.model.prior.shape, now.size))
        elapsed = np.where(last >= 0.0, now - last, 0.0)
        places = np.arange(WAVES, len(added))
        added[places, places] = self.model.growth[WAVES:, None] * elapsed
        gone = np.where(last >= 0.0, 1.0 - np.square(self.model.kept(now - last, duration)), 0.0)
        for axis in (0, 1):
            added[STEADY + axis, STEADY + axis] = self.model.walk**2 * elapsed
            place = PERSISTENT + axis
            added[place, place] = self.model.prior[place, place] * gone
        return added


def _speed(leg: PlannedLeg) -> Array:
    """Speed through the water, 0 for a trial that does not move, shape (n,) [m/s]."""
    return np.asarray(np.hypot(*leg.nominal) / np.where(leg.duration > 0.0, leg.duration, 1.0))


def time_over_ground(wanted: Array, velocity: Array, speed: Array, otherwise: Array) -> Array:
    """Time that a displacement over the ground takes in a current: ‖d − v t‖ = U t.

    The nominal time of Eqs. 21 and 22 makes a leg end short by v²ℓ/U², with the current as against it.

    Parameters
    ----------
    wanted, velocity : array, shape (2, n)
        d [m], v [m/s].
    speed, otherwise : array, shape (n,)
        U [m/s]; time returned where the current is faster than the vehicle [s].
    """
    spare = speed**2 - np.sum(velocity**2, axis=0)
    against = -np.sum(wanted * velocity, axis=0)
    gains = spare > 0.0
    root = np.sqrt(np.maximum(against**2 + spare * np.sum(wanted**2, axis=0), 0.0))
    return np.where(gains, (against + root) / np.where(gains, spare, 1.0), otherwise)


def stop_short(radius: Scalars, along: Array, across: Array, surfacing_cost: Scalars) -> Array:
    """How far short of the centre of the arrival circle it pays to aim.

    A leg aimed m short ends off by N(0, s²) along it and N(0, s_c²) across it. It saves the distance m; where it misses
    the circle, it costs a surfacing and the distance left. In two regimes the minimum has a closed form:

    - s well below r: the near edge lies r − s_c²/(2r) before the centre on average, a miss costs C = U t_s + r, and
      −m + C Φ((m + s_c²/(2r) − r)/s) is least at m = r − s_c²/(2r) − s √(2 ln(C/(s √(2π)))); the centre, m = 0, where
      that is negative or has no root.
    - s above about r: the leg will miss anyhow and should not overshoot, so that the next need not go back. Then
      m = 2s, and 0.27 s on average is left to be run beyond m. This is taken where it costs less, with a certain
      surfacing, than aiming at the centre, P U t_s + E[d; d > r] with P = P(d > r), d the Rayleigh distance from it.

    Parameters
    ----------
    radius : float or array, shape (n,)
        r [m].
    along, across : array, shape (n,)
        s and s_c; the second regime takes the root of their mean square [m].
    surfacing_cost : float or array, shape (n,)
        U t_s, a surfacing in metres run [m].
    """
    r = np.maximum(radius, 1e-9)
    ratio = (surfacing_cost + r) / (np.sqrt(2.0 * np.pi) * np.maximum(along, 1e-9))
    margin = along * np.sqrt(2.0 * np.log(np.maximum(ratio, 1.0)))
    edge = np.where(ratio > 1.0, np.maximum(r - across**2 / (2.0 * r) - margin, 0.0), 0.0)
    s = np.maximum(np.sqrt(0.5 * (along**2 + across**2)), 1e-9)
    missed = np.exp(-0.5 * np.minimum(r / s, 30.0) ** 2)
    left = r * missed + s * np.sqrt(0.5 * np.pi) * scipy.special.erfc(r / (s * np.sqrt(2.0)))
    will_miss = left - MISS_REMAINDER * s > (1.0 - missed) * surfacing_cost
    return np.asarray(np.where(will_miss & (np.asarray(radius) > 0.0), MISS_UNDERSHOOT * s, edge))


def _measurement_update(
    state: Array, covariance: Array, row: Array, measured: Array, noise: Array, moved: NDArray[np.bool_]
) -> tuple[Array, Array]:
    """Update by one scalar measurement, ``measured = row · state + noise``, of the trials that moved.

    Parameters
    ----------
    state, covariance, row : array, shapes (k, n), (k, k, n), (k, n)
    measured, noise, moved : array, shape (n,)
        `noise` is a variance.
    """
    cross = np.einsum("ijn,jn->in", covariance, row)
    variance = np.einsum("in,in->n", row, cross) + noise
    updates = moved & (variance > 0.0)
    gain = np.where(updates, cross / np.where(updates, variance, 1.0), 0.0)
    innovation = measured - np.einsum("in,in->n", row, state)
    return state + gain * innovation, covariance - gain[:, None] * cross[None]
