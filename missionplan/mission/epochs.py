"""Phases of oscillating currents that count from a date of their own, as those of a mission that starts at another."""

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from missionplan.effects import CATALOGUE
from missionplan.mission.schema.effect_list import EffectEntry, EffectList, OneOf
from missionplan.montecarlo.distributions import Distribution, Quantity, Shifted
from missionplan.montecarlo.posterior import WeightedDraws


def phase_shifts(effect: str, seconds: float, latitude: float) -> dict[str, float]:
    """Return by how much each phase of an effect grows when its zero of time moves by so many seconds [rad].

    a·cos(ω(t + Δ) − φ) is a·cos(ωt − (φ − ωΔ)).

    Parameters
    ----------
    effect : str
    seconds : float
        From the date of the phases to the mission's start [s].
    latitude : float
        Of the mission's origin, nan where it has none [rad].
    """
    info = CATALOGUE[effect]
    if info.frequency_of is None:
        return {}
    return {phase: -info.frequency_of(phase, latitude) * seconds for _, phase in info.polar}


def turned_draws(draws: WeightedDraws, seconds: float, latitude: float) -> WeightedDraws:
    """Return draws whose phases count from the mission's start; parameters as of `phase_shifts`."""
    if seconds == 0.0 or not math.isfinite(seconds):
        return draws
    values = draws.values.copy()
    for index, (effect, name) in enumerate(draws.columns):
        shift = phase_shifts(effect, seconds, latitude).get(name, 0.0) if effect else 0.0
        if shift:
            values[:, index] = np.angle(np.exp(1j * (values[:, index] + shift)))
    return replace(draws, values=values)


def turned_effects(effects: EffectList, start: float, latitude: float) -> EffectList:
    """Return effects whose phases count from the mission's start [s since 1970], those with an `epoch` turned to it."""
    return EffectList(
        tuple(
            _turned(item, start, latitude)
            if isinstance(item, EffectEntry)
            else replace(
                item,
                explanations=tuple(
                    replace(each, effects=tuple(_turned(entry, start, latitude) for entry in each.effects))
                    for each in item.explanations
                ),
            )
            if isinstance(item, OneOf)
            else item
            for item in effects.items
        )
    )


def _turned(entry: EffectEntry, start: float, latitude: float) -> EffectEntry:
    if entry.epoch is None:
        return entry
    shifts = phase_shifts(entry.effect, start - entry.epoch, latitude)
    own: Mapping[str, Quantity] = {n: _shifted(q, shifts.get(n, 0.0)) for n, q in entry.parameters.items()}
    missing = {name: shift for name, shift in shifts.items() if name not in own}
    return replace(entry, parameters={**own, **missing}, epoch=None)


def _shifted(quantity: Quantity, by: float) -> Quantity:
    if not by:
        return quantity
    return Shifted(quantity, by) if isinstance(quantity, Distribution) else quantity + by
