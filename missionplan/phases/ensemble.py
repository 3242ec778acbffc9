"""An ensemble of forecasts: each trial sails in one of its members; what is expected is their weighted mean.

The error of a forecast of the current: a velocity that is correlated in time and space, the same at all depths.

Each component is Gaussian at every place and moment, with the covariance σ² exp(−|Δt|/τ) exp(−|Δx|/L) of an
Ornstein–Uhlenbeck process in time and an exponential one in space. A trial's error is a sum of plane waves with random
amplitudes, whose frequencies are drawn from the spectrum of that covariance (Cauchy in time; in space the density
(1 + L²k²)^(−3/2) of the wavenumber's plane). So it has exactly that covariance over the trials, and it is a function of
place and time: legs, drifts at the surface and dives meet the same error, and its mean along a straight track is exact
too. A mean over thirty times its memory has heavier tails than a normal one (excess kurtosis 1.8), over three next to
none. Rahimi and Recht 2007, Random features for large-scale kernel machines.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray
from typing_extensions import override

from missionplan.arrays import Array, Scalars
from missionplan.phases.currents import Current, Span
from missionplan.phases.recorded_currents import RecordedCurrent


@dataclass(frozen=True)
class Ensemble(RecordedCurrent):
    """Members of an ensemble; use `of`.

    Attributes
    ----------
    time, depth : array, shapes (2,)
        Which all members cover [s since the mission's start, m].
    """

    members: tuple[RecordedCurrent, ...]
    names: tuple[str, ...]
    weights: Array
    """Their probabilities, shape (m,)."""
    chosen: NDArray[np.intp] | None = None
    """The member of each trial; None for the weighted mean; shape (n,)."""
    given: int | None = None
    """The member of all trials, where it is not drawn. What is expected remains the weighted mean."""

    @classmethod
    def of(cls, members: Sequence[RecordedCurrent], names: Sequence[str], weights: Sequence[float]) -> "Ensemble":
        """Build it from members and their weights, in any scale."""
        depths = np.array([member.depths_covered for member in members])
        return cls(
            time=np.array([max(member.time[0] for member in members), min(member.time[-1] for member in members)]),
            depth=np.array([depths[:, 0].max(), depths[:, 1].min()]),
            members=tuple(members),
            names=tuple(names),
            weights=np.asarray(weights, dtype=float) / float(np.sum(weights)),
        )

    def drawn(self, normals: Array) -> "Ensemble":
        """Return it with a member for each trial, from standard normals of shape (n,)."""
        if self.given is not None:
            return replace(self, chosen=np.full(normals.size, self.given, dtype=np.intp))
        return replace(
            self, chosen=np.searchsorted(np.cumsum(self.weights)[:-1], scipy.special.ndtr(normals), side="right")
        )

    @property
    @override
    def depths_covered(self) -> tuple[float, float]:
        """Least and greatest depth at which all members are good [m]."""
        return float(self.depth[0]), float(self.depth[1])

    @override
    def velocity(self, t: Scalars, depth: Scalars, position: Array) -> Array:
        return self._of_members("velocity", t, depth, position)

    @override
    def mean_velocity(self, t: Scalars, duration: Scalars, depth: Scalars, start: Array, through: Array) -> Array:
        return self._of_members("mean_velocity", t, duration, depth, start, through)

    @override
    def covers(self, span: Span) -> NDArray[np.bool_]:
        if self.chosen is None:
            return np.asarray(np.all(np.broadcast_arrays(*(member.covers(span) for member in self.members)), axis=0))
        covered = np.zeros(self.chosen.size, dtype=bool)
        for number, trials in self._trials():
            part = [
                _part(value, trials, self.chosen.size) for value in (span.start, span.end, span.depth, *span.places)
            ]
            covered[trials] = self.members[number].covers(Span(part[0], part[1], part[2], tuple(part[3:])))
        return covered

    @override
    def later(self, seconds: float) -> "Ensemble":
        return replace(super().later(seconds), members=tuple(member.later(seconds) for member in self.members))

    @property
    @override
    def steady_for(self) -> float:
        return min(member.steady_for for member in self.members)

    @override
    def take(self, trials: NDArray[np.intp]) -> "Ensemble":
        return self if self.chosen is None else replace(self, chosen=self.chosen[trials])

    def _of_members(self, method: str, *arguments: Scalars) -> Array:
        """Call a method of the members: of each trial's own, or of all for their weighted mean."""
        if self.chosen is None:
            velocities = [getattr(member, method)(*arguments) for member in self.members]
            return np.asarray(sum(weight * velocity for weight, velocity in zip(self.weights, velocities, strict=True)))
        if self.chosen.size == 1:
            return np.asarray(getattr(self.members[int(self.chosen[0])], method)(*arguments))
        velocity = np.zeros((2, self.chosen.size))
        for number, trials in self._trials():
            part = [_part(value, trials, self.chosen.size) for value in arguments]
            velocity[:, trials] = getattr(self.members[number], method)(*part)
        return velocity

    def _trials(self) -> list[tuple[int, NDArray[np.intp]]]:
        return [
            (number, trials)
            for number in range(len(self.members))
            if (trials := np.flatnonzero(self.chosen == number)).size
        ]


def _part(value: Scalars, trials: NDArray[np.intp], size: int) -> Array:
    """Values of some of the trials; what is the same for all stays."""
    array = np.asarray(value, dtype=float)
    return array[..., trials] if array.ndim and array.shape[-1] == size else array


WAVES = 16
"""Waves of each trial. Their frequencies are stratified, which keeps sums over long times close to normal."""
NORMALS = 8
"""Standard normals for each wave."""
_STRIDE = 5
"""Between the strata of frequency and wavenumber; shares no factor with `WAVES`."""


class Statistics(NamedTuple):
    """Standard deviation on each axis [m/s], correlation time [s] and length [m]; no length: the same everywhere."""

    sigma: Scalars
    time: Scalars
    length: Scalars | None


@dataclass(frozen=True)
class ErrorWaves:
    """The error of each trial as plane waves."""

    rate: Array
    """Angular frequency, shape (m, n) [rad/s]."""
    number: Array | None
    """Wavenumber toward east and north [rad/m]; None where the error is the same everywhere; shape (2, m, n)."""
    cosine: Array
    sine: Array
    """Shape (2, m, n). Amplitudes toward east and north [m/s]."""

    @classmethod
    def drawn(cls, statistics: Statistics, normals: Array) -> "ErrorWaves":
        """Draw them from standard normals of shape (`NORMALS`, `WAVES`, n)."""
        size = np.asarray(statistics.sigma) / np.sqrt(WAVES)
        within, farther, heading, shift = scipy.special.ndtr(normals[4:])
        stratum = np.arange(WAVES)[:, None]
        rate = np.tan(0.5 * np.pi * (stratum + within) / WAVES) / statistics.time
        number = None
        if statistics.length is not None:
            # each stratum of frequency meets each of wavenumber equally often over the trials
            other = (_STRIDE * stratum + np.floor(WAVES * shift[:1])) % WAVES
            beyond = 1.0 - (other + farther) / WAVES
            wavenumber = np.sqrt(np.maximum(beyond**-2.0 - 1.0, 0.0)) / statistics.length
            angle = 2.0 * np.pi * heading
            number = wavenumber * np.stack((np.cos(angle), np.sin(angle)))
        return cls(rate, number, size * normals[:2], size * normals[2:4])

    def at(self, t: Scalars, position: Array) -> Array:
        """Error at a moment and place, shape (2, n) [m/s]."""
        return self._sum(self._phase(t, position), None)

    def mean(self, t: Scalars, duration: Scalars, start: Array, displacement: Array) -> Array:
        """Mean error along a straight track that is travelled at a steady speed, shape (2, n) [m/s].

        Parameters
        ----------
        t, duration : float or array, shape (n,)
            [s]
        start, displacement : array, shape (2, n)
            [m]
        """
        half = 0.5 * self._phase(duration, displacement)
        middle = self._phase(np.asarray(t) + 0.5 * np.asarray(duration), start + 0.5 * displacement)
        return self._sum(middle, np.sinc(half / np.pi))

    def take(self, trials: NDArray[np.intp]) -> "ErrorWaves":
        """Select trials."""
        number = None if self.number is None else self.number[..., trials]
        return ErrorWaves(self.rate[:, trials], number, self.cosine[..., trials], self.sine[..., trials])

    def _phase(self, t: Scalars, position: Array) -> Array:
        phase: Array = self.rate * t
        if self.number is not None:
            phase = phase + self.number[0] * position[0] + self.number[1] * position[1]
        return phase

    def _sum(self, phase: Array, weight: Array | None) -> Array:
        cosine, sine = np.cos(phase), np.sin(phase)
        if weight is not None:
            cosine, sine = cosine * weight, sine * weight
        waves = self.cosine * cosine
        waves += self.sine * sine
        return np.asarray(np.sum(waves, axis=1))


@dataclass(frozen=True)
class ErringCurrent(Current):
    """A forecast and, trial by trial, its error."""

    forecast: Current
    error: ErrorWaves

    @override
    def velocity(self, t: Scalars, depth: Scalars, position: Array) -> Array:
        return self.forecast.velocity(t, depth, position) + self.error.at(t, position)

    @override
    def mean_velocity(self, t: Scalars, duration: Scalars, depth: Scalars, start: Array, through: Array) -> Array:
        forecast = self.forecast.mean_velocity(t, duration, depth, start, through)
        return forecast + self.error.mean(t, duration, start, through + forecast * duration)

    @override
    def take(self, trials: NDArray[np.intp]) -> "ErringCurrent":
        return ErringCurrent(self.forecast.take(trials), self.error.take(trials))

    @override
    def covers(self, span: Span) -> NDArray[np.bool_]:
        return self.forecast.covers(span)

    @property
    @override
    def steady_for(self) -> float:
        return self.forecast.steady_for

    @property
    @override
    def is_binding(self) -> bool:
        return self.forecast.is_binding

    @property
    @override
    def is_record(self) -> bool:
        return self.forecast.is_record
