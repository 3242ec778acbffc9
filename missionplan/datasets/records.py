"""What was measured, as arrays: legs of a navigation log, and dives; no file and no table.

What a measurement is known by: a hash of its own numbers, in whatever file, order, place and format they stand.

A mission keeps the hashes of what it has learned from (`learned_from`), so that no measurement counts twice.
"""

import hashlib
import math
from collections import Counter
from collections.abc import Hashable, Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array

LENGTH, TIME, DEPTH = 0.01, 0.1, 0.001
"""Steps in which distances of legs, times and depths of dives are told apart [m, s, m]."""
WHEN, REWRITTEN = np.array([10.0, 10.0, 5.0, 5.0]), np.array([2.0, 2.0, 1.0, 1.0])
"""Steps in which legs with a date are told apart: start, time under way, error and its part across the way [s, s, m,
m]; and by how much these differ in a log that is written with fewer digits."""
EDGE = 1.0 / math.sqrt(3.0)
"""Place of the edges between steps, away from every decimal that a file may write."""
DIGITS = 16
"""Of a hash."""
ROW_BY_ROW = 100
"""Rows of a table up to which each is known by itself; a longer one is known as a whole."""
NAMED = 8
"""Measurements that a notice names."""


def leg_identities(data: "TransitData") -> tuple[str, ...]:
    """Return the hash of each leg: how long it took, and the triangle of fix, dead-reckoned position and next fix.

    The three sides, and on which side of the way the next fix lies, depend on no origin, no grid and no format of
    positions; when the leg began is left out, since a log may count from any zero. Where the log has a date, a second
    hash follows, of its moment and coarse error: it stays when the log is written with fewer digits.
    """
    length, error, made_good, across = _triangle(data)
    columns = [_steps(data.under_way + data.surface, TIME)]
    columns += [_steps(side, LENGTH) for side in (length, error, made_good, across)]
    shapes = [_hash("leg", row) for row in np.stack(columns, axis=1)]
    if data.epoch is None:
        return tuple(shapes)
    return tuple(shape + _hash("leg at", row) for shape, row in zip(shapes, _steps(_moments(data), WHEN), strict=True))


def first_known(data: "TransitData", learned: Sequence[str] = ()) -> NDArray[np.int_]:
    """Return, for each leg, the place of the first before it that is the same, or itself; -1 where it was `learned`.

    Legs are the same where they have the same shape, or the same moment and error within `REWRITTEN`.
    """
    first = {half: -1 for identity in learned for half in (identity[:DIGITS], identity[DIGITS:]) if half}
    near = [[""]] * data.n
    if data.epoch is not None:
        around = np.stack([_steps(_moments(data) + sign * REWRITTEN, WHEN) for sign in (-1.0, 1.0)], axis=-1)
        near = [sorted({_hash("leg at", row) for row in product(*map(tuple, leg))}) for leg in around.tolist()]
    places = []
    for leg, identity in enumerate(data.identities):
        shape, moment = identity[:DIGITS], identity[DIGITS:]
        places.append(next((first[key] for key in (shape, *near[leg]) if key in first), leg))
        for key in filter(None, (shape, moment)):
            first.setdefault(key, places[-1])
    return np.array(places, dtype=int)


class HasIdentities(Protocol):
    """Data whose legs, dives or runs are known by their hashes."""

    @property
    def identities(self) -> tuple[str, ...]:
        """Hashes of its legs, dives or runs."""
        ...


def is_learned(data: HasIdentities, learned_from: Sequence[str]) -> NDArray[np.bool_]:
    """Return from which legs, dives or runs of a data set a mission has learned, by the hashes that it lists."""
    if isinstance(data, TransitData):
        return np.asarray(first_known(data, learned_from) < 0)
    return np.isin(np.array(data.identities, dtype=str), np.array(learned_from, dtype=str))


def _triangle(data: "TransitData") -> tuple[Array, Array, Array, Array]:
    """Length of each leg, of its error, of its way made good, and the error's part across the way [m]."""
    way, error, made_good = data.dead_reckoned - data.start, data.end - data.dead_reckoned, data.end - data.start
    length = np.hypot(*way)
    across = (way[0] * error[1] - way[1] * error[0]) / np.where(length > 0.0, length, 1.0)
    return length, np.hypot(*error), np.hypot(*made_good), across


def _moments(data: "TransitData") -> Array:
    """What `WHEN` tells apart, shape (n, 4)."""
    _, error, _, across = _triangle(data)
    began = data.t_start + (data.epoch or 0.0)
    return np.stack([began, data.under_way + data.surface, error, across], axis=1)


def dive_identity(t: Array, depth: Array) -> str:
    """Return the hash of a dive: its depths, and their times from the first.

    `t`, `depth`, shape (m,): times [s] and readings [m], as logged.
    """
    return _hash("dive", np.concatenate([_steps(t - t[0], TIME), _steps(depth, DEPTH)]))


def row_identities(kind: str, rows: Sequence[str]) -> tuple[str, ...]:
    """Return the hashes of rows that may agree by chance: the second of two that agree is known as the second.

    `kind`: of data. `rows`: numbers of each row, as `row_texts` writes them.
    """
    return tuple(_hash(kind, (row, number)) for row, number in zip(rows, _occurrences(rows), strict=True))


def table_identity(kind: str, rows: Sequence[str]) -> str:
    """Return the hash of a whole table, in whatever order its rows stand."""
    return _hash(kind, sorted(rows))


def row_texts(columns: Iterable[Sequence[object] | Array]) -> list[str]:
    """Return the numbers and words of each row of a table as text, the same however a file formats them."""
    written = [[f"{cell + 0.0:.9g}" if isinstance(cell, float) else str(cell) for cell in column] for column in columns]
    return [" ".join(row) for row in zip(*written, strict=True)]


def repeated(identities: Sequence[Hashable]) -> NDArray[np.int_]:
    """Return, for each measurement, the place of the first with its identity: its own where it is no repetition."""
    first: dict[Hashable, int] = {}
    return np.array([first.setdefault(identity, place) for place, identity in enumerate(identities)], dtype=int)


def written_once(rows: Sequence[str]) -> NDArray[np.bool_]:
    """Return which rows to keep of a table that stands several times over, every row as often; else all.

    Single rows may agree by chance, as rounded numbers of two runs do.
    """
    counts = Counter(rows)
    times = math.gcd(*counts.values())
    if times < 2 or len(counts) < 2:
        return np.ones(len(rows), dtype=bool)
    return np.array([number < counts[row] // times for row, number in zip(rows, _occurrences(rows), strict=True)])


def as_other(name: str, other: str) -> str:
    """Name a measurement that repeats another."""
    return name if name == other else f"{name} (as {other})"


def listed(names: Sequence[str]) -> str:
    """Write the first of some names, and how many more there are."""
    more = f" and {len(names) - NAMED} more" if len(names) > NAMED else ""
    return f"{', '.join(names[:NAMED])}{more}"


def _occurrences(rows: Sequence[str]) -> list[int]:
    """Number of rows before each that agree with it."""
    seen: Counter[str] = Counter()
    counts = []
    for row in rows:
        counts.append(seen[row])
        seen[row] += 1
    return counts


def _steps(values: Array, step: float | Array) -> NDArray[np.int_]:
    return np.floor(values / step + EDGE).astype(np.int64)


def _hash(kind: str, values: Iterable[object]) -> str:
    return hashlib.sha256(" ".join([kind, *map(str, values)]).encode()).hexdigest()[:DIGITS]


TOUCHDOWN_MARGIN = 0.12
"""Share of the vehicle's depth at touchdown that is cut off above it."""


@dataclass(frozen=True)
class TransitData:
    """Legs of a navigation log in the order of time."""

    name: str
    source: str
    """Of the data set."""
    labels: NDArray[np.str_]
    """Legs' names, shape (n,)."""
    run: NDArray[np.int_]
    """Number of the run each leg belongs to, shape (n,)."""
    t_start: Array
    """Since the mission's start, or since the first fix, shape (n,) [s]."""
    under_way: Array
    surface: Array
    """Shape (n,). Time under way, and at the surface until the fix [s]."""
    start: Array
    dead_reckoned: Array
    end: Array
    """Shape (2, n). Fix on diving, dead-reckoned position on surfacing, fix on surfacing: east, north of the origin
    [m]."""
    origin: tuple[float, float] | None
    """Latitude and longitude of the origin, where known [rad]."""
    fix_sd: float | None
    """Stated standard deviation of a fix, each axis [m]."""
    has_surface_time: bool
    """Whether the log says how long the vehicle lay at the surface before the fix."""
    notices: tuple[str, ...]
    """Treatments the reader should know of."""
    epoch: float | None = None
    """Seconds since 1970 of the times' zero, where the log says."""
    leg_fix_sd: Array | None = None
    """Standard deviation of the fix after each leg, each axis, where the log states it, shape (n,) [m]."""
    depth: Array | None = None
    """Mean depth under way of each leg, nan where it is not known, shape (n,) [m]."""
    reckoned_speed_sd: float | None = None
    """Standard deviation of the speed over it, where the dead reckoning was made without a logged one."""

    @property
    def n(self) -> int:
        """Number of legs."""
        return len(self.t_start)

    @property
    def identities(self) -> tuple[str, ...]:
        """Hash of each leg."""
        return leg_identities(self)

    @property
    def middle(self) -> Array:
        """Middle of each leg's time under way, shape (n,) [s]."""
        return self.t_start + 0.5 * self.under_way

    @property
    def date(self) -> float:
        """Middle of the log [s since 1970]; nan where its times have no date."""
        return math.nan if self.epoch is None else self.epoch + float(np.mean(self.middle))

    @property
    def latitude(self) -> float:
        """Latitude of the origin [rad]; nan where unknown."""
        return self.origin[0] if self.origin else float("nan")

    @property
    def velocity_error(self) -> Array:
        """Position error on surfacing over the time under way, shape (2, n) [m/s]."""
        return (self.end - self.dead_reckoned) / self.under_way

    @property
    def weight(self) -> Array:
        """What a velocity error counts for in a mean of their squares: as its error of position does, shape (n,)."""
        return np.asarray(self.under_way / np.sqrt(np.mean(self.under_way**2)))

    @property
    def typical_fix_sd(self) -> float | None:
        """Standard deviation of a fix, each axis: the median of those stated leg by leg, else that of all [m]."""
        return self.fix_sd if self.leg_fix_sd is None else float(np.median(self.leg_fix_sd))

    @property
    def fix_scale(self) -> Array:
        """Standard deviation of the fix after each leg over the typical one, shape (n,); 1 where it is not stated."""
        if self.leg_fix_sd is None:
            return np.ones(self.n)
        return np.asarray(self.leg_fix_sd / np.median(self.leg_fix_sd))

    def subset(self, keep: NDArray[np.bool_] | NDArray[np.int_]) -> "TransitData":
        """Keep some of the legs."""
        return replace(
            self,
            labels=self.labels[keep],
            run=self.run[keep],
            t_start=self.t_start[keep],
            under_way=self.under_way[keep],
            surface=self.surface[keep],
            start=self.start[:, keep],
            dead_reckoned=self.dead_reckoned[:, keep],
            end=self.end[:, keep],
            leg_fix_sd=None if self.leg_fix_sd is None else self.leg_fix_sd[keep],
            depth=None if self.depth is None else self.depth[keep],
        )


@dataclass(frozen=True)
class MeasuredDive:
    """One dive as it was logged."""

    name: str
    """Of the run."""
    line: int
    """Of its first reading in the file."""
    t: Array
    depth: Array
    """Shape (m,). Time since the separation by the log's clock [s], and reading [m]."""
    wet_weight: float
    line_length: float
    site_depth: float
    """Of this dive [N, m, m]."""

    @property
    def identity(self) -> str:
        """Hash of the dive."""
        return dive_identity(self.t, self.depth)

    @property
    def deepest_fitted(self) -> float:
        """Depth above which readings are taken to be of the descent, free of the touchdown [m]."""
        return (1.0 - TOUCHDOWN_MARGIN) * (self.site_depth - self.line_length)


@dataclass(frozen=True)
class DescentData:
    """Dives of a data set."""

    name: str
    source: str
    file: str
    """Of the data set; its CSV as messages name it."""
    dives: tuple[MeasuredDive, ...]
    """In the order of the file."""
    depth_noise: float | None
    """Stated standard deviation of a reading [m]."""
    notices: tuple[str, ...]
    """Treatments the reader should know of."""
    date: float = math.nan
    """Of the dives [s since 1970]; nan where it is not known."""
