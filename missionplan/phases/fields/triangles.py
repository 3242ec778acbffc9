"""Which triangle holds a place: the triangles of a mesh, listed by the cells of a raster that is laid over them."""

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array

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
        held = np.where(area != 0.0, area, np.inf)
        self._toward_second = np.stack((by, -bx)) / held
        self._toward_third = np.stack((-ay, ax)) / held
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
        found = np.full(place.shape[1], -1, dtype=np.intp)
        shares = np.zeros(place.shape)
        while True:
            left = at < end
            if not left.all():
                todo, at, end = todo[left], at[left], end[left]
            if not todo.size:
                return found, shares
            triangle = self._listed[at]
            second, third = self._shares(triangle, place[:, todo])
            inside = (second >= -_EDGE) & (third >= -_EDGE) & (second + third <= 1.0 + _EDGE)
            hit = todo[inside]
            found[hit], shares[0, hit], shares[1, hit] = triangle[inside], second[inside], third[inside]
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
