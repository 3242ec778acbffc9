"""The table of legs and the best fixed d_max on the same trials, also where errors are not as planned."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from missionplan.arrays import Array
from missionplan.montecarlo.statistics import Moments, wilson
from missionplan.montecarlo.streams import block_size
from missionplan.results.leg_length.leg_cases import LegCase, SampledCost
from missionplan.studies.leg_length.paired_trials import AS_PLANNED, ErrorScenario, LegsAtSpeed, PlanTrials, run_plans
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
