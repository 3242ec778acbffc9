"""Whole commands, from the start of the process to its end."""

import statistics
import tempfile
from pathlib import Path

from benchmarks.common import MISSIONS, Options, Row, Section, duration, python, run_command

SWEEP_TRIALS = 20_000


def compare(options: Options) -> Section:
    """Time a sweep from start to report, and the help."""
    sweeps, helps = [], []
    trials = SWEEP_TRIALS // options.shrink
    for _ in range(options.repeats):
        with tempfile.TemporaryDirectory() as folder:
            words = ("missionplan", "sweep-dmax", MISSIONS / "fig8.yaml", "--trials", str(trials), "--jobs", "2")
            sweeps.append(run_command([*python(*words), "--quiet", "--out", Path(folder) / "report"]).wall)
        helps.append(run_command(python("missionplan", "--help")).wall)
    sweep, help_ = statistics.median(sweeps), statistics.median(helps)
    rows = (
        Row(
            "`missionplan sweep-dmax missions/fig8.yaml`, start to report, 2 jobs",
            duration(sweep),
            "",
            "",
            "≤ 10 s",
            sweep <= 10.0,
        ),
        Row("`missionplan --help`", duration(help_), "", "", "≤ 0.5 s", help_ <= 0.5),
    )
    return Section(rows, ("numpy", "joblib", "typer", "matplotlib"))
