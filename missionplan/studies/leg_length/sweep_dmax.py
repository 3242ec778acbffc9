"""What maximum leg length? The cost of each d_max for each velocity error (Briggs et al., section IV.B, Fig. 8)."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, Literal, Unpack, get_args

import numpy as np

from missionplan.errors import InputError, Problem
from missionplan.mission import Mission, MissionOrPath
from missionplan.montecarlo.statistics import Probability, wilson
from missionplan.montecarlo.streams import block_count, block_size
from missionplan.phases.transit.expectation import TransitExpectation
from missionplan.results.decision import MemberOutcome
from missionplan.studies.judgement import judged
from missionplan.studies.leg_length import CellTotals, SweepScenario, run_cells
from missionplan.studies.leg_length.analytic_transit import analytic_curves, analytic_obstacle
from missionplan.studies.leg_length.sweep_result import ExplainedSweep, Sweep, SweepCurve, SweepPoint
from missionplan.studies.run import Run, RunArguments

Method = Literal["both", "analytic", "monte-carlo"]
Analytic = Sequence[TransitExpectation]
Columns = dict[str, list[Any]]
"""Of the points of a curve, by the fields of `SweepPoint`."""


def sweep_dmax(
    mission: MissionOrPath,
    *,
    method: Method | None = None,
    **run_as: Unpack[RunArguments],
) -> Sweep:
    """Find the cost of every d_max of the mission's `sweep` section for every velocity error.

    Parameters
    ----------
    mission : Mission, str or Path
    method : {'both', 'analytic', 'monte-carlo'}, optional
        Default: both where the analytic form applies, else Monte Carlo.
    **run_as
        See `studies.run.RunArguments`.

    Raises
    ------
    InputError
        When the mission has no transit, the mean drift is as fast as the vehicle, or the analytic form is requested
        where it does not apply.
    """
    run = Run.begun("sweep-dmax", mission, one_of={"method": (method, (None, *get_args(Method)))}, **run_as)
    jobs, scenario = run.workers.jobs, SweepScenario.of(run.mission)
    obstacle = analytic_obstacle(scenario)
    if obstacle and method in ("both", "analytic"):
        hint = "use method='monte-carlo'"
        raise InputError([Problem(f"the analytic cost does not allow for {obstacle}", key="method", hint=hint)])
    used = method or ("monte-carlo" if obstacle else "both")
    run = replace(run, trials=0) if used == "analytic" else run
    curves = range(len(scenario.sigmas))
    processes = jobs if run.workers.backend == "loky" else 1
    analytic = [()] * len(curves) if used == "monte-carlo" else analytic_curves(scenario, processes)
    sampled = _sampled(run, scenario)
    options = {"method": used, **run.workers.options}
    sweep = Sweep(
        provenance=run.provenance(options, run.mission.notices()),
        phase=scenario.phase.name,
        method=used,
        distance=scenario.distance,
        speed=scenario.speed,
        surfacing_time=scenario.surfacing_time,
        arrival_radius=scenario.arrival_radius,
        curves=tuple(_curve(scenario, index, sampled.get(index), analytic[index]) for index in curves),
    )
    quiet = replace(run, workers=run.workers.quiet)
    explained, members = _explained(sweep, scenario, quiet), _members(sweep, scenario, quiet)
    outcome = None
    if run.trials and np.isfinite(sweep.middle.recommended.cost):
        recommended = {f"{sweep.phase}.d_max": f"{sweep.middle.recommended.d_max!r} m"}
        outcome = judged(run.mission, recommended, trials=run.trials, seed=run.seed, jobs=jobs)
    return replace(sweep, explanations=tuple(explained), members=tuple(members), judged=outcome)


def first_curve(mission: Mission, *, trials: int, seed: int) -> SweepCurve:
    """Find the cost of every d_max for the first velocity error by Monte Carlo, as `sweep_dmax` does, and no more."""
    run = Run.begun("sweep-dmax", mission, trials=trials, seed=seed)
    scenario = SweepScenario.of(run.mission)
    return _curve(scenario, 0, _sampled(run, scenario).get(0), ())


def _sampled(run: Run, scenario: SweepScenario) -> dict[int, CellTotals]:
    """Run every block of every curve, and merge those of each curve."""
    curve_totals: dict[int, CellTotals] = {}
    # the largest sigma, as a rule the last, takes longest: it goes first, so that workers end together
    curves = range(len(scenario.sigmas))
    items = [(index, block) for block in range(block_count(run.trials)) for index in reversed(curves)]
    results = run.workers.run(partial(_block, scenario, run.trials, run.seed), items)
    for (index, _), totals in zip(items, results, strict=True):
        curve_totals[index] = curve_totals[index].merge(totals) if index in curve_totals else totals
    return curve_totals


def _explained(sweep: Sweep, scenario: SweepScenario, run: Run) -> Iterator[ExplainedSweep]:
    """Run the middle curve under each explanation, with the same draws, beside what is recommended over all of them."""
    index = sweep.curves.index(sweep.middle)
    for causes, probability, alone in run.under_explanations():
        explained_scenario = replace(SweepScenario.of(alone.mission), sigmas=(scenario.sigmas[index],))
        curve = _curve(explained_scenario, 0, _sampled(alone, explained_scenario)[0], ())
        yield ExplainedSweep(causes, probability, curve, curve.points[sweep.middle.recommended_index])


def _members(sweep: Sweep, scenario: SweepScenario, run: Run) -> Iterator[MemberOutcome]:
    """Run what is recommended for the middle curve in each member of the current's ensemble."""
    index, means = sweep.curves.index(sweep.middle), scenario.means
    for name, probability, sailed, alone in run.in_members(means.recorded):
        member_scenario = replace(
            scenario,
            means=replace(means, recorded=sailed),
            sigmas=(scenario.sigmas[index],),
            d_max=np.array([sweep.middle.recommended.d_max, scenario.distance]),
        )
        point = _curve(member_scenario, 0, _sampled(alone, member_scenario)[0], ()).points[0]
        yield MemberOutcome(name, probability, point.arrived)


def _block(scenario: SweepScenario, trials: int, seed: int, item: tuple[int, int]) -> CellTotals:
    """Run every d_max of a curve on a block of trials, by the curve's index and the block."""
    index, block = item
    size = block_size(trials, block)
    drawn = scenario.means.sampled(seed=seed, block=block, size=size)
    state, normals = scenario.state(drawn, seed, block, size), scenario.normals(seed, block)
    plan, environment = scenario.plan(index, drawn), scenario.environment(drawn)
    return run_cells(plan, state, normals, environment, scenario.d_max, scenario.table)


def _of_trials(totals: CellTotals, grid: int) -> tuple[int, Columns]:
    """The best of the first cells, which are the grid's d_max, and what trials tell of all; nan where none arrived."""
    cost, reached = totals.cost, totals.cost.count > 0
    swept = totals.first(grid)
    best = swept.best()
    means = {"cost": cost.mean, "standard_error": cost.standard_error, "surfacings": totals.surfacings.mean}
    return best, {
        **{name: np.where(reached, values, np.nan).tolist() for name, values in means.items()},
        "sd": [value**0.5 for value in np.where(reached, cost.variance, np.nan).tolist()],
        "arrived": [wilson(int(n), int(n) + int(lost)) for n, lost in zip(cost.count, cost.missing, strict=True)],
        "excess_error": totals.difference_error(best).tolist(),
        "as_good": swept.as_good_as(best).tolist() + [False] * (len(reached) - grid),
    }


def _of_expectations(expectations: Analytic, grid: int) -> tuple[int, Columns]:
    """The same from the integral equation."""
    costs, count = [expectation.cost for expectation in expectations], len(expectations)
    best = int(np.argmin(costs[:grid]))
    return best, {
        "cost": costs,
        "standard_error": [0.0] * count,
        "surfacings": [expectation.surfacings for expectation in expectations],
        "sd": [math.nan] * count,
        "arrived": [Probability(1.0, 1.0, 1.0)] * count,
        "excess_error": [0.0] * count,
        "as_good": [cost <= costs[best] for cost in costs],
    }


def _curve(scenario: SweepScenario, index: int, sampled: CellTotals | None, analytic: Analytic) -> SweepCurve:
    """Curve of one σ_v; after the grid follow the whole distance in one leg, and the table where there is one."""
    grid = len(scenario.d_max) - 1
    best, columns = _of_expectations(analytic, grid) if sampled is None else _of_trials(sampled, grid)
    lengths = [*scenario.d_max.tolist(), *([] if scenario.table is None else [math.nan])]
    columns["d_max"] = lengths
    columns["d_max_over_distance"] = [length / scenario.distance for length in lengths]
    columns["cost_analytic"] = [expectation.cost for expectation in analytic] or [None] * len(lengths)
    points = [SweepPoint(**dict(zip(columns, values, strict=True))) for values in zip(*columns.values(), strict=True)]
    return SweepCurve(
        sigma=scenario.sigma(index),
        points=tuple(points[:grid]),
        best_index=best,
        one_leg=points[grid],
        table=points[-1] if scenario.table is not None else None,
        required_arrival=scenario.required_arrival,
        nominal_time=scenario.distance / scenario.speed,
    )
