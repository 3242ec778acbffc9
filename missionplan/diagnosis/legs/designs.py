"""Designs: further legs that might discriminate between two sets of causes."""

from collections.abc import Callable, Iterator
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
GOLDEN_SHARE = 0.38
"""Share of a circle between consecutive headings that spread evenly: 1 less the golden ratio's 0.62."""


def with_further_legs(data: TransitData, design: int) -> TransitData:
    """Append the legs of a design to a log; their fixes lie where dead reckoning puts them."""
    return DESIGNS[design][1](data)


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


def _headings(data: TransitData) -> Array:
    path = data.dead_reckoned - data.start
    return np.asarray(np.arctan2(path[0], path[1]))


def _median_times(data: TransitData, count: int, factor: float = 1.0) -> tuple[Array, Array]:
    """Median time under way, by a factor, and median time at the surface, for each of the new legs [s]."""
    return np.full(count, factor * float(np.median(data.under_way))), np.full(count, float(np.median(data.surface)))


def _leg_numbers() -> Array:
    return np.arange(FURTHER_LEGS, dtype=np.float64)


def _reverse_course(data: TransitData) -> TransitData:
    return _append(data, _headings(data)[::-1][:FURTHER_LEGS] + np.pi, *_median_times(data, min(FURTHER_LEGS, data.n)))


def _all_headings(data: TransitData) -> TransitData:
    return _append(data, 2.0 * np.pi * GOLDEN_SHARE * _leg_numbers(), *_median_times(data, FURTHER_LEGS))


def _short_legs(data: TransitData) -> TransitData:
    return _append(data, np.pi * _leg_numbers(), *_median_times(data, FURTHER_LEGS, 0.25))


def _late_fixes(data: TransitData) -> TransitData:
    duration, surface = _median_times(data, FURTHER_LEGS)
    late = np.where(np.arange(FURTHER_LEGS) % 2, LATE_FIX, 0.0)
    return _append(data, np.pi * _leg_numbers(), duration, surface + late)


def _twice_as_long(data: TransitData) -> TransitData:
    return _append(data, _headings(data), data.under_way, data.surface)


def short_trials(data: TransitData) -> Iterator[tuple[str, TransitData]]:
    """Return what a few further legs may differ in, in words, and the log with `TRIAL_LEGS` of them."""
    heading = 2.0 * np.pi * GOLDEN_SHARE * _leg_numbers()[:TRIAL_LEGS]
    usual, quarter = (_median_times(data, TRIAL_LEGS, factor) for factor in (1.0, 0.25))
    yield "a quarter as long", _append(data, heading, *quarter)
    yield "as usual", _append(data, heading, *usual)
    yield f"at {SLOWER:g} of the speed", _append(data, heading, *usual, speed=SLOWER)
    if data.depth is not None:
        yield "half as deep", _append(data, heading, *usual, depth=0.5)
    yield "six hours later", _append(data, heading, *usual, pause=LATER)


NEEDS_SURFACE_TIME = (_late_fixes,)
DESIGNS: tuple[tuple[str, Callable[[TransitData], TransitData]], ...] = (
    (f"{FURTHER_LEGS} legs back over the last ones, on the reverse headings", _reverse_course),
    (f"{FURTHER_LEGS} legs all round the compass", _all_headings),
    (f"{FURTHER_LEGS} legs there and back, a quarter as long", _short_legs),
    (f"{FURTHER_LEGS} legs there and back, every second fix 15 minutes after surfacing", _late_fixes),
    ("a record twice as long", _twice_as_long),
)
"""In words; the log with those legs. Cheapest first."""


def designs_for(data: TransitData) -> tuple[int, ...]:
    """Indices of the designs that can be compared with a log."""
    return tuple(
        index for index, (_, extend) in enumerate(DESIGNS) if data.has_surface_time or extend not in NEEDS_SURFACE_TIME
    )
