"""Columns gathered from one file after another, in little memory."""

import numpy as np

from missionplan.arrays import Array
from missionplan.importers.sourcefiles.channels import MOST, spaced
from missionplan.importers.track import Break

_EXACT = ("t", "lat", "lon", "dr_lat", "dr_lon", "x", "y", "dr_x", "dr_y")
_FINEST, _COARSEST = 0.5, 64.0
"""Intervals to which many rows are thinned [s]."""
_BACKWARDS = 1.0
"""Step back of the times within a file that is a jump of the clock [s]."""


class ColumnStore:
    """Columns of many files; a column that a file lacks is missing there."""

    def __init__(self) -> None:
        self._interval = 0.0
        self._parts: list[dict[str, Array]] = []
        self._joined: dict[str, Array] = {}
        self.breaks: tuple[Break, ...] = ()

    def add(self, columns: dict[str, Array]) -> None:
        """Add the columns of one file, of which `t` has the times since 1970 [s]; rows without a time are left out."""
        t = columns["t"]
        timed = np.isfinite(t)
        part = {name: _small(name, values[timed]) for name, values in columns.items()}
        self.breaks += tuple(clock_jumps(part["t"]))
        self._parts.append(self._thinned(part))
        while sum(len(each["t"]) for each in self._parts) > MOST and self._interval < _COARSEST:
            self._interval = 2.0 * self._interval if self._interval else _FINEST
            self._parts = [self._thinned(each) for each in self._parts]
        self._joined = {}

    def _thinned(self, part: dict[str, Array]) -> dict[str, Array]:
        """Keep one row in each interval, and those that are marked to be kept."""
        if not self._interval:
            return part
        keep = spaced(part["t"], self._interval)
        if "keep" in part:
            keep |= part["keep"] == 1.0
        return {name: values[keep] for name, values in part.items()}

    def __getitem__(self, name: str) -> Array:
        """Values of a column in the order of time."""
        if not self._joined and self._parts:
            names = dict.fromkeys(name for part in self._parts for name in part)
            times = np.concatenate([part["t"] for part in self._parts])
            order = np.argsort(times, kind="stable")
            for each in names:
                self._joined[each] = np.concatenate([_column(part, each) for part in self._parts])[order]
            self._parts = []
        return self._joined.get(name, np.full(len(self._joined.get("t", ())), np.nan))


def _small(name: str, values: Array) -> Array:
    """Halve the memory of all but times and positions, which need their digits."""
    return values if name in _EXACT else values.astype(np.float32)


def _column(part: dict[str, Array], name: str) -> Array:
    return part[name] if name in part else np.full(len(part["t"]), np.nan)


def clock_jumps(t: Array) -> list[Break]:
    """Find where the times of a file, in the order they were written, step back."""
    back = np.flatnonzero(np.diff(t) < -_BACKWARDS)
    return [Break(float(t[k + 1]), f"the clock jumps back ({t[k] - t[k + 1]:.0f} s)") for k in back]
