"""Checkpoints: finished blocks of a run on disk, so that a run killed at any time can be resumed.

One file per block, written atomically, beside ``run.json``, which records what the blocks depend on. File names contain
the size of the block: when a run is extended, its incomplete last block is computed again as a whole.
"""

import difflib
import hashlib
import json
import zlib
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from io import BytesIO
from pathlib import Path
from zipfile import BadZipFile

import numpy as np
from numpy.typing import NDArray

from missionplan.errors import InputError, Problem, RunError
from missionplan.store.folder import write_atomically

_UNREADABLE = (OSError, ValueError, KeyError, EOFError, BadZipFile, zlib.error)
Arrays = Mapping[str, NDArray[np.generic]]


@dataclass(frozen=True)
class Identity:
    """What the blocks of a run depend on, apart from their number.

    Attributes
    ----------
    mission : str
        The resolved mission as text, with digests of the data files that it reads.
    options : str
        Options that change a block's content, one per line.
    version : str
        Of the program.
    """

    mission: str
    options: str
    version: str

    @property
    def digest(self) -> str:
        """SHA-256 of all of it."""
        return hashlib.sha256(json.dumps(asdict(self), sort_keys=True).encode()).hexdigest()

    def differences(self, other: "Identity") -> str:
        """Unified diff from `other`, the older one."""
        parts = []
        for name, old in asdict(other).items():
            new = getattr(self, name)
            lines = difflib.unified_diff(
                old.splitlines(), new.splitlines(), f"{name} before", f"{name} now", "", "", 2, ""
            )
            parts += list(lines)
        return "\n".join(parts)


class Checkpoints:
    """The folder of a run's finished blocks.

    Parameters
    ----------
    folder : Path
        Created if necessary.
    identity : Identity
    resume : bool
        Whether to use the blocks that the folder holds.

    Raises
    ------
    InputError
        When the folder holds a run and `resume` is not given, or a different run; then with the difference.
    RunError
        When the folder cannot be written.
    """

    def __init__(self, folder: Path, identity: Identity, *, resume: bool = False) -> None:
        self._folder, self._digest = folder, identity.digest
        record = folder / "run.json"
        try:
            before = record.read_text(encoding="utf-8")
        except FileNotFoundError:
            before = None
        except (OSError, UnicodeDecodeError) as error:
            raise RunError(f"cannot read {record}: {error}") from error
        if before is not None:
            self._check(before, identity, resume=resume)
        for stray in folder.glob(".block-*"):  # left by a write that was killed
            stray.unlink(missing_ok=True)
        write_atomically(record, json.dumps(asdict(identity), indent=1, ensure_ascii=False) + "\n")

    def _check(self, before: str, identity: Identity, *, resume: bool) -> None:
        shown = str(self._folder)
        if not resume:
            message = "holds the finished blocks of a run"
            raise InputError([Problem(message, shown, hint="--resume continues with them")])
        try:
            old = Identity(**json.loads(before))
        except (ValueError, TypeError):
            raise InputError([Problem("run.json is not that of a run; nothing can be resumed", shown)]) from None
        if old != identity:
            message = f"holds blocks of another run; this is the difference:\n{identity.differences(old)}"
            raise InputError([Problem(message, shown)])

    def holds(self, block: int, size: int) -> bool:
        """Whether a block is there, by its name and digest."""
        try:
            with self._path(block, size).open("rb") as content, np.load(content, allow_pickle=False) as file:
                return str(file["digest"]) == self._digest
        except _UNREADABLE:
            return False

    def read(self, block: int, size: int) -> dict[str, NDArray[np.generic]] | None:
        """Return a finished block; None when there is none that can be read."""
        try:
            with self._path(block, size).open("rb") as content, np.load(content, allow_pickle=False) as file:
                arrays = {name: file[name] for name in file.files}
        except _UNREADABLE:
            return None
        return arrays if str(arrays.pop("digest", "")) == self._digest else None

    def write(self, block: int, size: int, arrays: Arrays) -> None:
        """Save a finished block.

        Raises
        ------
        RunError
            When the disk is full, or the folder is missing or not writable.
        """
        if not self._folder.is_dir():
            raise RunError(f"cannot write {self._path(block, size)}: the folder {self._folder} no longer exists")
        content = BytesIO()
        np.savez_compressed(content, digest=np.array(self._digest), **dict(arrays))  # type: ignore[arg-type]
        write_atomically(self._path(block, size), content.getvalue())

    def _path(self, block: int, size: int) -> Path:
        return self._folder / f"block-{block:07d}-{size}.npz"
