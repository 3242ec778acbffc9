"""Checkpoints: finished blocks of a run on disk, so that a run killed at any time can be resumed.

One file per block, written atomically, beside ``run.json``, which records what the blocks depend on. File names contain
the size of the block: when a run is extended, its incomplete last block is computed again as a whole.

Nothing damaged is believed. A block's file is a ``.npz`` with the run's digest and the block's number and size among
its arrays, followed by the SHA-256 of all that; ``run.json`` has the digest of its own content. A block that does not
agree is computed again, with a warning in the log (which Python shows on standard error).

A table with one row a trial, written as it grows.
"""

import hashlib
import io
import json
import logging
import zlib
from collections.abc import Callable, Generator, Iterable, Mapping, Sequence
from contextlib import closing
from importlib import import_module
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar
from zipfile import ZIP_DEFLATED, BadZipFile, ZipFile

import numpy as np
from numpy.typing import NDArray

from missionplan.errors import InputError, Problem, RunError
from missionplan.identity import Identity, differences, digest_of, how_to_install
from missionplan.montecarlo.pool import interrupts_deferred
from missionplan.store.folder import write_atomically

if TYPE_CHECKING:
    import pandas as pd


_UNREADABLE = (OSError, ValueError, KeyError, EOFError, BadZipFile, zlib.error)
_CHECKSUM_BYTES = hashlib.sha256().digest_size
_MAX_NAMED = 5
"""Damaged blocks that a warning names; the others are counted."""
_log = logging.getLogger(__name__)
Arrays = Mapping[str, NDArray[np.generic]]


class Checkpoints:
    """The folder of a run's finished blocks.

    `folder`: created if necessary. `resume`: whether to use the blocks that the folder holds. Raises InputError when
    the folder holds a run and `resume` is not given, or a different run; then with the difference. Raises RunError when
    the folder cannot be written.
    """

    def __init__(self, folder: Path, identity: Identity, *, resume: bool = False) -> None:
        self._folder, self._digest = folder, identity.digest
        if folder.exists() and not folder.is_dir():
            raise InputError([Problem("is a file; a folder for finished blocks was expected", str(folder))])
        record = folder / "run.json"
        try:
            before = record.read_bytes()
        except FileNotFoundError:
            before = None
        except OSError as error:
            raise RunError(f"cannot read {record}: {error.strerror or error}") from error
        if before is not None:
            self._check(before, identity, resume=resume)
        for stray in folder.glob(".block-*"):  # left by a write that was killed
            stray.unlink(missing_ok=True)
        whole = identity.whole()
        content = {**whole, "sha256": digest_of(whole)}
        write_atomically(record, json.dumps(content, indent=1, ensure_ascii=False) + "\n")

    def _check(self, before: bytes, identity: Identity, *, resume: bool) -> None:
        shown = str(self._folder)
        if not resume:
            message = "holds the finished blocks of a run"
            raise InputError([Problem(message, shown, hint="resume=True continues with them")])
        old = _read_identity(before)
        if old is None and not any(self._folder.glob("block-*.npz")):
            raise InputError([Problem("run.json is not that of a run; nothing can be resumed", shown)])
        if old is None:
            message = "%s is damaged; the blocks beside it that say themselves that they are of this run are used"
            _log.warning(message, self._folder / "run.json")
        elif old != identity:
            lines = "\n".join(f"  {line}" for line in differences(old.whole(), identity.whole()))
            message = f"holds the blocks of another run; nothing was changed. What differs:\n{lines}"
            raise InputError([Problem(message, shown)])

    def intact(self, blocks: Iterable[tuple[int, int]]) -> set[tuple[int, int]]:
        """Return which of some blocks, by number and size, are there and agree with their checksums.

        Those that are there and do not agree are named in a warning.
        """
        present = [item for item in blocks if _block_file(self._folder, *item).exists()]
        kept = {item for item in present if self.holds(*item)}
        damaged = [_block_file(self._folder, *item).name for item in present if item not in kept]
        if damaged:
            more = f" and {len(damaged) - _MAX_NAMED} more" if len(damaged) > _MAX_NAMED else ""
            _log.warning(
                "damaged, or of another run, and computed again: %s%s (in %s)",
                ", ".join(damaged[:_MAX_NAMED]),
                more,
                self._folder,
            )
        return kept

    def holds(self, block: int, size: int) -> bool:
        """Whether a block is there and agrees with its checksum, the run, its number and its size."""
        return self.read(block, size) is not None

    def read(self, block: int, size: int) -> dict[str, NDArray[np.generic]] | None:
        """Return a finished block; None when there is none that agrees with its checksum, the run and its name."""
        arrays = read_block(self._folder, block, size)
        if arrays is None or str(arrays.pop("digest")) != self._digest:
            return None
        return arrays

    def write(self, block: int, size: int, arrays: Arrays) -> None:
        """Save a finished block.

        Raises RunError when the disk is full, or the folder is missing or not writable.
        """
        path = _block_file(self._folder, block, size)
        if not self._folder.is_dir():
            raise RunError(f"cannot write {path}: the folder {self._folder} no longer exists")
        content = BytesIO()
        label = {"digest": np.array(self._digest), "block": np.array([block, size])}
        with interrupts_deferred():  # a ZIP file that an exception leaves half opened raises another when it is closed
            # as np.savez_compressed does, in a quarter of its time and a fifth more bytes
            with ZipFile(content, "w", ZIP_DEFLATED, compresslevel=1) as archive:
                for name, array in {**label, **arrays}.items():
                    with archive.open(f"{name}.npy", "w", force_zip64=True) as file:
                        np.lib.format.write_array(file, np.asarray(array), allow_pickle=False)
            checksum = hashlib.sha256(content.getvalue()).digest()
            write_atomically(path, content.getvalue() + checksum)


Item = TypeVar("Item", bound=tuple[int, ...])
Block = TypeVar("Block")


def kept_or_run(
    items: Sequence[Item],
    run: Callable[[Sequence[Item]], Generator[Block, None, None]],
    store: Checkpoints | None,
    number: Callable[[Item], tuple[int, int]],
    form: tuple[Callable[[Block], Arrays | None], Callable[[Arrays], Block]],
    progress: Callable[[int, int], None] | None = None,
) -> Generator[tuple[Item, Block], None, None]:
    """Yield the blocks of a run in their order: as they are kept, where they are intact, else run and kept.

    `items`: the blocks, with the trials of each last. `run`: yields those that it is given. `number`: of a block in the
    store, and its size. `form`: turns a block into arrays, None where it is not to be kept, and back. `progress`: told
    the trials done of all.
    """
    kept = store.intact(map(number, items)) if store is not None else set()
    done, total = 0, sum(item[-1] for item in items)
    tell = progress or (lambda *_: None)
    tell(done, total)
    with closing(run([item for item in items if number(item) not in kept])) as fresh:
        for item in items:
            place = number(item)
            kept_arrays = store.read(*place) if store is not None and place in kept else None
            if kept_arrays is not None:
                block = form[1](kept_arrays)
            else:  # one that was kept has been damaged or taken away meanwhile
                block = next(run([item]) if place in kept else fresh)
                if store is not None and (arrays := form[0](block)) is not None:
                    store.write(*place, arrays)
            done += item[-1]
            tell(done, total)
            yield item, block


def read_block(folder: Path, block: int, size: int) -> dict[str, NDArray[np.generic]] | None:
    """Return a finished block of whatever run, with its ``digest``; None where it is damaged or not there."""
    try:
        content = _block_file(folder, block, size).read_bytes()
        arrays, checksum = content[:-_CHECKSUM_BYTES], content[-_CHECKSUM_BYTES:]
        if hashlib.sha256(arrays).digest() != checksum:
            return None
        with np.load(BytesIO(arrays), allow_pickle=False) as file:
            if file["block"].tolist() != [block, size]:
                return None
            return {name: file[name] for name in file.files if name != "block"}
    except _UNREADABLE:
        return None


def _block_file(folder: Path, block: int, size: int) -> Path:
    return folder / f"block-{block:07d}-{size}.npz"


def _read_identity(content: bytes) -> Identity | None:
    """Read ``run.json``; None where it does not agree with its digest."""
    try:
        whole = json.loads(content)
        digest = whole.pop("sha256")
        return Identity.from_whole(whole) if digest_of(whole) == digest else None
    except (ValueError, TypeError, KeyError, AttributeError, RecursionError):
        return None


class TrialsTable:
    """Parquet in memory, a row group a block: inputs, quantities and events of every trial; null where not reached."""

    def __init__(self) -> None:
        """Start an empty table.

        Raises InputError when pyarrow, which writes it, is not installed: found out before the first trial is run.
        """
        try:
            import_module("pyarrow")
        except ImportError as error:
            raise InputError([Problem(f"needs pyarrow: {how_to_install('parquet')}", key="keep_trials")]) from error
        self._content = io.BytesIO()
        self._writer: Any = None

    def add(self, first: int, rows: Mapping[str, NDArray[np.generic]]) -> None:
        """Add a block whose first trial has the number `first`."""
        import pyarrow
        from pyarrow import parquet

        size = len(next(iter(rows.values())))
        columns = {"trial": pyarrow.array(np.arange(first, first + size))}
        columns |= {
            name: pyarrow.array(np.ascontiguousarray(values), from_pandas=True) for name, values in rows.items()
        }
        table = pyarrow.table(columns)
        if self._writer is None:
            self._writer = parquet.ParquetWriter(self._content, table.schema, compression="zstd")
        self._writer.write_table(table)

    def parquet(self) -> bytes:
        """Close the table and return the file."""
        self._writer.close()
        return self._content.getvalue()


def read_trials(content: bytes | None) -> "pd.DataFrame":
    """Read the table that a run kept.

    Raises InputError when it kept none.
    """
    if content is None:
        hint = "simulate(..., keep_trials=True) keeps them"
        raise InputError([Problem("the trials were not kept", key="trials", hint=hint)])
    from pandas import read_parquet

    return read_parquet(io.BytesIO(content))
