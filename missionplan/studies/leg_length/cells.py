"""Cells of a sweep: every d_max on the same trials, reduced to sums that merge block by block.

The same standard normals serve every d_max (common random numbers; Law 2015, Simulation Modeling and Analysis, sect.
11.2), so that differences between two d_max are known much better than either cost. Their standard errors come from the
covariances of the costs, taken between means of groups of trials (batch means): the groups are independent, and their
products cost a sixteenth of those of the trials.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.montecarlo.statistics import Moments
from missionplan.phases.state import TrialState
from missionplan.phases.transit.leg_table import LegTable
from missionplan.phases.transit.plan import Environment, TransitNormals, TransitPlan, column
from missionplan.phases.transit.transit import transit

GROUP = 16
"""Trials in a group. What is left of a block over whole groups is not used for differences."""
MAX_PAIRED = 1000
"""Largest number of d_max for which covariances are kept; beyond, differences ignore the common random numbers."""
_FEWEST_GROUPS = 8


@dataclass(frozen=True)
class CellTotals:
    """Merged trials of k values of d_max.

    Attributes
    ----------
    cost, surfacings : Moments of shape (k,)
        Of the trials that arrived; `missing` counts the others.
    groups : int
        Groups of trials in the two sums below.
    sums : array, shape (k,)
        Sum of the groups' means of the cost about a fixed reference.
    products : array, shape (k, k)
        Sum of their products; shape (0, 0) where there are too many d_max.
    """

    cost: Moments
    surfacings: Moments
    groups: int
    sums: Array
    products: Array

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

    Parameters
    ----------
    plan : TransitPlan
        Its own `d_max` is not used.
    state, normals, environment
        As for `transit`.
    d_max : array, shape (k,)
        [m]
    table : LegTable, optional
        One cell more, the last.
    """
    nominal = plan.nominal_time(state.position)
    lengths: list[float | LegTable] = [*(float(length) for length in d_max), *([table] if table is not None else [])]
    reference = _typical_costs(plan, state, d_max, len(lengths), nominal)
    costs, surfacings = np.empty((len(lengths), state.trials)), np.empty((len(lengths), state.trials))
    for index, length in enumerate(lengths):
        _, record = transit(replace(plan, d_max=length), state, normals, environment)
        costs[index] = plan.cost(record, nominal)
        surfacings[index] = record.surfacings
        if not record.arrived.all():
            costs[index, ~record.arrived] = surfacings[index, ~record.arrived] = math.nan
    return _totals(costs, surfacings, reference)


def _typical_costs(plan: TransitPlan, state: TrialState, d_max: Array, cells: int, nominal: Array) -> Array:
    """Cost without errors of each d_max, of one surfacing for a table: a reference near the costs, shape (cells,)."""
    distance = np.hypot(*(column(plan.goal) - state.position))
    surfacings = np.append(np.ceil(float(np.mean(distance)) / d_max) - 1.0, np.ones(cells - len(d_max)))
    return np.asarray(surfacings * float(np.mean(plan.surfacing_time)) / float(np.mean(nominal)))


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
