"""How long should each leg be? The best legs for an aim, run in the mission's own Monte Carlo beside others."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import reduce
from typing import Unpack, get_args

import numpy as np

from missionplan.arrays import Array
from missionplan.mission import MissionOrPath
from missionplan.montecarlo.statistics import Count, Moments, RunningStatistic, wilson
from missionplan.montecarlo.streams import block_count, block_size
from missionplan.results.decision import FAILURE_LOSS, label
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


def _case(task: PairedPlansTask, case: ErrorScenario, totals: Moments, share: float | None) -> LegCase:
    """Result of a case from the moments that the task returns."""
    mean, error = totals.mean, totals.standard_error

    def sampled(plan: int) -> SampledCost:
        trials = int(totals.count[6 + plan])
        arrived = wilson(round(float(mean[6 + plan]) * trials), trials)
        cost, spread, surfacings = (mean[plan], error[plan], mean[3 + plan]) if totals.count[0] else (np.nan,) * 3
        return SampledCost(float(cost), float(spread), float(surfacings), arrived)

    saved, saved_energy = (
        MeanAndError(float(mean[row]), float(error[row])) if totals.count[row] else UNKNOWN for row in (2, 5)
    )
    return LegCase(
        name=case.name,
        sigma=task.scenario.sigma(0) * case.sigma_factor,
        mean_error=case.mean,
        surface_drift=case.surface,
        fixed=sampled(0),
        adaptive=sampled(1),
        saved=saved,
        saved_energy=saved_energy,
        probability=share,
    )


SKETCH_ERROR = 5e-4
"""Relative error of a quantile from a sketch."""


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
    return _judge(scenario, plans, aim, trials, seed)


def _judge(
    scenario: SweepScenario,
    plans: Mapping[str, LegsAtSpeed],
    aim: LegAim,
    trials: int,
    seed: int,
    case: ErrorScenario = AS_PLANNED,
) -> tuple[CandidatePlan, ...]:
    """Run several plans on the same trials, and judge each by the aim."""
    merged: list[tuple[RunningStatistic, RunningStatistic, Count]] = []
    for block in range(block_count(trials)):
        ran = run_plans(scenario, list(plans.values()), seed, block, block_size(trials, block), case=case)
        totals = [
            (
                RunningStatistic.of(np.where(run.arrived, run.duration, np.nan)),
                RunningStatistic.of(np.where(run.arrived, run.energy, np.nan)),
                Count.of(run.arrived & (run.duration <= aim.deadline)),
            )
            for run in ran
        ]
        pairs = zip(merged, totals, strict=bool(merged))
        merged = [(one[0].merge(two[0]), one[1].merge(two[1]), one[2].merge(two[2])) for one, two in pairs] or totals
    judged_plans = []
    for (name, legs), (times, joules, count) in zip(plans.items(), merged, strict=True):
        duration, energy, on_time = times.statistic(), joules.statistic(), count.probability()
        if aim.name == "energy":
            value, error = energy.mean, energy.standard_error
        elif np.isfinite(aim.deadline):
            value = on_time.value
            error = float(np.sqrt(value * (1.0 - value) / max(count.trials, 1)))
        else:
            value, error = _late(times, count.trials)
        speed = legs.speed_factor * scenario.speed
        judged_plans.append(CandidatePlan(name, speed, duration, energy, on_time, value, error))
    return tuple(judged_plans)


def _late(running: RunningStatistic, trials: int) -> tuple[float, float]:
    """Time that 95 % of all trials keep; where fewer arrive, of those that do, failures as in `expected_cost`."""
    value, error = _quantile(running, DEADLINE_QUANTILE, trials)
    arrived = int(running.moments.count)
    if np.isfinite(value) or not arrived:
        return value, error
    failed, (value, error) = 1.0 - arrived / trials, _quantile(running, DEADLINE_QUANTILE, arrived)
    factor, chance = 1.0 + FAILURE_LOSS * failed, FAILURE_LOSS * float(np.sqrt(failed * (1.0 - failed) / trials))
    return value * factor, float(np.hypot(error * factor, value * chance))


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
    **run_as: Unpack[RunArguments],
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
    **run_as
        See `studies.run.RunArguments`.

    Raises
    ------
    InputError
        When the mission has no transit, or no legs can be planned for it.
    """
    run = Run.begun("plan-legs", mission, one_of={"aim": (aim, get_args(Aim))}, **run_as)
    scenario, seed = replace(SweepScenario.of(run.mission), sigmas=(None,)), run.seed
    wanted = LegAim(aim, _deadline(scenario)) if aim == "p95" else LegAim(aim)
    best = optimise_legs(scenario, wanted, seed, progress=run.workers.progress, workers=run.workers.quiet)
    task = PairedPlansTask(scenario, error_scenarios(scenario), *plans_of(best), run.trials, seed)
    cases = [
        case for plans, share in [(task, None), *_explained(task, run)] for case in _cases(plans, share, run, wanted)
    ]
    candidates = compare_plans(scenario, wanted, best, run.trials, seed) if aim != "mean" else ()
    tracks = task.tracks()
    members = [case for plans, share in _members(task, run) for case in _cases(plans, share, run)]
    obstacle, notices = analytic_obstacle(scenario), run.mission.notices()
    if obstacle:
        words = "it uses the spread of legs in pilot trials of the mission, and only the trials show what the legs save"
        notices = (*notices, f"the integral equation does not include {obstacle}: {words}")
    goal, workers = scenario.means.position(scenario.phase.to), run.workers
    plan = LegPlan(
        **vars(best),
        provenance=run.provenance({"aim": aim, **workers.options}, notices),
        phase=scenario.phase.name,
        phase_index=[phase.name for phase in scenario.mission.phases].index(scenario.phase.name),
        aim=aim,
        deadline=wanted.deadline,
        distance=scenario.distance,
        mission_speed=scenario.speed,
        arrival_radius=scenario.arrival_radius,
        required_arrival=wanted.required(scenario),
        surfacing_time=scenario.surfacing_time,
        sigma=scenario.sigma(0),
        goal=(float(goal[0]), float(goal[1])),
        cases=tuple(cases),
        candidates=candidates,
        fixed_tracks=tracks[0],
        adaptive_tracks=tracks[1],
        members=tuple(members),
    )
    outcome = judged(run.mission, plan.recommended_values, trials=run.trials, seed=seed, jobs=workers.jobs)
    return replace(plan, judged=outcome)


def _deadline(scenario: SweepScenario) -> float:
    """Longest duration that the mission's requirements allow the transit; infinite without one [s]."""
    event = f"{scenario.phase.name}.duration"
    bounds = [item.at_most for item in scenario.mission.requirements if item.quantity == event]
    return min((float(bound) for bound in bounds if bound is not None), default=float("inf"))


def _explained(task: PairedPlansTask, run: Run) -> Iterator[tuple[PairedPlansTask, float]]:
    """Yield the same plans under each explanation of the mission, with its probability."""
    for causes, probability, alone in run.under_explanations():
        scenario = replace(SweepScenario.of(alone.mission), sigmas=(None,))
        yield replace(task, scenario=scenario, cases=(replace(AS_PLANNED, name=label(causes)),)), probability


def _members(task: PairedPlansTask, run: Run) -> Iterator[tuple[PairedPlansTask, float]]:
    """Yield the same plans in each member of the current's ensemble, with its probability."""
    means = task.scenario.means
    for name, probability, sailed, alone in run.in_members(means.recorded):
        scenario = replace(task.scenario, means=replace(means, recorded=sailed))
        cases = (replace(AS_PLANNED, name=name),)
        yield replace(task, scenario=scenario, cases=cases, trials=alone.trials), probability


def _cases(task: PairedPlansTask, share: float | None, run: Run, aim: LegAim | None = None) -> tuple[LegCase, ...]:
    """Run every block of each case, and merge its blocks; add what the table gains by the aim ``p95``, where it is."""
    count, block_numbers = len(task.cases), range(block_count(task.trials))
    blocks = list(run.workers.run(task, [(n, block) for block in block_numbers for n in range(count)]))
    cases = []
    for number, case in enumerate(task.cases):
        cases.append(_case(task, case, reduce(Moments.merge, blocks[number::count]), share))
        if aim is not None and aim.name == "p95":
            plans = {"fixed": task.fixed, "table": task.adaptive}
            fixed, table = _judge(task.scenario, plans, aim, task.trials, task.seed, case)
            gain = table.value - fixed.value if np.isfinite(aim.deadline) else fixed.value - table.value
            cases[-1] = replace(
                cases[-1], late=MeanAndError(gain, float(np.hypot(fixed.standard_error, table.standard_error)))
            )
    return tuple(cases)
