"""Mean of a navigation log's velocity errors: linear in the causes, by the effects' own hooks."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import cast

import numpy as np
from numpy.typing import NDArray

from missionplan.diagnose.coordinates import Coordinate, coordinates_of, parameters_from
from missionplan.diagnose.model import Causes
from missionplan.diagnose.transit_data import TransitData
from missionplan.effects import CATALOGUE, effects_of
from missionplan.effects.tidal_current import resolvable
from missionplan.phases.hooks import Leg, TransitEffect

Array = NDArray[np.float64]

RANDOM = ("persistent-error", "random-walk", "fix-error", "heavy-tails")
"""Effects that enter the covariance and not the mean."""
STEP = 1e-3
"""Step of the finite differences, in prior standard deviations of a cause."""


@dataclass(frozen=True)
class TransitMean:
    """Legs of a log, what the mission expects of them, and the columns of the causes.

    Attributes
    ----------
    data : TransitData
        The log.
    base : array, shape (2, n)
        Velocity error that the mission expects: site's current and mean of the velocity error [m/s].
    covariance : array, shape (2, 2)
        Σ_v of the mission [m²/s²].
    fix_error : float
        The mission's standard deviation of a fix [m]; 0 when not given.
    current_sd : tuple of float
        How unsure the mission itself is of the steady current, east and north [m/s].
    only : tuple of Coordinate, optional
        Coordinates to use; default those that the record can resolve.
    """

    data: TransitData
    base: Array
    covariance: Array
    fix_error: float
    current_sd: tuple[float, float] = (0.0, 0.0)
    only: tuple[Coordinate, ...] | None = None

    @cached_property
    def untestable(self) -> Mapping[str, str]:
        """Effects that this record cannot show, and why."""
        why = {}
        if not math.isfinite(self.data.latitude):
            why["inertial-current"] = "needs the latitude: site.origin in the mission, or positions by latitude"
        if not self.data.has_surface_time:
            why["surface-drift"] = "needs the time at the surface before each fix: column surface_s"
        if not resolvable(self._length):
            why["tidal-current"] = "needs a record of at least half a tidal period"
        return why

    @property
    def _length(self) -> float:
        return float(np.ptp(self.data.middle))

    @cached_property
    def candidates(self) -> Causes:
        """Effects of the catalogue that this record could show."""
        return tuple(info.id for info in effects_of("transit") if info.id not in self.untestable)

    @cached_property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """Coordinates of all causes of the mean."""
        if self.only is not None:
            return self.only
        found: list[Coordinate] = []
        for name in self.candidates:
            if name == "tidal-current":
                tides = resolvable(self._length)
                names = [key for key in CATALOGUE[name].parameters if key.split("_")[0] in tides]
                found += coordinates_of(CATALOGUE[name], names)
            elif name not in RANDOM:
                found += coordinates_of(CATALOGUE[name])
        return tuple(found)

    @cached_property
    def axes(self) -> Array:
        """Principal axes of Σ_v as columns, shape (2, 2); east and north when it is isotropic."""
        if np.allclose(self.covariance, self.covariance[0, 0] * np.eye(2)):
            return np.eye(2)
        return cast(Array, np.linalg.eigh(self.covariance)[1])

    @cached_property
    def y(self) -> Array:
        """Velocity errors less what the mission expects, on the principal axes, shape (2, n) [m/s]."""
        return self.axes.T @ (self.data.velocity_error - self.base)

    @cached_property
    def leg(self) -> Leg:
        """The legs as an effect sees them: the course is the one dead-reckoned."""
        data = self.data
        path = data.dead_reckoned - data.start
        length = np.hypot(*path)
        return Leg(
            data.t_start,
            data.under_way,
            data.start,
            path / np.maximum(length, 1e-9),
            length / data.under_way,
            data.latitude,
        )

    def mean_error(self, values: Array) -> Array:
        """Velocity errors that the causes of the mean give, on the principal axes, shape (2, n) [m/s]."""
        return self.axes.T @ sum(
            (self._error(own, values) for own in self._by_effect.values()), np.zeros((2, self.data.n))
        )

    @cached_property
    def _by_effect(self) -> dict[str, list[int]]:
        """Coordinates of each effect."""
        found: dict[str, list[int]] = {}
        for index, coordinate in enumerate(self.coordinates):
            found.setdefault(coordinate.effect, []).append(index)
        return found

    def _error(self, own: list[int], values: Array) -> Array:
        """Velocity errors east and north that one effect gives, shape (2, n) [m/s]."""
        data = self.data
        ((name, parameters),) = parameters_from([self.coordinates[i] for i in own], values[own]).items()
        effect = cast(TransitEffect, CATALOGUE[name].make(parameters))
        drift = effect.surface_velocity(data.t_start + data.under_way, data.surface, data.end)
        return effect.velocity(self.leg) + drift * data.surface / data.under_way

    def columns(self, about: Array) -> Array:
        """Columns of the coordinates by central differences through the effects' hooks, shape (2, n, k)."""
        columns = []
        for index, coordinate in enumerate(self.coordinates):
            own, step = self._by_effect[coordinate.effect], np.zeros(len(about))
            step[index] = STEP * coordinate.slab
            ahead, behind = (self._error(own, about + sign * step) for sign in (1.0, -1.0))
            columns.append(self.axes.T @ (ahead - behind) / (2.0 * step[index]))
        return np.stack(columns, axis=2)

    @cached_property
    def _columns_at_zero(self) -> Array:
        return self.columns(np.zeros(len(self.coordinates)))

    def prior_sd(self, causes: Causes) -> Array:
        """Prior standard deviation of each coordinate: its slab when its effect is a cause, else its spike."""
        values = [c.slab if c.effect in causes else c.spike for c in self.coordinates]
        for index, coordinate in enumerate(self.coordinates):
            if coordinate.effect == "mean-current":
                values[index] = math.hypot(values[index], self.current_sd[coordinate.name == "north"])
        return np.array(values)

    def linearised(self, about: Array) -> tuple[Array, Array]:
        """Data and columns of the model linearised about coordinates: y ≈ columns·coordinates, (2, n), (2, n, k)."""
        if not np.any(about):
            return self.y, self._columns_at_zero
        columns = self.columns(about)
        return self.y - self.mean_error(about) + columns @ about, columns
