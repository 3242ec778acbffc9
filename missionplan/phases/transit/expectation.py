"""Expected time of a transit in legs, without Monte Carlo.

For isotropic zero-mean velocity errors, drawn anew for each leg and not compensated, a position matters only by its
distance d left to the target. A leg of length ℓ(d) towards it ends at a Rice-distributed distance d′ about
|d − ℓ| with scale s, s² = (σℓ/U)² + s₀², where s₀ is what fixes and the drift at the surface add to a leg of any
length (0 in the base model). The expected time to go J solves

    J(d) = ℓ/U + t_s + E[J(d′); d′ > r_x],    J = 0 for d ≤ r_x.

The equation is linear: it is solved for the expected distance run R and for the expected surfacings N,
J = R/U + t_s N. Checked against Monte Carlo for σ/U from 0.005 to 0.4 and s₀ up to the arrival radius.
"""

import math
from dataclasses import dataclass

import numpy as np

from missionplan.arrays import Array
from missionplan.phases.transit.plan import LegTable
from missionplan.phases.transit.rice_panels import (
    MAX_PANELS,
    TAIL,
    Panels,
    expectation_matrix,
    graded_panels,
    solve_ascending,
)

MAX_RATIO = 0.7
"""Largest σ/U accepted: at 1/√2 a leg's mean-square error is as long as the leg itself."""
NO_ERROR = 1e-5
"""Fraction of the arrival radius below which the error of a leg over the whole distance counts as zero."""
MAX_LEGS = 100_000
"""Legs after which a transit without error counts as never arriving."""
PANEL_SCALES = 2.5
"""Widest panel about a feature of J, relative to the feature's width."""
PANEL_RATIO = 0.6
"""Widest panel elsewhere, relative to the distance to the nearest feature."""
MIN_PANEL_WIDTH = 0.02
"""Narrowest panel that a table of legs requires, in arrival radii."""


@dataclass(frozen=True)
class TransitExpectation:
    """Expected distance run and surfacings of a transit."""

    distance: float
    """To the target at the start [m]."""
    speed: float
    surfacing_time: float
    """Speed through the water [m/s] and time at the surface after each leg [s]."""
    distance_run: float
    """Expected total length of the legs [m]."""
    surfacings: float
    """Expected number of legs, hence of surfacings, the arrival's included."""

    @property
    def duration(self) -> float:
        """Expected time, the arrival's surfacing included [s]."""
        return self.distance_run / self.speed + self.surfacing_time * self.surfacings

    @property
    def cost(self) -> float:
        """Expected c of Briggs et al., Eq. 25, the arrival surfacing not charged; −1 for a start that has arrived."""
        charged = max(self.surfacings - 1.0, 0.0) * self.surfacing_time
        return (self.distance_run + charged * self.speed) / self.distance - 1.0


def expected_transit(
    distance: float,
    d_max: float | LegTable,
    speed: float,
    arrival_radius: float,
    sigma: float,
    surfacing_time: float,
    base_spread: float = 0.0,
) -> TransitExpectation:
    """Expected transit with legs of at most `d_max`: ℓ = min(d, d_max(d)).

    Raises ValueError if an argument is out of its range, or the error so large that legs do not bring the vehicle
    nearer.

    Parameters
    ----------
    distance : float
        To the target at the start [m].
    d_max : float or LegTable
        Maximum leg length, or a table of it over the distance left [m].
    speed : float
        Through the water [m/s].
    arrival_radius : float
        r_x, within which the vehicle has arrived [m].
    sigma : float
        Standard deviation of each component of a leg's velocity error [m/s].
    surfacing_time : float
        t_s, at the surface after each leg [s].
    base_spread : float
        s₀, standard deviation that each leg's end has on each axis whatever the leg's length [m].
    """
    table = d_max if isinstance(d_max, LegTable) else LegTable(np.array([0.0]), np.array([_positive("d_max", d_max)]))
    for name, value in {"distance": distance, "speed": speed, "arrival_radius": arrival_radius}.items():
        _positive(name, value)
    for name, value in {"sigma": sigma, "surfacing_time": surfacing_time, "base_spread": base_spread}.items():
        if not value >= 0 or not np.isfinite(value):
            raise ValueError(f"{name} must be finite and not negative, not {value:g}")
    if sigma / speed > MAX_RATIO:
        raise ValueError(
            f"a velocity error of {sigma:g} m/s is too large compared with a speed of {speed:g} m/s: "
            f"above {MAX_RATIO:g} times the speed a leg does not bring the vehicle nearer in the mean square"
        )
    k = sigma / speed
    if distance <= arrival_radius or math.hypot(k * distance, base_spread) <= NO_ERROR * arrival_radius:
        run, surfacings = _without_error(table, distance, arrival_radius)
    else:
        build = _panels_of_table if len(table.leg) > 1 else _panels_of_d_max
        panels = build(distance, table, arrival_radius, k, base_spread)
        run, surfacings = _with_error(table, panels, distance, k, base_spread)
    return TransitExpectation(distance, speed, surfacing_time, run, surfacings)


def _positive(name: str, value: float) -> float:
    if not value > 0 or not np.isfinite(value):
        raise ValueError(f"{name} must be positive and finite, not {value:g}")
    return value


def _without_error(table: LegTable, distance: float, arrival_radius: float) -> tuple[float, float]:
    """Distance run and surfacings where every leg ends where it was aimed."""
    left, run = distance, 0.0
    for surfacings in range(MAX_LEGS):
        if left <= arrival_radius:
            return run, float(surfacings)
        leg = float(table(np.array([left]))[0])
        left, run = abs(left - leg), run + leg
    raise ValueError(f"not arrived after {MAX_LEGS} legs: d_max is too short for the distance")


def _with_error(table: LegTable, panels: Panels, distance: float, k: float, base: float) -> tuple[float, float]:
    """Expected distance run and surfacings from `distance`, with panels that reach as far as legs may end."""
    nodes = panels.nodes
    d = np.append(nodes, distance)
    leg = table(d)
    matrix = expectation_matrix(panels, np.abs(d - leg), np.hypot(k * leg, base))
    ones = np.ones_like(leg)
    to_go = solve_ascending(matrix[:-1], np.stack([leg, ones], axis=1)[:-1])
    run, surfacings = np.array([leg[-1], 1.0]) + (matrix[-1:] @ to_go)[0]
    return float(run), float(surfacings)


def _panels_of_d_max(distance: float, table: LegTable, arrival_radius: float, k: float, base: float) -> Panels:
    """Panels graded towards the features of J.

    Beyond d = j d_max + r_x one more leg is needed: J rises there over the width k d_max √j of j legs' errors. The leg
    length has a kink at d_max, which J repeats, smoothed, at each further j d_max.
    """
    d_max = float(table.leg[0])
    scale = math.hypot(k * d_max, base)

    def width(d: Array) -> Array:
        legs = np.maximum(np.round((d - 0.5 * arrival_radius) / d_max), 1.0)
        offset = d - legs * d_max
        to_feature = np.minimum(np.abs(offset), np.abs(offset - arrival_radius))
        widest = np.maximum(PANEL_SCALES * scale * np.sqrt(legs), PANEL_RATIO * to_feature)
        return np.where(d < d_max, PANEL_RATIO * d, widest)

    top = max(_farthest(distance, table, k, base), 2.0 * arrival_radius)
    if top / d_max > MAX_PANELS:
        raise ValueError(f"d_max of {d_max:g} m is too short for a distance of {distance:g} m")
    steps = d_max * np.arange(1, np.floor(top / d_max) + 1)
    edges = np.concatenate([steps, steps + arrival_radius])
    return graded_panels(_between(arrival_radius, edges, top), width)


def _panels_of_table(distance: float, table: LegTable, arrival_radius: float, k: float, base: float) -> Panels:
    """Panels as wide as the error of the leg from there, the finest scale on which J varies, or as d − r_x."""
    top = max(_farthest(distance, table, k, base), 2.0 * arrival_radius)
    narrowest = MIN_PANEL_WIDTH * arrival_radius

    def width(d: Array) -> Array:
        near = np.maximum(PANEL_RATIO * (d - arrival_radius), narrowest)
        return np.minimum(np.maximum(PANEL_SCALES * np.hypot(k * table(d), base), narrowest), near)

    return graded_panels(_between(arrival_radius, table.kinks, top), width)


def _between(low: float, edges: Array, high: float) -> Array:
    """Edges between two limits, with the limits."""
    return np.concatenate([[low], edges[(edges > low) & (edges < high)], [high]])


def _farthest(distance: float, table: LegTable, k: float, base: float) -> float:
    """Distance left that any leg ends beyond with negligible probability."""
    spread = 2.0 * TAIL * base
    if TAIL * k < 1.0:  # every leg ends nearer than it began
        first = float(table(np.array([distance]))[0])
        return distance - first + TAIL * k * first + spread
    # With a longest leg the distance is a walk of that drift, step scale k ℓ: P(rise > z) < exp(−2z/(k² ℓ)).
    # Without one it is at worst a product of Rayleigh variables with E[(d′/d)²] = 2k² < 1.
    longest = float(table.leg.max())
    return min(max(distance, longest) + (TAIL * k + 12.0 * k**2) * longest, 1e6 * distance) + spread
