"""What was learned, at a mission's date and place: draws turned to its start, left behind, drifted since and faded."""

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.effects import CATALOGUE
from missionplan.mission.schema.effect_list import EffectEntry, EffectList, Learned, effects_of_draws
from missionplan.montecarlo.distributions import Distribution, Quantity, Shifted
from missionplan.montecarlo.levels import MOST, Ageing, LevelKey, Levels, Measured, Seen, in_missions, levels
from missionplan.montecarlo.posterior import Column, Place, WeightedDraws
from missionplan.montecarlo.streams import stream

REACH = 20_000.0
"""Distance beyond which a current that was learned is another one [m]: it changes with depth and coast within that."""
SEASON, DAYS = 30.0 * 86400.0, 3.0 * 86400.0
"""Time beyond which what belongs to a place in a season, and to the weather, is another one [s]."""
EARTH = 6.371e6
"""Mean radius of the Earth [m]."""


def not_handed_on(effects: Collection[str], learned: Sequence[Place], here: Place) -> dict[str, str]:
    """Return the effects that were learned too far away or too long ago to hold here, each with the reason.

    `learned`: places all over the data. What is not known, of latitude, longitude [rad] and date [s since 1970], is
    taken to be the same.
    """
    reasons = {}
    for effect, lasts in _lasting(effects).items():
        away, ago = _nearest(learned, here, lasts)
        if away > REACH:
            reasons[effect] = f"{effect} was learned {away / 1000.0:.0f} km away"
        elif ago > lasts:
            reasons[effect] = f"{effect} was learned {ago / 86400.0:.0f} days before or after"
    return reasons


def still_alike(columns: Collection[Column], learned: Sequence[Place], here: Place) -> dict[str, float]:
    """Return the correlation of what was learned with what is here, of each effect of the place or the day.

    That of a smooth field, a Gaussian of distance and time, and of what a record could not tell from it; places as of
    `not_handed_on`.
    """
    correlations = {}
    for effect, lasts in _lasting(dict.fromkeys(effect for effect, _ in columns if effect)).items():
        away, ago = _nearest(learned, here, lasts)
        correlations[effect] = math.exp(-0.5 * ((away / REACH) ** 2 + (ago / lasts) ** 2))
        kept = CATALOGUE[effect].kept_after
        if kept is not None:
            since = min(abs(float(np.nan_to_num(here[2] - place[2]))) for place in learned)
            correlations[effect] *= kept([name for of, name in columns if of == effect], since)
    return correlations


def _nearest(learned: Sequence[Place], here: Place, lasts: float) -> tuple[float, float]:
    """Distance [m] and time [s] from the place of the data that is likest here; 0 where one is not known."""
    apart = [np.nan_to_num([_distance(place, here), abs(here[2] - place[2])]).tolist() for place in learned]
    away, ago = min(apart, key=lambda pair: (pair[0] / REACH) ** 2 + (pair[1] / lasts) ** 2)
    return away, ago


def _lasting(effects: Collection[str]) -> dict[str, float]:
    """How long each effect of the place or the day lasts [s]; a tide has no season."""
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


def left_behind(effects: EffectList, learned: Sequence[Place], here: Place) -> tuple[EffectList, tuple[str, ...]]:
    """Return effects without those of a posterior that do not hold here, with a notice of each."""
    posterior = effects.learned
    gone = not_handed_on(posterior.draws.effects, learned, here) if posterior is not None else {}
    if posterior is None or not gone:
        return effects, ()
    draws = posterior.held_as_seen.without(gone)
    stated = {entry.effect for entry in posterior.entries}
    entries = tuple(entry for entry in effects_of_draws(draws) if entry.effect in stated)
    kept = Learned(draws, entries, None if posterior.known is None else 0)
    notices = tuple(f"{words}, and is not handed on" for words in gone.values())
    return EffectList(tuple(kept if item is posterior else item for item in effects.items)), notices


def phase_shifts(effect: str, seconds: float, latitude: float) -> dict[str, float]:
    """Return by how much each phase of an effect grows when its zero of time moves by so many seconds [rad].

    a·cos(ω(t + Δ) − φ) is a·cos(ωt − (φ − ωΔ)).

    `seconds`: from the date of the phases to the mission's start [s]. `latitude`: of the mission's origin, nan where it
    has none [rad].
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

    def turned(entry: EffectEntry) -> EffectEntry:
        if entry.epoch is None:
            return entry
        shifts = phase_shifts(entry.effect, start - entry.epoch, latitude)
        sizes: Mapping[str, Quantity] = {n: _shifted(q, shifts.get(n, 0.0)) for n, q in entry.parameters.items()}
        return replace(entry, parameters={**sizes, **{n: by for n, by in shifts.items() if n not in sizes}}, epoch=None)

    return effects.with_stated(turned)


def _shifted(quantity: Quantity, by: float) -> Quantity:
    if not by:
        return quantity
    return Shifted(quantity, by) if isinstance(quantity, Distribution) else quantity + by


IS_JUMP: Mapping[str, float] = {"keeps": 0.04, "drifts": 0.04, "jumps": 0.07}
IS_TREND: Mapping[str, float] = {"keeps": 0.1, "drifts": 0.3, "jumps": 0.1}
"""Probabilities that a mission jumps, and that there is a trend, by how an effect ages."""
TREND, WALK = 0.15, 0.1
"""Standard deviations of the change a mission by a trend and by a walk, over those of the usual sizes of the effect."""
LEAST_SPREAD = 0.5
"""Standard deviation of draws at an earlier date, over that of the draws, at least."""


def has_level(key: LevelKey) -> bool:
    """Whether a coordinate is a level of the vehicle's: a strength of a physical effect that lasts beyond a record."""
    info = CATALOGUE.get(key[0])
    if info is None or key[2] == "shape" or info.belongs_to != "vehicle" or info.tier != "physical":
        return False
    within = any(parameter.searched == "time" for parameter in info.parameters.values())
    return not within and info.parameters[key[1]].spike > 0.0


@dataclass(frozen=True)
class Series:
    """What records have told of one level, in the order of time."""

    of: LevelKey
    records: tuple[Seen, ...]
    first: float
    """Mean of the level before the first record."""
    first_sd: float

    def levels(self, ahead: float = math.nan, missions: float = 1.0) -> tuple[Levels, float]:
        """Return the level at any time in missions, and the time of a mission ahead; parameters as of `at_date`."""
        last = self.records[-MOST:]
        times, then = in_missions([estimate.date for estimate in last], ahead, missions)
        values, sds = (np.array([getattr(estimate, name) for estimate in last]) for name in ("value", "sd"))
        measured = Measured(times, values, sds, self.first, self.first_sd)
        info = CATALOGUE[self.of[0]]
        size, spike = info.parameters[self.of[1]].scale, info.parameters[self.of[1]].spike
        return levels(
            measured, Ageing(TREND * size, WALK * size, spike, size, IS_TREND[info.ageing], IS_JUMP[info.ageing])
        ), then


def series_of(seen: Sequence[Seen]) -> dict[LevelKey, Series]:
    """Return what records have told of each level: each once, by their dates where all have one, else as they came."""
    series = {}
    for key in dict.fromkeys(estimate.of for estimate in seen):
        estimates = [estimate for estimate in seen if estimate.of == key]
        records = list({estimate.record: estimate for estimate in estimates if estimate.record}.values())
        if all(math.isfinite(estimate.date) for estimate in records):
            records.sort(key=lambda estimate: estimate.date)
        if records and has_level(key):
            before = next((estimate for estimate in estimates if not estimate.record), None)
            usual = CATALOGUE[key[0]].parameters[key[1]].scale
            first, sd = (0.0, usual) if before is None else (before.value, before.sd)
            series[key] = Series(key, tuple(records), first, sd)
    return series


def at_date(
    effects: EffectList,
    seen: Sequence[Seen],
    ahead: float | None,
    missions: float = 1.0,
    alike: Mapping[str, float] | None = None,
) -> EffectList:
    """Return effects with what was learned of the vehicle as it will be at a date.

    `seen`: what the draws come from. `ahead`: date [s since 1970]; nan: of the next mission; None: of the last record.
    `missions`: from the last record to a date that is not known. `alike`: of what belongs to a place; see `faded`.
    """
    learned = effects.learned
    if learned is None:
        return effects
    unaged = learned.as_seen
    draws = faded(unaged if ahead is None else drifted(unaged, seen, ahead, missions), alike or {})
    stated = {entry.effect for entry in learned.entries}
    entries: tuple[EffectEntry, ...] = tuple(entry for entry in effects_of_draws(draws) if entry.effect in stated)
    moved: Learned = Learned(draws, entries, unaged=unaged)
    moved = moved if learned.known is None else moved.knowing(learned.known)
    return EffectList(tuple(moved if item is learned else item for item in effects.items))


def drifted(draws: WeightedDraws, seen: Sequence[Seen], ahead: float, missions: float = 1.0) -> WeightedDraws:
    """Return draws at a date: moved and widened as the levels since the record that came last, whichever its date.

    In each set of effects, what is added to a level is independent of the others.

    Parameters as of `at_date`.
    """
    columns = _columns(draws)
    for key, series in series_of(seen).items():
        if key[:2] not in columns:
            continue
        level, then = series.levels(ahead, missions)
        last = [values.record for values in seen if values.of == key][-1]
        records = [entry.record for entry in series.records[-MOST:]]
        at = level.measured.times[records.index(last) if last in records else -1]
        mean, sd = level.at(np.array([at, then]))
        shift, added = float(mean[1] - mean[0]), float(sd[1] ** 2 - sd[0] ** 2)
        for rows in _rows_of_sets(draws, columns[key[0], key[1]]):
            _move(columns, key, rows, draws.weights[rows], shift, added)
    return _with_columns(draws, columns)


def faded(draws: WeightedDraws, alike: Mapping[str, float]) -> WeightedDraws:
    """Return draws of what is only like what was learned: nearer to the effect's prior, as a correlation says.

    In each set the mean of a strength shrinks by the correlation, and its variance goes towards that of usual sizes.
    `alike` has correlations by effect, 1 for others.
    """
    columns = _columns(draws)
    for effect, name in draws.columns:
        share, info = alike.get(effect, 1.0), CATALOGUE.get(effect)
        if info is None or share == 1.0 or info.parameters[name].is_shape or name in dict(info.polar).values():
            continue
        wide = info.parameters[name].scale ** 2
        for kind in ("cosine", "sine") if name in dict(info.polar) else ("strength",):
            for rows in _rows_of_sets(draws, columns[effect, name]):
                weights, key = draws.weights[rows], (effect, name, kind)
                coordinate = _coordinate(columns, key, rows)
                mean = float(np.average(coordinate, weights=weights))
                variance = float(np.average(np.square(coordinate - mean), weights=weights))
                _move(columns, key, rows, weights, (share - 1.0) * mean, (1.0 - share**2) * (wide - variance))
    return _with_columns(draws, columns)


def _columns(draws: WeightedDraws) -> dict[Column, Array]:
    return {column: draws.values[:, index].copy() for index, column in enumerate(draws.columns)}


def _with_columns(draws: WeightedDraws, columns: Mapping[Column, Array]) -> WeightedDraws:
    """Draws with other values, cut to the range of their parameters."""
    values = [columns[column] for column in draws.columns]
    for index, (effect, name) in enumerate(draws.columns):
        if effect:
            parameter = CATALOGUE[effect].parameters[name]
            values[index] = np.clip(values[index], parameter.low, parameter.high)
    return replace(draws, values=np.stack(values, axis=1))


def _rows_of_sets(draws: WeightedDraws, values: Array) -> Iterator[NDArray[np.int_]]:
    """Rows of the draws that have a value, set by set."""
    for number in range(len(draws.sets)):
        rows = np.flatnonzero((draws.which == number) & np.isfinite(values))
        if len(rows):
            yield rows


def _coordinate(columns: Mapping[tuple[str, str], Array], key: LevelKey, rows: NDArray[np.int_]) -> Array:
    """Values of one coordinate in some draws."""
    effect, name, kind = key
    phase = dict(CATALOGUE[effect].polar).get(name)
    size = columns[effect, name][rows]
    turn = 0.0 if phase is None else columns[effect, phase][rows]
    return np.asarray(size * (np.sin(turn) if kind == "sine" else np.cos(turn)))


def _move(
    columns: dict[tuple[str, str], Array],
    key: LevelKey,
    rows: NDArray[np.int_],
    weights: Array,
    shift: float,
    added: float,
) -> None:
    """Move and widen one coordinate of some draws, by the shift of its mean and the variance that is added."""
    effect, name, kind = key
    coordinate, shares = _coordinate(columns, key, rows), weights / weights.sum()
    moved = coordinate + shift + _spread(coordinate, shares, added, stream(0, f"level.{'.'.join(key)}", 0))
    phase = dict(CATALOGUE[effect].polar).get(name)
    if phase is None:
        columns[effect, name][rows] = moved
        return
    other = _coordinate(columns, (effect, name, "cosine" if kind == "sine" else "sine"), rows)
    cosine, sine = (other, moved) if kind == "sine" else (moved, other)
    columns[effect, name][rows], columns[effect, phase][rows] = np.hypot(cosine, sine), np.arctan2(sine, cosine)


def _spread(coordinate: Array, shares: Array, added: float, generator: np.random.Generator) -> Array:
    """What widens draws by a variance that is independent of all else, or narrows them by one.

    `coordinate`, `shares`, shape (n,): draws, and their weights, whose sum is 1.
    """
    apart = coordinate - shares @ coordinate
    variance = float(shares @ np.square(apart))
    if added <= 0.0 or not variance > 0.0:
        share = max(1.0 + added / variance, LEAST_SPREAD**2) if variance > 0.0 else 1.0
        return np.asarray((math.sqrt(share) - 1.0) * apart)
    normals = generator.standard_normal(len(coordinate))
    normals -= shares @ normals + apart * (shares @ (apart * normals)) / variance
    return np.asarray(normals * math.sqrt(added / float(shares @ np.square(normals))))
