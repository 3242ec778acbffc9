"""Designs: further legs that might discriminate between two sets of causes."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from missionplan.arrays import Array
from missionplan.datasets.records import TransitData

FURTHER_LEGS = 20
PAUSE = 60.0
"""Time between a fix and the next dive [s]."""
LATE_FIX = 900.0
"""Time at the surface before a late fix, beyond the usual [s]."""
TRIAL_LEGS = 12
"""Legs of a short trial, at most."""
SLOWER = 0.7
"""Part of the usual speed at which legs of another speed are made."""
LATER = 6.0 * 3600.0
"""Half a tide [s]."""
ALL_ROUND = 2.0 * np.pi * 0.38 * np.arange(FURTHER_LEGS, dtype=np.float64)
"""Headings that spread evenly [rad]: 1 less the golden ratio's 0.62 is the share of a circle between two of them."""


DESIGNS = (
    f"{FURTHER_LEGS} legs back over the last ones, on the reverse headings",
    f"{FURTHER_LEGS} legs all round the compass",
    f"{FURTHER_LEGS} legs there and back, a quarter as long",
    f"{FURTHER_LEGS} legs there and back, every second fix 15 minutes after surfacing",
    "a record twice as long",
)
"""In words, cheapest first."""
LATE_FIXES = 3
"""The design that is of no use to a log without times at the surface."""


def with_further_legs(data: TransitData, design: int) -> TransitData:
    """Append the legs of a design to a log; their fixes lie where dead reckoning puts them."""
    path, numbers = data.dead_reckoned - data.start, np.arange(FURTHER_LEGS, dtype=np.float64)
    sailed, there_and_back = np.asarray(np.arctan2(path[0], path[1])), np.pi * numbers
    duration, surface = _median_times(data, FURTHER_LEGS)
    legs = (  # headings, times under way and at the surface
        (sailed[::-1][:FURTHER_LEGS] + np.pi, *_median_times(data, min(FURTHER_LEGS, data.n))),
        (ALL_ROUND, duration, surface),
        (there_and_back, *_median_times(data, FURTHER_LEGS, 0.25)),
        (there_and_back, duration, surface + np.where(numbers % 2, LATE_FIX, 0.0)),
        (sailed, data.under_way, data.surface),
    )
    return _append(data, *legs[design])


def _append(
    data: TransitData,
    heading: Array,
    duration: Array,
    surface: Array,
    *,
    speed: float = 1.0,
    depth: float = 1.0,
    pause: float = PAUSE,
) -> TransitData:
    """Append legs on given headings [rad] and of given times [s], dead-reckoned without error.

    After a pause [s], at these parts of the usual speed and depth.
    """
    speed = speed * float(np.median(np.hypot(*(data.dead_reckoned - data.start)) / data.under_way))
    first = data.t_start[-1] + data.under_way[-1] + data.surface[-1] + pause
    t_start = first + np.concatenate([[0.0], np.cumsum(duration + surface + PAUSE)[:-1]])
    path = speed * duration * np.stack([np.sin(heading), np.cos(heading)])
    ends = data.end[:, -1:] + np.cumsum(path, axis=1)
    starts = ends - path
    return replace(
        data,
        labels=np.concatenate([data.labels, np.array([f"new {k + 1}" for k in range(len(heading))])]),
        run=np.concatenate([data.run, np.full(len(heading), data.run[-1])]),
        t_start=np.concatenate([data.t_start, t_start]),
        under_way=np.concatenate([data.under_way, duration]),
        surface=np.concatenate([data.surface, surface]),
        start=np.concatenate([data.start, starts], axis=1),
        dead_reckoned=np.concatenate([data.dead_reckoned, ends], axis=1),
        end=np.concatenate([data.end, ends + 1e-3], axis=1),
        leg_fix_sd=_with_typical(data.leg_fix_sd, len(heading)),
        depth=_with_typical(data.depth, len(heading), depth),
    )


def _with_typical(values: Array | None, new: int, factor: float = 1.0) -> Array | None:
    """What is known leg by leg, with the median of it by a factor for further legs; None where nothing is."""
    return None if values is None else np.append(values, np.full(new, factor * np.nanmedian(values)))


def _median_times(data: TransitData, count: int, factor: float = 1.0) -> tuple[Array, Array]:
    """Median time under way, by a factor, and median time at the surface, for each of the new legs [s]."""
    return np.full(count, factor * float(np.median(data.under_way))), np.full(count, float(np.median(data.surface)))


def short_trials(data: TransitData) -> Iterator[tuple[str, TransitData]]:
    """Return what a few further legs may differ in, in words, and the log with `TRIAL_LEGS` of them."""
    heading = ALL_ROUND[:TRIAL_LEGS]
    usual, quarter = (_median_times(data, TRIAL_LEGS, factor) for factor in (1.0, 0.25))
    yield "a quarter as long", _append(data, heading, *quarter)
    yield "as usual", _append(data, heading, *usual)
    yield f"at {SLOWER:g} of the speed", _append(data, heading, *usual, speed=SLOWER)
    if data.depth is not None:
        yield "half as deep", _append(data, heading, *usual, depth=0.5)
    yield "six hours later", _append(data, heading, *usual, pause=LATER)


def designs_for(data: TransitData) -> tuple[int, ...]:
    """Indices of the designs that can be compared with a log."""
    return tuple(index for index in range(len(DESIGNS)) if data.has_surface_time or index != LATE_FIXES)
