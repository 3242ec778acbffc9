"""Legs that adapt to the distance left: the optimal policy by dynamic programming.

The policy of Bellman's equation (`bellman`) is reduced to a table of few knots, whose extra cost is computed.
Checked for σ/U from 0.004 to 0.3.

Bellman's equation of a transit in legs: the optimal leg length at each distance left.

Under the assumptions of `expectation`, the least expected time to go solves

    J(d) = min over ℓ of ℓ/U + t_s + E[J(d′); d′ > r_x],    J = 0 for d ≤ r_x,

where d′ is Rice-distributed about d − ℓ with scale s, s² = (σℓ/U)² + s₀², and 0 < ℓ ≤ d. Policy iteration (Howard)
alternates between the best legs for a given J, by a scan and golden-section search, and the J of given legs, by a
linear solve.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import scipy
from numpy.typing import NDArray
from scipy.sparse import csr_array

from missionplan.arrays import Array
from missionplan.phases.transit.expectation import TransitExpectation, expected_transit
from missionplan.phases.transit.plan import LegTable
from missionplan.phases.transit.rice_panels import TAIL, Panels, expectation_matrix, graded_panels, solve_ascending

CANDIDATES = 40
"""Leg lengths scanned at each distance left."""
SECTIONS = 12
"""Steps of golden-section search between two candidates, which narrow the interval to a 300th."""
TOLERANCE = 1e-6
"""Relative change of J that ends policy iteration."""
MAX_PANEL_WIDTH = 0.12
"""Of the grid, relative to the distance left."""
JUMP = 1.0
"""Greatest distance between the two knots of a jump in the leg length [m]."""
MAX_ITERATIONS = 50
"""Of policy iteration, which seldom needs ten."""

_GOLDEN = 0.5 * (np.sqrt(5.0) - 1.0)


@dataclass(frozen=True)
class Bellman:
    """Bellman's equation on a grid. Times are multiplied by the speed, so that J is in metres."""

    panels: Panels
    """Grid of J."""
    distance: float
    """To the target at the start [m]."""
    k: float
    """σ/U."""
    base: float
    """s₀ [m]."""
    surfacing: float
    """t_s U [m]."""
    candidates: Array
    """Leg lengths scanned at each node, shape (nodes, CANDIDATES) [m]."""
    transition: csr_array
    """Transition matrix of the candidates: E[J(d′); d′ > r_x] after each of them from J at the nodes; shape (nodes *
    CANDIDATES, nodes)."""

    @classmethod
    def on_grid(cls, distance: float, arrival_radius: float, k: float, surfacing: float, base: float) -> "Bellman":
        """Build the grid, finest at the arrival radius where legs are short, and the candidates of the scan."""

        def width(d: Array) -> Array:
            return np.maximum(np.minimum(0.3 * (d - arrival_radius), MAX_PANEL_WIDTH * d), 0.02 * arrival_radius)

        # A leg can end farther away only where TAIL k > 1, and legs that may end far away do not pay.
        top = (distance if TAIL * k < 1.0 else 10.0 * distance) + 2.0 * TAIL * base
        panels = graded_panels(np.array([arrival_radius, distance, top]), width)
        return cls(panels, distance, k, base, surfacing, *_scan(panels, panels.nodes, k, base))

    def solve(self) -> tuple[Array, Array]:
        """Optimal legs: distances left, ascending, and leg lengths, with jumps resolved to `JUMP`.

        Raises ValueError if policy iteration does not converge.
        """
        left = self.panels.nodes
        to_go = self._evaluate(left)
        _, to_go = self._iterate(left, to_go, sections=0)
        leg, to_go = self._iterate(left, to_go, sections=SECTIONS)
        # a knot at `distance`, and steep intervals halved until jumps are `JUMP` wide
        extra = np.array([self.distance])
        while extra.size:
            added = self._improve(extra, *_scan(self.panels, extra, self.k, self.base), to_go, SECTIONS)
            order = np.argsort(np.append(left, extra))
            left, leg = np.append(left, extra)[order], np.append(leg, added)[order]
            wide = np.flatnonzero(is_steep(left, leg) & (np.diff(left) > JUMP))
            extra = 0.5 * (left[wide] + left[wide + 1])
        return left, leg

    def _scale(self, leg: Array) -> Array:
        """Standard deviation of a leg's end on each axis [m]."""
        scale: Array = np.hypot(self.k * leg, self.base)
        return scale

    def _iterate(self, left: Array, to_go: Array, sections: int) -> tuple[Array, Array]:
        """Iterate policies until J converges: legs at the nodes, J there."""
        for _ in range(MAX_ITERATIONS):
            leg = self._improve(left, self.candidates, self.transition, to_go, sections)
            before, to_go = to_go, self._evaluate(leg)
            if np.max(np.abs(to_go / before - 1.0)) < TOLERANCE:
                return leg, to_go
        raise ValueError("the best legs did not converge: the velocity error is too large")

    def _evaluate(self, leg: Array) -> Array:
        """J of given legs at the nodes."""
        matrix = expectation_matrix(self.panels, self.panels.nodes - leg, self._scale(leg))
        solution: Array = solve_ascending(matrix, (leg + self.surfacing)[:, None])[:, 0]
        return solution

    def _improve(self, left: Array, candidates: Array, transition: csr_array, to_go: Array, sections: int) -> Array:
        """Best leg from each distance left, if J is `to_go` afterwards: the best candidate, refined in `sections`."""
        best = np.argmin(candidates + (transition @ to_go).reshape(candidates.shape), axis=1)
        rows = np.arange(left.size)
        if sections == 0:
            chosen: Array = candidates[rows, best]
            return chosen
        low = candidates[rows, np.maximum(best - 1, 0)]
        high = candidates[rows, np.minimum(best + 1, CANDIDATES - 1)]

        def total(leg: Array) -> Array:
            expected: Array = leg + expectation_matrix(self.panels, left - leg, self._scale(leg)) @ to_go
            return expected

        for _ in range(sections):
            inner, outer = high - _GOLDEN * (high - low), low + _GOLDEN * (high - low)
            shorter = total(inner) < total(outer)
            low, high = np.where(shorter, low, inner), np.where(shorter, outer, high)
        middle: Array = 0.5 * (low + high)
        return middle


def is_steep(left: Array, leg: Array) -> NDArray[np.bool_]:
    """Whether the leg length changes too steeply to be interpolated, between each knot and the next."""
    steep: NDArray[np.bool_] = np.abs(np.diff(leg)) > 1.5 * np.diff(left) + 0.02 * left[1:] + JUMP
    return steep


def _scan(panels: Panels, left: Array, k: float, base: float) -> tuple[Array, csr_array]:
    """Candidate leg lengths from each distance left, and their transition matrix.

    Candidates ascend, shape (n, CANDIDATES). They aim at points that are evenly spaced near the target, over the
    arrival circle and the error of a full leg, and geometrically beyond.
    """
    near = (panels.edges[0] + 3.0 * np.hypot(k * left, base))[:, None]
    steps = np.linspace(1.0, 0.0, CANDIDATES + 1)[1:]
    candidates = left[:, None] - near * np.sinh(np.arcsinh(left[:, None] / near) * steps)
    legs = candidates.ravel()
    return candidates, expectation_matrix(panels, np.repeat(left, CANDIDATES) - legs, np.hypot(k * legs, base))


TABLE_LOSS = 1e-5
"""Largest extra cost accepted for a table with few knots."""
MIN_ERROR = 1e-3
"""Smallest error of a leg over the whole distance that is planned for, in arrival radii."""


@dataclass(frozen=True)
class LegPolicy:
    """The optimal legs with their expected transit."""

    legs: LegTable
    """Leg length against distance left, exact at its knots."""
    transit: TransitExpectation
    """Expected with these legs."""
    bound: float
    """Least expected cost c of any legs, which the table exceeds by at most `TABLE_LOSS`."""


def best_legs(
    distance: float,
    speed: float,
    arrival_radius: float,
    sigma: float,
    surfacing_time: float,
    base_spread: float = 0.0,
) -> LegPolicy:
    """Find the legs that minimise the expected time of a transit.

    Raises ValueError if an argument is out of its range, or the iteration does not converge.

    Parameters
    ----------
    distance : float
        To the target at the start, more than the arrival radius [m].
    speed : float
        Through the water [m/s].
    arrival_radius : float
        r_x [m].
    sigma : float
        Standard deviation of each component of a leg's velocity error [m/s]; at least what `MIN_ERROR` gives is used.
    surfacing_time : float
        t_s, positive: otherwise the optimal legs would be infinitely short [s].
    base_spread : float
        s₀, standard deviation that each leg's end has on each axis whatever the leg's length [m].
    """
    one_leg = expected_transit(distance, distance, speed, arrival_radius, sigma, surfacing_time, base_spread)
    if not surfacing_time > 0 or distance <= arrival_radius:
        raise ValueError("the best legs need a surfacing time and a start outside the arrival radius")
    k = max(sigma / speed, MIN_ERROR * arrival_radius / distance)
    left, leg = Bellman.on_grid(distance, arrival_radius, k, surfacing_time * speed, base_spread).solve()

    arguments = (speed, arrival_radius, k * speed, surfacing_time, base_spread)
    full = LegTable(left, leg)
    bound = min(expected_transit(distance, full, *arguments).cost, one_leg.cost)
    tolerance = k * leg + 0.02 * arrival_radius
    while True:
        legs = simplify_table(full, tolerance)
        if legs.left.size == left.size or expected_transit(distance, legs, *arguments).cost <= bound + TABLE_LOSS:
            transit = expected_transit(distance, legs, speed, arrival_radius, sigma, surfacing_time, base_spread)
            return LegPolicy(legs, transit, bound)
        tolerance *= 0.5


def best_d_max(
    distance: float,
    speed: float,
    arrival_radius: float,
    sigma: float,
    surfacing_time: float,
    base_spread: float = 0.0,
) -> tuple[float, TransitExpectation]:
    """Find the fixed d_max, from distance/20 to the distance, of least expected cost; arguments as of `best_legs`."""

    def expected(d_max: float) -> TransitExpectation:
        return expected_transit(distance, d_max, speed, arrival_radius, sigma, surfacing_time, base_spread)

    def cost(d_max: float) -> float:
        return expected(d_max).cost

    grid = np.linspace(0.05, 1.0, 96) * distance
    best = int(np.argmin([cost(d_max) for d_max in grid]))
    bounds = (grid[max(best - 1, 0)], grid[min(best + 1, len(grid) - 1)])
    minimum = scipy.optimize.minimize_scalar(cost, bounds=bounds, method="bounded", options={"xatol": 1e-4 * distance})
    refined = float(minimum.x)
    d_max = min(refined, float(grid[best]), key=cost)
    return d_max, expected(d_max)


def simplify_table(table: LegTable, tolerance: Array) -> LegTable:
    """Remove knots that interpolation restores to within a tolerance per knot [m]; jumps are kept."""
    left, leg = table.left, table.leg
    keep = np.zeros(left.size, dtype=bool)
    keep[[0, -1]] = True
    jumps = np.flatnonzero(is_steep(left, leg))
    keep[jumps] = keep[jumps + 1] = True
    while True:
        kept = np.flatnonzero(keep)
        excess = np.abs(np.interp(left, left[kept], leg[kept]) - leg) / tolerance
        for start, stop in pairwise(kept):
            worst = start + int(np.argmax(excess[start : stop + 1]))
            keep[worst] |= excess[worst] > 1.0
        if keep.sum() == kept.size:
            return LegTable(left[keep], leg[keep])
