"""Rules by which a track is cut into legs, as far as a user may change them."""

from dataclasses import dataclass

import numpy as np

from missionplan.importers.track import Series

_DEEPEST_SURFACE = 3.0
_SHALLOWEST_DIVE = 5.0


@dataclass(frozen=True)
class LegRules:
    """Rules for legs.

    Attributes
    ----------
    shortest : float or None
        Time from fix to fix below which a leg does not count [s]; None for the reader's own.
    longest_gap : float or None
        Longest time without a reading that a leg may have [s]; None for 120 s, or four intervals of a slower log.
    dive_depth : float or None
        Depth that a dive reaches [m]; None for 5 m, or a quarter of the depth of a vehicle that stays above 20 m.
    take_out_current : bool
        Whether the current that the vehicle's dead reckoning is carried with is taken out of it.
    """

    shortest: float | None = None
    longest_gap: float | None = None
    dive_depth: float | None = None
    take_out_current: bool = False


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
