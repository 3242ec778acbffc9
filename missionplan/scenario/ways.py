"""Water that a transit cannot pass, as polygons, and the shortest way round it."""

import heapq
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from missionplan.arrays import Array
from missionplan.phases.ground import Ground
from missionplan.phases.place import Place

if TYPE_CHECKING:
    from shapely import Geometry

_MOST_NODES = 1200
"""Of the lattice on which depths are contoured, along each side; two a cell of the grid where these suffice."""
_REACHES = (1.0, 4.0)
"""How far from start and goal a way is sought, in their distance."""
_LENIENT = 0.8
"""Share of the margin that a way keeps which leaves out a point: it is worth more than a turn less."""


def blocked(place: Place, low: Array, high: Array, depth: float, *, at_some_time: bool) -> "Geometry":
    """Return what a vehicle at a depth cannot pass within a part of the plane: zones, and water too shallow or unknown.

    Parameters
    ----------
    place : Place
        At the means.
    low, high : array, shape (2,)
        Corners of that part [m].
    depth : float
        Of the transit [m].
    at_some_time : bool
        Whether zones count that hold at some times alone. Without them nothing is returned that might be passed: shoals
        less a node of the lattice, and none where that is coarser than the grid.
    """
    import shapely

    parts = [
        zone.geometry
        for zone in place.zones
        if zone.below < depth < zone.above and (at_some_time or (zone.since, zone.until) == (-np.inf, np.inf))
    ]
    if place.ground is not None:
        parts.append(_shoals(place, place.ground, (low, high), depth, surely=not at_some_time))
    return shapely.union_all([part for part in parts if not part.is_empty] or [shapely.Polygon()])


def _shoals(place: Place, ground: Ground, box: tuple[Array, Array], depth: float, *, surely: bool) -> "Geometry":
    """Water that is not deeper than a vehicle at a depth needs, by contours on a lattice, at the start's sea level."""
    import shapely
    from contourpy import FillType, contour_generator

    low, high = box
    step = max(0.5 * ground.cell, float((high - low).max()) / (_MOST_NODES - 1.0))
    if surely and step > ground.cell:
        return shapely.Polygon()
    low, high = low - 2.0 * step, high + 2.0 * step  # what is shrunk is shrunk at the box's edges too
    east, north = (np.linspace(a, b, int(np.ceil((b - a) / step)) + 1) for a, b in zip(low, high, strict=True))
    places = np.stack([axis.ravel() for axis in np.meshgrid(east, north)])
    water = place.water_at(places, np.zeros(places.shape[1])).reshape(north.size, east.size)
    needed = depth + float(np.mean(place.draught)) + float(np.mean(place.clearance))
    lines = contour_generator(east, north, np.nan_to_num(water, nan=-1e4), fill_type=FillType.OuterOffset)
    outlines, offsets = lines.filled(-1e5, needed)[:2]
    rings = [
        [outline[a:b] for a, b in pairwise(starts.tolist())]
        for outline, starts in zip(outlines, offsets, strict=True)
        if outline is not None and starts is not None
    ]
    shoals = shapely.union_all([shapely.make_valid(shapely.Polygon(ring[0], ring[1:])) for ring in rings])
    return shoals.buffer(-step) if surely else shoals


def way_round(place: Place, start: Array, goal: Array, depth: float, margin: float) -> tuple[Array, ...] | None:
    """Return the points between start and goal of the shortest way that keeps a margin; None where there is none.

    The way of a visibility graph over the corners of what blocks it, grown by the margin (de Berg et al.,
    *Computational Geometry*, ch. 15), by Dijkstra's algorithm. About start and goal, which may lie nearer to a coast,
    the margin is what they have. Where there is no way near them, it is sought farther away.
    """
    span = max(float(np.hypot(*(goal - start))), 4.0 * margin)
    ways = (_way_within(place, (start, goal), depth, margin, reach * span) for reach in _REACHES)
    return next((way for way in ways if way is not None), None)


def _way_within(
    place: Place, between: tuple[Array, Array], depth: float, margin: float, span: float
) -> tuple[Array, ...] | None:
    """Return the points of the shortest way that goes no farther than a span [m] about start and goal."""
    import shapely

    start, goal = between
    low, high = np.minimum(start, goal) - span, np.maximum(start, goal) + span
    walls = blocked(place, low, high, depth, at_some_time=True)
    ends = shapely.points(np.stack((start, goal)))
    spare = 0.999 * np.minimum(shapely.distance(walls, ends), margin) if not walls.is_empty else np.full(2, margin)
    if np.any(spare <= 0.0):
        return None
    grown = walls.buffer(margin, join_style="mitre", mitre_limit=1.5)
    for end, room in zip(ends, spare, strict=True):
        grown = grown.difference(end.buffer(2.0 * margin)).union(
            walls.buffer(room).intersection(end.buffer(2.0 * margin))
        )
    grown = grown.simplify(0.02 * margin)
    shrunk = grown.buffer(-0.03 * margin)
    corners = shapely.get_coordinates(grown)  # what blocks goes on outside the part that is looked at, the way does not
    corners = corners[np.all((corners >= low) & (corners <= high), axis=1)]
    nodes = np.concatenate(
        (np.stack((start, goal)), corners[~shapely.intersects_xy(shrunk, corners[:, 0], corners[:, 1])])
    )
    way = _shortest(nodes, shrunk)
    return None if way is None else _fewer([nodes[node] for node in way], shrunk.buffer((_LENIENT - 0.97) * margin))


def _fewer(way: list[Array], walls: "Geometry") -> tuple[Array, ...]:
    """Leave out points of a way between whose neighbours it is straight on, clear of walls."""
    import shapely

    place = 1
    while place < len(way) - 1:
        straight = shapely.linestrings(np.stack((way[place - 1], way[place + 1])))
        if shapely.intersects(walls, straight):
            place += 1
        else:
            del way[place]
    return tuple(way[1:-1])


def _shortest(nodes: Array, walls: "Geometry") -> list[int] | None:
    """Return the nodes of the shortest way from the first to the second that crosses no wall."""
    import shapely

    shapely.prepare(walls)
    best, before = np.full(len(nodes), np.inf), np.full(len(nodes), -1)
    best[0], queue, done = 0.0, [(0.0, 0)], np.zeros(len(nodes), dtype=bool)
    while queue:
        length, here = heapq.heappop(queue)
        if done[here]:
            continue
        done[here] = True
        if here == 1:
            way = [1]
            while way[-1] != 0:
                way.append(int(before[way[-1]]))
            return way[::-1]
        step = np.hypot(*(nodes - nodes[here]).T)
        nearer = np.flatnonzero(~done & (length + step < best))
        pairs = np.stack((np.broadcast_to(nodes[here], (nearer.size, 2)), nodes[nearer]), axis=1)
        open_ = nearer[~shapely.intersects(walls, shapely.linestrings(pairs))] if nearer.size else nearer
        best[open_], before[open_] = length + step[open_], here
        for node in open_.tolist():
            heapq.heappush(queue, (float(best[node]), node))
    return None
