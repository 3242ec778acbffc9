"""Every combination of what may be chosen: a lattice of the values of some keys."""

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.results.axis import Axis

Point = tuple[int, ...]
"""A choice: an index along each axis."""


@dataclass(frozen=True)
class Lattice(Sequence[Mapping[str, object]]):
    """Every combination of the values of some axes, numbered with the last axis running fastest."""

    axes: tuple[Axis, ...]

    @property
    def shape(self) -> tuple[int, ...]:
        """Values of each axis."""
        return tuple(len(axis.values) for axis in self.axes)

    def __len__(self) -> int:
        return math.prod(self.shape)

    def __getitem__(self, number: int) -> Mapping[str, object]:  # type: ignore[override]  # slices have no use
        return self.values_at(tuple(int(i) for i in np.unravel_index(number, self.shape)))

    def number(self, point: Point) -> int:
        """Return the number of a point."""
        return int(np.ravel_multi_index(point, self.shape))

    def values_at(self, point: Point) -> dict[str, object]:
        """Return the values by key path."""
        pairs = zip(self.axes, point, strict=True)
        return {key: axis.values[index] for axis, index in pairs for key in axis.keys}

    def places(self, points: Sequence[Point]) -> tuple[Array, NDArray[np.intp]]:
        """Return where points lie, shape (n, k), and the axis of each column.

        Numbers run from 0 to 1; of an axis without numbers each value has a column, so that any two are 1 apart.
        """
        columns: list[Array] = []
        axes: list[int] = []
        for number, (axis, indices) in enumerate(zip(self.axes, np.array(points).T, strict=True)):
            values = np.array(axis.numbers if axis.numbers is not None else range(len(axis.values)), dtype=float)
            if axis.numbers is not None:
                columns.append((values[indices] - values.min()) / max(float(np.ptp(values)), 1e-12))
            else:
                columns += [(indices == value) / math.sqrt(2.0) for value in values]
            axes += [number] * (len(columns) - len(axes))
        return np.stack(columns, axis=1), np.array(axes)

    def neighbours(self, point: Point) -> Iterator[Point]:
        """Yield points one step away in one axis, or in each of two; along an axis without numbers, any other value."""
        moves = [(axis, step) for axis in range(len(self.axes)) for step in self._steps(axis, point[axis])]
        pairs = [(one, two) for one, two in itertools.combinations(moves, 2) if one[0] != two[0]]
        for combined in (*((move,) for move in moves), *pairs):
            moved = list(point)
            for axis, step in combined:
                moved[axis] += step
            yield tuple(moved)

    def _steps(self, axis: int, at: int) -> list[int]:
        count = self.shape[axis]
        reach = (-1, 1) if self.axes[axis].numbers is not None else range(-at, count - at)
        return [step for step in reach if step and 0 <= at + step < count]
