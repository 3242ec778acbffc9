"""Files of tables, plain or compressed: what is unpacked is limited, for a small file may unpack to any size."""

import bz2
import gzip
import lzma
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from typing import IO, Protocol
from zipfile import BadZipFile, ZipFile

from missionplan.errors import InputError, Problem

MAX_UNPACKED = 30_000_000
"""Bytes that a compressed file may unpack to."""
_CHUNK = 1_000_000


class _Reader(Protocol):
    """What all of them can do."""

    def read(self, size: int, /) -> bytes:
        """Read some bytes."""
        ...


_KINDS = (".gz", ".bz2", ".xz", ".zip")
"""Endings of compressed files; all others are plain."""
_BROKEN = (EOFError, BadZipFile, lzma.LZMAError, zlib.error, NotImplementedError, RuntimeError)


@contextmanager
def open_table(path: Path) -> Iterator[IO[bytes]]:
    """Open a table, unpacked where it is compressed.

    Raises
    ------
    InputError
        When it cannot be read, is not compressed as its name says, or unpacks to more than `MAX_UNPACKED`.
    """
    if path.suffix.lower() not in _KINDS:
        with path.open("rb") as stream:
            yield stream
        return
    yield BytesIO(_unpacked(path))


def _unpacked(path: Path) -> bytes:
    kind, content = path.suffix.lower(), bytearray()
    try:
        with _opened(path, kind) as stream:
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


@contextmanager
def _opened(path: Path, kind: str) -> Iterator[_Reader]:
    if kind == ".zip":
        with ZipFile(path) as archive:
            if len(archive.namelist()) != 1:
                raise BadZipFile("expected one file inside")
            with archive.open(archive.namelist()[0]) as member:
                yield member
    elif kind == ".gz":
        with gzip.open(path) as packed:
            yield packed
    elif kind == ".bz2":
        with bz2.open(path) as packed_by_bzip2:
            yield packed_by_bzip2
    else:
        with lzma.open(path) as packed_by_lzma:
            yield packed_by_lzma
