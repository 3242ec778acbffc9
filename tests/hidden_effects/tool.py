"""The tool under test, run only through its command line."""

import contextlib
import importlib.util
import io
import json
import os
import runpy
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .case import Case

PROGRAM = "missionplan"
"""Name of the program."""


@dataclass(frozen=True)
class Outcome:
    """A case with its diagnosis by the tool; ``error`` is empty if the tool succeeded."""

    case: Case
    diagnosis: dict[str, Any]
    seconds: float
    error: str = ""


def run_cli(arguments: list[str], in_process: bool) -> tuple[int, str]:
    """Return exit status and standard error, with the tail of standard output."""
    if not in_process:
        environment = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", **os.environ}
        command = [sys.executable, "-m", PROGRAM, *arguments]
        done = subprocess.run(command, capture_output=True, text=True, env=environment, timeout=600, check=False)
        return done.returncode, done.stdout[-500:] + done.stderr
    out, err = io.StringIO(), io.StringIO()
    before = sys.argv
    sys.argv = [PROGRAM, *arguments]
    sys.modules.pop(f"{PROGRAM}.__main__", None)
    status = 0
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            runpy.run_module(PROGRAM, run_name="__main__", alter_sys=False)
    except SystemExit as stop:
        status = stop.code if isinstance(stop.code, int) else int(stop.code is not None)
    finally:
        sys.argv = before
    return status, out.getvalue()[-500:] + err.getvalue()


def unavailable_reason() -> str:
    """Return why the tool cannot diagnose; empty if it can."""
    if importlib.util.find_spec(PROGRAM) is None or importlib.util.find_spec(f"{PROGRAM}.__main__") is None:
        return f"`python -m {PROGRAM}` does not exist"
    status, text = run_cli(["diagnose", "--help"], in_process=False)
    return "" if status == 0 else f"`{PROGRAM} diagnose` does not exist (exit status {status}): {text[-200:]}"


def diagnose(case: Case, folder: Path, truth_folder: Path, in_process: bool = False, jobs: int = 1) -> Outcome:
    """Write the case, run ``diagnose`` on it with `jobs` processes (0: one per core) and read its result."""
    mission, data = case.write(folder / case.name, truth_folder)
    report = folder / f"{case.name}-report"
    begin = time.perf_counter()
    try:
        options = ["--out", str(report), "--json", "--jobs", str(jobs)]
        status, text = run_cli(["diagnose", str(mission), str(data), *options], in_process)
    except Exception as fault:  # a crash of the tool is a result and does not end the study
        return Outcome(case, {}, time.perf_counter() - begin, f"{type(fault).__name__}: {fault}")
    seconds = time.perf_counter() - begin
    found = report / "diagnosis.json"
    if status not in (0, 3) or not found.exists():
        return Outcome(case, {}, seconds, f"exit status {status}: {text.strip()[-400:]}")
    return Outcome(case, json.loads(found.read_text(encoding="utf-8")), seconds)


def diagnose_without_plans(case: Case, folder: Path, truth_folder: Path) -> Outcome:
    """Write the case and diagnose it in Python, without the plans, pages and drawings that no figure is made of."""
    mission, data = case.write(folder / case.name, truth_folder)
    begin = time.perf_counter()
    found = importlib.import_module(PROGRAM).diagnose(mission, data, plan=False)
    seconds = time.perf_counter() - begin
    return Outcome(case, json.loads(found.files()["diagnosis.json"]), seconds)
