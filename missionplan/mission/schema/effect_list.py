"""Effects of a mission as they are read: those that always hold, and explanations of which one holds."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any, Generic, cast

from missionplan.errors import KeyPath
from missionplan.mission.schema.section import V
from missionplan.montecarlo.distributions import ROUNDING, WhichHolds
from missionplan.montecarlo.draws import Correlation

ONE_OF = "one-of"
"""Key of a list of explanations."""


@dataclass(frozen=True)
class EffectEntry(Generic[V]):
    """One effect of the mission.

    Attributes
    ----------
    effect : str
        Its id in the catalogue.
    parameters : dict
        Floats or distributions; drawn, floats or arrays [SI].
    path : tuple of (str or int)
        Where it stands in the file.
    explanation : (str, int) or None
        Key path of the `one-of` that it stands in and the number of its explanation there; None: it always holds.
    """

    effect: str
    parameters: dict[str, V]
    path: KeyPath = ()
    explanation: tuple[str, int] | None = None

    @property
    def place(self) -> str:
        """First part of the key paths of its parameters: ``effects.compass-bias``."""
        if self.explanation is None:
            return f"effects.{self.effect}"
        return f"{self.explanation[0]}[{self.explanation[1]}].{self.effect}"

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
    """Effects that hold together, with a probability.

    Attributes
    ----------
    probability : float
    effects : tuple of EffectEntry
    correlations : tuple of Correlation
        Of their parameters, by key paths within the explanation: ``compass-bias.angle``.
    """

    probability: float
    effects: tuple[EffectEntry[V], ...]
    correlations: tuple[Correlation, ...] = ()

    @property
    def causes(self) -> tuple[str, ...]:
        """Names of its effects."""
        return tuple(entry.effect for entry in self.effects)


@dataclass(frozen=True)
class OneOf(Generic[V]):
    """Explanations of which one holds, or none with what their probabilities leave to 1.

    Attributes
    ----------
    place : str
        Its key path.
    explanations : tuple of Explanation
    known : int or None
        Number of the explanation that is taken to hold, or of them all for none; None: it is drawn.
    drawn : float or array, shape (n,), or None
        Number of the explanation that holds, once it is drawn.
    """

    place: str
    explanations: tuple[Explanation[V], ...]
    known: int | None = None
    drawn: V | None = None

    @property
    def which(self) -> V:
        """The number of the explanation that holds."""
        if self.drawn is not None:
            return self.drawn
        which = WhichHolds(tuple(explanation.probability for explanation in self.explanations))
        return cast("V", which if self.known is None else float(self.known))

    @property
    def probabilities(self) -> tuple[float, ...]:
        """Of each explanation, and of none where they leave more than rounding."""
        given = tuple(explanation.probability for explanation in self.explanations)
        left = 1.0 - sum(given)
        return (*given, left) if left > ROUNDING else given

    @property
    def causes(self) -> tuple[tuple[str, ...], ...]:
        """Names of the effects of each of these; empty for none."""
        found = tuple(explanation.causes for explanation in self.explanations)
        return (*found, ()) if len(self.probabilities) > len(found) else found

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
class EffectList(Generic[V]):
    """The whole section.

    Attributes
    ----------
    items : tuple of EffectEntry and OneOf
        In the order of the file.
    """

    items: tuple[EffectEntry[V] | OneOf[V], ...] = ()

    @property
    def entries(self) -> tuple[EffectEntry[V], ...]:
        """Every effect, those of explanations too."""
        found: list[EffectEntry[V]] = []
        for item in self.items:
            inside = (
                [item] if isinstance(item, EffectEntry) else [e for each in item.explanations for e in each.effects]
            )
            found += inside
        return tuple(found)

    @property
    def known(self) -> tuple[EffectEntry[V], ...]:
        """The effects that are known to hold: without those of explanations that may not."""
        known = {(item.place, item.known) for item in self.doubts}
        return tuple(entry for entry in self.entries if entry.explanation is None or entry.explanation in known)

    @property
    def doubts(self) -> tuple[OneOf[V], ...]:
        """The explanations of which one holds."""
        return tuple(item for item in self.items if isinstance(item, OneOf))

    def streams(self) -> dict[str, str]:
        """Return by the place of every effect the name under which its random numbers are drawn.

        An effect in doubt has the numbers that it would have if it always held; of several entries of one effect the
        first has them, one that always holds before the others.
        """
        found: dict[str, str] = {}
        for entry in sorted(self.entries, key=lambda each: each.explanation is not None):
            name = f"effects.{entry.effect}"
            found[entry.place] = entry.place if name in found.values() else name
        return found

    def mapped(self, change: Callable[[str, Any], Any]) -> "EffectList[Any]":
        """Return the list with every parameter, and which explanations hold, changed, given names and values."""
        return EffectList(tuple(item.mapped(change) for item in self.items))

    def knowing(self, place: str, number: int) -> "EffectList[V]":
        """Return the list with the explanation of a number known to hold, of the `one-of` at a key path."""
        items = (
            replace(item, known=number, drawn=None) if isinstance(item, OneOf) and item.place == place else item
            for item in self.items
        )
        return EffectList(tuple(items))
