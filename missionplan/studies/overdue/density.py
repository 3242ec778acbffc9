"""Areas of highest density of a cloud of weighted points: the smallest that hold a share of it, bent or in parts."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import contourpy
import numpy as np

from missionplan.arrays import Array

Polygon = tuple[Array, ...]
"""Closed rings of shape (2, k): the outer one, then those of its holes [m]."""
_CELLS = 160
"""Of the grid along the longer axis."""
_REACH = 4.0
"""Of a kernel, in its standard deviations."""
_KERNEL = 0.7
"""Width of the kernels in units of that which is best for a normal cloud: less, as clouds are bent."""
_LEAST = 1.0
"""Standard deviation that a cloud has at least, where all points lie alike [m]."""


@dataclass(frozen=True)
class Cloud:
    """Points with weights."""

    points: Array
    """Shape (2, n). [m]"""
    weights: Array
    """Their sum is one, shape (n,)."""

    @cached_property
    def centre(self) -> Array:
        """Mean, shape (2,) [m]."""
        return np.asarray(self.points @ self.weights)

    @cached_property
    def axes(self) -> tuple[Array, Array]:
        """Standard deviations along the short and the long axis [m], and unit vectors of these as columns."""
        off = self.points - self.centre[:, None]
        values, vectors = np.linalg.eigh((off * self.weights) @ off.T)
        return np.sqrt(np.maximum(values, _LEAST**2)), vectors

    @cached_property
    def _density(self) -> "_Density":
        return _Density.of(self)

    def areas(self, shares: Sequence[float]) -> list[tuple[Polygon, ...]]:
        """Return, for each share, the parts of the area of highest density that holds it."""
        return [self._density.area(share) for share in shares]

    def densest(self) -> Array:
        """Return the place of highest density, shape (2,) [m]."""
        return self._density.densest()


@dataclass(frozen=True)
class _Density:
    """A kernel estimate on a grid along the cloud's axes, in units of its standard deviations.

    Attributes
    ----------
    cloud : Cloud
    x, y : array
        Of the grid's nodes.
    values : array, shape (y, x)
    """

    cloud: Cloud
    x: Array
    y: Array
    values: Array
    of_points: Array
    """At each point, as the others alone give it: what a point adds at its own place is no evidence that the vehicle is
    there, and areas that counted it would be too small, shape (n,)."""

    @classmethod
    def of(cls, cloud: Cloud) -> "_Density":
        sds, vectors = cloud.axes
        scaled = (vectors.T @ (cloud.points - cloud.centre[:, None])) / sds[:, None]
        alike = 1.0 / float(np.sum(np.square(cloud.weights)))  # as many points of one weight would tell as much
        width = _KERNEL * alike ** (-1.0 / 6.0)
        low, high = scaled.min(axis=1) - _REACH * width, scaled.max(axis=1) + _REACH * width
        step = float(np.max(high - low)) / _CELLS
        step = min(step, 0.5 * width)
        x, y = (np.arange(a, b + step, step) for a, b in zip(low, high, strict=True))
        edges = [np.append(axis, axis[-1] + step) - 0.5 * step for axis in (y, x)]
        counts, *_ = np.histogram2d(scaled[1], scaled[0], bins=edges, weights=cloud.weights)
        along, across = _kernels(counts.shape[0], width / step), _kernels(counts.shape[1], width / step)
        smooth = along @ counts @ across
        row, column = (np.rint((at - axis[0]) / step).astype(int) for at, axis in ((scaled[1], y), (scaled[0], x)))
        own = cloud.weights * along[row, row] * across[column, column]
        return cls(cloud, x, y, smooth, smooth[row, column] - own)

    def area(self, share: float) -> tuple[Polygon, ...]:
        order = np.argsort(-self.of_points)
        reached = np.searchsorted(np.cumsum(self.cloud.weights[order]), share)
        level = float(self.of_points[order[min(int(reached), order.size - 1)]])
        level = max(level, 1e-6 * float(self.values.max()))
        lines = contourpy.contour_generator(self.x, self.y, self.values, fill_type="OuterOffset").filled(level, np.inf)
        return tuple(
            tuple(self._placed(points[a:b].T) for a, b in pairwise(offsets))
            for points, offsets in zip(*lines, strict=True)
        )

    def densest(self) -> Array:
        row, column = np.unravel_index(int(np.argmax(self.values)), self.values.shape)
        return self._placed(np.array([[self.x[column]], [self.y[row]]]))[:, 0]

    def _placed(self, scaled: Array) -> Array:
        sds, vectors = self.cloud.axes
        return np.asarray(self.cloud.centre[:, None] + vectors @ (sds[:, None] * scaled))


def _kernels(count: int, sd: float) -> Array:
    """Normal kernels about each of so many cells, each of sum one where it is whole; shape (count, count)."""
    reach = np.arange(-int(_REACH * sd + 0.5), int(_REACH * sd + 0.5) + 1)
    total = np.exp(-0.5 * np.square(reach / sd)).sum()
    apart = np.abs(np.subtract.outer(np.arange(count), np.arange(count)))
    return np.where(apart <= reach[-1], np.exp(-0.5 * np.square(apart / sd)) / total, 0.0)
