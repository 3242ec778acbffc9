"""How long should each leg be? The best legs for an aim, run in the mission's own Monte Carlo beside others."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import reduce
from typing import get_args

import numpy as np

from missionplan.arrays import Array
from missionplan.mission import MissionOrPath
from missionplan.montecarlo.blocks import Backend, Progress, Workers
from missionplan.montecarlo.statistics import Count, Moments, RunningStatistic, wilson
from missionplan.montecarlo.streams import block_count, block_size
from missionplan.results import Provenance
from missionplan.results.decision import label
from missionplan.studies.judgement import judged
from missionplan.studies.leg_length import SweepScenario
from missionplan.studies.leg_length.analytic_transit import LegSpread, analytic_obstacle
from missionplan.studies.leg_length.optimise_legs import (
    DEADLINE_QUANTILE,
    MEAN_TIME,
    Aim,
    LegAim,
    optimise_legs,
    plans_of,
)
from missionplan.studies.leg_length.paired_trials import (
    AS_PLANNED,
    ErrorScenario,
    LegsAtSpeed,
    error_scenarios,
    run_plans,
)
from missionplan.studies.leg_length.plan_result import (
    UNKNOWN,
    CandidatePlan,
    FoundLegs,
    LegCase,
    LegPlan,
    MeanAndError,
    SampledCost,
)
from missionplan.studies.run import Run, RunArguments

TRACKED_TRIALS = 6
"""Trials whose tracks are kept."""


@dataclass(frozen=True)
class PairedPlansTask:
    """Both plans on one block of one case: a function of the case's number and the block alone."""

    scenario: SweepScenario
    cases: Sequence[ErrorScenario]
    fixed: LegsAtSpeed
    adaptive: LegsAtSpeed
    trials: int
    seed: int

    def __call__(self, item: tuple[int, int]) -> Moments:
        """Moments of costs, time saved, surfacings, energy saved (of those that arrive by both plans), and arrivals."""
        number, block = item
        size, plans = block_size(self.trials, block), (self.fixed, self.adaptive)
        fixed, adaptive = run_plans(self.scenario, plans, self.seed, block, size, case=self.cases[number])
        saved = (fixed.cost - adaptive.cost) * fixed.nominal
        energy = fixed.energy - adaptive.energy
        values = np.stack([fixed.cost, adaptive.cost, saved, fixed.surfacings, adaptive.surfacings, energy])
        values[:, ~(fixed.arrived & adaptive.arrived)] = np.nan
        return Moments.of(np.concatenate([values, np.stack([fixed.arrived, adaptive.arrived]).astype(float)]))

    def tracks(self) -> tuple[Array, Array]:
        """Tracks of the first few trials of the mission itself, by each plan."""
        size, plans = min(block_size(self.trials, 0), TRACKED_TRIALS), (self.fixed, self.adaptive)
        fixed, adaptive = run_plans(self.scenario, plans, self.seed, 0, size, case=self.cases[0], tracked=size)
        return fixed.track, adaptive.track


def leg_case(scenario: SweepScenario, case: ErrorScenario, totals: Moments) -> LegCase:
    """Result of a case from the moments that `PairedPlansTask` returns."""
    mean, error = totals.mean, totals.standard_error

    def sampled(plan: int) -> SampledCost:
        trials = int(totals.count[6 + plan])
        arrived = wilson(round(float(mean[6 + plan]) * trials), trials)
        cost, spread, surfacings = (mean[plan], error[plan], mean[3 + plan]) if totals.count[0] else (np.nan,) * 3
        return SampledCost(float(cost), float(spread), float(surfacings), arrived)

    def saved(row: int) -> MeanAndError:
        return MeanAndError(float(mean[row]), float(error[row])) if totals.count[row] else UNKNOWN

    return LegCase(
        name=case.name,
        sigma=scenario.sigma(0) * case.sigma_factor,
        mean_error=case.mean,
        surface_drift=case.surface,
        fixed=sampled(0),
        adaptive=sampled(1),
        saved=saved(2),
        saved_energy=saved(5),
    )


SKETCH_ERROR = 5e-4
"""Relative error of a quantile from a sketch."""


Totals = tuple[RunningStatistic, RunningStatistic, Count]
"""Merged trials of one plan: time and energy of those that arrived, and how many were on time."""


@dataclass(frozen=True)
class PlanComparisonTask:
    """Several plans on one block of trials: a function of the block alone."""

    scenario: SweepScenario
    plans: tuple[LegsAtSpeed, ...]
    deadline: float
    trials: int
    seed: int
    case: ErrorScenario = AS_PLANNED

    def __call__(self, block: int) -> list[Totals]:
        """Totals of every plan."""
        size = block_size(self.trials, block)
        found = run_plans(self.scenario, self.plans, self.seed, block, size, case=self.case)
        return [
            (
                RunningStatistic.of(np.where(trials.arrived, trials.duration, np.nan)),
                RunningStatistic.of(np.where(trials.arrived, trials.energy, np.nan)),
                Count.of(trials.arrived & (trials.duration <= self.deadline)),
            )
            for trials in found
        ]


def compare_plans(
    scenario: SweepScenario, aim: LegAim, best: FoundLegs, trials: int, seed: int
) -> tuple[CandidatePlan, ...]:
    """The best fixed d_max, the best legs for the mean time at the mission's own speed, and the table."""
    mean = optimise_legs(scenario, MEAN_TIME, seed, LegSpread(best.planned_sigma, best.base_spread))
    (fixed, adaptive), (fixed_for_mean, adaptive_for_mean) = plans_of(best), plans_of(mean)
    plans = {
        f"fixed d_max for the aim {aim.name}": fixed,
        "fixed d_max for the mean time": fixed_for_mean,
        "table for the mean time": adaptive_for_mean,
        f"table for the aim {aim.name}": adaptive,
    }
    return _judge(PlanComparisonTask(scenario, tuple(plans.values()), aim.deadline, trials, seed), tuple(plans), aim)


def late_gain(
    scenario: SweepScenario, aim: LegAim, best: FoundLegs, case: ErrorScenario, trials: int, seed: int
) -> MeanAndError:
    """What the table gains on the best fixed d_max by the aim ``p95`` in a case, and its standard error.

    Seconds that 95 % of the trials need less; with a deadline, by how much its probability is greater.
    """
    task = PlanComparisonTask(scenario, plans_of(best), aim.deadline, trials, seed, case)
    fixed, table = _judge(task, ("fixed", "table"), aim)
    gain = table.value - fixed.value if np.isfinite(aim.deadline) else fixed.value - table.value
    return MeanAndError(gain, float(np.hypot(fixed.standard_error, table.standard_error)))


def _judge(task: PlanComparisonTask, names: tuple[str, ...], aim: LegAim) -> tuple[CandidatePlan, ...]:
    """Run the blocks, and judge each plan by the aim."""
    totals = task(0)
    for block in range(1, block_count(task.trials)):
        pairs = zip(totals, task(block), strict=True)
        totals = [(one[0].merge(two[0]), one[1].merge(two[1]), one[2].merge(two[2])) for one, two in pairs]
    return tuple(
        _candidate(name, legs.speed_factor * task.scenario.speed, reached, aim)
        for name, legs, reached in zip(names, task.plans, totals, strict=True)
    )


def _candidate(name: str, speed: float, totals: Totals, aim: LegAim) -> CandidatePlan:
    times, joules, count = totals
    duration, energy, on_time = times.statistic(), joules.statistic(), count.probability()
    if aim.name == "energy":
        value, error = energy.mean, energy.standard_error
    elif np.isfinite(aim.deadline):
        value = on_time.value
        error = float(np.sqrt(value * (1.0 - value) / max(count.trials, 1)))
    else:
        value, error = _quantile(times, DEADLINE_QUANTILE, count.trials)
    return CandidatePlan(name, speed, duration, energy, on_time, value, error)


def _quantile(running: RunningStatistic, share: float, trials: int) -> tuple[float, float]:
    """Quantile over all trials, those that never arrive last, and its standard error.

    Half the distance of the quantiles one binomial standard error below and above (Woodruff 1952, J. Am. Stat. Assoc.
    47, 635–646), and the error of the sketch.
    """
    arrived = int(running.moments.count)
    spread = float(np.sqrt(share * (1.0 - share) / max(trials, 1)))
    shares = [level * trials / max(arrived, 1) for level in (share - spread, share, share + spread)]
    low, value, high = (running.quantile(level) if level <= 1.0 else float("inf") for level in shares)
    return value, float(np.hypot(0.5 * (high - low), SKETCH_ERROR * value)) if np.isfinite(high) else float("inf")


def plan_legs(
    mission: MissionOrPath,
    *,
    aim: Aim = "mean",
    trials: int | None = None,
    seed: int | None = None,
    jobs: int = 1,
    backend: Backend = "loky",
    scheduler: str | None = None,
    progress: Progress | None = None,
) -> LegPlan:
    """Find the best legs of a transit, and compare them with the best fixed d_max.

    Parameters
    ----------
    mission : Mission, str or Path
        Its transit is the one that `sweep` names, else the first.
    aim : {'mean', 'p95', 'energy'}
        What to make least: the expected time; the time that 95 % of the trials keep (where the mission requires a
        transit's `duration` to be `at_most` something, greatest: the probability of that); the energy, with the speed
        chosen too.
    trials, seed : int, optional
        Default: the mission's.
    jobs, backend, scheduler, progress
        See `montecarlo.blocks.Workers`.

    Raises
    ------
    InputError
        When the mission has no transit, or no legs can be planned for it.
    """
    asked = RunArguments(trials=trials, seed=seed, jobs=jobs, backend=backend, scheduler=scheduler, progress=progress)
    run = Run.begun("plan-legs", mission, one_of={"aim": (aim, get_args(Aim))}, **asked)
    scenario, seed = replace(SweepScenario.of(run.mission), sigmas=(None,)), run.seed
    wanted = LegAim(aim, _deadline(scenario)) if aim == "p95" else LegAim(aim)
    best = optimise_legs(scenario, wanted, seed, progress=progress, workers=run.workers.quiet)
    task = PairedPlansTask(scenario, error_scenarios(scenario), *plans_of(best), run.trials, seed)
    tasks = [(task, None), *_explained(task, run)]
    cases = [case for each, share in tasks for case in _judged(_cases(each, share, run.workers), each, wanted, best)]
    candidates = compare_plans(scenario, wanted, best, run.trials, seed) if aim != "mean" else ()
    tracks = task.tracks()
    members = [case for each, share in _members(task, run) for case in _cases(each, share, run.workers)]
    options = {"aim": aim, "jobs": jobs, "backend": backend, "scheduler": scheduler}
    provenance = run.provenance(options, (*run.mission.notices(), *_notices(scenario)))
    plan = _leg_plan(provenance, scenario, wanted, best, cases, candidates, tracks, members)
    recommended = {f"{plan.phase}.{key}": value for key, value in plan.changes.items()}
    return replace(plan, judged=judged(run.mission, recommended, trials=run.trials, seed=seed, jobs=jobs))


def _explained(task: PairedPlansTask, run: Run) -> Iterator[tuple[PairedPlansTask, float]]:
    """Yield the same plans under each explanation of the mission, with its probability."""
    for each, _ in run.under_explanations():
        known = replace(SweepScenario.of(each.mission), sigmas=(None,))
        case = replace(AS_PLANNED, name=label(each.causes))
        yield replace(task, scenario=known, cases=(case,)), each.probability


def _members(task: PairedPlansTask, run: Run) -> Iterator[tuple[PairedPlansTask, float]]:
    """Yield the same plans in each member of the current's ensemble, with its probability."""
    means = task.scenario.means
    for name, probability, sailed, alone in run.in_members(means.recorded):
        given = replace(task.scenario, means=replace(means, recorded=sailed))
        case = replace(AS_PLANNED, name=name)
        yield replace(task, scenario=given, cases=(case,), trials=alone.trials), probability


def _cases(task: PairedPlansTask, share: float | None, workers: Workers) -> tuple[LegCase, ...]:
    """Run every block of each case, and merge its blocks."""
    count = len(task.cases)
    blocks = list(workers.run(task, [(n, block) for block in range(block_count(task.trials)) for n in range(count)]))
    totals = (reduce(Moments.merge, blocks[number::count]) for number in range(count))
    pairs = zip(task.cases, totals, strict=True)
    return tuple(replace(leg_case(task.scenario, case, each), probability=share) for case, each in pairs)


def _judged(cases: tuple[LegCase, ...], task: PairedPlansTask, aim: LegAim, best: FoundLegs) -> tuple[LegCase, ...]:
    """Add what the table gains by the aim ``p95``, where that is the aim."""
    if aim.name != "p95":
        return cases
    gains = (late_gain(task.scenario, aim, best, case, task.trials, task.seed) for case in task.cases)
    return tuple(replace(case, late=gain) for case, gain in zip(cases, gains, strict=True))


def _leg_plan(
    provenance: Provenance,
    scenario: SweepScenario,
    aim: LegAim,
    best: FoundLegs,
    cases: Sequence[LegCase],
    candidates: tuple[CandidatePlan, ...],
    tracks: tuple[Array, Array],
    members: Sequence[LegCase],
) -> LegPlan:
    """Put together what was planned and what its trials show, with tracks by the fixed d_max and by the table."""
    goal = scenario.means.position(scenario.phase.to)
    return LegPlan(
        **vars(best),
        provenance=provenance,
        phase=scenario.phase.name,
        phase_index=[phase.name for phase in scenario.mission.phases].index(scenario.phase.name),
        aim=aim.name,
        deadline=aim.deadline,
        distance=scenario.distance,
        mission_speed=scenario.speed,
        arrival_radius=scenario.arrival_radius,
        required_arrival=scenario.required_arrival,
        surfacing_time=scenario.surfacing_time,
        sigma=scenario.sigma(0),
        goal=(float(goal[0]), float(goal[1])),
        cases=tuple(cases),
        candidates=candidates,
        fixed_tracks=tracks[0],
        adaptive_tracks=tracks[1],
        members=tuple(members),
    )


def _deadline(scenario: SweepScenario) -> float:
    """Longest duration that the mission's requirements allow the transit; infinite without one [s]."""
    quantity = f"{scenario.phase.name}.duration"
    bounds = [requirement.at_most for requirement in scenario.mission.requirements if requirement.quantity == quantity]
    return min((float(bound) for bound in bounds if bound is not None), default=float("inf"))


def _notices(scenario: SweepScenario) -> tuple[str, ...]:
    obstacle = analytic_obstacle(scenario)
    words = "it uses the spread of legs in pilot trials of the mission, and only the trials show what the legs save"
    return (f"the integral equation does not include {obstacle}: {words}",) if obstacle else ()
