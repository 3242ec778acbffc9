"""Discrete causes of small probability, each tried for itself: their probabilities are known, none need be found.

A chain moves from one value of a discrete quantity to another only by a jump in its normal. A value of probability
10⁻⁵ that makes a mission fail is met by no pilot, however probable the failure is under it. So the trials are divided:
into those in which a quantity takes such a value, and those in which none does. Quantity by quantity, in an order that
is fixed, stratum j holds the trials in which quantity j takes the value and none before it takes a rare one; the later
ones are free. The strata exclude each other, and together are all trials.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import scipy

from missionplan.arrays import Array
from missionplan.montecarlo.rare_events.population import Key, NormalPopulation

RARE = 1.0 / 16.0
"""Probability of a value below which it gets a stratum: of a pilot's chains sixteen and more start at any other."""
MOST_STRATA = 32
"""Beside the one of what is usual. Where there are more rare values, the least probable get them."""

Interval = tuple[float, float]
"""Of probabilities of a standard normal, Φ(z)."""


@dataclass(frozen=True)
class DiscreteValue:
    """A value of a discrete quantity.

    Attributes
    ----------
    quantity : str
    value : str
        As a reader knows it.
    interval : Interval
        Where the quantity's normal gives this value.
    """

    quantity: str
    value: str
    interval: Interval

    @property
    def probability(self) -> float:
        """Probability of the value."""
        return self.interval[1] - self.interval[0]


@dataclass(frozen=True)
class Stratum:
    """A part of all trials.

    Attributes
    ----------
    probability : float
        Of a trial to be in it.
    value : DiscreteValue or None
        The rare value that its trials have; None where none has one.
    allowed : mapping of Key to sequence of Interval
        Where the normals of its discrete quantities lie.
    """

    probability: float = 1.0
    value: DiscreteValue | None = None
    allowed: Mapping[Key, Sequence[Interval]] = field(default_factory=dict)


@dataclass(frozen=True)
class StrataView:
    """Trials of strata: a population whose normals of discrete quantities are brought to where they may lie.

    Attributes
    ----------
    population : NormalPopulation
    strata : sequence of Stratum
        As many trials of each, side by side.
    """

    population: NormalPopulation
    strata: Sequence[Stratum] = (Stratum(),)

    @property
    def trials(self) -> int:
        """Number of trials."""
        return self.population.trials

    def cell(self, name: str, leg: int = 0, rows: int = 1) -> Array:
        """Return the normals of a quantity on a leg, shape (rows, n)."""
        normals, key = self.population.cell(name, leg, rows), (name, leg)
        if not any(key in stratum.allowed for stratum in self.strata):
            return normals
        parts = [
            _brought_into(part, stratum.allowed[key]) if key in stratum.allowed else part
            for part, stratum in zip(np.split(normals, len(self.strata), axis=1), self.strata, strict=True)
        ]
        return np.concatenate(parts, axis=1)


def strata(values: Mapping[Key, Sequence[DiscreteValue]]) -> tuple[Stratum, ...]:
    """Divide all trials by the rare values of discrete quantities; the first stratum has none of them.

    Parameters
    ----------
    values : mapping of Key to sequence of DiscreteValue
        All values of each discrete quantity, by the key of the normal from which it is drawn.
    """
    rare = sorted(value.probability for each in values.values() for value in each if 0.0 < value.probability < RARE)
    least = rare[MOST_STRATA] if len(rare) > MOST_STRATA else RARE
    parts: list[Stratum] = []
    usual: dict[Key, Sequence[Interval]] = {}
    left = 1.0
    for key, each in values.items():
        own = [value for value in each if 0.0 < value.probability < least]
        parts += [Stratum(left * value.probability, value, {**usual, key: (value.interval,)}) for value in own]
        if own:
            usual[key] = [value.interval for value in each if value not in own]
            left *= 1.0 - math.fsum(value.probability for value in own)
    return Stratum(left, None, usual), *parts


def _brought_into(normals: Array, intervals: Sequence[Interval]) -> Array:
    """Map standard normals to normals within intervals of probability, through their probabilities."""
    starts, ends = np.array(intervals).T
    covered = np.concatenate([[0.0], np.cumsum(ends - starts)])
    share = scipy.special.ndtr(normals) * covered[-1]
    number = np.minimum(np.searchsorted(covered, share, side="right") - 1, len(starts) - 1)
    inside = np.minimum(starts[number] + (share - covered[number]), np.nextafter(ends[number], 0.0))
    return np.asarray(scipy.special.ndtri(np.maximum(inside, np.nextafter(starts[number], 1.0))))
