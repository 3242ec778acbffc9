"""Where a field has water, when, and how deep."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array, Scalars, take_trials
from missionplan.phases.fields.grids import Columns, Grid, RegularGrid
from missionplan.phases.fields.lattice import EvenAxes
from missionplan.phases.recorded_currents import bracket


@dataclass(frozen=True)
class FieldWater:
    """Water of a field's columns."""

    grid: Grid
    """c columns."""
    time: Array
    """Time, shape (t,) [s]."""
    wet: NDArray[np.bool_]
    """Where the model has water, shape (t, c)."""
    bottom: Array
    """Depth down to which each column is good, shape (c,) [m]."""

    def is_good(self, place: Array, t: Scalars, depth: Scalars) -> NDArray[np.bool_]:
        """Whether places, shape (2, n), are on the grid, water at a time [s], and as deep as a depth [m]."""
        if self.is_all_open(place, depth):
            return np.ones(1, dtype=bool)
        easily = self._is_open(place, depth)
        if easily is None:
            return self._is_good_by_columns(place, t, depth)
        if not easily.all():
            left, each = np.flatnonzero(~easily), (np.broadcast_to(value, easily.shape) for value in (t, depth))
            easily[left] = self._is_good_by_columns(take_trials(place, left), *(value[left] for value in each))
        return easily

    def holds(self, place: Array) -> NDArray[np.bool_]:
        """Whether places, shape (2, n), are on the grid and at some time water."""
        columns = self._homes(place)
        ever: NDArray[np.bool_] = np.any(self.wet, axis=0)
        share = np.sum(columns.weight * ever[columns.node], axis=0)
        return np.asarray(columns.inside & (share >= 0.5), dtype=bool)

    def is_all_open(self, place: Array, depth: Scalars) -> bool:
        """Whether all places are in one block of cells all of whose columns are always water and as deep: soon told."""
        cells = self._open_down_to
        if cells is None or not place.size:
            return False
        axes, deep = cells
        (west, south), (east, north) = place.min(axis=1).tolist(), place.max(axis=1).tolist()
        (first_east, first_north), (last_east, last_north) = self._corners
        if not (first_east <= west and east <= last_east and first_north <= south and north <= last_north):
            return False
        rows = slice(axes.cell(0, south), axes.cell(0, north) + 1)
        columns = slice(axes.cell(1, west), axes.cell(1, east) + 1)
        return bool(deep[rows, columns].min() >= np.max(depth))

    @cached_property
    def _corners(self) -> list[list[float]]:
        """East and north of the grid's south-west and north-east corner [m]."""
        corners: list[list[float]] = self.grid.extent.tolist()
        return corners

    def _is_open(self, place: Array, depth: Scalars) -> NDArray[np.bool_] | None:
        """Whether places are in cells all of whose columns are always water and as deep; None on other grids."""
        cells = self._open_down_to
        if cells is None:
            return None
        axes, deep = cells
        row, column = axes.cells(place[::-1].copy())[0].astype(np.intp)
        inside = depth <= deep[row, column]
        for x, least, most in zip(place, *self.grid.extent, strict=True):
            inside &= (least <= x) & (x <= most)
        return np.asarray(inside)

    @cached_property
    def _open_down_to(self) -> tuple[EvenAxes, Array] | None:
        """Axes of the cells, and depth down to which all columns of each are good; -inf where one is ever dry."""
        if not isinstance(self.grid, RegularGrid):
            return None
        rows = self.grid.north_axis, self.grid.east_axis
        axes = EvenAxes.of(rows, self.grid.steps)
        if axes is None:
            return None
        deep = np.where(self.wet.all(axis=0), self.bottom, -np.inf).reshape(axes.count)
        deep = np.minimum(deep[1:], deep[:-1])
        return axes, np.minimum(deep[:, 1:], deep[:, :-1])

    def _is_good_by_columns(self, place: Array, t: Scalars, depth: Scalars) -> NDArray[np.bool_]:
        columns = self._homes(place)
        bottom = np.sum(columns.weight * self.bottom[columns.node], axis=0)
        return np.asarray(columns.inside & (depth <= bottom) & self._is_water(t, columns))

    def _homes(self, place: Array) -> Columns:
        """Columns that say whether places are water, and how deep."""
        columns = self.grid.columns(place)
        if not self.grid.is_of_cells:
            return columns
        return Columns(columns.node[:1], np.ones_like(columns.weight[:1]), columns.inside)

    def _is_water(self, t: Scalars, columns: Columns) -> NDArray[np.bool_]:
        """Whether most of a place is water, by the columns that make it up."""
        if self._is_wet_throughout:
            return np.ones(1, dtype=bool)
        low, high, share = bracket(self.time, t)
        part = (1.0 - share) * self.wet[low, columns.node] + share * self.wet[high, columns.node]
        return np.asarray(np.sum(columns.weight * part, axis=0) >= 0.5)

    @cached_property
    def _is_wet_throughout(self) -> bool:
        return bool(self.wet.all())
