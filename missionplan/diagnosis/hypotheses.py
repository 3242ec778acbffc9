"""What may hold after a diagnosis, and what its record tells by itself of the levels of the vehicle."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from missionplan.diagnosis.coordinates import Coordinate
from missionplan.diagnosis.given.priors import given_priors, is_learned
from missionplan.diagnosis.inference.model import CauseFit
from missionplan.diagnosis.inference.selection import CREDIBLE
from missionplan.effects import CATALOGUE
from missionplan.mission import Mission
from missionplan.mission.learned import has_level
from missionplan.montecarlo.levels import LevelKey, Seen
from missionplan.montecarlo.posterior import NOWHERE, Place
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
    place: Place = NOWHERE
    """Of the data; see `DataKind.place`."""
    date: float = math.nan
    """Likewise `DataKind.date`."""


def seen_after(found: Sequence[Hypothesis], record: str) -> tuple[Seen, ...]:
    """Return what all records have told of levels, this one too.

    Of a level on which hypotheses differ, what the likeliest has that knows of it, of those that hold `CREDIBLE` of the
    probability or add to one of these: one without what the record shows takes its like for it.

    Parameters
    ----------
    found : sequence of Hypothesis
        The likeliest first.
    record : str
        Hash of this one.
    """
    known: dict[LevelKey, tuple[Seen, ...]] = {}
    before = np.cumsum([0.0, *(each.probability for each in found[:-1])])
    credible = [frozenset(each.causes) for each in found[: int(np.count_nonzero(before < CREDIBLE))]]
    for each in (one for one in found if any(own <= {*one.causes} for own in credible)):
        for key, seen in _seen_under(each, record).items():
            known.setdefault(key, seen)
    return tuple(row for rows in known.values() for row in rows)


def _seen_under(each: Hypothesis, record: str) -> dict[LevelKey, tuple[Seen, ...]]:
    """What records have told under one hypothesis, by level."""
    rows: dict[LevelKey, list[Seen]] = {}
    for row in each.before.posterior.seen if each.before.posterior is not None else ():
        rows.setdefault(row.of, []).append(row)
    stated = {entry.effect for entry in each.before.effects if not is_learned(entry)}
    for coordinate, told in _told(each, record):
        before = rows.setdefault(coordinate.key, [])
        if not before and coordinate.effect in stated and coordinate.effect not in each.fit.causes:
            mean, variance = _before(each)[coordinate.key]
            before.append(Seen(coordinate.key, "", math.nan, mean, math.sqrt(variance)))
        before.append(told)
    effects = {entry.effect for entry in each.before.effects} | set(each.fit.causes)
    return {key: tuple(own) for key, own in rows.items() if key[0] in effects}


def _told(each: Hypothesis, record: str) -> Iterator[tuple[Coordinate, Seen]]:
    """Each level of which the record tells, with what it tells of it: the normal law that took the prior there."""
    posterior = each.fit.posterior
    if posterior is None:
        return
    known = _before(each)
    for index, coordinate in enumerate(posterior.coordinates):
        if not has_level(coordinate.key):
            continue
        mean, variance = known.get(coordinate.key, (0.0, coordinate.slab**2))
        after, spread = float(posterior.mean[index]), float(posterior.covariance[index, index])
        if not 0.0 < spread < (1.0 - TELLS) * variance:
            continue
        own = 1.0 / (1.0 / spread - 1.0 / variance)
        yield coordinate, Seen(coordinate.key, record, each.date, own * (after / spread - mean / variance), own**0.5)


def _before(each: Hypothesis) -> Mapping[LevelKey, tuple[float, float]]:
    """Mean and variance that the mission knew of its own effects which are as it knew them."""
    wanted = [CATALOGUE[name] for name in each.shown if name not in each.fit.causes]
    return {
        coordinate.key: (float(mean), float(variance))
        for given in given_priors(each.before, wanted)
        for coordinate, mean, variance in zip(given.coordinates, given.mean, given.covariance.diagonal(), strict=True)
    }
