"""Currents from records: what all have in common, and a series against time and depth; `gridded_current` has grids.

Beyond a record's times, depths and places its value at the end is held, or there is no current, as `outside` says;
`covers` tells which trials stay within it.

A tidal current at one place: a mean and waves at some depths, linear between them; it has no end in time.
"""

from bisect import bisect_right
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from missionplan.arrays import Array, Scalars
from missionplan.phases.currents import Current, Span

Outside = Literal["error", "hold", "zero"]
"""Beyond a record: held, and the trial fails; held; or no current."""

DEPTH_MARGIN = 5.0
DEPTH_SHARE = 0.2
"""By which a record is good above and below its depths: 5 m, or this share of its depth. An acoustic profiler loses
the lowest 6 to 15 % to side lobes, and the top few metres."""


@dataclass(frozen=True)
class RecordedCurrent(Current):
    """A current that is known at some times and depths."""

    time: Array
    depth: Array
    """Shapes (k,) and (m,). Increasing [s since the mission's start, m]."""
    outside: Outside = field(default="hold", kw_only=True)
    """What is beyond the record."""

    @property
    @override
    def is_record(self) -> bool:
        return True

    @property
    @override
    def is_binding(self) -> bool:
        return self.outside == "error"

    @override
    def covers(self, span: Span) -> NDArray[np.bool_]:
        low, high = self.depths_covered
        in_time = (self.time[0] <= np.asarray(span.start)) & (np.asarray(span.end) <= self.time[-1])
        return np.atleast_1d(in_time & (low <= np.asarray(span.depth)) & (np.asarray(span.depth) <= high))

    @property
    def depths_covered(self) -> tuple[float, float]:
        """Least and greatest depth at which the record is good [m]."""
        margins = np.maximum(DEPTH_MARGIN, DEPTH_SHARE * self.depth[[0, -1]])
        return float(self.depth[0] - margins[0]), float(self.depth[-1] + margins[1])

    def later(self, seconds: float) -> Self:
        """Return it as a mission meets it that starts so much later [s]."""
        return replace(self, time=self.time - seconds)

    def _known(self, t: Scalars, depth: Scalars, position: Array) -> Array | float:
        """Factor on a velocity: 0 where there is none beyond the record, else 1."""
        if self.outside != "zero":
            return 1.0
        return self.covers(Span(t, t, depth, (position,))).astype(float)


@dataclass(frozen=True)
class SeriesCurrent(RecordedCurrent):
    """A current against time and depth, linear in both between the samples."""

    east: Array
    north: Array
    """Shape (k, m). [m/s]."""

    @cached_property
    def _values(self) -> NDArray[np.complex128]:
        return _complex(self.east, self.north)

    @override
    def velocity(self, t: Scalars, depth: Scalars, position: Array) -> Array:
        inside = _interpolated((self.time, self.depth), self._values, (t, depth))
        return inside * self._known(t, depth, position)

    @override
    def mean_velocity(self, t: Scalars, duration: Scalars, depth: Scalars, start: Array, through: Array) -> Array:
        lasting = np.asarray(duration) > 0.0
        seconds = np.where(lasting, duration, 1.0)
        mean = (self._travel(t + seconds, depth) - self._travel(t, depth)) / seconds
        mean = mean * self._known(self.time[0], depth, start)
        return np.where(lasting, mean, self.velocity(t, depth, start))

    def _travel(self, t: Scalars, depth: Scalars) -> Array:
        """Integral of the velocity from the first sample to `t`, exact for the piecewise linear series [m]."""
        values = np.stack((self.east, self.north))
        steps = 0.5 * (values[:, 1:] + values[:, :-1]) * np.diff(self.time)[:, None]
        travelled = np.concatenate((np.zeros((2, 1, len(self.depth))), np.cumsum(steps, axis=1)), axis=1)
        time = np.clip(t, self.time[0], self.time[-1])
        before = np.asarray(bracket(self.time, time).low)
        nodes = np.arange(len(self.time), dtype=float)
        to_node = _interpolated((nodes, self.depth), _complex(*travelled), (before.astype(float), depth))
        start, end = (self.velocity(moment, depth, np.zeros((2, 1))) for moment in (self.time[before], time))
        inside = to_node + 0.5 * (start + end) * (time - self.time[before])
        return np.asarray(inside if self.outside == "zero" else inside + end * (t - time))


class Bracket(NamedTuple):
    """Nodes on either side of points on an axis, and the weight of the second; numbers where there is one point."""

    low: NDArray[np.intp] | int
    high: NDArray[np.intp] | int
    share: Scalars


def bracket(axis: Array, x: Scalars, step: float | None = None) -> Bracket:
    """Find the nodes on either side of `x`, which is held at the axis' ends.

    Parameters
    ----------
    axis : array, shape (m,)
    x : float or array, shape (n,)
    step : float, optional
        The axis' `even_step`, with which nodes are counted; where a count is off by one, all are searched for.
    """
    last = len(axis) - 1
    if np.size(x) == 1:
        point = min(max(float(np.reshape(x, ())), float(axis[0])), float(axis[-1]))
        at = min(max(bisect_right(axis, point) - 1, 0), max(last - 1, 0))
        after = min(at + 1, last)
        return Bracket(at, after, (point - axis[at]) / (axis[after] - axis[at] if after > at else 1.0))
    within = np.minimum(np.maximum(x, axis[0]), axis[-1])
    if step is not None:
        low = np.minimum(((within - axis[0]) * (1.0 / step)).astype(np.intp), last - 1)
        high, before = low + 1, axis.take(low)
        share = (within - before) / (axis.take(high) - before)
        if share.size and share.min() >= 0.0 and share.max() < 1.0:
            return Bracket(low, high, share)
    low = np.minimum(np.searchsorted(axis, within, side="right") - 1, max(last - 1, 0))
    high = np.minimum(low + 1, last)
    before = axis.take(low)
    width = axis.take(high) - before
    return Bracket(low, high, (within - before) / (width if last else 1.0))


def even_step(axis: Array) -> float | None:
    """Mean distance of an axis' nodes where each is within 1e-5 of it from even spacing; otherwise None."""
    if len(axis) < 2:
        return None
    step = float(axis[-1] - axis[0]) / (len(axis) - 1)
    off = np.abs(axis - axis[0] - step * np.arange(len(axis)))
    return step if float(np.max(off)) <= 1e-5 * step else None


def _interpolated(axes: tuple[Array, ...], values: NDArray[np.complex128], point: tuple[Scalars, ...]) -> Array:
    """Interpolate linearly in every axis; returns shape (2, n), or (2, 1) at one point.

    Parameters
    ----------
    values : array, shape (axis, ...)
        East, and north as the imaginary part, so that a node is looked up once.
    point : tuple of float or array, shape (n,)
    """
    corners: list[tuple[NDArray[np.intp] | int, Scalars]] = [(0, 1.0)]
    for axis, x in zip(axes, point, strict=True):
        low, high, share = bracket(axis, x)
        sides = [side for side in ((low, 1.0 - share), (high, share)) if np.ndim(share) or side[1]]
        corners = [(index * len(axis) + node, weight * part) for index, weight in corners for node, part in sides]
    flat = values.reshape(-1)
    total = sum((flat.take(index) * weight for index, weight in corners), start=np.zeros(1, dtype=complex))
    return np.stack((total.real, total.imag))


def _complex(east: Array, north: Array) -> NDArray[np.complex128]:
    """Return vectors as complex numbers."""
    values = np.empty(east.shape, dtype=complex)
    values.real, values.imag = east, north
    return values


EVER = np.array([-np.inf, np.inf])
"""The times of a current that has no end [s]."""


@dataclass(frozen=True)
class TidalStream(RecordedCurrent):
    """A mean current and waves ``C·cos(ωt) + S·sin(ωt)``, the same at every place; `time` is `EVER`."""

    mean: Array
    """East and north at each depth, shape (2, m) [m/s]."""
    frequency: Array
    """ω, shape (k,) [rad/s]."""
    cosine: Array
    sine: Array
    """Shape (2, k, m). C and S, east and north at each depth [m/s]."""

    @override
    def velocity(self, t: Scalars, depth: Scalars, position: Array) -> Array:
        return self._average(t, 0.0, depth) * self._known(0.0, depth, position)

    @override
    def mean_velocity(self, t: Scalars, duration: Scalars, depth: Scalars, start: Array, through: Array) -> Array:
        return self._average(t, duration, depth) * self._known(0.0, depth, start)

    def _average(self, t: Scalars, duration: Scalars, depth: Scalars) -> Array:
        """Mean over a time, exact: a wave's is its value at the middle, times sin(x)/x with x = ω·duration/2."""
        at = np.atleast_1d(depth)
        share = np.stack([np.interp(at, self.depth, node) for node in np.eye(len(self.depth))])
        middle = self.frequency[:, None] * (np.asarray(t) + 0.5 * np.asarray(duration))
        kept = np.sinc(self.frequency[:, None] * np.asarray(duration) / (2.0 * np.pi))
        waves = (self.cosine @ share) * np.cos(middle) + (self.sine @ share) * np.sin(middle)
        return np.asarray(self.mean @ share + np.sum(waves * kept, axis=1))
