"""Transits of a vehicle with a propeller: speed from shaft rate, setting off from rest, speed inferred wrongly."""

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from missionplan.arrays import Scalars
from missionplan.effects.speed_scale import SpeedScale
from missionplan.montecarlo.distributions import mean_of
from missionplan.physics.added_mass import lamb_axial_coefficient
from missionplan.physics.buoyancy import displaced_mass
from missionplan.physics.cruise import cruise_speed, distance_lost, shaft_rate_for, speed_error
from missionplan.physics.propeller import Propeller, Resistance
from missionplan.scenario.measured_vehicle import propeller

if TYPE_CHECKING:
    from missionplan.scenario.scenario import Scenario

LONG_AGO = 1e9
"""A leg so long that setting off does not count [s]."""


def shaft_speeds(scenario: "Scenario") -> Mapping[str, Scalars]:
    """Speeds of the transits that give a shaft rate, by key path [m/s]; empty where none does."""
    found: dict[str, Scalars] = {}
    for phase in scenario.mission.transits:
        unit = _propeller(scenario) if phase.shaft_rate is not None else None
        if unit is not None:
            rate = scenario[f"{phase.name}.shaft_rate"]
            found[f"{phase.name}.speed"] = _plain(cruise_speed(unit, rate, scenario.vehicle_drag))
    return found


def length_lost(scenario: "Scenario", speed: Scalars) -> Scalars | None:
    """Distance by which a leg falls short while the vehicle gathers way [m]; None without a propeller or a mass."""
    unit, vehicle = _propeller(scenario), scenario.mission.vehicle
    if unit is None or vehicle is None or vehicle.mass is None:
        return None
    drag = scenario.vehicle_drag(speed)
    resistance = Resistance(mass=moving_mass(scenario), linear=0.0, quadratic=drag / speed**2)
    return _plain(distance_lost(unit, resistance, shaft_rate_for(unit, drag, speed)))


def moving_mass(scenario: "Scenario") -> Scalars:
    """Mass and added mass of the egress vehicle in surge [kg]."""
    hull = scenario.vehicle_drag.hull
    displaced = displaced_mass(scenario["vehicle.mass"], scenario["vehicle.net_buoyancy"])
    fraction = scenario.get("vehicle.hull.added_mass", lamb_axial_coefficient(hull.length / hull.diameter))
    return scenario["vehicle.mass"] + scenario.get("vehicle.added_mass.surge", fraction * displaced)


def inferred_speed(scenario: "Scenario", speed: Scalars) -> tuple[SpeedScale, ...]:
    """What goes wrong where speed is inferred from the shaft rate with another thrust and drag than the true ones.

    The vehicle believes in the speed that its file's propeller and drag give; the true ones are `thrust_factor` and
    `drag_factor` times as large. Gathering way is not in it: the vehicle's clock allows for that.
    """
    unit, path = _propeller(scenario), "vehicle.propulsion"
    if unit is None:
        return ()
    thrust, drag = scenario[f"{path}.thrust_factor"], scenario[f"{path}.drag_factor"]
    if np.all(np.equal(thrust, 1.0)) and np.all(np.equal(drag, 1.0)):
        return ()
    force = scenario.vehicle_drag(speed)
    resistance = Resistance(mass=1.0, linear=0.0, quadratic=force / speed**2)
    rate = shaft_rate_for(unit, force, speed)
    error = speed_error(unit, resistance, rate, LONG_AGO, thrust_factor=thrust, drag_factor=drag)
    return (SpeedScale(_plain(error / speed)),)


def _propeller(scenario: "Scenario") -> Propeller | None:
    vehicle, site = scenario.mission.vehicle, scenario.mission.site
    if vehicle is None or site is None or site.water is None:
        return None
    expected = {path: mean_of(value) for path, value in scenario.mission.quantities().items()}
    return propeller(vehicle, float(replace(scenario, draws=expected).water.density), scenario.draws)


def _plain(value: Scalars) -> Scalars:
    """A float where nothing was drawn."""
    array = np.asarray(value)
    return float(array) if array.ndim == 0 else array
