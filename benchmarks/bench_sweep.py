"""Time of the sweep of `missions/fig8.yaml` beside its peers, in one run, as ratios per leg and trial.

Peers: (a) the plain Python loop over trials that a user would write; (b) a C loop compiled on the spot with
-O3 -march=native, drawing its own normals for every leg (xoshiro256+ and the polar method). Each is run until its
number of legs is large enough to be timed, and the best of a few repeats counts, on one core; then the sweep's
Monte Carlo on 2 jobs against 1 with workers warm.

    python benchmarks/bench_sweep.py [--trials 20000] [--repeats 3]
"""

import argparse
import ctypes
import math
import os
import random
import subprocess
import tempfile
import time
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np

from missionplan.mission import load
from missionplan.studies.sweep_dmax import sweep_dmax

HERE = Path(__file__).parent
DISTANCE, SPEED, RADIUS, SURFACING_TIME, MAX_LEGS = 7408.0, 1.25, 50.0, 90.0, 400
SIGMAS = np.array([0.015, 0.035, 0.055])
D_MAX = np.linspace(0.02, 1.0, 99) * DISTANCE


def python_loop(d_max, sigma, trials):
    """Run one cell as a user would write it; give the mean cost and the legs run."""
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


def compiled_loop(folder):
    """Compile the C loop and give it as a function of the trials."""
    library = Path(folder) / "sweep_loop.so"
    source = HERE / "sweep_loop.c"
    subprocess.run(["cc", "-O3", "-march=native", "-shared", "-fPIC", "-o", library, source, "-lm"], check=True)
    sweep = ctypes.CDLL(str(library)).sweep
    pointer = np.ctypeslib.ndpointer(dtype=np.float64, flags="C_CONTIGUOUS")
    real, whole = ctypes.c_double, ctypes.c_int
    sweep.argtypes = [pointer, whole, pointer, whole, whole, real, real, real, real, whole, ctypes.c_uint64, pointer]
    sweep.restype = ctypes.c_int64

    def run(trials):
        cost = np.empty((len(SIGMAS), len(D_MAX)))
        legs = sweep(
            *(D_MAX, len(D_MAX), SIGMAS, len(SIGMAS), trials, DISTANCE, SPEED, RADIUS, SURFACING_TIME, MAX_LEGS, 1),
            cost,
        )
        return cost, legs

    return run


def best_time(function, repeats):
    """Give the shortest time of a few repeats [s], and the last result."""
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        result = function()
        times.append(time.perf_counter() - start)
    return min(times), result


def main():
    """Run and print the ratios."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--trials", type=int, default=20_000)
    parser.add_argument("--repeats", type=int, default=3)
    options = parser.parse_args()
    mission = load(HERE.parent / "missions" / "fig8.yaml")

    def sweep(jobs):
        return sweep_dmax(mission, trials=options.trials, jobs=jobs, method="monte-carlo")

    with tempfile.TemporaryDirectory() as folder:
        c_loop = compiled_loop(folder)
        c_time, (c_cost, c_legs) = best_time(lambda: c_loop(options.trials), options.repeats)
    our_time, ours = best_time(lambda: sweep(1), options.repeats)
    our_legs = options.trials * sum(point.surfacings for curve in ours.curves for point in curve.points)
    few = [(float(d_max), float(sigma)) for d_max in D_MAX[9::15] for sigma in SIGMAS]
    python_time, cells = best_time(lambda: [python_loop(*cell, 300) for cell in few], options.repeats)
    python_legs = sum(legs for _, legs in cells)
    sweep(2)
    two_jobs, _ = best_time(lambda: sweep(2), options.repeats)

    apart = max(
        abs(point.cost - cost) / max(math.sqrt(2.0) * point.standard_error, 1e-6)
        for curve, row in zip(ours.curves, c_cost, strict=True)
        for point, cost in zip(curve.points, row, strict=True)
    )
    each = {"sweep": our_time / our_legs, "C loop": c_time / c_legs, "Python loop": python_time / python_legs}
    print(f"{len(D_MAX)} d_max × {len(SIGMAS)} sigma × {options.trials} trials; one core; best of {options.repeats}")
    for name, seconds in each.items():
        print(f"  {name:12} {1e9 * seconds:9.1f} ns per leg and trial")
    print(f"  sweep: {each['Python loop'] / each['sweep']:.1f} × faster than the Python loop (asked: 30)")
    print(f"  sweep: {each['sweep'] / each['C loop']:.2f} × the time of the C loop (asked: 1.5 at most)")
    print(f"  2 jobs: {our_time / two_jobs:.2f} × faster than 1, workers warm (asked: 1.7)")
    print(f"  costs of sweep and C loop differ by {apart:.1f} standard errors at most")


if __name__ == "__main__":
    main()
