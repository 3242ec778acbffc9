"""Tables of text with any separator, a preface or none, and decimal points or commas."""

import csv
import gzip
import io
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import IO

import pandas as pd

_ROWS = 50_000
"""Rows that are held as text at a time."""
_PREFACE = 60
"""Lines among which the header is looked for."""
_LONGEST = 60
"""Characters of a name that a message shows."""
_SEPARATORS = (",", ";", "\t", "|")


def text_chunks(path: Path, wanted: Sequence[str]) -> Iterator[pd.DataFrame]:
    """Read columns as text, some rows at a time.

    Parameters
    ----------
    path : Path
    wanted : sequence of str
        Names of columns; one of the form `Date+Time` is several, joined by a space.

    Raises
    ------
    ValueError
        When no line has all these names.
    """
    columns = list(dict.fromkeys(part for name in wanted for part in _parts(name)))
    line, separator = _header(path, columns)
    with _opened(path) as stream:
        table = pd.read_csv(
            stream, sep=separator, skiprows=line, usecols=lambda name: name.strip() in columns, dtype=str,
            keep_default_na=False, skipinitialspace=True, chunksize=_ROWS, on_bad_lines="skip", engine="c",
        )  # fmt: skip
        for chunk in table:
            chunk.columns = [str(name).strip() for name in chunk.columns]
            yield pd.DataFrame({name: _joined(chunk, name) for name in wanted})


def read_header(path: Path) -> list[str]:
    """Names of the columns that the first line of a file has."""
    with _opened(path) as stream:
        line = stream.readline()
    separator = max(_SEPARATORS, key=line.count)
    return [cell.strip() for cell in next(csv.reader([line], delimiter=separator), [])]


def _parts(name: str) -> list[str]:
    return [part.strip() for part in name.split("+")]


def _joined(chunk: pd.DataFrame, name: str) -> "pd.Series[str]":
    first, *others = _parts(name)
    words = chunk[first].astype(str)
    for other in others:
        words = words + " " + chunk[other].astype(str)
    return words


@contextmanager
def _opened(path: Path) -> Iterator[IO[str]]:
    with (
        gzip.open(path, "rb") if path.suffix == ".gz" else path.open("rb") as raw,
        io.TextIOWrapper(raw, encoding="utf-8-sig", errors="replace", newline="") as stream,
    ):
        yield stream


def _cells(line: str, separator: str) -> list[str]:
    """Split a line; one with a cell longer than any name is none of names."""
    try:
        return line.split() if separator == r"\s+" else next(csv.reader([line], delimiter=separator), [])
    except csv.Error:
        return []


def _header(path: Path, columns: Sequence[str]) -> tuple[int, str]:
    """Line of the header, from 0, and the separator that shows all columns there."""
    seen: list[str] = []
    with _opened(path) as stream:
        for number, line in zip(range(_PREFACE), stream, strict=False):
            for separator in (*_SEPARATORS, r"\s+"):
                names = [cell.strip() for cell in _cells(line, separator)]
                if set(columns) <= set(names):
                    return number, separator
                seen = max(seen, names, key=len)
    missing = [name for name in columns if name not in seen]
    raise ValueError(f"no column {', '.join(missing)}; it has {', '.join(name[:_LONGEST] for name in seen[:20])}")
