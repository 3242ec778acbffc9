"""Subset simulation: a rare failure as a chain of failures that are not rare.

Au & Beck (2001), *Probabilistic Engineering Mechanics* 16, 263–277: P(g ≤ 0) = P(g ≤ b₁) P(g ≤ b₂ | g ≤ b₁) …, each
factor near `SHARE`, each conditional sample made by Markov chains that start in the last one. The chains move by
conditional sampling (Papaioannou, Betz, Zwirglmaier & Straub 2015, same journal 41, 89–103), which works in any number
of dimensions.

With thresholds chosen from the sample itself the product is biased by O(1/N). Here a pilot run chooses thresholds and
spreads, and independent repetitions then keep them: a fixed number of chains, of fixed length, starts from a systematic
resample of those that passed, so that the product is unbiased whatever the chains' correlation (Del Moral 2004,
*Feynman–Kac Formulae*, section 7.4.2), and the scatter of the repetitions gives its error.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.montecarlo.rare_events.population import MovedPopulation, NormalPopulation, gathered

Margin = Callable[[NormalPopulation], Array]
"""Margin of each trial, shape (n,): zero or negative where it fails, the smaller the nearer to failure."""

SHARE = 0.25
"""Of the trials of a level that pass to the next."""
STEPS = 4
"""States of a chain on each level: as many chains pass on average as there are."""
CHAINS = 256
"""In each repetition."""
PILOT_CHAINS = 512
ACCEPTED = 0.44
"""Share of accepted moves to which the pilot tunes the spread (Papaioannou et al., section 5)."""
MOST_LEVELS = 24
"""After which a failure counts as not found: at a probability of about 4⁻²⁴ = 4e-15."""


@dataclass(frozen=True)
class Level:
    """Trials whose margin is at most `threshold`, explored by moves of `spread`; the first level is all trials."""

    threshold: float
    spread: float


@dataclass(frozen=True)
class Pilot:
    """Result of the pilot run.

    Attributes
    ----------
    levels : tuple of Level
        From all trials to the last before failure.
    reached : bool
        Whether failures were found; if not, the margin led nowhere.
    shares : tuple of float
        Of the trials of each level that passed to the next; of the last level, those that failed.
    trials : int
        That were run.
    """

    levels: tuple[Level, ...]
    reached: bool
    shares: tuple[float, ...]
    trials: int

    @property
    def probability(self) -> float:
        """Of the event, roughly; where no failure was found, of coming as near to it as the last level."""
        return math.prod(self.shares if self.reached else self.shares[:-1])


@dataclass(frozen=True)
class Repetitions:
    """Independent repetitions with fixed levels.

    Attributes
    ----------
    estimates : array, shape (repetitions,)
        Unbiased estimate of each.
    failing : NormalPopulation
        A sample of the trials that fail, `CHAINS` of each repetition; each weighs as its repetition's estimate.
    margins : array, shape (repetitions * chains,)
        Of that sample; positive in a repetition that found no failure.
    trials : int
        That were run.
    """

    estimates: Array
    failing: NormalPopulation
    margins: Array
    trials: int

    @property
    def weights(self) -> Array:
        """Weight of each failing trial."""
        chains = self.failing.trials // len(self.estimates)
        return np.where(self.margins <= 0.0, np.repeat(self.estimates, chains), 0.0)


def run_pilot(margin: Margin, generator: np.random.Generator, chains: int = PILOT_CHAINS) -> Pilot:
    """Choose levels and spreads by one adaptive run.

    Parameters
    ----------
    margin : Margin
    generator : Generator
    chains : int
    """
    population, values = NormalPopulation(chains, generator), np.empty(0)
    levels, shares, spread = [Level(math.inf, 1.0)], [], 1.0
    reached = False
    for number in range(MOST_LEVELS):
        states, margins, spread = _explored(margin, population, values, levels[-1], generator, tuned=True)
        levels[-1] = Level(levels[-1].threshold, spread)
        values = np.concatenate(margins)
        threshold = _next_threshold(values, levels[-1].threshold)
        shares.append(float(np.mean(values <= threshold)))
        reached = threshold == 0.0
        if reached or not shares[-1] or number + 1 == MOST_LEVELS:
            break
        chosen = _resampled(values <= threshold, chains, generator)
        population, values = gathered(states, chosen, generator), values[chosen]
        levels.append(Level(threshold, spread))
    return Pilot(tuple(levels), reached, tuple(shares), len(shares) * STEPS * chains)


def repeat(
    margin: Margin, levels: tuple[Level, ...], generator: np.random.Generator, *, repetitions: int, chains: int = CHAINS
) -> Repetitions:
    """Run independent repetitions with the levels of a pilot, all at once.

    Parameters
    ----------
    margin : Margin
    levels : tuple of Level
    generator : Generator
    repetitions, chains : int
        Chains in each repetition.
    """
    population, values = NormalPopulation(repetitions * chains, generator), np.empty(0)
    estimates = np.ones(repetitions)
    thresholds = [*(level.threshold for level in levels[1:]), 0.0]
    for level, threshold in zip(levels, thresholds, strict=True):
        states, margins, _ = _explored(margin, population, values, level, generator, tuned=False)
        values = np.concatenate(margins)
        passed = np.stack(margins).reshape(STEPS, repetitions, chains) <= threshold
        estimates *= passed.mean(axis=(0, 2))
        places = np.arange(values.size).reshape(passed.shape)
        chosen = np.concatenate(
            [
                places[:, each].ravel()[_resampled(passed[:, each].ravel(), chains, generator)]
                for each in range(repetitions)
            ]
        )
        population, values = gathered(states, chosen, generator), values[chosen]
    return Repetitions(estimates, population, values, len(levels) * STEPS * repetitions * chains)


def _explored(
    margin: Margin,
    population: NormalPopulation,
    values: Array,
    level: Level,
    generator: np.random.Generator,
    *,
    tuned: bool,
) -> tuple[list[NormalPopulation], list[Array], float]:
    """Run the chains of a level; return their states, the states' margins, and the spread (tuned in the pilot)."""
    states, margins, spread = [], [], level.spread
    for step in range(STEPS):
        if math.isinf(level.threshold):
            population = NormalPopulation(population.trials, generator)
            values = margin(population)
        else:
            moved = MovedPopulation(population, spread, generator)
            found = margin(moved)
            accepted = found <= level.threshold
            population, values = population.where(accepted, moved), np.where(accepted, found, values)
            if tuned:
                spread = min(1.0, spread * math.exp((float(np.mean(accepted)) - ACCEPTED) / math.sqrt(step + 1.0)))
        states.append(population)
        margins.append(values)
    return states, margins, spread


def _next_threshold(values: Array, last: float) -> float:
    """Margin that `SHARE` of the trials do not exceed, at least zero, and less than the last; -1 where none is less."""
    threshold = float(np.partition(values, int(SHARE * values.size) - 1)[int(SHARE * values.size) - 1])
    if threshold >= last:
        threshold = float(np.max(values, where=values < last, initial=-1.0))
        return threshold if threshold > 0.0 else (0.0 if np.any(values <= 0.0) else -1.0)
    return max(threshold, 0.0)


def _resampled(passed: NDArray[np.bool_], count: int, generator: np.random.Generator) -> NDArray[np.intp]:
    """Choose `count` of the trials that passed, each as often as any other on average (systematic, in random order).

    Where none passed, any: their repetition counts as zero from there.
    """
    candidates = np.flatnonzero(passed)
    candidates = generator.permutation(candidates if candidates.size else passed.size)
    places = (np.arange(count) + generator.random()) * (candidates.size / count)
    return np.asarray(candidates[places.astype(np.intp)], dtype=np.intp)
