"""Dives between two fixes: where a leg may be."""

from dataclasses import dataclass

import numpy as np

from missionplan.arrays import Array
from missionplan.importers.legs.rules import Depths
from missionplan.importers.track import Fixes, Series

_SILENT = 60.0
"""Time without a fix that is a dive where no depth was logged [s]."""
_NEAR = 300.0
"""How far from a reading its depth is taken for that of a fix [s]."""


@dataclass(frozen=True)
class Candidate:
    """A dive between the last fix before and the first after it.

    Attributes
    ----------
    before, after : int
        Of the good fixes.
    max_depth : float
        Greatest depth [m]; nan where none was logged.
    depth_at_fix : float
        Depth that the log has at the time of the fix before: large where that fix was logged late [m].
    surfaced : float
        When the vehicle came to the surface [s]; the time of the fix after where that is not known.
    """

    before: int
    after: int
    max_depth: float
    depth_at_fix: float
    surfaced: float


def find_candidates(fixes: Fixes, depth: Series, depths: Depths) -> list[Candidate]:
    """Find the dives between consecutive fixes.

    A fix cannot be taken under water: one that is logged while the vehicle is deep was taken before the dive, and
    ends none.
    """
    if not len(depth):
        gaps = np.flatnonzero(np.diff(fixes.t) >= _SILENT)
        return [Candidate(int(k), int(k) + 1, np.nan, np.nan, float(fixes.t[k + 1])) for k in gaps]
    at_fix = _depth_near(depth, fixes.t)
    found = []
    for k in range(len(fixes) - 1):
        during = depth.within(float(fixes.t[k]), float(fixes.t[k + 1]))
        deepest = float(during.values.max()) if len(during) else np.nan
        if deepest >= depths.dive and not at_fix[k + 1] > depths.surface:
            surfaced = _surfaced(during, depths, float(fixes.t[k + 1]))
            found.append(Candidate(k, k + 1, deepest, float(at_fix[k]), surfaced))
    return found


def _depth_near(depth: Series, t: Array) -> Array:
    """Depth at some times [m]; nan far from any reading, before the first and after the last."""
    after = np.searchsorted(depth.t, t)
    before, after = np.maximum(after - 1, 0), np.minimum(after, len(depth) - 1)
    away = np.minimum(np.abs(depth.t[before] - t), np.abs(depth.t[after] - t))
    return np.asarray(np.where((away <= _NEAR) & (t >= depth.t[0]) & (t <= depth.t[-1]), depth.at(t), np.nan))


def _surfaced(during: Series, depths: Depths, fix: float) -> float:
    """When a vehicle that dived last came up to the surface [s]: between two readings where it crossed that depth."""
    deep = np.flatnonzero(during.values > depths.surface)
    last = int(deep[-1])
    if last + 1 >= len(during):
        return fix
    upper, lower = during.values[last + 1], during.values[last]
    share = (lower - depths.surface) / max(lower - upper, 1e-9)
    return float(during.t[last] + share * (during.t[last + 1] - during.t[last]))
