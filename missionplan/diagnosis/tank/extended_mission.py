"""The extended mission of tank data: causes in the vehicle's own keys where it has them, else as effects."""

import copy
from collections.abc import Mapping

from missionplan.datasets.tank import DragSettings, OscillationSettings, TankData
from missionplan.diagnosis.inference.model import CauseFit
from missionplan.diagnosis.tank.free_oscillation import full_size_added_mass
from missionplan.diagnosis.tank.towed_drag import drag_reynolds
from missionplan.effects import CATALOGUE
from missionplan.effects.info import VehicleKey
from missionplan.mission import Mission
from missionplan.mission.schema.vehicle import Vehicle
from missionplan.montecarlo.distributions import mean_of
from missionplan.results.learned.evidence import ParameterEstimate


def extended_tank_mission(mission: Mission, best: CauseFit, data: TankData) -> dict[str, object]:
    """Write what keys of the vehicle file state of the causes into a mission's data, at full size.

    As an effect it would act on a descent's anchor too. A mission without a vehicle carries nothing of that kind.

    Parameters
    ----------
    mission : Mission
        The base model.
    best : CauseFit
        The causes, and what is known now of what the mission knew already.
    data : TankData
        What was diagnosed.
    """
    found, extended = (*best.given, *best.estimates), dict(mission.raw)
    keys = vehicle_keys(mission, best)
    own = {keys[estimate.effect]: estimate for estimate in found if estimate.effect in keys}
    given = extended.get("vehicle")
    if not own or mission.vehicle is None or not isinstance(given, dict):
        return extended
    vehicle, settings = copy.deepcopy(given), data.settings
    if isinstance(settings, DragSettings):
        vehicle["drag"] = _drag(mission.vehicle, settings, own, best.calibration, data)
    if isinstance(settings, OscillationSettings) and "added_mass.surge" in own:
        estimate = own["added_mass.surge"]
        surge, sd = full_size_added_mass(settings, mission.vehicle, estimate.value, estimate.sd)
        known = dict(vehicle.get("added_mass") or {})
        vehicle["added_mass"] = known | {"surge": {"mean": f"{surge:.5g} kg", "sd": f"{sd:.3g} kg"}}
    extended["vehicle"] = vehicle
    return extended


def vehicle_keys(mission: Mission, best: CauseFit) -> dict[str, VehicleKey]:
    """Return the key of the vehicle's file that states an effect found, by the effect; none of those carried so far."""
    carried = {entry.effect for entry in mission.effect_list.known}
    found = {estimate.effect for estimate in (*best.given, *best.estimates)} - carried
    return {name: CATALOGUE[name].vehicle_key for name in found if CATALOGUE[name].vehicle_key}


def _drag(
    vehicle: Vehicle,
    settings: DragSettings,
    own: Mapping[VehicleKey, ParameterEstimate],
    calibration: Mapping[str, float],
    data: TankData,
) -> dict[str, object]:
    """The vehicle's ``drag``: its coefficient times the bias, and the exponent about the middle of the speeds towed."""
    known = vehicle.drag
    level = mean_of(known.coefficient) if known is not None else calibration["drag_coefficient"]
    area = known.area if known is not None else settings.reference_area * settings.scale**2
    coefficient = _coefficient(level, own.get("drag.coefficient"))
    found: dict[str, object] = {"coefficient": coefficient, "area": f"{area:.6g} m^2"}
    exponent = _exponent(mean_of(known.exponent) if known is not None else 0.0, own.get("drag.exponent"))
    if exponent is None:
        return found
    length = known.length if known is not None else None
    if length is None:
        length = settings.reference_length * settings.scale
    at_reynolds = drag_reynolds(data, settings, vehicle)
    return {**found, "exponent": exponent, "at_reynolds": at_reynolds, "length": f"{length:.6g} m"}


def _coefficient(level: float, bias: ParameterEstimate | None) -> float | dict[str, float]:
    """The coefficient with the bias, as a distribution where it is uncertain."""
    mean = float(f"{level * (1.0 + bias.value):.5g}") if bias is not None else float(f"{level:.5g}")
    sd = level * bias.sd if bias is not None else 0.0
    return {"mean": mean, "sd": float(f"{sd:.3g}")} if sd else mean


def _exponent(known: float, change: ParameterEstimate | None) -> float | dict[str, float] | None:
    """The exponent of the Reynolds number with its change; None where the drag does not depend on it."""
    if change is not None:
        return {"mean": float(f"{known + change.value:.4g}"), "sd": float(f"{change.sd:.3g}")}
    return known or None
