"""What belongs to no effect of the mission extended by a navigation log: noise, origin and start."""

import math
from collections.abc import Mapping
from dataclasses import replace
from datetime import UTC, datetime

from missionplan.datasets.records import TransitData
from missionplan.diagnosis.extended_mission import with_noise
from missionplan.diagnosis.inference.model import CauseFit


def widened(best: CauseFit, scale: float) -> CauseFit:
    """Return a fit with σ_v and the sizes of its random causes scaled: its intervals were too narrow, or too wide.

    Parameters
    ----------
    best : CauseFit
    scale : float
        1 leaves it as it is.
    """
    calibration = {name: value * (scale if name == "sigma_v_m_s" else 1.0) for name, value in best.calibration.items()}
    return replace(best, calibration=calibration, posterior=best.posterior.scaled(scale))


def extended_transit_mission(raw: Mapping[str, object], best: CauseFit, data: TransitData) -> dict[str, object]:
    """Return a mission's data with the noise as fitted, and with the place and time to which phases refer.

    Parameters
    ----------
    raw : mapping
        The mission file's data with includes in place.
    best : CauseFit
    data : TransitData
        Gives origin and start to missions that lack them: the phases of currents refer to them.
    """
    mission = with_noise(raw, best.calibration)
    if not (best.given or best.estimates):
        return mission
    given = mission.get("site")
    site = dict(given) if isinstance(given, dict) else {}
    if data.origin is not None and "origin" not in site:
        latitude, longitude = (math.degrees(angle) for angle in data.origin)
        mission["site"] = {**site, "origin": {"latitude": f"{latitude:.7f} deg", "longitude": f"{longitude:.7f} deg"}}
    if data.epoch is not None and "start" not in mission:
        mission["start"] = datetime.fromtimestamp(data.epoch, UTC).strftime("%Y-%m-%dT%H:%M:%SZ")
    return mission
