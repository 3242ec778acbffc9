"""What may hold after a diagnosis, and the extended mission: its data, and beside them the draws of all that may hold.

What the record tells by itself of the levels of the vehicle is read from the same hypotheses.
"""

import copy
import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.diagnosis.coordinates import Coordinate
from missionplan.diagnosis.given.priors import given_priors, is_learned, stated_draws
from missionplan.diagnosis.inference.model import CauseFit
from missionplan.diagnosis.inference.selection import CREDIBLE
from missionplan.effects import CATALOGUE
from missionplan.mission import Mission
from missionplan.mission.includes import SIGMA, hash_of
from missionplan.mission.learned import has_level
from missionplan.mission.schema.effect_list import ONE_OF, POSTERIOR
from missionplan.mission.sections import MOST_LEARNED
from missionplan.moments import moment_of
from missionplan.montecarlo.levels import LevelKey, Seen
from missionplan.montecarlo.posterior import NOWHERE, Column, Place, PosteriorFile, WeightedDraws
from missionplan.montecarlo.streams import stream
from missionplan.results.learned.evidence import Causes

TELLS = 1e-3
"""Share of the variance known before that a record takes away, at least, to tell of a level."""


@dataclass(frozen=True)
class Hypothesis:
    """What may hold after a diagnosis."""

    causes: Causes
    """Effects of the mission's explanation, and those found beyond it."""
    probability: float
    before: Mission
    """Under the explanation."""
    shown: Causes
    """The mission's own effects that the data concern."""
    fit: CauseFit
    """With what is known of these now, and of the causes."""
    data: Mapping[str, object]
    """The mission's data with all that belongs to no effect, and the effects that it had."""
    places: tuple[Place, ...] = (NOWHERE,)
    """Of the data; see `DataKind.places`."""
    date: float = math.nan
    """Likewise `DataKind.date`."""


def seen_after(hypotheses: Sequence[Hypothesis], record: str) -> tuple[Seen, ...]:
    """Return what all records have told of levels, this one too.

    Of a level on which hypotheses differ, what the likeliest has that knows of it, of those that hold `CREDIBLE` of the
    probability or add to one of these: one without what the record shows takes its like for it.

    `hypotheses` has the likeliest first; `record` is the hash of this one.
    """
    levels: dict[LevelKey, tuple[Seen, ...]] = {}
    before = np.cumsum([0.0, *(hypothesis.probability for hypothesis in hypotheses[:-1])])
    credible = [frozenset(hypothesis.causes) for hypothesis in hypotheses[: int(np.count_nonzero(before < CREDIBLE))]]
    for hypothesis in (one for one in hypotheses if any(causes <= {*one.causes} for causes in credible)):
        for key, seen in _seen_under(hypothesis, record).items():
            levels.setdefault(key, seen)
    return tuple(row for rows in levels.values() for row in rows)


def _seen_under(hypothesis: Hypothesis, record: str) -> dict[LevelKey, tuple[Seen, ...]]:
    """What records have told under one hypothesis, by level."""
    rows: dict[LevelKey, list[Seen]] = {}
    for row in hypothesis.before.posterior.seen if hypothesis.before.posterior is not None else ():
        rows.setdefault(row.of, []).append(row)
    stated = {entry.effect for entry in hypothesis.before.effects if not is_learned(entry)}
    for coordinate, seen in _told(hypothesis, record):
        before = rows.setdefault(coordinate.key, [])
        if not before and coordinate.effect in stated and coordinate.effect not in hypothesis.fit.causes:
            mean, variance = _before(hypothesis)[coordinate.key]
            before.append(Seen(coordinate.key, "", math.nan, mean, math.sqrt(variance)))
        before.append(seen)
    effects = {entry.effect for entry in hypothesis.before.effects} | set(hypothesis.fit.causes)
    return {key: tuple(level_rows) for key, level_rows in rows.items() if key[0] in effects}


def _told(hypothesis: Hypothesis, record: str) -> Iterator[tuple[Coordinate, Seen]]:
    """Each level of which the record tells, with what it tells of it: the normal law that took the prior there."""
    posterior = hypothesis.fit.posterior
    if posterior is None:
        return
    priors = _before(hypothesis)
    for index, coordinate in enumerate(posterior.coordinates):
        if not has_level(coordinate.key):
            continue
        mean, variance = priors.get(coordinate.key, (0.0, coordinate.slab**2))
        after, spread = float(posterior.mean[index]), float(posterior.covariance[index, index])
        if not 0.0 < spread < (1.0 - TELLS) * variance:
            continue
        noise = 1.0 / (1.0 / spread - 1.0 / variance)
        yield (
            coordinate,
            Seen(coordinate.key, record, hypothesis.date, noise * (after / spread - mean / variance), noise**0.5),
        )


def _before(hypothesis: Hypothesis) -> Mapping[LevelKey, tuple[float, float]]:
    """Mean and variance that the mission knew of its own effects which are as it knew them."""
    wanted = [CATALOGUE[name] for name in hypothesis.shown if name not in hypothesis.fit.causes]
    return {
        coordinate.key: (float(mean), float(variance))
        for prior in given_priors(hypothesis.before, wanted)
        for coordinate, mean, variance in zip(prior.coordinates, prior.mean, prior.covariance.diagonal(), strict=True)
    }


DRAWS, FEWEST = 8192, 16
"""Draws of a posterior, and of each of its sets at least."""
LEAST = 2e-3
"""Probability below which a set is left out."""
LEAST_FACTOR = 1.02
"""Factor below which σ_v is written as a number."""


def with_noise(raw: Mapping[str, object], calibration: Mapping[str, float]) -> dict[str, object]:
    """Return a mission's data with the noise that was fitted, ``sigma_v_m_s``, where it has a sigma."""
    mission = copy.deepcopy(dict(raw))
    if "sigma_v_m_s" in calibration:
        _set_sigma(mission, calibration["sigma_v_m_s"], calibration.get("sigma_v_factor", 1.0))
    return mission


def _set_sigma(mission: Mapping[str, object], median: float, factor: float) -> None:
    """Write σ_v, as a distribution where it is known how uncertain it is."""
    navigation = mission.get("navigation")
    error = navigation.get("velocity_error") if isinstance(navigation, dict) else None
    if isinstance(error, dict) and "sigma" in error:
        middle = f"{median:.4g} m/s"
        uncertain = {"median": middle, "factor": float(f"{factor:.4g}")}
        error["sigma"] = uncertain if factor > LEAST_FACTOR else middle


def having_learned(extended: Mapping[str, object], identities: Sequence[str]) -> dict[str, object]:
    """Write into a mission's data that it has learned from measurements, by their hashes, the last `MOST_LEARNED`."""
    before = extended.get("learned_from")
    learned = dict.fromkeys([*(before if isinstance(before, list) else []), *identities])
    return {**extended, **({"learned_from": list(learned)[-MOST_LEARNED:]} if learned else {})}


def extended_mission(hypotheses: Sequence[Hypothesis], identities: Sequence[str] = ()) -> dict[str, object]:
    """Write hypotheses into one mission, as weighted draws.

    Everything but the effects and the noise is that of the likeliest. Hypotheses that differ in the vehicle's own keys,
    as tank data change them, cannot be written together: the likeliest is written alone.

    `hypotheses` has the likeliest first; `identities` are hashes of the data.
    """
    mission = having_learned(copy.deepcopy(dict(hypotheses[0].data)), identities)
    if any(hypothesis.data.get("vehicle") != mission.get("vehicle") for hypothesis in hypotheses):
        hypotheses = hypotheses[:1]
    draws = _draws(
        [hypothesis for hypothesis in hypotheses if hypothesis.probability >= LEAST * hypotheses[0].probability]
    )
    _forget(mission, set(draws.effects) | {name for hypothesis in hypotheses for name in hypothesis.shown})
    mission.pop(POSTERIOR, None)
    if SIGMA in draws.columns:
        logs, weights = np.log(draws.values[:, draws.columns.index(SIGMA)]), draws.weights
        centre = float(weights @ logs)
        _set_sigma(mission, math.exp(centre), math.exp(math.sqrt(float(weights @ (logs - centre) ** 2))))
    if draws.effects:
        start = mission.get("start")
        epoch = math.nan if start is None else moment_of(start).timestamp()
        summary = _summary(draws, "" if start is None else moment_of(start).isoformat())
        mission[POSTERIOR] = PosteriorFile.of(
            draws,
            hash_of(mission.get("learned_from")),
            summary,
            epoch,
            hypotheses[0].places,
            seen_after(hypotheses, hash_of(identities)),
        )
    return mission


def _forget(mission: dict[str, object], effects: Collection[str]) -> None:
    """Take out what a mission states of effects that its draws hold now, and what ties them."""
    gone = ("effects[", *(f"effects.{name}." for name in effects))
    kept = [entry for entry in _items(mission, "effects") if ONE_OF not in entry and not set(entry) & set(effects)]
    pairs = _items(mission, "correlations")
    tied = [pair for pair in pairs if not any(str(name).startswith(gone) for name in pair["between"])]
    for key, left in (("effects", kept), ("correlations", tied)):
        mission.pop(key, None)
        if left:
            mission[key] = left


def _items(mission: Mapping[str, object], key: str) -> list[Any]:
    """Items of a list of a mission that has been read."""
    value = mission.get(key)
    return list(value) if isinstance(value, list) else []


def _draws(hypotheses: Sequence[Hypothesis]) -> WeightedDraws:
    """Draw each hypothesis as often as it is likely; those with the same effects are one set."""
    total = sum(hypothesis.probability for hypothesis in hypotheses)
    sets: dict[Causes, list[tuple[dict[Column, Array], Array]]] = {}
    for number, hypothesis in enumerate(hypotheses):
        count = max(FEWEST, round(DRAWS * hypothesis.probability / total))
        drawn = _drawn(hypothesis, count, stream(0, POSTERIOR, number))
        effects = tuple(name for name in CATALOGUE if any(name == effect for effect, _ in drawn))
        sets.setdefault(effects, []).append((drawn, np.full(count, hypothesis.probability / total / count)))
    columns = tuple(dict.fromkeys(column for parts in sets.values() for drawn, _ in parts for column in drawn))
    rows, shares = [], []
    for effects, parts in sets.items():
        values = np.concatenate([_rows(drawn, len(weights), columns, effects) for drawn, weights in parts])
        order = np.lexsort(values.T[::-1]) if columns else np.arange(len(values))  # neighbours are alike
        rows.append(values[order])
        shares.append(np.concatenate([weights for _, weights in parts])[order])
    which = np.repeat(np.arange(len(rows)), [len(block) for block in rows])
    weights = np.concatenate(shares)
    return WeightedDraws(tuple(sets), which, columns, np.concatenate(rows), weights / weights.sum())


def _rows(drawn: Mapping[Column, Array], count: int, columns: Sequence[Column], effects: Causes) -> Array:
    """Draws as rows of all columns: a parameter that one fit has and another leaves out is at its default there."""
    rows = np.full((count, len(columns)), np.nan)
    for index, (effect, name) in enumerate(columns):
        if (effect, name) in drawn:
            rows[:, index] = drawn[effect, name]
        elif effect in effects:
            rows[:, index] = CATALOGUE[effect].parameters[name].default
    return rows


def _drawn(hypothesis: Hypothesis, count: int, generator: np.random.Generator) -> dict[Column, Array]:
    """Draws of all effects of a hypothesis: what the data show of them, and what the mission knew of the others."""
    draws: dict[Column, Array] = (
        hypothesis.fit.posterior.drawn(count, generator) if hypothesis.fit.posterior is not None else {}
    )
    seen = {*hypothesis.shown, *hypothesis.fit.causes}
    others = [e for e in hypothesis.before.effect_list.known if e.effect not in seen and e.explanation is not None]
    stated = {entry.place: entry for entry in others if not is_learned(entry)}
    if stated:
        drawn, weights = stated_draws(hypothesis.before, {place: entry.parameters for place, entry in stated.items()})
        picked = _resampled(weights, count, generator)
        for entry, parameters in zip(stated.values(), drawn, strict=True):
            draws |= {(entry.effect, name): values[picked] for name, values in parameters.items()}
    learned = hypothesis.before.effect_list.learned
    if learned is not None:
        kept = {entry.effect for entry in others if is_learned(entry)} | ({""} if SIGMA not in draws else set())
        weighted_draws = learned.held_as_seen
        picked = _resampled(weighted_draws.weights, count, generator)
        draws |= {c: weighted_draws.values[picked, i] for i, c in enumerate(weighted_draws.columns) if c[0] in kept}
    return draws


def _resampled(weights: Array, count: int, generator: np.random.Generator) -> NDArray[np.int_]:
    """Places of draws, each about as often as its weight says, in random order."""
    picked = np.searchsorted(np.cumsum(weights), (np.arange(count) + generator.random()) / count)
    return generator.permutation(np.minimum(picked, len(weights) - 1))


def _summary(draws: WeightedDraws, start: str) -> dict[str, object]:
    """What a person reads of the draws: each effect with its probability, means and spreads, and the date of phases."""
    summary: dict[str, object] = {}
    for effect in sorted(draws.effects, key=lambda name: -draws.probability(name)):
        words: dict[str, object] = {"probability": float(f"{draws.probability(effect):.4g}")}
        for other, name in draws.columns:
            if other == effect:
                words[name] = _in_words((effect, name), *draws.column((effect, name)))
        summary[effect] = words | ({"epoch": start} if start and CATALOGUE[effect].frequency_of is not None else {})
    return summary


def _in_words(column: Column, values: Array, weights: Array) -> object:
    """Mean and standard deviation, of an angle about its direction, of a size or a time middle and factor."""
    parameter, shares = CATALOGUE[column[0]].parameters[column[1]], weights / weights.sum()
    scale, unit = (180.0 / math.pi, "deg") if parameter.unit == "rad" else (1.0, parameter.unit)

    def written(value: float) -> str | float:
        return f"{scale * value:.4g} {unit}" if unit else float(f"{value:.4g}")

    if parameter.is_shape and np.all(values > 0.0):
        logs = np.log(values)
        centre = float(shares @ logs)
        factor = math.exp(math.sqrt(float(shares @ (logs - centre) ** 2)))
        return {"median": written(math.exp(centre)), "factor": float(f"{max(factor, 1.0001):.4g}")}
    centre = float(shares @ values)
    if any(column[1] == phase for _, phase in CATALOGUE[column[0]].polar):
        centre = float(np.angle(shares @ np.exp(1j * values)))
        values = centre + np.angle(np.exp(1j * (values - centre)))
    return {"mean": written(centre), "sd": written(math.sqrt(float(shares @ (values - centre) ** 2)))}
