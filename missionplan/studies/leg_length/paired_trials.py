"""Plans of legs on the same trials of a mission (common random numbers), and the best of many plans.

Differences between plans on common trials are known much better than either plan's cost (Law 2015, Simulation Modeling
and Analysis, sect. 11.2).
"""

import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.montecarlo.blocks import IN_THIS_PROCESS, Workers
from missionplan.montecarlo.streams import BLOCK
from missionplan.phases.hooks import TransitEffect, TrialState
from missionplan.phases.transit import transit
from missionplan.phases.transit.compensation import Compensation
from missionplan.phases.transit.plan import Environment, LegTable, LegTables, TransitNormals, TransitPlan, VelocityError
from missionplan.results.decision import FAILURE_LOSS
from missionplan.studies.leg_length import SweepScenario, start_of

PILOT_BLOCK = 1 << 40
"""Block of the pilot trials, on which plans are chosen: never one of those on which chosen plans are evaluated."""
HALVING_RUNGS = ((512, 96), (1024, 32))
"""Trials and number of plans that go on, at each rung of successive halving; the last rung is a whole block."""
TRIALS_TOGETHER = 1 << 15
"""Trials that are run at once, each trial of each plan for itself; more take memory and gain little."""


@dataclass(frozen=True)
class LegsAtSpeed:
    """A plan of legs."""

    d_max: float | LegTable
    """D max [m]."""
    speed_factor: float = 1.0
    """Speed over the mission's own."""


@dataclass(frozen=True)
class ErrorScenario:
    """A navigation error that is not as planned."""

    name: str
    sigma_factor: float = 1.0
    """On Σ_v's root."""
    mean: tuple[float, float] = (0.0, 0.0)
    """Under way, beyond the mission's v̄, east and north [m/s]."""
    surface: tuple[float, float] = (0.0, 0.0)
    """At the surface, beyond the mission's current, east and north [m/s]."""


@dataclass(frozen=True)
class _AddedDrift(TransitEffect):
    """Steady drift at the surface [m/s], added to the mission's."""

    east: float
    north: float

    def surface_velocity(self, t: Array, duration: Array, position: Array) -> Array:
        """Return the drift velocity, shape (2, n) [m/s]."""
        return np.stack([np.full_like(t, self.east), np.full_like(t, self.north)])


AS_PLANNED = ErrorScenario("")


def error_scenarios(scenario: SweepScenario) -> tuple[ErrorScenario, ...]:
    """The mission itself; σ_v half and double; the mean drift half and double, or one that was not expected."""
    (drift, surface), sigma = scenario.mean_drifts, scenario.sigma(0)
    half, twice = ErrorScenario("σ_v half as large", 0.5), ErrorScenario("σ_v twice as large", 2.0)
    if np.any(drift) or np.any(surface):  # a current that is larger or smaller is so at the surface too
        return (
            *(AS_PLANNED, half, twice),
            ErrorScenario("mean drift half as large", mean=_pair(-0.5 * drift), surface=_pair(-0.5 * surface)),
            ErrorScenario("mean drift twice as large", mean=_pair(drift), surface=_pair(surface)),
        )
    course = scenario.means.position(scenario.phase.to)
    course = course - scenario.means.position(start_of(scenario.means.drawn, scenario.phase))
    across = np.array([-course[1], course[0]]) / np.hypot(*course)
    return (
        *(AS_PLANNED, half, twice),
        ErrorScenario("unexpected mean error of σ_v/2 across the course", mean=_pair(0.5 * sigma * across)),
        ErrorScenario("unexpected mean error of σ_v across the course", mean=_pair(sigma * across)),
    )


def _pair(vector: Array) -> tuple[float, float]:
    return float(vector[0]), float(vector[1])


@dataclass(frozen=True)
class PlanTrials:
    """Trials of one plan."""

    cost: Array
    """c (Briggs et al., Eq. 25); shape (n,)."""
    duration: Array
    energy: Array
    surfacings: Array
    """[s, J, 1], shape (n,)."""
    arrived: NDArray[np.bool_]
    """Arrived, shape (n,)."""
    nominal: Array
    """t_nom at the plan's speed, shape (n,) [s]."""
    track: Array
    """As of `TransitRecord`, of the first k trials, shape (2, m, k) [m]."""

    def take(self, trials: slice) -> "PlanTrials":
        """Select trials; without tracks."""
        chosen = {name: values[trials] for name, values in vars(self).items() if name != "track"}
        return PlanTrials(**chosen, track=np.empty((2, 0, 0)))


Score = tuple[float, float]
"""Whether too few trials arrive, 0 or 1, then what is to be least: the first decides, then the second."""
Objective = Callable[[PlanTrials], Score]
"""Function of a plan's trials whose least value is sought."""


def expected_cost(trials: PlanTrials, required: float, values: Array, of: Callable[[Array], Any] = np.mean) -> Score:
    """Score by the mean of what is spent, where too few trials arrive with failures, each as dear as several missions.

    `values`: spent in each trial, positive. `of`: what is taken in place of the mean. So a plan that arrives as often
    as required is better than any that does not, and of those that do not none is dearer for a trial or two that arrive
    by chance.
    """
    least = float(of(values[trials.arrived])) if trials.arrived.any() else math.inf
    if trials.arrived.mean() >= required:
        return 0.0, least
    return 1.0, least * (1.0 + FAILURE_LOSS * float(np.mean(~trials.arrived)))


def run_plans(
    scenario: SweepScenario,
    plans: Sequence[LegsAtSpeed],
    seed: int,
    block: int,
    size: int = BLOCK,
    *,
    case: ErrorScenario = AS_PLANNED,
    tracked: int = 0,
    wrap_compensation: Callable[[Compensation | None], Compensation] | None = None,
) -> Iterator[PlanTrials]:
    """Run every plan on the same trials of a block, a few plans at a time.

    `seed`, `block`, `size`: of the trials. `case`: how the errors differ from the mission's. `tracked`: trials whose
    tracks are kept. `wrap_compensation`: applied to the vehicle's compensation.
    """
    drawn = scenario.means.sampled(seed=seed, block=block, size=size)
    state = scenario.state(drawn, seed, block, size)
    normals, environment = scenario.normals(seed, block), scenario.environment(drawn)
    if any(case.surface):
        environment = replace(environment, effects=(*environment.effects, _AddedDrift(*case.surface)))
    together = 1 if tracked or wrap_compensation else max(TRIALS_TOGETHER // size, 1)
    if wrap_compensation is not None:
        environment = replace(environment, compensation=wrap_compensation(environment.compensation))
    for factor, alike in itertools.groupby(plans, key=lambda legs: legs.speed_factor):
        plan, lengths = scenario.plan(0, drawn, factor), [legs.d_max for legs in alike]
        error = plan.velocity_error
        error = VelocityError(error.mean + np.array(case.mean)[:, None], error.root * case.sigma_factor)
        plan = replace(plan, velocity_error=error)
        for first in range(0, len(lengths), together):
            chosen = lengths[first : first + together]
            if len(chosen) == 1:
                yield _run(replace(plan, d_max=chosen[0]), state, normals, environment, tracked)
            else:  # one block, in which each trial stands once for each plan
                rows = np.tile(np.arange(state.trials), len(chosen))
                tables = [
                    legs if isinstance(legs, LegTable) else LegTable(np.zeros(1), np.array([legs])) for legs in chosen
                ]
                ends = state.trials * np.arange(1, len(chosen) + 1)
                around = replace(
                    environment,
                    current=environment.current.take(rows) if environment.current else None,
                    effects=tuple(effect.take(rows, state.trials) for effect in environment.effects),
                    place=environment.place.take(rows) if environment.place else None,
                )
                run = _run(
                    replace(plan.take(rows), d_max=LegTables(tables, ends)),
                    state.take(rows),
                    replace(normals, rows=rows),
                    around,
                )
                for number in range(len(chosen)):
                    yield run.take(slice(number * state.trials, (number + 1) * state.trials))


def _run(
    plan: TransitPlan, state: TrialState, normals: TransitNormals, environment: Environment, tracked: int = 0
) -> PlanTrials:
    _, record = transit(plan, state, normals, environment, tracked=tracked)
    nominal = plan.nominal_time(state.position)
    return PlanTrials(
        cost=plan.cost(record, nominal),
        duration=record.duration,
        energy=record.energy,
        surfacings=record.surfacings,
        arrived=record.arrived,
        nominal=nominal,
        track=np.empty((2, 0, 0)) if record.track is None else record.track,
    )


def _pilot_trials(scenario: SweepScenario, seed: int, trials: int, plans: Sequence[LegsAtSpeed]) -> list[PlanTrials]:
    """Run some of the plans: a task for one process."""
    return list(run_plans(scenario, plans, seed, PILOT_BLOCK, trials))


def pilot_work(plans: int) -> int:
    """Count the trials that `best_plan` runs for a number of plans, each trial of each plan for itself."""
    work, left = 0, plans
    if not plans:
        return work
    for trials, kept in (*HALVING_RUNGS, (BLOCK, 1)):
        if left > kept or trials == BLOCK:
            work, left = work + trials * left, min(left, kept)
    return work


def best_plan(
    scenario: SweepScenario,
    plans: Sequence[LegsAtSpeed],
    objective: Objective,
    seed: int,
    *,
    advance: Callable[[int], None] | None = None,
    workers: Workers = IN_THIS_PROCESS,
) -> tuple[int, Score]:
    """Find the plan of least objective on a block of pilot trials, by successive halving.

    All plans are screened on the first of the trials, and the best go on to more of them (Jamieson & Talwalkar 2016,
    Non-stochastic best arm identification, AISTATS, with rungs as in `HALVING_RUNGS`): as the trials are common to
    all, differences between plans show long before their costs are known. `advance`, if given, is called with the
    number of trials whenever a plan has been run. Returns the index of the plan, and its objective.
    """
    left: list[int] = list(range(len(plans)))
    values: dict[int, Score] = {}
    for trials, kept in (*HALVING_RUNGS, (BLOCK, 1)):
        if len(left) > kept or trials == BLOCK:
            together = max(TRIALS_TOGETHER // trials, 1)
            parts = [
                [plans[index] for index in left[first : first + together]] for first in range(0, len(left), together)
            ]
            task = partial(_pilot_trials, scenario, seed, trials)
            tried = itertools.chain.from_iterable(workers.run(task, parts))
            values = {}
            for index, run in zip(left, tried, strict=True):
                values[index] = objective(run)
                if advance is not None:
                    advance(trials)
            left = sorted(left, key=values.__getitem__)[:kept]
    return left[0], values[left[0]]
