"""Run `transit_trial` under monaco: ``python -m benchmarks.monaco_cases CASES WORKERS``, in monaco's environment.

Prints JSON: wall time [s] of a run with the workers warm, the part of it outside the function itself (one worker
only) [s], mean duration of the transit [s]; with a third argument ``analysis`` also the time [s] of a sensitivity
analysis of both outputs, which is not part of the run.
"""

import json
import statistics
import sys
import time

import monaco  # type: ignore[import-not-found]
import numpy as np
from scipy.stats import norm

from benchmarks.transit_trial import RUNS, SPEED, SPEED_SD, transit_trial

inside = 0.0


def preprocess(case: monaco.Case) -> tuple[float, int]:
    """Inputs of a case: the speed drawn, and the case's own seed for the legs."""
    return case.invals["speed"].val, case.seed


def run(speed: float, seed: int) -> tuple[float, int]:
    """Run and time the function."""
    global inside
    started = time.perf_counter()
    result = transit_trial(speed, seed)
    inside += time.perf_counter() - started
    return result


def postprocess(case: monaco.Case, duration: float, surfacings: int) -> None:
    """Outputs of a case."""
    case.addOutVal("duration", duration)
    case.addOutVal("surfacings", surfacings)


def run_all(sim: monaco.Sim) -> None:
    """Run all cases and compute the statistics that missionplan computes: no confidence intervals."""
    sim.runSim()
    for output in sim.outvars.values():
        output.addVarStat("mean")
        output.addVarStat(np.std)
        output.addVarStat("percentile", {"p": [0.05, 0.5, 0.95]})


def main(cases: int, workers: int, *, analyse: bool) -> None:
    """Run `RUNS` times after a first run that starts the workers; the minimum of each time counts."""
    global inside
    functions = {"preprocess": preprocess, "run": run, "postprocess": postprocess}
    settings = {"seed": 1, "singlethreaded": workers == 1, "ncores": workers, "verbose": False, "debug": True}
    sim = monaco.Sim("transit", cases, functions, **settings)
    sim.addInVar("speed", norm, {"loc": SPEED, "scale": SPEED_SD})
    run_all(sim)
    runs = []
    for _ in range(RUNS[workers]):
        inside = 0.0
        started = time.perf_counter()
        run_all(sim)
        runs.append((time.perf_counter() - started, inside))
    found = {
        "wall": min(wall for wall, _ in runs),
        "overhead": min(wall - function for wall, function in runs),
        "mean": statistics.fmean(sim.outvars["duration"].nums),
    }
    if analyse:
        started = time.perf_counter()
        sim.calcSensitivities()
        found["analysis"] = time.perf_counter() - started
    print(json.dumps(found))


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]), analyse="analysis" in sys.argv[3:])
