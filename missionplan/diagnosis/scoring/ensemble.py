"""What a mission expects of a data set before it is seen: draws of the means, and covariances of the rest."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise, product

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.mission import Mission
from missionplan.mission.schema.effect_list import EffectList


def explained(mission: Mission) -> list[tuple[float, Mission]]:
    """Return the mission under each combination of its explanations, with the probability that it holds."""
    doubts = [doubt for doubt in mission.doubts if doubt.known is None]
    found = []
    for numbers in product(*(range(len(doubt.probabilities)) for doubt in doubts)):
        share, known = 1.0, mission
        for doubt, number in zip(doubts, numbers, strict=True):
            share, known = share * doubt.probabilities[number], known.knowing(doubt.place, number)
        if share > 0.0:
            found.append((share, known))
    return found


def bare_mission(mission: Mission) -> Mission:
    """Return the mission without its effects."""
    kept = tuple(each for each in mission.correlations if not any(path.startswith("effects") for path in each.between))
    return mission.model_copy(update={"effect_list": EffectList(), "correlations": kept})


RELATIVE_JITTER = 1e-10
"""Added to the diagonal of a covariance, of its mean: a record may have values that are not uncertain at all."""


@dataclass(frozen=True)
class Noise:
    """What is random beside the draws: normal, independent of them."""

    weight: float
    """Prior probability, among the noises of its part."""
    covariance: Array
    """Of the v values, shape (v, v)."""
    scales: Array
    """Shape (s,). Equally likely factors on the standard deviation of the share that has heavy tails; (1,) for none."""
    tailed: Array
    """Variance of that share in each value, shape (v,)."""


@dataclass(frozen=True)
class Part:
    """One explanation of the mission: its probability, and what it expects."""

    probability: float
    """That it holds; those of all parts add up to 1."""
    draws: Array
    """Shape (d, v). Expected values in each of d draws of the uncertain quantities; one row where nothing is uncertain.
    """
    noises: tuple[Noise, ...]
    """For as many draws of the sizes of what is random."""


@dataclass(frozen=True)
class Component:
    """One normal distribution of all values, of a mixture."""

    log_weight: float
    mean: Array
    covariance: Array
    noise: Noise


@dataclass(frozen=True)
class Ensemble:
    """A mission's distribution of all values of a record."""

    values: Array
    """As measured, group by group, shape (v,)."""
    groups: NDArray[np.int_]
    """Leg or dive of each value, from 0, in the order of time, shape (v,)."""
    parts: tuple[Part, ...]

    def slices(self) -> list[slice]:
        """Values of each group."""
        edges = np.searchsorted(self.groups, np.arange(int(self.groups[-1]) + 2))
        return [slice(int(first), int(last)) for first, last in pairwise(edges)]

    def later(self, groups: int) -> "Ensemble":
        """Return all but the first groups, before any of the record is seen."""
        rows = slice(int(np.searchsorted(self.groups, groups)), None)
        parts = tuple(
            Part(part.probability, part.draws[:, rows], tuple(_rows(noise, rows) for noise in part.noises))
            for part in self.parts
        )
        return Ensemble(self.values[rows], self.groups[rows] - groups, parts)

    def after(self, groups: int) -> "Ensemble":
        """Return all but the first groups, what is random in them given the first.

        The mission has learned its draws from the first: these do not weigh them again, but tell where errors that
        persist then were.
        """
        if not groups:
            return self
        first = int(np.searchsorted(self.groups, groups))
        parts = tuple(_given(self.values[:first], part, noise) for part in self.parts for noise in part.noises)
        return Ensemble(self.values[first:], self.groups[first:] - groups, parts)

    def components(self) -> Iterator[Component]:
        """Yield normal distributions: the draws by their mean and covariance, each noise by itself."""
        for part in self.parts:
            mean = part.draws.mean(axis=0)
            apart = part.draws - mean
            spread = apart.T @ apart / max(len(apart) - 1, 1)
            for noise in part.noises:
                covariance = _definite(spread + noise.covariance)
                yield Component(float(np.log(part.probability * noise.weight)), mean, covariance, noise)


def _definite(covariance: Array) -> Array:
    """Add the jitter to a covariance."""
    return covariance + RELATIVE_JITTER * max(float(np.mean(np.diag(covariance))), 1e-12) * np.eye(len(covariance))


def _rows(noise: Noise, rows: slice) -> Noise:
    """Return what is random in some of the values."""
    return replace(noise, covariance=noise.covariance[rows, rows], tailed=noise.tailed[rows])


def _given(first: Array, part: Part, noise: Noise) -> Part:
    """Return the values after the first under one noise, given these: in each draw the conditional normal law."""
    seen, rest = slice(len(first)), slice(len(first), None)
    shared = noise.covariance[seen, rest]
    gain = np.linalg.solve(_definite(noise.covariance[seen, seen]), shared)
    own = _rows(noise, rest)
    left = replace(own, weight=1.0, covariance=own.covariance - shared.T @ gain)
    draws = part.draws[:, rest] + (first - part.draws[:, seen]) @ gain
    return Part(part.probability * noise.weight, draws, (left,))
