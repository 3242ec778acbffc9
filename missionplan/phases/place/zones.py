"""Polygons that no vehicle may touch: land, and zones kept out of, some of them at times and depths alone.

A polygon's edge belongs to it: a way that touches one has met it. Geometry is shapely's, imported when first used.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array

if TYPE_CHECKING:
    from shapely import Geometry, STRtree

_NODES = 160
"""Of the field of distances, along each side."""
_PARTS = 8
"""Into which a way is cut that may touch a zone, before its geometry is asked."""


@dataclass(frozen=True)
class Zone:
    """A polygon with what it forbids.

    Attributes
    ----------
    name : str
    is_land : bool
    since, until : float
        When it holds, since the mission's start [s].
    above, below : float
        It forbids depths less than `above` and more than `below` [m].
    """

    geometry: "Geometry" = field(repr=False)
    """In the plane [m]."""
    name: str
    is_land: bool
    since: float = -np.inf
    until: float = np.inf
    above: float = np.inf
    below: float = -np.inf

    def contact(self, start: Array, end: Array, times: Array, depths: Array) -> Array:
        """Share of straight ways until they first touch the zone while it holds, shape (n,); infinite where none does.

        Parameters
        ----------
        start, end : array, shape (2, n)
            [m]
        times : array, shape (2, n)
            At both ends [s].
        depths : array, shape (2, n)
            Least and greatest on the way [m].
        """
        import shapely

        share = np.full(start.shape[1], np.inf)
        shapely.prepare(self.geometry)
        concerned = np.flatnonzero(
            (depths[0] < self.above) & (depths[1] > self.below) & (times[1] >= self.since) & (times[0] <= self.until)
        )
        lines = _ways(start[:, concerned], end[:, concerned])
        touching = shapely.intersects(self.geometry, lines)
        ways, lines = concerned[touching], lines[touching]
        if not ways.size:
            return share
        parts, owner = shapely.get_parts(shapely.intersection(lines, self.geometry), return_index=True)
        points, part = shapely.get_coordinates(parts, return_index=True)
        chosen = ways[owner][part]
        along = end[:, chosen] - start[:, chosen]
        square = np.maximum((along**2).sum(axis=0), 1e-12)
        at = np.clip(((points.T - start[:, chosen]) * along).sum(axis=0) / square, 0.0, 1.0)
        enters, leaves = np.full(len(parts), np.inf), np.full(len(parts), -np.inf)
        np.minimum.at(enters, part, at)
        np.maximum.at(leaves, part, at)
        begin, lasting = times[0][ways][owner], (times[1] - times[0])[ways][owner]
        lasting = np.where(lasting > 0.0, lasting, 1.0)
        meets = np.maximum(enters, (self.since - begin) / lasting)
        holds = meets <= np.minimum(leaves, (self.until - begin) / lasting)
        np.minimum.at(share, ways[owner][holds], meets[holds])
        return share

    def distance(self, start: Array, end: Array, times: Array, depths: Array) -> Array:
        """How near straight ways come to the zone while it holds, shape (n,): 0 where they touch it [m].

        Time and depth by which they miss it count as lengths: what a way covers in that time, and metres.

        Parameters are those of `contact`.
        """
        import shapely

        away = np.full(start.shape[1], np.inf)
        (ways, _), found = self._edges.query_nearest(_ways(start, end), return_distance=True, all_matches=False)
        away[ways] = found
        shapely.prepare(self.geometry)
        away[shapely.intersects_xy(self.geometry, *start)] = 0.0
        speed = np.hypot(*(end - start)) / np.maximum(times[1] - times[0], 1.0)
        early, late = self.since - times[1], times[0] - self.until
        deep, high = depths[0] - self.above, self.below - depths[1]
        missed = [speed * np.maximum(np.maximum(early, late), 0.0), np.maximum(np.maximum(deep, high), 0.0)]
        return np.asarray(np.sqrt(away**2 + missed[0] ** 2 + missed[1] ** 2))

    @cached_property
    def _edges(self) -> "STRtree":
        import shapely

        lines = shapely.get_parts(shapely.boundary(self.geometry))
        return shapely.STRtree(
            shapely.linestrings(np.concatenate([_edges(shapely.get_coordinates(line)) for line in lines]))
        )


def _ways(start: Array, end: Array) -> "NDArray[Any]":
    """Lines from start to end; a point where they are one place."""
    import shapely

    lines: NDArray[Any] = shapely.linestrings(np.stack((start.T, end.T), axis=1))
    still = np.all(start == end, axis=0)
    if still.any():
        lines[still] = shapely.points(start.T[still])
    return lines


@dataclass(frozen=True)
class Fence:
    """All zones of a place, and how far the nearest is: most ways pass none.

    Attributes
    ----------
    zones : tuple of Zone
    low, high : array, shape (2,)
        Corners of the part of the plane in which distances are tabulated [m].
    """

    zones: tuple[Zone, ...]
    low: Array
    high: Array

    def near(self, start: Array, end: Array) -> NDArray[np.bool_]:
        """Whether straight ways, shape (2, n), may touch a zone; of those that do, none is left out."""
        near = self._is_near(start, end)
        close = np.flatnonzero(near)
        if close.size:
            cuts = np.linspace(0.0, 1.0, _PARTS + 1)
            points = start[:, close, None] + cuts * (end - start)[:, close, None]
            parts = self._is_near(points[..., :-1].reshape(2, -1), points[..., 1:].reshape(2, -1))
            near[close] = parts.reshape(-1, _PARTS).any(axis=1)
        return near

    def _is_near(self, start: Array, end: Array) -> NDArray[np.bool_]:
        """Whether ways are no farther from a zone than they reach from their middles."""
        middle = 0.5 * (start + end)
        half = 0.5 * np.sqrt(((end - start) ** 2).sum(axis=0))
        step = (self.high - self.low)[:, None] / (_NODES - 1.0)
        node = np.clip(np.rint((middle - self.low[:, None]) / step), 0, _NODES - 1).astype(np.intp)
        away = self.low[:, None] + node * step - middle
        reach = self._distance[node[1], node[0]] - np.sqrt((away**2).sum(axis=0))
        return np.asarray(reach <= half)

    def first(self, start: Array, end: Array, times: Array, depths: Array) -> tuple[Array, NDArray[np.intp]]:
        """Share of straight ways until the first zone, infinite where none is met, and which it is.

        Parameters are those of `Zone.contact`.
        """
        share, which = np.full(start.shape[1], np.inf), np.zeros(start.shape[1], dtype=np.intp)
        close = np.flatnonzero(self.near(start, end))
        if not close.size:
            return share, which
        for number, zone in enumerate(self.zones):
            found = zone.contact(start[:, close], end[:, close], times[:, close], depths[:, close])
            sooner = found < share[close]
            share[close[sooner]], which[close[sooner]] = found[sooner], number
        return share, which

    @cached_property
    def _distance(self) -> Array:
        """From each node to the nearest zone, 0 inside one, shape (`_NODES`, `_NODES`) [m]."""
        import shapely

        east, north = (np.linspace(a, b, _NODES) for a, b in zip(self.low, self.high, strict=True))
        places = shapely.points(*(axis.ravel() for axis in np.meshgrid(east, north)))
        return distances(places, [zone.geometry for zone in self.zones]).reshape(_NODES, _NODES)


def distances(places: "NDArray[Any]", geometries: "Sequence[Geometry]") -> Array:
    """Distance of points to the nearest of some polygons, shape (n,); 0 inside [m]."""
    import shapely

    whole = shapely.union_all(list(geometries))
    shapely.prepare(whole)
    lines = shapely.get_parts(shapely.boundary(whole))
    if not len(lines):
        return np.full(len(places), np.inf)
    edges = np.concatenate([_edges(shapely.get_coordinates(line)) for line in lines])
    tree = shapely.STRtree(shapely.linestrings(edges))
    (asked, _), found = tree.query_nearest(places, return_distance=True, all_matches=False)
    away = np.full(len(places), np.inf)
    away[asked] = found
    away[shapely.intersects(whole, places)] = 0.0
    return away


def _edges(points: Array) -> Array:
    return np.stack((points[:-1], points[1:]), axis=1)
