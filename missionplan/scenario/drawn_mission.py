"""A mission with a value, or one a trial, in place of each distribution: what does not depend on the phase."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product
from typing import Self

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.effects import CATALOGUE, Effect
from missionplan.mission import Mission
from missionplan.mission.schema.effect_list import LIKELY, EffectEntry
from missionplan.mission.schema.phases import MoorPhase, Navigation, TransitPhase
from missionplan.mission.schema.place import Geographic, Position, to_plane
from missionplan.mission.schema.site import SlopeSection
from missionplan.mission.schema.vehicle import EnergyBudget
from missionplan.mission.views import MooringMission, navigation_of, required, required_origin, transit_of
from missionplan.phases.hooks import DescentEffect, TransitEffect
from missionplan.phases.transit.plan import VelocityError
from missionplan.physics.drag import VehicleDrag
from missionplan.physics.water import Water, sea_water
from missionplan.scenario.transits import PropelledVehicle, propeller, vehicle_drag

NO_BUDGET: EnergyBudget[Scalars] = EnergyBudget.model_construct(
    hotel=float("nan"), propulsive_efficiency=float("nan"), surfacing=float("nan")
)


@dataclass(frozen=True)
class DrawnMission:
    """A mission, and the same mission drawn."""

    mission: Mission
    """As its file has it, with distributions."""
    drawn: Mission[Scalars]
    """With a value, or one a trial, for each of its quantities, float or shape (n,) [SI]."""

    @property
    def trials(self) -> int:
        """Trials of the draws; 1 where nothing is uncertain."""
        return max((np.size(value) for value in self.drawn.quantities().values()), default=1)

    def position(self, position: Position[Scalars]) -> Array:
        """Return a position east and north of the origin, shape (2,) or (2, n) [m].

        Raises InputError when it is given by latitude and longitude, and the mission has no origin.
        """
        if isinstance(position, Geographic):
            origin = required_origin(self.mission, "positions by latitude and longitude need it")
            return np.concatenate(to_plane(np.array([position.latitude]), np.array([position.longitude]), origin))
        return _vector(*position)

    @cached_property
    def mooring(self) -> MooringMission[Scalars]:
        """What moorings need.

        Raises InputError with everything that is missing.
        """
        return MooringMission.of(self.drawn)

    def transit(self, name: str | None = None) -> TransitPhase[Scalars]:
        """Return the transit of that name, by default the first; InputError where there is none."""
        return transit_of(self.drawn, name)

    def moor(self, name: str | None = None) -> MoorPhase[Scalars]:
        """Return the mooring of that name, by default the first; InputError where there is none."""
        return self.mooring.mooring(name)

    @cached_property
    def water(self) -> Water:
        """The site's water."""
        return _water(self.drawn)

    def at_depth(self, depth: Scalars, slope: SlopeSection[Scalars] | None = None) -> Self:
        """Return the mission where the water is as deep as this [m], over ground of this slope or the file's."""
        site = required(self.drawn.site, self.mission, "site", "a mooring needs it")
        deep = site.model_copy(update={"depth": depth, "slope": slope or site.slope})
        return replace(self, drawn=self.drawn.model_copy(update={"site": deep}))

    @property
    def latitude(self) -> float:
        """Latitude of the origin [rad]; nan where the mission has none."""
        site = self.mission.site
        return site.origin.latitude if site and site.origin else float("nan")

    @cached_property
    def vehicle_drag(self) -> VehicleDrag:
        """Drag of the egress vehicle.

        Raises InputError when the mission has no vehicle.
        """
        vehicle = required(self.drawn.vehicle, self.mission, "vehicle", "the drag is computed from it")
        return vehicle_drag(vehicle, self.water)

    @cached_property
    def propelled(self) -> PropelledVehicle | None:
        """The vehicle with its propeller; None where it has none, or the mission no water."""
        vehicle, site = self.drawn.vehicle, self.drawn.site
        if vehicle is None or vehicle.propulsion is None or site is None or site.water is None:
            return None
        unit = propeller(vehicle.propulsion, float(_water(self.mission.at_means()).density))
        return PropelledVehicle(unit, vehicle, vehicle.propulsion, self.vehicle_drag)

    @cached_property
    def means(self) -> "DrawnMission":
        """The same mission at its means."""
        return DrawnMission(self.mission, self.mission.at_means())

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

    @property
    def budget(self) -> EnergyBudget[Scalars]:
        """The energy budget; of nan where the mission has none."""
        return self.drawn.budget or NO_BUDGET

    @property
    def surfacing_time(self) -> Scalars:
        """Time at the surface for a fix [s]; 0 without a section `navigation`."""
        return self.drawn.navigation.surfacing_time if self.drawn.navigation else 0.0

    @property
    def fix_error(self) -> Scalars:
        """Standard deviation of a fix, each axis, without effects [m]."""
        return self.drawn.navigation.fix_error if self.drawn.navigation else 0.0

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
        capacity = self.budget.capacity
        return float("inf") if capacity is None else capacity

    @cached_property
    def navigation(self) -> Navigation:
        """The mission's section `navigation`.

        Raises InputError when the mission has no transit or no such section.
        """
        return navigation_of(self.mission)

    @cached_property
    def _effects(self) -> tuple[Effect, ...]:
        return tuple(
            self._held(entry)
            for entry in self.drawn.effects
            if CATALOGUE[entry.effect].changes_plan  # a clock or a sensor that is off moves no vehicle
        )

    @cached_property
    def effects_on_readings_too(self) -> tuple[Effect, ...]:
        """All effects with their parameters as drawn, those on clocks and sensors too."""
        return tuple(self._held(entry) for entry in self.drawn.effects)

    def _held(self, entry: EffectEntry[Scalars]) -> Effect:
        """Make an effect, of an explanation for the trials in which that holds."""
        info = CATALOGUE[entry.effect]
        if entry.explanation is None:
            return info.make(entry.parameters)
        place, numbers = entry.explanation
        (which,) = (doubt.which for doubt in self.drawn.doubts if doubt.place == place)
        return info.make_where(entry.parameters, np.isin(which, numbers))

    def under_explanations(self) -> Iterator[Self]:
        """Yield the mission under each combination of the explanations that are likely enough to plan for."""
        doubts = [doubt for doubt in self.mission.doubts if doubt.told_apart]
        likely = [[k for k in doubt.told_apart if doubt.probabilities[k] >= LIKELY] for doubt in doubts]
        for numbers in product(*likely):
            mission = self.mission
            for doubt, number in zip(doubts, numbers, strict=True):
                mission = mission.knowing(doubt.place, number)
            effects = {"effect_list": mission.at_means().effect_list}
            yield replace(self, drawn=self.drawn.model_copy(update=effects)) if doubts else self

    @cached_property
    def velocity_error(self) -> VelocityError:
        """Velocity error of the legs; its mean and a sigma as drawn."""
        error = navigation_of(self.drawn).velocity_error
        mean = _vector(*error.mean)
        if error.sigma is None:
            return VelocityError.general(self.navigation.velocity_error.covariance, mean)
        return VelocityError.isotropic(error.sigma, mean)


def _vector(east: Scalars, north: Scalars) -> Array:
    """Return a vector from its components, shape (2,) or (2, n)."""
    if isinstance(east, float) and isinstance(north, float):
        return np.array([east, north])
    return np.stack(np.broadcast_arrays(np.asarray(east, dtype=float), np.asarray(north, dtype=float)))


def _water(mission: Mission[Scalars]) -> Water:
    water = required(mission.site.water if mission.site else None, mission, "site.water", "the drag depends on it")
    if water.density is not None and water.viscosity is not None:
        return Water(water.density, water.viscosity)
    if water.temperature is None or water.salinity is None:
        raise AssertionError("water has two of its quantities")  # as its section is read
    return sea_water(water.temperature, water.salinity)
