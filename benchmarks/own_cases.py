"""Run the transit under missionplan: ``python -m benchmarks.own_cases function|simulate|sweep CASES WORKERS``.

``function`` gives the blocks of `Workers` the same scalar function that monaco runs, with inputs from named
streams and outputs into streaming statistics; ``simulate`` runs the transit as a mission, with everything that its
report needs; ``sweep`` computes the cost of its 16 d_max, each trial of each being a case. Prints JSON as
`benchmarks.monaco_cases` does; the model of ``simulate`` and ``sweep`` is `transit`, on the same legs. The
sensitivity analysis at the end of ``simulate`` is timed separately: it runs once, on the first four blocks at most.
"""

import json
import sys
import time
from collections.abc import Mapping, Sequence
from functools import reduce
from importlib import import_module
from operator import itemgetter
from unittest.mock import patch

import numpy as np
import yaml

from benchmarks.transit_trial import (
    D_MAX,
    DISTANCE,
    MAX_LEGS,
    MISSION,
    RADIUS,
    RUNS,
    SIGMA,
    SPEED,
    SPEED_SD,
    SURFACING_TIME,
    transit_trial,
)
from missionplan.arrays import Array
from missionplan.mission import Mission
from missionplan.montecarlo.blocks import Workers
from missionplan.montecarlo.pool import process_pool
from missionplan.montecarlo.sensitivity import Influence, sensitivities
from missionplan.montecarlo.statistics import RunningStatistics
from missionplan.montecarlo.streams import BLOCK, LegNormals, block_count, block_size, stream
from missionplan.phases.hooks import TrialState
from missionplan.phases.transit import transit
from missionplan.phases.transit.plan import TransitNormals, TransitPlan, VelocityError
from missionplan.studies.leg_length.sweep_dmax import sweep_dmax
from missionplan.studies.simulation import outcome_builder as outcome
from missionplan.studies.simulation.simulate import simulate

Item = tuple[int, int]
SEED = 1
OUTPUTS: dict[str, type] = {"duration": float, "surfacings": int}


def function_block(item: Item) -> tuple[RunningStatistics, float]:
    """Run a block of trials of the scalar function; return its statistics and time."""
    block, size = item
    speed = SPEED + SPEED_SD * stream(SEED, "ingress.speed", block).standard_normal(size)
    first = (SEED << 32) + block * BLOCK
    speeds, seeds = speed.tolist(), range(first, first + size)
    started = time.perf_counter()
    found = list(map(transit_trial, speeds, seeds))
    inside = time.perf_counter() - started
    columns: dict[str, Array] = {
        name: np.fromiter(map(itemgetter(place), found), kind, size)
        for place, (name, kind) in enumerate(OUTPUTS.items())
    }
    return RunningStatistics.of(columns), inside


def run_function(cases: int, workers: int) -> dict[str, float]:
    """Run the scalar function in blocks."""
    items = [(block, block_size(cases, block)) for block in range(block_count(cases))]
    started = time.perf_counter()
    blocks, inside = zip(*Workers(jobs=workers).run(function_block, items), strict=True)
    found = {name: running.statistic() for name, running in reduce(RunningStatistics.merge, blocks).items()}
    return {"wall": time.perf_counter() - started, "inside": sum(inside), "mean": found["duration"].mean}


def run_model(trials: int, d_max: Sequence[float]) -> float:
    """Time the vectorised model of the transit alone, its legs' draws included [s]."""
    started = time.perf_counter()
    for block in range(block_count(trials)):
        size = block_size(trials, block)
        speed = SPEED + SPEED_SD * stream(SEED, "ingress.speed", block).standard_normal(BLOCK)[:size]
        legs = LegNormals(SEED, "ingress.velocity_error", block)
        for length in d_max:
            plan = TransitPlan(
                goal=np.array([DISTANCE, 0.0]),
                speed=speed,
                arrival_radius=RADIUS,
                d_max=length,
                surfacing_time=SURFACING_TIME,
                velocity_error=VelocityError.isotropic(SIGMA),
                max_legs=MAX_LEGS,
            )
            transit(plan, TrialState.at(np.zeros(2), size), TransitNormals(legs))
    return time.perf_counter() - started


def read_mission() -> Mission:
    """Return the transit as a mission."""
    return Mission.from_data(yaml.safe_load(MISSION))


def run_simulate(cases: int, workers: int) -> dict[str, float]:
    """Run the mission."""
    mission, analyses = read_mission(), []

    def analysed(*given: Mapping[str, Array]) -> tuple[Influence, ...]:
        started = time.perf_counter()
        found = sensitivities(*given)
        analyses.append(time.perf_counter() - started)
        return found

    with patch.object(outcome, "sensitivities", analysed):
        started = time.perf_counter()
        result = simulate(mission, trials=cases, jobs=workers)
        wall = time.perf_counter() - started
    analysis = sum(analyses)
    mean = result.phases[0].quantities["duration_s"].mean
    outputs = sum(bool(found.count) for phase in (*result.phases, result.total) for found in phase.quantities.values())
    inside = run_model(cases, (D_MAX,)) + analysis
    return {"wall": wall, "inside": inside, "mean": mean, "analysis": analysis, "outputs": outputs}


def run_sweep(cases: int, workers: int) -> dict[str, float]:
    """Sweep the mission's d_max; the sweep adds a single leg of the whole distance."""
    mission = read_mission()
    lengths = [*mission.sweep.d_max_values(DISTANCE), DISTANCE]
    trials = cases // len(lengths)
    started = time.perf_counter()
    found = sweep_dmax(mission, trials=trials, jobs=workers, method="monte-carlo")
    wall = time.perf_counter() - started
    share = cases / (trials * len(lengths))
    inside = run_model(trials, lengths)
    return {"wall": wall * share, "inside": inside * share, "mean": found.curves[0].one_leg.cost}


def main(what: str, cases: int, workers: int) -> None:
    """Run once to import and start the workers, then `RUNS` times; the minimum of each time counts.

    The scalar function is timed where it runs, the vectorised model in separate runs.
    """
    run = {"function": run_function, "simulate": run_simulate, "sweep": run_sweep}[what]
    if workers > 1:
        process_pool(workers - 1).submit(import_module, "missionplan.montecarlo.statistics").result()
    run(cases, workers)
    runs = [run(cases, workers) for _ in range(RUNS[workers])]
    least = {key: min(found[key] for found in runs) for key in runs[0]}
    if what == "function":
        least["overhead"] = min(found["wall"] - found["inside"] for found in runs)
    print(json.dumps(least))


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]))
