"""Discrete causes of small probability, each tried for itself: their probabilities are known, none need be found.

A chain moves from one value of a discrete quantity to another only by a jump in its normal. A value of probability
10⁻⁵ that makes a mission fail is met by no pilot, however probable the failure is under it. So the trials are divided:
into those in which a quantity takes such a value, and those in which none does. Quantity by quantity, in an order that
is fixed, stratum j holds the trials in which quantity j takes the value and none before it takes a rare one; the later
ones are free. The strata exclude each other, and together are all trials.

A probability that is a sum of unbiased estimates, each from independent runs in two stages.

Ways to fail, each driven for itself, and their probabilities combined with what they share.

A failure comes about in several ways i, each with a margin mᵢ that is negative where it does. One scalar over all of
them, such as the least of the margins over their standard deviations, is no measure of nearness: where a margin is
skewed or bounded, a pilot on it follows one way and never meets another that is more probable. So subset simulation is
run on each margin by itself, whose order among trials is all that it uses, so that neither unit nor distribution of a
margin matters. With K(u) the number of ways in which trial u fails,

    P(F) = Σᵢ E[1{mᵢ ≤ 0} / K],

so that what several ways share counts once. What fails with no margin negative, K = 0, is a further way: it is led by
all margins together, each as a reliability index −Φ⁻¹ of its rank among plain trials.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import scipy
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.montecarlo.rare_events import Groups, Key, NormalPopulation

RARE = 1.0 / 16.0
"""Probability of a value below which it gets a stratum: of a pilot's chains sixteen and more start at any other."""
MOST_STRATA = 32
"""Beside the one of what is usual. Where there are more rare values, the least probable get them."""

Interval = tuple[float, float]
"""Of probabilities of a standard normal, Φ(z)."""


@dataclass(frozen=True)
class DiscreteValue:
    """A value of a discrete quantity."""

    quantity: str
    value: str
    """As a reader knows it."""
    interval: Interval
    """Where the quantity's normal gives this value."""

    @property
    def probability(self) -> float:
        """Probability of the value."""
        return self.interval[1] - self.interval[0]


@dataclass(frozen=True)
class Stratum:
    """A part of all trials."""

    probability: float = 1.0
    """Of a trial to be in it."""
    value: DiscreteValue | None = None
    """The rare value that its trials have; None where none has one."""
    allowed: Mapping[Key, Sequence[Interval]] = field(default_factory=dict)
    """Where the normals of its discrete quantities lie."""


@dataclass(frozen=True)
class StrataView:
    """Trials of strata: a population whose normals of discrete quantities are brought to where they may lie."""

    population: NormalPopulation
    strata: Sequence[Stratum] = (Stratum(),)
    """As many trials of each, side by side."""

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

    All values of each quantity are given, by the key of the normal from which it is drawn.
    """
    rare = sorted(value.probability for domain in values.values() for value in domain if 0.0 < value.probability < RARE)
    least = rare[MOST_STRATA] if len(rare) > MOST_STRATA else RARE
    parts: list[Stratum] = []
    usual: dict[Key, Sequence[Interval]] = {}
    left = 1.0
    for key, domain in values.items():
        rare_values = [value for value in domain if 0.0 < value.probability < least]
        parts += [Stratum(left * value.probability, value, {**usual, key: (value.interval,)}) for value in rare_values]
        if rare_values:
            usual[key] = [value.interval for value in domain if value not in rare_values]
            left *= 1.0 - math.fsum(value.probability for value in rare_values)
    return Stratum(left, None, usual), *parts


def _brought_into(normals: Array, intervals: Sequence[Interval]) -> Array:
    """Map standard normals to normals within intervals of probability, through their probabilities."""
    starts, ends = np.array(intervals).T
    covered = np.concatenate([[0.0], np.cumsum(ends - starts)])
    share = scipy.special.ndtr(normals) * covered[-1]
    number = np.minimum(np.searchsorted(covered, share, side="right") - 1, len(starts) - 1)
    inside = np.minimum(starts[number] + (share - covered[number]), np.nextafter(ends[number], 0.0))
    return np.asarray(scipy.special.ndtri(np.maximum(inside, np.nextafter(starts[number], 1.0))))


FIRST_WEIGHT = 1.0 / 3.0
"""Of the first stage. Fixed beforehand: how many runs the second stage has depends on what the first found, and a mean
over all runs would be low, as stages that find little also scatter little, and end early."""


@dataclass(frozen=True)
class TwoStages:
    """Runs of one part of the sum."""

    first: Array
    second: Array
    """Shape (runs,). Unbiased estimates; at least two in all, the second stage may be empty."""

    @property
    def value(self) -> float:
        """Weighted mean of the stages."""
        if not self.second.size:
            return float(np.mean(self.first))
        return float(FIRST_WEIGHT * np.mean(self.first) + (1.0 - FIRST_WEIGHT) * np.mean(self.second))

    @property
    def freedom(self) -> int:
        """Degrees of freedom of the scatter of the runs."""
        return self.first.size + self.second.size - 1

    @property
    def scatter(self) -> float:
        """Standard deviation of one run."""
        return float(np.std(np.concatenate([self.first, self.second]), ddof=1))

    @property
    def variance(self) -> float:
        """Variance of the value."""
        if not self.second.size:
            return self.scatter**2 / self.first.size
        return self.scatter**2 * (FIRST_WEIGHT**2 / self.first.size + (1.0 - FIRST_WEIGHT) ** 2 / self.second.size)


@dataclass(frozen=True)
class Estimate:
    """A probability."""

    value: float
    variation: float
    """Coefficient of variation of `value`, from the scatter of the runs; infinite where none found a failure."""
    low: float
    high: float
    """95 % interval: Student's t on the logarithm of the value, as a product of many random factors is skewed, with the
    degrees of freedom of a sum of variances (Satterthwaite 1946, *Biometrics Bulletin* 2, 110–114)."""

    @classmethod
    def of(cls, parts: Sequence[TwoStages], left: float = 0.0) -> "Estimate":
        """Add up the parts, which are independent of each other, and what is left out of them as negligible."""
        value, variances = left + sum(part.value for part in parts), np.array([part.variance for part in parts])
        if value <= left:
            return cls(0.0, math.inf, 0.0, 1.0)
        variation = math.sqrt(float(variances.sum())) / value
        if variation == 0.0:
            return cls(value, 0.0, value, value)
        freedoms = np.array([part.freedom for part in parts])
        freedom = float(variances.sum() ** 2 / np.sum(variances**2 / freedoms))
        factor = math.exp(min(float(scipy.special.stdtrit(freedom, 0.975)) * variation, 700.0))
        return cls(value, variation, value / factor, min(1.0, value * factor))


def runs_needed(
    first: Sequence[Array], costs: Sequence[int], *, variation: float, most_cost: float, least: int
) -> tuple[list[int], bool]:
    """Share the second stage's runs among the parts so that the sum is known as well as asked for the least cost.

    Neyman's allocation: runs in proportion to the scatter of a part over the root of what a run of it costs.

    Parameters
    ----------
    first : sequence of array
        Estimates of the first stage, by part.
    costs : sequence of int
        Of one run of each part.
    variation : float
        Coefficient of variation of the sum that is asked for.
    most_cost : float
        Of the whole second stage; fewer runs are made where the accuracy asked for would cost more.
    least : int
        Runs of each part, whatever they cost.

    Returns
    -------
    runs, cut : list of int, bool
        Of each part; and whether they are fewer than the accuracy takes.
    """
    if not first:
        return [], False
    scatters = np.array([np.std(estimates, ddof=1) for estimates in first])
    value = float(sum(np.mean(estimates) for estimates in first))
    variance = float(sum(scatter**2 / estimates.size for scatter, estimates in zip(scatters, first, strict=True)))
    roots = np.sqrt(np.array(costs, dtype=float))
    wanted = (variation * value) ** 2 - FIRST_WEIGHT**2 * variance
    wanted = max(wanted, 0.05 * (variation * value) ** 2)  # the first stage alone may scatter more than is asked for
    runs = np.zeros(len(first))
    if value > 0.0 and variance > 0.0:
        runs = (1.0 - FIRST_WEIGHT) ** 2 * float(np.sum(scatters * roots)) * scatters / roots / wanted
    runs = np.maximum(np.ceil(runs), least)
    spare = max(most_cost - least * float(np.sum(costs)), 0.0)
    more = float(np.sum((runs - least) * costs))
    if more > spare:
        runs = least + np.floor((runs - least) * spare / more)
    return [int(count) for count in runs], more > spare


_LEAST = float(np.finfo(float).tiny)
"""Margin of a trial that does not fail in a way whose margin is not positive."""


@dataclass(frozen=True)
class TrialMargins:
    """How near trials came to each way to fail."""

    by_way: Array
    """Negative or zero where the trial fails so, the smaller the nearer; nan where it never came so far; shape (ways,
    n)."""
    failed: NDArray[np.bool_]
    """Whether it fails at all, shape (n,)."""

    @property
    def fails_by(self) -> NDArray[np.bool_]:
        """Whether each trial fails in each way, shape (ways, n)."""
        return np.asarray(self.failed & (self.by_way <= 0.0))


Model = Callable[[StrataView], TrialMargins]
"""Runs one trial for each of a population."""


@dataclass(frozen=True)
class ReliabilityIndices:
    """Margins as standard deviations of a normal, by their ranks among plain trials."""

    margins: Sequence[Array]
    scores: Sequence[Array]
    """Of each way: margins of plain trials in ascending order, without ties, and the normal scores of their ranks;
    empty where fewer than two differ."""

    @classmethod
    def of(cls, plain: TrialMargins) -> "ReliabilityIndices":
        """Rank the margins of plain trials; those that are not finite do not count."""
        tallies = [np.unique(row[np.isfinite(row)], return_counts=True) for row in plain.by_way]
        ranked = [(values, (np.cumsum(counts) - 0.5 * counts) / counts.sum()) for values, counts in tallies]
        useful = [(values, shares) if values.size > 1 else (values[:0], shares[:0]) for values, shares in ranked]
        return cls(
            tuple(values for values, _ in useful),
            tuple(np.asarray(scipy.special.ndtri(shares)) for _, shares in useful),
        )

    def nearest(self, by_way: Array) -> Array:
        """Return the least distance of margins, shape (ways, n), from zero, shape (n,); infinite without any."""
        least = np.full(by_way.shape[1], np.inf)
        for row, margins, scores in zip(by_way, self.margins, self.scores, strict=True):
            if margins.size:
                least = np.fmin(least, _score(row, margins, scores) - _score(np.zeros(1), margins, scores))
        return least


def _score(values: Array, margins: Array, scores: Array) -> Array:
    """Normal score of margins; below the least of plain trials on the line through it and the lower decile."""
    tenth = min(max(1, margins.size // 10), margins.size - 1)
    slope = (scores[tenth] - scores[0]) / (margins[tenth] - margins[0])
    inside = np.interp(values, margins, scores)
    scored = np.where(values < margins[0], scores[0] + slope * (values - margins[0]), inside)
    return np.where(np.isnan(values), np.nan, scored)


@dataclass(frozen=True, eq=False)
class WayDrive:
    """Drives groups of trials, each in a stratum and towards one way to fail."""

    model: Model
    strata: Sequence[Stratum]
    """Of each group."""
    ways: Sequence[int]
    """Number of each group's margin; as many as there are for what fails with no margin negative."""
    indices: ReliabilityIndices

    def __call__(self, population: NormalPopulation, groups: Groups) -> tuple[Array, Array]:
        """Return the margin of each trial, and what it counts: one over the ways in which it fails."""
        trials = self.model(StrataView(population, [self.strata[group] for group in groups]))
        fails_by, chains = trials.fails_by, population.trials // groups.size
        count = fails_by.sum(axis=0)
        margins, fails = np.empty(population.trials), np.empty(population.trials, dtype=bool)
        for place, group in enumerate(groups):
            block, way = slice(place * chains, (place + 1) * chains), self.ways[group]
            if way == len(trials.by_way):
                fails[block] = trials.failed[block] & (count[block] == 0)
                margins[block] = self.indices.nearest(trials.by_way[:, block])
            else:
                fails[block], margins[block] = fails_by[way, block], trials.by_way[way, block]
        margins = np.where(np.isnan(margins), np.inf, np.maximum(margins, _LEAST))
        return np.where(fails, 0.0, margins), np.where(fails, 1.0 / np.maximum(count, 1), 0.0)
