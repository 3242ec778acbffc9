"""Names of files as users give them: looked at without an error for those that no file system takes."""

import os.path
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


def is_folder(path: Path) -> bool:
    """Whether there is a folder at a path; no error where the name is too long."""
    return os.path.isdir(path)  # noqa: PTH112 - `Path.is_dir` raises an OSError


def is_file(path: Path) -> bool:
    """Whether there is a file at a path; no error where the name is too long."""
    return os.path.isfile(path)  # noqa: PTH113 - `Path.is_file` raises an OSError
