"""Errors that reach a user as a message and an exit status, never as a traceback."""

import errno
import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from difflib import get_close_matches
from typing import TypeVar

Result = TypeVar("Result")
KeyPath = tuple[str | int, ...]
"""Place of a value in a file: keys of mappings and indices of lists, from the outside in."""

UNPRINTABLE = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069\ufffe\uffff]")
"""Control characters but tab and line feed, what reverses the direction of text, and what XML cannot hold."""
_LONGEST = 60
"""Characters of a value that a message shows."""


@dataclass(frozen=True)
class Problem:
    """One thing wrong with a file or an option."""

    message: str
    """What was expected, and what was given."""
    file: str = ""
    """File as the user named it; empty for a command-line option."""
    line: int | None = None
    """Line in that file, from 1."""
    key: str = ""
    """Key path, such as ``phases[0].transit.speed``, or a column, or an option."""
    hint: str = ""
    """The nearest valid key, or how to correct it."""

    def __str__(self) -> str:
        place = f"{self.file}:{self.line}" if self.file and self.line is not None else self.file
        parts = [part for part in (place, self.key, self.message) if part]
        text = ": ".join(parts) + (f" ({self.hint})" if self.hint else "")
        return UNPRINTABLE.sub(lambda match: ascii(match[0])[1:-1], text)


@dataclass(frozen=True)
class LocalProblem:
    """One thing wrong with a value, where the place of that value in a file is not known yet."""

    path: KeyPath
    """Key path below the value; empty for the value itself."""
    message: str
    hint: str = ""
    """See `Problem`."""

    def within(self, outer: KeyPath) -> "LocalProblem":
        """Return the same problem, its path starting further out."""
        return replace(self, path=(*outer, *self.path))


class MissionplanError(Exception):
    """Base of the errors that a command reports as a message."""

    exit_status = 1


class InputError(MissionplanError):
    """Bad input or options (exit status 2): all problems of a file at once."""

    exit_status = 2

    def __init__(self, problems: Sequence[Problem] | str) -> None:
        self.problems = (Problem(problems),) if isinstance(problems, str) else tuple(problems)
        super().__init__("\n".join(str(problem) for problem in self.problems))

    def __reduce__(self) -> tuple[type["InputError"], tuple[Sequence[Problem]]]:
        """Keep the problems when a worker's error is sent to the process that waits for it."""
        return type(self), (self.problems,)


def attempted(call: Callable[[], Result], problems: list[Problem]) -> Result | None:
    """Return what a call returns; None where input is bad, whose problems are added to a list of them.

    So what is wrong with several inputs can be told at once.
    """
    try:
        return call()
    except InputError as error:
        problems += error.problems
        return None


class RunError(MissionplanError):
    """The run itself failed (exit status 1)."""


OUT_OF_FILES = "the system lets this process open no more files: raise the limit (ulimit -n)"


def out_of_files(error: BaseException | None) -> bool:
    """Tell whether an error comes of the limit of open files; loky hides it behind one of its own."""
    while error is not None and not (isinstance(error, OSError) and error.errno in (errno.EMFILE, errno.ENFILE)):
        error = error.__cause__ or error.__context__
    return error is not None


def key_path(path: KeyPath) -> str:
    """Return a key path as users write it: ``phases[0].transit.speed``."""
    text = ""
    for part in path:
        text += f"[{part}]" if isinstance(part, int) else f".{part}" if text else str(part)
    return text


def shown(value: object) -> str:
    """Return a value as messages show it, cut where it is long."""
    try:
        text = repr(value)
    except ValueError:  # of a whole number with thousands of digits
        return "a number with thousands of digits"
    return text if len(text) <= _LONGEST else text[: _LONGEST - 3] + "..."


def counted(number: int, noun: str) -> str:
    """Write a number of things: ``1 row``, ``2 rows``."""
    return f"{number} {noun}{'' if number == 1 else 's'}"


def did_you_mean(name: str, names: Iterable[str], before: str = "") -> str:
    """Return a hint at the known name nearest to the one given, with `before` in front; empty where none is near."""
    close = get_close_matches(name, list(names), n=1)
    return f"{before}did you mean {close[0]}?" if close else ""
