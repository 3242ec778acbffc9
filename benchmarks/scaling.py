"""Scaling of `missionplan simulate`: with trials and jobs as a command, from start to report; with legs as a study."""

import copy
import json
import tempfile
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

from benchmarks.common import MISSIONS, Options, Row, Section, duration, grouped, megabytes, python, run_command
from missionplan.mission import Mission, load
from missionplan.studies.simulation.simulate import simulate as simulate_study

MISSION = "chesapeake.yaml"
PACKAGES = ("numpy", "scipy", "joblib")
SIZES = {1: (1_000, 10_000, 100_000), 2: (1_000, 10_000, 100_000, 1_000_000)}
LONG = 10_000_000
ASKED = {100_000: 15.0, 1_000_000: 120.0}
"""Longest time allowed, by trials, on two jobs [s]."""
MOST_MEMORY = 1e9
LINEAR = 1.25
"""Largest growth of the time per further trial and of the memory from one size to the next: linear, flat."""
LEG_LENGTHS = (400, 200, 100, 50)
"""Values of d_max [m]; the distance of the mission's transits is a multiple of each."""
LEG_TRIALS = 20_000
LEG_ROUNDS = 3
"""Rounds per repeat: a leg is a small part of a trial, less than the machine's variation."""
REQUIREMENT_NOT_MET = 3
"""Exit status that is not a failure of the run."""


@dataclass(frozen=True)
class Simulated:
    """A run of the command: start to report, the simulation in it [s], peak memory [bytes]."""

    wall: float
    elapsed: float
    peak: int


def simulate(mission: Path, trials: int, jobs: int) -> Simulated:
    """Run the command in a folder that is removed afterwards."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "report"
        words = python("missionplan", "simulate", mission, "--trials", str(trials), "--jobs", str(jobs))
        run = run_command([*words, "--quiet", "--out", out], accept=(0, REQUIREMENT_NOT_MET))
        summary = json.loads((out / "summary.json").read_text())
    return Simulated(run.wall, summary["elapsed_s"], run.peak)


def trials(options: Options) -> Section:
    """Compare numbers of trials and jobs."""
    sizes = {jobs: list(counts) + [LONG] * (options.long and jobs == 2) for jobs, counts in SIZES.items()}
    found = {
        (jobs, count // options.shrink): simulate(MISSIONS / MISSION, count // options.shrink, jobs)
        for count in sorted({count for counts in sizes.values() for count in counts})
        for jobs in sizes
        if count in sizes[jobs]
    }
    rows = [_run_row(jobs, count, run) for (jobs, count), run in found.items()]
    rows += _growth_rows([(count, run) for (jobs, count), run in found.items() if jobs == 2])
    most = max(count for jobs, count in found if jobs == 1)
    gain = found[1, most].elapsed / found[2, most].elapsed
    rows.append(Row(f"2 jobs: 1 job, {grouped(most)} trials, start of the workers included", f"{gain:.2f} × faster"))
    return Section(tuple(rows), PACKAGES)


def _run_row(jobs: int, count: int, run: Simulated) -> Row:
    spent = f"{duration(run.wall)}, {duration(run.elapsed / count)} per trial, {megabytes(run.peak)}"
    what = f"{grouped(count)} trials, {jobs} job{'s' * (jobs > 1)}"
    if jobs == 1 or count not in ASKED:
        return Row(what, spent)
    most = ASKED[count]
    return Row(what, spent, target=f"≤ {most:.0f} s, < 1 GB", met=run.wall <= most and run.peak < MOST_MEMORY)


def _growth_rows(runs: list[tuple[int, Simulated]]) -> list[Row]:
    """Time per further trial from one size to the next; targets from the second row on: linear, flat memory."""
    rows: list[Row] = []
    last = 0.0
    for (few, before), (many, after) in pairwise(runs):
        slope, memory = (after.elapsed - before.elapsed) / (many - few), after.peak / before.peak
        text = f"{duration(slope)} per further trial, {memory:.2f} × the memory"
        met = slope <= LINEAR * last and memory <= LINEAR if last else None
        target = "linear, flat" if last else ""
        rows.append(Row(f"from {grouped(few)} to {grouped(many)} trials, 2 jobs", text, target=target, met=met))
        last = slope
    return rows


def legs(options: Options) -> Section:
    """Shorter legs over the same distance: only the mission's two transits, in this process."""
    count = LEG_TRIALS // options.shrink
    missions = {length: _transits(length) for length in LEG_LENGTHS}
    spent: dict[int, list[float]] = {length: [] for length in LEG_LENGTHS}
    number: dict[int, float] = {}
    for _ in range(LEG_ROUNDS * options.repeats):
        for length, mission in missions.items():
            found = simulate_study(mission, trials=count)
            spent[length].append(found.provenance.elapsed_s / count)
            number[length] = sum(phase.quantities["surfacings"].mean for phase in found.phases)
    cost = {length: min(times) for length, times in spent.items()}
    rows = [
        Row(f"d_max {length} m: {number[length]:.1f} legs", f"{duration(cost[length])} per trial") for length in cost
    ]
    for long, short in pairwise(LEG_LENGTHS):
        slope = (cost[short] - cost[long]) / (number[short] - number[long])
        rows.append(Row(f"per further leg, from d_max {long} m to {short} m", f"{slope * 1e9:.0f} ns per trial"))
    note = f"{grouped(count)} trials, 1 job; the minimum of {LEG_ROUNDS * options.repeats} runs, in alternation."
    return Section(tuple(rows), PACKAGES, (note,))


def _transits(length: int) -> Mission:
    """The mission with only its transits, and with other legs."""
    data = copy.deepcopy(dict(load(MISSIONS / MISSION).raw))
    data["phases"] = [phase for phase in data["phases"] if "transit" in phase]
    for phase in data["phases"]:
        phase["transit"]["d_max"] = f"{length} m"
    del data["requirements"]
    return Mission.from_data(data)
