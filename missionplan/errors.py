"""Errors that reach a user as a message and an exit status, never as a traceback."""

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Problem:
    """One thing wrong with a file or an option.

    Attributes
    ----------
    message : str
        What was expected, and what was given.
    file : str
        File as the user named it; empty for a command-line option.
    line : int or None
        Line in that file, from 1.
    key : str
        Key path, such as ``phases[0].transit.speed``, or a column, or an option.
    hint : str
        The nearest valid key, or what would mend it.
    """

    message: str
    file: str = ""
    line: int | None = None
    key: str = ""
    hint: str = ""

    def __str__(self) -> str:
        place = f"{self.file}:{self.line}" if self.file and self.line is not None else self.file
        parts = [part for part in (place, self.key, self.message) if part]
        return ": ".join(parts) + (f" ({self.hint})" if self.hint else "")


class MissionplanError(Exception):
    """Base of the errors that a command reports in words."""

    exit_status = 1


class InputError(MissionplanError):
    """Bad input or options (exit status 2): all problems of a file at once."""

    exit_status = 2

    def __init__(self, problems: Sequence[Problem] | str) -> None:
        self.problems = (Problem(problems),) if isinstance(problems, str) else tuple(problems)
        super().__init__("\n".join(str(problem) for problem in self.problems))


class RunError(MissionplanError):
    """The run itself failed (exit status 1)."""
