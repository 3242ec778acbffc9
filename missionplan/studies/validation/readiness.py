"""What a file is good for: which commands it is ready for, and what they lack."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from missionplan.errors import InputError, Problem
from missionplan.mission.schema.shared_sections import ValueInForce


@dataclass(frozen=True)
class Readiness:
    """Whether one command can use a file."""

    command: str
    needs: tuple[str, ...] = ()
    """What is missing or wrong; none where it is ready."""
    without: str = ""
    """What a part of its answer needs, where it is ready."""

    def __str__(self) -> str:
        words = f"needs {'; '.join(self.needs)}" if self.needs else "ready"
        return f"{self.command:<17} {words}" + (f"; needs {self.without}" if self.without and not self.needs else "")


@dataclass(frozen=True)
class Validated:
    """What was found of one file or data set."""

    path: Path
    summary: str = ""
    """What it is."""
    values: tuple[ValueInForce, ...] = ()
    """Of a mission, what is in force of the keys that its vehicle file may give too."""
    table: tuple[Readiness, ...] = ()
    """What it is good for."""
    notices: tuple[str, ...] = ()
    """What is unusual."""
    problems: tuple[Problem, ...] = ()
    """What is wrong; then there is no more."""


def needs(check: Callable[[], object]) -> tuple[str, ...]:
    """What a check refuses, in words: the key path where it is missing."""
    try:
        check()
    except InputError as error:
        return tuple(_in_words(problem) for problem in error.problems)
    return ()


def _in_words(problem: Problem) -> str:
    if problem.message.startswith("missing"):
        return problem.key
    words = problem.message.removeprefix("the mission has no ")
    return f"a {words}" if words != problem.message else f"{problem.key}: {words}" if problem.key else words
