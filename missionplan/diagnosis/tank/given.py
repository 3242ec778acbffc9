"""What a mission knows of the effects that tank data show: its own effects, and uncertain keys of its vehicle."""

from collections.abc import Iterable

import numpy as np

from missionplan.datasets.tank import DragSettings, OscillationSettings, TankData
from missionplan.diagnosis.coordinates import coordinates_of
from missionplan.diagnosis.given.effects import GivenEffect
from missionplan.diagnosis.given.priors import check_together, given_priors
from missionplan.diagnosis.tank.free_oscillation import full_size_added_mass
from missionplan.effects import CATALOGUE, EffectInfo
from missionplan.effects.info import VehicleKey
from missionplan.mission import Mission
from missionplan.mission.schema.vehicle import Vehicle
from missionplan.montecarlo.distributions import mean_of, sd_of


def given_in_tank(data: TankData, mission: Mission, candidates: Iterable[str]) -> tuple[GivenEffect, ...]:
    """Return the priors of the candidates of which the mission knows something.

    Its own effects; else, where an effect is stated by a key of the vehicle file and that key has a distribution, no
    change on the mean, with that uncertainty.

    Raises
    ------
    InputError
        When a diagnosis cannot hold the mission's effects together.
    """
    effects = [CATALOGUE[name] for name in candidates]
    given = given_priors(mission, effects)
    check_together(given, mission, "tank")
    own = {entry.effect for entry in mission.effect_list.known}
    stated = [_stated(info, data, mission.vehicle) for info in effects if info.vehicle_key and info.id not in own]
    return (*given, *(each for each in stated if each is not None))


def _stated(info: EffectInfo, data: TankData, vehicle: Vehicle | None) -> GivenEffect | None:
    sd = _uncertainty(info.vehicle_key, data, vehicle) if vehicle is not None else 0.0
    if sd == 0.0:
        return None
    coordinates = coordinates_of(info)
    (parameter,) = info.parameters.values()
    spike = parameter.tank_spike or parameter.spike
    return GivenEffect(info.id, coordinates, np.zeros(1), np.array([[sd**2]]), np.array([spike**2]))


def _uncertainty(key: VehicleKey, data: TankData, vehicle: Vehicle) -> float:
    """Standard deviation of an effect's one parameter by the key that states it; 0 where the key is a number."""
    settings = data.settings
    if isinstance(settings, DragSettings) and vehicle.drag is not None:
        if key == "drag.coefficient":
            return sd_of(vehicle.drag.coefficient) / mean_of(vehicle.drag.coefficient)
        if key == "drag.exponent":
            return sd_of(vehicle.drag.exponent)
    if key == "added_mass.surge" and isinstance(settings, OscillationSettings) and vehicle.added_mass is not None:
        surge = vehicle.added_mass.surge
        return sd_of(surge) / full_size_added_mass(settings, vehicle, 0.0, 1.0)[1] if surge is not None else 0.0
    return 0.0
