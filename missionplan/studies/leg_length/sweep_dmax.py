"""What maximum leg length? The cost of each d_max for each velocity error (Briggs et al., section IV.B, Fig. 8)."""

import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from missionplan.errors import InputError, Problem
from missionplan.mission import Mission
from missionplan.montecarlo.parallel_blocks import Backend, Progress, run_blocks
from missionplan.montecarlo.statistics import Probability, wilson
from missionplan.montecarlo.streams import block_count, block_size
from missionplan.phases.transit.analytic.expectation import TransitExpectation
from missionplan.results.base import Provenance
from missionplan.results.sweep import Sweep, SweepCurve, SweepPoint
from missionplan.studies.leg_length.sweep_cells import CellTotals, run_cells
from missionplan.studies.leg_length.sweep_scenario import SweepScenario

Method = Literal["both", "analytic", "monte-carlo"]
Analytic = Sequence[TransitExpectation]


def sweep_dmax(
    mission: Mission,
    *,
    trials: int | None = None,
    seed: int | None = None,
    jobs: int = 1,
    backend: Backend = "loky",
    scheduler: str | None = None,
    method: Method | None = None,
    progress: Progress | None = None,
) -> Sweep:
    """Find the cost of every d_max of the mission's `sweep` section for every velocity error.

    Parameters
    ----------
    mission : Mission
    trials, seed : int, optional
        Default: the mission's.
    jobs, backend, scheduler, progress
        See `run_blocks`.
    method : {'both', 'analytic', 'monte-carlo'}, optional
        Default: both where the analytic form applies, else Monte Carlo.

    Raises
    ------
    InputError
        When the mission has no transit, the vehicle cannot stem its mean drift, or the analytic form is asked for
        where it does not apply.
    """
    started = time.perf_counter()
    scenario = SweepScenario.of(mission)
    chosen = _method(scenario, method)
    trials = 0 if chosen == "analytic" else trials or mission.monte_carlo.trials
    seed = mission.monte_carlo.seed if seed is None else seed
    curves = range(len(scenario.sigmas))
    analytic = {index: scenario.analytic(index) for index in curves} if chosen != "monte-carlo" else {}
    sampled: dict[int, CellTotals] = {}
    # the largest sigma, as a rule the last, takes longest: short items come last, for workers wait for the last one
    items = [(index, block) for block in range(block_count(trials)) for index in reversed(curves)]
    results = run_blocks(
        SweepTask(scenario, trials, seed), items, jobs=jobs, backend=backend, scheduler=scheduler, progress=progress
    )
    for (index, _), totals in zip(items, results, strict=True):
        sampled[index] = sampled[index].merge(totals) if index in sampled else totals
    provenance = Provenance(
        command="sweep-dmax",
        mission=mission.name,
        file=mission.file,
        seed=seed,
        trials=trials,
        options={"method": chosen, "jobs": jobs, "backend": backend, "scheduler": scheduler},
        elapsed_s=time.perf_counter() - started,
        data=mission.raw,
        notices=mission.notices(),
    )
    return Sweep(
        provenance=provenance,
        phase=scenario.phase.name,
        method=chosen,
        distance=scenario.distance,
        speed=scenario.speed,
        surfacing_time=scenario.surfacing_time,
        arrival_radius=scenario.arrival_radius,
        curves=tuple(_curve(scenario, index, sampled.get(index), analytic.get(index)) for index in curves),
    )


def _method(scenario: SweepScenario, asked: Method | None) -> Method:
    obstacle = scenario.analytic_obstacle()
    if obstacle and asked in ("both", "analytic"):
        hint = "use --method monte-carlo"
        raise InputError([Problem(f"the analytic cost is not known with {obstacle}", key="--method", hint=hint)])
    return asked or ("monte-carlo" if obstacle else "both")


@dataclass(frozen=True)
class SweepTask:
    """One block of trials of one curve: a function of the curve's index and the block, and of nothing else."""

    scenario: SweepScenario
    trials: int
    seed: int

    def __call__(self, item: tuple[int, int]) -> CellTotals:
        """PlanTrials every d_max of a curve on a block of trials."""
        index, block = item
        scenario, size = self.scenario, block_size(self.trials, block)
        drawn = scenario.means.sampled(seed=self.seed, block=block, size=size)
        state = scenario.state(drawn, self.seed, block, size)
        normals = scenario.normals(self.seed, block)
        plan, around = scenario.plan(index, drawn), scenario.surroundings(drawn)
        return run_cells(plan, state, normals, around, scenario.d_max, scenario.table)


def _curve(scenario: SweepScenario, index: int, sampled: CellTotals | None, analytic: Analytic | None) -> SweepCurve:
    """Make a curve; after the grid come the whole distance in one leg, and the table where there is one."""
    grid, cells = len(scenario.d_max) - 1, len(scenario.d_max) + (scenario.table is not None)
    if sampled is not None:
        swept = sampled.first(grid)
        best, errors = swept.best(), sampled.difference_error(swept.best())
        as_good = np.append(swept.as_good_as(best), np.zeros(cells - grid, dtype=bool))
    else:
        assert analytic is not None
        costs = np.array([expectation.cost for expectation in analytic])
        best = int(np.argmin(costs[:grid]))
        as_good, errors = costs <= costs[best], np.zeros(len(costs))
    points = [
        _point(scenario, number, sampled, analytic, float(errors[number]), bool(as_good[number]))
        for number in range(cells)
    ]
    table = points[-1] if scenario.table is not None else None
    return SweepCurve(scenario.sigma(index), tuple(points[:grid]), best, points[grid], table)


def _point(
    scenario: SweepScenario,
    number: int,
    sampled: CellTotals | None,
    analytic: Analytic | None,
    excess_error: float,
    as_good: bool,
) -> SweepPoint:
    expected = analytic[number] if analytic is not None else None
    if sampled is not None:
        cost, surfacings = sampled.cost, sampled.surfacings
        reached = int(cost.count[number])
        numbers = (float(cost.mean[number]), float(cost.standard_error[number]), float(cost.variance[number]) ** 0.5)
        if not reached:
            numbers = (float("nan"),) * 3
        visits = float(surfacings.mean[number]) if reached else float("nan")
        arrived = wilson(reached, reached + int(cost.missing[number]))
    else:
        assert expected is not None
        numbers, visits, arrived = (expected.cost, 0.0, float("nan")), expected.surfacings, Probability(1.0, 1.0, 1.0)
    d_max = float(scenario.d_max[number]) if number < len(scenario.d_max) else float("nan")
    return SweepPoint(
        d_max=d_max,
        d_max_over_distance=d_max / scenario.distance,
        cost=numbers[0],
        standard_error=numbers[1],
        sd=numbers[2],
        surfacings=visits,
        arrived=arrived,
        cost_analytic=expected.cost if expected is not None else None,
        excess_error=excess_error,
        as_good=as_good,
    )
