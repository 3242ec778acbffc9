"""The sweep of `missions/fig8.yaml` compared with a hand-written loop, in Python and in C.

The C loop is compiled at run time with -O3 -march=native and draws its own normals for every leg (xoshiro256+ and
the polar method). Times are per leg and trial, on one core; then 2 jobs against 1 with workers warm.
"""

import ctypes
import math
import random
import shutil
import subprocess
import tempfile
from collections.abc import Callable
from importlib import import_module
from pathlib import Path

import numpy as np

from benchmarks.common import MISSIONS, Options, Row, Section, alternate, duration
from missionplan.mission import load
from missionplan.montecarlo.pool import process_pool
from missionplan.studies.leg_length.sweep_dmax import sweep_dmax
from missionplan.studies.leg_length.sweep_result import Sweep

TRIALS, PYTHON_TRIALS = 20_000, 300
DISTANCE, SPEED, RADIUS, SURFACING_TIME, MAX_LEGS = 7408.0, 1.25, 50.0, 90.0, 400
SIGMAS = np.array([0.015, 0.035, 0.055])
D_MAX = np.linspace(0.02, 1.0, 99) * DISTANCE

CLoop = Callable[[int], tuple[np.ndarray, int]]


def python_loop(d_max: float, sigma: float, trials: int) -> tuple[float, int]:
    """Run one cell as a user would write it; return the mean cost and the number of legs."""
    draw = random.Random(1).gauss
    legs, total = 0, 0.0
    for _ in range(trials):
        x, y, run, surfacings = -DISTANCE, 0.0, 0.0, 0
        left = DISTANCE
        while left >= RADIUS and surfacings < MAX_LEGS:
            length = min(left, d_max)
            duration = length / SPEED
            x += -x / left * length + draw(0.0, sigma) * duration
            y += -y / left * length + draw(0.0, sigma) * duration
            left = math.hypot(x, y)
            run += length
            surfacings += 1
        legs += surfacings
        total += run / SPEED + SURFACING_TIME * (surfacings - 1)
    return total / trials / (DISTANCE / SPEED) - 1.0, legs


def compiled_loop(folder: str) -> CLoop:
    """Compile the C loop and return it as a function of the trials."""
    library = Path(folder) / "sweep_loop.so"
    source = Path(__file__).with_name("sweep_loop.c")
    subprocess.run(["cc", "-O3", "-march=native", "-shared", "-fPIC", "-o", library, source, "-lm"], check=True)
    sweep = ctypes.CDLL(str(library)).sweep
    pointer = np.ctypeslib.ndpointer(dtype=np.float64, flags="C_CONTIGUOUS")
    real, whole = ctypes.c_double, ctypes.c_int
    sweep.argtypes = [pointer, whole, pointer, whole, whole, real, real, real, real, whole, ctypes.c_uint64, pointer]
    sweep.restype = ctypes.c_int64

    def run(trials: int) -> tuple[np.ndarray, int]:
        cost = np.empty((len(SIGMAS), len(D_MAX)))
        legs = sweep(
            *(D_MAX, len(D_MAX), SIGMAS, len(SIGMAS), trials, DISTANCE, SPEED, RADIUS, SURFACING_TIME, MAX_LEGS, 1),
            cost,
        )
        return cost, legs

    return run


def compare(options: Options) -> Section:
    """Time the sweep, both loops, and the sweep on two jobs."""
    mission = load(MISSIONS / "fig8.yaml")
    trials = TRIALS // options.shrink

    def sweep(jobs: int) -> Sweep:
        return sweep_dmax(mission, trials=trials, jobs=jobs, method="monte-carlo")

    ours = sweep(1)
    process_pool(1).submit(import_module, sweep_dmax.__module__).result()  # started, and warm
    legs = trials * sum(point.surfacings for curve in ours.curves for point in curve.points)
    cells = [(float(d_max), float(sigma)) for d_max in D_MAX[9::15] for sigma in SIGMAS]
    python_legs = sum(python_loop(*cell, PYTHON_TRIALS)[1] for cell in cells)
    sides: dict[str, Callable[[], object]] = {
        "sweep": lambda: sweep(1),
        "python": lambda: [python_loop(*cell, PYTHON_TRIALS) for cell in cells],
        "two jobs": lambda: sweep(2),
    }
    with tempfile.TemporaryDirectory() as folder:
        c_legs, note = 0, "No C compiler here: the C loop was not run."
        if shutil.which("cc"):
            c_loop = compiled_loop(folder)
            c_cost, c_legs = c_loop(trials)
            sides["c"] = lambda: c_loop(trials)
            note = f"Costs of sweep and C loop differ by {_apart(ours, c_cost):.1f} standard errors at most."
        times = alternate(sides, options.repeats)
    each, python_each = times["sweep"] / legs, times["python"] / python_legs
    what = f"{len(D_MAX)} d_max × {len(SIGMAS)} σ_v × {trials} trials, per leg and trial: "
    ratio, gain = python_each / each, times["sweep"] / times["two jobs"]
    rows = [
        Row(
            what + "plain Python loop",
            duration(each),
            duration(python_each),
            f"{ratio:.0f} × faster",
            "≥ 30",
            ratio >= 30,
        ),
        Row(
            "2 jobs, workers warm: 1 job",
            duration(times["two jobs"]),
            duration(times["sweep"]),
            f"{gain:.2f} × faster",
            "≥ 1.7",
            gain >= 1.7,
        ),
    ]
    if c_legs:
        share = each / (times["c"] / c_legs)
        row = Row(
            what + "C loop",
            duration(each),
            duration(times["c"] / c_legs),
            f"{share:.2f} × its time",
            "≤ 1.5",
            share <= 1.5,
        )
        rows.insert(1, row)
    return Section(tuple(rows), ("numpy", "joblib", "cc"), (note,))


def _apart(ours: Sweep, theirs: np.ndarray) -> float:
    """Largest difference of the mean costs, in standard errors of the difference."""
    return max(
        abs(point.cost - float(cost)) / max(math.sqrt(2.0) * point.standard_error, 1e-6)
        for curve, row in zip(ours.curves, theirs, strict=True)
        for point, cost in zip(curve.points, row, strict=True)
    )
