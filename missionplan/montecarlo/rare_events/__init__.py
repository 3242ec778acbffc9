"""Subset simulation: a rare failure as a chain of failures that are not rare.

Au & Beck (2001), *Probabilistic Engineering Mechanics* 16, 263–277: P(g ≤ 0) = P(g ≤ b₁) P(g ≤ b₂ | g ≤ b₁) …, each
factor near `SHARE`, each conditional sample made by Markov chains that start in the last one. The chains move by
conditional sampling (Papaioannou, Betz, Zwirglmaier & Straub 2015, same journal 41, 89–103), which works in any number
of dimensions.

With thresholds chosen from the sample itself the product is biased by O(1/N). Here a pilot chooses thresholds and
spreads, and a run of its own then keeps them: a fixed number of chains, of fixed length, starts from a systematic
resample of those that passed, so that the product is unbiased whatever the chains' correlation (Del Moral 2004,
*Feynman–Kac Formulae*, section 7.4.2). Each run has its own pilot: what one pilot misses the others need not, so that
the scatter of the runs says it. Many runs, the groups, go side by side as one population, perhaps towards different
failures: arrays of their trials are long, and nothing of one enters another. `strata` has what plain trials and
independent repetitions say together.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array

Key = tuple[str, int]
"""Name of a quantity, and the leg for which it is drawn (0 for one that is drawn once)."""


class NormalPopulation:
    """Standard normals of n trials.

    How many normals a trial needs is not known before it has been run (a transit has as many legs as it takes). What no
    trial has asked for is independent of all margins so far, and may be drawn later.
    """

    def __init__(self, trials: int, generator: np.random.Generator, cells: dict[Key, Array] | None = None) -> None:
        self.trials = trials
        self._generator = generator
        self._cells: dict[Key, Array] = {} if cells is None else cells

    def cell(self, name: str, leg: int = 0, rows: int = 1) -> Array:
        """Return the normals of a quantity on a leg, shape (rows, n)."""
        key = (name, leg)
        if key not in self._cells:
            self._cells[key] = self._draw(key, rows)
        return self._cells[key]

    def _draw(self, key: Key, rows: int) -> Array:
        return self._generator.standard_normal((rows, self.trials))

    def rows(self) -> dict[Key, int]:
        """Return what has been drawn, with the number of rows of each."""
        return {key: len(cell) for key, cell in self._cells.items()}

    def where(self, accepted: NDArray[np.bool_], other: "NormalPopulation") -> "NormalPopulation":
        """Take the accepted trials from another population, and the rest from this one."""
        cells = {
            (name, leg): np.where(accepted, other.cell(name, leg, rows), self.cell(name, leg, rows))
            for (name, leg), rows in {**self.rows(), **other.rows()}.items()
        }
        return NormalPopulation(self.trials, self._generator, cells)


class MovedPopulation(NormalPopulation):
    """Each trial moved at random so that standard normals stay standard normals (Papaioannou et al. 2015).

    u' = √(1 − s²) u + s ξ with ξ a new standard normal. The spread s, one or one a trial, is 1 for a trial drawn anew,
    0 for one that stays.
    """

    def __init__(self, parent: NormalPopulation, spread: float | Array, generator: np.random.Generator) -> None:
        super().__init__(parent.trials, generator)
        self._parent, self._spread = parent, np.asarray(spread)

    def _draw(self, key: Key, rows: int) -> Array:
        name, leg = key
        kept = np.sqrt(1.0 - self._spread**2) * self._parent.cell(name, leg, rows)
        return np.asarray(kept + self._spread * super()._draw(key, rows))


def gathered(
    populations: Sequence[NormalPopulation], chosen: NDArray[np.intp], generator: np.random.Generator
) -> NormalPopulation:
    """Collect trials of several populations, counted from the first trial of the first to the last of the last."""
    rows: dict[Key, int] = {}
    for population in populations:
        rows |= population.rows()
    cells = {
        (name, leg): np.concatenate([population.cell(name, leg, count) for population in populations], axis=1)[
            :, chosen
        ]
        for (name, leg), count in rows.items()
    }
    return NormalPopulation(chosen.size, generator, cells)


Scalar = TypeVar("Scalar", bound=np.generic)
Groups = NDArray[np.intp]
Drive = Callable[[NormalPopulation, Groups], tuple[Array, Array]]
"""Of each trial of a population, whose trials are of the groups of these numbers, as many of each, side by side: its
margin, zero or negative where it fails and the smaller the nearer to failure; and what it counts where it fails, which
is one unless it fails in other ways too. Both of shape (n,)."""

SHARE = 0.25
"""Of the trials of a level that pass to the next."""
STEPS = 4
"""States of a chain on each level: as many chains pass on average as there are."""
CHAINS = 128
"""Of each group: the more groups share the same trials, the better their scatter is known."""
PILOT_CHAINS = 64
ACCEPTED = 0.44
"""Share of accepted moves to which the pilot tunes the spread (Papaioannou et al., section 5)."""
MOST_LEVELS = 17
"""After which a failure counts as not found: at a probability of about 4⁻¹⁷ = 6e-11."""


@dataclass
class Levels:
    """Levels of a group, as its pilot chooses them one after another."""

    thresholds: list[float]
    """The trials of each level have at most this margin: infinite on the first."""
    spreads: list[float]
    """Of the moves on each level."""
    shares: list[float]
    """Of the trials of each level that passed to the next; of the last level, those that failed."""
    reached: bool = False
    """Whether failures were found; if not, the margin led nowhere."""

    @property
    def probability(self) -> float:
        """Of the failure, roughly; of coming as near to it as the last level where none was found."""
        return math.prod(self.shares if self.reached else self.shares[: len(self.thresholds) - 1])

    @property
    def count(self) -> int:
        """Number of levels."""
        return len(self.spreads)


@dataclass(frozen=True)
class Run:
    """What groups with fixed levels found."""

    probabilities: Array
    """Unbiased estimate of the probability of its failure, of each group, shape (groups,)."""
    counted: Array
    """The same, each failing trial counted as what it counts, shape (groups,)."""
    failing: NormalPopulation
    """A sample of the trials that fail, as many of each group."""
    weights: Array
    """Of that sample: those of a group sum to its `counted`, on average; zero where a group found no failure; shape
    (n,)."""
    trials: int
    """That were run."""


@dataclass(frozen=True)
class _States:
    """States of the chains of some groups, their margins and what they count."""

    groups: Groups
    population: NormalPopulation
    margins: Array
    counts: Array

    def by_group(self, values: NDArray[Scalar]) -> NDArray[Scalar]:
        """Put an array of the states in rows, shape (groups, chains)."""
        return values.reshape(self.groups.size, -1)


def run_pilots(
    drive: Drive,
    groups: int,
    generator: np.random.Generator,
    *,
    chains: int = PILOT_CHAINS,
    negligible: float = 0.0,
    chance: float = 0.0,
) -> tuple[Levels, ...]:
    """Choose levels and spreads for each group by an adaptive run.

    `chains`: in each group. `negligible`: a group ends without a failure when what is left to it is less than this
    share of the most probable failure that a group has found, or is known. `chance`: probability of a failure that is
    known.
    """
    pilots = tuple(Levels([math.inf], [], []) for _ in range(groups))
    states, spread = _begun(groups, chains, generator), np.ones(groups)
    while states.groups.size:
        running = [pilots[group] for group in states.groups]
        visited, spread = _explored(drive, states, running, spread, generator, tuned=True)
        values = _together(visited, [visit.margins for visit in visited])
        thresholds = [_next_threshold(row, levels.thresholds[-1]) for row, levels in zip(values, running, strict=True)]
        for levels, row, used, threshold in zip(running, values, spread, thresholds, strict=True):
            levels.spreads.append(float(used))
            levels.shares.append(float(np.mean(row <= threshold)))
            levels.reached = threshold == 0.0
        least = negligible * max([chance, *(pilot.probability for pilot in pilots if pilot.reached)])
        going = [
            threshold > 0.0 and levels.count < MOST_LEVELS and math.prod(levels.shares) >= least
            for levels, threshold in zip(running, thresholds, strict=True)
        ]
        for levels, threshold, goes in zip(running, thresholds, going, strict=True):
            if goes:
                levels.thresholds.append(threshold)
        states, spread = _resampled(visited, np.array(thresholds), np.array(going), generator), spread[going]
    return pilots


def run_levels(drive: Drive, levels: Sequence[Levels], generator: np.random.Generator, *, chains: int = CHAINS) -> Run:
    """Run each group with the levels of its pilot."""
    probabilities, counted = np.ones(len(levels)), np.zeros(len(levels))
    states, ended = _begun(len(levels), chains, generator), []
    for level in range(max(pilot.count for pilot in levels)):
        running = [levels[group] for group in states.groups]
        spread = np.array([pilot.spreads[level] for pilot in running])
        visited, _ = _explored(drive, states, running, spread, generator, level=level)
        following = np.array([[*pilot.thresholds, 0.0][level + 1] for pilot in running])
        passed = _together(visited, [visit.margins for visit in visited]) <= following[:, None]
        counts = np.where(passed, _together(visited, [visit.counts for visit in visited]), 0.0)
        counted[states.groups] = probabilities[states.groups] * counts.mean(axis=1)
        probabilities[states.groups] *= passed.mean(axis=1)
        last = np.array([pilot.count == level + 1 for pilot in running])
        ended.append(_resampled(visited, following, last, generator))
        states = _resampled(visited, following, ~last, generator)
    order = np.concatenate([np.repeat(end.groups, chains) for end in ended])
    place = np.argsort(order, kind="stable")
    margins = np.concatenate([end.margins for end in ended])[place]
    counts = np.concatenate([end.counts for end in ended])[place]
    weights = np.repeat(probabilities, chains) * np.where(margins <= 0.0, counts, 0.0) / chains
    failing = gathered([end.population for end in ended], place, generator)
    return Run(probabilities, counted, failing, weights, sum(pilot.count for pilot in levels) * STEPS * chains)


def _begun(groups: int, chains: int, generator: np.random.Generator) -> _States:
    """Begin with trials that the moves on the first level, whose spread is one, draw anew."""
    trials = groups * chains
    population = NormalPopulation(trials, generator)
    return _States(np.arange(groups), population, np.full(trials, math.inf), np.zeros(trials))


def _explored(
    drive: Drive,
    states: _States,
    levels: Sequence[Levels],
    spread: Array,
    generator: np.random.Generator,
    *,
    level: int = -1,
    tuned: bool = False,
) -> tuple[list[_States], Array]:
    """Run the chains of a level; return the states they visit, and the spreads (tuned in a pilot)."""
    visited, chains = [], states.margins.size // states.groups.size
    threshold = np.array([pilot.thresholds[level] for pilot in levels])
    limit = np.repeat(threshold, chains)
    for step in range(STEPS):
        moved = MovedPopulation(states.population, np.repeat(spread, chains), generator)
        margins, counts = drive(moved, states.groups)
        accepted = margins <= limit
        states = _States(
            states.groups,
            states.population.where(accepted, moved),
            np.where(accepted, margins, states.margins),
            np.where(accepted, counts, states.counts),
        )
        visited.append(states)
        if tuned:
            share = states.by_group(accepted).mean(axis=1)
            tuned_spread = np.minimum(1.0, spread * np.exp((share - ACCEPTED) / math.sqrt(step + 1.0)))
            spread = np.where(np.isinf(threshold), 1.0, tuned_spread)
    return visited, spread


def _together(visited: Sequence[_States], values: Sequence[NDArray[Scalar]]) -> NDArray[Scalar]:
    """Put what the chains of each group met on their steps in a row, shape (groups, steps * chains)."""
    return np.concatenate([visited[0].by_group(array) for array in values], axis=1)


def _next_threshold(values: Array, last: float) -> float:
    """Margin that `SHARE` of the trials do not exceed, at least zero, and less than the last; -1 where none is less."""
    threshold = float(np.partition(values, int(SHARE * values.size) - 1)[int(SHARE * values.size) - 1])
    if threshold >= last and threshold > 0.0:
        threshold = float(np.max(values, where=values < last, initial=-1.0))
        return threshold if threshold > 0.0 else (0.0 if np.any(values <= 0.0) else -1.0)
    return max(threshold, 0.0)


def _resampled(
    visited: Sequence[_States], threshold: Array, chosen: NDArray[np.bool_], generator: np.random.Generator
) -> _States:
    """Choose as many states of each chosen group as it has chains, of those that passed, each as often as any other.

    Systematic, in random order. Where none passed, any: their group counts as zero from there.
    """
    groups = visited[0].groups
    trials = visited[0].margins.size
    places = _together(visited, [np.arange(trials) + step * trials for step in range(len(visited))])
    passed = _together(visited, [visit.margins for visit in visited]) <= threshold[:, None]
    taken = [places[row][_systematic(passed[row], trials // groups.size, generator)] for row in np.flatnonzero(chosen)]
    place = np.concatenate(taken) if taken else np.empty(0, dtype=np.intp)
    return _States(
        groups[chosen],
        gathered([visit.population for visit in visited], place, generator),
        np.concatenate([visit.margins for visit in visited])[place],
        np.concatenate([visit.counts for visit in visited])[place],
    )


def _systematic(passed: NDArray[np.bool_], count: int, generator: np.random.Generator) -> NDArray[np.intp]:
    candidates = np.flatnonzero(passed)
    candidates = generator.permutation(candidates if candidates.size else passed.size)
    places = (np.arange(count) + generator.random()) * (candidates.size / count)
    return np.asarray(candidates[places.astype(np.intp)], dtype=np.intp)
