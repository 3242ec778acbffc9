"""The extended mission: the mission's data with the causes as effects, each parameter a distribution."""

import copy
import math
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from typing import Any

from missionplan.datasets.legs import TransitData
from missionplan.effects import CATALOGUE
from missionplan.results.diagnosis import ParameterEstimate


def extended_mission(
    raw: Mapping[str, Any],
    found: Sequence[ParameterEstimate],
    calibration: Mapping[str, float],
    data: TransitData | None,
) -> dict[str, Any]:
    """Write the causes into a mission's data.

    Parameters
    ----------
    raw : mapping
        The mission file's data with includes in place.
    found : sequence of ParameterEstimate
        Parameters of the causes; none leaves the effects as they are.
    calibration : mapping
        Nuisances as fitted; ``sigma_v_m_s`` replaces the mission's where it has a sigma.
    data : TransitData or None
        Of a navigation log: gives origin and start to missions that lack them, which phases of currents refer to.
    """
    mission = copy.deepcopy(dict(raw))
    effects = list(mission.get("effects") or [])
    for name in dict.fromkeys(estimate.effect for estimate in found):
        effects = [entry for entry in effects if name not in entry]
        effects.append({name: {e.name: quantity(e) for e in found if e.effect == name}})
    if effects:
        mission["effects"] = effects
    error = (mission.get("navigation") or {}).get("velocity_error")
    if isinstance(error, dict) and "sigma" in error and "sigma_v_m_s" in calibration:
        error["sigma"] = f"{calibration['sigma_v_m_s']:.4g} m/s"
    if data is not None and found:
        _place_and_time(mission, data)
    return mission


def _place_and_time(mission: dict[str, Any], data: TransitData) -> None:
    site = dict(mission.get("site") or {})
    if data.origin is not None and "origin" not in site:
        latitude, longitude = (math.degrees(angle) for angle in data.origin)
        mission["site"] = {**site, "origin": {"latitude": f"{latitude:.7f} deg", "longitude": f"{longitude:.7f} deg"}}
    if data.epoch is not None and "start" not in mission:
        mission["start"] = datetime.fromtimestamp(data.epoch, UTC).strftime("%Y-%m-%dT%H:%M:%SZ")


def quantity(estimate: ParameterEstimate) -> dict[str, Any]:
    """Write a parameter as a distribution: normal, or log-normal for one that is positive by nature."""
    parameter = CATALOGUE[estimate.effect].parameters[estimate.name]

    def written(value: float) -> Any:
        return f"{value:.5g} {parameter.unit}" if parameter.unit else float(f"{value:.5g}")

    if parameter.is_shape:
        factor = math.exp(min(estimate.sd / estimate.value, 3.0))
        return {"median": written(estimate.value), "factor": float(f"{max(factor, 1.0001):.5g}")}
    return {"mean": written(estimate.value), "sd": written(estimate.sd)}
