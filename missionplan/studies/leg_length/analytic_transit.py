"""A transit as the integral equation of its expected cost takes it, where that applies, and the spread of its legs.

Where it does not apply, a family of leg tables is searched for the best one on pilot trials.
"""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import lru_cache, partial

import numpy as np
import scipy
from typing_extensions import override

from missionplan.arrays import Array
from missionplan.montecarlo.blocks import IN_THIS_PROCESS, Progress, Workers, parallel_map
from missionplan.montecarlo.distributions import Distribution, mean_of
from missionplan.phases.transit.compensation import Compensation, CompletedLeg, Memory, PlannedLeg
from missionplan.phases.transit.expectation import MAX_RATIO, TransitExpectation, expected_transit
from missionplan.phases.transit.plan import LegTable
from missionplan.phases.transit.policy import JUMP, best_d_max, best_legs
from missionplan.studies.leg_length import SweepScenario, start_of
from missionplan.studies.leg_length.paired_trials import (
    PILOT_BLOCK,
    LegsAtSpeed,
    Objective,
    Score,
    best_plan,
    pilot_work,
    run_plans,
)


def analytic_obstacle(scenario: SweepScenario) -> str:
    """Return the first property of the mission that the analytic cost does not allow for; empty where there is none."""
    mission, navigation = scenario.mission, scenario.navigation
    (phase,) = (transit for transit in mission.transits if transit.name == scenario.phase.name)
    error = navigation.velocity_error
    places = [place for place in (start_of(mission, phase), phase.to) if isinstance(place, tuple)]
    course = (phase.speed, phase.shaft_rate, phase.arrival_radius, *itertools.chain.from_iterable(places))
    uncertain = (*course, navigation.surfacing_time, *error.mean)
    own_error = () if mission.sweep.sigma else (error.sigma,)
    obstacles = {
        "a current": bool(mission.site and mission.site.current),
        "drift compensation": navigation.drift_compensation != "none",
        "a fix error": navigation.fix_error != 0.0,
        "effects": bool(scenario.means.effects_afloat),
        "a propeller, which takes time to gather way": scenario.plan(0, scenario.means).length_lost is not None,
        "uncertain speed, error, surfacing time or place": any(
            isinstance(quantity, Distribution) for quantity in (*uncertain, *own_error)
        ),
        "a velocity error that is not isotropic": not mission.sweep.sigma and error.isotropic_sigma is None,
        "a velocity error whose mean is not zero": any(mean_of(component) != 0.0 for component in error.mean),
        f"a velocity error over {MAX_RATIO:g} of the speed": any(
            scenario.sigma(index) > MAX_RATIO * scenario.speed for index in range(len(scenario.sigmas))
        ),
    }
    return next((words for words, applies in obstacles.items() if applies), "")


def analytic_curves(scenario: SweepScenario, jobs: int) -> list[tuple[TransitExpectation, ...]]:
    """Solve for the expected transit of every d_max, and of the table after them, for each σ_v, in `jobs` processes."""
    lengths: list[float | LegTable] = [float(d_max) for d_max in scenario.d_max]
    lengths += [scenario.table] if scenario.table is not None else []
    cells = list(itertools.product(range(len(scenario.sigmas)), lengths))
    solved = parallel_map(partial(_expectations, scenario), cells, jobs=jobs)
    return list(zip(*[iter(solved)] * len(lengths), strict=True))


def _expectations(scenario: SweepScenario, cells: Sequence[tuple[int, float | LegTable]]) -> list[TransitExpectation]:
    """Expected transits of given σ_v, by number, and longest legs."""
    course = scenario.speed, scenario.arrival_radius
    return [
        expected_transit(scenario.distance, d_max, *course, scenario.sigma(index), scenario.surfacing_time)
        for index, d_max in cells
    ]


LEARNING_COMPENSATIONS = ("last-leg", "mean", "filter")
"""Drift compensations that estimate the drift from legs made."""
LENGTH_SHARES = (0.05, 0.1, 0.2, 0.35, 0.6, 1.0)
"""Maximum leg lengths of the pilot trials, as shares of the distance."""
BINS = 24
"""Classes of duration, of equal numbers of legs, to which the spread is fitted."""


@dataclass(frozen=True)
class LegSpread:
    """Standard deviation of a leg's end on each axis, √((sigma T)² + base²)."""

    sigma: float
    """Of the velocity, as if drawn anew each leg [m/s]."""
    base: float
    """Of any leg [m]."""


@dataclass
class _RecordingCompensation(Compensation):
    """Compensation that records each leg's planned duration [s] and the square of its miss [m²]."""

    inner: Compensation | None
    durations: list[Array] = field(default_factory=list)
    squared_misses: list[Array] = field(default_factory=list)

    @override
    def begin(self, trials: int) -> Memory:
        inner = self.inner.begin(trials) if self.inner else ()
        return (np.zeros(trials), np.zeros((2, trials)), *inner)

    @override
    def offset(self, memory: Memory, leg: PlannedLeg) -> Array:
        duration, short, *inner = memory
        np.copyto(duration, leg.duration)
        if self.inner is None:
            return np.zeros((2, 1))
        np.copyto(short, self.inner.undershoot(tuple(inner), leg))
        return self.inner.offset(tuple(inner), leg)

    @override
    def update(self, memory: Memory, leg: CompletedLeg) -> Memory:
        duration, short, *inner = memory
        moved = leg.duration > 0.0
        self.durations.append(duration[moved])
        self.squared_misses.append(np.sum((leg.miss + short)[:, moved] ** 2, axis=0))
        return (duration, short, *(self.inner.update(tuple(inner), leg) if self.inner else ()))


def fit_leg_spread(scenario: SweepScenario, seed: int) -> LegSpread:
    """Fit the spread of legs to pilot trials of the mission, with maximum leg lengths from short to the distance.

    Non-negative least squares (Lawson & Hanson 1974, ch. 23) on medians in classes of duration, so that a few outliers
    do not decide; the square of an isotropic normal miss is exponential, its median 2 ln 2 times the variance on each
    axis. A vehicle that estimates its drift from legs made has no estimate on the first leg, which is left out.
    """
    records: list[_RecordingCompensation] = []

    def recorded(compensation: Compensation | None) -> Compensation:
        records.append(_RecordingCompensation(compensation))
        return records[-1]

    plans = [LegsAtSpeed(share * scenario.distance) for share in LENGTH_SHARES]
    list(run_plans(scenario, plans, seed, PILOT_BLOCK, wrap_compensation=recorded))  # for what is recorded
    first = 1 if scenario.navigation.drift_compensation in LEARNING_COMPENSATIONS else 0
    duration = np.concatenate([part for record in records for part in record.durations[first:]])
    squared = np.concatenate([part for record in records for part in record.squared_misses[first:]])
    classes = [part for part in np.array_split(np.argsort(duration, kind="stable"), BINS) if part.size]
    seconds = np.array([np.sqrt(np.mean(duration[part] ** 2)) for part in classes])
    variance = np.array([np.median(squared[part]) for part in classes]) / (2.0 * np.log(2.0))
    weight = 1.0 / np.maximum(variance, 1e-12)
    terms = np.stack([seconds**2, np.ones_like(seconds)], axis=1)
    rate, base = _non_negative(terms * weight[:, None], variance * weight)
    return LegSpread(min(float(np.sqrt(rate)), 0.9 * MAX_RATIO * scenario.speed), float(np.sqrt(base)))


def _non_negative(terms: Array, values: Array) -> Array:
    try:
        return np.asarray(scipy.optimize.nnls(terms, values)[0])
    except ValueError:  # early versions of nnls in Python stop so where nothing is left to free
        return np.asarray(scipy.optimize.lsq_linear(terms, values, bounds=(0.0, np.inf)).x)


_best_legs = lru_cache(maxsize=64)(best_legs)
"""Cached: the same legs are needed by several objectives and for their costs."""


@dataclass(frozen=True)
class AnalyticTransit:
    """A transit whose legs end within a known spread of where they aim."""

    scenario: SweepScenario
    spread: LegSpread
    speed: float
    """Speed [m/s]."""
    surfacing_time: float
    """Cost of a surfacing, as time under way [s]."""

    @property
    def speed_factor(self) -> float:
        """Its speed over the mission's own."""
        return self.speed / self.scenario.speed

    def best_table(self, spread_factor: float = 1.0, surfacing_factor: float = 1.0) -> LegTable:
        """Best legs for a larger or smaller spread and cost of a surfacing, to 0.1 m, as mission files write them."""
        table = _best_legs(*self._arguments(spread_factor, surfacing_factor)).legs
        left, leg = np.round(table.left, 1), np.maximum(np.round(table.leg, 1), 0.1)
        kept = np.append(True, np.diff(left) > 0.0)  # of knots that coincide one
        return LegTable(left[kept], leg[kept])

    def least_cost(self) -> float:
        """Least expected cost of any legs."""
        return _best_legs(*self._arguments()).bound

    def best_fixed(self) -> float:
        """Best fixed d_max [m]."""
        return best_d_max(*self._arguments())[0]

    def expected(self, d_max: float | LegTable) -> TransitExpectation:
        """Solve for the expected transit."""
        distance, *others = self._arguments()
        return expected_transit(distance, d_max, *others)

    def _arguments(
        self, spread_factor: float = 1.0, surfacing_factor: float = 1.0
    ) -> tuple[float, float, float, float, float, float]:
        return (
            self.scenario.distance,
            self.speed,
            self.scenario.arrival_radius,
            self.spread.sigma * spread_factor,
            self.surfacing_time * surfacing_factor,
            self.spread.base * spread_factor,
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

    Raises ValueError when no legs can cope with the errors.
    """
    distance = transit.scenario.distance
    lengths = [round(float(share * distance), 1) for share in FIXED_LENGTHS]
    swept = [round(float(length), 1) for length in transit.scenario.d_max]
    radius = np.array([transit.scenario.arrival_radius])
    fixed = [LegTable(radius, np.array([length])) for length in sorted({*lengths, *swept})]
    tried = (1 + len(lengths)) * np.array([len(family.spread_factors), len(family.surfacing_factors)])
    work, done = sum(map(pilot_work, (len(fixed), *tried.tolist()))), 0

    def advance(trials: int) -> None:
        nonlocal done
        done += trials
        if progress is not None:
            progress(done, work)

    def best_of(tables: Sequence[LegTable]) -> tuple[Score, int]:
        plans = [LegsAtSpeed(table, transit.speed_factor) for table in tables]
        index, least = best_plan(transit.scenario, plans, objective, seed, advance=advance, workers=workers)
        return least, index

    def best_variant(factors: Sequence[tuple[float, float]]) -> tuple[Score, float, LegTable]:
        policies = _policies(transit, factors, lengths, workers)
        least, index = best_of([table for _, table in policies])
        return least, *policies[index]

    fixed_value, index = best_of(fixed)
    constant = fixed[index]
    value, spread, table = best_variant([(factor, 1.0) for factor in family.spread_factors])
    if family.surfacing_factors:
        other, _, variant = best_variant([(spread, factor) for factor in family.surfacing_factors])
        value, table = (other, variant) if other < value else (value, table)
    return float(constant.leg[0]), table if value < fixed_value else constant


def _policies(
    transit: AnalyticTransit, factors: Sequence[tuple[float, float]], lengths: Sequence[float], workers: Workers
) -> list[tuple[float, LegTable]]:
    """Best legs for factors on spread and cost of a surfacing, with their own first leg or another, by their spread."""
    solved = list(workers.run(partial(_best_table, transit), factors))
    # errors that no legs can cope with are left out
    best = [(spread, table) for (spread, _), table in zip(factors, solved, strict=True) if not isinstance(table, str)]
    if not best:
        raise ValueError(solved[-1])
    return [
        (spread, variant)
        for spread, table in best
        for variant in (table, *(replace_first_leg(table, transit.scenario.distance, length) for length in lengths))
    ]


def replace_first_leg(table: LegTable, distance: float, length: float) -> LegTable:
    """Set the leg near the whole distance, with a jump of `JUMP` below."""
    edge = round(FIRST_LEG_SHARE * distance, 1)
    nearer = table.left < edge
    left = np.append(table.left[nearer], [edge, edge + JUMP])
    return LegTable(left, np.append(table.leg[nearer], [np.round(table(np.array([edge]))[0], 1), length]))


def _best_table(transit: AnalyticTransit, factors: tuple[float, float]) -> LegTable | str:
    """Best legs for factors on spread and cost of a surfacing, or why there are none: a task for one process."""
    try:
        return transit.best_table(*factors)
    except ValueError as error:
        return str(error)
