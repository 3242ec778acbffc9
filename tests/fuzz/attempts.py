"""What counts as a finding: a traceback, a warning, a number that is none, and time or memory beyond bounds."""

import io
import math
import resource
import signal
import time
import traceback
import warnings
from collections.abc import Callable, Mapping
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass

from missionplan.errors import InputError, MissionplanError

REFUSAL_SECONDS = 1.0
"""Of CPU that a refusal may take, beside the start of Python."""
GROWTH_KB = 300_000
"""By which one attempt may raise the process's largest memory."""

_MAY_BE_MISSING = ("fits.chi_squared", "ranking.held_out.paired_se")
"""Numbers that an answer may lack: χ² where no errors are stated, a spread between runs where there is one run."""


class Overtime(BaseException):
    """The attempt took more CPU than any may."""


@dataclass(frozen=True)
class Finding:
    """What is wrong: a short name by which findings are told apart, and the details."""

    name: str
    details: str


def attempt(act: Callable[[], object], limit: float) -> tuple[str, Finding | None]:
    """Do something once: how it ended (`done`, `refused`, `failed` or `finding`), and what is wrong."""
    before, start = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss, time.process_time()
    ending, finding = _guarded(act, limit)
    spent = time.process_time() - start
    grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
    if finding is None and ending == "refused" and spent > REFUSAL_SECONDS:
        finding = Finding("slow refusal", f"{spent:.1f} s of CPU")
    if finding is None and grown > GROWTH_KB:
        finding = Finding("memory", f"grew by {grown / 1000:.0f} MB")
    return ("finding" if finding else ending), finding


def _guarded(act: Callable[[], object], limit: float) -> tuple[str, Finding | None]:
    def stop(_signal: int, _frame: object) -> None:
        raise Overtime

    previous = signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, limit)
    try:
        with warnings.catch_warnings(), redirect_stdout(io.StringIO()), redirect_stderr(io.StringIO()):
            warnings.simplefilter("error", RuntimeWarning)
            result = act()
    except InputError:
        return "refused", None
    except MissionplanError:
        return "failed", None
    except Overtime:
        return "finding", Finding("time", f"more than {limit:g} s of CPU")
    except Exception as error:
        frames = [each for each in traceback.extract_tb(error.__traceback__) if "missionplan/" in each.filename]
        place = f"{frames[-1].filename.rpartition('missionplan/')[2]}:{frames[-1].name}" if frames else "?"
        return "finding", Finding(f"{type(error).__name__} in {place}", traceback.format_exc())
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, previous)
    wrong = [key for key, value in numbers_in(result) if not math.isfinite(value) and key not in _MAY_BE_MISSING]
    return ("done", None) if not wrong else ("finding", Finding(f"not finite: {wrong[0]}", ", ".join(wrong)))


def numbers_in(value: object, path: str = ""):
    """Yield every float of a summary with its key path."""
    if isinstance(value, Mapping):
        for key, inner in value.items():
            yield from numbers_in(inner, f"{path}.{key}" if path else str(key))
    elif isinstance(value, list | tuple):
        for inner in value:
            yield from numbers_in(inner, path)
    elif isinstance(value, float):
        yield path, value
