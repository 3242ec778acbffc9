"""Currents that carry the vehicle: what all have in common, and layers; `recorded_currents` has those from files.

A velocity comes as an array whose shape broadcasts to ``(2, n)``: east and north, trials last.

The wind's part in the drift of a vehicle afloat.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from missionplan.arrays import Array, Scalars
from missionplan.phases.hooks import TransitEffect

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(5)


@dataclass(frozen=True)
class Span:
    """What part of a current a leg, a surfacing or a dive needs; arrays over trials."""

    start: Scalars
    end: Scalars
    """Shape (n,). Times since the mission's start [s]."""
    depth: Scalars
    """Deepest, float or shape (n,) [m]."""
    places: tuple[Array, ...]
    """Where it begins and ends, shape (2, n) [m]."""


class Current(ABC):
    """Velocity of the water over the ground."""

    @abstractmethod
    def velocity(self, t: Scalars, depth: Scalars, position: Array) -> Array:
        """Velocity at a moment and place, shape broadcasting to (2, n) [m/s].

        Parameters
        ----------
        t : float or array, shape (n,)
            Since the mission's start [s].
        depth : float or array, shape (n,)
            Below the surface [m].
        position : array, shape (2, n)
            East and north of the coordinates' origin [m].
        """

    def mean_velocity(self, t: Scalars, duration: Scalars, depth: Scalars, start: Array, through: Array) -> Array:
        """Mean velocity along a leg.

        Parameters
        ----------
        t, duration : float or array, shape (n,)
            Start of the leg and its length in time [s].
        depth : float or array, shape (n,)
            [m]
        start, through : array, shape (2, n)
            True position at the start, and the displacement through the water [m].

        Returns
        -------
        array, shape broadcasting to (2, n)
            [m/s]. By 5-point Gauss–Legendre quadrature along the track over the ground, in two passes: along the
            straight track, then along the track that the mean velocity of the first pass gives.
        """
        mean = np.zeros((2, 1))
        for _ in range(2):
            over_ground = through + mean * duration
            mean = sum(
                (
                    0.5 * weight * self.velocity(t + share * duration, depth, start + share * over_ground)
                    for share, weight in zip(0.5 * (_NODES + 1.0), _WEIGHTS, strict=True)
                ),
                start=np.zeros((2, 1)),
            )
        return mean

    def take(self, trials: NDArray[np.intp]) -> Self:
        """Select trials; a current that is the same for all of them returns itself."""
        return self

    def covers(self, span: Span) -> NDArray[np.bool_]:
        """Whether the current is known there, shape broadcasting to (n,); everywhere unless it is a record."""
        return np.ones(1, dtype=bool)

    @property
    def is_record(self) -> bool:
        """Whether it is known at some times, depths or places alone."""
        return False

    @property
    def steady_for(self) -> float:
        """Longest time for which bodies that sink or rise take the water about them as steady [s]; 0: for each step."""
        return 0.0

    @property
    def is_binding(self) -> bool:
        """Whether a trial that leaves what is known of the current fails."""
        return False


@dataclass(frozen=True)
class LayeredCurrent(Current):
    """Layers of constant velocity from the surface down (Briggs et al., Eq. 1); the deepest has no lower end."""

    down_to: Array
    """Lower ends of the layers, increasing: one per layer, or one per layer and trial; shape (k,) or (k, n) [m]."""
    east: Array
    north: Array
    """Shape (k,) or (k, n). One velocity per layer, or one per layer and trial [m/s]."""

    @override
    def velocity(self, t: Scalars, depth: Scalars, position: Array) -> Array:
        chosen: Array = self._velocities[-1]
        for index in range(len(self.down_to) - 2, -1, -1):
            chosen = np.where(depth <= self.down_to[index], self._velocities[index], chosen)
        return chosen

    @cached_property
    def _velocities(self) -> Array:
        """Shape (k, 2, n), or (k, 2, 1) of trials alike [m/s]."""
        return np.stack((self.east, self.north), axis=1).reshape(len(self.east), 2, -1)

    @override
    def mean_velocity(self, t: Scalars, duration: Scalars, depth: Scalars, start: Array, through: Array) -> Array:
        return self.velocity(t, depth, start)

    @override
    def take(self, trials: NDArray[np.intp]) -> "LayeredCurrent":
        parts = (self.down_to, self.east, self.north)
        return LayeredCurrent(*(part if part.ndim == 1 else part[:, trials] for part in parts))


def layers(down_to: Sequence[Scalars], speed: Sequence[Scalars], toward: Sequence[Scalars]) -> LayeredCurrent:
    """Build a layered current from speeds and the directions towards which the layers flow.

    Parameters
    ----------
    down_to : sequence of float or array, shape (n,)
        Lower ends of the layers [m].
    speed, toward : sequence of float or array, shape (n,)
        [m/s], and clockwise from north [rad].
    """
    pairs = list(zip(speed, toward, strict=True))
    east = _stacked([layer_speed * np.sin(course) for layer_speed, course in pairs])
    north = _stacked([layer_speed * np.cos(course) for layer_speed, course in pairs])
    return LayeredCurrent(_stacked(down_to), east, north)


def _stacked(values: Sequence[Scalars]) -> Array:
    return np.stack(np.broadcast_arrays(*(np.asarray(value, dtype=float) for value in values)))


def leeway_velocity(wind: Array, downwind: Scalars, crosswind: Scalars, along: Scalars, across: Scalars) -> Array:
    """Velocity through the water that the wind gives a body afloat, shape (2, n) [m/s].

    Allen and Plourde 1999 (USCG R&D Center, CG-D-08-99), as Breivik and Allen 2008 (J. Mar. Syst. 69, 99) use it: down
    the wind a share of its speed and a constant, across it a share, to one side. Measured for winds of 2 to 20 m/s.
    In a calm there is no direction down the wind, and no leeway.

    Parameters
    ----------
    wind : array, shape (2, n)
        Velocity of the air, 10 m above the sea, toward east and north [m/s].
    downwind, crosswind : float or array, shape (n,)
        Shares of the wind's speed; crosswind positive to the right of where the air moves.
    along, across : float or array, shape (n,)
        Velocities besides [m/s].
    """
    speed = np.hypot(wind[0], wind[1])
    blows = speed > 0.0
    east, north = np.where(blows, wind / np.where(blows, speed, 1.0), 0.0)
    down, right = downwind * speed + along, crosswind * speed + across
    return np.stack((down * east + right * north, down * north - right * east))


@dataclass(frozen=True)
class Leeway(TransitEffect):
    """Drift with the wind while at the surface."""

    wind: Current
    """Velocity of the air, 10 m above the sea."""
    downwind: Scalars
    crosswind: Scalars
    along: Scalars
    across: Scalars
    """Shape (n,). See `leeway_velocity`."""

    @override
    def surface_velocity(self, t: Array, duration: Array, position: Array) -> Array:
        air = self.wind.mean_velocity(t, duration, 0.0, position, np.zeros((2, 1)))
        air = np.broadcast_to(air, (2, np.size(t)))
        return leeway_velocity(air, self.downwind, self.crosswind, self.along, self.across)
