"""Overhead per trial compared with monaco, a framework that runs any Python function case by case.

monaco has its own environment in a temporary folder. Both run the same scalar function (`transit_trial`);
missionplan also runs the same transit as a mission, vectorised. Overhead is the wall time minus that of the model.
Both sides draw the inputs and compute mean, standard deviation and three quantiles of the outputs; imports, reports and
the sensitivity analysis are in neither side's overhead; the last is compared in its own row.
"""

import json
import subprocess
import sys
import tempfile
import venv
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from benchmarks.common import Options, Row, Run, Section, duration, megabytes, python, run_command

CASES = (1024, 8192)
SUSTAINED = 100_000
ASKED = 100.0
OUTPUTS = 2
"""Cases of the scalar function."""
RESOLUTION = 1e-8
"""Smallest overhead per trial that the difference of two times resolves [s]."""


@dataclass(frozen=True)
class Cases:
    """A run of many cases.

    Attributes
    ----------
    each, overhead : float
        Time per case, and the part that the framework adds to the model [s].
    analysis : float
        Time of the sensitivity analysis, where there is one [s].
    peak : int
        Memory [bytes].
    outputs : int
        Number of quantities with statistics.
    """

    each: float
    overhead: float
    analysis: float
    peak: int
    outputs: int

    @classmethod
    def of(cls, runs: Sequence[Run], cases: int) -> "Cases":
        """Return the minimum of each printed time; the model may have been timed in separate runs."""
        printed = [json.loads(run.output.splitlines()[-1]) for run in runs]
        least = {key: min(found[key] for found in printed) for key in printed[0]}
        overhead = least["overhead"] if "overhead" in least else least["wall"] - least["inside"]
        peak, outputs = min(run.peak for run in runs), least.get("outputs", OUTPUTS)
        return cls(least["wall"] / cases, overhead / cases, least.get("analysis", 0.0), peak, outputs)

    @property
    def of_an_output(self) -> "Cases":
        """The same with the overhead per output."""
        return replace(self, overhead=self.overhead / self.outputs)


Key = tuple[str, int, int]
"""Side (``monaco``, ``function``, ``simulate``, ``sweep``), number of cases, number of workers."""
Measured = Mapping[Key, Cases]


def install(folder: Path) -> Path | None:
    """Create an environment with monaco and return its Python, or None if it cannot be installed."""
    venv.create(folder, with_pip=True)
    interpreter = folder / ("Scripts" if sys.platform == "win32" else "bin") / "python"
    command = [str(interpreter), "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "monaco"]
    done = subprocess.run(command, capture_output=True, check=False)
    return interpreter if done.returncode == 0 else None


def compare(options: Options) -> Section:
    """Run both sides in alternation, with one worker and with two."""
    sizes, many = [cases // options.shrink for cases in CASES], SUSTAINED // options.shrink
    keys = [(side, cases, workers) for cases in sizes for workers in (1, 2) for side in ("monaco", "function")]
    keys += [("simulate", trials, 1) for trials in (*sizes, many)]
    keys += [("sweep", trials, 1) for trials in (sizes[-1], many)]
    with tempfile.TemporaryDirectory() as folder:
        interpreter = install(Path(folder))
        if interpreter is None:
            return Section((Row("`monaco` could not be installed here", "not run"),))
        command = [str(interpreter), "-c", "from importlib.metadata import version; print(version('monaco'))"]
        release = run_command(command).output.strip()
        rounds = [{key: run(key, interpreter) for key in keys} for _ in range(options.repeats)]
        analysed = Cases.of([run(("monaco", sizes[0], 1), interpreter, "analysis")], sizes[0])
    measured = {key: Cases.of([found[key] for found in rounds], key[1]) for key in keys}
    what = f"sensitivity analysis, once, {sizes[0]} cases: 4 outputs (monaco: 2)"
    rows = [
        *_time_rows(keys, measured),
        *_function_rows(sizes, measured),
        *_study_rows(sizes, many, measured),
        _faster_row(what, measured["simulate", sizes[0], 1].analysis, analysed.analysis),
        *_memory_rows(sizes, keys, measured),
    ]
    alone = measured["monaco", sizes[-1], 1].each - measured["monaco", sizes[-1], 1].overhead
    return Section(
        tuple(rows), ("numpy", "joblib"), (f"The function alone takes {duration(alone)}. monaco {release}.",)
    )


def run(key: Key, interpreter: Path, *more: str) -> Run:
    """Run cases in a separate process."""
    what, cases, workers = key
    own = python("benchmarks.own_cases", what)
    command = [interpreter, "-m", "benchmarks.monaco_cases"] if what == "monaco" else own
    return run_command([*command, str(cases), str(workers), *more])


def _time_rows(keys: Sequence[Key], measured: Measured) -> Iterator[Row]:
    """Total times of the same function."""
    for side, cases, workers in keys:
        if side == "function":
            ours, theirs = measured[side, cases, workers], measured["monaco", cases, workers]
            what = f"time per case, same function, {cases} cases, {_count(workers)}"
            yield _faster_row(what, ours.each, theirs.each, digits=1)


def _function_rows(sizes: Sequence[int], measured: Measured) -> Iterator[Row]:
    """Overheads of the same function, average and marginal."""
    for cases in sizes:
        what = f"overhead per case, same function, {cases} cases"
        yield _overhead_row(what, measured["function", cases, 1], measured["monaco", cases, 1])
    few, many = sizes
    what = f"marginal overhead per case, same function, {few} to {many} cases"
    yield _overhead_row(what, *(_further(measured, side, few, many) for side in ("function", "monaco")))


def _study_rows(sizes: Sequence[int], many: int, measured: Measured) -> Iterator[Row]:
    """Overheads of the vectorised studies: per trial, marginal, per trial and output."""
    few, most = sizes
    theirs = measured["monaco", most, 1]
    for study in ("sweep", "simulate"):
        for trials in (most, many):
            what = f"overhead per trial, `{study}`, {trials} trials vs {most} cases"
            yield _overhead_row(what, measured[study, trials, 1], theirs)
    what = f"marginal overhead per trial, `simulate`, {most} to {many} trials vs {few} to {most} cases"
    yield _overhead_row(what, _further(measured, "simulate", most, many), _further(measured, "monaco", few, most))
    for trials in (most, many):
        ours = measured["simulate", trials, 1]
        what = f"overhead per trial and output, `simulate`, {trials} trials vs {most} cases: "
        what += f"{ours.outputs} outputs (monaco: {OUTPUTS})"
        yield _overhead_row(what, ours.of_an_output, theirs.of_an_output)
    what = f"total time per trial, `simulate`, model and analysis included, {many} trials vs {most} cases"
    yield _faster_row(what, measured["simulate", many, 1].each, theirs.each)


def _further(measured: Measured, what: str, few: int, many: int) -> Cases:
    """Marginal overhead per case."""
    fewer, more = measured[what, few, 1], measured[what, many, 1]
    return replace(more, overhead=(more.overhead * many - fewer.overhead * few) / (many - few))


def _memory_rows(sizes: Sequence[int], keys: Sequence[Key], measured: Measured) -> Iterator[Row]:
    """Peak memory, and memory per further case."""
    for side, cases, workers in keys:
        if side == "function":
            peak, peer = measured[side, cases, workers].peak, measured["monaco", cases, workers].peak
            what = f"peak memory, same function, {cases} cases, {_count(workers)}"
            yield Row(what, megabytes(peak), megabytes(peer))
    few, many = sizes
    ours, theirs = (
        f"{max(measured[side, many, 1].peak - measured[side, few, 1].peak, 0) / (many - few) / 1e3:.1f} kB"
        for side in ("function", "monaco")
    )
    yield Row(f"memory per further case, {few} to {many} cases, 1 worker", ours, theirs)


def _faster_row(what: str, ours: float, theirs: float, digits: int = 0) -> Row:
    return Row(what, duration(ours), duration(theirs), f"{theirs / ours:.{digits}f} × faster")


def _overhead_row(what: str, ours: Cases, theirs: Cases) -> Row:
    own_overhead = max(ours.overhead, RESOLUTION)
    times = theirs.overhead / own_overhead
    ratio = f"1/{times:.0f}" if times >= 1.5 else f"{1.0 / times:.1f} ×"
    return Row(what, duration(own_overhead), duration(theirs.overhead), ratio, "≤ 1/100", times >= ASKED)


def _count(workers: int) -> str:
    return f"{workers} worker" + ("s" if workers > 1 else "")
