"""The extended mission of tank data: in the vehicle's own keys where it has them, else as effects that are carried."""

import copy
import math
from collections.abc import Mapping, Sequence
from typing import Any

from missionplan.datasets.tank import DragSettings, OscillationSettings
from missionplan.diagnosis.extended_mission import extended_mission
from missionplan.diagnosis.tank.data import TankSet
from missionplan.diagnosis.tank.forward import base_mass, drag_reynolds
from missionplan.mission import Mission
from missionplan.montecarlo.distributions import mean_of
from missionplan.results.diagnosis import ParameterEstimate

IN_VEHICLE = ("drag-bias", "reynolds-drag", "added-mass")
"""Causes that the vehicle file says better than an effect: a descent's effects of these names act on the anchor too."""


def extended_tank_mission(
    mission: Mission, found: Sequence[ParameterEstimate], calibration: Mapping[str, float], data: TankSet
) -> dict[str, Any]:
    """Write the causes into a mission's data.

    Drag goes into ``vehicle.drag`` and added mass into ``vehicle.added_mass.surge``, at full size; what no plan
    depends on goes into ``effects``. A mission without a vehicle carries nothing of the first kind.

    Parameters
    ----------
    mission : Mission
        The base model.
    found : sequence of ParameterEstimate
        Parameters of the causes.
    calibration : mapping
        Constants of the base model as fitted.
    data : TankSet
        What was diagnosed.
    """
    others = [estimate for estimate in found if estimate.effect not in IN_VEHICLE]
    extended = extended_mission(mission.raw, others, {})
    own = {estimate.effect: estimate for estimate in found if estimate.effect in IN_VEHICLE}
    if not own or mission.vehicle is None:
        return extended
    known_vehicle = extended["vehicle"]
    vehicle: dict[str, Any] = copy.deepcopy(known_vehicle) if isinstance(known_vehicle, dict) else {}
    settings = data.tank.settings
    if isinstance(settings, DragSettings):
        vehicle["drag"] = _drag(mission, settings, own, calibration, data)
    if isinstance(settings, OscillationSettings) and "added-mass" in own:
        estimate, base = own["added-mass"], base_mass(settings, mission.vehicle)
        assert settings.mass is not None
        surge = (base * (1.0 + estimate.value) - settings.mass) * settings.scale**3
        sd = base * estimate.sd * settings.scale**3
        known = dict(vehicle.get("added_mass") or {})
        vehicle["added_mass"] = known | {"surge": {"mean": f"{surge:.5g} kg", "sd": f"{sd:.3g} kg"}}
    extended["vehicle"] = vehicle
    return extended


def _drag(
    mission: Mission,
    settings: DragSettings,
    own: Mapping[str, ParameterEstimate],
    calibration: Mapping[str, float],
    data: TankSet,
) -> dict[str, Any]:
    """The vehicle's ``drag``: its coefficient times the bias, and the exponent about the middle of the speeds towed."""
    known = mission.vehicle.drag if mission.vehicle is not None else None
    bias, power = own.get("drag-bias"), own.get("reynolds-drag")
    level = mean_of(known.coefficient) if known is not None else calibration["drag_coefficient"]
    sd = level * bias.sd if bias is not None else 0.0
    factor = 1.0 + bias.value if bias is not None else 1.0
    area = known.area if known is not None else settings.reference_area * settings.scale**2
    coefficient = f"{level * factor:.5g}"
    found: dict[str, Any] = {
        "coefficient": {"mean": float(coefficient), "sd": float(f"{sd:.3g}")} if sd else float(coefficient),
        "area": f"{area:.6g} m^2",
    }
    exponent = mean_of(known.exponent) if known is not None else 0.0
    if power is not None:
        found["exponent"] = {"mean": float(f"{exponent + power.value:.4g}"), "sd": float(f"{power.sd:.3g}")}
    elif exponent:
        found["exponent"] = exponent
    if "exponent" in found:
        length = known.length if known is not None and known.length is not None else math.nan
        if not math.isfinite(length):
            length = settings.reference_length * settings.scale
        found |= {"at_reynolds": drag_reynolds(data.tank, settings, mission.vehicle), "length": f"{length:.6g} m"}
    return found
