"""Legs that are best for an aim: the mean time, a deadline, or energy, each by the method that suits it.

- ``mean``: dynamic programming; exact under the assumptions of `expectation`. Where a mission has more, the same
  equation with the spread of legs in pilot trials of the mission.
- ``p95``: dynamic programming would need the time left to the deadline as a second state. Instead a small family of
  policies, best legs for larger and smaller errors and costs of a surfacing, is run on common trials.
- ``energy``: the same dynamic programming with the cost of a metre and of a surfacing in joules, and a search over the
  speed.
"""

from dataclasses import dataclass, replace
from functools import partial
from typing import Literal

import numpy as np
import scipy

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
    expected_cost,
    run_plans,
)
from missionplan.studies.leg_length.plan_result import FoundLegs

Aim = Literal["mean", "p95", "energy"]


DEADLINE_QUANTILE = 0.95
"""Share of the trials that are to arrive by the deadline."""


@dataclass(frozen=True)
class LegAim:
    """What legs are to be best for."""

    name: Aim
    deadline: float = float("inf")
    """For ``p95``: by when the transit is to be done [s]; infinite where the mission has no such requirement."""

    def required(self, scenario: SweepScenario) -> float:
        """Share of the trials that must arrive: as the mission requires, and those whose time is asked for."""
        keeps = self.name == "p95" and not np.isfinite(self.deadline)
        return max(scenario.required_arrival, DEADLINE_QUANTILE if keeps else 0.0)


MEAN_TIME = LegAim("mean")

SPEED_RANGE = (0.3, 1.5)
"""Speeds searched, over the mission's own."""
MEAN_FAMILY = PolicyFamily(SPREAD_FACTORS[:3], ())
"""Tables tried where a mean is least."""
DEADLINE_FAMILY = PolicyFamily()
"""Tables tried for a deadline."""


def plans_of(legs: FoundLegs) -> tuple[LegsAtSpeed, LegsAtSpeed]:
    """Return the best fixed d_max, and the table, at their speed."""
    return LegsAtSpeed(legs.fixed_d_max, legs.speed_factor), LegsAtSpeed(legs.table, legs.speed_factor)


def optimise_legs(
    scenario: SweepScenario,
    aim: LegAim,
    seed: int,
    spread: LegSpread | None = None,
    progress: Progress | None = None,
    workers: Workers = IN_THIS_PROCESS,
) -> FoundLegs:
    """Find the best legs for an aim, of those that arrive as often as the mission requires; else with failures counted.

    `scenario`: with one σ_v, the mission's own. `seed`: of the pilot trials. `spread`: of legs in the pilot trials,
    where it is known already. `progress`: called with (done, total) pilot trials. `workers`: for the pilot trials and
    the best legs of several spreads. Raises InputError when no legs can be planned.
    """
    obstacle = analytic_obstacle(scenario)
    try:
        transit = AnalyticTransit(scenario, LegSpread(scenario.sigma(0), 0.0), scenario.speed, scenario.surfacing_time)
        transit.expected(scenario.distance)  # refuses errors that no legs can cope with
        if obstacle:
            transit = replace(transit, spread=spread or fit_leg_spread(scenario, seed))
        if aim.name == "energy":
            transit = _at_best_speed(transit)
        if aim.name != "p95" and not obstacle:
            how_found = _EXACTLY_FOR_ENERGY if aim.name == "energy" else _EXACTLY
            legs = _optimised(transit, transit.best_fixed(), transit.best_table(), how_found)
            pilots = run_plans(scenario, plans_of(legs), seed, PILOT_BLOCK)  # the equation has no `max_legs`
            if all(trials.arrived.mean() >= scenario.required_arrival for trials in pilots):
                return legs
        family, score, how_found = _family_of(aim, aim.required(scenario))
        d_max, table = search_policies(transit, family, score, seed, progress, workers)
        return _optimised(transit, d_max, table, how_found)
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


def _family_of(aim: LegAim, required: float) -> tuple[PolicyFamily, Objective, str]:
    """Tables that are tried for an aim, what is to be least, and how they are found, in words.

    For ``p95`` the 95 % quantile of the time is least, or the probability of meeting a deadline greatest.
    """

    def mean(trials: PlanTrials) -> Score:
        return expected_cost(trials, required, trials.energy if aim.name == "energy" else 1.0 + trials.cost)

    def lateness(trials: PlanTrials) -> Score:
        arriving = float(np.mean(trials.arrived))
        if np.isfinite(aim.deadline):  # of all trials, so that those that never arrive count already
            in_time = trials.arrived & (trials.duration <= aim.deadline)
            return float(arriving < required), -float(np.mean(in_time))
        level = DEADLINE_QUANTILE / (arriving if arriving >= DEADLINE_QUANTILE else 1.0)
        return expected_cost(trials, required, trials.duration, partial(np.quantile, q=level, method="higher"))

    if aim.name != "p95":
        return MEAN_FAMILY, mean, _EXACTLY_FOR_ENERGY if aim.name == "energy" else _ON_TRIALS
    goal = "the probability of meeting the deadline" if np.isfinite(aim.deadline) else "the 95 % quantile of the time"
    how_found = (
        f"Search for the best {goal} on common trials in a family of policies: best legs of the dynamic programme for "
        f"{len(DEADLINE_FAMILY.spread_factors)} spreads, for the best of them also for other prices of a surfacing, "
        "larger and smaller, with first legs of all lengths, and fixed d_max."
    )
    return DEADLINE_FAMILY, lateness, how_found


def _at_best_speed(transit: AnalyticTransit) -> AnalyticTransit:
    """Count a surfacing as the time under way that takes as much energy, at the speed of least expected energy.

    The speed by Brent's method, golden sections with parabolic interpolation (Brent 1973, Algorithms for Minimization
    without Derivatives, ch. 5).
    """
    scenario = transit.scenario

    def at_speed(speed: float) -> tuple[AnalyticTransit, float]:
        # energy of a second under way and of a surfacing, at a speed [W, J]
        plan = scenario.means.transit_plan(scenario.phase.model_copy(update={"speed": speed}))
        under_way = float(np.mean(plan.power_under_way))
        surfacing = float(np.mean(plan.power_at_surface)) * scenario.surfacing_time
        surfacing += float(np.mean(plan.surfacing_energy))
        if not np.isfinite(under_way + surfacing):
            words = "the aim energy needs a vehicle with hull and energy, and the site's water"
            raise InputError([Problem(words, scenario.mission.file, key="vehicle")])
        if surfacing <= 0.0:
            words = (
                "a surfacing costs no energy, so that legs would be endlessly short: give energy.hotel or .surfacing"
            )
            raise InputError([Problem(words, scenario.mission.file, key="energy")])
        return replace(transit, speed=speed, surfacing_time=surfacing / under_way), under_way

    def energy(speed: float) -> float:
        candidate, per_second = at_speed(speed)
        return candidate.expected(candidate.best_table()).duration * per_second

    slowest, fastest = SPEED_RANGE
    low = max(slowest * scenario.speed, 1.5 * transit.spread.sigma)
    bounds = (low, fastest * scenario.speed)
    optimum = scipy.optimize.minimize_scalar(
        energy, bounds=bounds, method="bounded", options={"xatol": 0.02 * low, "maxiter": 12}
    )
    return at_speed(float(optimum.x))[0]


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
