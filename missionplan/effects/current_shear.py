"""A current that changes across the area."""

from dataclasses import dataclass

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.effects.finding import Finding
from missionplan.effects.info import EffectInfo, Parameter
from missionplan.phases.hooks import Leg, TransitEffect


@dataclass(frozen=True)
class CurrentShear(TransitEffect):
    """Current linear in position, zero at the origin, at the middle of each leg as the current displaces it.

    ``east_by_north`` is the growth of the east component for each metre to the north [1/s], and so on: the rows of
    the 2 × 2 gradient are (east_by_east, east_by_north) and (north_by_east, north_by_north).
    """

    east_by_east: Scalars = 0.0
    east_by_north: Scalars = 0.0
    north_by_east: Scalars = 0.0
    north_by_north: Scalars = 0.0

    def velocity(self, leg: Leg) -> Array:
        """Return the velocity error of each leg, shape (2, n) [m/s].

        The mean over the leg of the solution of ẋ = w + G x, to second order in G and the leg's duration.
        """
        middle = leg.start + 0.5 * leg.duration * leg.speed * leg.along
        return self._at(middle + 0.5 * leg.duration * self._at(middle))

    def _at(self, place: Array) -> Array:
        """Return the current at places, shape (2, n) [m/s]."""
        x, y = place
        return np.stack(
            [self.east_by_east * x + self.east_by_north * y, self.north_by_east * x + self.north_by_north * y]
        )


INFO = EffectInfo(
    id="current-shear",
    phase="transit",
    tier="physical",
    effect=CurrentShear,
    parameters={
        f"{component}_by_{axis}": Parameter(
            "1/s",
            f"growth of the {component} current for each metre toward {axis}",
            -1e-2,
            1e-2,
            scale=5e-5,
            spike=2e-7,
            extent_scale=0.1,  # over an area a current changes by no more than its usual speed
            extent_spike=0.004,
        )
        for component in ("east", "north")
        for axis in ("east", "north")
    },
    belongs_to="place",
    what="The edge of a jet, a river mouth, the shelf edge: the current differs from one end of the area to the other.",
    finding=Finding(
        "",
        "the current differs from one place of the site to another",
        remedy="take the current from a model or from measurements along the way",
    ),
    sizes="0.1 m/s over 1 to 10 km: 1e-5 to 1e-4 1/s.",
    confused_with=("mean-current", "tidal-current", "persistent-error"),
    linear=False,
    distinguished_by="Legs that visit the same place at different times.",
)
