"""How long should each leg be? The best legs for an aim, tried in the mission's own Monte Carlo."""

import time
from dataclasses import replace

import numpy as np

from missionplan.mission import Mission
from missionplan.montecarlo.parallel_blocks import Backend, Progress, run_blocks
from missionplan.montecarlo.statistics import Moments, RunningStatistic, wilson
from missionplan.montecarlo.streams import block_count
from missionplan.phases.transit.leg_table import LegTable
from missionplan.results.base import Provenance
from missionplan.results.legs import CandidatePlan, LegCase, LegPlan, SampledCost
from missionplan.studies.leg_length.optimise_legs import DEADLINE_QUANTILE, Aim, OptimisedLegs, optimise_legs
from missionplan.studies.leg_length.paired_trials import (
    AS_PLANNED,
    ErrorScenario,
    PairedPlansTask,
    PlanComparisonTask,
    PlanTotals,
)
from missionplan.studies.leg_length.sweep_scenario import SweepScenario

SKETCH_ERROR = 5e-4
"""Relative error of a quantile's sketch."""


def plan_legs(
    mission: Mission,
    *,
    aim: Aim = "mean",
    trials: int | None = None,
    seed: int | None = None,
    jobs: int = 1,
    backend: Backend = "loky",
    scheduler: str | None = None,
    progress: Progress | None = None,
) -> LegPlan:
    """Find the legs that serve a transit best, and try them beside the best fixed d_max.

    Parameters
    ----------
    mission : Mission
        Its transit is the one that `sweep` names, else the first.
    aim : {'mean', 'p95', 'energy'}
        What to make least: the expected time; the time that 95 % of the trials keep (where the mission requires a
        transit's `duration` to be `at_most` something, greatest: the probability of that); the energy, with the speed
        chosen too.
    trials, seed : int, optional
        Default: the mission's.
    jobs, backend, scheduler, progress
        See `run_blocks`.

    Raises
    ------
    InputError
        When the mission has no transit, or no legs can be planned for it.
    """
    started = time.perf_counter()
    scenario = replace(SweepScenario.of(mission), sigmas=(None,))
    trials = trials or mission.monte_carlo.trials
    seed = mission.monte_carlo.seed if seed is None else seed
    deadline = _deadline(scenario) if aim == "p95" else float("inf")
    choice = optimise_legs(scenario, aim, deadline, seed)
    table = choice.adaptive.d_max
    assert isinstance(table, LegTable)
    assert isinstance(choice.fixed.d_max, float)
    cases = _cases(scenario)
    task = PairedPlansTask(scenario, cases, choice.fixed, choice.adaptive, trials, seed)
    items = [(number, block) for block in range(block_count(trials)) for number in range(len(cases))]
    totals: dict[int, Moments] = {}
    results = run_blocks(task, items, jobs=jobs, backend=backend, scheduler=scheduler, progress=progress)
    for (number, _), moments in zip(items, results, strict=True):
        totals[number] = totals[number].merge(moments) if number in totals else moments
    tracks = task.tracks()
    candidates = _contest(scenario, aim, choice, deadline, trials, seed) if aim != "mean" else ()
    provenance = Provenance(
        command="plan-legs",
        mission=mission.name,
        file=mission.file,
        seed=seed,
        trials=trials,
        options={"aim": aim, "jobs": jobs, "backend": backend, "scheduler": scheduler},
        elapsed_s=time.perf_counter() - started,
        data=mission.raw,
        notices=(*mission.notices(), *_notices(scenario)),
    )
    goal = scenario.means.position(scenario.phase.to, f"{scenario.phase.name}.to")
    return LegPlan(
        provenance=provenance,
        phase=scenario.phase.name,
        phase_index=mission.phases.index(scenario.phase),
        aim=aim,
        how_found=choice.how_found,
        deadline=deadline,
        distance=scenario.distance,
        speed=scenario.speed * choice.adaptive.speed,
        mission_speed=scenario.speed,
        arrival_radius=scenario.arrival_radius,
        surfacing_time=scenario.surfacing_time,
        sigma=scenario.sigma(0),
        planned_sigma=choice.spread.sigma,
        base_spread=choice.spread.base,
        goal=(float(goal[0]), float(goal[1])),
        left=table.left,
        leg=table.leg,
        expected_cost=choice.adaptive_cost,
        least_cost=choice.least_cost,
        expected_surfacings=choice.surfacings,
        fixed_d_max=choice.fixed.d_max,
        fixed_cost=choice.fixed_cost,
        one_leg_cost=choice.one_leg_cost,
        cases=tuple(_case(scenario, case, totals[number]) for number, case in enumerate(cases)),
        candidates=candidates,
        fixed_tracks=tracks[0],
        adaptive_tracks=tracks[1],
    )


def _deadline(scenario: SweepScenario) -> float:
    """The longest that the mission allows the transit; infinite where it does not say [s]."""
    wanted = f"{scenario.phase.name}.duration"
    bounds = [requirement.at_most for requirement in scenario.mission.requirements if requirement.quantity == wanted]
    return min((float(bound) for bound in bounds if bound is not None), default=float("inf"))


def _contest(
    scenario: SweepScenario, aim: Aim, choice: OptimisedLegs, deadline: float, trials: int, seed: int
) -> tuple[CandidatePlan, ...]:
    """The best fixed d_max, the best legs for the mean time at the mission's own speed, and the table."""
    mean = optimise_legs(scenario, "mean", deadline, seed, choice.spread)
    plans = (mean.fixed, choice.fixed, mean.adaptive, choice.adaptive)
    task = PlanComparisonTask(scenario, plans, deadline, trials, seed)
    totals: list[PlanTotals] = []
    for block in range(block_count(trials)):
        more = task(block)
        totals = [a.merge(b) for a, b in zip(totals, more, strict=True)] if totals else more
    names = (
        "fixed d_max for the mean time",
        f"fixed d_max for the aim {aim}",
        "table for the mean time",
        f"table for the aim {aim}",
    )
    order = (1, 0, 2, 3)
    return tuple(
        _candidate_plan(names[i], plans[i].speed * scenario.speed, totals[i], aim, deadline=deadline) for i in order
    )


def _candidate_plan(name: str, speed: float, totals: PlanTotals, aim: Aim, deadline: float) -> CandidatePlan:
    duration, energy, on_time = totals.duration.statistic(), totals.energy.statistic(), totals.on_time.probability()
    if aim == "energy":
        value, error = energy.mean, energy.standard_error
    elif np.isfinite(deadline):
        value = on_time.value
        error = float(np.sqrt(value * (1.0 - value) / max(totals.on_time.trials, 1)))
    else:
        value, error = _quantile(totals.duration, DEADLINE_QUANTILE, totals.on_time.trials)
    return CandidatePlan(name, speed, duration, energy, on_time, value, error)


def _quantile(running: RunningStatistic, share: float, trials: int) -> tuple[float, float]:
    """Quantile over all trials, those that never arrive last, and its standard error from order statistics."""
    arrived = int(running.moments.count)
    spread = float(np.sqrt(share * (1.0 - share) / max(trials, 1)))
    shares = [level * trials / max(arrived, 1) for level in (share - spread, share, share + spread)]
    low, value, high = (running.quantile(level) if level <= 1.0 else float("inf") for level in shares)
    return value, float(np.hypot(0.5 * (high - low), SKETCH_ERROR * value)) if np.isfinite(high) else float("inf")


def _cases(scenario: SweepScenario) -> tuple[ErrorScenario, ...]:
    """The mission itself; σ_v half and double; the mean drift half and double, or one that was not expected."""
    drift = scenario.mean_drift
    sigma = scenario.sigma(0)
    if np.any(drift):
        means = [("mean drift half as large", -0.5 * drift), ("mean drift twice as large", drift)]
    else:
        course = scenario.means.position(scenario.phase.to, f"{scenario.phase.name}.to")
        course = course - scenario.means.position(*scenario.start)
        across = np.array([-course[1], course[0]]) / np.hypot(*course)
        means = [
            ("unexpected mean error of σ_v/2 across the course", 0.5 * sigma * across),
            ("unexpected mean error of σ_v across the course", sigma * across),
        ]
    return (
        AS_PLANNED,
        ErrorScenario("σ_v half as large", 0.5),
        ErrorScenario("σ_v twice as large", 2.0),
        *(ErrorScenario(name, mean=(float(shift[0]), float(shift[1]))) for name, shift in means),
    )


def _case(scenario: SweepScenario, case: ErrorScenario, totals: Moments) -> LegCase:
    mean, error = totals.mean, totals.standard_error
    reached = bool(totals.count[0])

    def sampled(plan: int) -> SampledCost:
        trials = int(totals.count[6 + plan])
        arrived = wilson(round(float(mean[6 + plan]) * trials), trials)
        cost, spread, surfacings = (mean[plan], error[plan], mean[3 + plan]) if reached else (np.nan,) * 3
        return SampledCost(float(cost), float(spread), float(surfacings), arrived)

    def saved(row: int) -> tuple[float, float]:
        return (float(mean[row]), float(error[row])) if totals.count[row] else (float("nan"), float("nan"))

    return LegCase(
        case.name, scenario.sigma(0) * case.sigma_factor, case.mean, sampled(0), sampled(1), *saved(2), *saved(5)
    )


def _notices(scenario: SweepScenario) -> tuple[str, ...]:
    obstacle = scenario.analytic_obstacle()
    if not obstacle:
        return ()
    return (
        f"the integral equation does not know {obstacle}: it reckons with the spread of legs in a pilot of the "
        "mission's trials, and only the trials tell what the legs save",
    )
