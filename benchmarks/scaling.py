"""How `missionplan simulate` grows with trials, jobs and legs: whole commands, from start to report."""

import json
import shutil
import tempfile
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

from benchmarks.common import MISSIONS, Options, Row, Section, duration, megabytes, python, run_command

MISSION = "chesapeake.yaml"
PACKAGES = ("numpy", "scipy", "joblib")
SIZES = {1: (1_000, 10_000, 100_000), 2: (1_000, 10_000, 100_000, 1_000_000)}
LONG = 10_000_000
ASKED = {100_000: 15.0, 1_000_000: 120.0}
"""Most time by trials, on two jobs [s]."""
MOST_MEMORY = 1e9
LEG_LENGTHS = (400, 200, 100, 50)
"""[m]; the distance of the mission's transits is a multiple of each."""
LEG_TRIALS = 20_000
REQUIREMENT_NOT_MET = 3


@dataclass(frozen=True)
class Simulated:
    """A run of the command: start to report, the simulation in it [s], peak memory [bytes], mean surfacings."""

    wall: float
    elapsed: float
    peak: int
    surfacings: float


def simulate(mission: Path, trials: int, jobs: int) -> Simulated:
    """Run the command in a folder that is removed afterwards."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "report"
        words = python("missionplan", "simulate", mission, "--trials", str(trials), "--jobs", str(jobs))
        run = run_command([*words, "--quiet", "--out", out], accept=(0, REQUIREMENT_NOT_MET))
        summary = json.loads((out / "summary.json").read_text())
    phases = [phase["quantities"] for phase in summary["phases"]]
    surfacings = sum(phase["surfacings"]["mean"] for phase in phases if "surfacings" in phase)
    return Simulated(run.wall, summary["elapsed_s"], run.peak, surfacings)


def trials(options: Options) -> Section:
    """Trials and jobs."""
    sizes = {jobs: list(counts) + [LONG] * (options.long and jobs == 2) for jobs, counts in SIZES.items()}
    found = {
        (jobs, count // options.shrink): simulate(MISSIONS / MISSION, count // options.shrink, jobs)
        for count in sorted({count for counts in sizes.values() for count in counts})
        for jobs in sizes
        if count in sizes[jobs]
    }
    rows = []
    for (jobs, count), run in found.items():
        most = ASKED.get(count) if jobs == 2 else None
        met = None if most is None else run.wall <= most and run.peak < MOST_MEMORY
        asked = "" if most is None else f"≤ {most:.0f} s, < 1 GB"
        spent = f"{duration(run.wall)}, {duration(run.elapsed / count)} a trial, {megabytes(run.peak)}"
        rows.append(
            Row(f"{count:,} trials, {jobs} job{'s' * (jobs > 1)}".replace(",", " "), spent, asked=asked, met=met)
        )
    largest = [(count, run) for (jobs, count), run in found.items() if jobs == 2]
    for (few, before), (many, after) in list(pairwise(largest))[1:]:
        cost = (after.elapsed / many) / (before.elapsed / few)
        text = f"{cost:.2f} × the time a trial, {after.peak / before.peak:.2f} × the memory"
        rows.append(Row(f"{many:,} beside {few:,} trials, 2 jobs".replace(",", " "), text, asked="linear, flat"))
    most = max(count for jobs, count in found if jobs == 1)
    gain = found[1, most].elapsed / found[2, most].elapsed
    rows.append(Row(f"2 jobs: 1 job, {most:,} trials, workers cold".replace(",", " "), f"{gain:.2f} × faster"))
    return Section(tuple(rows), PACKAGES)


def legs(options: Options) -> Section:
    """Shorter legs on the same way."""
    rows = []
    count = LEG_TRIALS // options.shrink
    runs = []
    with tempfile.TemporaryDirectory() as folder:
        shutil.copytree(MISSIONS / "vehicles", Path(folder) / "vehicles")
        text = (MISSIONS / MISSION).read_text()
        for length in LEG_LENGTHS:
            path = Path(folder) / f"legs-{length}.yaml"
            path.write_text(text.replace("d_max: 350 m", f"d_max: {length} m"))
            runs.append(simulate(path, count, 1))
    for length, run in zip(LEG_LENGTHS, runs, strict=True):
        what = f"d_max {length} m: {run.surfacings:.1f} legs"
        rows.append(Row(what, f"{duration(run.elapsed / count)} a trial"))
    for (few, before), (many, after) in pairwise(zip(LEG_LENGTHS, runs, strict=True)):
        slope = (after.elapsed - before.elapsed) / count / (after.surfacings - before.surfacings)
        rows.append(Row(f"a leg more, d_max {few} m to {many} m", f"{duration(slope)} a trial", asked="linear"))
    return Section(tuple(rows), PACKAGES, (f"Both transits of the mission together; {count} trials, 1 job.",))
