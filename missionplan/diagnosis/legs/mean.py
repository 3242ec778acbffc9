"""Mean of a navigation log's velocity errors: linear in the causes' coordinates, through the effects' own hooks."""

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
from missionplan.effects.info import LegRecord
from missionplan.phases.hooks import Leg, TransitEffect
from missionplan.results.evidence import Causes

DIFFERENCE_STEP = 1e-3
"""Step of the central differences, in slabs (prior standard deviations of a cause)."""


@dataclass(frozen=True)
class LinearisedLegs:
    """Linearised model of a set of causes: y ≈ columns·coefficients + noise, coefficients ~ N(0, prior_sd²).

    Attributes
    ----------
    about : array, shape (k,)
        Coordinates about which it is linearised.
    y : array, shape (2, n)
        Velocity errors on the principal axes [m/s].
    columns : array, shape (2, n, k + m)
        Of the k coordinates, then of the m functions that modulate oscillating causes.
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
    """Legs of a log, the velocity errors that the mission expects, and the columns of the causes.

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
        Standard deviation of the mission's steady current, east and north [m/s].
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
        """Return the default: effects are nearly linear in their strengths, and of known shape."""
        return MINIMUM_EVIDENCE_GAIN

    @cached_property
    def untestable(self) -> Mapping[str, str]:
        """Effects that this record cannot show, and why."""
        reasons = {info.id: info.lacking(self._record) for info in effects_of("transit")}
        return {effect: reason for effect, reason in reasons.items() if reason}

    @cached_property
    def _record(self) -> LegRecord:
        """What the record holds, as the effects ask for it."""
        data, mean_heading = self.data, float(np.hypot(*self.leg.along.mean(axis=1)))
        return LegRecord(data.latitude, data.has_surface_time, float(np.ptp(data.middle)), mean_heading)

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
        for info in map(CATALOGUE.__getitem__, self.candidates):
            if info.part == "mean":
                names = info.resolvable(self._record.duration) if info.resolvable is not None else None
                found += [self._limited(coordinate) for coordinate in coordinates_of(info, names)]
        return tuple(found)

    def _limited(self, coordinate: Coordinate) -> Coordinate:
        """Limit a gradient's priors by what it changes over the area of the record."""
        parameter = CATALOGUE[coordinate.effect].parameters[coordinate.name]
        slab = min(coordinate.slab, parameter.extent_scale / self._extent)
        return replace(coordinate, slab=slab, spike=min(coordinate.spike, parameter.extent_spike / self._extent))

    @cached_property
    def _extent(self) -> float:
        """Root mean square distance of the legs' middles from their centre, at least 1 m [m]."""
        place = self.data.start + 0.5 * (self.data.dead_reckoned - self.data.start)
        return max(float(np.sqrt(np.sum(place.var(axis=1)))), 1.0)

    @cached_property
    def axes(self) -> Array:
        """Principal axes of Σ_v as columns, shape (2, 2); east and north when it is isotropic."""
        if np.allclose(self.covariance, self.covariance[0, 0] * np.eye(2)):
            return np.eye(2)
        return cast(Array, np.linalg.eigh(self.covariance)[1])

    @cached_property
    def y(self) -> Array:
        """Velocity errors minus those that the mission expects, on the principal axes, shape (2, n) [m/s]."""
        return self.axes.T @ (self.data.velocity_error - self.base)

    @cached_property
    def leg(self) -> Leg:
        """Legs in the form that effects take, with the dead-reckoned course."""
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
        """Velocity errors caused by the effects in the mean, on the principal axes, shape (2, n) [m/s]."""
        return self.axes.T @ sum(
            (self._error(own, values) for own in self._by_effect.values()), np.zeros((2, self.data.n))
        )

    @cached_property
    def _by_effect(self) -> dict[str, list[int]]:
        """Indices of each effect's coordinates."""
        found: dict[str, list[int]] = {}
        for index, coordinate in enumerate(self.coordinates):
            found.setdefault(coordinate.effect, []).append(index)
        return found

    def _error(self, own: list[int], values: Array) -> Array:
        """Velocity errors east and north caused by one effect, shape (2, n) [m/s]."""
        data = self.data
        ((name, parameters),) = parameters_from([self.coordinates[i] for i in own], values[own]).items()
        effect = cast(TransitEffect, CATALOGUE[name].make(parameters))
        drift = effect.surface_velocity(data.t_start + data.under_way, data.surface, data.end)
        return effect.velocity(self.leg) + drift * data.surface / data.under_way

    def columns(self, about: Array) -> Array:
        """Columns of the coordinates, by central differences of the effects' hooks, shape (2, n, k)."""
        columns = []
        for index, coordinate in enumerate(self.coordinates):
            own, step = self._by_effect[coordinate.effect], np.zeros(len(about))
            step[index] = DIFFERENCE_STEP * coordinate.slab
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
            if CATALOGUE[coordinate.effect].is_steady_current:
                values[index] = math.hypot(values[index], self.current_sd[coordinate.name == "north"])
        return np.array(values)

    def linearised(self, causes: Causes, about: Array) -> LinearisedLegs:
        """Linearise the model of a set about given coordinates, with columns that modulate its oscillating causes."""
        prior = self.prior_sd(causes)
        if not np.any(about):
            return LinearisedLegs(about, self.y, self._columns_at_zero, prior)
        linear = all(CATALOGUE[name].linear for name in causes)
        columns = self._columns_at_zero if linear else self.columns(about)
        y = self.y - self.mean_error(about) + columns @ about
        modulated = [self._modulation_columns(name, about) for name in self._modulated(causes)]
        extra = np.concatenate([np.zeros((2, self.data.n, 0)), *modulated], axis=2)
        return LinearisedLegs(
            about, y, np.concatenate([columns, extra], axis=2), np.append(prior, np.ones(extra.shape[2]))
        )

    @staticmethod
    def _modulated(causes: Causes) -> tuple[str, ...]:
        """Oscillating causes whose amplitude and phase change slowly, in the catalogue's order; see `modulation`."""
        return tuple(info.id for info in effects_of("transit") if info.modulation and info.id in causes)

    def _modulation_columns(self, name: str, about: Array) -> Array:
        """Columns of the slow modulation of an oscillating cause, shape (2, n, m)."""
        own = self._by_effect[name]
        quadrature = about.copy()
        quadrature[own[::2]], quadrature[own[1::2]] = -about[own[1::2]], about[own[::2]]
        steady = [self._error(own, values) for values in (about, quadrature)]
        components = np.ones((1, 2)) if CATALOGUE[name].modulation == "together" else np.eye(2)
        columns = [
            modulation(self.data.middle, *(component[:, None] * each for each in steady)) for component in components
        ]
        return np.asarray(np.einsum("ij,jnm->inm", self.axes.T, np.concatenate(columns, axis=2)))
