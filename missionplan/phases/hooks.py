"""Hooks by which effects act on the phases: base classes without any effect, which the catalogue's effects refine.

An effect is a frozen data class whose fields are its parameters, floats or arrays over trials, in SI units; at zero
strength it is neutral. A phase is given a tuple of effects and combines their hooks: velocities, lifts, delays and
variances add, factors multiply. Parameters as arrays let each trial of one call be a Jacobian column, a starting
point or a dive of its own.

The state in which one phase leaves a block of trials, and from which the next one starts.
"""

from collections.abc import Iterable, Mapping
from copy import copy
from dataclasses import dataclass, field
from math import inf
from typing import Protocol, Self, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array, Scalars, take_trials


@dataclass(frozen=True)
class Leg:
    """The legs under way, one per trial, as an effect on a transit sees them."""

    t_start: Array
    duration: Array
    """Shape (n,). Start of the leg since the mission's start, and its planned length [s]."""
    start: Array
    """True position at the start, east and north of the coordinates' origin, shape (2, n) [m]."""
    along: Array
    """Unit vector of the course steered (east, north), shape (2, n)."""
    speed: Scalars
    """Speed through the water, shape (n,) [m/s]."""
    latitude: float = float("nan")
    """Of the coordinates' origin [rad]; nan when the mission has none."""
    depth: Scalars = float("nan")
    """Shape (n,). Mean depth under way [m]; nan where it is not known."""

    @property
    def through_water(self) -> NDArray[np.complex128]:
        """Velocity through the water as complex numbers, east + i north, shape (n,) [m/s]."""
        return np.asarray(self.speed * (self.along[0] + 1j * self.along[1]))

    def share_after(self, moment: Scalars) -> Array:
        """Share of each leg that comes after a moment, shape (n,); 0 of one that takes no time."""
        after = np.clip(self.t_start + self.duration - moment, 0.0, self.duration)
        return np.asarray(after / np.where(self.duration > 0.0, self.duration, 1.0))


@dataclass(frozen=True)
class DriftParts:
    """What an effect adds to the drift, as far as the filter of the drift estimates it (`transit.kalman_filter`)."""

    velocity: Array | float = 0.0
    """Steady velocity under way, shape (2,) or (2, n) [m/s]."""
    surface: Array | float = 0.0
    """Steady velocity at the surface, shape (2,) or (2, n) [m/s]."""
    waves: Mapping[float, Array] = field(default_factory=dict)
    """By period [s], coefficients of cos ωt and sin ωt toward east, then toward north, shape (4,) or (4, n) [m/s]."""
    inertial: Array | None = None
    """A and B of a current (A cos ft + B sin ft, B cos ft − A sin ft) that turns with the inertial frequency, shape
    (2,) or (2, n) [m/s]."""
    persistent: tuple[Scalars, Scalars] | None = None
    """Standard deviation [m/s] and correlation time [s] of an Ornstein–Uhlenbeck velocity; None: it has none."""
    walk: Scalars = 0.0
    """Growth of the steady velocity's deviation [m/s^1.5]."""
    modulation: tuple[Scalars, Scalars] = (0.0, 1.0)
    """Standard deviation of slow changes of the waves and of the turning current, relative to their amplitudes, and
    their e-folding time [s]."""


@runtime_checkable
class MarkovProcess(Protocol):
    """A velocity error that is a Markov process in time, the same on both axes and independent between them."""

    def transition(self, elapsed: Array) -> tuple[Array, Array]:
        """Share of the velocity that is kept over a time [s], and the variance that is added [m²/s²]."""
        ...

    @property
    def first_variance(self) -> Scalars:
        """Variance where a run begins [m²/s²]."""
        ...

    def mean_over(self, duration: Array) -> tuple[Array, Array]:
        """Mean over a time [s] given the values at its ends: the share of their sum, and its variance [m²/s²]."""
        ...


@runtime_checkable
class Selectable(Protocol):
    """What an effect may hold that has trials of its own, as a current has."""

    def take(self, trials: NDArray[np.intp]) -> "Selectable":
        """Select trials."""
        ...


class TransitEffect:
    """An effect on a transit. A hook that the effect does not refine returns its neutral element."""

    def velocity(self, leg: Leg) -> Array | float:
        """Mean velocity error over the leg, unknown to the vehicle, shape (2, n) [m/s]."""
        return 0.0

    def course_factor(self, leg: Leg) -> NDArray[np.complex128] | Scalars:
        """Factor on the velocity through the water, complex as `Leg.through_water`, shape (n,)."""
        return 1.0

    @property
    def changes_course(self) -> bool:
        """Whether the effect refines `course_factor`."""
        return type(self).course_factor is not TransitEffect.course_factor

    def answer_to_current(self, leg: Leg, water: Array) -> Array | float:
        """Velocity error because the vehicle answers to a current otherwise than by going with it, shape (2, n) [m/s].

        `water` is the velocity of the water on each leg, of the site's current and of all effects' `velocity` but
        those of effects that refine this hook, shape (2, n) [m/s].
        """
        return 0.0

    @property
    def answers_current(self) -> bool:
        """Whether the effect refines `answer_to_current`."""
        return type(self).answer_to_current is not TransitEffect.answer_to_current

    def surface_velocity(self, t: Array, duration: Array, position: Array) -> Array | float:
        """Drift velocity at the surface beyond the site's current, shape (2, n) [m/s]."""
        return 0.0

    def fix_variance(self) -> Scalars:
        """Extra variance of a fix, each axis [m²]."""
        return 0.0

    def position_variance_rate(self) -> Scalars:
        """Growth of the variance of the position error under way, each axis, independent of everything else [m²/s].

        An effect that refines it is random.
        """
        return 0.0

    def tail_dof(self) -> Scalars:
        """Degrees of freedom of a Student-t velocity error that is independent from leg to leg; infinite: normal."""
        return inf

    def error_scale(self, normals: Array) -> Array | float:
        """Factor on the leg's random velocity error, from standard normals of shape (2, n)."""
        return 1.0

    def drift(self) -> DriftParts:
        """What a filter of the drift may estimate of it; none: the filter does not know of the effect."""
        return DriftParts()

    @property
    def is_random(self) -> bool:
        """Whether `step`, `error_scale` or `position_variance_rate` needs standard normals for each leg."""
        return False

    def take(self, trials: NDArray[np.intp], count: int) -> Self:
        """Select some of `count` trials: of whatever has a value for each of them."""
        taken = copy(self)
        for name, value in vars(self).items():
            if isinstance(value, np.ndarray) and value.ndim and value.shape[-1] == count:
                vars(taken)[name] = value[..., trials]
            elif not isinstance(value, np.generic | np.ndarray) and isinstance(value, Selectable):
                vars(taken)[name] = value.take(trials)
        return taken

    def step(
        self, memory: Array | None, elapsed: Array, normals: Array, leg: Leg
    ) -> tuple[Array | None, Array | float]:
        """Advance a random velocity from leg to leg.

        Parameters
        ----------
        memory : array or None
            As the last call returned it; None before the first leg.
        elapsed : array, shape (n,)
            Time from the middle of the previous leg to the middle of this one [s].
        normals : array, shape (2, n)
            Standard normals of this effect for this leg.

        Returns
        -------
        memory, velocity : array or None, array of shape (2, n)
            Memory for the next leg (trials last), and this leg's velocity error [m/s].
        """
        return memory, 0.0


def velocity_error(effects: Iterable[TransitEffect], leg: Leg, current: Array | float = 0.0) -> Array:
    """Combine the effects' mean velocity errors: factors on the velocity through the water multiply, velocities add.

    Parameters
    ----------
    leg : Leg
        n legs.
    current : array, shape (2, n), or float
        The site's current on each leg, to which the vehicle may answer [m/s].

    Returns
    -------
    array, shape (2, n)
        [m/s]
    """
    factor = np.ones(leg.along.shape[1], dtype=complex)
    velocity, answer = np.zeros(leg.along.shape), np.zeros(leg.along.shape)
    answering: list[TransitEffect] = []
    for effect in effects:
        factor = factor * effect.course_factor(leg)
        if effect.answers_current:
            answering.append(effect)
            answer = answer + effect.velocity(leg)
        else:
            velocity = velocity + effect.velocity(leg)
    for effect in answering:
        answer = answer + effect.answer_to_current(leg, current + velocity)
    changed = (factor - 1.0) * leg.through_water
    return velocity + answer + np.stack([changed.real, changed.imag])


def surface_velocity(effects: Iterable[TransitEffect], t: Array, duration: Array, position: Array) -> Array:
    """Sum of the effects' drift velocities at the surface, beyond the site's current, shape (2, n) [m/s].

    Parameters
    ----------
    t, duration : array, shape (n,)
        Start of the time at the surface since the mission's start, and its length [s].
    position : array, shape (2, n)
        East and north of the coordinates' origin [m].
    """
    velocity = np.zeros((2, t.size))
    for effect in effects:
        velocity = velocity + effect.surface_velocity(t, duration, position)
    return velocity


class DescentEffect:
    """An effect on a descent. A hook that the effect does not refine returns its neutral element.

    Times count from the anchor's separation unless stated otherwise; depth is that of the vehicle's nose [m].
    """

    def refines(self, hook: str) -> bool:
        """Whether the effect refines the hook of this name."""
        return getattr(type(self), hook) is not getattr(DescentEffect, hook)

    def lone_drag_factor(self) -> Scalars:
        """Factor on the anchor's drag while it falls alone."""
        return 1.0

    def drag_factor(self, since_taut: Scalars, speed: Scalars) -> Scalars:
        """Factor on both bodies' drag once the line is taut; speed through the water [m/s]."""
        return 1.0

    def local_drag_factor(self, depth: Scalars, line_length: Scalars) -> Scalars:
        """Factor on both bodies' drag once the line is taut, at a depth and on a line of a length [m]."""
        return 1.0

    def wet_weight_factor(self, since_separation: Scalars) -> Scalars:
        """Factor on the anchor's wet weight."""
        return 1.0

    def lift(self, depth: Scalars) -> Scalars:
        """Upward force on the vehicle once the line is taut [N]."""
        return 0.0

    def mass_factor(self) -> Scalars:
        """Factor on the joint mass, added masses included, in the snatch too."""
        return 1.0

    def water_velocity(self) -> Scalars:
        """Downward velocity of the water around the vehicle once the line is taut [m/s]."""
        return 0.0

    def delay(self, line_length: Scalars) -> Scalars:
        """Delay, on the clock of the log, of everything after the separation [s]."""
        return 0.0

    def reading(self, t: Array, depth: Array) -> Array:
        """Depth that the sensor reads, from the true depth on the same uniform time grid (trials last) [m]."""
        return depth


@dataclass(frozen=True)
class TrialState:
    """State of a block of trials between two phases."""

    position: Array
    """True position, east and north of the coordinates' origin, shape (2, n) [m]."""
    fix: Array
    """Last fix: where the vehicle believes that it is, shape (2, n) [m]."""
    clock: Array
    """Time since the mission's start, shape (n,) [s]."""
    energy: Array
    """Used so far, shape (n,) [J]."""
    alive: NDArray[np.bool_]
    """Whether the trial goes on: it has arrived at every goal and surfaced from every mooring so far, shape (n,)."""

    @property
    def trials(self) -> int:
        """Number of trials."""
        return self.clock.size

    def take(self, trials: NDArray[np.intp]) -> "TrialState":
        """Select trials; one may be selected several times."""
        return take_trials(self, trials)

    @classmethod
    def at(cls, position: Array, trials: int, fix_noise: Array | float = 0.0) -> "TrialState":
        """State at deployment.

        Parameters
        ----------
        position : array, shape (2,) or (2, n)
            Of the deployment [m].
        fix_noise : array, shape (2, n)
            Error of the fix before the first dive [m].
        """
        column = position[:, None] if position.ndim == 1 else position
        true = np.array(np.broadcast_to(column, (2, trials)), dtype=float)
        return cls(true, true + fix_noise, np.zeros(trials), np.zeros(trials), np.ones(trials, dtype=bool))
