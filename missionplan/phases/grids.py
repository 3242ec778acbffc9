"""Horizontal grids of a field: in which columns of it a place lies, with which weights; and where they have water."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray
from typing_extensions import override

from missionplan.arrays import Array, Scalars, take_trials
from missionplan.phases.lattice import EvenAxes, Indices, TriangleFinder
from missionplan.phases.recorded_currents import bracket, even_step

_NEWTON_STEPS = 4
"""Of the place in a four-sided cell; 1e-12 of the cell for sides that differ by a fifth."""


class Columns(NamedTuple):
    """Columns of water that make up places, and their weights, shape (k, n) each; `inside`: whether the grid holds it.

    A place beyond the grid is made up of the nearest column alone. The first column is the one the place lies in where
    a grid has its values at the middles of cells.
    """

    node: Indices
    weight: Array
    inside: NDArray[np.bool_]


class Grid(ABC):
    """Columns of water in the local plane.

    Parameters
    ----------
    points : array, shape (2, c)
        East and north of each column [m].
    """

    def __init__(self, points: Array) -> None:
        self.points = points

    @cached_property
    def extent(self) -> Array:
        """South-west and north-east corner of a box about the columns, shape (2, 2) [m]."""
        return np.stack((self.points.min(axis=1), self.points.max(axis=1)))

    @property
    def is_of_cells(self) -> bool:
        """Whether values belong to the middles of cells, so that the first column says whether a place is water."""
        return False

    def on_grid(self, place: Array) -> Array:
        """Return places of the local plane, shape (2, n) [m], in the grid's own coordinates: here the same."""
        return place

    def columns(self, place: Array) -> Columns:
        """Return the columns that make up places in the grid's coordinates, shape (2, n) [m]."""
        node, weight, inside = self._within(place)
        if inside.all():
            return Columns(node, weight, inside)
        away = np.flatnonzero(~inside)
        weight[:, away] = 0.0
        weight[0, away] = 1.0
        node[:, away] = self._tree.query(place[:, away].T)[1]
        return Columns(node, weight, inside)

    @cached_property
    def _tree(self) -> "scipy.spatial.cKDTree":
        return scipy.spatial.cKDTree(self.points.T)

    @abstractmethod
    def _within(self, place: Array) -> Columns:
        """Columns of places on the grid; anything for the others."""


class RegularGrid(Grid):
    """Values at the nodes of rows and columns, bilinear between them; beyond the edge those of the edge.

    Rows and columns are straight in the grid's coordinates. Parallels and meridians bend on the local plane: to second
    order a place (x, y) of the plane is at (x (1 + b y), y − b x²/2) of the grid, b the geodesic curvature of the
    parallel. Against the ellipsoid that is within 0.05 m at 10 km from the origin and 6 m at 50 km (up to 60° of
    latitude), where straight rows would be 26 m and 650 m out.

    Parameters
    ----------
    north_axis, east_axis : array, shapes (j,) and (i,)
        Increasing [m]; a column's number is that of its row times i, plus that in the row.
    bend : float
        Curvature b of the row through the origin, toward north [1/m].
    """

    def __init__(self, north_axis: Array, east_axis: Array, bend: float = 0.0) -> None:
        super().__init__(np.stack(np.meshgrid(east_axis, north_axis)).reshape(2, -1))
        self.north_axis, self.east_axis, self.bend = north_axis, east_axis, bend
        self.steps = even_step(north_axis), even_step(east_axis)

    @override
    def on_grid(self, place: Array) -> Array:
        if not self.bend:
            return place
        east, north = place
        bent, coordinates = self.bend * east, np.empty_like(place, dtype=float)
        np.multiply(bent, north, out=coordinates[0])
        coordinates[0] += east
        bent *= 0.5 * east
        np.subtract(north, bent, out=coordinates[1])
        return coordinates

    @override
    def columns(self, place: Array) -> Columns:
        return self._within(place)

    @override
    def _within(self, place: Array) -> Columns:
        north, east = self.north_axis, self.east_axis
        rows, across = bracket(north, place[1], self.steps[0]), bracket(east, place[0], self.steps[1])
        row, row_part = np.stack((rows.low, rows.high)), np.stack((1.0 - rows.share, rows.share))
        column, part = np.stack((across.low, across.high)), np.stack((1.0 - across.share, across.share))
        count = place.shape[1]
        node = (row.reshape(2, 1, -1) * east.size + column.reshape(1, 2, -1)).reshape(4, count)
        weight = (row_part.reshape(2, 1, -1) * part.reshape(1, 2, -1)).reshape(4, count)
        beyond = [(axis[0] > x) | (x > axis[-1]) for axis, x in ((north, place[1]), (east, place[0]))]
        return Columns(node, weight, ~(beyond[0] | beyond[1]))


class TriangleMesh(Grid):
    """Values at the nodes of triangles, linear within each.

    Parameters
    ----------
    points : array, shape (2, c)
        Nodes [m].
    triangles : array of int, shape (m, 3)
    """

    def __init__(self, points: Array, triangles: Indices) -> None:
        super().__init__(points)
        self._triangles, self._finder = triangles.T, TriangleFinder(points, triangles)

    @override
    def _within(self, place: Array) -> Columns:
        triangle, (second, third) = self._finder.find(place)
        return Columns(self._triangles[:, triangle], np.stack((1.0 - second - third, second, third)), triangle >= 0)


class CurvedGrid(Grid):
    """Values at the nodes of a grid of rows and columns that may bend, bilinear in each of its four-sided cells.

    Parameters
    ----------
    points : array, shape (2, rows, columns)
        [m]
    """

    def __init__(self, points: Array) -> None:
        super().__init__(points.reshape(2, -1))
        rows, columns = points.shape[1:]
        corner = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
        self._corners = np.stack((corner, corner + 1, corner + columns, corner + columns + 1))
        # the lower and the upper triangle of each cell
        halves = np.stack((self._corners[[0, 1, 2]], self._corners[[3, 2, 1]]), axis=2)
        self._finder = TriangleFinder(self.points, halves.transpose(1, 2, 0).reshape(-1, 3))
        p00, p01, p10, p11 = (self.points[:, number] for number in self._corners)
        self._shape = p00, p01 - p00, p10 - p00, p11 - p10 - p01 + p00

    @override
    def _within(self, place: Array) -> Columns:
        triangle, (second, third) = self._finder.find(place)
        cell, upper = triangle // 2, triangle % 2 == 1
        start, along, up, twist = (part[:, cell] for part in self._shape)
        a, b = np.where(upper, 1.0 - second, second), np.where(upper, 1.0 - third, third)
        away = place - start
        for _ in range(_NEWTON_STEPS):
            miss = away - a * along - b * up - a * b * twist
            by_a, by_b = along + b * twist, up + a * twist
            area = by_a[0] * by_b[1] - by_a[1] * by_b[0]
            area = np.where(area != 0.0, area, np.inf)
            a, b = (
                np.clip(a + (miss[0] * by_b[1] - miss[1] * by_b[0]) / area, 0.0, 1.0),
                np.clip(b + (by_a[0] * miss[1] - by_a[1] * miss[0]) / area, 0.0, 1.0),
            )
        weight = np.stack(((1.0 - a) * (1.0 - b), a * (1.0 - b), (1.0 - a) * b, a * b))
        return Columns(self._corners[:, cell], weight, triangle >= 0)


class CellMesh(Grid):
    """Values at the middles of cells, with a gradient in each from the cells beside it.

    Parameters
    ----------
    points : array, shape (2, c)
        Middles of the cells [m].
    corners : array, shape (2, p)
        Nodes of the mesh [m].
    triangles : array of int, shape (m, 3)
        Of which the cells consist.
    cells : array of int, shape (m,)
        The cell of each triangle.
    beside : array of int, shape (k, c)
        The cells beside each, -1 where there is none.
    slopes : array, shape (2, 1 + k, c)
        Gradient toward east and north as a sum over a cell's own value and those beside it [1/m].
    """

    def __init__(
        self, points: Array, corners: Array, triangles: Indices, cells: Indices, beside: Indices, slopes: Array
    ) -> None:
        super().__init__(points)
        self._finder, self._cells = TriangleFinder(corners, triangles), cells
        numbers = np.arange(points.shape[1])
        # at the edge of the mesh the nearest cell alone
        self._slopes = slopes * np.all(beside >= 0, axis=0)
        self._columns = np.vstack((numbers, np.where(beside >= 0, beside, numbers)))

    @property
    @override
    def is_of_cells(self) -> bool:
        return True

    @override
    def _within(self, place: Array) -> Columns:
        triangle, _ = self._finder.find(place)
        cell = self._cells[triangle]
        away = place - self.points[:, cell]
        weight = away[0] * self._slopes[0][:, cell] + away[1] * self._slopes[1][:, cell]
        weight[0] += 1.0
        return Columns(self._columns[:, cell], weight, triangle >= 0)


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
            left, values = np.flatnonzero(~easily), (np.broadcast_to(value, easily.shape) for value in (t, depth))
            easily[left] = self._is_good_by_columns(take_trials(place, left), *(value[left] for value in values))
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
