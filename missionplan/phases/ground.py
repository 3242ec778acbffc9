"""Depth of the seafloor on a grid, and the first place of a straight way where the water is too shallow.

Between the centres of its cells the depth is bilinear; from the outermost centres to the outer edges of their cells it
is that of the nearest centre; beyond, and where a corner is missing, it is unknown.
"""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import scipy
from numpy.typing import NDArray

from missionplan.arrays import Array

Depths = NDArray[np.float32]
_SPLIT = 4
"""Parts into which a way is cut that may be too shallow somewhere."""
_FINEST = 2.0
"""Cells below which a way is sampled rather than cut."""
_BEYOND = -10.0
"""Column and row of what lies beyond the part of the plane that a grid was read for."""
_SAMPLES = 17
"""Along such a way: eight a cell. Bilinear depth between two samples is within twist/512 of linear, the twist being the
difference of a cell's diagonals' sums."""
_MOST_SAMPLES = 128
"""Of a way whose nearness to shallow water is asked for."""
_LEAST_NEEDED = 0.25
"""Of the depths for which distances to less are tabulated [m]."""


@dataclass(frozen=True)
class Frame:
    """From the plane to the grid's columns and rows: a polynomial, fitted to the exact projection."""

    low: Array
    high: Array
    """Shape (2,). Corners of the part of the plane in which it was fitted [m]."""
    terms: Array
    """Coefficients of x^i y^j, x and y from -1 to 1 across that part, of column and row, shape (degree + 1, degree + 1,
    2)."""

    @classmethod
    def fitted(cls, low: Array, high: Array, places: Array, cells: Array, tolerance: float = 1e-3) -> "Frame | None":
        """Fit to columns and rows of places, shape (2, k); None where no polynomial is within the tolerance [cells]."""
        x, y = (2.0 * places - (low + high)[:, None]) / (high - low)[:, None]
        for degree in range(1, 8):
            pairs = [(i, j) for i in range(degree + 1) for j in range(degree + 1 - i)]
            basis = np.stack([x**i * y**j for i, j in pairs], axis=1)
            solved = np.linalg.lstsq(basis, cells.T, rcond=None)[0]
            if np.abs(basis @ solved - cells.T).max() <= tolerance:
                terms = np.zeros((degree + 1, degree + 1, 2))
                for (i, j), pair in zip(pairs, solved, strict=True):
                    terms[i, j] = pair
                return cls(low, high, terms)
        return None

    def cells(self, places: Array) -> Array:
        """Columns and rows of places, shape (2, n), whole at cells' centres; `_BEYOND` where it was not fitted."""
        half = 0.5 * (self.high - self.low)[:, None]
        scaled = (places - (self.low[:, None] + half)) / half
        beyond = np.abs(scaled).max(axis=0) > 1.0
        x, y = np.clip(scaled, -1.0, 1.0) if beyond.any() else scaled
        cells = np.zeros((2, x.size))
        for i in range(len(self.terms) - 1, -1, -1):
            along = np.zeros((2, x.size))
            for j in range(len(self.terms) - 1 - i, -1, -1):
                along = along * y + self.terms[i, j][:, None]
            cells = cells * x + along
        if beyond.any():
            cells[:, beyond] = _BEYOND
        return cells

    def box(self, low: Array, high: Array) -> tuple[Array, Array] | None:
        """Least and greatest column and row that a box of the plane can hold; None where it leaves what was fitted.

        The greatest slopes of the polynomial bound how far its columns and rows are from those of the box's middle.
        """
        if not ((low >= self.low).all() and (high <= self.high).all()):
            return None
        middle = self.cells(0.5 * (low + high)[:, None])[:, 0]
        reach = ((high - low) / (self.high - self.low)) @ self._steepest
        return middle - reach, middle + reach

    @cached_property
    def _steepest(self) -> Array:
        """Bounds of the slopes of column and row along x and y, shape (2, 2)."""
        powers, size = np.arange(len(self.terms)), np.abs(self.terms)
        return np.stack([np.einsum("i,ijk->k", powers, size), np.einsum("j,ijk->k", powers, size)])


@dataclass(frozen=True)
class Ground:
    """The seafloor."""

    depth: Depths = field(repr=False)
    """Below the datum, negative on land, nan where unknown, shape (rows, columns) [m]."""
    frame: Frame

    @property
    def cell(self) -> float:
        """Shorter side of a cell [m]."""
        middle = 0.5 * (self.frame.low + self.frame.high)[:, None]
        away = self.frame.cells(middle + np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]))
        return float(1.0 / np.hypot(*(away[:, 1:] - away[:, :1])).max())

    def depth_at(self, places: Array) -> Array:
        """Depth at places of shape (2, n), shape (n,); nan where unknown [m]."""
        return self._bilinear(self.depth, self.frame.cells(places))

    def is_deep(self, low: Array, high: Array, least: float) -> bool:
        """Whether all of a box of the plane, corners of shape (2,), is surely deeper than `least` [m]."""
        within = self.frame.box(low, high)
        if within is None:
            return False
        first, last = (np.floor(corner).astype(np.int64) for corner in within)
        level = min(int(max(last - first) + 1).bit_length() // 2, len(self._blocks) - 1)
        (column, row), (right, top) = (np.maximum((corner >> level) + 1, 0) for corner in (first, last))
        depths = self._blocks[level][row : top + 1, column : right + 1]
        is_whole = depths.shape == (top - row + 1, right - column + 1)
        return bool(is_whole and depths.min() > least)

    def spare_along(self, start: Array, end: Array, least: Array) -> tuple[Array, Array]:
        """How near straight ways come to water that is too shallow, and to where the depth is unknown.

        Ways are sampled twice a cell: an order of nearness, while `too_shallow` alone says what is met.

        Parameters
        ----------
        start, end, least : array, shape (2, n)
            As in `too_shallow`.

        Returns
        -------
        shallow : array, shape (n,)
            Least depth beyond what is needed, times one and the distance in cells to water that is too shallow for it:
            ways are led to a rise from afar, and over level ground by what is needed [m].
        unknown : array, shape (n,)
            Least distance to where the depth is unknown [cells].
        """
        first, last = self.frame.cells(start), self.frame.cells(end)
        extent = np.abs(last - first).max(axis=0)
        count = np.clip(2 ** np.ceil(np.log2(2.0 * extent + 1.0)), 2, _MOST_SAMPLES).astype(int)
        level = np.ceil(4.0 * np.log2(np.maximum(least.max(axis=0), _LEAST_NEEDED))).astype(int)
        shallow, unknown = np.full(count.size, np.inf), np.full(count.size, np.inf)
        for samples, depth_level in sorted(set(zip(count.tolist(), level.tolist(), strict=True))):
            rows = np.flatnonzero((count == samples) & (level == depth_level))
            at = np.linspace(0.0, 1.0, samples)
            cells = (first[:, rows, None] + at * (last - first)[:, rows, None]).reshape(2, -1)
            needed = (least[0][rows, None] + at * (least[1] - least[0])[rows, None]).ravel()
            spare = self._bilinear(self.depth, cells) - needed
            beside = 1.0 + np.nan_to_num(self._bilinear(self._to_shallower(depth_level), cells))
            product = np.where(np.isnan(spare), np.inf, spare * beside).reshape(rows.size, samples)
            shallow[rows] = product.min(axis=1)
            away = np.nan_to_num(self._bilinear(self._to_unknown, cells)).reshape(rows.size, samples)
            unknown[rows] = away.min(axis=1)
        return shallow, unknown

    def _to_shallower(self, level: int) -> Depths:
        """Distance of each centre from water less deep than 2^(level/4) m; 0 everywhere without any [cells]."""
        if level not in self._distances:
            deep = ~(self.depth <= 2.0 ** (0.25 * level))
            away = scipy.ndimage.distance_transform_edt(deep) if not deep.all() else np.zeros(deep.shape)
            self._distances[level] = away.astype(np.float32)
        return self._distances[level]

    @cached_property
    def _distances(self) -> dict[int, Depths]:
        return {}

    @cached_property
    def _to_unknown(self) -> Depths:
        """Distance of each centre from one without a depth, or from the grid's edge [cells]."""
        is_known = np.pad(~np.isnan(self.depth), 1)
        return np.asarray(scipy.ndimage.distance_transform_edt(is_known)[1:-1, 1:-1], dtype=np.float32)

    def slope_at(self, places: Array) -> tuple[Array, Array]:
        """Angle of the seafloor, and the direction toward which it falls, clockwise from north, shape (n,) [rad].

        That over two metres: of a cell, while these are small against it. Level where a neighbour is unknown. `places`,
        shape (2, n) [m].
        """
        sides = np.array([[1.0], [0.0]]), np.array([[0.0], [1.0]])
        falls = [0.5 * (self.depth_at(places + side) - self.depth_at(places - side)) for side in sides]
        toward_east, toward_north = np.nan_to_num(falls[0]), np.nan_to_num(falls[1])
        angle = np.arctan(np.sqrt(toward_east**2 + toward_north**2))
        return angle, np.arctan2(toward_east, toward_north)

    def too_shallow(self, start: Array, end: Array, least: Array) -> tuple[Array, Array, Array]:
        """Find where straight ways first meet water that is not deeper than they need.

        Parameters
        ----------
        start, end : array, shape (2, n)
            [m]
        least : array, shape (2, n)
            Depth below the datum that has to be exceeded at the start and at the end, linear between [m].

        Returns
        -------
        share : array, shape (n,)
            Of the way until there; infinite where all of it is deep enough.
        depth : array, shape (n,)
            Of the ground there [m].
        unknown : array, shape (n,)
            Share of the way until the depth is first unknown; infinite where it is known all along.
        """
        count = start.shape[1]
        share, depth, unknown = np.full(count, np.inf), np.full(count, np.nan), np.full(count, np.inf)
        first, last = begun, ended = self.frame.cells(start), self.frame.cells(end)
        way, low, high = np.arange(count), np.zeros(count), np.ones(count)
        needed = least.max(axis=0)
        while way.size:
            extent = float(np.abs(last - first).max(initial=0.0))
            # least depth of all cells in the blocks that hold ways of at most an extent [cells], -inf beyond the grid
            level = min(int(np.ceil(np.log2(extent + 2.0))), len(self._blocks) - 1)
            blocks = self._blocks[level]
            corner = (np.floor(np.minimum(first, last)).astype(np.int64) >> level) + 1
            top = blocks.shape
            depths: Depths = blocks[np.clip(corner[1], 0, top[0] - 1), np.clip(corner[0], 0, top[1] - 1)]
            suspect = ~(depths > needed[way])
            way, low, high = way[suspect], low[suspect], high[suspect]
            if extent <= _FINEST:
                break
            parts = np.linspace(0.0, 1.0, _SPLIT + 1)
            length, way = high - low, np.repeat(way, _SPLIT)
            low, high = ((low[:, None] + length[:, None] * cut).ravel() for cut in (parts[:-1], parts[1:]))
            first, last = (begun[:, way] + at * (ended - begun)[:, way] for at in (low, high))
        if way.size:
            at = self._samples(begun[:, way], (ended - begun)[:, way], low, high)
            over = start[:, way, None] + at * (end - start)[:, way, None]
            sampled = self.depth_at(over.reshape(2, -1)).reshape(at.shape)
            limit = least[0][way, None] + at * (least[1] - least[0])[way, None]
            np.minimum.at(unknown, way, np.where(np.isnan(sampled), at, np.inf).min(axis=1))
            np.minimum.at(share, way, np.where(sampled <= limit, at, np.inf).min(axis=1))
            met = np.isfinite(share)
            depth[met] = self.depth_at(start[:, met] + share[met] * (end - start)[:, met])
        return share, depth, unknown

    @staticmethod
    def _samples(first: Array, along: Array, low: Array, high: Array) -> Array:
        """Shares of ways at which the depth is looked at, shape (n, k): evenly, and where they cross rows and columns.

        Between two of them the depth along the way is quadratic.
        """
        even = low[:, None] + (high - low)[:, None] * np.linspace(0.0, 1.0, _SAMPLES)
        crossings = [even]
        for axis in (0, 1):
            lines = np.floor(np.minimum(*(first[axis] + at * along[axis] for at in (low, high))))[:, None] + (1, 2, 3)
            step = np.where(along[axis] == 0.0, np.inf, along[axis])[:, None]
            crossings.append(np.clip((lines - first[axis][:, None]) / step, low[:, None], high[:, None]))
        return np.concatenate(crossings, axis=1)

    @staticmethod
    def _bilinear(table: Depths, cells: Array) -> Array:
        rows, columns = table.shape
        column, row = cells
        inside = (np.abs(column - 0.5 * (columns - 1)) <= 0.5 * columns) & (
            np.abs(row - 0.5 * (rows - 1)) <= 0.5 * rows
        )
        column, row = np.clip(column, 0.0, columns - 1.0), np.clip(row, 0.0, rows - 1.0)
        west = np.minimum(column.astype(np.intp), max(columns - 2, 0))
        south = np.minimum(row.astype(np.intp), max(rows - 2, 0))
        east, north = np.minimum(west + 1, columns - 1), np.minimum(south + 1, rows - 1)
        across, up = column - west, row - south
        low = table[south, west] * (1.0 - across) + table[south, east] * across
        high = table[north, west] * (1.0 - across) + table[north, east] * across
        return np.where(inside, low * (1.0 - up) + high * up, np.nan)

    @cached_property
    def _blocks(self) -> list[Depths]:
        """Least depth of two by two blocks of 1, 2, 4, … cells to a side, -inf where unknown or beyond the grid.

        By the block at their corner, counted from the one before the first.
        """
        cells = np.where(np.isnan(self.depth), np.float32(-np.inf), self.depth)
        blocks = []
        while True:
            ringed = np.pad(cells, 1, constant_values=-np.inf)
            across = np.minimum(ringed[:, :-1], ringed[:, 1:])
            blocks.append(np.minimum(across[:-1], across[1:]))
            if max(cells.shape) <= 2:
                return blocks
            rows, columns = cells.shape
            padded = np.pad(cells, ((0, rows % 2), (0, columns % 2)), constant_values=-np.inf)
            cells = padded.reshape(padded.shape[0] // 2, 2, padded.shape[1] // 2, 2).min(axis=(1, 3))
