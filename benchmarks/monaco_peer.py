"""Overhead a trial beside monaco, a framework that runs any Python function case by case.

monaco gets an environment of its own in a temporary folder. Both run the same scalar function (`transit_trial`);
missionplan also runs the same transit as a mission, vectorised. Overhead is the wall time less that of the model.
Both sides draw the inputs, and give mean, standard deviation and three quantiles of the outputs; imports, reports and
the analysis of sensitivities are in neither side's overhead, and the last is compared in a row of its own.
"""

import json
import subprocess
import sys
import tempfile
import venv
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from benchmarks.common import Options, Row, Run, Section, duration, megabytes, python, run_command

CASES = (1024, 8192)
SUSTAINED = 100_000
ASKED = 100.0
OUTPUTS = 2
"""Of the scalar function."""
RESOLUTION = 1e-8
"""Least overhead a trial that the difference of two times can tell [s]."""


@dataclass(frozen=True)
class Cases:
    """A run of many cases.

    Attributes
    ----------
    each, overhead : float
        Time a case, and what of it the framework adds to the model [s].
    analysis : float
        Time of the sensitivity analysis, where there is one [s].
    peak : int
        Memory [bytes].
    outputs : int
        Quantities of which statistics are given.
    """

    each: float
    overhead: float
    analysis: float
    peak: int
    outputs: int

    @classmethod
    def of(cls, run: Run, cases: int) -> "Cases":
        """Read what a child printed."""
        found = json.loads(run.output.splitlines()[-1])
        outputs = found.get("outputs", OUTPUTS)
        return cls(found["wall"] / cases, found["overhead"] / cases, found.get("analysis", 0.0), run.peak, outputs)

    @property
    def of_an_output(self) -> "Cases":
        """The same with its overhead shared out among the outputs."""
        return replace(self, overhead=self.overhead / self.outputs)


Runs = Mapping[tuple[int, int], Cases]
"""By cases and workers."""


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
        child: list[str | Path] = [interpreter, "-m", "benchmarks.monaco_cases"]
        monaco = {
            (cases, workers): Cases.of(run_command([*child, str(cases), str(workers)]), cases)
            for cases in sizes
            for workers in (1, 2)
        }
        analysed = Cases.of(run_command([*child, str(sizes[0]), "1", "analysis"]), sizes[0])
    function = {key: own("function", *key) for key in monaco}
    many, most = SUSTAINED // options.shrink, sizes[-1]
    rows = [_time_row(*key, function[key], theirs) for key, theirs in monaco.items()]
    rows += _function_rows(sizes, function, monaco)
    simulated = {cases: own("simulate", cases, 1) for cases in (sizes[0], most, many)}
    rows += _study_rows(sizes, many, simulated, monaco)
    what = f"sensitivity analysis, once, {sizes[0]} cases: 4 outputs here, 2 there"
    rows.append(_faster_row(what, simulated[sizes[0]].analysis, analysed.analysis))
    rows += _memory_rows(sizes, function, monaco)
    alone = monaco[most, 1].each - monaco[most, 1].overhead
    return Section(
        tuple(rows), ("numpy", "joblib"), (f"The function alone takes {duration(alone)}. monaco {release}.",)
    )


def _function_rows(sizes: list[int], ours: Runs, theirs: Runs) -> list[Row]:
    """Overheads of the same function, and what a case more costs."""
    few, many = sizes
    rows = []
    for cases in sizes:
        what = f"overhead a case, same function, {cases} cases"
        rows.append(_overhead_row(what, ours[cases, 1], theirs[cases, 1]))
    what = f"overhead a case more, same function, {few} to {many} cases"
    more = (_further(runs[few, 1], runs[many, 1], few, many) for runs in (ours, theirs))
    return [*rows, _overhead_row(what, *more)]


def _study_rows(sizes: list[int], many: int, simulated: Mapping[int, Cases], theirs: Runs) -> list[Row]:
    """Overheads of the vectorised studies: a trial, a trial more, a trial and output."""
    few, most = sizes
    rows = []
    swept = {trials: own("sweep", trials, 1) for trials in (most, many)}
    for study, runs in (("sweep", swept), ("simulate", simulated)):
        for trials in (most, many):
            what = f"overhead a trial, `{study}`, {trials} trials beside {most} cases"
            rows.append(_overhead_row(what, runs[trials], theirs[most, 1]))
    what = f"overhead a trial more, `simulate`, {most} to {many} trials beside {few} to {most} cases"
    more = _further(simulated[most], simulated[many], most, many)
    rows.append(_overhead_row(what, more, _further(theirs[few, 1], theirs[most, 1], few, most)))
    for trials in (most, many):
        what = f"overhead a trial and output, `simulate`, {trials} trials beside {most} cases: "
        what += f"{simulated[trials].outputs} outputs here, {OUTPUTS} there"
        rows.append(_overhead_row(what, simulated[trials].of_an_output, theirs[most, 1].of_an_output))
    what = f"whole time a trial, `simulate`, model and analysis included, {many} trials beside {most} cases"
    return [*rows, _faster_row(what, simulated[many].each, theirs[most, 1].each)]


def _further(few: Cases, many: Cases, fewer: int, more: int) -> Cases:
    """What a case more costs, once the fixed part is paid."""
    return replace(many, overhead=(many.overhead * more - few.overhead * fewer) / (more - fewer))


def _memory_rows(sizes: list[int], ours: Runs, theirs: Runs) -> list[Row]:
    """Peaks, and what a case more takes."""
    few, many = sizes
    rows = []
    for (cases, workers), their in theirs.items():
        what = f"peak memory, same function, {cases} cases, {_count(workers)}"
        rows.append(Row(what, megabytes(ours[cases, workers].peak), megabytes(their.peak)))
    growth = [max(runs[many, 1].peak - runs[few, 1].peak, 0) / (many - few) for runs in (ours, theirs)]
    what = f"memory a case more, {few} to {many} cases, 1 worker"
    return [*rows, Row(what, f"{growth[0] / 1e3:.1f} kB", f"{growth[1] / 1e3:.1f} kB")]


def own(what: str, cases: int, workers: int) -> Cases:
    """Run the cases under missionplan, in a process of their own."""
    return Cases.of(run_command(python("benchmarks.own_cases", what, str(cases), str(workers))), cases)


def _time_row(cases: int, workers: int, ours: Cases, theirs: Cases) -> Row:
    return _faster_row(
        f"time a case, same function, {cases} cases, {_count(workers)}", ours.each, theirs.each, digits=1
    )


def _faster_row(what: str, ours: float, theirs: float, digits: int = 0) -> Row:
    return Row(what, duration(ours), duration(theirs), f"{theirs / ours:.{digits}f} × faster")


def _overhead_row(what: str, ours: Cases, theirs: Cases) -> Row:
    own_overhead = max(ours.overhead, RESOLUTION)
    times = theirs.overhead / own_overhead
    ratio = f"1/{times:.0f}" if times >= 1.5 else f"{1.0 / times:.1f} ×"
    return Row(what, duration(own_overhead), duration(theirs.overhead), ratio, "≤ 1/100", times >= ASKED)


def _count(workers: int) -> str:
    return f"{workers} worker" + ("s" if workers > 1 else "")
