"""The extended mission of a navigation log: the causes as effects, with the origin and start that phases refer to."""

import math
from collections.abc import Mapping
from datetime import UTC, datetime

from missionplan.datasets.legs import TransitData
from missionplan.diagnosis.extended_mission import extended_mission
from missionplan.diagnosis.inference.model import CauseFit


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
    mission = extended_mission(raw, found, best.calibration)
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
