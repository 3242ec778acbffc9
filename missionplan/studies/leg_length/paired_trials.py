"""Plans of legs on the same trials of a mission: what each costs, and what one saves against the other."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.montecarlo.statistics import Count, Moments, RunningStatistic
from missionplan.montecarlo.streams import BLOCK, block_size
from missionplan.phases.transit.compensation import Compensation
from missionplan.phases.transit.leg_table import LegTable
from missionplan.phases.transit.plan import TransitPlan, VelocityError
from missionplan.phases.transit.transit import transit
from missionplan.scenario.scenario import Scenario
from missionplan.studies.leg_length.sweep_scenario import SweepScenario

PILOT_BLOCK = 1 << 40
"""Block of the trials on which plans are chosen: never one of those on which the chosen plans are judged."""
HALVING_RUNGS = ((512, 96), (1024, 32))
"""Trials on which plans are screened, and how many of the best go on; what is left is judged on a whole block."""
TRACKS = 6
"""Trials whose tracks are kept."""


@dataclass(frozen=True)
class LegsAtSpeed:
    """A plan of legs.

    Attributes
    ----------
    d_max : float or LegTable
        [m]
    speed : float
        Of the mission's own at its mean: a factor.
    """

    d_max: float | LegTable
    speed: float = 1.0


@dataclass(frozen=True)
class ErrorScenario:
    """A navigation error that is not as planned.

    Attributes
    ----------
    name : str
    sigma_factor : float
        On Σ_v's root.
    mean : tuple of float
        Beyond the mission's v̄, east and north [m/s].
    """

    name: str
    sigma_factor: float = 1.0
    mean: tuple[float, float] = (0.0, 0.0)


AS_PLANNED = ErrorScenario("")


@dataclass(frozen=True)
class PlanTrials:
    """What one plan came to, an array over trials each; `nominal` is t_nom at the plan's speed [s]."""

    cost: Array
    duration: Array
    energy: Array
    surfacings: Array
    arrived: NDArray[np.bool_]
    nominal: Array
    track: Array | None


Score = Callable[[PlanTrials], float]
"""What a plan is chosen by; the less the better."""


def run_plans(
    scenario: SweepScenario,
    plans: Sequence[LegsAtSpeed],
    seed: int,
    block: int,
    size: int = BLOCK,
    *,
    case: ErrorScenario = AS_PLANNED,
    tracked: int = 0,
    listening: Callable[[Compensation | None], Compensation] | None = None,
) -> list[PlanTrials]:
    """PlanTrials every plan on the same trials of a block.

    Parameters
    ----------
    scenario : SweepScenario
    plans : sequence of LegsAtSpeed
    seed, block, size : int
        Of the trials.
    case : ErrorScenario
        What the mission does not know of its errors.
    tracked : int
        Trials whose tracks are kept.
    listening : callable, optional
        Wraps the vehicle's compensation.
    """
    drawn = Scenario.drawn(scenario.mission, scenario.means.recorded, seed=seed, block=block, size=size)
    state = scenario.state(drawn, seed, block, size)
    normals, around = scenario.normals(seed, block), scenario.surroundings(drawn)
    if listening is not None:
        around = replace(around, compensation=listening(around.compensation))
    name, runs = f"{scenario.phase.name}.speed", []
    at_speed: dict[float, TransitPlan] = {}
    for each in plans:
        if each.speed not in at_speed:
            plan = scenario.plan(0, replace(drawn, draws={**drawn.draws, name: drawn[name] * each.speed}))
            error = plan.velocity_error
            shifted = VelocityError(error.mean + np.array(case.mean)[:, None], error.root * case.sigma_factor)
            at_speed[each.speed] = replace(plan, velocity_error=shifted)
        plan = replace(at_speed[each.speed], d_max=each.d_max)
        _, record = transit(plan, state, normals, around, tracked=tracked)
        nominal = np.hypot(*(np.asarray(plan.goal).reshape(2, -1) - state.position)) / plan.speed
        charged = np.maximum(record.surfacings - 1.0, 0.0) * plan.surfacing_time
        cost = (plan.time_under_way(record.distance, record.surfacings) + charged) / nominal - 1.0  # Eq. 25
        runs.append(
            PlanTrials(cost, record.duration, record.energy, record.surfacings, record.arrived, nominal, record.track)
        )
    return runs


def best_plan(scenario: SweepScenario, plans: Sequence[LegsAtSpeed], score: Score, seed: int) -> tuple[int, float]:
    """Find the plan of least score on a block of pilot trials; give its number and its score.

    All are screened on the first of the trials: as these are common to all, differences between plans show long before
    their costs do.
    """
    left, scores = list(range(len(plans))), {}
    for trials, kept in (*HALVING_RUNGS, (BLOCK, 1)):
        if len(left) > kept or trials == BLOCK:
            runs = run_plans(scenario, [plans[index] for index in left], seed, PILOT_BLOCK, trials)
            scores = dict(zip(left, map(score, runs), strict=True))
            left = sorted(left, key=scores.__getitem__)[:kept]
    return left[0], scores[left[0]]


@dataclass(frozen=True)
class PairedPlansTask:
    """The best fixed d_max and the table on one block of one case: a function of the case's number and the block."""

    scenario: SweepScenario
    cases: tuple[ErrorScenario, ...]
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
        size = min(block_size(self.trials, 0), TRACKS)
        fixed, adaptive = self._run(0, 0, size, tracked=size)
        assert fixed.track is not None
        assert adaptive.track is not None
        return fixed.track, adaptive.track

    def _run(self, number: int, block: int, size: int, tracked: int) -> tuple[PlanTrials, PlanTrials]:
        plans = (self.fixed, self.adaptive)
        fixed, adaptive = run_plans(
            self.scenario, plans, self.seed, block, size, case=self.cases[number], tracked=tracked
        )
        return fixed, adaptive


@dataclass(frozen=True)
class PlanTotals:
    """What is kept of the trials of one plan: time and energy of those that arrived, and how many were on time."""

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

    def __call__(self, block: int) -> list[PlanTotals]:
        """Totals of every plan."""
        runs = run_plans(self.scenario, self.plans, self.seed, block, block_size(self.trials, block))
        return [
            PlanTotals(
                RunningStatistic.of(np.where(run.arrived, run.duration, np.nan)),
                RunningStatistic.of(np.where(run.arrived, run.energy, np.nan)),
                Count.of(run.arrived & (run.duration <= self.deadline)),
            )
            for run in runs
        ]
