"""What a reader makes of a source: a track with fixes, dead-reckoned positions and what else was logged."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from dataclasses import fields as dataclass_fields
from itertools import pairwise
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.errors import InputError, Problem
from missionplan.moments import YET_TO_COME

_NONE = np.empty(0)
_SAME_PLACE = 1e-4
"""Difference of latitude and longitude of readings that are of one fix [deg]."""
SILENCE = 30.0 * 86400.0
"""Time without any reading that lies between two deployments [s]."""


@dataclass(frozen=True)
class Series:
    """A logged quantity: times since 1970 [s], which increase, and values, shape (n,) each."""

    t: Array = field(default_factory=lambda: _NONE)
    values: Array = field(default_factory=lambda: _NONE)

    def __len__(self) -> int:
        return len(self.t)

    def within(self, start: float, end: float) -> "Series":
        """Keep the readings from `start` to `end`, both included."""
        first, last = np.searchsorted(self.t, start), np.searchsorted(self.t, end, side="right")
        return Series(self.t[first:last], self.values[first:last])

    def at(self, t: Array) -> Array:
        """Interpolate at times [s]; the first and last values beyond the ends, nan where nothing was logged."""
        if not len(self):
            return np.full(np.shape(t), np.nan)
        return np.asarray(np.interp(t, self.t, self.values))

    def held(self, t: Array) -> Array:
        """Values at times [s] that hold until the next reading, as states do; nan before the first."""
        index = np.searchsorted(self.t, t, side="right") - 1
        return np.where(index >= 0, self.values[np.maximum(index, 0)], np.nan) if len(self) else np.full(len(t), np.nan)

    def latest(self, t: float, oldest: float) -> float:
        """Return the last value at or before `t` that is not older than `oldest`; nan where there is none [s]."""
        index = int(np.searchsorted(self.t, t, side="right")) - 1
        return float(self.values[index]) if index >= 0 and self.t[index] >= oldest else float("nan")


def series(t: Array, values: Array) -> Series:
    """Make a series of readings in any order: missing ones left out, in the order of time, one for each time."""
    t, values = np.asarray(t, dtype=float), np.asarray(values)
    there = np.isfinite(t) & np.isfinite(values)
    t, first = np.unique(t[there], return_index=True)
    return Series(t, values[there][first])


@dataclass(frozen=True)
class Positions:
    """Positions: times since 1970 [s], which increase, latitude and longitude [deg], shape (n,) each."""

    t: Array = field(default_factory=lambda: _NONE)
    latitude: Array = field(default_factory=lambda: _NONE)
    longitude: Array = field(default_factory=lambda: _NONE)

    def __len__(self) -> int:
        return len(self.t)

    def within(self, start: float, end: float) -> "Positions":
        """Keep the positions from `start` on and before `end`."""
        first, last = np.searchsorted(self.t, (start, end))
        return Positions(self.t[first:last], self.latitude[first:last], self.longitude[first:last])


def positions(t: Array, latitude: Array, longitude: Array) -> Positions:
    """Make positions of readings in any order: those that are none left out, in the order of time, one a time."""
    t, latitude, longitude = (np.asarray(column, dtype=float) for column in (t, latitude, longitude))
    there = np.isfinite(t) & is_place(latitude, longitude)
    t, first = np.unique(t[there], return_index=True)
    return Positions(t, latitude[there][first], longitude[there][first])


def is_place(latitude: Array, longitude: Array) -> NDArray[np.bool_]:
    """Whether a position can be one: degrees within bounds, and not the 0, 0 that stands for no position."""
    with np.errstate(invalid="ignore"):
        inside = (np.abs(latitude) <= 90.0) & (np.abs(longitude) <= 360.0)
    return np.asarray(inside & ~((latitude == 0.0) & (longitude == 0.0)))


@dataclass(frozen=True)
class Fixes:
    """Fixes of a satellite receiver as logged, shape (n,) each; nan where a quality was not logged."""

    t: Array
    latitude: Array
    longitude: Array
    """Time since 1970 [s] and position [deg]."""
    accuracy: Array
    """Horizontal accuracy that the receiver states [m]."""
    hdop: Array
    """Horizontal dilution of precision."""
    satellites: Array
    """Number in use."""
    valid: Array
    """1 where the log calls the fix valid, 0 where not, nan where it says neither."""

    def __len__(self) -> int:
        return len(self.t)

    def __getitem__(self, keep: NDArray[np.bool_] | NDArray[np.intp]) -> "Fixes":
        return Fixes(*(getattr(self, name)[keep] for name in self.__dataclass_fields__))


def fixes(
    t: Array,
    latitude: Array,
    longitude: Array,
    *,
    accuracy: Array | None = None,
    hdop: Array | None = None,
    satellites: Array | None = None,
    valid: Array | None = None,
) -> Fixes:
    """Make fixes of readings in any order: those that are no positions left out, in the order of time.

    Of readings of one time and nearly one place the first is kept; one elsewhere stays, to be judged.
    """
    t = np.asarray(t, dtype=float)
    unknown = np.full(len(t), np.nan)
    channels = (latitude, longitude, accuracy, hdop, satellites, valid)
    columns = [unknown if channel is None else np.asarray(channel, dtype=float) for channel in channels]
    there = np.flatnonzero(np.isfinite(t) & is_place(columns[0], columns[1]))
    readings = Fixes(t, *columns)[there[np.argsort(t[there], kind="stable")]]
    steps = (np.abs(np.diff(coordinate)) for coordinate in (readings.latitude, readings.longitude))
    again = (np.diff(readings.t) == 0.0) & np.all([step < _SAME_PLACE for step in steps], axis=0)
    return readings[np.append(True, ~again)[: len(readings)]]


def columns_of(kind: type[Series | Positions | Fixes], parts: Sequence[object]) -> dict[str, Array]:
    """Columns of several series, positions or fixes by name, those of one part after another's."""
    names = [column.name for column in dataclass_fields(kind)]
    return {name: np.concatenate([getattr(part, name) for part in parts] or [_NONE]) for name in names}


@dataclass(frozen=True)
class Break:
    """A moment at which a log does not go on as it should."""

    t: float
    """Since 1970 [s]."""
    reason: str
    """What happened: a restart, a jump of the clock."""
    at_surface_too: bool = True
    """Whether it spoils a leg even while the vehicle is at the surface, as a jump of the clock does."""
    until: float = -np.inf
    """To when it spoils what is logged: where the clock went back, times up to then stand twice [s]."""


@dataclass(frozen=True)
class Track:
    """What one vehicle logged."""

    name: str
    format: str
    """Of the vehicle or source, and of the reader."""
    fixes: Fixes
    """As logged, good and bad."""
    reckoned: Positions = field(default_factory=Positions)
    """By the vehicle's own dead reckoning; empty where it logs none under water."""
    reckoning: str = "the log holds no dead reckoning"
    """Where these positions come from, in words; or why there are none."""
    depth: Series = field(default_factory=Series)
    pitch: Series = field(default_factory=Series)
    heading: Series = field(default_factory=Series)
    speed: Series = field(default_factory=Series)
    """Depth [m], pitch (either sign) [deg], heading clockwise [deg], horizontal speed through the water [m/s]."""
    heading_from: Literal["magnetic", "true", "unknown"] = "unknown"
    """North that headings are counted from: ``magnetic``, ``true`` or ``unknown``."""
    declination: Series = field(default_factory=Series)
    """That the vehicle adds to its headings [deg]."""
    rpm: Series = field(default_factory=Series)
    """Of the propeller [1/min]."""
    current_east: Series = field(default_factory=Series)
    current_north: Series = field(default_factory=Series)
    """Current that the vehicle estimates and may carry its dead reckoning with [m/s]."""
    breaks: tuple[Break, ...] = ()
    marks: tuple[float, ...] = ()
    """Moments that the log marks as the separation of an anchor, since 1970 [s]."""
    shortest: float | None = None
    """Shortest leg that counts by default [s]; None for half of the vehicle's usual dive, 15 min at most."""
    planned: float | None = None
    """Time from one surfacing to the next by the plan beside the logs [s]."""
    at_surface: Series = field(default_factory=Series)
    """1 where the vehicle's own state says that it is at the surface, else 0."""

    def within(self, start: float, end: float) -> "Track":
        """Keep what was logged from `start` on and before `end` [s]; a quantity logged once is for all times."""
        kept = self.fixes[(self.fixes.t >= start) & (self.fixes.t < end)]
        parts: dict[str, Any] = {
            quantity.name: part.within(start, np.nextafter(end, -np.inf))
            for quantity in dataclass_fields(self)
            if isinstance(part := getattr(self, quantity.name), Series) and len(part) > 1
        }
        breaks = tuple(moment for moment in self.breaks if start <= max(moment.t, moment.until) and moment.t < end)
        marks = tuple(mark for mark in self.marks if start <= mark < end)
        return replace(self, fixes=kept, reckoned=self.reckoned.within(start, end), breaks=breaks, marks=marks, **parts)

    def deployments(self) -> list[tuple[float, float]]:
        """Times between which the vehicle was in use: from a first fix on to the last before a long silence [s].

        A single fix is none: a receiver whose clock is not set yet dates it in another year.
        """
        t = np.sort(np.concatenate([self.fixes.t, self.depth.t]))
        ends = np.flatnonzero(np.diff(t) > SILENCE)
        edges = [-np.inf, *(0.5 * (t[ends] + t[ends + 1])), np.inf]
        pairs = list(pairwise(edges))
        return [
            (begin, end)
            for begin, end in pairs
            if len(self.fixes.t[(self.fixes.t >= begin) & (self.fixes.t < end)]) > 1
        ]

    notices: tuple[str, ...] = ()
    """What the reader noticed."""


_GREATEST = {"depth": 12_000.0, "pitch": 180.0, "heading": 360.0, "speed": 12.0, "declination": 180.0}
"""Size of a quantity beyond which it is none, but a value that stands for none, in the track's units."""
_YEAR = 31_556_952.0
_FIRST = 10.0 * _YEAR
"""Satellites of navigation have told times since 1980 [s since 1970]."""
_MOST = 0.5
"""Share of such readings from which on the unit is another one."""


def possible(track: Track) -> Track:
    """Leave out readings that no vehicle has, and say how many.

    Raises InputError where most of a quantity's are such, or fixes are yet to come: they are in another unit.
    """
    hint = "are they in another unit than said?"
    kept: dict[str, Any] = {}
    notices = []
    if len(track.fixes) and not _FIRST < track.fixes.t[0] <= track.fixes.t[-1] < YET_TO_COME:
        notice = f"the times of its fixes are of the years from {1970.0 + track.fixes.t[0] / _YEAR:.0f} on"
        if track.fixes.t[-1] >= YET_TO_COME:
            raise InputError([Problem(notice, hint=hint)])
        notices.append(f"{notice}: they have no date that tides or the magnetic field could be known by")
    if len(track.fixes) and np.all(np.abs([2.0 * track.fixes.latitude, track.fixes.longitude]) < np.pi):
        notices.append(
            "its fixes lie within 1.6° of the equator and 3.2° of Greenwich: they are taken as degrees, not radians"
        )
    if len(track.heading) and track.heading.values.max() < 2.0 * np.pi and np.ptp(track.heading.values) > np.pi:
        notices.append("its headings lie between 0 and 6.3: they are taken as degrees, not radians")
    for name, greatest in _GREATEST.items():
        read: Series = getattr(track, name)
        wrong = np.abs(read.values) > greatest
        if wrong.any():
            notice = f"{wrong.sum()} of {len(read)} readings of the {name} are impossible, such as"
            notice = f"{notice} {read.values[wrong][0]:.6g}"
            if wrong.mean() > _MOST:
                raise InputError([Problem(notice, hint=hint)])
            kept[name] = Series(read.t[~wrong], read.values[~wrong])
            notices.append(f"{notice}: left out")
    return replace(track, **kept, notices=(*track.notices, *notices))


_IN_NO_ORDER = 0.05
"""Share of steps back from which on rows are in no order of time."""
_BACKWARDS = 1.0
"""Step back of the times within a file that is a jump of the clock [s]."""
_SINGLE = 4
"""Fewer readings that are later than those after them are of single wrong times."""


def clock_jumps(t: Array) -> list[Break]:
    """Find where the times of a file step back, and stay there.

    Rows that are in no order of time, or the last first, tell nothing.
    """
    steps = np.flatnonzero(np.diff(t) < -_BACKWARDS)
    back = [k for k in steps if np.median(t[k + 1 : k + 1 + _SINGLE]) < t[k]]
    if len(back) > _IN_NO_ORDER * len(t):
        return []
    return [
        Break(float(t[k + 1]), f"the clock jumps back ({t[k] - t[k + 1]:.0f} s)", until=_twice(t[: k + 1], t[k + 1]))
        for k in back
    ]


def _twice(before: Array, t: float) -> float:
    """To when times from some moment on were logged before already [s]; a few are single wrong ones."""
    later = np.sort(before[before > t])
    return float(later[-_SINGLE]) if len(later) >= _SINGLE else -np.inf
