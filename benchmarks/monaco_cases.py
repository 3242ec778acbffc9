"""Run `transit_trial` under monaco: ``python -m benchmarks.monaco_cases CASES WORKERS``, in monaco's environment.

Prints JSON: wall time [s] of a run with the workers warm, what of it was not spent in the function itself (one worker
only) [s], mean duration of the transit [s].
"""

import json
import statistics
import sys
import time

import monaco  # type: ignore[import-not-found]
from scipy.stats import norm

from benchmarks.transit_trial import SPEED, SPEED_SD, transit_trial

inside = 0.0


def preprocess(case: monaco.Case) -> tuple[float, int]:
    """Inputs of a case: the speed drawn, and the case's own seed for the legs."""
    return case.invals["speed"].val, case.seed


def run(speed: float, seed: int) -> tuple[float, int]:
    """Run the function, and note its time."""
    global inside
    started = time.perf_counter()
    result = transit_trial(speed, seed)
    inside += time.perf_counter() - started
    return result


def postprocess(case: monaco.Case, duration: float, surfacings: int) -> None:
    """Outputs of a case."""
    case.addOutVal("duration", duration)
    case.addOutVal("surfacings", surfacings)


def main(cases: int, workers: int) -> None:
    """Run three times: the first run starts the workers; of the others the least of each time counts."""
    global inside
    functions = {"preprocess": preprocess, "run": run, "postprocess": postprocess}
    settings = {"seed": 1, "singlethreaded": workers == 1, "ncores": workers, "verbose": False, "debug": True}
    sim = monaco.Sim("transit", cases, functions, **settings)
    sim.addInVar("speed", norm, {"loc": SPEED, "scale": SPEED_SD})
    sim.runSim()
    runs = []
    for _ in range(2):
        inside = 0.0
        started = time.perf_counter()
        sim.runSim()
        runs.append((time.perf_counter() - started, inside))
    found = {
        "wall": min(wall for wall, _ in runs),
        "overhead": min(wall - function for wall, function in runs),
        "mean": statistics.fmean(sim.outvars["duration"].nums),
    }
    print(json.dumps(found))


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]))
