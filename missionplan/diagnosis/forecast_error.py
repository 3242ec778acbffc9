"""The error of a mission's forecast of the current, as a diagnosis of legs sees it: an effect that persists."""

import copy
import math
from collections.abc import Mapping, Sequence

from missionplan.effects import CATALOGUE, EffectInfo
from missionplan.mission import Mission
from missionplan.mission.schema.site import CurrentFile, TidalCurrent
from missionplan.mission.views import forecast_error
from missionplan.montecarlo.distributions import Quantity, mean_of
from missionplan.results.learned.evidence import ParameterEstimate

_PARAMETERS = {"sigma", "time"}
ERROR_PLACE = "site.current.error"
"""Beginning of the key paths of the error's parameters."""


def along_a_track(mission: Mission) -> tuple[EffectInfo, dict[str, Quantity]] | None:
    """Return the effect that the error of the forecast is on legs, with its parameters; None where there is none.

    With a length L the error is forgotten along the track too, at the speed U of the first transit: 1/time + U/L.
    """
    error = forecast_error(mission)
    if error is None:
        return None
    time = error.time
    if error.length is not None and mission.transits and mission.transits[0].speed is not None:
        time = 1.0 / (1.0 / mean_of(error.time) + mean_of(mission.transits[0].speed) / mean_of(error.length))
    return forecast_effect(), {"sigma": error.sigma, "time": time}


def has_forecast_error(mission: Mission) -> bool:
    """Whether a mission states the error of its forecast: what legs tell of it is then written there, as no effect."""
    return forecast_error(mission) is not None


def with_forecast_error(
    data: Mapping[str, object], mission: Mission, found: Sequence[ParameterEstimate]
) -> dict[str, object]:
    """Write what was found of the error where the mission has it, in `site.current.error`.

    Legs tell how long the error lasts along the track alone, so that it has no length any more.
    """
    changed = copy.deepcopy(dict(data))
    site, own = changed.get("site"), [each for each in found if each.effect == forecast_effect().id]
    current = site.get("current") if isinstance(site, dict) else None
    if own and isinstance(current, dict) and has_forecast_error(mission):
        current["error"] = {each.name: _written(each) for each in own}
    return changed


def _written(size: ParameterEstimate) -> dict[str, object]:
    factor = math.exp(min(size.sd / size.value, 3.0))
    return {"median": f"{size.value:.5g} {size.unit}", "factor": float(f"{max(factor, 1.0001):.5g}")}


def forecast_notice(mission: Mission, causes: tuple[str, ...]) -> tuple[str, ...]:
    """Say that an error which persists beside a forecast of the current is the forecast's, where that was found."""
    current = mission.site.current if mission.site else None
    name = forecast_effect().id
    if name not in causes or not isinstance(current, CurrentFile | TidalCurrent) or current.error is not None:
        return ()
    return (
        f"The mission's current is a forecast, so that the {name} found is the error of this forecast: written as "
        "site.current.error, with its sigma and time, it also moves the vehicle at the surface and at its mooring.",
    )


def forecast_effect() -> EffectInfo:
    """Return the effect that has the parameters of a forecast's error."""
    return next(info for info in CATALOGUE.values() if info.phase == "transit" and set(info.parameters) == _PARAMETERS)
