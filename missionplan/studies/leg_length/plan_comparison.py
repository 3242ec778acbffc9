"""Plans of legs evaluated by the aim that they are chosen for, on other trials than those that they are chosen on."""

from dataclasses import dataclass

import numpy as np

from missionplan.montecarlo.statistics import Count, RunningStatistic
from missionplan.montecarlo.streams import block_count, block_size
from missionplan.results.leg_length.leg_cases import CandidatePlan
from missionplan.studies.leg_length.optimise_legs import (
    DEADLINE_QUANTILE,
    MEAN_TIME,
    LegAim,
    OptimisedLegs,
    optimise_legs,
)
from missionplan.studies.leg_length.paired_trials import AS_PLANNED, ErrorScenario, LegsAtSpeed, run_plans
from missionplan.studies.leg_length.sweep_scenario import SweepScenario

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
