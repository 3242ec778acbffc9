"""A transit in the terms of the integral equation of its expected cost, and the legs that are best for it."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from missionplan.phases.transit.analytic.expectation import TransitExpectation, expected_transit
from missionplan.phases.transit.analytic.policy import best_d_max, best_legs
from missionplan.phases.transit.leg_table import LegTable
from missionplan.studies.leg_length.leg_spread import LegSpread
from missionplan.studies.leg_length.sweep_scenario import SweepScenario

_best_legs = lru_cache(maxsize=64)(best_legs)
"""Cached: the same legs are needed by several objectives and for their costs."""


@dataclass(frozen=True)
class AnalyticTransit:
    """A transit whose legs end within a known spread of where they aim.

    Attributes
    ----------
    scenario : SweepScenario
    spread : LegSpread
    speed : float
        [m/s]
    surfacing_time : float
        Cost of a surfacing, as time under way [s].
    """

    scenario: SweepScenario
    spread: LegSpread
    speed: float
    surfacing_time: float

    @property
    def speed_factor(self) -> float:
        """Its speed over the mission's own."""
        return self.speed / self.scenario.speed

    def best_table(self, spread_factor: float = 1.0, surfacing_factor: float = 1.0) -> LegTable:
        """Best legs for a larger or smaller spread and cost of a surfacing."""
        return _rounded(_best_legs(*self._arguments(spread_factor, surfacing_factor)).legs)

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


def _rounded(table: LegTable) -> LegTable:
    """Round a table to 0.1 m, as mission files write it; knots that coincide are left out."""
    left, leg = np.round(table.left, 1), np.maximum(np.round(table.leg, 1), 0.1)
    kept = np.append(True, np.diff(left) > 0.0)
    return LegTable(left[kept], leg[kept])
