"""How long should legs be? The transit with its velocity errors and leg lengths, and a block of its trials for all.

One d_max for all (`sweep_dmax`), or a table against the distance left (`plan_legs`). Read then `analytic_transit` (its
expected cost, and families of tables), `paired_trials` and `optimise_legs`.
"""

import itertools
import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array, Scalars
from missionplan.errors import InputError, Problem
from missionplan.mission import Mission
from missionplan.mission.schema import V
from missionplan.mission.schema.phases import LegTableSection, Navigation, TransitPhase
from missionplan.mission.schema.place import Position
from missionplan.mission.views import navigation_of
from missionplan.montecarlo.distributions import mean_of
from missionplan.montecarlo.statistics import Moments
from missionplan.montecarlo.streams import BlockStreams
from missionplan.phases.hooks import TrialState
from missionplan.phases.transit import transit
from missionplan.phases.transit.plan import Environment, LegTable, TransitNormals, TransitPlan, VelocityError, column
from missionplan.physics.propulsion import JOULES_PER_WATT_HOUR
from missionplan.scenario.phases import deployed, transit_normals
from missionplan.scenario.scenario import Scenario, leg_table
from missionplan.scenario.site_current import recorded_current
from missionplan.studies.simulation import check_cover

GROUP = 16
"""Trials in a group. What is left of a block over whole groups is not used for differences."""
MAX_PAIRED = 1000
"""Largest number of d_max for which covariances are kept; beyond, differences ignore the common random numbers."""
_FEWEST_GROUPS = 8


@dataclass(frozen=True)
class CellTotals:
    """Merged trials of k values of d_max."""

    cost: Moments
    surfacings: Moments
    """Of the trials that arrived; `missing` counts the others, shape (k,)."""
    groups: int
    """Groups of trials in the two sums below."""
    sums: Array
    """Sum of the groups' means of the cost about a fixed reference, shape (k,)."""
    products: Array
    """Sum of their products; shape (0, 0) where there are too many d_max."""

    def merge(self, other: "CellTotals") -> "CellTotals":
        """Add the next block."""
        return CellTotals(
            self.cost.merge(other.cost),
            self.surfacings.merge(other.surfacings),
            self.groups + other.groups,
            self.sums + other.sums,
            self.products + other.products,
        )

    def first(self, cells: int) -> "CellTotals":
        """Return the first cells alone."""
        kept = slice(None, cells)
        return CellTotals(
            self.cost.take(kept), self.surfacings.take(kept), self.groups, self.sums[kept], self.products[kept, kept]
        )

    @property
    def arrived(self) -> Array:
        """Fraction of the trials that arrived, shape (k,)."""
        return np.asarray(self.cost.count / (self.cost.count + self.cost.missing))

    def difference_error(self, reference: int) -> Array:
        """Standard error of each mean cost minus that of one d_max, shape (k,).

        Paired where all trials of both arrived; else, and for few trials, as for independent trials.
        """
        error = self.cost.standard_error
        unpaired: Array = np.hypot(error, error[reference])
        unpaired[reference] = 0.0
        if not self.products.size or self.groups < _FEWEST_GROUPS:
            return unpaired
        variance = np.diag(self.products) + self.products[reference, reference] - 2.0 * self.products[reference]
        variance = variance - (self.sums - self.sums[reference]) ** 2 / self.groups
        paired = np.sqrt(np.maximum(variance, 0.0) / (self.groups * (self.groups - 1)))
        whole = (self.cost.missing == 0) & (self.cost.missing[reference] == 0)
        return np.where(whole, paired, unpaired)

    def best(self) -> int:
        """Find the d_max of least mean cost among those at which practically as many trials arrive as at any."""
        eligible = (self.arrived >= 0.99 * self.arrived.max()) & (self.cost.count > 0)
        return int(np.argmin(np.where(eligible, self.cost.mean, math.inf))) if eligible.any() else 0

    def as_good_as(self, reference: int) -> NDArray[np.bool_]:
        """Whether each d_max costs no more than another by over two standard errors of the difference, shape (k,)."""
        eligible = self.arrived >= 0.99 * self.arrived.max()
        excess = self.cost.mean - self.cost.mean[reference]
        return np.asarray(eligible & (excess <= 2.0 * self.difference_error(reference)))


def run_cells(
    plan: TransitPlan,
    state: TrialState,
    normals: TransitNormals,
    environment: Environment,
    d_max: Array,
    table: LegTable | None = None,
) -> CellTotals:
    """Run one block of trials through the transit for every d_max, and for a table of legs after them.

    `plan`: its own `d_max` is not used. `state`, `normals`, `environment`: as for `transit`. `d_max`, shape (k,): [m].
    `table`: one cell more, the last.
    """
    nominal = plan.nominal_time(state.position)
    lengths: list[float | LegTable] = [*(float(length) for length in d_max), *([table] if table is not None else [])]
    # costs without errors, of one surfacing for a table: a reference near the costs
    distance = float(np.mean(np.hypot(*(column(plan.goal) - state.position))))
    typical = np.append(np.ceil(distance / d_max) - 1.0, np.ones(len(lengths) - len(d_max)))
    reference = np.asarray(typical * float(np.mean(plan.surfacing_time)) / float(np.mean(nominal)))
    costs, surfacings = np.empty((len(lengths), state.trials)), np.empty((len(lengths), state.trials))
    for index, length in enumerate(lengths):
        _, record = transit(replace(plan, d_max=length), state, normals, environment)
        costs[index] = plan.cost(record, nominal)
        surfacings[index] = record.surfacings
        if not record.arrived.all():
            costs[index, ~record.arrived] = surfacings[index, ~record.arrived] = math.nan
    return _totals(costs, surfacings, reference)


def _totals(costs: Array, surfacings: Array, reference: Array) -> CellTotals:
    cells, trials = costs.shape
    groups = trials // GROUP
    kept = cells if cells <= MAX_PAIRED else 0
    grouped = np.nan_to_num(costs[:kept, : groups * GROUP]).reshape(kept, groups, GROUP).mean(axis=-1)
    about = grouped - reference[:kept, None]
    return CellTotals(
        cost=Moments.of(costs),
        surfacings=Moments.of(surfacings),
        groups=groups,
        sums=about.sum(axis=-1),
        products=np.einsum("ig,jg->ij", about, about),  # not BLAS, whose bits depend on its threads
    )


USUAL_ARRIVAL = 0.99
"""Probability of arriving that a d_max must have to be recommended where the mission requires none."""


@dataclass(frozen=True)
class SweepScenario:
    """A transit to be run with many plans of legs."""

    means: Scenario
    """The mission at its means."""
    phase: TransitPhase[Scalars]
    """At the means."""
    navigation: Navigation
    distance: float
    """L, at the means [m]."""
    d_max: Array
    """The mission's grid, and the whole distance after it: one leg; shape (k + 1,) [m]."""
    sigmas: tuple[float | None, ...]
    """σ_v of each curve [m/s]; None is the mission's own velocity error."""

    @classmethod
    def of(cls, mission: Mission, means: Scenario | None = None) -> "SweepScenario":
        """Read a mission.

        `means`: the mission at its means, where it is made and its record of the current checked already. Raises
        InputError when it has no transit or navigation, or the transit no length, or the mean drift is as fast as the
        vehicle.
        """
        navigation = navigation_of(mission)
        if means is None:
            means = Scenario.at_means(mission, recorded_current(mission))
            check_cover(mission, means)
        phase = means.transit(mission.sweep.phase)
        origin, goal = means.position(start_of(means.drawn, phase)), means.position(phase.to)
        distance = float(np.hypot(*(goal - origin)))
        if distance == 0.0:
            raise InputError([Problem("ends where it starts; a sweep needs a distance", mission.file, key=phase.name)])
        drift, speed = float(np.hypot(*_mean_drift(means, phase, origin))), float(phase.speed)
        if drift >= speed:
            message = f"the mean drift, {drift:.3g} m/s, reaches the vehicle's speed, {speed:.3g} m/s: it cannot arrive"
            raise InputError([Problem(message, mission.file, key=f"{phase.name}.speed")])
        needed = float(np.mean(means.transit_plan(phase).power_under_way)) * distance / (speed + drift)
        needed, capacity = needed / JOULES_PER_WATT_HOUR, float(np.max(means.capacity)) / JOULES_PER_WATT_HOUR
        if needed > capacity:  # never where energy is not computed: nan
            course = f"the straight course alone takes {needed:.3g} W h"
            words = f"{course}, the battery holds {capacity:.3g} W h: it cannot arrive"
            raise InputError([Problem(words, means.mission.file, key=phase.name)])
        grid = np.asarray(mission.sweep.d_max_values(distance), dtype=float)
        sigmas = tuple(mission.sweep.sigma) if mission.sweep.sigma else (None,)
        return cls(means, phase, navigation, distance, np.append(grid, distance), sigmas)

    @property
    def mission(self) -> Mission:
        """The whole mission."""
        return self.means.mission

    @property
    def mean_drifts(self) -> tuple[Array, Array]:
        """Mean velocity that carries the vehicle at the start, under way and at the surface, shape (2,) each [m/s]."""
        start = self.means.position(start_of(self.means.drawn, self.phase))
        return _mean_drift(self.means, self.phase, start), _mean_current(self.means, 0.0, start)

    @property
    def required_arrival(self) -> float:
        """Probability of arriving that the mission requires of the transit; the usual one where it requires none."""
        event = f"{self.phase.name}.arrived"
        required = [item.probability for item in self.mission.requirements if item.quantity == event]
        return max(required, default=USUAL_ARRIVAL)

    @property
    def table(self) -> LegTable | None:
        """The transit's own table of legs against distance left, where it has one instead of a d_max."""
        return leg_table(self.phase.d_max) if isinstance(self.phase.d_max, LegTableSection) else None

    @property
    def speed(self) -> float:
        """U at its mean [m/s]."""
        return float(self.phase.speed)

    @property
    def surfacing_time(self) -> float:
        """t_s at its mean [s]."""
        return mean_of(self.navigation.surfacing_time)

    @property
    def arrival_radius(self) -> float:
        """r_x at its mean [m]."""
        return float(self.phase.arrival_radius)

    def sigma(self, index: int) -> float:
        """σ_v that labels a curve; of an anisotropic Σ_v the root mean of its variances [m/s]."""
        covariance = self.navigation.velocity_error.covariance
        sigma = self.sigmas[index]
        return float(np.sqrt(0.5 * np.trace(covariance))) if sigma is None else sigma

    def plan(self, index: int, drawn: Scenario, speed_factor: float = 1.0) -> TransitPlan:
        """Build the plan of a curve from the draws of a block, at a factor times the transit's speed."""
        phase, sigma = drawn.transit(self.phase.name), self.sigmas[index]
        plan = drawn.transit_plan(phase.model_copy(update={"speed": phase.speed * speed_factor}))
        if sigma is None:
            return plan
        return replace(plan, velocity_error=VelocityError.isotropic(sigma, plan.velocity_error.mean))

    def environment(self, drawn: Scenario) -> Environment:
        """Build current, compensation and effects from the draws of a block."""
        return drawn.environment(drawn.transit(self.phase.name))

    def normals(self, seed: int, block: int) -> TransitNormals:
        """Open the streams of the legs, the same for every σ_v and every d_max."""
        return transit_normals(self.means, self.phase, BlockStreams(seed, block))

    def state(self, drawn: Scenario, seed: int, block: int, trials: int) -> TrialState:
        """Place a block of trials at the start, with the fix that each takes before its first dive."""
        phase = drawn.transit(self.phase.name)
        return deployed(drawn, phase, drawn.position(start_of(drawn.drawn, phase)), BlockStreams(seed, block), trials)


def start_of(mission: Mission[V], phase: TransitPhase[V]) -> Position[V]:
    """Where a transit begins: its own `from`, else where the transit before it went."""
    before = [transit.to for transit in itertools.takewhile(lambda other: other.name != phase.name, mission.transits)]
    if phase.start is None and not before:
        raise InputError([Problem("missing; the first transit needs a start", mission.file, key="from")])
    return before[-1] if phase.start is None else phase.start


def _mean_drift(means: Scenario, phase: TransitPhase[Scalars], start: Array) -> Array:
    """Mean velocity that carries the vehicle under way at the start: v̄ and the current, shape (2,) [m/s]."""
    error = means.transit_plan(phase).velocity_error.mean[:, 0]
    return np.asarray(error + _mean_current(means, float(phase.depth), start))


def _mean_current(means: Scenario, depth: float, start: Array) -> Array:
    """Mean current at the start, shape (2,) [m/s]."""
    return np.zeros(2) if means.current is None else means.current.velocity(0.0, depth, start[:, None])[:, 0]
