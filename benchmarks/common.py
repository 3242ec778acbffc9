"""Shared by the comparisons: alternating timing, memory of a command, the machine, rows of the table.

Imports only the standard library, because the module also runs in a reference program's environment.
"""

import os
import platform
import shutil
import statistics
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
MISSIONS = ROOT / "missions"
POLL = 0.02
"""Interval between readings of a command's memory [s]."""


@dataclass(frozen=True)
class Options:
    """Extent of a run.

    Attributes
    ----------
    repeats : int
        Runs of each side, in alternation; the median counts.
    shrink : int
        Divisor of the sizes; 1 for the published tables.
    long : bool
        Include runs of many minutes.
    """

    repeats: int = 3
    shrink: int = 1
    long: bool = False


@dataclass(frozen=True)
class Row:
    """A row of the table; `met` is None without a target."""

    what: str
    ours: str
    peer: str = ""
    ratio: str = ""
    target: str = ""
    met: bool | None = None


@dataclass(frozen=True)
class Section:
    """Result of a comparison; `packages` are those whose versions matter, `notes` go below the table."""

    rows: tuple[Row, ...]
    packages: tuple[str, ...] = ("numpy",)
    notes: tuple[str, ...] = ()


Comparison = Callable[[Options], Section]


def alternate(sides: Mapping[str, Callable[[], Any]], repeats: int) -> dict[str, float]:
    """Run the sides in alternation (A B A B …) and return the median wall time of each [s].

    Other load on the machine then slows all sides alike.
    """
    times: dict[str, list[float]] = {name: [] for name in sides}
    for _ in range(repeats):
        for name, run in sides.items():
            started = time.perf_counter()
            run()
            times[name].append(time.perf_counter() - started)
    return {name: statistics.median(found) for name, found in times.items()}


@dataclass(frozen=True)
class Run:
    """A command that has ended: wall and CPU time [s], peak memory of it and its children [bytes], what it printed."""

    wall: float
    cpu: float
    peak: int
    output: str


def run_command(command: Sequence[str | Path], *, accept: Sequence[int] = (0,)) -> Run:
    """Run a command on one BLAS thread from the project's root, and watch its memory.

    The peak is the sum over its processes of the largest resident size of each, pages that they share counted once
    for each. It is read from ``/proc`` while they live (0 where there is none), and the last reading of each counts,
    for a child that has been forked and does not run its own program yet has the size of its parent; so does its
    ``ru_maxrss`` ever after.

    Raises
    ------
    RuntimeError
        When the exit status is not one of those accepted.
    """
    environment = {**os.environ, "OMP_NUM_THREADS": "1"}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)  # an installed package has its modules compiled
    started, before = time.perf_counter(), _cpu_of_children()
    process = subprocess.Popen(
        [str(word) for word in command],
        cwd=ROOT,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    peaks: dict[int, int] = {}
    ended = threading.Event()

    def watch() -> None:
        while not ended.wait(POLL):
            for pid in _family(process.pid):
                peaks[pid] = _peak_of(pid) or peaks.get(pid, 0)

    watcher = threading.Thread(target=watch, daemon=True)
    watcher.start()
    output, errors = process.communicate()
    wall = time.perf_counter() - started
    ended.set()
    watcher.join()
    if process.returncode not in accept:
        raise RuntimeError(f"{' '.join(map(str, command))}: exit status {process.returncode}\n{errors[-2000:]}")
    return Run(wall, _cpu_of_children() - before, sum(peaks.values()), output)


def python(*words: str | Path) -> list[str | Path]:
    """Command line of this Python with a module of the project."""
    return [sys.executable, "-m", *words]


def _cpu_of_children() -> float:
    times = os.times()
    return times.children_user + times.children_system


def _family(pid: int) -> list[int]:
    """Return a process and all its descendants."""
    found = [pid]
    for parent in found:
        for task in Path(f"/proc/{parent}/task").glob("*/children"):
            try:
                found += [int(child) for child in task.read_text().split()]
            except OSError:  # it has ended meanwhile
                continue
    return found


def _peak_of(pid: int) -> int:
    try:
        status = Path(f"/proc/{pid}/status").read_text()
    except OSError:
        return 0
    line = next((line for line in status.splitlines() if line.startswith("VmHWM:")), "VmHWM: 0 kB")
    return int(line.split()[1]) * 1024


@dataclass(frozen=True)
class Circumstances:
    """When and where a comparison ran; no names, no paths.

    Attributes
    ----------
    date : str
    machine : sequence of str
        Processors, memory and system.
    versions : sequence of str
        Python and the packages that matter.
    load : float or None
        Load average before; other load makes absolute times longer.
    """

    date: str
    machine: Sequence[str]
    versions: Sequence[str]
    load: float | None

    def words(self) -> str:
        """Return all of it on one line."""
        load = () if self.load is None else (f"load average {self.load:.1f} before",)
        return ", ".join((self.date, *self.machine, *self.versions, *load))


def load_average() -> float | None:
    """Return the load of the machine, where it is known."""
    return round(os.getloadavg()[0], 1) if hasattr(os, "getloadavg") else None


def circumstances(packages: Sequence[str], load: float | None) -> Circumstances:
    """Return when and where a comparison runs."""
    machine = (f"{os.cpu_count()} × {_processor()}", _memory(), platform.system())
    versions = (f"Python {platform.python_version()}", *(f"{name} {_version(name)}" for name in packages))
    return Circumstances(f"{datetime.now(UTC):%Y-%m-%d}", [part for part in machine if part], versions, load)


def _processor() -> str:
    cpuinfo = Path("/proc/cpuinfo")
    lines = cpuinfo.read_text().splitlines() if cpuinfo.exists() else []
    model = next((line.partition(":")[2].strip() for line in lines if line.startswith("model name")), "")
    return model or platform.processor() or platform.machine()


def _memory() -> str:
    try:
        return f"{os.sysconf('SC_PAGE_SIZE') * os.sysconf('SC_PHYS_PAGES') / 2**30:.0f} GiB"
    except (AttributeError, ValueError, OSError):
        return ""


def _version(package: str) -> str:
    if package == "cc":
        return compiler_version()
    try:
        return version(package)
    except PackageNotFoundError:
        return ""


def compiler_version() -> str:
    """Version of the C compiler; empty where there is none."""
    if shutil.which("cc") is None:
        return ""
    return subprocess.run(["cc", "-dumpfullversion"], capture_output=True, text=True, check=False).stdout.strip()


def duration(seconds: float) -> str:
    """Format a time with three digits and a suitable unit."""
    for unit, scale in (("s", 1.0), ("ms", 1e-3), ("µs", 1e-6)):
        if seconds >= scale:
            return f"{seconds / scale:.3g} {unit}" if seconds < 1000.0 * scale else f"{seconds / scale:.0f} {unit}"
    return f"{seconds / 1e-9:.3g} ns"


def grouped(count: int) -> str:
    """Format a whole number with its thousands separated."""
    return f"{count:_}".replace("_", " ")


def megabytes(size: float) -> str:
    """Format a memory size."""
    return f"{size / 1e6:.0f} MB"
