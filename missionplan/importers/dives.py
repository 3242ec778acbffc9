"""Dives between two fixes, where a leg may be, and the rules for them that a user may change."""

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.importers.geodesy import displacement
from missionplan.importers.track import Fixes, Positions, Series, Track

_DEEPEST_SURFACE = 3.0
_SHALLOWEST_DIVE = 5.0
_SILENT = 60.0
"""Time without a fix that is a dive where no depth was logged [s]."""
_NEAR = 300.0
"""How far from a reading its depth is taken for that of a fix [s]."""
_AT_FIX = 60.0
"""How far from a fix a reading still tells what the gauge reads at the surface [s]."""
_FEWEST = 3
"""Readings at the surface that tell it."""
_ABOVE = 1.0
"""How far above the surface's reading waves reach [m]."""
_SHARE_ABOVE = 0.01
"""Share of all readings that may lie further above: more of them show that it was no surface."""
_AT_SURFACE = 0.02
"""Share of the readings that are made at the surface, or above."""
_SEVERAL = 10.0
"""Length of a hole in the log over that of a usual dive from which many may hide in it."""


@dataclass(frozen=True)
class LegRules:
    """Rules for legs."""

    shortest: float | None = None
    """Time from fix to fix below which a leg does not count [s]; None for the reader's own."""
    longest_gap: float | None = None
    """Longest time without a reading that a leg may have [s]; None for 120 s, or four intervals of a slower log."""
    dive_depth: float | None = None
    """Depth that a dive reaches [m]; None for 5 m, or a quarter of the depth of a vehicle that stays above 20 m."""
    take_out_current: bool = False
    """Whether the current that the vehicle's dead reckoning is carried with is taken out of it."""


@dataclass(frozen=True)
class Depths:
    """What counts as a dive, and what as the surface [m]."""

    dive: float
    surface: float


def depths_of(depth: Series, rules: LegRules) -> Depths:
    """Choose depths of dive and surface: by the rule, else by how deep the vehicle goes at all."""
    deep = float(np.quantile(depth.values, 0.95)) if len(depth) else _SHALLOWEST_DIVE
    dive = rules.dive_depth or min(_SHALLOWEST_DIVE, max(0.25 * deep, 0.3))
    return Depths(dive, min(0.6 * dive, _DEEPEST_SURFACE))


def longest_gap(depth: Series, rules: LegRules) -> float:
    """Choose the longest time without a reading [s]."""
    if rules.longest_gap is not None:
        return rules.longest_gap
    interval = float(np.median(np.diff(depth.t))) if len(depth) > 1 else 0.0
    return max(120.0, 4.0 * interval)


@dataclass(frozen=True)
class Candidate:
    """A dive between the last fix before and the first after it."""

    before: int
    after: int
    """Of the good fixes."""
    max_depth: float
    """Greatest depth [m]; nan where none was logged."""
    depth_at_fix: float
    """Depth that the log has at the time of the fix before: large where that fix was logged late [m]."""
    surfaced: float
    """When the vehicle came to the surface [s]; the time of the fix after where that is not known."""
    reckoned_to: float
    """Until when positions are of this dive [s]: that of the fix after, or of surfacing where it was logged late."""


def from_surface(track: Track, good: Fixes) -> tuple[Track, float, str]:
    """Count depths downwards from what the gauge reads at the surface, and say so where that is not near 0.

    The surface is known by the vehicle's own ``state``, else by its ``fixes``, which it takes there, or is
    ``assumed``; returned are the track, what the gauge reads there [m], and by which it is known.
    """
    track = downwards(track)
    depth = track.depth
    if not len(depth):
        notice = f"no depth is logged: a dive is what lies between fixes {_SILENT:g} s or more apart"
        return replace(track, notices=(*track.notices, notice)), 0.0, "assumed"
    zero, by = _surface_reading(depth, track.at_surface, good)
    if abs(zero) <= _ABOVE:
        return track, 0.0, by
    notice = f"the depth gauge reads {zero:.1f} m at the surface: depths count from there"
    depth = replace(depth, values=depth.values - zero)
    return replace(track, depth=depth, notices=(*track.notices, notice)), zero, by


def downwards(track: Track) -> Track:
    """Turn the sign of depths that are logged as heights, and say so."""
    depth = track.depth
    if not len(depth) or np.quantile(depth.values, 0.05) >= -max(2.0, 2.0 * np.quantile(depth.values, 0.95)):
        return track
    notice = "depths are logged as heights, less than 0 under water: their sign was turned"
    return replace(track, depth=replace(depth, values=-depth.values), notices=(*track.notices, notice))


def shallowest(depth: Series) -> float:
    """What the gauge reads at the surface, where nothing but its readings tells it, and where it is below 0 [m]."""
    return max(float(np.quantile(depth.values, _AT_SURFACE)), 0.0)


def _surface_reading(depth: Series, at_surface: Series, good: Fixes) -> tuple[float, str]:
    """What the gauge reads at the surface [m], and by which that is known; 0 where it is not.

    A fix may be logged late, when the vehicle is deep: the lower quartile of the readings at fixes counts, if
    nearly none lie above it.
    """
    by_state = depth.values[at_surface.held(depth.t) == 1.0] if len(at_surface) else np.empty(0)
    if len(by_state) >= _FEWEST:
        return float(np.median(by_state)), "state"
    at_fix = depth_near(depth, good.t, _AT_FIX)
    readings = at_fix[np.isfinite(at_fix)]
    if len(readings) < _FEWEST:
        return 0.0, "assumed"
    zero = float(np.quantile(readings, 0.25))
    return (zero, "fixes") if np.mean(depth.values < zero - _ABOVE) < _SHARE_ABOVE else (0.0, "assumed")


def logged_again(good: Fixes, depth: Series, depths: Depths) -> NDArray[np.bool_]:
    """Fixes that are the one before a dive, logged again under water or after it until a new one is had, shape (n,).

    Where no other comes, or none before the next dive, the vehicle may have stayed in its place.
    """
    is_same = np.append(False, (np.diff(good.latitude) == 0.0) & (np.diff(good.longitude) == 0.0))[: len(good)]
    place = np.cumsum(~is_same)
    again: NDArray[np.bool_] = is_same & (depth.at(good.t) > depths.surface) & (place < np.max(place, initial=0))
    left = np.flatnonzero(~again)
    kept = good[left]
    dive = np.searchsorted(depth.t[depth.values >= depths.dive], kept.t)
    edges = [0, *(np.flatnonzero(np.diff(dive)) + 1), len(kept)]
    for begin, end in pairwise(edges[1:]):
        same = [coordinate[begin:end] == coordinate[begin - 1] for coordinate in (kept.latitude, kept.longitude)]
        is_old = np.all(same, axis=0)
        again[left[begin:end]] = is_old & ~is_old.all()
    return again


def find_candidates(fixes: Fixes, depth: Series, depths: Depths, longest_gap: float) -> list[Candidate]:
    """Find the dives between consecutive fixes.

    A fix cannot be taken under water: one that is logged while the vehicle is deep was taken before that dive, and
    ends one only if the vehicle had been at the surface in between. A hole in the log that is longer than several
    dives is told as one, for nothing is known of what happened in it.
    """
    if not len(depth):
        gaps = np.flatnonzero(np.diff(fixes.t) >= _SILENT)
        ends = [float(fixes.t[k + 1]) for k in gaps]
        return [Candidate(int(k), int(k) + 1, np.nan, np.nan, t, t) for k, t in zip(gaps, ends, strict=True)]
    at_fix = depth_near(depth, fixes.t, _NEAR)
    dives, holes = [], []
    for k in range(len(fixes) - 1):
        start, end = float(fixes.t[k]), float(fixes.t[k + 1])
        during = depth.within(start, end)
        deepest = float(during.values.max()) if len(during) else np.nan
        is_late = bool(at_fix[k + 1] > depths.surface)
        before = _before_last_descent(during, depths, longest_gap) if is_late else during
        if deepest >= depths.dive and len(before) and before.values.max() >= depths.dive:
            surfaced = _surfaced(before, depths, end)
            dives.append(Candidate(k, k + 1, deepest, float(at_fix[k]), surfaced, surfaced if is_late else end))
        else:
            hole = float(np.diff(np.concatenate([[start], during.t, [end]])).max())
            holes.append((hole, Candidate(k, k + 1, deepest, float(at_fix[k]), end, end)))
    usual = float(np.median([fixes.t[dive.after] - fixes.t[dive.before] for dive in dives] or [np.inf]))
    dives += [dive for hole, dive in holes if hole > _SEVERAL * usual]
    return sorted(dives, key=lambda dive: dive.before)


def depth_near(depth: Series, t: Array, near: float) -> Array:
    """Depth at some times [m]; nan farther than `near` from any reading, before the first and after the last."""
    if not len(depth):
        return np.full(len(t), np.nan)
    after = np.searchsorted(depth.t, t)
    before, after = np.maximum(after - 1, 0), np.minimum(after, len(depth) - 1)
    away = np.minimum(np.abs(depth.t[before] - t), np.abs(depth.t[after] - t))
    return np.asarray(np.where((away <= near) & (t >= depth.t[0]) & (t <= depth.t[-1]), depth.at(t), np.nan))


def _before_last_descent(during: Series, depths: Depths, longest_gap: float) -> Series:
    """Readings before the descent that a late fix stands in: up to the last one at the surface, or to a hole."""
    ends = np.flatnonzero(during.values <= depths.surface)
    holes = np.flatnonzero(np.diff(during.t) > longest_gap)
    last = max([int(indices[-1]) for indices in (ends, holes) if len(indices)], default=-1)
    return Series(during.t[: last + 1], during.values[: last + 1])


def _surfaced(during: Series, depths: Depths, fix: float) -> float:
    """When a vehicle that dived last came up to the surface [s]: between two readings where it crossed that depth."""
    deep = np.flatnonzero(during.values > depths.surface)
    last = int(deep[-1])
    if last + 1 >= len(during):
        return fix
    upper, lower = during.values[last + 1], during.values[last]
    share = (lower - depths.surface) / max(lower - upper, 1e-9)
    return float(during.t[last] + share * (during.t[last + 1] - during.t[last]))


def split_at_surface(track: Track, line: Positions) -> Track:
    """Split the vehicle's own positions into dead-reckoned ones, under water, and fixes, at the surface.

    At the surface the position is dead-reckoned until it jumps to the fix: fixes count from the greatest step on that
    the position makes while the vehicle comes up and stays there. Where positions are blank under water, or no depth
    tells it apart, all are fixes.
    """
    if not len(track.depth) or not len(line):
        return track
    track = downwards(track)
    zero = shallowest(track.depth)
    depth = replace(track.depth, values=track.depth.values - (zero if zero > _ABOVE else 0.0))
    under = depth.at(line.t) > depths_of(depth, LegRules()).surface
    if not under.any():
        return track
    is_fix = ~under
    starts = np.flatnonzero(under[:-1] & ~under[1:]) + 1
    for start in starts:
        after = np.flatnonzero(under[start:])
        end = start + int(after[0]) if len(after) else len(line)
        rows = slice(start - 1, end)
        steps = np.hypot(*displacement(line.latitude[rows][:-1], line.longitude[rows][:-1], line.latitude[rows][1:],
                                       line.longitude[rows][1:]))  # fmt: skip
        is_fix[start : start + int(np.argmax(steps))] = False
    notice = (
        "one position alone: it is taken for a fix at the surface, from its greatest step on, and as dead-reckoned else"
    )
    return replace(
        track,
        fixes=track.fixes[np.isin(track.fixes.t, line.t[is_fix])],
        reckoned=Positions(line.t[~is_fix], line.latitude[~is_fix], line.longitude[~is_fix]),
        reckoning="the vehicle's one position, under water",
        notices=(*track.notices, notice),
    )
