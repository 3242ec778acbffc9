"""Names of files as users give them: looked at without an error for those that no file system takes."""

import os.path
from collections.abc import Iterable
from pathlib import Path, PurePath

from missionplan.errors import UNPRINTABLE, InputError, Problem, shown


def as_path(value: object, argument: str) -> Path:
    """Return an argument of a Python call as a path.

    Raises
    ------
    InputError
        When it is neither text nor a path, or holds a control character.
    """
    if not isinstance(value, str | PurePath):
        raise InputError([Problem(f"given {shown(value)}, expected a path", key=argument)])
    check_name(str(value))
    return Path(value)


def check_name(name: str) -> None:
    """Refuse a file name that no message and no report could show.

    Raises
    ------
    InputError
        When it holds a control character.
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

    Raises
    ------
    InputError
        When the folder is a file, or one of the files is there already.
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
