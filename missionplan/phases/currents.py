"""Currents that carry the vehicle: layers, a series against time and depth, a field against time, depth and place.

A velocity comes as an array whose shape broadcasts to ``(2, n)``: east and north, trials last. Times beyond a
record's ends take the value at the end, and so do depths and places beyond its grid.
"""

import itertools
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt
from typing_extensions import override

from missionplan.arrays import Array, Scalars
from missionplan.errors import InputError

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(5)


class Current(ABC):
    """Velocity of the water over the ground."""

    @abstractmethod
    def velocity(self, t: Scalars, depth: Scalars, position: Array) -> Array:
        """Velocity at a moment and place.

        Parameters
        ----------
        t : float or array, shape (n,)
            Since the mission's start [s].
        depth : float or array, shape (n,)
            Below the surface [m].
        position : array, shape (2, n)
            East and north of the coordinates' origin [m].

        Returns
        -------
        array, shape broadcasting to (2, n)
            [m/s]
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


@dataclass(frozen=True)
class LayeredCurrent(Current):
    """Layers of constant velocity from the surface down (Briggs et al., Eq. 1); the deepest has no lower end.

    Attributes
    ----------
    down_to : array, shape (k,) or (k, n)
        Lower ends of the layers, increasing: one per layer, or one per layer and trial [m].
    east, north : array, shape (k,) or (k, n)
        One velocity per layer, or one per layer and trial [m/s].
    """

    down_to: Array
    east: Array
    north: Array

    @override
    def velocity(self, t: Scalars, depth: Scalars, position: Array) -> Array:
        east, north = self.east[-1], self.north[-1]
        for index in range(len(self.down_to) - 2, -1, -1):
            inside = depth <= self.down_to[index]
            east = np.where(inside, self.east[index], east)
            north = np.where(inside, self.north[index], north)
        chosen = np.stack((east, north))
        return chosen if chosen.ndim == 2 else chosen[:, None]

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
    east = _stacked([each * np.sin(course) for each, course in pairs])
    north = _stacked([each * np.cos(course) for each, course in pairs])
    return LayeredCurrent(_stacked(down_to), east, north)


def _stacked(values: Sequence[Scalars]) -> Array:
    return np.stack(np.broadcast_arrays(*(np.asarray(value, dtype=float) for value in values)))


@dataclass(frozen=True)
class SeriesCurrent(Current):
    """A current against time and depth, linear in both between the samples.

    Attributes
    ----------
    time, depth : array, shapes (k,) and (m,)
        Increasing [s since the mission's start, m].
    east, north : array, shape (k, m)
        [m/s]
    """

    time: Array
    depth: Array
    east: Array
    north: Array

    @override
    def velocity(self, t: Scalars, depth: Scalars, position: Array) -> Array:
        return _interpolated((self.time, self.depth), np.stack((self.east, self.north)), (t, depth))

    @override
    def mean_velocity(self, t: Scalars, duration: Scalars, depth: Scalars, start: Array, through: Array) -> Array:
        lasting = np.asarray(duration) > 0.0
        seconds = np.where(lasting, duration, 1.0)
        mean = (self._travel(t + seconds, depth) - self._travel(t, depth)) / seconds
        return np.where(lasting, mean, self.velocity(t, depth, start))

    def _travel(self, t: Scalars, depth: Scalars) -> Array:
        """Integral of the velocity from the first sample to `t`, exact for the piecewise linear series [m]."""
        values = np.stack((self.east, self.north))
        steps = 0.5 * (values[:, 1:] + values[:, :-1]) * np.diff(self.time)[:, None]
        travelled = np.concatenate((np.zeros((2, 1, len(self.depth))), np.cumsum(steps, axis=1)), axis=1)
        held = np.clip(t, self.time[0], self.time[-1])
        before, _, _ = _bracket(self.time, held)
        nodes = np.arange(len(self.time), dtype=float)
        to_node = _interpolated((nodes, self.depth), travelled, (before.astype(float), depth))
        start, end = (self.velocity(moment, depth, np.zeros((2, 1))) for moment in (self.time[before], held))
        return to_node + 0.5 * (start + end) * (held - self.time[before]) + end * (t - held)


@dataclass(frozen=True)
class FieldCurrent(Current):
    """A current against time, depth and place, linear in each between the nodes; without nan, see `fill_gaps`.

    Attributes
    ----------
    time, depth, north_axis, east_axis : array
        Increasing [s since the mission's start, m, m, m].
    east, north : array, shape (time, depth, north, east)
        [m/s]
    """

    time: Array
    depth: Array
    north_axis: Array
    east_axis: Array
    east: Array
    north: Array

    @override
    def velocity(self, t: Scalars, depth: Scalars, position: Array) -> Array:
        axes = (self.time, self.depth, self.north_axis, self.east_axis)
        return _interpolated(axes, np.stack((self.east, self.north)), (t, depth, position[1], position[0]))


def fill_gaps(values: Array) -> Array:
    """Fill nodes without a value (land, below the seafloor) from the nearest node that has one, time by time.

    A step in depth counts as a hundredth of a horizontal one, so that nodes below the seafloor take the value above.

    Parameters
    ----------
    values : array, shape (time, depth, north, east)
        nan where there is no value.

    Raises
    ------
    InputError
        When there is no value at all at some time.
    """
    result = np.array(values, dtype=float)
    for at_one_time in result:
        missing = np.isnan(at_one_time)
        if missing.all():
            raise InputError("the current field has a time without any value")
        if missing.any():
            nearest = distance_transform_edt(
                missing, sampling=(0.01, 1.0, 1.0), return_distances=False, return_indices=True
            )
            at_one_time[...] = at_one_time[tuple(nearest)]
    return result


def _bracket(axis: Array, x: Scalars) -> tuple[NDArray[np.intp], NDArray[np.intp], Array]:
    """Find the nodes on either side of `x`, which is held at the axis' ends, and the weight of the second."""
    held = np.clip(x, axis[0], axis[-1])
    low = np.clip(np.searchsorted(axis, held, side="right") - 1, 0, max(len(axis) - 2, 0))
    high = np.minimum(low + 1, len(axis) - 1)
    width = np.where(high > low, axis[high] - axis[low], 1.0)
    return np.asarray(low), np.asarray(high), (held - axis[low]) / width


def _interpolated(axes: tuple[Array, ...], values: Array, point: tuple[Scalars, ...]) -> Array:
    """Interpolate linearly in every axis; `values` has shape (2, axis, ...); returns (2, n), or (2, 1) at one point."""
    brackets = [_bracket(axis, x) for axis, x in zip(axes, point, strict=True)]
    total: Array = np.zeros((2, 1))
    for corner in itertools.product((0, 1), repeat=len(axes)):
        weight: Array = np.ones(1)
        for (_, _, share), side in zip(brackets, corner, strict=True):
            weight = weight * (share if side else 1.0 - share)
        nodes = np.broadcast_arrays(*(bracket[side] for bracket, side in zip(brackets, corner, strict=True)))
        at = tuple(np.atleast_1d(node) for node in nodes)
        total = total + np.stack([component[at] for component in values]) * weight
    return total
