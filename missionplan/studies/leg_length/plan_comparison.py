"""Plans of legs against each other: with errors that are not as planned, and by the aim on trials of their own."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from missionplan.arrays import Array
from missionplan.montecarlo.statistics import Count, Moments, RunningStatistic, wilson
from missionplan.montecarlo.streams import block_count, block_size
from missionplan.studies.leg_length.optimise_legs import (
    DEADLINE_QUANTILE,
    MEAN_TIME,
    LegAim,
    OptimisedLegs,
    optimise_legs,
)
from missionplan.studies.leg_length.paired_trials import AS_PLANNED, ErrorScenario, LegsAtSpeed, PlanTrials, run_plans
from missionplan.studies.leg_length.plan_result import CandidatePlan, LegCase, SampledCost
from missionplan.studies.leg_length.sweep_scenario import SweepScenario, start_of

TRACKED_TRIALS = 6
"""Trials whose tracks are kept."""


def error_scenarios(scenario: SweepScenario) -> tuple[ErrorScenario, ...]:
    """The mission itself; σ_v half and double; the mean drift half and double, or one that was not expected."""
    return (
        AS_PLANNED,
        ErrorScenario("σ_v half as large", 0.5),
        ErrorScenario("σ_v twice as large", 2.0),
        *_mean_errors(scenario),
    )


def _mean_errors(scenario: SweepScenario) -> tuple[ErrorScenario, ErrorScenario]:
    """Mean drift that is not as planned; a current that is larger or smaller is so at the surface too."""
    drift, surface, sigma = scenario.mean_drift, scenario.mean_surface_drift, scenario.sigma(0)
    if np.any(drift) or np.any(surface):
        return (
            ErrorScenario("mean drift half as large", mean=_pair(-0.5 * drift), surface=_pair(-0.5 * surface)),
            ErrorScenario("mean drift twice as large", mean=_pair(drift), surface=_pair(surface)),
        )
    course = scenario.means.position(scenario.phase.to)
    course = course - scenario.means.position(start_of(scenario.means.drawn, scenario.phase))
    across = np.array([-course[1], course[0]]) / np.hypot(*course)
    return (
        ErrorScenario("unexpected mean error of σ_v/2 across the course", mean=_pair(0.5 * sigma * across)),
        ErrorScenario("unexpected mean error of σ_v across the course", mean=_pair(sigma * across)),
    )


def _pair(vector: Array) -> tuple[float, float]:
    return float(vector[0]), float(vector[1])


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
        """Moments of costs, time saved, surfacings, energy saved, arrivals; fixed before adaptive.

        All but the arrivals are of the trials that arrive by both plans.
        """
        number, block = item
        size = block_size(self.trials, block)
        fixed, adaptive = self._run(number, block, size, tracked=0)
        saved = (fixed.cost - adaptive.cost) * fixed.nominal
        energy = fixed.energy - adaptive.energy
        values = np.stack([fixed.cost, adaptive.cost, saved, fixed.surfacings, adaptive.surfacings, energy])
        values[:, ~(fixed.arrived & adaptive.arrived)] = np.nan
        return Moments.of(np.concatenate([values, np.stack([fixed.arrived, adaptive.arrived]).astype(float)]))

    def tracks(self) -> tuple[Array, Array]:
        """Tracks of the first few trials of the mission itself, by each plan."""
        size = min(block_size(self.trials, 0), TRACKED_TRIALS)
        fixed, adaptive = self._run(0, 0, size, tracked=size)
        return fixed.track, adaptive.track

    def _run(self, number: int, block: int, size: int, tracked: int) -> tuple[PlanTrials, PlanTrials]:
        plans = (self.fixed, self.adaptive)
        fixed, adaptive = run_plans(
            self.scenario, plans, self.seed, block, size, case=self.cases[number], tracked=tracked
        )
        return fixed, adaptive


def leg_case(scenario: SweepScenario, case: ErrorScenario, totals: Moments) -> LegCase:
    """Result of a case from the moments that `PairedPlansTask` returns."""
    mean, error = totals.mean, totals.standard_error
    reached = bool(totals.count[0])

    def sampled(plan: int) -> SampledCost:
        trials = int(totals.count[6 + plan])
        arrived = wilson(round(float(mean[6 + plan]) * trials), trials)
        cost, spread, surfacings = (mean[plan], error[plan], mean[3 + plan]) if reached else (np.nan,) * 3
        return SampledCost(float(cost), float(spread), float(surfacings), arrived)

    def saved(row: int) -> tuple[float, float]:
        return (float(mean[row]), float(error[row])) if totals.count[row] else (float("nan"), float("nan"))

    saving, saving_error = saved(2)
    energy_saving, energy_saving_error = saved(5)
    return LegCase(
        name=case.name,
        sigma=scenario.sigma(0) * case.sigma_factor,
        mean_error=case.mean,
        surface_drift=case.surface,
        fixed=sampled(0),
        adaptive=sampled(1),
        saving=saving,
        saving_error=saving_error,
        energy_saving=energy_saving,
        energy_saving_error=energy_saving_error,
    )


SKETCH_ERROR = 5e-4
"""Relative error of a quantile from a sketch."""


@dataclass(frozen=True)
class PlanTotals:
    """Merged trials of one plan: time and energy of those that arrived, and how many were on time."""

    duration: RunningStatistic
    energy: RunningStatistic
    on_time: Count

    def merge(self, other: "PlanTotals") -> "PlanTotals":
        """Add the next block."""
        return PlanTotals(
            self.duration.merge(other.duration), self.energy.merge(other.energy), self.on_time.merge(other.on_time)
        )


@dataclass(frozen=True)
class PlanComparisonTask:
    """Several plans on one block of trials: a function of the block alone."""

    scenario: SweepScenario
    plans: tuple[LegsAtSpeed, ...]
    deadline: float
    trials: int
    seed: int
    case: ErrorScenario = AS_PLANNED

    def __call__(self, block: int) -> list[PlanTotals]:
        """Totals of every plan."""
        size = block_size(self.trials, block)
        found = run_plans(self.scenario, self.plans, self.seed, block, size, case=self.case)
        return [
            PlanTotals(
                RunningStatistic.of(np.where(trials.arrived, trials.duration, np.nan)),
                RunningStatistic.of(np.where(trials.arrived, trials.energy, np.nan)),
                Count.of(trials.arrived & (trials.duration <= self.deadline)),
            )
            for trials in found
        ]


def compare_plans(
    scenario: SweepScenario, aim: LegAim, best: OptimisedLegs, trials: int, seed: int
) -> tuple[CandidatePlan, ...]:
    """The best fixed d_max, the best legs for the mean time at the mission's own speed, and the table."""
    mean = optimise_legs(scenario, MEAN_TIME, seed, best.spread)
    plans = {
        f"fixed d_max for the aim {aim.name}": best.fixed,
        "fixed d_max for the mean time": mean.fixed,
        "table for the mean time": mean.adaptive,
        f"table for the aim {aim.name}": best.adaptive,
    }
    return _judge(PlanComparisonTask(scenario, tuple(plans.values()), aim.deadline, trials, seed), tuple(plans), aim)


def late_gain(
    scenario: SweepScenario, aim: LegAim, best: OptimisedLegs, case: ErrorScenario, trials: int, seed: int
) -> tuple[float, float]:
    """What the table gains on the best fixed d_max by the aim ``p95`` in a case, and its standard error.

    Seconds that 95 % of the trials need less; with a deadline, by how much its probability is greater.
    """
    task = PlanComparisonTask(scenario, (best.fixed, best.adaptive), aim.deadline, trials, seed, case)
    fixed, table = _judge(task, ("fixed", "table"), aim)
    gain = table.value - fixed.value if np.isfinite(aim.deadline) else fixed.value - table.value
    return gain, float(np.hypot(fixed.standard_error, table.standard_error))


def _judge(task: PlanComparisonTask, names: tuple[str, ...], aim: LegAim) -> tuple[CandidatePlan, ...]:
    """Run the blocks, and judge each plan by the aim."""
    totals = task(0)
    for block in range(1, block_count(task.trials)):
        totals = [one.merge(other) for one, other in zip(totals, task(block), strict=True)]
    return tuple(
        _candidate(name, legs.speed_factor * task.scenario.speed, reached, aim)
        for name, legs, reached in zip(names, task.plans, totals, strict=True)
    )


def _candidate(name: str, speed: float, totals: PlanTotals, aim: LegAim) -> CandidatePlan:
    duration, energy, on_time = totals.duration.statistic(), totals.energy.statistic(), totals.on_time.probability()
    if aim.name == "energy":
        value, error = energy.mean, energy.standard_error
    elif np.isfinite(aim.deadline):
        value = on_time.value
        error = float(np.sqrt(value * (1.0 - value) / max(totals.on_time.trials, 1)))
    else:
        value, error = _quantile(totals.duration, DEADLINE_QUANTILE, totals.on_time.trials)
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
