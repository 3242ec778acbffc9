"""What legs are chosen for: the mean time, a deadline, or energy, each by the method that suits it.

- ``mean``: dynamic programming; exact under the assumptions of `expectation`. Where a mission has more, the same
  equation with the spread that a pilot of the mission shows.
- ``p95``: the time left to the deadline would have to join the state. Instead a small family of policies, best legs
  for errors and prices of a surfacing larger and smaller than they are, is run on common trials.
- ``energy``: the same dynamic programming with prices a metre and a surfacing in joules, and a search over the speed.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Literal, get_args

import numpy as np
from scipy.optimize import minimize_scalar

from missionplan.arrays import Array
from missionplan.errors import InputError, Problem
from missionplan.phases.transit.analytic.bellman import JUMP
from missionplan.phases.transit.analytic.expectation import TransitExpectation, expected_transit
from missionplan.phases.transit.analytic.policy import best_d_max, best_legs
from missionplan.phases.transit.leg_table import LegTable
from missionplan.studies.leg_length.leg_spread import LegSpread, fit_leg_spread
from missionplan.studies.leg_length.paired_trials import LegsAtSpeed, PlanTrials, Score, best_plan
from missionplan.studies.leg_length.sweep_scenario import SweepScenario

Aim = Literal["mean", "p95", "energy"]
AIMS: tuple[Aim, ...] = get_args(Aim)

DEADLINE_QUANTILE = 0.95
"""Of the trials that are to arrive by the deadline."""
SPREADS, PRICES = (0.7, 1.0, 1.4, 2.0), (0.6, 1.7)
"""Family of policies: factors on the spread that the best legs reckon with, then on the price of a surfacing."""
FIXED = np.linspace(0.05, 1.0, 58)
"""Fixed d_max tried on trials, of the distance."""
FIRST = 0.97
"""Share of the distance beyond which a leg is the first."""
SLOWEST, FASTEST = 0.3, 1.5
"""Speeds searched, of the mission's own."""

PolicyMember = tuple[float, LegTable]
"""Factor on the spread, and the legs that reckon with it."""


@dataclass(frozen=True)
class OptimisedLegs:
    """Legs for an aim.

    Attributes
    ----------
    fixed, adaptive : LegsAtSpeed
        Best fixed d_max and the table, at the speed chosen.
    spread : LegSpread
        Reckoned with.
    fixed_cost, adaptive_cost, one_leg_cost, least_cost : float
        Expected c (Briggs et al., Eq. 25) at that speed with that spread, from the integral equation; the last of any
        legs.
    surfacings : float
        Expected number of the table, the arrival's included.
    how_found : str
        How the table was found, in a sentence.
    """

    fixed: LegsAtSpeed
    adaptive: LegsAtSpeed
    spread: LegSpread
    fixed_cost: float
    adaptive_cost: float
    one_leg_cost: float
    least_cost: float
    surfacings: float
    how_found: str


@dataclass(frozen=True)
class _Problem:
    """A transit in the terms of the integral equation, at some speed, with a price of a surfacing in seconds."""

    scenario: SweepScenario
    spread: LegSpread
    speed: float
    surfacing_time: float

    def best(self, spread: float = 1.0, price: float = 1.0) -> LegTable:
        """Best legs, reckoning with factors on spread and price."""
        return _rounded_table(_policy(*self._arguments(spread, price)).legs)

    def least_cost(self) -> float:
        """Least expected cost of any legs."""
        return _policy(*self._arguments(1.0, 1.0)).bound

    def best_fixed(self) -> float:
        """Best fixed d_max [m]."""
        return best_d_max(*self._arguments(1.0, 1.0))[0]

    def expected(self, d_max: float | LegTable) -> TransitExpectation:
        """Solve for the expected transit."""
        distance, *others = self._arguments(1.0, 1.0)
        return expected_transit(distance, d_max, *others)

    def _arguments(self, spread: float, price: float) -> tuple[float, float, float, float, float, float]:
        return (
            self.scenario.distance,
            self.speed,
            self.scenario.arrival_radius,
            self.spread.sigma * spread,
            self.surfacing_time * price,
            self.spread.base * spread,
        )


_policy = lru_cache(maxsize=64)(best_legs)
"""Best legs, kept: the same are asked for by the aim, by its rivals and by their costs."""


def optimise_legs(
    scenario: SweepScenario, aim: Aim, deadline: float, seed: int, spread: LegSpread | None = None
) -> OptimisedLegs:
    """Choose legs for an aim.

    Parameters
    ----------
    scenario : SweepScenario
        With one σ_v, the mission's own.
    aim : {'mean', 'p95', 'energy'}
    deadline : float
        For ``p95``: by when the transit is to be done [s]; infinite where the mission does not say.
    seed : int
        Of the pilot.
    spread : LegSpread, optional
        To reckon with, where another choice has measured it already.

    Raises
    ------
    InputError
        When no legs can be planned.
    """
    obstacle = scenario.analytic_obstacle()
    try:
        stated = LegSpread(scenario.sigma(0), 0.0)
        problem = _Problem(scenario, stated, scenario.speed, scenario.surfacing_time)
        problem.expected(scenario.distance)  # refuses errors that no legs can cope with
        if obstacle:
            problem = replace(problem, spread=spread or fit_leg_spread(scenario, seed))
        if aim == "energy":
            return _for_energy(problem, seed, on_trials=bool(obstacle))
        if aim == "p95":
            return _for_deadline(problem, deadline, seed)
        if obstacle:
            how = (
                "Dynamic programming with the spread of legs that a pilot of the mission's own trials shows, and such "
                "legs for other spreads and with other first legs, chosen on common trials."
            )
            return _on_trials(problem, SPREADS[:3], (), _mean_time, seed, how)
        how = "Dynamic programming over the distance left: exact for isotropic errors drawn anew for each leg."
        return _optimised_legs(problem, problem.best_fixed(), problem.best(), how)
    except ValueError as error:
        raise InputError([Problem(str(error), scenario.mission.file, key=scenario.phase.name)]) from error


def _for_deadline(problem: _Problem, deadline: float, seed: int) -> OptimisedLegs:
    """Least 95 % quantile of the time, or greatest probability of meeting a deadline, in a family of policies."""

    def late(run: PlanTrials) -> float:
        time = np.where(run.arrived, run.duration, np.inf)
        if np.isfinite(deadline):
            return -float(np.mean(time <= deadline))
        return float(np.quantile(time, DEADLINE_QUANTILE, method="higher"))

    goal = "the probability of meeting the deadline" if np.isfinite(deadline) else "the 95 % quantile of the time"
    how = (
        f"Search for the best {goal} on common trials in a family of policies: best legs of the dynamic programme for "
        f"{len(SPREADS)} spreads, for the best of them also for other prices of a surfacing, larger and smaller, with "
        "first legs of all lengths, and fixed d_max."
    )
    return _on_trials(problem, SPREADS, PRICES, late, seed, how)


def _for_energy(problem: _Problem, seed: int, *, on_trials: bool) -> OptimisedLegs:
    """Least expected energy: a surfacing costs joules, a metre costs joules, and the speed is chosen too."""
    scenario = problem.scenario

    def at(speed: float) -> tuple[_Problem, float]:
        per_second, per_surfacing = _prices(scenario, speed)
        return replace(problem, speed=speed, surfacing_time=per_surfacing / per_second), per_second

    def energy(speed: float) -> float:
        priced, per_second = at(speed)
        return priced.expected(priced.best()).duration * per_second

    low = max(SLOWEST * scenario.speed, 1.5 * problem.spread.sigma)
    bounds = (low, FASTEST * scenario.speed)
    found = minimize_scalar(energy, bounds=bounds, method="bounded", options={"xatol": 0.02 * low, "maxiter": 12})
    priced, _ = at(float(found.x))
    how = (
        "Dynamic programming with prices of a metre and of a surfacing in joules, and a search over the speed "
        f"from {SLOWEST:g} to {FASTEST:g} times the mission's."
    )
    if on_trials:
        return _on_trials(priced, SPREADS[:3], (), lambda run: _mean(run, run.energy), seed, how)
    return _optimised_legs(priced, priced.best_fixed(), priced.best(), how)


def _prices(scenario: SweepScenario, speed: float) -> tuple[float, float]:
    """Energy of a second under way and of a surfacing, at a speed [W, J]."""
    path = f"{scenario.phase.name}.speed"
    plan = replace(scenario.means, draws={**scenario.means.draws, path: speed}).transit_plan(scenario.phase)
    under_way = float(np.mean(plan.power_under_way))
    surfacing = float(np.mean(plan.power_at_surface)) * scenario.surfacing_time + float(np.mean(plan.surfacing_energy))
    if not np.isfinite(under_way + surfacing):
        words = "the aim energy needs a vehicle with hull and energy, and the site's water"
        raise InputError([Problem(words, scenario.mission.file, key="vehicle")])
    if surfacing <= 0.0:
        words = "a surfacing costs no energy, so that legs would be endlessly short: give energy.hotel or .surfacing"
        raise InputError([Problem(words, scenario.mission.file, key="energy")])
    return under_way, surfacing


def _on_trials(
    problem: _Problem, spreads: Sequence[float], prices: Sequence[float], score: Score, seed: int, how_found: str
) -> OptimisedLegs:
    """Best member of a family and best fixed d_max on the same pilot trials.

    Spreads are tried at the true price, then prices at the best spread. Each table is tried with first legs of every
    length too: on the first leg nothing has been learnt of the drift. The fixed lengths are members themselves.
    """
    distance, radius = problem.scenario.distance, problem.scenario.arrival_radius
    lengths, factor = [round(float(share * distance), 1) for share in FIXED], problem.speed / problem.scenario.speed

    def tried_best(tables: Sequence[LegTable]) -> tuple[int, float]:
        return best_plan(problem.scenario, [LegsAtSpeed(table, factor) for table in tables], score, seed)

    def best_of(members: Sequence[PolicyMember]) -> tuple[float, PolicyMember]:
        tried = [
            (spread, each)
            for spread, table in members
            for each in (table, *(replace_first_leg(table, distance, length) for length in lengths))
        ]
        place, least = tried_best([table for _, table in tried])
        return least, tried[place]

    fixed = [LegTable(np.array([radius]), np.array([length])) for length in lengths]
    place, least = tried_best(fixed)
    (lowest, (spread, table)) = best_of(_tables(problem, [(each, 1.0) for each in spreads]))
    if prices:
        priced = _tables(problem, [(spread, price) for price in prices])
        lowest, (spread, table) = min((lowest, (spread, table)), best_of(priced), key=lambda found: found[0])
    return _optimised_legs(problem, lengths[place], table if lowest < least else fixed[place], how_found)


def replace_first_leg(table: LegTable, distance: float, length: float) -> LegTable:
    """Give a table another leg near the whole distance, with a jump of `JUMP` below."""
    edge = round(FIRST * distance, 1)
    nearer = table.left < edge
    left = np.append(table.left[nearer], [edge, edge + JUMP])
    return LegTable(left, np.append(table.leg[nearer], [np.round(table(np.array([edge]))[0], 1), length]))


def _tables(problem: _Problem, family: Sequence[tuple[float, float]]) -> list[PolicyMember]:
    """Best legs of each member; those for errors that no legs can cope with are left out."""
    tables, refusal = [], ""
    for spread, price in family:
        try:
            tables.append((spread, problem.best(spread, price)))
        except ValueError as error:
            refusal = str(error)
    if not tables:
        raise ValueError(refusal)
    return tables


def _optimised_legs(problem: _Problem, d_max: float, table: LegTable, how_found: str) -> OptimisedLegs:
    timed = replace(problem, surfacing_time=problem.scenario.surfacing_time)
    transit = timed.expected(table)
    factor = problem.speed / problem.scenario.speed
    return OptimisedLegs(
        fixed=LegsAtSpeed(d_max, factor),
        adaptive=LegsAtSpeed(table, factor),
        spread=problem.spread,
        fixed_cost=timed.expected(d_max).cost,
        adaptive_cost=transit.cost,
        one_leg_cost=timed.expected(problem.scenario.distance).cost,
        least_cost=timed.least_cost(),
        surfacings=transit.surfacings,
        how_found=how_found,
    )


def _mean_time(run: PlanTrials) -> float:
    return _mean(run, run.duration)


def _mean(run: PlanTrials, values: Array) -> float:
    """Mean over the trials that arrive, the more the fewer do."""
    share = float(np.mean(run.arrived))
    return float(np.mean(values[run.arrived])) / share if share else float("inf")


def _rounded_table(legs: LegTable) -> LegTable:
    """Round a table as mission files write it, to 0.1 m; knots that fall together are left out."""
    left, leg = np.round(legs.left, 1), np.maximum(np.round(legs.leg, 1), 0.1)
    kept = np.append(True, np.diff(left) > 0.0)
    return LegTable(left[kept], leg[kept])
