"""The extended mission: the mission's data with the causes as effects, each parameter a distribution."""

import copy
import math
from collections.abc import Collection, Mapping, Sequence

from missionplan.effects import CATALOGUE
from missionplan.mission.mission import MOST_LEARNED
from missionplan.montecarlo.draws import Correlation
from missionplan.results.learned.evidence import ParameterEstimate

SIGMA_FACTOR = "sigma_v_factor"
"""Key of the calibration that says within what factor σ_v is known, in two of three cases."""
LEAST_FACTOR = 1.02
"""Factor below which σ_v is written as a number."""


def extended_mission(
    raw: Mapping[str, object],
    found: Sequence[ParameterEstimate],
    calibration: Mapping[str, float],
    correlations: Sequence[Correlation] = (),
) -> dict[str, object]:
    """Write the causes into a mission's data.

    Parameters
    ----------
    raw : mapping
        The mission file's data with includes in place.
    found : sequence of ParameterEstimate
        Parameters of the causes, and of the mission's own effects as they are known now.
    calibration : mapping
        Nuisance parameters as fitted; ``sigma_v_m_s`` replaces the mission's where it has a sigma.
    correlations : sequence of Correlation
        Of the causes' parameters, named ``effect.parameter``.
    """
    mission = copy.deepcopy(dict(raw))
    effects = _with_found(mission.get("effects"), found)
    if effects:
        mission["effects"] = effects
    together = _with_correlations(mission.get("correlations"), correlations, {estimate.effect for estimate in found})
    if together:
        mission["correlations"] = together
    navigation = mission.get("navigation")
    error = navigation.get("velocity_error") if isinstance(navigation, dict) else None
    if isinstance(error, dict) and "sigma" in error and "sigma_v_m_s" in calibration:
        error["sigma"] = _sigma(calibration)
    return mission


def _sigma(calibration: Mapping[str, float]) -> object:
    """Write σ_v, as a distribution where it is known how uncertain it is."""
    middle = f"{calibration['sigma_v_m_s']:.4g} m/s"
    factor = calibration.get(SIGMA_FACTOR, 1.0)
    return {"median": middle, "factor": float(f"{factor:.4g}")} if factor > LEAST_FACTOR else middle


def having_learned(extended: Mapping[str, object], identities: Sequence[str]) -> dict[str, object]:
    """Write into a mission's data that it has learned from measurements, by their hashes, the last `MOST_LEARNED`."""
    before = extended.get("learned_from")
    learned = dict.fromkeys([*(before if isinstance(before, list) else []), *identities])
    return {**extended, **({"learned_from": list(learned)[-MOST_LEARNED:]} if learned else {})}


def _with_correlations(given: object, found: Sequence[Correlation], effects: Collection[str]) -> list[object]:
    """Correlations of the mission, but for those of parameters of the effects found, then theirs."""
    names = tuple(f"effects.{effect}." for effect in effects)
    kept = [
        entry
        for entry in (given if isinstance(given, list) else [])
        if not any(str(name).startswith(names) for name in entry["between"])
    ]
    written = [
        correlation for correlation in found if {name.split(".")[0] for name in correlation.between} <= set(effects)
    ]
    return kept + [
        {"between": [f"effects.{name}" for name in correlation.between], "rho": correlation.rho}
        for correlation in written
    ]


def _with_found(given: object, found: Sequence[ParameterEstimate]) -> list[object]:
    """Effects of the mission with what was found of them, then the further causes.

    An effect of the same exclusive group as another that was found has been replaced by that.
    """
    by_effect: dict[str, list[ParameterEstimate]] = {}
    for estimate in found:
        by_effect.setdefault(estimate.effect, []).append(estimate)
    groups = {CATALOGUE[name].exclusive_group for name in by_effect} - {""}
    effects: list[object] = []
    for entry in given if isinstance(given, list) else []:
        name, parameters = next(iter(entry.items())) if isinstance(entry, dict) and entry else ("", None)
        own = by_effect.pop(name, None)
        if own is not None:
            effects.append({name: (parameters or {}) | _written(own)})
        elif name not in CATALOGUE or CATALOGUE[name].exclusive_group not in groups:
            effects.append(entry)
    return effects + [{name: _written(own)} for name, own in by_effect.items()]


def _written(found: Sequence[ParameterEstimate]) -> dict[str, object]:
    return {estimate.name: quantity(estimate) for estimate in found}


def quantity(estimate: ParameterEstimate) -> dict[str, str | float]:
    """Write a parameter as a distribution: normal, or log-normal for one that is positive by nature.

    Its middle lies in the physical range, to which a mission cuts the distribution.
    """
    parameter = CATALOGUE[estimate.effect].parameters[estimate.name]
    value = min(max(estimate.value, parameter.low), parameter.high)

    def written(value: float) -> str | float:
        return f"{value:.5g} {parameter.unit}" if parameter.unit else float(f"{value:.5g}")

    if parameter.is_shape:
        factor = math.exp(min(estimate.sd / estimate.value, 3.0))
        return {"median": written(value), "factor": float(f"{max(factor, 1.0001):.5g}")}
    return {"mean": written(value), "sd": written(estimate.sd)}
