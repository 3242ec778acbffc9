"""Legs that are best for an aim: the mean time, a deadline, or energy, each by the method that suits it.

- ``mean``: dynamic programming; exact under the assumptions of `expectation`. Where a mission has more, the same
  equation with the spread of legs in pilot trials of the mission.
- ``p95``: dynamic programming would need the time left to the deadline as a second state. Instead a small family of
  policies, best legs for larger and smaller errors and costs of a surfacing, is run on common trials.
- ``energy``: the same dynamic programming with the cost of a metre and of a surfacing in joules, and a search over the
  speed.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from operator import attrgetter
from typing import Literal

import numpy as np
import scipy

from missionplan.arrays import Array
from missionplan.errors import InputError, Problem
from missionplan.montecarlo.blocks import IN_THIS_PROCESS, Progress, Workers
from missionplan.phases.transit.plan import LegTable
from missionplan.studies.leg_length import SweepScenario
from missionplan.studies.leg_length.analytic_transit import (
    SPREAD_FACTORS,
    AnalyticTransit,
    LegSpread,
    PolicyFamily,
    analytic_obstacle,
    fit_leg_spread,
    search_policies,
)
from missionplan.studies.leg_length.paired_trials import (
    PILOT_BLOCK,
    LegsAtSpeed,
    Objective,
    PlanTrials,
    Score,
    arrival_shortfall,
    run_plans,
)
from missionplan.studies.leg_length.plan_result import FoundLegs

Aim = Literal["mean", "p95", "energy"]


@dataclass(frozen=True)
class LegAim:
    """What legs are to be best for."""

    name: Aim
    deadline: float = float("inf")
    """For ``p95``: by when the transit is to be done [s]; infinite where the mission has no such requirement."""


MEAN_TIME = LegAim("mean")

DEADLINE_QUANTILE = 0.95
"""Share of the trials that are to arrive by the deadline."""
SPEED_RANGE = (0.3, 1.5)
"""Speeds searched, over the mission's own."""
MEAN_FAMILY = PolicyFamily(SPREAD_FACTORS[:3], ())
"""Tables tried where a mean is least."""
DEADLINE_FAMILY = PolicyFamily()
"""Tables tried for a deadline."""


@dataclass(frozen=True)
class _Pilot:
    """Pilot trials: seed, progress bar, whether legs must be chosen on them, not by the equation alone, and workers."""

    seed: int
    progress: Progress | None
    is_needed: bool
    workers: Workers


def plans_of(found: FoundLegs) -> tuple[LegsAtSpeed, LegsAtSpeed]:
    """Return the best fixed d_max, and the table, at their speed."""
    return LegsAtSpeed(found.fixed_d_max, found.speed_factor), LegsAtSpeed(found.table, found.speed_factor)


def optimise_legs(
    scenario: SweepScenario,
    aim: LegAim,
    seed: int,
    spread: LegSpread | None = None,
    progress: Progress | None = None,
    workers: Workers = IN_THIS_PROCESS,
) -> FoundLegs:
    """Find the best legs for an aim, among those that arrive as often as the mission requires; else the likeliest to.

    `scenario`: with one σ_v, the mission's own. `seed`: of the pilot trials. `spread`: of legs in the pilot trials,
    where it is known already. `progress`: called with (done, total) pilot trials. `workers`: for the pilot trials and
    the best legs of several spreads. Raises InputError when no legs can be planned.
    """
    obstacle = analytic_obstacle(scenario)
    pilot = _Pilot(seed, progress, bool(obstacle), workers)
    try:
        transit = AnalyticTransit(scenario, LegSpread(scenario.sigma(0), 0.0), scenario.speed, scenario.surfacing_time)
        transit.expected(scenario.distance)  # refuses errors that no legs can cope with
        if obstacle:
            transit = replace(transit, spread=spread or fit_leg_spread(scenario, seed))
        if aim.name == "energy":
            how_found = _EXACTLY_FOR_ENERGY
            return _least_mean(_at_best_speed(transit), pilot, attrgetter("energy"), how_found, how_found)
        if aim.name == "p95":
            return _for_deadline(transit, aim.deadline, pilot)
        return _least_mean(transit, pilot, attrgetter("cost"), _EXACTLY, _ON_TRIALS)
    except ValueError as error:
        raise InputError([Problem(str(error), scenario.mission.file, key=scenario.phase.name)]) from error


_EXACTLY = "Dynamic programming over the distance left: exact for isotropic errors drawn anew for each leg."
_ON_TRIALS = (
    "Dynamic programming with the spread of legs that a pilot of the mission's own trials shows, and such legs for "
    "other spreads and with other first legs, chosen on common trials."
)
_EXACTLY_FOR_ENERGY = (
    "Dynamic programming with prices of a metre and of a surfacing in joules, and a search over the speed from "
    f"{SPEED_RANGE[0]:g} to {SPEED_RANGE[1]:g} times the mission's."
)


def _least_mean(
    transit: AnalyticTransit, pilot: _Pilot, values: Callable[[PlanTrials], Array], exactly: str, on_trials: str
) -> FoundLegs:
    """Least mean of a cost: by the equation alone where it holds and the legs arrive as often as required in trials."""
    if not pilot.is_needed:
        found = _optimised(transit, transit.best_fixed(), transit.best_table(), exactly)
        if _arrive(transit.scenario, found, pilot.seed):
            return found

    def score(trials: PlanTrials) -> Score:
        mean = float(np.mean(values(trials)[trials.arrived])) if trials.arrived.any() else float("inf")
        return arrival_shortfall(trials, transit.scenario.required_arrival), mean

    return _on_trials(transit, MEAN_FAMILY, score, pilot, on_trials)


def _for_deadline(transit: AnalyticTransit, deadline: float, pilot: _Pilot) -> FoundLegs:
    """Least 95 % quantile of the time, or greatest probability of meeting a deadline, in a family of policies."""
    required = transit.scenario.required_arrival

    def lateness(trials: PlanTrials) -> Score:
        time = np.where(trials.arrived, trials.duration, np.inf)
        if np.isfinite(deadline):  # of all trials, so that those that never arrive count already
            return 0.0, -float(np.mean(time <= deadline))
        return arrival_shortfall(trials, required), float(np.quantile(time, DEADLINE_QUANTILE, method="higher"))

    family = DEADLINE_FAMILY
    goal = "the probability of meeting the deadline" if np.isfinite(deadline) else "the 95 % quantile of the time"
    how_found = (
        f"Search for the best {goal} on common trials in a family of policies: best legs of the dynamic programme for "
        f"{len(family.spread_factors)} spreads, for the best of them also for other prices of a surfacing, larger and "
        "smaller, with first legs of all lengths, and fixed d_max."
    )
    return _on_trials(transit, family, lateness, pilot, how_found)


def _at_best_speed(transit: AnalyticTransit) -> AnalyticTransit:
    """Count a surfacing as the time under way that takes as much energy, at the speed of least expected energy.

    The speed by Brent's method, golden sections with parabolic interpolation (Brent 1973, Algorithms for Minimization
    without Derivatives, ch. 5).
    """
    scenario = transit.scenario

    def at_speed(speed: float) -> tuple[AnalyticTransit, float]:
        per_second, per_surfacing = _energy_rates(scenario, speed)
        return replace(transit, speed=speed, surfacing_time=per_surfacing / per_second), per_second

    def energy(speed: float) -> float:
        candidate, per_second = at_speed(speed)
        return candidate.expected(candidate.best_table()).duration * per_second

    slowest, fastest = SPEED_RANGE
    low = max(slowest * scenario.speed, 1.5 * transit.spread.sigma)
    bounds = (low, fastest * scenario.speed)
    found = scipy.optimize.minimize_scalar(
        energy, bounds=bounds, method="bounded", options={"xatol": 0.02 * low, "maxiter": 12}
    )
    return at_speed(float(found.x))[0]


def _energy_rates(scenario: SweepScenario, speed: float) -> tuple[float, float]:
    """Energy of a second under way and of a surfacing, at a speed [W, J]."""
    plan = scenario.means.transit_plan(scenario.phase.model_copy(update={"speed": speed}))
    under_way = float(np.mean(plan.power_under_way))
    surfacing = float(np.mean(plan.power_at_surface)) * scenario.surfacing_time + float(np.mean(plan.surfacing_energy))
    if not np.isfinite(under_way + surfacing):
        words = "the aim energy needs a vehicle with hull and energy, and the site's water"
        raise InputError([Problem(words, scenario.mission.file, key="vehicle")])
    if surfacing <= 0.0:
        words = "a surfacing costs no energy, so that legs would be endlessly short: give energy.hotel or .surfacing"
        raise InputError([Problem(words, scenario.mission.file, key="energy")])
    return under_way, surfacing


def _arrive(scenario: SweepScenario, found: FoundLegs, seed: int) -> bool:
    """Whether both plans arrive as often as required in the pilot trials: the integral equation has no `max_legs`."""
    pilots = run_plans(scenario, plans_of(found), seed, PILOT_BLOCK)
    return all(arrival_shortfall(trials, scenario.required_arrival) == 0.0 for trials in pilots)


def _on_trials(
    transit: AnalyticTransit, family: PolicyFamily, objective: Objective, pilot: _Pilot, how_found: str
) -> FoundLegs:
    d_max, table = search_policies(transit, family, objective, pilot.seed, pilot.progress, pilot.workers)
    return _optimised(transit, d_max, table, how_found)


def _optimised(transit: AnalyticTransit, d_max: float, table: LegTable, how_found: str) -> FoundLegs:
    """Add the expected costs, in time."""
    timed = replace(transit, surfacing_time=transit.scenario.surfacing_time)
    adaptive = timed.expected(table)
    return FoundLegs(
        how_found=how_found,
        speed_factor=transit.speed_factor,
        planned_sigma=transit.spread.sigma,
        base_spread=transit.spread.base,
        left=table.left,
        leg=table.leg,
        expected_cost=adaptive.cost,
        least_cost=timed.least_cost(),
        expected_surfacings=adaptive.surfacings,
        fixed_d_max=d_max,
        fixed_cost=timed.expected(d_max).cost,
        one_leg_cost=timed.expected(transit.scenario.distance).cost,
    )
