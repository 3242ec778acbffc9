"""Options that commands share, in groups: a command's parameter of a group's type stands for all of its options.

Standard output and error as they are found: of any encoding, full, or closed.
"""

import codecs
import errno
import inspect
import json
import math
import os
import shutil
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass, fields, is_dataclass
from datetime import datetime
from functools import wraps
from io import TextIOWrapper
from pathlib import Path
from typing import Annotated, Any, Literal, get_args, get_type_hints

import typer

from missionplan.errors import InputError, Problem, RunError, did_you_mean, shown


def choice(kind: Any, flag: str, **settings: Any) -> Any:
    """Make an option that takes one of some words: it refuses another one with the nearest, whatever typer's version.

    `kind`: the words. `flag`: as ``--units``. `**settings`: as of ``typer.Option``.
    """
    words = get_args(kind)

    def chosen(word: str) -> str:
        if word not in words:
            message = f"given {shown(word)}, expected one of {', '.join(words)}"
            raise InputError([Problem(message, key=flag.removeprefix("--"), hint=did_you_mean(word, words))])
        return word

    metavar = f"<{'|'.join(words)}>"
    return typer.Option(
        flag, **{"metavar": metavar, "parser": chosen, "autocompletion": lambda: list(words), **settings}
    )


ParallelBackend = Literal["loky", "threading", "dask"]
UnitSystem = Literal["metric", "nautical", "imperial"]


MissionFile = Annotated[Path, typer.Argument(metavar="MISSION", help="Mission file (YAML).")]
DatasetFolder = Annotated[Path, typer.Argument(metavar="DATASET", help="Data set: a folder with dataset.yaml.")]
AllowOutside = Annotated[
    bool, typer.Option("--allow-outside", help="Allow files outside the folder of the mission or data set.")
]
Seed = Annotated[int | None, typer.Option(min=0, help="Random seed; default: the mission's.")]
Jobs = Annotated[int, typer.Option("--jobs", "-j", help="Number of processes; 0: one per core.", min=0)]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Show no progress and no table.")]
Trials = Annotated[int | None, typer.Option(min=1, help="Number of trials; default: the mission's.")]
_Backend = Annotated[
    ParallelBackend, choice(ParallelBackend, "--backend", help="How blocks of trials are run in parallel.")
]
_Scheduler = Annotated[str | None, typer.Option(metavar="ADDRESS", help="Dask scheduler, tcp://host:port.")]
_Out = Annotated[Path | None, typer.Option("--out", "-o", help="Report folder; default: reports/MISSION/COMMAND-TIME.")]


_Units = Annotated[
    UnitSystem | None,
    choice(UnitSystem, "--units", help="Units of the report; default: as in the file. Files are in SI."),
]
Force = Annotated[bool, typer.Option("--force", help="Overwrite files in a folder that is not empty.")]
Resume = Annotated[bool, typer.Option("--resume", help="Go on with the finished blocks of a run cut short.")]
Json = Annotated[
    bool, typer.Option("--json", help="Print the summary as JSON on standard output, and nothing else there.")
]

JsonAnswer = Annotated[bool, typer.Option("--json", help="Print the answer as JSON on standard output.")]


@dataclass(frozen=True)
class MonteCarloOptions:
    """Options of a command that runs a Monte Carlo."""

    trials: Trials = None
    seed: Seed = None
    jobs: Jobs = 0
    backend: _Backend = "loky"
    scheduler: _Scheduler = None

    def arguments(self) -> dict[str, Any]:
        """Return the options as a study with a Monte Carlo takes them."""
        return {**asdict(self), "jobs": worker_count(self.jobs)}

    @property
    def other_processes(self) -> int:
        """Processes of the pool beside this one; 0 where it is not used."""
        return worker_count(self.jobs) - 1 if self.backend == "loky" else 0


@dataclass(frozen=True)
class OutputOptions:
    """Where a command's result goes, and what is printed."""

    out: _Out = None
    force: Force = False
    as_json: Json = False
    quiet: Quiet = False
    units: _Units = None


def worker_count(jobs: int) -> int:
    """Return the number of workers that `--jobs` means."""
    return jobs or os.cpu_count() or 1


def with_option_groups(command: Callable[..., None]) -> Callable[..., None]:
    """Make a command whose groups of options appear one by one on the command line.

    typer reads the options from the signature: a keyword-only parameter whose type is a data class is replaced there
    by the fields of the class, and assembled again when the command is called.
    """
    hints = get_type_hints(command, include_extras=True)
    groups = {name: hint for name, hint in hints.items() if isinstance(hint, type) and is_dataclass(hint)}

    @wraps(command)
    def flat(**arguments: object) -> None:
        for name, group in groups.items():
            arguments[name] = group(**{field.name: arguments.pop(field.name) for field in fields(group)})
        command(**arguments)

    parameters: list[inspect.Parameter] = []
    for parameter in inspect.signature(command).parameters.values():
        group = groups.get(parameter.name)
        types = get_type_hints(group, include_extras=True) if group else {}
        parameters += [
            inspect.Parameter(field.name, parameter.KEYWORD_ONLY, default=field.default, annotation=types[field.name])
            for field in (fields(group) if group else ())
        ] or [parameter]
    flat.__dict__["__signature__"] = inspect.Signature(parameters)
    flat.__annotations__ = {parameter.name: parameter.annotation for parameter in parameters}
    return flat


_PLAIN = {"\u202f": " ", "\u00a0": " ", "\u2009": " ", "–": "-", "—": "-", "−": "-", "×": "x", "…": "...", "√": "sqrt "}
_PLAIN |= {
    "σ": "sigma",
    "µ": "u",
    "μ": "u",
    "°": " deg",
    "±": "+-",
    "≤": "<=",
    "≥": ">=",
    "≈": "~",
    "→": "->",
    "²": "^2",
}
"""What stands for a character that the encoding of a stream lacks; for any other, its code."""

_OF_STREAMS = (errno.ENOSPC, errno.EPIPE, errno.EBADF, errno.EIO, errno.EDQUOT, errno.EFBIG)
"""Numbers of the errors of a stream that cannot be written."""


def _spelt_plainly(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    lacking = error.object[error.start : error.end]
    return "".join(_PLAIN.get(character) or ascii(character)[1:-1] for character in lacking), error.end


def prepare_streams() -> None:
    """Let both streams take any text, and let one that is closed take nothing."""
    codecs.register_error("missionplan", _spelt_plainly)
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if stream is None:
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: SIM115, PTH123 - kept to the end
        elif isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="missionplan")


def note(text: str) -> None:
    """Write a line to standard error, if that can be written at all."""
    with suppress(OSError):
        typer.echo(text, err=True)


def remark(text: str) -> None:
    """Write a sentence to standard error, broken at words where that is a terminal."""
    from missionplan.report.wording import wrapped

    note(wrapped(text, shutil.get_terminal_size().columns) if sys.stderr.isatty() else text)


def print_json(problems: Sequence[Problem] = (), **answer: object) -> None:
    """Write, for scripts, what a command has to say on standard output: what is wrong, or what its function returns.

    `answer`: by the names that it has in Python.
    """
    errors = []
    for problem in problems:
        expected, hint = problem.message.partition("expected ")[2], problem.hint
        message = f"{problem.message} ({hint})" if expected and hint else problem.message
        place = {"file": problem.file, "line": problem.line, "key": problem.key}
        errors.append({**place, "message": message, "expected": expected or hint})
    typer.echo(json.dumps({"errors": errors, **answer}, default=_plain, indent=1))


def _plain(value: object) -> object:
    """Return a data class as those of its fields that are data, null for a number that is not finite; else text."""
    if is_dataclass(value):
        entries = {field.name: getattr(value, field.name) for field in fields(value)}
        return {
            name: None if isinstance(entry, float) and not math.isfinite(entry) else entry
            for name, entry in entries.items()
            if not callable(entry)
        }
    if isinstance(value, Mapping):
        return dict(value)
    return value.isoformat() if isinstance(value, datetime) else str(value)


@contextmanager
def answering(saved: str = "") -> Iterator[None]:
    """Write the answer to standard output; a reader that has gone away, like `head`, is no error.

    `saved`: what the message says where the answer cannot be written. Raises RunError when it cannot be written, as on
    a full disk.
    """
    try:
        yield
        sys.stdout.flush()
    except BrokenPipeError:
        _discard_output()
    except OSError as error:
        if error.filename is not None or error.errno not in _OF_STREAMS:  # it is about something else
            raise
        _discard_output()
        raise RunError(f"cannot write to standard output: {error.strerror or error}{saved}") from error


def _discard_output() -> None:
    """Let what is left go nowhere, or the interpreter would complain about it at its end."""
    with suppress(OSError, ValueError):
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, sys.stdout.fileno())
        os.close(nowhere)
