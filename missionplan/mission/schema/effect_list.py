"""Effects of a mission: those that always hold, explanations of which one holds, and a posterior over sets of them."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Generic, cast

import numpy as np

from missionplan.arrays import Array
from missionplan.effects import CATALOGUE
from missionplan.errors import KeyPath
from missionplan.mission.schema import V
from missionplan.montecarlo.distributions import ROUNDING, WhichHolds
from missionplan.montecarlo.posterior import Column, WeightedDraws
from missionplan.montecarlo.streams import Correlation

ONE_OF = "one-of"
"""Key of a list of explanations."""
LIKELY = 0.05
"""Least probability of a set of effects that a plan is judged under by itself."""
POSTERIOR = "posterior"
"""Key of the section that names draws, and the name of the random stream from which all of them are picked."""


@dataclass(frozen=True)
class EffectEntry(Generic[V]):
    """One effect of the mission."""

    effect: str
    """Its id in the catalogue."""
    parameters: dict[str, V]
    """Floats or distributions; drawn, floats or arrays [SI]."""
    path: KeyPath = ()
    """Where it stands in the file."""
    explanation: tuple[str, tuple[int, ...]] | None = None
    """Key path of what is in doubt, and the numbers of the explanations there with which it holds; None: it always
    holds."""
    epoch: float | None = None
    """Date from which its phases count [s since 1970]; None: from the mission's start."""

    @property
    def place(self) -> str:
        """First part of the key paths of its parameters: ``effects.compass-bias``."""
        if self.explanation is None or self.explanation[0] == POSTERIOR:
            return f"effects.{self.effect}"
        place, (number,) = self.explanation
        return f"{place}[{number}].{self.effect}"

    @property
    def names(self) -> tuple[str, ...]:
        """Key paths of the parameters."""
        return tuple(f"{self.place}.{name}" for name in self.parameters)

    def mapped(self, change: Callable[[str, Any], Any]) -> "EffectEntry[Any]":
        """Return the effect with its parameters changed, given their names and values."""
        parameters = {name: change(f"{self.place}.{name}", value) for name, value in self.parameters.items()}
        return replace(self, parameters=parameters)


@dataclass(frozen=True)
class Explanation(Generic[V]):
    """Effects that hold together, with a probability."""

    probability: float
    effects: tuple[EffectEntry[V], ...]
    correlations: tuple[Correlation, ...] = ()
    """Of their parameters, by key paths within the explanation: ``compass-bias.angle``."""

    @property
    def causes(self) -> tuple[str, ...]:
        """Names of its effects."""
        return tuple(entry.effect for entry in self.effects)


@dataclass(frozen=True)
class OneOf(Generic[V]):
    """Explanations of which one holds, or none with what their probabilities leave to 1."""

    place: str
    """Its key path."""
    explanations: tuple[Explanation[V], ...]
    known: int | None = None
    """Number of the explanation that is taken to hold, or of them all for none; None: it is drawn."""
    drawn: V | None = None
    """Number of the explanation that holds, once it is drawn, shape (n,)."""

    @property
    def which(self) -> V:
        """The number of the explanation that holds."""
        if self.drawn is not None:
            return self.drawn
        which = WhichHolds(tuple(explanation.probability for explanation in self.explanations))
        return cast("V", which if self.known is None else float(self.known))

    @property
    def entries(self) -> tuple[EffectEntry[V], ...]:
        """Effects of every explanation."""
        return tuple(entry for explanation in self.explanations for entry in explanation.effects)

    @property
    def probabilities(self) -> tuple[float, ...]:
        """Of each explanation, and of none where they leave more than rounding."""
        shares = tuple(explanation.probability for explanation in self.explanations)
        left = 1.0 - sum(shares)
        return (*shares, left) if left > ROUNDING else shares

    @property
    def causes(self) -> tuple[tuple[str, ...], ...]:
        """Names of the effects of each of these; empty for none."""
        causes = tuple(explanation.causes for explanation in self.explanations)
        return (*causes, ()) if len(self.probabilities) > len(causes) else causes

    @property
    def told_apart(self) -> tuple[int, ...]:
        """Numbers of these that a plan is judged under one by one: all; none once one is known to hold."""
        return tuple(range(len(self.probabilities))) if self.known is None else ()

    def mapped(self, change: Callable[[str, Any], Any]) -> "OneOf[Any]":
        """Return the list with which one holds and the parameters of every one changed, given names and values."""
        which = change(self.place, self.which)
        explanations = tuple(
            replace(explanation, effects=tuple(entry.mapped(change) for entry in explanation.effects))
            for explanation in self.explanations
        )
        return replace(self, explanations=explanations, drawn=which)

    def correlations(self) -> Iterator[Correlation]:
        """Yield the correlations by whole key paths."""
        for number, explanation in enumerate(self.explanations):
            for correlation in explanation.correlations:
                first, second = (f"{self.place}[{number}].{name}" for name in correlation.between)
                yield Correlation((first, second), correlation.rho)


@dataclass(frozen=True)
class Learned(Generic[V]):
    """A posterior: sets of effects of which one holds, whose parameters are picked together from its draws."""

    draws: WeightedDraws
    entries: tuple[EffectEntry[V], ...]
    """Each effect of a set once, for all sets with it."""
    known: int | None = None
    """Number of the set that is taken to hold; None: it is drawn."""
    drawn: V | None = None
    """Number of the set that holds, once it is drawn, shape (n,)."""
    unaged: WeightedDraws | None = None
    """The draws as of the last record, where `draws` are of another date."""

    place = POSTERIOR

    @property
    def as_seen(self) -> WeightedDraws:
        """Draws as of the last record, of all sets."""
        return self.draws if self.unaged is None else self.unaged

    @property
    def which(self) -> V:
        """The number of the set that holds."""
        if self.drawn is not None:
            return self.drawn
        return cast("V", WhichHolds(self.draws.probabilities) if self.known is None else float(self.known))

    @property
    def probabilities(self) -> tuple[float, ...]:
        """Of each set."""
        return self.draws.probabilities

    @property
    def causes(self) -> tuple[tuple[str, ...], ...]:
        """Effects of each set."""
        return self.draws.sets

    @property
    def told_apart(self) -> tuple[int, ...]:
        """Numbers of the sets that a plan is judged under one by one: those likely enough, where there are several."""
        likely = tuple(number for number, share in enumerate(self.probabilities) if share >= LIKELY)
        return likely if self.known is None and len(likely) > 1 else ()

    def mapped(self, change: Callable[[str, Any], Any]) -> "Learned[Any]":
        """Return it with which set holds and the parameters changed, given their names and values."""
        entries = tuple(entry.mapped(change) for entry in self.entries)
        return replace(self, entries=entries, drawn=change(self.place, self.which))

    def knowing(self, number: int) -> "Learned[V]":
        """Return it with a set known to hold: its effects alone, with its draws."""
        stated = {entry.effect for entry in self.entries}
        entries = tuple(
            replace(entry, explanation=(POSTERIOR, (number,)))
            for entry in effects_of_draws(self.draws.of_set(number))
            if entry.effect in stated
        )
        return replace(self, entries=cast("tuple[EffectEntry[V], ...]", entries), known=number, drawn=None)

    @property
    def held(self) -> WeightedDraws:
        """Its draws: those of the set that is known to hold, else all."""
        return self.draws if self.known is None else self.draws.of_set(self.known)

    @property
    def held_as_seen(self) -> WeightedDraws:
        """Likewise, as of the last record."""
        return self.as_seen if self.known is None else self.as_seen.of_set(self.known)

    def correlations(self) -> Iterator[Correlation]:
        """Yield none: draws are joint as they are."""
        return iter(())


def effects_of_draws(draws: WeightedDraws) -> tuple[EffectEntry, ...]:
    """Return each effect of draws once, with its parameters and the sets with which it holds."""
    entries = []
    for effect in draws.effects:
        numbers = tuple(number for number, effects in enumerate(draws.sets) if effect in effects)
        columns = [column for column in draws.columns if column[0] == effect]
        typical = _typical(draws, columns)
        parameters = {name: draws.distribution((effect, name), typical[name]) for _, name in columns}
        entries.append(EffectEntry(effect, parameters, (POSTERIOR,), (POSTERIOR, numbers)))
    return tuple(entries)


def _typical(draws: WeightedDraws, columns: Sequence[Column]) -> Mapping[str, float]:
    """Parameters of an effect that stand for its draws: means, of sizes and times medians, of a vector its mean."""
    typical = {}
    for effect, name in columns:
        values, weights = draws.column((effect, name))
        if CATALOGUE[effect].parameters[name].is_shape:
            order = np.argsort(values)
            middle = np.searchsorted(np.cumsum(weights[order]), 0.5 * weights.sum())
            typical[name] = float(values[order[min(middle, len(order) - 1)]])
        else:
            typical[name] = float(np.average(values, weights=weights))
    for amplitude, phase in CATALOGUE[columns[0][0]].polar if columns else ():
        if amplitude in typical and phase in typical:
            (sizes, weights), (angles, _) = (draws.column((columns[0][0], name)) for name in (amplitude, phase))
            turned: Array = sizes * np.exp(1j * angles)
            mean = complex(np.average(turned, weights=weights))
            typical[amplitude], typical[phase] = float(np.abs(mean)), float(np.angle(mean))
    return typical


@dataclass(frozen=True)
class EffectList(Generic[V]):
    """Effects as the mission states them, and as it has learned them."""

    items: tuple[EffectEntry[V] | OneOf[V] | Learned[V], ...] = ()
    """In the order of the file."""

    @property
    def entries(self) -> tuple[EffectEntry[V], ...]:
        """Every effect, those of explanations too."""
        return tuple(
            entry for item in self.items for entry in ((item,) if isinstance(item, EffectEntry) else item.entries)
        )

    @property
    def known(self) -> tuple[EffectEntry[V], ...]:
        """The effects that are known to hold: without those of explanations that may not."""
        explanations: set[tuple[str, tuple[int | None, ...]]] = {(item.place, (item.known,)) for item in self.doubts}
        if self.learned is not None and self.learned.known is None:
            explanations.add((POSTERIOR, tuple(range(len(self.learned.draws.sets)))))  # in every set
        return tuple(entry for entry in self.entries if entry.explanation is None or entry.explanation in explanations)

    @property
    def doubts(self) -> tuple[OneOf[V] | Learned[V], ...]:
        """The explanations of which one holds."""
        return tuple(item for item in self.items if not isinstance(item, EffectEntry))

    def with_stated(self, change: Callable[[EffectEntry[V]], EffectEntry[V]]) -> "EffectList[V]":
        """Return the list with what the mission states of each effect changed, in explanations too."""

        def changed(item: Any) -> Any:
            if isinstance(item, OneOf):
                explanations = (
                    replace(explanation, effects=tuple(map(change, explanation.effects)))
                    for explanation in item.explanations
                )
                return replace(item, explanations=tuple(explanations))
            return change(item) if isinstance(item, EffectEntry) else item

        return EffectList(tuple(map(changed, self.items)))

    @property
    def learned(self) -> Learned[V] | None:
        """The posterior; None where the mission names none."""
        return next((item for item in self.items if isinstance(item, Learned)), None)

    def having_learned(self, draws: WeightedDraws) -> "EffectList":
        """Return the list with a posterior: what the mission states of an effect goes before what was learned of it."""
        stated = {entry.effect for entry in self.entries}
        entries = tuple(entry for entry in effects_of_draws(draws) if entry.effect not in stated)
        return EffectList((*cast("tuple[Any, ...]", self.items), Learned(draws, entries)))

    def stream_of(self, entry: EffectEntry[V], parameter: str) -> str:
        """Name of the random stream from which a parameter is drawn: the same for all of a posterior."""
        if entry.explanation is not None and entry.explanation[0] == POSTERIOR:
            return POSTERIOR
        return f"{self.streams()[entry.place]}.{parameter}"

    def streams(self) -> dict[str, str]:
        """Return by the place of every effect the name under which its random numbers are drawn.

        An effect in doubt has the numbers that it would have if it always held; of several entries of one effect the
        first has them, one that always holds before the others.
        """
        names: dict[str, str] = {}
        for entry in sorted(self.entries, key=lambda entry: entry.explanation is not None):
            name = f"effects.{entry.effect}"
            names[entry.place] = entry.place if name in names.values() else name
        return names

    def mapped(self, change: Callable[[str, Any], Any]) -> "EffectList[Any]":
        """Return the list with every parameter, and which explanations hold, changed, given names and values."""
        return EffectList(tuple(item.mapped(change) for item in self.items))

    def knowing(self, place: str, number: int) -> "EffectList[V]":
        """Return the list with the explanation of a number known to hold, of the `one-of` at a key path."""
        items: list[EffectEntry[V] | OneOf[V] | Learned[V]] = []
        for item in self.items:
            if isinstance(item, EffectEntry) or item.place != place:
                items.append(item)
            else:
                doubt = item.knowing(number) if isinstance(item, Learned) else replace(item, known=number, drawn=None)
                items.append(doubt)
        return EffectList(tuple(items))
