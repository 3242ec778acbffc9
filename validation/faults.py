"""Rows on faults survived: planted in the code, in the input, and in the run."""

import io
import re
from contextlib import redirect_stdout

from validation.rows import Options, at_least, at_most, reported, row


def _printed(main: object, *words: str) -> tuple[int, str]:
    """Run a harness's main; its exit status and what it prints."""
    out = io.StringIO()
    with redirect_stdout(out):
        status = main(list(words))  # type: ignore[operator]
    return status, out.getvalue()


@row(
    "fault.mutation",
    "The nearest tests notice a fault planted at the edges",
    case="24 faults: comparisons, signs, constants, conditions in readers, writers and checks",
    reference="`tests.mutation`",
    seed=63,
    accepted=[at_least("noticed", 0.6, "of those decided"), reported("decided")],
    differs="0.85 is asked; some faults change nothing; the command lists those that lived",
    cost=500.0,
)
def _mutation(_: Options) -> list[float]:
    from tests.mutation.__main__ import main

    _status, text = _printed(main, "--count", "24", "--seed", "63", "--bound", "0.5", "--jobs", "1")
    found = re.search(r"(\d+) of (\d+) noticed", text)
    assert found is not None
    return [int(found[1]) / max(int(found[2]), 1), float(found[2])]


@row(
    "fault.fuzz",
    "Damaged files and options end in a clear message",
    case="20 damaged examples of each target",
    reference="`tests.fuzz`: no traceback, warning, number that is none; bounded time and memory",
    seed=48,
    accepted=[at_most("findings", 0.0), reported("cases")],
    cost=120.0,
)
def _fuzz(_: Options) -> list[float]:
    from tests.fuzz.__main__ import TARGETS, run

    found = [run(name, 20, 48, None) for name in TARGETS]
    return [float(sum(len(findings) for _, findings in found)), float(sum(sum(counts.values()) for counts, _ in found))]


@row(
    "fault.kill",
    "A run ended at any moment resumes to the same numbers",
    case="6 runs ended by SIGKILL, SIGTERM or SIGINT, alone, with workers and with Dask",
    reference="`tests.kill`: every file as of an undisturbed run",
    seed=48,
    accepted=[at_most("runs with a finding", 0.0)],
    cost=150.0,
)
def _kill(_: Options) -> list[float]:
    from tests.kill.__main__ import main

    _status, text = _printed(main, "--count", "6", "--seed", "48")
    found = re.search(r"(\d+) of (\d+) without a finding", text)
    assert found is not None
    return [float(int(found[2]) - int(found[1]))]
