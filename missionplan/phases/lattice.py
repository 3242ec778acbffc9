"""Fields on evenly spaced rows and columns, packed so that a place in a cell is one look-up.

Between four nodes a velocity is c₀ + c₁ e + c₂ n + c₃ e n, with the shares e and n of the way to the next column and
row. The four coefficients of a cell, east and north, stand together in memory, in single precision (1e-7 of them).

Which triangle holds a place: the triangles of a mesh, listed by the cells of a raster that is laid over them.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array, Scalars

Cells = NDArray[np.float32]
"""Coefficients of cells, one after the other, shape (cells, 8): c₀ east, c₀ north, c₁ east and so on [m/s]."""
_TOGETHER = 4096
"""Places that are looked up at once: a block of trials, whose arrays stay in the cache."""
_SHORT = 1.0 - 1e-12
"""By which places are kept before the last node, so that they are in a cell."""


@dataclass(frozen=True)
class EvenAxes:
    """Evenly spaced axes, at least two nodes each."""

    first: Array
    per_unit: Array
    end: Array
    """Shape (k, 1). First node, nodes per unit, and just before the last node, counted in nodes."""
    count: tuple[int, ...]
    """Nodes."""

    @classmethod
    def of(cls, axes: tuple[Array, ...], steps: tuple[float | None, ...]) -> "EvenAxes | None":
        """Build it from axes and their `even_step`; None where one is not even."""
        if None in steps:
            return None
        first, count = np.array([[axis[0]] for axis in axes], dtype=float), tuple(len(axis) for axis in axes)
        per_unit = 1.0 / np.array([[step] for step in steps], dtype=float)
        return cls(first, per_unit, (np.array(count, dtype=float)[:, None] - 1.0) * _SHORT, count)

    def cell(self, axis: int, x: float) -> int:
        """Number of the cell along an axis; of one beyond it, that at the edge."""
        first, per_unit, end = self._numbers[axis]
        return int(min(max((x - first) * per_unit, 0.0), end))

    @cached_property
    def _numbers(self) -> list[list[float]]:
        """For each axis its first node, nodes per unit and end."""
        numbers: list[list[float]] = np.hstack((self.first, self.per_unit, self.end)).tolist()
        return numbers

    def cells(self, places: Array) -> tuple[Array, Array]:
        """Whole numbers of the cells along each axis, and shares of the way through them; those beyond are at the edge.

        `places`, shape (k, n), is written over.
        """
        share = places
        share -= self.first
        share *= self.per_unit
        np.maximum(share, 0.0, out=share)
        np.minimum(share, self.end, out=share)
        cell = np.floor(share)
        share -= cell
        return cell, share


def packed(values: NDArray[np.complexfloating], shape: tuple[int, int]) -> Cells:
    """Pack values, shape (..., rows times columns), of `shape` rows and columns; cells follow in the same order."""
    field = values.reshape(*values.shape[:-1], *shape)
    start = field[..., :-1, :-1]
    along, up = field[..., :-1, 1:] - start, field[..., 1:, :-1] - start
    twist = field[..., 1:, 1:] - start - along - up
    rows = np.stack((start, along, up, twist), axis=-1).astype(np.complex64)
    return np.ascontiguousarray(rows).view(np.float32).reshape(-1, 8)


@dataclass(frozen=True)
class Lattice:
    """A field in time and across, at one depth or at fixed levels."""

    axes: EvenAxes
    """Time, north and east [s, m]."""
    cells: Cells
    """By time, level, row and column."""
    levels: Array
    """Their depths; one where it is a field at one depth; shape (d,) [m]."""

    def velocity(self, t: Scalars, depth: Scalars, position: Array) -> Array:
        """Velocity at moments, depths and places, shape (2, n) [m/s]."""
        count = max(np.size(t), position.shape[-1], np.size(depth))
        places = np.empty((3, count))
        places[0], places[1], places[2] = t, position[1], position[0]
        level: Array | None = None
        if len(self.levels) > 1:
            level = np.empty(count)
            level[:] = depth
        if count <= _TOGETHER:
            return self._at(places, level)
        velocity = np.empty((2, count))
        for begin in range(0, count, _TOGETHER):
            part = slice(begin, begin + _TOGETHER)
            velocity[:, part] = self._at(places[:, part], None if level is None else level[part])
        return velocity

    def _at(self, places: Array, depth: Array | None) -> Array:
        cell, (later, north, east) = self.axes.cells(places)
        _, rows, columns = self.axes.count
        across, levels = (rows - 1) * (columns - 1), len(self.levels)
        cell[0] *= across * levels
        cell[1] *= columns - 1
        cell[0] += cell[1]
        cell[0] += cell[2]
        row = cell[0].astype(np.intp)
        weighted = [(row, 1.0 - later), (row + across * levels, later)]
        if depth is not None:
            level, below = self._level(depth)
            row += level * across
            both, down = later * below, below
            weighted = [
                (row, 1.0 - later - down + both),
                (row + across, down - both),
                (row + across * levels, later - both),
                (row + across * (levels + 1), both),
            ]
        total: NDArray[np.float32] | None = None
        for number, weight in weighted:
            corner = np.ascontiguousarray(self.cells.take(number, axis=0).T)
            corner *= weight.astype(np.float32)
            total = corner if total is None else np.add(total, corner, out=total)
        start, along, up, twist = np.asarray(total, dtype=float).reshape(4, 2, -1)
        twist *= east
        twist += up
        twist *= north
        along *= east
        start += along
        start += twist
        return start

    def _level(self, depth: Array) -> tuple[NDArray[np.intp], Array]:
        """Number of the level above each depth, and the share of the way to the next; held beyond the levels."""
        number = np.searchsorted(self.levels[1:-1], depth, side="right")
        above = self.levels.take(number)
        share = (depth - above) / (self.levels.take(number + 1) - above)
        return number, np.clip(share, 0.0, 1.0)


Indices = NDArray[np.intp]

_EDGE = 1e-9
"""Share of a triangle by which a place may lie beyond its edge, so that rounding opens no gaps between triangles."""
_CELLS = 2.0
"""Cells of the raster for each triangle."""


class TriangleFinder:
    """Finds the triangle about a place and the place's shares in its corners.

    Parameters
    ----------
    points : array, shape (2, p)
        East and north [m].
    triangles : array of int, shape (m, 3)
        Corners, in either sense of rotation. Triangles without an area hold no place.
    """

    def __init__(self, points: Array, triangles: Indices) -> None:
        corners = points[:, triangles]  # (2, m, 3)
        self._first = corners[:, :, 0]
        (ax, ay), (bx, by) = (corners[:, :, side] - self._first for side in (1, 2))
        area = ax * by - ay * bx
        divisor = np.where(area != 0.0, area, np.inf)
        self._toward_second = np.stack((by, -bx)) / divisor
        self._toward_third = np.stack((-ay, ax)) / divisor
        low, high = corners.min(axis=2), corners.max(axis=2)
        self._corner = low.min(axis=1)
        size = np.maximum(high.max(axis=1) - self._corner, 1e-9)
        cell = np.sqrt(size[0] * size[1] / (_CELLS * len(triangles) + 1.0))
        self._shape = np.maximum(np.ceil(size / cell), 1.0).astype(np.intp)
        self._per_metre = self._shape / size
        self._starts, self._listed = self._list(low, high, np.flatnonzero(area != 0.0))

    def find(self, place: Array) -> tuple[Indices, Array]:
        """Triangle about each place, -1 where there is none, and the shares of its second and third corner.

        Parameters
        ----------
        place : array, shape (2, n)
            [m]

        Returns
        -------
        triangle, shares : array of int of shape (n,), array of shape (2, n)
        """
        cell = np.floor((place - self._corner[:, None]) * self._per_metre[:, None])
        cell -= cell == self._shape[:, None]  # the raster's last edge is its own
        on_raster = np.all((cell >= 0.0) & (cell < self._shape[:, None]), axis=0)
        todo = np.flatnonzero(on_raster)
        number = (cell[1, todo] * self._shape[0] + cell[0, todo]).astype(np.intp)
        at, end = self._starts[number], self._starts[number + 1]
        triangles = np.full(place.shape[1], -1, dtype=np.intp)
        shares = np.zeros(place.shape)
        while True:
            left = at < end
            if not left.all():
                todo, at, end = todo[left], at[left], end[left]
            if not todo.size:
                return triangles, shares
            triangle = self._listed[at]
            second, third = self._shares(triangle, place[:, todo])
            inside = (second >= -_EDGE) & (third >= -_EDGE) & (second + third <= 1.0 + _EDGE)
            hit = todo[inside]
            triangles[hit], shares[0, hit], shares[1, hit] = triangle[inside], second[inside], third[inside]
            missed = ~inside
            todo, at, end = todo[missed], at[missed] + 1, end[missed]

    def _shares(self, triangle: Indices, place: Array) -> tuple[Array, Array]:
        away = place - self._first[:, triangle]
        toward = self._toward_second[:, triangle], self._toward_third[:, triangle]
        second, third = (away[0] * along[0] + away[1] * along[1] for along in toward)
        return second, third

    def _list(self, low: Array, high: Array, kept: Indices) -> tuple[Indices, Indices]:
        """List the triangles of each cell: where its list begins, and the lists, one after the other."""
        first, last = (
            np.clip(((corner[:, kept] - self._corner[:, None]) * self._per_metre[:, None]).astype(np.intp), 0, limit)
            for corner, limit in ((low, self._shape[:, None] - 1), (high, self._shape[:, None] - 1))
        )
        wide, tall = last - first + 1
        count = wide * tall
        triangle = np.repeat(np.arange(kept.size), count)
        number = np.arange(triangle.size) - np.repeat(np.cumsum(count) - count, count)
        column = first[0, triangle] + number % wide[triangle]
        row = first[1, triangle] + number // wide[triangle]
        cell = row * self._shape[0] + column
        order = np.argsort(cell, kind="stable")
        starts = np.searchsorted(cell[order], np.arange(self._shape[0] * self._shape[1] + 1))
        return starts, kept[triangle[order]]


def slopes_by_least_squares(points: Array, beside: Indices) -> Array:
    """Gradient in each cell that fits the differences to the cells beside it best, as FVCOM computes ``a1u, a2u``.

    Chen, Liu and Beardsley 2003, J. Atmos. Oceanic Technol. 20, 159-186; FVCOM, ``shape_coef_gcn.F``.

    Parameters
    ----------
    points : array, shape (2, c)
        [m]
    beside : array of int, shape (k, c)
        -1: none.

    Returns
    -------
    array, shape (2, 1 + k, c)
        See `grids.CellMesh`; zero where the cells beside lie on one line.
    """
    there = beside >= 0
    away = np.where(there, points[:, beside] - points[:, None, :], 0.0)
    xx, yy, xy = (np.sum(away[i] * away[j], axis=0) for i, j in ((0, 0), (1, 1), (0, 1)))
    area = xx * yy - xy * xy
    fits = area > 1e-9 * xx * yy
    divisor = np.where(fits, area, np.inf)
    toward = np.stack((away[0] * yy - away[1] * xy, away[1] * xx - away[0] * xy)) / divisor
    return np.concatenate((-toward.sum(axis=1, keepdims=True), toward), axis=1)
