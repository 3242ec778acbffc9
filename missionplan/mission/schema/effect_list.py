"""Effects of a mission as they are read: those that always hold, and explanations of which one holds."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

from missionplan.errors import KeyPath
from missionplan.montecarlo.distributions import ROUNDING, Quantity, WhichHolds
from missionplan.montecarlo.draws import Correlation

ONE_OF = "one-of"
"""Key of a list of explanations."""


@dataclass(frozen=True)
class EffectEntry:
    """One effect of the mission.

    Attributes
    ----------
    effect : str
        Its id in the catalogue.
    parameters : dict
        Floats or distributions [SI].
    path : tuple of (str or int)
        Where it stands in the file.
    explanation : (str, int) or None
        Key path of the `one-of` that it stands in and the number of its explanation there; None: it always holds.
    """

    effect: str
    parameters: dict[str, Quantity]
    path: KeyPath = ()
    explanation: tuple[str, int] | None = None

    @property
    def place(self) -> str:
        """First part of the key paths of its parameters: ``effects.compass-bias``."""
        if self.explanation is None:
            return f"effects.{self.effect}"
        return f"{self.explanation[0]}[{self.explanation[1]}].{self.effect}"

    def quantities(self) -> dict[str, Quantity]:
        """Return the parameters by their key paths."""
        return {f"{self.place}.{name}": value for name, value in self.parameters.items()}


@dataclass(frozen=True)
class Explanation:
    """Effects that hold together, with a probability.

    Attributes
    ----------
    probability : float
    effects : tuple of EffectEntry
    correlations : tuple of Correlation
        Of their parameters, by key paths within the explanation: ``compass-bias.angle``.
    """

    probability: float
    effects: tuple[EffectEntry, ...]
    correlations: tuple[Correlation, ...] = ()

    @property
    def causes(self) -> tuple[str, ...]:
        """Names of its effects."""
        return tuple(entry.effect for entry in self.effects)


@dataclass(frozen=True)
class OneOf:
    """Explanations of which one holds, or none with what their probabilities leave to 1.

    Attributes
    ----------
    place : str
        Its key path.
    explanations : tuple of Explanation
    known : int or None
        Number of the explanation that is taken to hold, or of them all for none; None: it is drawn.
    """

    place: str
    explanations: tuple[Explanation, ...]
    known: int | None = None

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

    def quantities(self) -> dict[str, Quantity]:
        """Return which one holds, and the parameters of every one, by their key paths."""
        which = WhichHolds(tuple(explanation.probability for explanation in self.explanations))
        found: dict[str, Quantity] = {self.place: which if self.known is None else float(self.known)}
        for explanation in self.explanations:
            for entry in explanation.effects:
                found |= entry.quantities()
        return found

    def correlations(self) -> Iterator[Correlation]:
        """Yield the correlations by whole key paths."""
        for number, explanation in enumerate(self.explanations):
            for correlation in explanation.correlations:
                first, second = (f"{self.place}[{number}].{name}" for name in correlation.between)
                yield Correlation((first, second), correlation.rho)


@dataclass(frozen=True)
class EffectList:
    """The whole section.

    Attributes
    ----------
    items : tuple of EffectEntry and OneOf
        In the order of the file.
    """

    items: tuple[EffectEntry | OneOf, ...] = ()

    @property
    def entries(self) -> tuple[EffectEntry, ...]:
        """Every effect, those of explanations too."""
        found: list[EffectEntry] = []
        for item in self.items:
            inside = (
                [item] if isinstance(item, EffectEntry) else [e for each in item.explanations for e in each.effects]
            )
            found += inside
        return tuple(found)

    @property
    def known(self) -> tuple[EffectEntry, ...]:
        """The effects that are known to hold: without those of explanations that may not."""
        known = {(item.place, item.known) for item in self.doubts}
        return tuple(entry for entry in self.entries if entry.explanation is None or entry.explanation in known)

    @property
    def doubts(self) -> tuple[OneOf, ...]:
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

    def quantities(self) -> dict[str, Quantity]:
        """Return every parameter, and which explanations hold, by key path."""
        found: dict[str, Quantity] = {}
        for item in self.items:
            found |= item.quantities()
        return found

    def knowing(self, place: str, number: int) -> "EffectList":
        """Return the list with the explanation of a number known to hold, of the `one-of` at a key path."""
        items = (
            replace(item, known=number) if isinstance(item, OneOf) and item.place == place else item
            for item in self.items
        )
        return EffectList(tuple(items))
