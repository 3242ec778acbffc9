"""Channels gathered from one file or message after another, each with times of its own, in little memory."""

from collections import defaultdict
from collections.abc import Iterable

import numpy as np

from missionplan.arrays import Array
from missionplan.importers.track import Series, series


class ChannelStore:
    """Readings of named channels."""

    def __init__(self) -> None:
        self._parts: dict[str, list[tuple[Array, Array]]] = defaultdict(list)

    def add(self, name: str, t: Array, values: Array) -> None:
        """Add readings of a channel, from one file."""
        if len(t):
            self._parts[name].append((np.asarray(t, dtype=float), np.asarray(values)))

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
    """Readings that come one by one, such as messages."""

    def __init__(self, names: Iterable[str]) -> None:
        from array import array

        self._names = tuple(names)
        self._columns = {name: array("d") for name in self._names}

    def add(self, *values: float) -> None:
        """Add one value of each column."""
        for name, value in zip(self._names, values, strict=True):
            self._columns[name].append(value)

    def __getitem__(self, name: str) -> Array:
        """Values of a column."""
        return np.array(self._columns[name], dtype=float)

    def __len__(self) -> int:
        return len(self._columns[self._names[0]])
