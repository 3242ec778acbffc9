"""Report folders: written under a temporary name and renamed, never over existing files unless forced."""

import os
import shutil
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from missionplan.errors import InputError, Problem, RunError


def write_atomically(path: Path, content: str | bytes) -> None:
    """Write a file under a temporary name and rename it, so that a reader never sees half of it.

    Raises
    ------
    RunError
        When the disk is full, or the folder is missing or not writable.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
        try:
            with os.fdopen(handle, "wb") as file:
                file.write(content.encode() if isinstance(content, str) else content)
            Path(name).chmod(0o644)
            Path(name).replace(path)
        except BaseException:
            Path(name).unlink(missing_ok=True)
            raise
    except OSError as error:
        raise RunError(f"cannot write {path}: {error.strerror or error}") from error


def check_new_folder(folder: Path, *, force: bool = False) -> None:
    """Refuse a folder that is not empty, before any work is done.

    Raises
    ------
    InputError
        When it is a file, or not empty without `force`, or its name is invalid.
    """
    try:
        exists, holds = folder.exists(), folder.is_dir() and any(folder.iterdir())
    except (OSError, ValueError) as error:
        words = getattr(error, "strerror", None) or str(error)
        raise InputError([Problem(f"cannot be a folder: {words}", file=str(folder))]) from error
    if exists and not folder.is_dir():
        raise InputError([Problem("is a file; a folder was expected", file=str(folder))])
    if holds and not force:
        raise InputError([Problem("is not empty", file=str(folder), hint="force=True writes over it")])


def check_holds_no_input(folder: Path, inputs: Iterable[Path]) -> None:
    """Refuse a report folder that holds files that were read, whatever their names: a report never replaces them.

    Raises
    ------
    InputError
        With each of these files.
    """
    places = {(folder / name).resolve() for name in ("", "figures", "blocks")}
    inside = [path for path in inputs if {path.parent.resolve(), path.resolve().parent} & places]
    hint = "name another folder"
    message = f"is read by this command and lies in the report folder {folder}, where it could be overwritten"
    if inside:
        raise InputError([Problem(message, str(path), hint=hint) for path in inside])


@contextmanager
def new_folder(folder: Path, *, force: bool = False) -> Iterator[Path]:
    """Yield a temporary folder beside `folder`; on success it replaces `folder`, on failure it is removed.

    With `force`, files of the same name in an existing folder are replaced and others are kept.
    """
    check_new_folder(folder, force=force)
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        temporary = Path(tempfile.mkdtemp(dir=folder.parent, prefix=f".{folder.name}."))
    except OSError as error:
        raise RunError(f"cannot write in {folder.parent}: {error.strerror or error}") from error
    try:
        temporary.chmod(0o755)
        yield temporary
        if folder.is_dir() and any(folder.iterdir()):
            _move_files(temporary, folder)
        else:
            if folder.is_dir():
                folder.rmdir()
            temporary.rename(folder)
    except OSError as error:
        raise RunError(f"cannot write {folder}: {error.strerror or error}") from error
    finally:
        shutil.rmtree(temporary, ignore_errors=True)


def _move_files(source: Path, target: Path) -> None:
    """Rename every file below `source` into its place below `target`."""
    for path in sorted(source.rglob("*")):
        place = target / path.relative_to(source)
        if path.is_dir():
            place.mkdir(exist_ok=True)
        else:
            path.replace(place)
