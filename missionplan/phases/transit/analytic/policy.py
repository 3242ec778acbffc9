"""Legs that adapt to the distance left: the optimal policy by dynamic programming.

The policy of Bellman's equation (`bellman`) is reduced to a table of few knots, whose extra cost is computed.
Checked for σ/U from 0.004 to 0.3.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.optimize import minimize_scalar

from missionplan.arrays import Array
from missionplan.phases.transit.analytic.bellman import Bellman, is_steep
from missionplan.phases.transit.analytic.expectation import TransitExpectation, expected_transit
from missionplan.phases.transit.leg_table import LegTable

TABLE_LOSS = 1e-5
"""Largest extra cost accepted for a table with few knots."""
MIN_ERROR = 1e-3
"""Smallest error of a leg over the whole distance that is planned for, in arrival radii."""


@dataclass(frozen=True)
class LegPolicy:
    """The optimal legs with their expected transit.

    Attributes
    ----------
    legs : LegTable
        Leg length against distance left, exact at its knots.
    transit : TransitExpectation
        Expected with these legs.
    bound : float
        Least expected cost c of any legs, which the table exceeds by at most `TABLE_LOSS`.
    """

    legs: LegTable
    transit: TransitExpectation
    bound: float


def best_legs(
    distance: float,
    speed: float,
    arrival_radius: float,
    sigma: float,
    surfacing_time: float,
    base_spread: float = 0.0,
) -> LegPolicy:
    """Find the legs that minimise the expected time of a transit.

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

    Raises
    ------
    ValueError
        If an argument is out of its range, or the iteration does not converge.
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
    refined = float(minimize_scalar(cost, bounds=bounds, method="bounded", options={"xatol": 1e-4 * distance}).x)
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
