"""Mean of a navigation log's velocity errors: linear in the causes' coordinates, through the effects' own hooks."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import cast

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.datasets.records import TransitData
from missionplan.diagnosis.coordinates import Coordinate, coordinates_of, parameters_from
from missionplan.diagnosis.given import GivenEffect, held, places_in, tied
from missionplan.diagnosis.legs.likelihood.fix_gaps import FixGaps, fix_gaps
from missionplan.diagnosis.legs.likelihood.linearised import CoordinatePrior, HeldEffect, LinearisedLegs
from missionplan.diagnosis.legs.likelihood.modulation import (
    STEADY,
    Forms,
    Modulation,
    modulated_columns,
    smooth_functions,
)
from missionplan.effects import CATALOGUE, effects_of, named_effects
from missionplan.effects.info import LegRecord
from missionplan.effects.oscillation import MODULATION_PARAMETERS
from missionplan.phases.hooks import Leg, TransitEffect, surface_velocity, velocity_error
from missionplan.results.learned.evidence import Causes

DIFFERENCE_STEP = 1e-3
"""Step of the central differences, in slabs (prior standard deviations of a cause)."""


@dataclass(frozen=True)
class ActingTerm:
    """A term of an effect as it acts on a log: its strengths are fitted, its shape is one of those tried."""

    effect: str
    coordinates: tuple[Coordinate, ...]
    """Its strengths."""
    shapes: Mapping[str, Scalars]
    """Name and value of the shape on which they depend; empty: none."""


@dataclass(frozen=True)
class TransitMean:
    """Legs of a log, the velocity errors that the mission expects, and the columns of the causes."""

    data: TransitData
    """The log."""
    base: Array
    """Velocity error that the mission expects: site's current and mean of the velocity error, shape (2, n) [m/s]."""
    covariance: Array
    """Σ_v of the mission, shape (2, 2) [m²/s²]."""
    fix_error: float
    """The mission's standard deviation of a fix [m]; 0 when not given."""
    current_sd: tuple[float, float] = (0.0, 0.0)
    """Standard deviation of the mission's steady current, east and north [m/s]."""
    given: tuple[GivenEffect, ...] = ()
    """The mission's own effects on a transit, whose means `base` includes."""
    only: tuple[Coordinate, ...] | None = None
    """Coordinates to use; default those that the record can resolve."""
    fix_share: float = 0.0
    """κ of `fix_gaps`: part of the gap between two fixes that is an error of either."""
    site_current: Array | float = 0.0
    """The site's current on each leg, as the mission has it, shape (2, n) [m/s]."""
    planned: tuple[float, float] | None = None
    """Speed [m/s] and depth [m] of the mission's first transit; None: as on the log's legs."""
    acting: ActingTerm | None = None
    """A term whose strengths are coordinates beside those of the effects that the record can resolve."""

    @cached_property
    def untestable(self) -> Mapping[str, str]:
        """Effects that this record cannot show, and why."""
        reasons = {info.id: info.lacking(self.record) for info in named_effects("transit")}
        return {effect: reason for effect, reason in reasons.items() if reason}

    @cached_property
    def record(self) -> LegRecord:
        """What the record holds, as the effects ask for it."""
        data, speed = self.data, np.asarray(self.leg.speed)
        depths = math.nan if data.depth is None or np.isnan(data.depth).any() else float(np.ptp(data.depth))
        ranges = [float(np.ptp(values) / np.median(values)) for values in (speed, data.under_way)]
        return LegRecord(data.latitude, data.has_surface_time, float(np.ptp(data.middle)), ranges[0], ranges[1], depths)

    @cached_property
    def candidates(self) -> Causes:
        """Effects of the catalogue that this record could show, but for those that act by their terms."""
        infos = (info for info in named_effects("transit") if not info.terms)
        return tuple(info.id for info in infos if info.id not in self.untestable)

    @cached_property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """Coordinates of all causes of the mean, and of the mission's own effects in it."""
        coordinates = list(self._resolvable if self.only is None else self.only)
        if self.acting is not None:
            coordinates += self.acting.coordinates
        return tuple(sorted(coordinates, key=lambda coordinate: self._order[coordinate.effect]))

    @cached_property
    def _resolvable(self) -> list[Coordinate]:
        """Coordinates of the causes of the mean that the record can resolve, and of the mission's own effects in it."""
        coordinates: list[Coordinate] = []
        for info in map(CATALOGUE.__getitem__, self.candidates):
            if info.part == "mean":
                names = info.resolvable(self.record.duration) if info.resolvable is not None else None
                coordinates += [self._limited(coordinate) for coordinate in coordinates_of(info, names)]
        keys = {(coordinate.effect, coordinate.name) for coordinate in coordinates}
        for prior in self.given_in_mean:
            coordinates += [c for c in prior.coordinates if (c.effect, c.name) not in keys]
        return coordinates

    @cached_property
    def _order(self) -> dict[str, int]:
        return {info.id: index for index, info in enumerate(effects_of("transit"))}

    @cached_property
    def given_in_mean(self) -> tuple[GivenEffect, ...]:
        """The mission's own effects on the mean of the errors, without their modulation."""
        pairs = ((prior, CATALOGUE[prior.effect]) for prior in self.given)
        return tuple(
            prior.only(info.parameters.keys() - MODULATION_PARAMETERS.keys()) if info.is_modulated else prior
            for prior, info in pairs
            if info.part == "mean"
        )

    @cached_property
    def expected(self) -> Array:
        """Coordinates that the mission expects: those of its own effects, zero for the others, shape (k,)."""
        values = np.zeros(len(self.coordinates))
        for prior in self.given_in_mean:
            values[places_in(self.coordinates, prior)] = prior.mean
        return values

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
        """Velocity errors less those that the mission expects and those that gaps between fixes tell, shape (2, n).

        On the principal axes [m/s].
        """
        gap_error = self.fix_share * self.gaps.velocity_error(self.data.under_way) if self.fix_share else 0.0
        return self.axes.T @ (self.data.velocity_error - self.base - gap_error)

    @cached_property
    def gaps(self) -> FixGaps:
        """Gaps between the fix after a leg and the one before the next."""
        return fix_gaps(self.data)

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
            math.nan if data.depth is None else data.depth,
        )

    def mean_error(self, values: Array) -> Array:
        """Velocity errors caused by the effects in the mean, on the principal axes, shape (2, n) [m/s]."""
        return self.axes.T @ self._error(tuple(self.by_effect), values)

    @cached_property
    def by_effect(self) -> dict[str, list[int]]:
        """Indices of each effect's coordinates."""
        indices: dict[str, list[int]] = {}
        for index, coordinate in enumerate(self.coordinates):
            indices.setdefault(coordinate.effect, []).append(index)
        return indices

    def velocity_error(self, effects: Iterable[TransitEffect]) -> Array:
        """Mean velocity errors of effects together, drift at the surface included, shape (2, n) [m/s]."""
        data, effects = self.data, tuple(effects)
        drift = surface_velocity(effects, data.t_start + data.under_way, data.surface, data.end)
        return velocity_error(effects, self.leg, self.site_current) + drift * data.surface / data.under_way

    def water(self, names: Iterable[str], values: Array) -> Array:
        """Velocity of the water on each leg by the site's current and some effects, shape (2, n) [m/s]."""
        indices = [index for name in names for index in self.by_effect.get(name, ())]
        made = parameters_from([self.coordinates[index] for index in indices], values[indices])
        effects = (cast(TransitEffect, CATALOGUE[name].make(parameters)) for name, parameters in made.items())
        moved = (effect.velocity(self.leg) for effect in effects if not effect.changes_course)
        return np.asarray(sum(moved, np.zeros((2, self.data.n))) + self.site_current)

    def _error(self, names: Sequence[str], values: Array) -> Array:
        """Velocity errors east and north that some effects cause together, shape (2, n) [m/s]."""
        return self.velocity_error(self._made(names, values).values())

    def _made(self, names: Iterable[str], values: Array) -> dict[str, TransitEffect]:
        """Effects of some names at given coordinates."""
        indices = [index for name in names for index in self.by_effect[name]]
        made = parameters_from([self.coordinates[index] for index in indices], values[indices])
        if self.acting is not None and self.acting.effect in made:
            made[self.acting.effect] |= self.acting.shapes
        return {name: cast(TransitEffect, CATALOGUE[name].make(parameters)) for name, parameters in made.items()}

    @cached_property
    def _on_course(self) -> tuple[str, ...]:
        """Effects of which one changes another's column.

        Factors on the velocity through the water multiply; what answers to a current does so to that of all effects.
        """
        made = {name: cast(TransitEffect, CATALOGUE[name].make({})) for name in self.by_effect}
        if any(effect.answers_current for effect in made.values()):
            return tuple(made)
        return tuple(name for name, effect in made.items() if effect.changes_course)

    def columns(self, about: Array) -> Array:
        """Columns of the coordinates, by central differences of the effects' hooks, shape (2, n, k)."""
        columns = self.columns_as_expected.copy()
        changed = [i for i, c in enumerate(self.coordinates) if not self.is_the_same_everywhere(c.effect)]
        columns[:, :, changed] = self._differences(changed, about)
        return columns

    def is_the_same_everywhere(self, effect: str) -> bool:
        """Whether an effect's columns do not depend on the point about which the model is linearised."""
        return CATALOGUE[effect].linear and effect not in self._on_course

    def _differences(self, indices: Sequence[int], about: Array) -> Array:
        """Columns of some coordinates, all other effects held where they are, shape (2, n, m)."""
        effects = {name: HeldEffect(effect, self.leg) for name, effect in self._made(self._on_course, about).items()}
        columns = np.empty((2, self.data.n, len(indices)))
        for place, index in enumerate(indices):
            coordinate = self.coordinates[index]
            beside = effects if coordinate.effect in effects else {}
            step = np.zeros(len(about))
            step[index] = DIFFERENCE_STEP * coordinate.slab
            ahead, behind = (
                self.velocity_error({**beside, **self._made((coordinate.effect,), about + sign * step)}.values())
                for sign in (1.0, -1.0)
            )
            columns[:, :, place] = self.axes.T @ (ahead - behind) / (2.0 * step[index])
        return columns

    @cached_property
    def columns_as_expected(self) -> Array:
        """Columns of the coordinates as the mission expects them, shape (2, n, k)."""
        return self._differences(range(len(self.coordinates)), self.expected)

    @cached_property
    def _error_as_expected(self) -> Array:
        return self.mean_error(self.expected)

    def prior(self, causes: Causes) -> CoordinatePrior:
        """Prior of the coordinates: slabs of the causes, what the mission knows of its own effects, spikes."""
        spread = np.array([c.slab if c.effect in causes else c.spike for c in self.coordinates])
        for index, coordinate in enumerate(self.coordinates):
            if CATALOGUE[coordinate.effect].is_steady_current:
                spread[index] = math.hypot(spread[index], self.current_sd[coordinate.name == "north"])
        mean, factor = np.zeros(len(spread)), np.diag(spread)
        for prior in tied(held(self.given_in_mean, causes)):
            indices = places_in(self.coordinates, prior)
            mean[indices] = prior.mean
            values, vectors = np.linalg.eigh(prior.here)
            factor[np.ix_(indices, indices)] = vectors * np.sqrt(np.maximum(values, 0.0))
        return CoordinatePrior(mean, factor)

    def linearised(self, causes: Causes, about: Array | None = None, forms: Forms = STEADY) -> LinearisedLegs:
        """Linearise the model of a set about given coordinates, with columns that modulate its oscillations.

        `causes`: the set. `about`, shape (k,), optional: default as the mission expects. `forms`: oscillations that are
        not steady.
        """
        prior, y, columns = self.prior(causes), self.y, self.columns_as_expected
        if about is None:
            about = self.expected
        else:
            y = y - (self.mean_error(about) - self._error_as_expected)
            columns = columns if all(CATALOGUE[name].linear for name in causes) else self.columns(about)
        y = y + columns @ (about - prior.mean)
        of_modulations = [self._modulation_columns(name, about) for name in forms.modulated]
        of_modulations += [self._wandering_columns(name) for name in forms.wandering]
        standardised = np.concatenate([columns @ prior.factor, *(block for _, block in of_modulations)], axis=2)
        slabs = {name: indices for name, indices in self.by_effect.items() if name in causes}
        return LinearisedLegs(
            about, prior, y, standardised, slabs, tuple(modulation for modulation, _ in of_modulations)
        )

    def _wandering_columns(self, name: str) -> tuple[Modulation, Array]:
        """Slow amplitude of an oscillation that wanders, in usual sizes, and its columns, shape (2, n, m)."""
        usual = np.zeros(len(self.coordinates))
        first = self.by_effect[name][0]
        usual[first] = self.coordinates[first].slab
        modulation, columns = self._modulation_columns(name, usual)
        return replace(modulation, wanders_over=self.data.middle), columns

    def _modulation_columns(self, name: str, about: Array) -> tuple[Modulation, Array]:
        """Slow modulation of an oscillation, and its columns, shape (2, n, m)."""
        indices = self.by_effect[name]
        quadrature = about.copy()
        quadrature[indices[::2]], quadrature[indices[1::2]] = -about[indices[1::2]], about[indices[::2]]
        in_phase, in_quadrature = (self._error((name,), values) for values in (about, quadrature))
        modulation, functions = smooth_functions(name, self.data.middle)
        columns = modulated_columns(functions, in_phase, in_quadrature)
        return modulation, np.asarray(np.einsum("ij,jnm->inm", self.axes.T, columns))
