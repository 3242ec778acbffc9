"""Mean of a navigation log's velocity errors: linear in the causes, by the effects' own hooks."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import cast

import numpy as np

from missionplan.arrays import Array
from missionplan.datasets.legs import TransitData
from missionplan.diagnosis.coordinates import Coordinate, coordinates_of, parameters_from
from missionplan.diagnosis.inference.model import MINIMUM_EVIDENCE_GAIN
from missionplan.diagnosis.legs.modulation import modulation
from missionplan.effects import CATALOGUE, effects_of
from missionplan.effects.tidal_current import resolvable
from missionplan.phases.hooks import Leg, TransitEffect
from missionplan.results.diagnosis import Causes

RANDOM = ("persistent-error", "random-walk", "fix-error", "heavy-tails")
"""Effects that enter the covariance and not the mean."""
TURNING = ("compass-bias", "compass-deviation")
"""Effects whose velocity is not linear in their angles."""
WAVERING = ("tidal-current", "inertial-current")
"""Currents that keep neither amplitude nor phase to the letter."""
NARROW = 2.0 / math.pi
"""Length of the mean heading vector above which the headings cover less than half the compass."""
STEP = 1e-3
"""Step of the finite differences, in prior standard deviations of a cause."""
ACROSS, ACROSS_UNSURE = 0.1, 0.004
"""What a sheared current differs by over the area of a record, and what one is unsure of anyway [m/s]."""


@dataclass(frozen=True)
class Linear:
    """A set's model linearised: y ≈ columns·coefficients + noise, coefficients ~ N(0, prior_sd²).

    Attributes
    ----------
    about : array, shape (k,)
        Coordinates about which it is linearised.
    y : array, shape (2, n)
        Data on the principal axes [m/s].
    columns : array, shape (2, n, k + m)
        Of the k coordinates, then of the m ways in which oscillating causes waver.
    prior_sd : array, shape (k + m,)
        Prior standard deviations.
    """

    about: Array
    y: Array
    columns: Array
    prior_sd: Array

    @cached_property
    def joined(self) -> Array:
        """Columns and, last, data, shape (2, n, k + m + 1)."""
        return np.concatenate([self.columns, self.y[:, :, None]], axis=2)


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

    def minimum_evidence_gain(self, causes: Causes) -> float:
        """The usual: what the catalogue adds is as good as linear in its strengths, and of known shape."""
        return MINIMUM_EVIDENCE_GAIN

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
        if np.hypot(*self.leg.along.mean(axis=1)) > NARROW:
            why["compass-deviation"] = "needs headings over at least half the compass"
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
            elif name == "current-shear":
                found += [self._limited(coordinate) for coordinate in coordinates_of(CATALOGUE[name])]
            elif name not in RANDOM:
                found += coordinates_of(CATALOGUE[name])
        return tuple(found)

    def _limited(self, gradient: Coordinate) -> Coordinate:
        """Limit a gradient's priors: over the whole area a current changes by no more than currents are strong."""
        place = self.data.start + 0.5 * (self.data.dead_reckoned - self.data.start)
        extent = max(float(np.sqrt(np.sum(place.var(axis=1)))), 1.0)
        slab, spike = min(gradient.slab, ACROSS / extent), min(gradient.spike, ACROSS_UNSURE / extent)
        return replace(gradient, slab=slab, spike=spike)

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

    def linearised(self, causes: Causes, about: Array) -> Linear:
        """Linearise the model of a set about coordinates, with what its oscillating causes do there beside."""
        prior = self.prior_sd(causes)
        if not np.any(about):
            return Linear(about, self.y, self._columns_at_zero, prior)
        columns = self.columns(about) if set(TURNING) & set(causes) else self._columns_at_zero
        y = self.y - self.mean_error(about) + columns @ about
        beside = [self._waver(name, about) for name in WAVERING if name in causes]
        extra = np.concatenate([np.zeros((2, self.data.n, 0)), *beside], axis=2)
        return Linear(about, y, np.concatenate([columns, extra], axis=2), np.append(prior, np.ones(extra.shape[2])))

    def _waver(self, name: str, about: Array) -> Array:
        """Columns of what an oscillating cause does beside its steady oscillation, shape (2, n, m)."""
        own = self._by_effect[name]
        later = about.copy()
        later[own[::2]], later[own[1::2]] = -about[own[1::2]], about[own[::2]]
        steady = [self._error(own, values) for values in (about, later)]
        # an inertial current turns as one; the ellipses of tidal constituents differ
        parts = np.ones((1, 2)) if name == "inertial-current" else np.eye(2)
        columns = [modulation(self.data.middle, *(part[:, None] * each for each in steady)) for part in parts]
        return np.asarray(np.einsum("ij,jnm->inm", self.axes.T, np.concatenate(columns, axis=2)))
