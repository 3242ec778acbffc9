"""A mission with a value for each of its quantities: what does not depend on which trial or phase is run."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product
from typing import Self

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.effects import CATALOGUE, Effect
from missionplan.mission import Mission
from missionplan.mission.geodesy import to_plane
from missionplan.mission.schema.effect_list import EffectEntry
from missionplan.mission.schema.navigation import Navigation
from missionplan.mission.schema.site import Geographic, Position
from missionplan.mission.views import TransitMission, required, required_origin
from missionplan.montecarlo.distributions import mean_of
from missionplan.phases.hooks import DescentEffect, TransitEffect
from missionplan.phases.transit.plan import VelocityError
from missionplan.physics.vehicle_drag import VehicleDrag
from missionplan.physics.water import Water, sea_water
from missionplan.scenario.propulsion import PropelledVehicle
from missionplan.scenario.vehicle import propeller, vehicle_drag

LIKELY = 0.05
"""Least probability of an explanation that the worst case allows for."""


@dataclass(frozen=True)
class DrawnMission:
    """A mission and a value, or one per trial, for each of its quantities.

    Attributes
    ----------
    mission : Mission
    draws : mapping of str to float or array, shape (n,)
        Every quantity of the mission by its key path [SI].
    """

    mission: Mission
    draws: Mapping[str, Scalars]

    @property
    def trials(self) -> int:
        """Trials of the draws; 1 where nothing is uncertain."""
        return max((np.size(value) for value in self.draws.values()), default=1)

    def __getitem__(self, path: str) -> Scalars:
        return self.draws[path]

    def get(self, path: str, default: Scalars) -> Scalars:
        """Return a quantity, or `default` where the mission has none at that key path."""
        return self.draws.get(path, default)

    def position(self, position: Position, path: str) -> Array:
        """Return the position at a key path, east and north of the origin, shape (2,) or (2, n) [m].

        Raises
        ------
        InputError
            When it is given by latitude and longitude, and the mission has no origin.
        """
        if isinstance(position, Geographic):
            origin = required_origin(self.mission, "positions by latitude and longitude need it")
            return np.concatenate(to_plane(np.array([position.latitude]), np.array([position.longitude]), origin))
        return _vector(self[f"{path}[0]"], self[f"{path}[1]"])

    @cached_property
    def water(self) -> Water:
        """The site's water."""
        return _water(self.draws)

    @property
    def latitude(self) -> float:
        """Latitude of the origin [rad]; nan where the mission has none."""
        site = self.mission.site
        return site.origin.latitude if site and site.origin else float("nan")

    @cached_property
    def vehicle_drag(self) -> VehicleDrag:
        """Drag of the egress vehicle.

        Raises
        ------
        InputError
            When the mission has no vehicle.
        """
        vehicle = required(self.mission.vehicle, self.mission, "vehicle", "the drag is computed from it")
        return vehicle_drag(vehicle, self.water, self.draws)

    @cached_property
    def propelled(self) -> PropelledVehicle | None:
        """The vehicle with its propeller; None where it has none, or the mission no water."""
        vehicle, site = self.mission.vehicle, self.mission.site
        if vehicle is None or vehicle.propulsion is None or site is None or site.water is None:
            return None
        unit = propeller(vehicle.propulsion, self._mean_density, self.draws)
        return PropelledVehicle(unit, self.vehicle_drag, self.draws)

    @cached_property
    def means(self) -> "DrawnMission":
        """The same mission at its means."""
        return DrawnMission(self.mission, {path: mean_of(value) for path, value in self.mission.quantities().items()})

    @cached_property
    def _mean_density(self) -> float:
        """Density of the water at its mean [kg/m³]."""
        return float(_water({path: mean_of(value) for path, value in self.mission.quantities().items()}).density)

    @cached_property
    def transit_effects(self) -> tuple[TransitEffect, ...]:
        """Effects on transits, with their parameters as drawn."""
        return tuple(effect for effect in self._effects if isinstance(effect, TransitEffect))

    @property
    def transit_effect_streams(self) -> tuple[str, ...]:
        """Names of the streams of their random numbers, in the same order."""
        streams = self.mission.effect_list.streams()
        transit = (entry for entry in self.mission.effects if CATALOGUE[entry.effect].phase == "transit")
        return tuple(streams[entry.place] for entry in transit)

    @cached_property
    def descent_effects(self) -> tuple[DescentEffect, ...]:
        """Effects on descents, with their parameters as drawn."""
        return tuple(effect for effect in self._effects if isinstance(effect, DescentEffect))

    def energy(self, key: str) -> Scalars:
        """Return a quantity of the energy budget [W, J or none]; nan where the mission has no budget."""
        return self.get(f"energy.{key}", float("nan"))

    @property
    def surfacing_time(self) -> Scalars:
        """Time at the surface for a fix [s]; 0 without a section `navigation`."""
        return self.get("navigation.surfacing_time", 0.0)

    @property
    def fix_error(self) -> Scalars:
        """Standard deviation of a fix, each axis, without effects [m]."""
        return self.get("navigation.fix_error", 0.0)

    @cached_property
    def fix_sd(self) -> Scalars:
        """Standard deviation of a fix, each axis, with effects [m]."""
        variance: Scalars = np.square(self.fix_error)
        for effect in self.transit_effects:
            variance = variance + effect.fix_variance()
        return np.sqrt(variance)

    @property
    def capacity(self) -> Scalars:
        """Energy in the battery [J]; infinite where the mission gives none."""
        capacity = self.energy("capacity")
        return capacity if np.isfinite(capacity).all() else float("inf")

    @cached_property
    def navigation(self) -> Navigation:
        """The mission's section `navigation`.

        Raises
        ------
        InputError
            When the mission has no transit or no such section.
        """
        return TransitMission.of(self.mission).navigation

    @cached_property
    def _effects(self) -> tuple[Effect, ...]:
        return tuple(
            self._held(entry)
            for entry in self.mission.effects
            if CATALOGUE[entry.effect].changes_plan  # a clock or a sensor that is off moves no vehicle
        )

    @cached_property
    def effects_on_readings_too(self) -> tuple[Effect, ...]:
        """All effects with their parameters as drawn, those on clocks and sensors too."""
        return tuple(self._held(entry) for entry in self.mission.effects)

    def _held(self, entry: EffectEntry) -> Effect:
        """Make an effect, of an explanation for the trials in which that holds."""
        info, values = CATALOGUE[entry.effect], {key: self[f"{entry.place}.{key}"] for key in entry.parameters}
        if entry.explanation is None:
            return info.make(values)
        place, number = entry.explanation
        return info.make_where(values, np.asarray(self[place]) == number)

    def under_explanations(self) -> Iterator[Self]:
        """Yield the mission under each combination of the explanations that are likely enough to plan for."""
        doubts = [doubt for doubt in self.mission.doubts if doubt.known is None]
        likely = [[k for k, share in enumerate(doubt.probabilities) if share >= LIKELY] for doubt in doubts]
        for numbers in product(*likely):
            held = {doubt.place: float(number) for doubt, number in zip(doubts, numbers, strict=True)}
            yield replace(self, draws={**self.draws, **held}) if held else self

    @cached_property
    def velocity_error(self) -> VelocityError:
        """Velocity error of the legs; its mean and a sigma as drawn."""
        error = self.navigation.velocity_error
        path = "navigation.velocity_error"
        mean = _vector(self[f"{path}.mean[0]"], self[f"{path}.mean[1]"])
        if error.covariance_rows is not None:
            return VelocityError.general(error.covariance, mean)
        return VelocityError.isotropic(self[f"{path}.sigma"], mean)


def _vector(east: Scalars, north: Scalars) -> Array:
    """Return a vector from its components, shape (2,) or (2, n)."""
    if isinstance(east, float) and isinstance(north, float):
        return np.array([east, north])
    return np.stack(np.broadcast_arrays(np.asarray(east, dtype=float), np.asarray(north, dtype=float)))


def _water(draws: Mapping[str, Scalars]) -> Water:
    if "site.water.density" in draws:
        return Water(draws["site.water.density"], draws["site.water.viscosity"])
    return sea_water(draws["site.water.temperature"], draws["site.water.salinity"])
