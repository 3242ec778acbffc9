"""The error of a mission's forecast of the current, as a diagnosis of legs sees it: an effect that persists."""

import copy
from collections.abc import Mapping

from missionplan.effects import CATALOGUE, EffectInfo
from missionplan.mission import Mission
from missionplan.mission.schema.site import CurrentFile, TidalCurrent
from missionplan.mission.views import forecast_error
from missionplan.montecarlo.distributions import Quantity, mean_of

_PARAMETERS = {"sigma", "time"}
ERROR_PLACE = "site.current.error."
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
    return _effect(), {"sigma": error.sigma, "time": time}


def as_forecast_error(extended: Mapping[str, object]) -> dict[str, object]:
    """Write what was found of the error where an extended mission has it: in `site.current.error`, not as an effect.

    Legs tell how long the error lasts along the track alone, so that it has no length any more.
    """
    mission = copy.deepcopy(dict(extended))
    site, effects, name = mission.get("site"), mission.get("effects"), _effect().id
    current = site.get("current") if isinstance(site, dict) else None
    if not isinstance(current, dict) or not isinstance(current.get("error"), dict) or not isinstance(effects, list):
        return mission
    found = [entry for entry in effects if isinstance(entry, dict) and name in entry]
    if found:
        current["error"] = found[0][name]
        mission["effects"] = [entry for entry in effects if entry not in found]
        mission |= _renamed_correlations(mission.get("correlations"), f"effects.{name}.")
    return mission


def _renamed_correlations(given: object, old: str) -> dict[str, object]:
    """Correlations of the effect's parameters as those of the error of the forecast."""
    pairs = [
        {**pair, "between": [name.replace(old, ERROR_PLACE) for name in pair["between"]]}
        for pair in (given if isinstance(given, list) else [])
    ]
    return {"correlations": pairs} if pairs else {}


def forecast_notice(mission: Mission, causes: tuple[str, ...]) -> tuple[str, ...]:
    """Say that an error which persists beside a forecast of the current is the forecast's, where that was found."""
    current = mission.site.current if mission.site else None
    name = _effect().id
    if name not in causes or not isinstance(current, CurrentFile | TidalCurrent) or current.error is not None:
        return ()
    return (
        f"The mission's current is a forecast, so that the {name} found is the error of this forecast: written as "
        "site.current.error, with its sigma and time, it also moves the vehicle at the surface and at its mooring.",
    )


def _effect() -> EffectInfo:
    """Return the effect that has the parameters of a forecast's error."""
    return next(info for info in CATALOGUE.values() if info.phase == "transit" and set(info.parameters) == _PARAMETERS)
