"""A current on the grid of an ocean model: linear in depth in each column of water, then across, then in time."""

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray
from typing_extensions import override

from missionplan.arrays import Array, Scalars
from missionplan.errors import InputError
from missionplan.phases.currents import Span
from missionplan.phases.grids import Columns, FieldWater, Grid, RegularGrid
from missionplan.phases.lattice import Cells, EvenAxes, Indices, Lattice, packed
from missionplan.phases.recorded_currents import Bracket, RecordedCurrent, bracket, even_step

Velocities = NDArray[np.complexfloating[Any]]
"""Toward east, and toward north as the imaginary part [m/s]."""
_DEPTHS_KEPT = 8
"""Depths at which the field across is kept: those of a mission's transits, and the surface."""
_MOST_PACKED = 4_000_000
"""Nodes of a field that is packed for faster look-ups; they take 32 bytes each."""
_STEADY = 1.0
"""Time for which dives take the water about them as steady [s]; in less than that a body sinks by a metre or two."""
LONGEST_STEP = 300.0
"""Of the integration along a leg [s]: 450 m at 1.5 m/s, about two cells of a model of an estuary."""


@dataclass(frozen=True)
class GriddedCurrent(RecordedCurrent):
    """A current against time and depth at columns of water; use `of`, which fills what has no value.

    Attributes
    ----------
    time, depth : array, shapes (t,) and (2,)
        Increasing [s since the mission's start]; the least and the greatest depth at which it is good [m].
    """

    grid: Grid
    """c columns."""
    levels: Array
    """Depths of the values below the surface of the moment, increasing: the same in all columns, or each its own; shape
    (d,) or (t, c, d) [m]."""
    values: Velocities
    """Toward east, and toward north as the imaginary part, shape (t, c, d) [m/s]."""
    wet: NDArray[np.bool_]
    """Where the model has water, shape (t, c)."""
    bottom: Array
    """Depth down to which each column is good, shape (c,) [m]."""
    _slices: dict[float, Array] = field(default_factory=dict, repr=False, compare=False)
    _packed: dict[float | None, Cells] = field(default_factory=dict, repr=False, compare=False)

    @classmethod
    def of(cls, time: Array, grid: Grid, levels: Array, values: Velocities, bottom: Array) -> "GriddedCurrent":
        """Build it from values that are nan where there is no water.

        Below its deepest value a column keeps that; a column without any takes those of the nearest that has some.
        Raises InputError when there is no value at all at some time.
        """
        values = _down_to_the_bottom(values)
        wet: NDArray[np.bool_] = np.isfinite(values)[:, :, 0]
        if not wet.any(axis=1).all():
            raise InputError("the current field has a time without any value in the mission's area")
        if not wet.all():
            values, levels = values.copy(), np.array(levels)
            nearest = _nearest_wet(wet, grid.points)
            for moment, source in enumerate(nearest):
                values[moment] = values[moment, source]
                if levels.ndim == 3:
                    levels[moment] = levels[moment, source]
            bottom = np.where(wet.any(axis=0), bottom, bottom[nearest[0]])
        depth = np.array([0.0 if levels.ndim == 3 else float(levels[0]), float(np.max(bottom))])
        return cls(time, depth, grid, levels, values, wet, bottom)

    @property
    @override
    def depths_covered(self) -> tuple[float, float]:
        """Least and greatest depth at which the field is good anywhere [m]."""
        return float(self.depth[0]), float(self.depth[1])

    @override
    def velocity(self, t: Scalars, depth: Scalars, position: Array) -> Array:
        place, lattice = self.grid.on_grid(np.asarray(position)), self._lattice(depth)
        if lattice is not None:
            velocity = lattice.velocity(t, depth, place)
            return velocity if self.outside != "zero" else velocity * self._known(t, depth, position)
        columns = self.grid.columns(place)
        low, high, share = bracket(self.time, t, self._time_step)
        shared = bracket(self.levels, depth) if self.levels.ndim == 1 and np.size(depth) > 1 else None
        velocity = np.zeros((2, 1))
        for moment, part in ((low, 1.0 - share), (high, share)):
            if np.ndim(part) or part:
                velocity = velocity + self._across(moment, columns, depth, shared) * part
        return velocity * self._known(t, depth, position)

    @override
    def mean_velocity(self, t: Scalars, duration: Scalars, depth: Scalars, start: Array, through: Array) -> Array:
        """Mean velocity along a leg, by Ralston's Runge–Kutta method of third order in steps of `LONGEST_STEP` at most.

        Ralston 1962, Math. Comp. 16, 431-437; parameters as in `Current.mean_velocity`.
        """
        lasting = np.asarray(duration, dtype=float)
        most = max(math.ceil(lasting.max(initial=0.0) / LONGEST_STEP), 1)
        steps = np.maximum(np.ceil(lasting / LONGEST_STEP), 1.0) if most > 1 else 1.0
        step = lasting / steps
        through_water = through / np.where(lasting > 0.0, lasting, np.inf)
        place, moment, total = start, np.asarray(t, dtype=float), np.zeros((2, 1))
        for number in range(most):
            first = self.velocity(moment, depth, place)
            second = self.velocity(moment + 0.5 * step, depth, place + (0.5 * step) * (first + through_water))
            third = self.velocity(moment + 0.75 * step, depth, place + (0.75 * step) * (second + through_water))
            mean = (2.0 / 9.0) * first + (3.0 / 9.0) * second + (4.0 / 9.0) * third
            if most == 1:
                return mean
            counted = np.minimum(np.maximum(steps - number, 0.0), 1.0)  # 0 for trials whose leg is over
            total = total + mean * counted
            place, moment = place + (step * counted) * (mean + through_water), moment + step * counted
        return total / steps

    def _lattice(self, depth: Scalars) -> Lattice | None:
        """Packed field at a depth, or at all levels for depths that differ; None where it cannot be packed."""
        one = depth if isinstance(depth, float) else float(np.reshape(depth, ())) if np.size(depth) == 1 else None
        kept = self._lattices
        if one in kept:
            return kept[one]
        if len(kept) > _DEPTHS_KEPT:
            kept.clear()
        lattice = kept[one] = self._packed_at(one)
        return lattice

    def _packed_at(self, depth: float | None) -> Lattice | None:
        axes = self._axes
        if axes is None or not isinstance(self.grid, RegularGrid):
            return None
        levels = self.levels if depth is None else np.array([depth])
        if depth is None and (levels.ndim != 1 or len(levels) < 2 or self.values.size > _MOST_PACKED):
            return None
        if depth not in self._packed:
            if len(self._packed) > _DEPTHS_KEPT:
                self._packed.clear()
            shape = self.grid.north_axis.size, self.grid.east_axis.size
            self._packed[depth] = packed(self._across_at(depth), shape)
        return Lattice(axes, self._packed[depth], levels)

    def _across_at(self, depth: float | None) -> Velocities:
        """Values at a depth, shape (t, c), or at all levels, shape (t, d, c)."""
        if depth is None:
            return self.values.transpose(0, 2, 1)
        east, north = self._at_depth(depth)
        return np.asarray((east + 1j * north).reshape(self.time.size, -1))

    @cached_property
    def _lattices(self) -> dict[float | None, Lattice | None]:
        """What `_lattice` has found, by depth."""
        return {}

    @cached_property
    def _axes(self) -> EvenAxes | None:
        """Axes of a field whose times, rows and columns are evenly spaced and not too many to pack."""
        if not isinstance(self.grid, RegularGrid) or self.wet.size > _MOST_PACKED:
            return None
        return EvenAxes.of((self.time, self.grid.north_axis, self.grid.east_axis), (self._time_step, *self.grid.steps))

    @cached_property
    def _time_step(self) -> float | None:
        return even_step(self.time)

    @property
    @override
    def steady_for(self) -> float:
        return _STEADY

    @override
    def covers(self, span: Span) -> NDArray[np.bool_]:
        start, end, depth = (np.asarray(value) for value in (span.start, span.end, span.depth))
        first, last = self.time[0], self.time[-1]
        places = [self.grid.on_grid(np.asarray(place)) for place in span.places]
        inside = start.size and start.min() >= first and end.max() <= last and depth.min() >= self.depth[0]
        if inside and all(self._water.is_all_open(place, depth) for place in places):
            return np.ones(1, dtype=bool)
        good = np.atleast_1d((first <= start) & (end <= last) & (depth >= self.depth[0]))
        for place, t in zip(places, (span.start, span.end), strict=False):
            good = good & self._water.is_good(place, t, span.depth)
        return good

    def holds(self, place: Array) -> NDArray[np.bool_]:
        """Whether places, shape (2, n), are on the grid and at some time water."""
        return self._water.holds(self.grid.on_grid(place))

    @cached_property
    def _water(self) -> FieldWater:
        return FieldWater(self.grid, self.time, self.wet, self.bottom)

    def _across(self, moment: Indices | int, columns: Columns, depth: Scalars, shared: Bracket | None) -> Array:
        """Velocity at one of the field's times for each place, shape (2, n); `shared`: the levels about each depth."""
        column = moment * self.values.shape[1] + columns.node
        if np.size(depth) == 1:
            parts = self._at_depth(float(np.reshape(depth, ()))).take(column, axis=1)
            return np.asarray(np.einsum("ikn,kn->in", parts, columns.weight))
        values = self._in_column(column, depth, shared)
        return np.stack([np.einsum("kn,kn->n", part, columns.weight) for part in (values.real, values.imag)])

    def _at_depth(self, depth: float) -> Array:
        """East and north of all columns at all times at one depth, shape (2, t c)."""
        if depth not in self._slices:
            if len(self._slices) >= _DEPTHS_KEPT:
                self._slices.clear()
            every = np.arange(self.values.shape[0] * self.values.shape[1])
            values = self._in_column(every, np.full(every.size, depth))
            self._slices[depth] = np.stack((values.real, values.imag))
        return self._slices[depth]

    def _in_column(self, column: Indices, depth: Scalars, shared: Bracket | None = None) -> Velocities:
        """Values at a depth in columns, which are counted through all times."""
        levels, last = self.values.shape[2], self.values.shape[2] - 1
        if self.levels.ndim == 1:
            low, high, share = shared or bracket(self.levels, depth)
        else:
            flat = self.levels.reshape(-1)
            low = _last_at_most(flat, column * levels, levels, depth)
            high = np.minimum(low + 1, last)
            above, below = flat.take(column * levels + low), flat.take(column * levels + high)
            step = below - above
            share = np.clip((depth - above) / np.where(step > 0.0, step, np.inf), 0.0, 1.0)
        values = self.values.reshape(-1)
        upper, lower = values.take(column * levels + low), values.take(column * levels + high)
        return np.asarray(upper + (lower - upper) * share)


def _last_at_most(flat: Array, start: Indices, count: int, depth: Scalars) -> Indices:
    """Number of the last of `count` increasing levels from `start` on that is not below a depth; 0 where all are."""
    low, high = np.zeros_like(start), np.full_like(start, count)
    for _ in range(int(count).bit_length()):
        middle = (low + high) // 2
        above = flat.take(start + middle) <= depth
        low, high = np.where(above & (middle < high), middle, low), np.where(above, high, middle)
    return np.asarray(low)


def _down_to_the_bottom(values: Velocities) -> Velocities:
    """Give levels without a value that of the level above them, or below where there is none above."""
    if np.isfinite(values).all():
        return values
    filled = values.copy()
    for levels in (range(1, filled.shape[2]), range(filled.shape[2] - 2, -1, -1)):
        step = 1 if levels.step > 0 else -1
        for level in levels:
            missing = ~np.isfinite(filled[:, :, level])
            filled[:, :, level][missing] = filled[:, :, level - step][missing]
    return filled


def _nearest_wet(wet: NDArray[np.bool_], points: Array) -> list[Indices]:
    """For each time the column that each column takes its values from."""
    sources: list[Indices] = []
    for moment, now in enumerate(wet):
        if moment and np.array_equal(now, wet[moment - 1]):
            sources.append(sources[-1])
            continue
        source = np.arange(now.size)
        there = np.flatnonzero(now)
        source[~now] = there[scipy.spatial.cKDTree(points[:, there].T).query(points[:, ~now].T)[1]]
        sources.append(source)
    return sources
