"""Whole commands, from the start of the process to its end: sweep, help, diagnoses; and the dynamic programme."""

import shutil
import tempfile
from collections.abc import Sequence
from pathlib import Path

from benchmarks.common import MISSIONS, Options, Row, Run, Section, alternate, duration, python, run_command
from missionplan.phases.transit.policy import best_legs
from tests.hidden_effects.cases import draw_case

SWEEP_TRIALS = 20_000
HARDEST_LEGS = {"distance": 14816.0, "speed": 1.2, "arrival_radius": 10.0, "sigma": 0.035, "surfacing_time": 90.0}
"""The slowest of the four cases in docs/adaptive-legs.md [m, m/s, m, m/s, s]."""
CASES = {
    "100 legs": ("transit", {"pair": (912, 916, 941), "single": (946,), "control": (914,)}, 4.0),
    "four dives": ("descent", {"pair": (905, 906), "single": (905, 908), "control": (903,)}, 6.0),
    "300 legs": ("transit", {"single": (915, 912), "control": (942,)}, 10.0),
}
"""Kind and seeds of records with two effects, with one and with none, and the time asked for [s]."""


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


def studies(options: Options) -> Section:
    """Time an exploration in a field of the current, and the plan of legs of a vehicle that barely makes way."""
    explored, planned = [], []
    trials = str(2000 // options.shrink)
    chesapeake = (MISSIONS / "chesapeake.yaml").read_text(encoding="utf-8")
    slow = chesapeake.replace("speed: 1.5 m/s", "speed: 0.45 m/s")
    for _ in range(options.repeats):
        with tempfile.TemporaryDirectory() as folder:
            end = ("--jobs", "2", "--quiet", "--out", Path(folder) / "report")
            starts = ("--vary", "start=04:00:12:10:10 min", "--trials", trials)
            explore = python("missionplan", "explore", MISSIONS / "estuary.yaml", *starts, *end)
            explored.append(run_command(explore))
        with tempfile.TemporaryDirectory() as folder:
            mission = Path(folder) / "slow.yaml"
            mission.write_text(slow, encoding="utf-8")
            shutil.copytree(MISSIONS / "vehicles", Path(folder) / "vehicles")
            end = ("--jobs", "2", "--quiet", "--out", Path(folder) / "report")
            planned.append(run_command(python("missionplan", "plan-legs", mission, *end), accept=(0, 3)))
    rows = (
        _row(f"`explore`, 50 starts of the estuary × {trials} trials, start to report, 2 jobs", explored, 10.0),
        _row("`plan-legs`, chesapeake at 0.45 m/s, start to report, 2 jobs", planned, 30.0),
    )
    return Section(rows, ("numpy", "scipy", "joblib", "matplotlib"))


def diagnoses(options: Options) -> Section:
    """Time diagnoses of made-up records of three kinds, from start to report with the plan."""
    run_command(python("compileall", "-q", "missionplan"))
    rows = []
    for what, (kind, seeds, most) in CASES.items():
        cases = [(seed, kind, scenario) for scenario, own in seeds.items() for seed in own]
        rows.append(_diagnosis(what, cases[: 1 if options.shrink > 1 else None], most))
    note = "Two jobs, the median over the records; CPU time of both processes; modules compiled before."
    return Section(tuple(rows), ("numpy", "scipy", "pandas", "matplotlib"), (note,))


def _diagnosis(what: str, cases: Sequence[tuple[int, str, str]], most: float) -> Row:
    runs = []
    for arguments in cases:
        with tempfile.TemporaryDirectory() as folder:
            mission, data = draw_case(*arguments).write(Path(folder) / "case", Path(folder) / "truth")
            words = ("missionplan", "diagnose", mission, data, "--jobs", "2", "--quiet")
            runs.append(run_command([*python(*words), "--out", Path(folder) / "report"]))
    return _row(f"`diagnose`, {what}, start to report", runs, most)


def _row(what: str, runs: list[Run], most: float) -> Row:
    """Row for the run of median wall time."""
    run = sorted(runs, key=lambda run: run.wall)[len(runs) // 2]
    spent = f"{duration(run.wall)} ({duration(run.cpu)} of CPU)"
    return Row(what, spent, target=f"≤ {most:g} s", met=run.wall <= most)
