"""Whole commands, from the start of the process to its end; and the dynamic programme of `plan-legs`."""

import tempfile
from pathlib import Path

from benchmarks.common import MISSIONS, Options, Row, Run, Section, alternate, duration, python, run_command
from missionplan.phases.transit.analytic.policy import best_legs

SWEEP_TRIALS = 20_000
HARDEST_LEGS = {"distance": 14816.0, "speed": 1.2, "arrival_radius": 10.0, "sigma": 0.035, "surfacing_time": 90.0}
"""The slowest of the four cases in docs/adaptive-legs.md [m, m/s, m, m/s, s]."""


def compare(options: Options) -> Section:
    """Time a sweep from start to report, the help, and the dynamic programme."""
    sweeps, helps = [], []
    trials = SWEEP_TRIALS // options.shrink
    for _ in range(options.repeats):
        with tempfile.TemporaryDirectory() as folder:
            words = ("missionplan", "sweep-dmax", MISSIONS / "fig8.yaml", "--trials", str(trials), "--jobs", "2")
            sweeps.append(run_command([*python(*words), "--quiet", "--out", Path(folder) / "report"]))
        helps.append(run_command(python("missionplan", "--help")))
    legs = alternate({"legs": lambda: best_legs(**HARDEST_LEGS)}, options.repeats)["legs"]
    what = "best legs by dynamic programming, 14.8 km, arrival radius 10 m"
    rows = (
        _row("`missionplan sweep-dmax missions/fig8.yaml`, start to report, 2 jobs", sweeps, 10.0),
        _row("`missionplan --help`", helps, 0.5),
        Row(what, duration(legs), target="≤ 3 s", met=legs <= 3.0),
    )
    return Section(rows, ("numpy", "joblib", "typer", "matplotlib"))


def _row(what: str, runs: list[Run], most: float) -> Row:
    """Row for the run of median wall time."""
    run = sorted(runs, key=lambda run: run.wall)[len(runs) // 2]
    spent = f"{duration(run.wall)} ({duration(run.cpu)} of CPU)"
    return Row(what, spent, target=f"≤ {most:g} s", met=run.wall <= most)
