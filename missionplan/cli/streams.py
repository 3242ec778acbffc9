"""Standard output and error as they are found: of any encoding, full, or closed."""

import codecs
import errno
import os
import shutil
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from io import TextIOWrapper

import typer

from missionplan.errors import RunError

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
    return "".join(_PLAIN.get(each) or ascii(each)[1:-1] for each in lacking), error.end


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


@contextmanager
def answering(saved: str = "") -> Iterator[None]:
    """Write the answer to standard output; a reader that has gone away, like `head`, is no error.

    Parameters
    ----------
    saved : str
        What the message says where the answer cannot be written.

    Raises
    ------
    RunError
        When it cannot be written, as on a full disk.
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
