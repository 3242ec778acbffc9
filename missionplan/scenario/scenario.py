"""A mission with the draws of a block of trials, as what its phases share and the parameters of its transits."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.effects import CATALOGUE, Effect
from missionplan.mission import Mission
from missionplan.mission.geodesy import to_plane
from missionplan.mission.schema.navigation import Navigation
from missionplan.mission.schema.phases import LegTableSection, TransitPhase
from missionplan.mission.schema.site import Geographic, Position
from missionplan.mission.views import TransitMission, required, required_origin
from missionplan.montecarlo.distributions import mean_of
from missionplan.montecarlo.draws import Correlation, JointDistribution
from missionplan.montecarlo.streams import BLOCK
from missionplan.phases.currents import Current, LayeredCurrent, layers
from missionplan.phases.hooks import DescentEffect, TransitEffect
from missionplan.phases.transit.compensation import Compensation, Forecast, compensation_named
from missionplan.phases.transit.kalman_filter import DriftFilter
from missionplan.phases.transit.leg_table import LegTable
from missionplan.phases.transit.plan import TransitPlan, VelocityError
from missionplan.physics.drag import FORM_CONSTANTS
from missionplan.physics.energy import propulsive_power
from missionplan.physics.vehicle_drag import Hull, Sail, VehicleDrag
from missionplan.physics.water import Water, sea_water
from missionplan.scenario.drift_model import drift_model
from missionplan.scenario.measured_vehicle import measured_drag, propeller, propeller_power
from missionplan.scenario.shaft_speed import inferred_speed, length_lost, shaft_speeds

STILL_WATER = LayeredCurrent(np.ones(1), np.zeros(1), np.zeros(1))
"""For phases that need a current where the mission has none."""

PRIOR = 1 << 41
"""Block of draws from which a filter's prior is taken: never one that a trial is run with."""


@dataclass(frozen=True)
class Scenario:
    """A mission and one draw a trial of everything uncertain in it.

    Attributes
    ----------
    mission : Mission
    recorded : Current or None
        The site's current where the mission reads it from a file (`site_current.recorded_current`).
    draws : mapping of str to float or array, shape (n,)
        Every quantity of the mission by its key path.
    expected : Scenario or None
        The mission at its means, where it is at hand: see `means`.
    """

    mission: Mission
    recorded: Current | None
    draws: Mapping[str, Scalars]
    expected: "Scenario | None" = None

    @classmethod
    def at_means(cls, mission: Mission, recorded: Current | None = None) -> "Scenario":
        """Give the mission with every distribution at its mean."""
        means = {path: mean_of(value) for path, value in mission.quantities().items()}
        return cls(mission, recorded, means)._with_shaft_speeds()

    @classmethod
    def drawn(
        cls, mission: Mission, recorded: Current | None = None, *, seed: int, block: int, size: int = BLOCK
    ) -> "Scenario":
        """Draw a block of trials."""
        return cls.at_means(mission, recorded).sampled(seed=seed, block=block, size=size)

    def sampled(self, *, seed: int, block: int, size: int = BLOCK) -> "Scenario":
        """Draw a block of trials about this setting at the means; what blocks have in common is made once, in it."""
        draws = {**self.draws, **self._joint.draw(seed, block, size)}
        return replace(self, draws=draws, expected=self)._with_shaft_speeds()

    @cached_property
    def _joint(self) -> JointDistribution:
        ties = [Correlation(correlation.between, correlation.rho) for correlation in self.mission.correlations]
        return JointDistribution.of(self.mission.quantities(), ties)

    def _with_shaft_speeds(self) -> "Scenario":
        """Add the speeds that shaft rates give."""
        if all(phase.shaft_rate is None for phase in self.mission.transits):
            return self
        return replace(self, draws={**self.draws, **shaft_speeds(self)})

    @cached_property
    def means(self) -> "Scenario":
        """The same mission at its means: what the vehicle is told beforehand."""
        return self.expected or Scenario.at_means(self.mission, self.recorded)

    @property
    def uncertain(self) -> Sequence[str]:
        """The quantities that are distributions, by key path."""
        return tuple(self.means._joint.marginals)

    def __getitem__(self, path: str) -> Scalars:
        return self.draws[path]

    def get(self, path: str, default: Scalars) -> Scalars:
        """Give a quantity, or `default` where the mission has none at that key path."""
        return self.draws.get(path, default)

    def position(self, position: Position, path: str) -> Array:
        """East and north of the origin, shape (2,) or (2, n) [m]."""
        if isinstance(position, Geographic):
            origin = required_origin(self.mission, "positions by latitude and longitude need it")
            return np.concatenate(to_plane(np.array([position.latitude]), np.array([position.longitude]), origin))
        return _vector(self[f"{path}[0]"], self[f"{path}[1]"])

    @cached_property
    def water(self) -> Water:
        """The site's water."""
        if "site.water.density" in self.draws:
            return Water(self["site.water.density"], self["site.water.viscosity"])
        return sea_water(self["site.water.temperature"], self["site.water.salinity"])

    @cached_property
    def current(self) -> Current | None:
        """The site's current; None in still water."""
        if self.recorded is not None:
            return self.recorded
        written = self.mission.site.current if self.mission.site else ()
        if not isinstance(written, tuple) or not written:
            return None
        paths = [f"site.current[{index}]" for index in range(len(written))]
        return layers(*([self[f"{path}.{key}"] for path in paths] for key in ("down_to", "speed", "toward")))

    @property
    def latitude(self) -> float:
        """Latitude of the origin [rad]; nan where the mission has none."""
        site = self.mission.site
        return site.origin.latitude if site and site.origin else float("nan")

    @cached_property
    def vehicle_drag(self) -> VehicleDrag:
        """Drag of the egress vehicle."""
        vehicle = required(self.mission.vehicle, self.mission, "vehicle", "its drag is asked for")
        form, path = vehicle.hull.form_factor, "vehicle.hull"
        constant = FORM_CONSTANTS[form] if isinstance(form, str) else self[f"{path}.form_factor"]
        hull = Hull(self[f"{path}.length"], self[f"{path}.diameter"], constant)
        sail = Sail(*(self[f"vehicle.sail.{key}"] for key in ("chord", "span", "thickness"))) if vehicle.sail else None
        built_up = VehicleDrag(hull, sail, self["vehicle.appendage_factor"], self.water)
        return measured_drag(vehicle, built_up, self.draws)

    @cached_property
    def transit_effects(self) -> tuple[TransitEffect, ...]:
        """Effects on transits, with their drawn parameters."""
        return tuple(effect for effect in self._effects if isinstance(effect, TransitEffect))

    @property
    def transit_effect_ids(self) -> tuple[str, ...]:
        """Their names in the catalogue, in the same order."""
        return tuple(entry.effect for entry in self.mission.effects if CATALOGUE[entry.effect].phase == "transit")

    @cached_property
    def descent_effects(self) -> tuple[DescentEffect, ...]:
        """Effects on descents, with their drawn parameters."""
        return tuple(effect for effect in self._effects if isinstance(effect, DescentEffect))

    def energy(self, key: str) -> Scalars:
        """A quantity of the energy budget; nan where the mission has no budget."""
        section = "energy" if self.mission.energy else "vehicle.energy"
        return self.get(f"{section}.{key}", float("nan"))

    @property
    def surfacing_time(self) -> Scalars:
        """At the surface each time [s]; 0 without a section `navigation`."""
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
        """What the battery holds [J]; infinite where the mission does not say."""
        capacity = self.energy("capacity")
        return capacity if np.isfinite(capacity).all() else float("inf")

    def transit_plan(self, phase: TransitPhase) -> TransitPlan:
        """What a transit is told.

        Its propulsion is reckoned with the egress vehicle's drag, with or without the anchor on its nose.
        """
        name, table = phase.name, phase.d_max
        speed, hotel = self[f"{name}.speed"], self.energy("hotel")
        return TransitPlan(
            goal=self.position(phase.to, f"{name}.to"),
            speed=speed,
            arrival_radius=self[f"{name}.arrival_radius"],
            d_max=leg_table(table) if isinstance(table, LegTableSection) else self[f"{name}.d_max"],
            surfacing_time=self.surfacing_time,
            velocity_error=self._velocity_error,
            fix_error=self.fix_error,
            depth=self[f"{name}.depth"],
            max_legs=self._navigation.max_legs,
            power_under_way=hotel + self._propulsion(speed),
            power_at_surface=hotel,
            surfacing_energy=self.energy("surfacing"),
            latitude=self.latitude,
            length_lost=length_lost(self, speed),
        )

    def effects_under_way(self, phase: TransitPhase) -> tuple[TransitEffect, ...]:
        """Effects on one transit: the mission's, and a speed inferred wrongly from the shaft rate."""
        if self.mission.vehicle is None or self.mission.vehicle.propulsion is None:
            return self.transit_effects
        return (*self.transit_effects, *inferred_speed(self, self[f"{phase.name}.speed"]))

    def compensation(self, phase: TransitPhase) -> Compensation | None:
        """What the vehicle does about its drift, knowing the means alone."""
        return self.means._compensations[phase.name]

    @cached_property
    def _compensations(self) -> Mapping[str, Compensation | None]:
        """By transit; of the setting at the means."""
        return {phase.name: self._compensation(phase) for phase in self.mission.transits}

    def _compensation(self, phase: TransitPhase) -> Compensation | None:
        navigation = self._navigation
        forecast = Forecast(
            current=self.current,
            mean_error=np.array([float(self[f"navigation.velocity_error.mean[{axis}]"]) for axis in (0, 1)]),
            depth=float(self[f"{phase.name}.depth"]),
            surfacing_time=float(self.surfacing_time),
        )
        way, covariance = navigation.drift_compensation, navigation.velocity_error.covariance
        if way == "filter":
            prior = self.sampled(seed=0, block=PRIOR)
            return DriftFilter(forecast, drift_model(self, prior, phase, forecast))
        return compensation_named(way, forecast, covariance, self.fix_error)

    @cached_property
    def _navigation(self) -> Navigation:
        return TransitMission.of(self.mission).navigation

    @cached_property
    def _effects(self) -> tuple[Effect, ...]:
        return tuple(
            CATALOGUE[entry.effect].make({key: self[f"effects.{entry.effect}.{key}"] for key in entry.parameters})
            for entry in self.mission.effects
            if CATALOGUE[entry.effect].changes_plan  # a clock or a sensor that is off moves no vehicle
        )

    @cached_property
    def _velocity_error(self) -> VelocityError:
        error = self._navigation.velocity_error
        path = "navigation.velocity_error"
        mean = _vector(self[f"{path}.mean[0]"], self[f"{path}.mean[1]"])
        if error.covariance_rows is not None:
            return VelocityError.general(error.covariance, mean)
        return VelocityError.isotropic(self[f"{path}.sigma"], mean)

    def _propulsion(self, speed: Scalars) -> Scalars:
        """Power of propulsion [W]; nan without vehicle or water, from which its drag would follow."""
        if self.mission.vehicle is None or self.mission.site is None or self.mission.site.water is None:
            return float("nan")
        drag = self.vehicle_drag(speed)
        unit = propeller(self.mission.vehicle, float(self.means.water.density), self.draws)
        if unit is not None:
            return propeller_power(unit, drag, speed, self["vehicle.propulsion.motor_efficiency"])
        return propulsive_power(drag, speed, self.energy("propulsive_efficiency"))


def _vector(east: Scalars, north: Scalars) -> Array:
    """Put two components together, shape (2,) or (2, n)."""
    if isinstance(east, float) and isinstance(north, float):
        return np.array([east, north])
    return np.stack(np.broadcast_arrays(np.asarray(east, dtype=float), np.asarray(north, dtype=float)))


def leg_table(table: LegTableSection) -> LegTable:
    """Leg length against distance left, as the transit takes it."""
    left, length = np.array(table.table, dtype=float).T
    return LegTable(left, length)
