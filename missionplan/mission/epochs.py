"""What was learned at another date and place: phases turned to the mission's start, and effects that stay behind."""

import math
from collections.abc import Collection, Mapping
from dataclasses import replace

import numpy as np

from missionplan.effects import CATALOGUE
from missionplan.mission.schema.effect_list import EffectEntry, EffectList, Learned, OneOf, effects_of_draws
from missionplan.montecarlo.distributions import Distribution, Quantity, Shifted
from missionplan.montecarlo.posterior import Place, WeightedDraws

REACH = 20_000.0
"""Distance beyond which a current that was learned is another one [m]: it changes with depth and coast within that."""
SEASON, DAYS = 30.0 * 86400.0, 3.0 * 86400.0
"""Time beyond which what belongs to a place in a season, and to the weather, is another one [s]."""
EARTH = 6.371e6
"""Mean radius of the Earth [m]."""


def not_handed_on(effects: Collection[str], learned: Place, here: Place) -> dict[str, str]:
    """Return the effects that were learned too far away or too long ago to hold here, each with the reason.

    What is not known, of the place or the date, is taken to be the same.

    Parameters
    ----------
    learned, here : tuple of float
        Latitude, longitude [rad] and date [s since 1970].
    """
    away, ago = _distance(learned, here), abs(here[2] - learned[2])
    found = {}
    for effect, lasts in _lasting(effects).items():
        if away > REACH:
            found[effect] = f"{effect} was learned {away / 1000.0:.0f} km away"
        elif ago > lasts:
            found[effect] = f"{effect} was learned {ago / 86400.0:.0f} days before or after"
    return found


def still_alike(effects: Collection[str], learned: Place, here: Place) -> dict[str, float]:
    """Return the correlation of what was learned with what is here, of each effect of the place or the day.

    That of a smooth field, a Gaussian of distance and time; parameters as of `not_handed_on`.
    """
    away, ago = np.nan_to_num([_distance(learned, here), abs(here[2] - learned[2])]).tolist()
    return {
        effect: math.exp(-0.5 * ((away / REACH) ** 2 + (ago / lasts) ** 2))
        for effect, lasts in _lasting(effects).items()
    }


def _lasting(effects: Collection[str]) -> dict[str, float]:
    """How long each effect of the place or the day lasts [s]; a tide's constituents outlast a season."""
    infos = [CATALOGUE[effect] for effect in effects]
    return {
        info.id: DAYS if info.belongs_to == "day" else math.inf if info.is_modulated else SEASON
        for info in infos
        if info.belongs_to != "vehicle"
    }


def _distance(first: Place, second: Place) -> float:
    """Distance on a sphere [m]; nan where it is not known."""
    north, east = second[0] - first[0], second[1] - first[1]
    chord = math.sin(0.5 * north) ** 2 + math.cos(first[0]) * math.cos(second[0]) * math.sin(0.5 * east) ** 2
    return 2.0 * EARTH * math.asin(math.sqrt(chord)) if math.isfinite(chord) else math.nan


def left_behind(effects: EffectList, learned: Place, here: Place) -> tuple[EffectList, tuple[str, ...]]:
    """Return effects without those of a posterior that do not hold here, with a notice of each."""
    posterior = effects.learned
    gone = not_handed_on(posterior.draws.effects, learned, here) if posterior is not None else {}
    if posterior is None or not gone:
        return effects, ()
    draws = posterior.held_as_seen.without(gone)
    own = {entry.effect for entry in posterior.entries}
    entries = tuple(entry for entry in effects_of_draws(draws) if entry.effect in own)
    kept = Learned(draws, entries, None if posterior.known is None else 0)
    notices = tuple(f"{words}, and is not handed on" for words in gone.values())
    return EffectList(tuple(kept if item is posterior else item for item in effects.items)), notices


def phase_shifts(effect: str, seconds: float, latitude: float) -> dict[str, float]:
    """Return by how much each phase of an effect grows when its zero of time moves by so many seconds [rad].

    a·cos(ω(t + Δ) − φ) is a·cos(ωt − (φ − ωΔ)).

    Parameters
    ----------
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
