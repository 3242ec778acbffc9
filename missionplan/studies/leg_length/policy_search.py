"""Search of a family of leg tables for the best one on pilot trials, where the integral equation does not apply."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from missionplan.montecarlo.parallel.blocks import IN_THIS_PROCESS, Progress, Workers
from missionplan.phases.transit.analytic.policy import JUMP
from missionplan.phases.transit.plan import LegTable
from missionplan.studies.leg_length.analytic_transit import AnalyticTransit
from missionplan.studies.leg_length.paired_trials import (
    LegsAtSpeed,
    Objective,
    Score,
    best_plan,
    pilot_work,
)

SPREAD_FACTORS = (0.7, 1.0, 1.4, 2.0)
"""Factors on the spread for which best legs are tried."""
SURFACING_FACTORS = (0.6, 1.7)
"""Factors on the cost of a surfacing for which best legs are tried."""
FIXED_LENGTHS = np.linspace(0.05, 1.0, 58)
"""Fixed d_max that are tried, besides those of the mission's sweep, as shares of the distance."""
FIRST_LEG_SHARE = 0.97
"""Share of the distance beyond which a leg is the first."""


@dataclass(frozen=True)
class PolicyFamily:
    """Leg tables that are tried."""

    spread_factors: Sequence[float] = SPREAD_FACTORS
    """Tried at the true cost of a surfacing."""
    surfacing_factors: Sequence[float] = SURFACING_FACTORS
    """Tried for the best spread."""


@dataclass(frozen=True)
class _Policy:
    """A leg table and the factor on the spread that it is best for."""

    spread_factor: float
    table: LegTable


@dataclass
class _Search:
    """Best plans on the pilot trials, with a count of the trials for a progress bar."""

    transit: AnalyticTransit
    objective: Objective
    seed: int
    progress: Progress | None
    work: int
    workers: Workers
    done: int = 0

    def best_of(self, policies: Sequence[_Policy]) -> tuple[Score, _Policy]:
        """Find the best of some policies, with its score."""
        plans = [LegsAtSpeed(policy.table, self.transit.speed_factor) for policy in policies]
        index, least = best_plan(
            self.transit.scenario, plans, self.objective, self.seed, advance=self._advance, workers=self.workers
        )
        return least, policies[index]

    def _advance(self, trials: int) -> None:
        self.done += trials
        if self.progress is not None:
            self.progress(self.done, self.work)


def search_policies(
    transit: AnalyticTransit,
    family: PolicyFamily,
    objective: Objective,
    seed: int,
    progress: Progress | None = None,
    workers: Workers = IN_THIS_PROCESS,
) -> tuple[float, LegTable]:
    """Find the best fixed d_max [m] and the best table of a family, on the same pilot trials.

    Each table is also tried with first legs of every length: on the first leg nothing has been learnt of the drift.
    Where no table does better, the best fixed length is the table. `progress` is told the trials run of all.

    Raises
    ------
    ValueError
        When no legs can cope with the errors.
    """
    distance = transit.scenario.distance
    lengths = [round(float(share * distance), 1) for share in FIXED_LENGTHS]
    swept = [round(float(length), 1) for length in transit.scenario.d_max]
    radius = np.array([transit.scenario.arrival_radius])
    fixed = [_Policy(1.0, LegTable(radius, np.array([length]))) for length in sorted({*lengths, *swept})]
    variants = len(lengths) + 1
    work = sum(
        pilot_work(plans)
        for plans in (len(fixed), variants * len(family.spread_factors), variants * len(family.surfacing_factors))
    )
    search = _Search(transit, objective, seed, progress, work, workers)

    def best_variant(policies: Sequence[_Policy]) -> tuple[Score, _Policy]:
        return search.best_of([variant for policy in policies for variant in _variants(policy, distance, lengths)])

    fixed_value, constant = search.best_of(fixed)
    value, policy = best_variant(_policies(transit, [(factor, 1.0) for factor in family.spread_factors], workers))
    if family.surfacing_factors:
        others = _policies(transit, [(policy.spread_factor, factor) for factor in family.surfacing_factors], workers)
        value, policy = min((value, policy), best_variant(others), key=lambda found: found[0])
    return float(constant.table.leg[0]), policy.table if value < fixed_value else constant.table


def _variants(policy: _Policy, distance: float, lengths: Sequence[float]) -> list[_Policy]:
    """A policy, and the same with every first leg."""
    changed = [_Policy(policy.spread_factor, replace_first_leg(policy.table, distance, length)) for length in lengths]
    return [policy, *changed]


def replace_first_leg(table: LegTable, distance: float, length: float) -> LegTable:
    """Set the leg near the whole distance, with a jump of `JUMP` below."""
    edge = round(FIRST_LEG_SHARE * distance, 1)
    nearer = table.left < edge
    left = np.append(table.left[nearer], [edge, edge + JUMP])
    return LegTable(left, np.append(table.leg[nearer], [np.round(table(np.array([edge]))[0], 1), length]))


def _policies(transit: AnalyticTransit, factors: Sequence[tuple[float, float]], workers: Workers) -> list[_Policy]:
    """Best legs for factors on spread and cost of a surfacing, without those for errors that no legs can cope with."""
    found = list(workers.run(partial(_policy, transit), factors))
    policies = [policy for policy in found if isinstance(policy, _Policy)]
    if not policies:
        raise ValueError(found[-1] if found else "")
    return policies


def _policy(transit: AnalyticTransit, factors: tuple[float, float]) -> _Policy | str:
    """Best legs for factors on spread and cost of a surfacing, or why there are none: a task for one process."""
    try:
        return _Policy(factors[0], transit.best_table(*factors))
    except ValueError as error:
        return str(error)
