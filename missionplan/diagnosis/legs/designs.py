"""Further legs that might tell two causes apart."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from missionplan.arrays import Array
from missionplan.datasets.legs import TransitData

MORE = 20


def planned(data: TransitData, entry: int) -> TransitData:
    """The log with the legs of a menu entry after it; their fixes are left where dead reckoning puts them."""
    return DESIGNS[entry][1](data)


def _append(data: TransitData, heading: Array, duration: Array, surface: Array) -> TransitData:
    """Append legs steered on given headings for given times, dead-reckoned without error."""
    speed = float(np.median(np.hypot(*(data.dead_reckoned - data.start)) / data.under_way))
    pause = 60.0
    start_times = data.t_start[-1] + data.under_way[-1] + data.surface[-1] + pause
    t_start = start_times + np.concatenate([[0.0], np.cumsum(duration + surface + pause)[:-1]])
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
    )


def _headings(data: TransitData) -> Array:
    path = data.dead_reckoned - data.start
    return np.asarray(np.arctan2(path[0], path[1]))


def _usual(data: TransitData, count: int, factor: float = 1.0) -> tuple[Array, Array]:
    return np.full(count, factor * float(np.median(data.under_way))), np.full(count, float(np.median(data.surface)))


def _numbers() -> Array:
    return np.arange(MORE, dtype=np.float64)


def _back(data: TransitData) -> TransitData:
    return _append(data, _headings(data)[::-1][:MORE] + np.pi, *_usual(data, min(MORE, data.n)))


def _star(data: TransitData) -> TransitData:
    return _append(data, 2.0 * np.pi * 0.38 * _numbers(), *_usual(data, MORE))


def _short(data: TransitData) -> TransitData:
    return _append(data, np.pi * _numbers(), *_usual(data, MORE, 0.25))


def _longer(data: TransitData) -> TransitData:
    return _append(data, _headings(data), data.under_way, data.surface)


def _waiting(data: TransitData) -> TransitData:
    duration, surface = _usual(data, MORE)
    return _append(data, np.pi * _numbers(), duration, surface + np.where(np.arange(MORE) % 2, 900.0, 0.0))


DESIGNS: tuple[tuple[str, Callable[[TransitData], TransitData]], ...] = (
    (f"{MORE} legs back over the last ones, on the reverse headings", _back),
    (f"{MORE} legs all round the compass", _star),
    (f"{MORE} legs there and back, a quarter as long", _short),
    (f"{MORE} legs there and back, every second fix 15 minutes after surfacing", _waiting),
    ("a record twice as long", _longer),
)
"""In words; the log with those legs. Cheapest first."""
