"""Whole commands, from the start of the process to its end."""

import tempfile
from pathlib import Path

from benchmarks.common import MISSIONS, Options, Row, Run, Section, duration, python, run_command

SWEEP_TRIALS = 20_000


def compare(options: Options) -> Section:
    """Time a sweep from start to report, and the help."""
    sweeps, helps = [], []
    trials = SWEEP_TRIALS // options.shrink
    for _ in range(options.repeats):
        with tempfile.TemporaryDirectory() as folder:
            words = ("missionplan", "sweep-dmax", MISSIONS / "fig8.yaml", "--trials", str(trials), "--jobs", "2")
            sweeps.append(run_command([*python(*words), "--quiet", "--out", Path(folder) / "report"]))
        helps.append(run_command(python("missionplan", "--help")))
    rows = (
        _row("`missionplan sweep-dmax missions/fig8.yaml`, start to report, 2 jobs", sweeps, 10.0),
        _row("`missionplan --help`", helps, 0.5),
    )
    return Section(rows, ("numpy", "joblib", "typer", "matplotlib"))


def _row(what: str, runs: list[Run], most: float) -> Row:
    """Line of the run of median wall time."""
    run = sorted(runs, key=lambda run: run.wall)[len(runs) // 2]
    spent = f"{duration(run.wall)} ({duration(run.cpu)} of CPU)"
    return Row(what, spent, asked=f"≤ {most:g} s", met=run.wall <= most)
