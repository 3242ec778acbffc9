"""Channels gathered from one file or message after another, each with times of its own, in little memory."""

import math
from array import array
from collections import defaultdict
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.importers.track import Series, series

MOST = 1_000_000
"""Readings that are held of one channel: of more, one in half a second, in a second and so on is kept."""
_FINEST = 0.5


def spaced(t: Array, interval: float) -> NDArray[np.bool_]:
    """Which readings to keep for one in each interval [s]: the first in it, in the order that they came."""
    which = np.floor(np.asarray(t) / interval)
    return np.append(True, which[1:] != which[:-1])[: len(which)]


class ChannelStore:
    """Readings of named channels."""

    def __init__(self) -> None:
        self._parts: dict[str, list[tuple[Array, Array]]] = defaultdict(list)
        self._intervals: dict[str, float] = {}

    def add(self, name: str, t: Array, values: Array) -> None:
        """Add readings of a channel, from one file."""
        if not len(t):
            return
        t, values = np.asarray(t, dtype=float), np.asarray(values)
        if name in self._intervals:
            keep = spaced(t, self._intervals[name])
            t, values = t[keep], values[keep]
        self._parts[name].append((t, values))
        while sum(len(part) for part, _ in self._parts[name]) > MOST:
            self._intervals[name] = 2.0 * self._intervals.get(name, 0.5 * _FINEST)
            kept = [(part, held, spaced(part, self._intervals[name])) for part, held in self._parts[name]]
            self._parts[name] = [(part[keep], held[keep]) for part, held, keep in kept]

    def series(self, name: str, factor: float = 1.0) -> Series:
        """Return a channel's readings in the order of time, times a factor."""
        t, values = self.joined(name)
        return series(t, values * factor)

    def joined(self, name: str) -> tuple[Array, Array]:
        """Times and values of a channel, in the order they were added."""
        parts = self._parts.get(name, [])
        if not parts:
            return np.empty(0), np.empty(0)
        return np.concatenate([t for t, _ in parts]), np.concatenate([values for _, values in parts])

    def at(self, name: str, t: Array) -> Array:
        """Values of a channel at exactly these times; nan where it has none."""
        known = self.series(name)
        place = np.searchsorted(known.t, t)
        found = np.full(len(t), np.nan)
        inside = place < len(known)
        hit = np.flatnonzero(inside)[known.t[place[inside]] == t[inside]]
        found[hit] = known.values[place[hit]]
        return found

    def __contains__(self, name: object) -> bool:
        return bool(self._parts.get(str(name)))


class Samples:
    """Readings that come one by one, such as messages; the first column has the times [s]."""

    def __init__(self, names: Iterable[str]) -> None:
        self._names = tuple(names)
        self._columns = {name: array("d") for name in self._names}
        self._rows = list(self._columns.values())
        self._interval, self._last = 0.0, math.nan

    def add(self, *values: float) -> None:
        """Add one value of each column."""
        if self._interval:
            which = values[0] // self._interval
            if which == self._last:
                return
            self._last = which
        for column, value in zip(self._rows, values, strict=True):
            column.append(value)
        if len(self._rows[0]) > MOST:
            self._thin()

    def _thin(self) -> None:
        self._interval = 2.0 * (self._interval or 0.5 * _FINEST)
        keep = spaced(self[self._names[0]], self._interval)
        for name, column in self._columns.items():
            column[:] = array("d", self[name][keep].tobytes())

    def __getitem__(self, name: str) -> Array:
        """Values of a column."""
        return np.array(self._columns[name], dtype=float)

    def __len__(self) -> int:
        return len(self._columns[self._names[0]])
