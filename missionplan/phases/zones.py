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

_SLACK = 1e-3
"""By which the box that holds ways is widened, so that rounding leaves none out [m]."""


@dataclass(frozen=True)
class Zone:
    """A polygon with what it forbids."""

    geometry: "Geometry" = field(repr=False)
    """In the plane [m]."""
    name: str
    is_land: bool
    since: float = -np.inf
    until: float = np.inf
    """When it holds, since the mission's start [s]."""
    above: float = np.inf
    below: float = -np.inf
    """It forbids depths less than `above` and more than `below` [m]."""

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
        (ways, _), distances = self._edges.query_nearest(_ways(start, end), return_distance=True, all_matches=False)
        away[ways] = distances
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
    """All zones of a place."""

    zones: tuple[Zone, ...]

    def reached(self, start: Array, end: Array) -> tuple[int, ...]:
        """Numbers of the zones that straight ways, shape (2, n), may touch: those in the box along their mean course.

        Most blocks of trials pass all zones at a distance, which one look at that box tells.
        """
        import shapely

        course = (end - start).mean(axis=1)
        size = float(np.hypot(*course))
        east, north = course / size if size > 0.0 else (1.0, 0.0)
        turned = np.array([[east, north], [-north, east]])
        ends = np.concatenate((turned @ start, turned @ end), axis=1)
        (left, right), (low, high) = zip(ends.min(axis=1) - _SLACK, ends.max(axis=1) + _SLACK, strict=True)
        corners = np.array([[left, low], [right, low], [right, high], [left, high]]) @ turned
        box = shapely.polygons(corners)
        beside = (self._bounds[:, :2] > corners.max(axis=0)) | (self._bounds[:, 2:] < corners.min(axis=0))
        near = np.flatnonzero(~beside.any(axis=1)).tolist()
        return tuple(number for number in near if shapely.intersects(self._prepared[number], box))

    def first(
        self, start: Array, end: Array, times: Array, depths: Array, reached: Sequence[int]
    ) -> tuple[Array, NDArray[np.intp]]:
        """Share of straight ways until the first zone, infinite where none is met, and which it is.

        Parameters are those of `Zone.contact`, and what `reached` gave.
        """
        share, which = np.full(start.shape[1], np.inf), np.zeros(start.shape[1], dtype=np.intp)
        low, high = np.minimum(start, end), np.maximum(start, end)
        for number in reached:
            bounds = self._bounds[number]
            close = np.flatnonzero(((low <= bounds[2:, None]) & (high >= bounds[:2, None])).all(axis=0))
            shares = self.zones[number].contact(start[:, close], end[:, close], times[:, close], depths[:, close])
            sooner = shares < share[close]
            share[close[sooner]], which[close[sooner]] = shares[sooner], number
        return share, which

    @cached_property
    def _bounds(self) -> Array:
        """West, south, east and north of each zone, shape (k, 4) [m]."""
        return np.array([zone.geometry.bounds for zone in self.zones])

    @cached_property
    def _prepared(self) -> "list[Geometry]":
        import shapely

        for zone in self.zones:
            shapely.prepare(zone.geometry)
        return [zone.geometry for zone in self.zones]


def _edges(points: Array) -> Array:
    return np.stack((points[:-1], points[1:]), axis=1)
