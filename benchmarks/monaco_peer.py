"""Overhead a trial beside monaco, a framework that runs any Python function case by case.

monaco gets an environment of its own in a temporary folder. Both run the same scalar function (`transit_trial`);
missionplan also runs the same transit as a mission, vectorised. Overhead is the wall time less that of the model.
"""

import json
import subprocess
import sys
import tempfile
import venv
from dataclasses import dataclass
from pathlib import Path

from benchmarks.common import Options, Row, Run, Section, duration, megabytes, python, run_command

CASES = (1024, 8192)
SUSTAINED = 100_000
ASKED = 100.0


@dataclass(frozen=True)
class Cases:
    """A run of many cases: time of all, and of the model in it, a case [s]; peak memory [bytes]."""

    each: float
    inside: float
    peak: int

    @classmethod
    def of(cls, run: Run, cases: int) -> "Cases":
        """Read what a child printed."""
        found = json.loads(run.output.splitlines()[-1])
        return cls(found["wall"] / cases, found["inside"] / cases, run.peak)

    @property
    def overhead(self) -> float:
        """What the framework adds to the model, a case [s]."""
        return self.each - self.inside


def install(folder: Path) -> Path | None:
    """Make an environment with monaco; give its Python, or None where it cannot be installed."""
    venv.create(folder, with_pip=True)
    interpreter = folder / ("Scripts" if sys.platform == "win32" else "bin") / "python"
    command = [str(interpreter), "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "monaco"]
    done = subprocess.run(command, capture_output=True, check=False)
    return interpreter if done.returncode == 0 else None


def compare(options: Options) -> Section:
    """Run both, with one worker and with two."""
    sizes = [cases // options.shrink for cases in CASES]
    with tempfile.TemporaryDirectory() as folder:
        interpreter = install(Path(folder))
        if interpreter is None:
            return Section((Row("`monaco` could not be installed here", "not run"),))
        command = [str(interpreter), "-c", "from importlib.metadata import version; print(version('monaco'))"]
        release = run_command(command).output.strip()
        monaco = {
            (cases, workers): Cases.of(
                run_command([interpreter, "-m", "benchmarks.monaco_cases", str(cases), str(workers)]), cases
            )
            for cases in sizes
            for workers in (1, 2)
        }
    function = {key: own("function", *key) for key in monaco}
    sustained = own("simulate", SUSTAINED // options.shrink, 1)
    mission = {cases: own("simulate", cases, 1) for cases in sizes}
    rows = [_time_row(*key, function[key], theirs) for key, theirs in monaco.items()]
    for cases in sizes:
        theirs = monaco[cases, 1].overhead
        what = f"overhead a case, same function, {cases} cases"
        rows.append(_overhead_row(what, function[cases, 1].overhead, theirs))
        what = f"overhead a trial, `simulate` with all its report needs, {cases} trials"
        rows.append(_overhead_row(what, mission[cases].overhead, theirs))
    what = f"the same, {SUSTAINED // options.shrink} trials, beside {sizes[-1]} cases"
    rows.append(_overhead_row(what, sustained.overhead, monaco[sizes[-1], 1].overhead))
    what = f"whole time a trial, model included, {SUSTAINED // options.shrink} trials beside {sizes[-1]} cases"
    ratio = monaco[sizes[-1], 1].each / sustained.each
    rows.append(Row(what, duration(sustained.each), duration(monaco[sizes[-1], 1].each), f"{ratio:.0f} × faster"))
    for workers in (1, 2):
        key = sizes[-1], workers
        what = f"peak memory, same function, {sizes[-1]} cases, {_count(workers)}"
        rows.append(Row(what, megabytes(function[key].peak), megabytes(monaco[key].peak)))
    growth = [(runs[sizes[1], 1].peak - runs[sizes[0], 1].peak) / (sizes[1] - sizes[0]) for runs in (function, monaco)]
    ours_grows, monaco_grows = (f"{max(size, 0.0) / 1e3:.1f} kB" for size in growth)
    rows.append(Row(f"memory a case more, {sizes[0]} to {sizes[1]} cases, 1 worker", ours_grows, monaco_grows))
    alone = f"The function alone takes {duration(monaco[sizes[-1], 1].inside)} a case. monaco {release}."
    return Section(tuple(rows), ("numpy", "joblib"), (alone,))


def own(what: str, cases: int, workers: int) -> Cases:
    """Run the cases under missionplan, in a process of their own."""
    return Cases.of(run_command(python("benchmarks.own_cases", what, str(cases), str(workers))), cases)


def _time_row(cases: int, workers: int, ours: Cases, theirs: Cases) -> Row:
    what = f"time a case, same function, {cases} cases, {_count(workers)}"
    return Row(what, duration(ours.each), duration(theirs.each), f"{theirs.each / ours.each:.1f} × faster")


def _overhead_row(what: str, ours: float, theirs: float) -> Row:
    times = theirs / ours
    ratio = f"1/{times:.0f}" if times >= 1.5 else f"{1.0 / times:.1f} ×"
    return Row(what, duration(ours), duration(theirs), ratio, "≤ 1/100", times >= ASKED)


def _count(workers: int) -> str:
    return f"{workers} worker" + ("s" if workers > 1 else "")
