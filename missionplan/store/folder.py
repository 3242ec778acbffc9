"""Report folders: one run's at a time, written under a temporary name and renamed, never over files unless forced.

Names of files as users give them: looked at without an error for those that no file system takes.
"""

import glob
import os
import os.path
import shutil
import tempfile
import threading
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from datetime import UTC, datetime
from pathlib import Path, PurePath
from typing import TextIO

from missionplan.errors import UNPRINTABLE, InputError, Problem, RunError, shown


def as_path(value: object, argument: str) -> Path:
    """Return an argument of a Python call as a path.

    Raises InputError when it is neither text nor a path, or holds a control character.
    """
    if not isinstance(value, str | PurePath):
        raise InputError([Problem(f"given {shown(value)}, expected a path", key=argument)])
    check_name(str(value))
    return Path(value)


def check_name(name: str) -> None:
    """Refuse a file name that no message and no report could show.

    Raises InputError when it holds a control character.
    """
    if UNPRINTABLE.search(name):
        raise InputError([Problem("is no name for a file: it holds a control character", file=name)])


def real_path(path: Path) -> Path:
    """Return where a path leads, through links; no error where these lead in a circle."""
    return Path(os.path.realpath(path))


def is_folder(path: Path) -> bool:
    """Whether there is a folder at a path; no error where the name is too long."""
    return os.path.isdir(path)  # noqa: PTH112 - `Path.is_dir` raises an OSError


def is_file(path: Path) -> bool:
    """Whether there is a file at a path; no error where the name is too long."""
    return os.path.isfile(path)  # noqa: PTH113 - `Path.is_file` raises an OSError


def exists(path: Path) -> bool:
    """Whether there is anything at a path; no error where the name is too long."""
    return os.path.exists(path)  # noqa: PTH110 - `Path.exists` raises an OSError


def vacant(folder: Path, names: Iterable[str]) -> list[Path]:
    """Return the paths of files to write in a folder, none of which is there yet.

    Raises InputError when the folder is a file, or one of the files is there already.
    """
    if exists(folder) and not is_folder(folder):
        raise InputError([Problem("is a file; a folder was expected", str(folder))])
    paths = [folder / name for name in names]
    hint = "nothing was written; name another folder"
    present = [Problem("is there already", str(path), hint=hint) for path in paths if exists(path)]
    if present:
        raise InputError(present)
    return paths


def matching(pattern: str) -> tuple[str, ...]:
    """Return the names of the files that an absolute pattern with ``*`` stands for, in order; without one, its own."""
    if "*" not in pattern:
        return (pattern,)
    root = Path(pattern).anchor
    return tuple(sorted(map(str, Path(root).glob(str(Path(pattern).relative_to(root))))))


try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]

_FILES = ("report.html", "summary.json", "mission.yaml")
"""Files of every report."""
_OWNER = ".owner"
"""Locked in a folder while it is written."""
_ATTEMPTS = 100
_held: dict[Path, int] = {}
"""Folders that this process holds, with the thread that does."""
_LONGEST_NAME = 240
"""Bytes of a name that leave room for that of the temporary folder; file systems take 255."""


def write_atomically(path: Path, content: str | bytes) -> None:
    """Write a file under a temporary name and rename it, so that a reader never sees half of it.

    Raises RunError when the disk is full, or the folder is missing or not writable.
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
    """Refuse a folder that is not empty or that no report can be written to, before any work is done.

    Raises InputError when it is a file, a link to nothing, or not empty without `force`, when its name is invalid, or
    when it holds folders with names of a report's files.
    """
    check_name(str(folder))
    try:
        problem = _place_problem(folder) or _content_problem(folder, force=force)
    except (OSError, ValueError) as error:
        words = getattr(error, "strerror", None) or str(error)
        raise InputError([Problem(f"cannot be a folder: {words}", file=str(folder))]) from error
    if problem is not None:
        raise InputError([problem])


def _place_problem(folder: Path) -> Problem | None:
    """Return why there can be no folder in this place.

    Raises OSError or ValueError when the system refuses to look.
    """
    places = (folder, *folder.parents)
    in_a_file = next((place for place in places if place.exists() and not place.is_dir()), None)
    if max(len(os.fsencode(place.name)) for place in places) > _LONGEST_NAME:
        return Problem("cannot be a folder: File name too long", file=str(folder))
    if folder.is_symlink() and not folder.exists():
        return Problem(f"is a link to {folder.readlink()}, which does not exist", file=str(folder))
    if in_a_file is not None:
        return Problem("is a file; a folder was expected", file=str(in_a_file))
    return None


def _content_problem(folder: Path, *, force: bool) -> Problem | None:
    """Return what in a folder would keep a report from being written."""
    holds = folder.is_dir() and any(folder.iterdir())
    if holds and not force:
        return Problem("is not empty", file=str(folder), hint="force=True writes over it")
    for name in _FILES if holds else ():
        if (folder / name).is_dir():
            return Problem("is a folder; a report's file of that name could not be written", str(folder / name))
    figures = folder / "figures"
    if figures.exists() and not figures.is_dir():
        return Problem("is a file; a report's folder of that name could not be written", str(figures))
    return None


def check_holds_no_input(folder: Path, inputs: Iterable[Path]) -> None:
    """Refuse a report folder that holds files that were read, whatever their names: a report never replaces them.

    Raises InputError with each of these files.
    """
    places = {(folder / name).resolve() for name in ("", "figures", "blocks")}
    inside = [path for path in inputs if {path.parent.resolve(), path.resolve().parent} & places]
    hint = "name another folder"
    message = f"is read by this command and lies in the report folder {folder}, where it could be overwritten"
    if inside:
        raise InputError([Problem(message, str(path), hint=hint) for path in inside])


def new_folder_name(parent: Path, command: str) -> Path:
    """Name the report folder of a command that starts now; runs that start together get different ones."""
    return parent / f"{command}-{datetime.now(UTC):%Y%m%dT%H%M%SZ}-{os.urandom(3).hex()}"


@contextmanager
def claimed(folder: Path, *, force: bool = False) -> Iterator[None]:
    """Hold a report folder: meanwhile no other run may, in this process or another.

    The lock, a hidden file beside the folder, ends with the process whatever ends it.

    Raises InputError when another run holds the folder, or `check_new_folder` refuses it. Nothing in it has been
    changed then. Raises RunError when the lock cannot be written.
    """
    check_new_folder(folder, force=force)
    place, me = folder.resolve(), threading.get_ident()
    if _held.get(place) == me:
        yield
        return
    made = [parent for parent in place.parents if not parent.exists()]
    lock = _lock_beside(place, folder)
    try:
        check_new_folder(folder, force=force)  # a run that held it may just have ended
        _held[place] = me
        yield
    finally:
        _held.pop(place, None)
        with suppress(OSError):
            Path(lock.name).unlink()
        lock.close()
        for parent in made:  # where nothing was written they are empty
            with suppress(OSError):
                parent.rmdir()


def is_claimed(folder: Path) -> bool:
    """Whether a run holds a folder now."""
    return not _is_free(_lock_file(folder.resolve()))


def _lock_file(place: Path) -> Path:
    return place.with_name(f".{place.name}.lock") if place.name else place / ".lock"


def _lock_beside(place: Path, shown: Path) -> TextIO:
    path = _lock_file(place)
    for _ in range(_ATTEMPTS):
        try:
            place.parent.mkdir(parents=True, exist_ok=True)
            lock = path.open("a")
        except FileNotFoundError:  # a run that ended has removed a folder above that it had made
            continue
        except OSError as error:
            raise RunError(f"cannot write in {place.parent}: {error.strerror or error}") from error
        if not _locks(lock):
            lock.close()
            hint = "nothing was changed; wait for it, or name another folder"
            raise InputError([Problem("another run is writing to this folder", str(shown), hint=hint)])
        with suppress(OSError):
            if path.stat().st_ino == os.fstat(lock.fileno()).st_ino:
                return lock
        lock.close()  # the run that held it has ended and removed it
    raise RunError(f"cannot lock {path}: it is removed time and again")


@contextmanager
def new_folder(folder: Path, *, force: bool = False) -> Iterator[Path]:
    """Yield a temporary folder beside `folder`; on success it replaces `folder`, on failure it is removed.

    With `force`, files of the same name in an existing folder are replaced and others are kept.
    """
    with claimed(folder, force=force):
        target = folder.resolve() if folder.is_symlink() else folder  # a link stays one
        try:
            _remove_strays(target)
            temporary = Path(tempfile.mkdtemp(dir=target.parent, prefix=f".{target.name}."))
        except OSError as error:
            raise RunError(f"cannot write in {target.parent}: {error.strerror or error}") from error
        try:
            temporary.chmod(0o755)
            with (temporary / _OWNER).open("w") as lock:
                _locks(lock)
                yield temporary
            (temporary / _OWNER).unlink()
            if target.is_dir() and any(target.iterdir()):
                _move_files(temporary, target)
            else:
                if target.is_dir():
                    target.rmdir()
                temporary.rename(target)
        except OSError as error:
            raise RunError(f"cannot write {folder}: {error.strerror or error}") from error
        finally:
            shutil.rmtree(temporary, ignore_errors=True)


def _locks(file: TextIO) -> bool:
    """Lock an open file until it is closed; False where another process has. Some systems know no such locks."""
    if fcntl is None:
        return True
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:  # a file system without locks
        return True
    return True


def _remove_strays(folder: Path) -> None:
    """Remove what killed reports have left beside a folder; what is still written to is locked."""
    for stray in folder.parent.glob(f".{glob.escape(folder.name)}.*"):
        owner, is_own = stray / _OWNER, stray.is_dir() and not stray.is_symlink()
        if fcntl is not None and is_own and owner.exists() and _is_free(owner):  # without locks nothing is known
            shutil.rmtree(stray, ignore_errors=True)


def _is_free(path: Path) -> bool:
    try:
        with path.open("r+") as file:
            return _locks(file)
    except OSError:
        return not path.exists()


def _move_files(source: Path, target: Path) -> None:
    """Rename every file below `source` into its place below `target`."""
    for path in sorted(source.rglob("*")):
        place = target / path.relative_to(source)
        if path.is_dir():
            place.mkdir(exist_ok=True)
        else:
            path.replace(place)
