"""The extended mission of a navigation log: the causes as effects, with the origin and start that phases refer to."""

import math
from collections.abc import Mapping
from dataclasses import replace
from datetime import UTC, datetime

from missionplan.datasets.records import TransitData
from missionplan.diagnosis.extended_mission import extended_mission
from missionplan.diagnosis.forecast_error import as_forecast_error
from missionplan.diagnosis.inference.model import CauseFit
from missionplan.effects import CATALOGUE
from missionplan.results.learned.evidence import ParameterEstimate


def widened(best: CauseFit, scale: float) -> CauseFit:
    """Return a fit with σ_v and the sizes of its random causes scaled: its intervals were too narrow, or too wide.

    Parameters
    ----------
    best : CauseFit
    scale : float
        1 leaves it as it is.
    """
    calibration = {name: value * (scale if name == "sigma_v_m_s" else 1.0) for name, value in best.calibration.items()}
    estimates, given = (tuple(_widened(each, scale) for each in found) for found in (best.estimates, best.given))
    return replace(best, calibration=calibration, estimates=estimates, given=given)


def _widened(estimate: ParameterEstimate, scale: float) -> ParameterEstimate:
    if not CATALOGUE[estimate.effect].parameters[estimate.name].is_random_size:
        return estimate
    value, sd, low, high = (scale * number for number in (estimate.value, estimate.sd, estimate.low, estimate.high))
    return replace(estimate, value=value, sd=sd, low=low, high=high)


def extended_transit_mission(raw: Mapping[str, object], best: CauseFit, data: TransitData) -> dict[str, object]:
    """Write the causes into a mission's data.

    Parameters
    ----------
    raw : mapping
        The mission file's data with includes in place.
    best : CauseFit
        The causes, and what is known now of the mission's own effects.
    data : TransitData
        Gives origin and start to missions that lack them: the phases of currents refer to them.
    """
    found = (*best.given, *best.estimates)
    mission = as_forecast_error(extended_mission(raw, found, best.calibration, best.correlations))
    if not found:
        return mission
    given = mission.get("site")
    site = dict(given) if isinstance(given, dict) else {}
    if data.origin is not None and "origin" not in site:
        latitude, longitude = (math.degrees(angle) for angle in data.origin)
        mission["site"] = {**site, "origin": {"latitude": f"{latitude:.7f} deg", "longitude": f"{longitude:.7f} deg"}}
    if data.epoch is not None and "start" not in mission:
        mission["start"] = datetime.fromtimestamp(data.epoch, UTC).strftime("%Y-%m-%dT%H:%M:%SZ")
    return mission
