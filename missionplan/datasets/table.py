"""CSV tables: the columns of a kind of data as numbers and text, with every problem of the file at once.

A header row; UTF-8, with a byte-order mark or without; rows with `ok` = 0 are left out and never looked at; a blank
is missing, and a row without a number that it needs is left out.
"""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from difflib import get_close_matches
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from missionplan.arrays import without_nines
from missionplan.datasets.csv_cells import (
    BLANKS,
    check_file,
    long_rows,
    read_cells,
    read_header,
)
from missionplan.errors import UNPRINTABLE, InputError, Problem, counted
from missionplan.moments import EPOCH_SCALE, YET_TO_COME, epoch_seconds

MAX_SHOWN = 5
"""Problems of one sort that are reported one by one; the rest are counted."""
MAX_NAMED = 20
"""Columns that a notice names."""
LEAST, GREATEST = 1e-20, 1e12
"""Between which the size of every number of a table is, but for zero [SI]."""
MAX_BYTES = 2_000_000_000
LONG_ROW = "the row has more cells than the header has columns (a decimal comma, or a comma in a text without quotes?)"


@dataclass(frozen=True)
class Columns:
    """Columns of a kind of data."""

    alternatives: tuple[tuple[str, ...], ...]
    """Sets of columns, of which a table has one; a row needs all numbers of that set."""
    optional: tuple[str, ...] = ()
    """Columns that a table may have as well."""
    complete: tuple[str, ...] = ()
    """Those of the optional columns whose numbers a row needs too, where the column is there."""
    text: tuple[str, ...] = ()
    """Columns of any of these that hold text."""
    times: tuple[str, ...] = ()
    """Columns of any of these that hold seconds, or times by ISO 8601, which become seconds since 1970."""
    max_bytes: int = MAX_BYTES
    """Size of the largest file that is read."""

    def nearest_to(self, header: Sequence[str]) -> tuple[str, ...]:
        """Return the first of the alternatives that a table has all columns of, else the one it has most of."""
        return max(self.alternatives, key=lambda names: (set(names) <= set(header), len(set(names) & set(header))))


@dataclass(frozen=True)
class CsvTable:
    """Rows of a CSV."""

    file: str
    """As messages name it."""
    rows: pd.DataFrame
    """Numbers (nan where missing) and text (empty where missing); the index is the file's line."""
    notices: tuple[str, ...]
    """Columns not used, rows left out."""
    problems: tuple[Problem, ...]
    """Cells that hold no number, nan in `rows`, and the like."""


def plain_table(path: Path, columns: Collection[str], max_bytes: int) -> pd.DataFrame:
    """Read the cells of some columns, numbers or text, nan where blank; the index is the file's line.

    Raises InputError when it is no such file, or all its rows are marked.
    """
    file = str(path)
    check_file(path, max_bytes)
    header = read_header(path)
    problems = [
        *_check_header(header, tuple(columns), [name for name in columns if name in header], file),
        *problems_at(long_rows(path, len(header)), lambda line: Problem(LONG_ROW, file, line)),
    ]
    if problems:
        raise InputError(problems)
    rows = read_cells(path, header, [*columns, *(["ok"] if "ok" in header else [])], ())
    rows = _without_marked(rows)[0].filter(list(columns))
    rows = rows.mask(rows.isin(BLANKS)).dropna(how="all")
    if rows.empty:
        raise InputError([Problem("has no rows of data", file, 1)])
    return rows


def times_from(cells: "pd.Series[Any]", zero: float | None, file: str) -> "pd.Series[float]":
    """Read the times of a record as seconds from a zero, nan where a cell holds none.

    Times by ISO 8601 and seconds since 1970 are counted from there, other seconds count from it already. Raises
    InputError where they are dates and the zero is not known [s since 1970], or of another age.
    """
    moments = epoch_seconds(cells.astype(str))
    is_date = (moments > EPOCH_SCALE) | pd.to_numeric(cells, errors="coerce").isna()
    if zero is None and moments[is_date].notna().any():
        raise InputError([Problem("its times are of the day: the mission needs its `start` (UTC)", file)])
    if moments.max() > YET_TO_COME:
        raise InputError([Problem("its times are yet to come", file, hint="are they seconds, or another unit?")])
    return moments - is_date * (zero or 0.0)


def read_table(path: Path, columns: Columns) -> CsvTable:
    """Read the columns of a kind of data from a CSV.

    `columns`: of that kind. Raises InputError when the file cannot be read as a table, or lacks columns.
    """
    file = str(path)
    check_file(path, columns.max_bytes)
    header = read_header(path)
    needed = columns.nearest_to(header)
    used = [name for name in (*needed, *columns.optional, "ok") if name in header]
    rows = read_cells(path, header, used, columns.text) if used else pd.DataFrame()
    rows, marked = _without_marked(rows)
    rows, bad_cells = _as_numbers(rows, columns, file)
    numbers = [str(name) for name in rows.select_dtypes(float) if name not in columns.times]
    rows = rows.assign(**{name: without_nines(rows[name].to_numpy()) for name in numbers})
    problems = [
        *_check_header(header, needed, used, file),
        *problems_at(long_rows(path, len(header)), lambda line: Problem(LONG_ROW, file, line)),
        *bad_cells,
    ]
    if not set(needed) <= set(used):
        raise InputError(problems)
    complete = [name for name in (*needed, *columns.complete) if name in used and name not in columns.text]
    rows, incomplete = _without_incomplete(rows, complete, columns.text)
    for name in (name for name in needed if name in columns.text):
        problems += wrong_cells(rows.index[rows[name] == ""], "is blank; expected a name", file, name)
    if rows.empty and not problems:
        problems.append(Problem("has no rows of data", file))
    notices = tuple(f"{path.name}: {note}" for note in (*_unused(header, used), *marked, *incomplete))
    return CsvTable(file, rows, notices, tuple(problems))


def _check_header(header: Sequence[str], needed: Sequence[str], used: Sequence[str], file: str) -> list[Problem]:
    """Return a problem for each column that is missing, and each that stands twice."""
    problems = []
    for name in needed:
        if name not in header:
            close = get_close_matches(name, header, n=1)
            hint = f"is it {close[0]}?" if close else ""
            problems.append(Problem("the column is missing", file, 1, name, hint))
    problems += [Problem("the column stands twice", file, 1, name) for name in used if header.count(name) > 1]
    hidden = [name for name in header if UNPRINTABLE.search(name)][:MAX_SHOWN]
    return [*problems, *(Problem("the column's name holds a control character", file, 1, name) for name in hidden)]


def _unused(header: Sequence[str], used: Sequence[str]) -> list[str]:
    """Note the columns that are not used."""
    unused = [name for name in dict.fromkeys(header) if name and name not in used]
    more = [f"{len(unused) - MAX_NAMED} more"] if len(unused) > MAX_NAMED else []
    return [f"columns not used: {', '.join([*unused[:MAX_NAMED], *more])}"] if unused else []


def _without_marked(rows: pd.DataFrame) -> tuple[pd.DataFrame, list[str]]:
    """Leave out the rows with `ok` = 0, before any of their cells is looked at, and note how many."""
    if "ok" not in rows:
        return rows, []
    marked = pd.to_numeric(rows["ok"], errors="coerce") == 0.0
    count = int(marked.sum())
    return rows[~marked], [f"{counted(count, 'row')} left out as marked (ok = 0)"] if count else []


def _as_numbers(rows: pd.DataFrame, columns: Columns, file: str) -> tuple[pd.DataFrame, list[Problem]]:
    """Turn all columns but text into floats; cells that hold no finite number become nan, and problems."""
    problems: list[Problem] = []
    converted: dict[str, pd.Series[float] | pd.Series[str]] = {}
    for name in (str(column) for column in rows.columns):
        cells = rows[name]
        if pd.api.types.is_float_dtype(cells):
            converted[name] = cells
            problems += _problems_of_size(cells, file, name)
            continue
        words = cells.fillna("").astype(str).str.strip()
        if name in columns.text:
            hidden = words.str.contains(UNPRINTABLE)
            problems += problems_at(rows.index[hidden], partial(_hidden_character, words, file, name))
            converted[name] = words
            continue
        blank = words.isin(BLANKS)
        numbers = pd.to_numeric(words.mask(blank), errors="coerce").astype(float)
        if name in columns.times:
            numbers = numbers.fillna(epoch_seconds(words))
        bad = (numbers.isna() & ~blank) | np.isinf(numbers)
        problems += problems_at(rows.index[bad], partial(_bad_cell, words, file, name, name in columns.times))
        converted[name] = numbers = numbers.mask(bad)
        problems += _problems_of_size(numbers, file, name)
    return pd.DataFrame(converted, index=rows.index).drop(columns="ok", errors="ignore"), problems


def _bad_cell(words: "pd.Series[str]", file: str, name: str, is_time: bool, line: int) -> Problem:
    expected = "seconds, or a time such as 2026-05-01T10:20:30Z" if is_time else "a number"
    return Problem(f"given {words[line]!r}, expected {expected}", file, line, name)


def _problems_of_size(numbers: "pd.Series[float]", file: str, name: str) -> list[Problem]:
    """Return a problem for each number that no quantity has, and that overflows when it is squared or divided by."""
    size = numbers.abs()
    odd = (size > GREATEST) | ((size > 0.0) & (size < LEAST))

    def problem(line: int) -> Problem:
        message = f"given {numbers[line]:g}, expected 0, or from {LEAST:g} to {GREATEST:g} in size"
        return Problem(message, file, line, name)

    return problems_at(numbers.index[odd], problem)


def _hidden_character(words: "pd.Series[str]", file: str, name: str, line: int) -> Problem:
    return Problem(f"given {words[line]!r}, expected text without control characters", file, line, name)


def _without_incomplete(
    rows: pd.DataFrame, complete: Sequence[str], text: Sequence[str]
) -> tuple[pd.DataFrame, list[str]]:
    """Leave out rows without a number that they need, and say so but for rows that are blank altogether."""
    missing = rows[list(complete)].isna()
    incomplete = missing.any(axis=1)
    if not incomplete.any():
        return rows, []
    candidates = rows[incomplete]
    words = [name for name in text if name in rows]
    blank = candidates.drop(columns=words).isna().all(axis=1) & (candidates[words] == "").all(axis=1)
    missing_some = missing[incomplete][~blank]
    notices = []
    if len(missing_some):
        where = [name for name in complete if missing_some[name].any()]
        notices.append(f"{counted(len(missing_some), 'row')} left out without {' or '.join(where)}")
    return rows[~incomplete], notices


def problems_at(lines: Sequence[int] | pd.Index, problem: Callable[[int], Problem]) -> list[Problem]:
    """Return the problems of the first of some lines, the last of them with the number of the rest.

    `lines`: lines with problems of one sort. `problem`: from a line to its problem.
    """
    problems = [problem(int(line)) for line in lines[:MAX_SHOWN]]
    if len(lines) > MAX_SHOWN:
        problems[-1] = replace(problems[-1], message=f"{problems[-1].message}; {len(lines) - MAX_SHOWN} more like it")
    return problems


def wrong_cells(lines: Sequence[int] | pd.Index, message: str, file: str, column: str, hint: str = "") -> list[Problem]:
    """Return a problem of a column's cells in some lines, as `problems_at` does."""
    return problems_at(lines, partial(Problem, message, file, key=column, hint=hint))
