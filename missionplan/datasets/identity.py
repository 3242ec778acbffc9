"""What a measurement is known by: a hash of its own numbers, in whatever file, order, place and format they stand.

A mission keeps the hashes of what it has learned from (`learned_from`), so that no measurement counts twice.
"""

import hashlib
import math
from collections import Counter
from collections.abc import Hashable, Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array

if TYPE_CHECKING:
    from missionplan.datasets.records import TransitData

LENGTH, TIME, DEPTH = 0.01, 0.1, 0.001
"""Steps in which distances of legs, times and depths of dives are told apart [m, s, m]."""
EDGE = 1.0 / math.sqrt(3.0)
"""Place of the edges between steps, away from every decimal that a file may write."""
ROW_BY_ROW = 100
"""Rows of a table up to which each is known by itself; a longer one is known as a whole."""
NAMED = 8
"""Measurements that a notice names."""


def leg_identities(data: "TransitData") -> tuple[str, ...]:
    """Return the hash of each leg: how long it took, and the triangle of fix, dead-reckoned position and next fix.

    The three sides depend on no origin, no grid and no format of positions; when the leg began is left out, since a
    log may count from any zero.
    """
    sides = [data.dead_reckoned - data.start, data.end - data.dead_reckoned, data.end - data.start]
    columns = [_steps(data.under_way + data.surface, TIME), *(_steps(np.hypot(*side), LENGTH) for side in sides)]
    return tuple(_hash("leg", row) for row in np.stack(columns, axis=1))


def dive_identity(t: Array, depth: Array) -> str:
    """Return the hash of a dive: its depths, and their times from the first.

    Parameters
    ----------
    t, depth : array, shape (m,)
        Times [s] and readings [m], as logged.
    """
    return _hash("dive", np.concatenate([_steps(t - t[0], TIME), _steps(depth, DEPTH)]))


def row_identities(kind: str, rows: Sequence[str]) -> tuple[str, ...]:
    """Return the hashes of rows that may agree by chance: the second of two that agree is known as the second.

    Parameters
    ----------
    kind : str
        Of data.
    rows : sequence of str
        Numbers of each row, as `row_texts` writes them.
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
    found = []
    for row in rows:
        found.append(seen[row])
        seen[row] += 1
    return found


def _steps(values: Array, step: float) -> NDArray[np.int_]:
    return np.floor(values / step + EDGE).astype(np.int64)


def _hash(kind: str, values: Iterable[object]) -> str:
    return hashlib.sha256(" ".join([kind, *map(str, values)]).encode()).hexdigest()[:16]
