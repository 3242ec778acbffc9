"""`diagnose` from the start of the process to its report, on made-up data of the study of hidden effects."""

import tempfile
from pathlib import Path

from benchmarks.common import Options, Row, Section, duration, python, run_command
from tests.hidden_effects.cases import draw_case

CASES = {
    "100 legs": (((912, "transit", "pair"), (916, "transit", "pair"), (941, "transit", "pair")), 4.0),
    "four dives": (((905, "descent", "single"), (905, "descent", "pair")), 6.0),
    "300 legs": (((915, "transit", "single"), (942, "transit", "control"), (912, "transit", "single")), 10.0),
}
"""Arguments of the cases, and the time asked for [s]."""


def compare(options: Options) -> Section:
    """Time diagnoses of the three kinds of record, plan and page included."""
    rows = tuple(_row(what, cases[: 1 if options.shrink > 1 else None], most) for what, (cases, most) in CASES.items())
    note = (
        "Two jobs, the median over the records; CPU time of both processes."
    )
    return Section(rows, ("numpy", "scipy", "pandas", "matplotlib"), (note,))


def _row(what: str, cases: tuple[tuple[int, str, str], ...], most: float) -> Row:
    runs = []
    for arguments in cases:
        with tempfile.TemporaryDirectory() as folder:
            mission, data = draw_case(*arguments).write(Path(folder) / "case", Path(folder) / "truth")
            words = (
                "missionplan",
                "diagnose",
                mission,
                data,
                "--jobs",
                "2",
                "--quiet",
                "--out",
                Path(folder) / "report",
            )
            runs.append(run_command(python(*words)))
    run = sorted(runs, key=lambda run: run.wall)[len(runs) // 2]
    spent = f"{duration(run.wall)} ({duration(run.cpu)} of CPU)"
    return Row(f"`diagnose`, {what}, start to report", spent, target=f"≤ {most:g} s", met=run.wall <= most)
