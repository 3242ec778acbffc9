"""Cells of a CSV file: read as floats at once, and as text only where a cell holds no number.

Files of tables, plain or compressed: what is unpacked is limited, for a small file may unpack to any size.
"""

import csv
import zlib
from bz2 import BZ2File
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from gzip import GzipFile
from io import BufferedIOBase, BytesIO, TextIOWrapper
from lzma import LZMAError, LZMAFile
from pathlib import Path
from typing import IO, cast
from zipfile import BadZipFile, ZipFile

import numpy as np
import pandas as pd

from missionplan.errors import InputError, Problem, did_you_mean
from missionplan.store.folder import check_name

MAX_UNPACKED = 30_000_000
"""Bytes that a compressed file may unpack to."""
_CHUNK = 1_000_000


@contextmanager
def _only_member(path: Path) -> Iterator[BufferedIOBase]:
    with ZipFile(path) as archive:
        if len(archive.namelist()) != 1:
            raise BadZipFile("expected one file inside")
        with archive.open(archive.namelist()[0]) as member:
            yield cast("BufferedIOBase", member)


_KINDS: Mapping[str, Callable[[Path], AbstractContextManager[BufferedIOBase]]] = {
    ".gz": GzipFile,
    ".bz2": BZ2File,
    ".xz": LZMAFile,
    ".zip": _only_member,
}
"""What opens compressed files, by their endings; all others are plain."""
_BROKEN = (EOFError, BadZipFile, LZMAError, zlib.error, NotImplementedError, RuntimeError)


@contextmanager
def open_table(path: Path) -> Iterator[IO[bytes]]:
    """Open a table, unpacked where it is compressed.

    Raises InputError when it cannot be read, is not compressed as its name says, or unpacks to more than
    `MAX_UNPACKED`.
    """
    if path.suffix.lower() not in _KINDS:
        with path.open("rb") as stream:
            yield stream
        return
    yield BytesIO(_unpacked(path))


def _unpacked(path: Path) -> bytes:
    kind, content = path.suffix.lower(), bytearray()
    try:
        with _KINDS[kind](path) as stream:
            while chunk := stream.read(_CHUNK):
                content += chunk
                if len(content) > MAX_UNPACKED:
                    message = f"unpacks to more than {MAX_UNPACKED / 1e6:g} MB"
                    raise InputError([Problem(message, str(path), hint="unpack it, or thin it")])
    except _BROKEN as error:
        raise InputError([Problem(f"cannot be unpacked as {kind}: {error}", str(path))]) from None
    except OSError as error:
        raise InputError([Problem(f"cannot be unpacked as {kind}: {error.strerror or error}", str(path))]) from None
    return bytes(content)


BLANKS = ("", "nan", "NaN", "NA", "N/A", "null")
"""What stands for a missing number."""


def check_file(path: Path, max_bytes: int) -> None:
    """Check that a file can be read and is not too large.

    Raises InputError when it is not.
    """
    file = str(path)
    check_name(file)
    try:
        size = path.stat().st_size
        if path.is_dir():
            raise InputError([Problem("is a folder; a CSV file was expected", file)])
    except FileNotFoundError:
        near = did_you_mean(path.name, [entry.name for entry in path.parent.glob("*")])
        hint = "it is a link to what is not there" if path.is_symlink() else near
        raise InputError([Problem("no such file", file, hint=hint)]) from None
    except OSError as error:
        raise InputError([Problem(f"cannot be read: {error.strerror or error}", file)]) from None
    if size > max_bytes:
        raise InputError([Problem(f"is larger than {max_bytes / 1e6:g} MB", file, hint="split it, or thin it")])


def read_header(path: Path) -> list[str]:
    """Read the names of the columns.

    Raises InputError when the file is empty or not UTF-8 text.
    """
    file = str(path)
    try:
        with open_table(path) as content, TextIOWrapper(content, encoding="utf-8-sig", newline="") as stream:
            return [name.strip() for name in next(csv.reader(stream, skipinitialspace=True))]
    except StopIteration:
        raise InputError([Problem("is empty; expected a header row and data", file)]) from None
    except UnicodeDecodeError as error:
        raise _not_utf8(file, error) from None
    except csv.Error as error:
        raise InputError([Problem(f"is not a table: {error}", file, 1)]) from None
    except OSError as error:
        raise InputError([Problem(f"cannot be read: {error.strerror or error}", file)]) from None


def long_rows(path: Path, width: int) -> list[int]:
    """Lines with more cells than the header; cells beyond it that are blank do not count."""
    numbers = []
    with open_table(path) as lines:
        for number, line in enumerate(lines, start=1):
            if line.count(b",") >= width and number > 1:
                words = line.decode(errors="replace").replace("\r", " ")  # a bare one is no end of a row
                try:
                    cells = next(csv.reader([words], skipinitialspace=True))
                except csv.Error:  # a cell of more than 131 072 characters
                    cells = words.split(",")
                if any(cell.strip() for cell in cells[width:]):
                    numbers.append(number)
    return numbers


def read_cells(path: Path, header: Sequence[str], used: Sequence[str], text: Sequence[str]) -> pd.DataFrame:
    """Read some of the columns; the index is the file's line.

    `header`: names of all columns. `used`: those to read; of two with one name the first. `text`: columns of text; the
    others are floats, nan where blank, or all of them text where a cell holds no number. Raises InputError when the
    file is no table.
    """
    names = [name if name in used and name not in header[:k] else f"#{k}" for k, name in enumerate(header)]
    numbers = [name for name in used if name not in text]
    try:
        rows = _floats_or_text(path, names, used, numbers)
    except UnicodeDecodeError as error:
        raise _not_utf8(str(path), error) from None
    except pd.errors.ParserError as error:
        reason = str(error).removeprefix("Error tokenizing data. C error: ")
        raise InputError([Problem(f"is not a table: {reason}", str(path))]) from None
    rows.index = pd.RangeIndex(2, len(rows) + 2)
    return rows


def _floats_or_text(path: Path, names: Sequence[str], used: Sequence[str], numbers: Sequence[str]) -> pd.DataFrame:
    try:
        rows = _parsed(path, names, used, numbers)
    except (UnicodeDecodeError, pd.errors.ParserError):
        raise
    except ValueError:  # a cell holds no number
        return _parsed(path, names, used, ())
    infinite = any(np.isinf(rows[name]).any() for name in numbers)
    return _parsed(path, names, used, ()) if infinite else rows


def _parsed(path: Path, names: Sequence[str], used: Sequence[str], numbers: Sequence[str]) -> pd.DataFrame:
    with open_table(path) as stream:
        rows: pd.DataFrame = pd.read_csv(
            stream,
            encoding="utf-8-sig",
            header=0,
            names=list(names),
            usecols=list(used),
            index_col=False,
            dtype={name: float if name in numbers else str for name in used},
            na_values={name: list(BLANKS) for name in numbers},
            keep_default_na=False,
            skipinitialspace=True,
            skip_blank_lines=False,
        )
    return rows


def _not_utf8(file: str, error: UnicodeDecodeError) -> InputError:
    return InputError([Problem(f"is not UTF-8 text (byte {error.start})", file)])
