"""Run the transit under missionplan: ``python -m benchmarks.own_cases function|simulate CASES WORKERS``.

``function`` gives the blocks of `run_blocks` the same scalar function that monaco runs, with inputs from named
streams and outputs into streaming statistics; ``simulate`` runs the transit as a mission, with all that its report
needs. Prints JSON as `benchmarks.monaco_cases` does; the model itself of ``simulate`` is `transit`, on the same legs.
"""

import json
import sys
import tempfile
import time
from functools import reduce
from pathlib import Path

import numpy as np

from benchmarks.transit_trial import (
    D_MAX,
    DISTANCE,
    MAX_LEGS,
    MISSION,
    RADIUS,
    SIGMA,
    SPEED,
    SPEED_SD,
    SURFACING_TIME,
    transit_trial,
)
from missionplan.mission import load
from missionplan.montecarlo.fanout import run_blocks
from missionplan.montecarlo.statistics import RunningStatistic
from missionplan.montecarlo.streams import BLOCK, LegNormals, block_count, block_size, stream
from missionplan.phases.state import TrialState
from missionplan.phases.transit import transit
from missionplan.phases.transit_plan import TransitNormals, TransitPlan, VelocityError
from missionplan.studies.simulate import simulate

Item = tuple[int, int]


def function_block(item: Item) -> tuple[list[RunningStatistic], float]:
    """Run a block of trials of the scalar function; give the statistics of its outputs, and its time."""
    block, size = item
    speed = SPEED + SPEED_SD * stream(1, "ingress.speed", block).standard_normal(BLOCK)[:size]
    seeds = stream(1, "ingress.velocity_error", block).integers(2**63, size=BLOCK)[:size]
    started = time.perf_counter()
    found = [transit_trial(*inputs) for inputs in zip(speed.tolist(), seeds.tolist(), strict=True)]
    inside = time.perf_counter() - started
    return [RunningStatistic.of(np.array(values, dtype=float)) for values in zip(*found, strict=True)], inside


def run_function(cases: int, workers: int) -> dict[str, float]:
    """Run the scalar function in blocks."""
    items = [(block, block_size(cases, block)) for block in range(block_count(cases))]
    started = time.perf_counter()
    outputs, inside = zip(*run_blocks(function_block, items, jobs=workers), strict=True)
    duration, _ = reduce(lambda so_far, new: [a.merge(b) for a, b in zip(so_far, new, strict=True)], outputs)
    return {"wall": time.perf_counter() - started, "inside": sum(inside), "mean": duration.statistic().mean}


def run_model(cases: int) -> float:
    """Time the vectorised model of the transit alone, its legs' draws included [s]."""
    started = time.perf_counter()
    for block in range(block_count(cases)):
        size = block_size(cases, block)
        speed = SPEED + SPEED_SD * stream(1, "ingress.speed", block).standard_normal(BLOCK)[:size]
        plan = TransitPlan(
            goal=np.array([DISTANCE, 0.0]),
            speed=speed,
            arrival_radius=RADIUS,
            d_max=D_MAX,
            surfacing_time=SURFACING_TIME,
            velocity_error=VelocityError.isotropic(SIGMA),
            max_legs=MAX_LEGS,
        )
        legs = LegNormals(1, "ingress.velocity_error", block)
        transit(plan, TrialState.at(np.zeros(2), size), TransitNormals(legs))
    return time.perf_counter() - started


def run_simulate(cases: int, workers: int) -> dict[str, float]:
    """Run the mission."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "transit.yaml"
        path.write_text(MISSION)
        mission = load(path)
    run_model(cases)
    started = time.perf_counter()
    outcome = simulate(mission, trials=cases, jobs=workers)
    wall = time.perf_counter() - started
    return {"wall": wall, "inside": run_model(cases), "mean": outcome.phases[0].quantities["duration_s"].mean}


def main(what: str, cases: int, workers: int) -> None:
    """Run three times: the first run starts the workers and imports what is needed; the faster of the others counts."""
    run = {"function": run_function, "simulate": run_simulate}[what]
    runs = [run(cases, workers) for _ in range(3)]
    print(json.dumps(min(runs[1:], key=lambda found: found["wall"])))


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]))
