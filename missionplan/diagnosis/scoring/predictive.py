"""What a mission expects of a data set before it is seen, and predictive distributions of each value by it.

Draws of the means with covariances of the rest make mixtures of normal distributions. *One step ahead* a group (a leg,
a dive) is predicted from all groups before it: each component of the mixture by the conditional normal distribution,
which the Cholesky factor of its covariance holds (Durbin & Koopman 2012, section 4.13), the components weighted by how
well they have predicted the past. *The whole* record is predicted from nothing: every draw of the mission is a
component.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise, product

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular
from scipy.special import logsumexp, ndtr, ndtri

from missionplan.arrays import Array
from missionplan.mission import Mission
from missionplan.mission.schema.effect_list import EffectList


def explained(mission: Mission) -> list[tuple[float, Mission]]:
    """Return the mission under each combination of its explanations, with the probability that it holds."""
    doubts = [doubt for doubt in mission.doubts if doubt.known is None]
    missions = []
    for numbers in product(*(range(len(doubt.probabilities)) for doubt in doubts)):
        share, plain_mission = 1.0, mission
        for doubt, number in zip(doubts, numbers, strict=True):
            share, plain_mission = share * doubt.probabilities[number], plain_mission.knowing(doubt.place, number)
        if share > 0.0:
            missions.append((share, plain_mission))
    return missions


def bare_mission(mission: Mission) -> Mission:
    """Return the mission without its effects."""
    kept = tuple(pair for pair in mission.correlations if not any(path.startswith("effects") for path in pair.between))
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
    rest_noise = _rows(noise, rest)
    left = replace(rest_noise, weight=1.0, covariance=rest_noise.covariance - shared.T @ gain)
    draws = part.draws[:, rest] + (first - part.draws[:, seen]) @ gain
    return Part(part.probability * noise.weight, draws, (left,))


WHOLE_COMPONENTS = 1024
"""Components, at most, of the distribution without the past."""
BISECTIONS = 50
LEAST_WEIGHT = 1e-300
"""Weight that stands for none in logarithms."""
EXACT_PAIRS = 100
"""Components up to which the pairs of the CRPS are summed in closed form."""


@dataclass(frozen=True)
class Mixture:
    """A mixture of c normal distributions for each of v values."""

    weights: Array
    means: Array
    sds: Array
    """The weights of each value add up to 1, shape (c, v)."""

    def of(self, rows: slice) -> "Mixture":
        """Return the distributions of some of the values."""
        return Mixture(self.weights[:, rows], self.means[:, rows], self.sds[:, rows])

    @cached_property
    def mean(self) -> Array:
        """Means, shape (v,)."""
        return np.asarray((self.weights * self.means).sum(axis=0))

    @cached_property
    def sd(self) -> Array:
        """Standard deviations, shape (v,)."""
        second = (self.weights * (self.sds**2 + (self.means - self.mean) ** 2)).sum(axis=0)
        return np.asarray(np.sqrt(second))

    def cdf(self, y: Array) -> Array:
        """Probability of less than y, shape (v,)."""
        return np.asarray((self.weights * ndtr((y - self.means) / self.sds)).sum(axis=0))

    def log_density(self, y: Array) -> Array:
        """Ln density at y, shape (v,)."""
        z = (y - self.means) / self.sds
        logs = np.log(np.maximum(self.weights, LEAST_WEIGHT)) - 0.5 * z**2 - np.log(self.sds)
        return np.asarray(logsumexp(logs, axis=0) - 0.5 * np.log(2.0 * np.pi))

    def quantile(self, probability: float) -> Array:
        """Quantile of each value, by bisection, shape (v,)."""
        ends = self.means + ndtri(probability) * self.sds
        low, high = ends.min(axis=0), ends.max(axis=0)
        if len(ends) == 1:
            return np.asarray(low)
        for _ in range(BISECTIONS):
            middle = 0.5 * (low + high)
            below = self.cdf(middle) < probability
            low, high = np.where(below, middle, low), np.where(below, high, middle)
        return np.asarray(0.5 * (low + high))

    def crps(self, y: Array) -> Array:
        """Continuous ranked probability score, E|X − y| − ½E|X − X′|, shape (v,) [unit of the values].

        In closed form for few components (Grimit et al. 2006, *Q. J. R. Meteorol. Soc.* 132, Eq. 5), which is that of
        Gneiting et al. 2005 for one; for many the second part is that of a sample of one draw a component.
        """
        first = (self.weights * _mean_absolute(y - self.means, self.sds)).sum(axis=0)
        if len(self.weights) <= EXACT_PAIRS:
            pairs = sum(
                (
                    weight * (self.weights * _mean_absolute(mean - self.means, np.hypot(sd, self.sds))).sum(axis=0)
                    for weight, mean, sd in zip(self.weights, self.means, self.sds, strict=True)
                ),
                np.zeros_like(first),
            )
            return np.asarray(first - 0.5 * pairs)
        count = len(self.weights)
        order = np.random.default_rng(0).permutation(count)
        x = self.means + ndtri((order[:, None] + 0.5) / count) * self.sds
        places = np.argsort(x, axis=0)
        x, w = np.take_along_axis(x, places, axis=0), np.take_along_axis(self.weights, places, axis=0)
        before, sums = np.cumsum(w, axis=0) - w, np.cumsum(w * x, axis=0) - w * x
        unequal = np.maximum(1.0 - (w**2).sum(axis=0), 1e-12)
        return np.asarray(first - 0.5 * (2.0 * (w * (x * before - sums)).sum(axis=0) / unequal))


def _mean_absolute(shift: Array, sd: Array) -> Array:
    """E|X| of a normal X of a mean and standard deviation."""
    z = shift / sd
    density = np.exp(-0.5 * z**2) / np.sqrt(2.0 * np.pi)
    return np.asarray(shift * (2.0 * ndtr(z) - 1.0) + 2.0 * sd * density)


@dataclass(frozen=True)
class OneStep:
    """Predictions of each group from those before it."""

    mixture: Mixture
    roots: list[list[Array]]
    """For each component of the mixture and each group, the triangular root of the covariance of the group's values."""
    effective: float
    """Effective number of components at the end of the record, 1/Σw²."""


def one_step_ahead(ensemble: Ensemble) -> OneStep:
    """Predict every group of a record from the groups before it."""
    groups, y = ensemble.slices(), ensemble.values
    means, log_weights, scaled, roots = [], [], [], []
    # normal distributions: the draws by their mean and covariance, each noise by itself
    for part, noise in [(explanation, noise) for explanation in ensemble.parts for noise in explanation.noises]:
        mean = part.draws.mean(axis=0)
        apart = part.draws - mean
        spread = apart.T @ apart / max(len(apart) - 1, 1)
        factor = np.linalg.cholesky(_definite(spread + noise.covariance))
        z = solve_triangular(factor, y - mean, lower=True, check_finite=False)
        blocks = [np.asarray(factor[rows, rows], dtype=float) for rows in groups]
        innovation = np.concatenate([root @ z[rows] for root, rows in zip(blocks, groups, strict=True)])
        logs = np.array(
            [-0.5 * z[rows] @ z[rows] - np.log(np.diag(root)).sum() for root, rows in zip(blocks, groups, strict=True)]
        )
        past = np.append(0.0, np.cumsum(logs)[:-1])
        variance = np.concatenate([np.sum(root**2, axis=1) for root in blocks])
        means.append(y - innovation)
        log_weights.append(float(np.log(part.probability * noise.weight)) + past)
        change = (noise.scales[:, None] ** 2 - 1.0) * np.minimum(noise.tailed, variance)
        scaled.append(np.sqrt(np.maximum(variance + change, 1e-12 * variance)))
        roots.append(blocks)
    logs = np.array(log_weights)
    weights = np.exp(logs - logsumexp(logs, axis=0))
    sizes = np.array([len(sds) for sds in scaled])  # each component at so many equally likely scales of its tails
    shares = np.repeat(weights[:, ensemble.groups] / sizes[:, None], sizes, axis=0)
    mixture = Mixture(shares, np.repeat(np.array(means), sizes, axis=0), np.concatenate(scaled))
    component_roots = [blocks for blocks, size in zip(roots, sizes, strict=True) for _ in range(size)]
    return OneStep(mixture, component_roots, float(1.0 / np.sum(weights[:, -1] ** 2)))


def without_past(ensemble: Ensemble) -> Mixture:
    """Predict every value of a record before any of it is seen."""
    weights, means, sds = [], [], []
    for part in ensemble.parts:
        for share, mean, noise in paired(part, max(1, int(WHOLE_COMPONENTS * part.probability))):
            variance = np.diag(noise.covariance)
            change = (noise.scales[:, None] ** 2 - 1.0) * np.minimum(noise.tailed, variance)
            spreads = np.sqrt(np.maximum(variance + change, 1e-12 * variance + 1e-18))
            weights += [part.probability * share / len(spreads)] * len(spreads)
            means += [mean] * len(spreads)
            sds += list(spreads)
    wide = np.repeat(np.array(weights)[:, None], len(ensemble.values), axis=1)
    return Mixture(wide / wide.sum(axis=0), np.array(means), np.array(sds))


def paired(part: Part, most: int) -> list[tuple[float, Array, Noise]]:
    """Pair the draws of a part with its noises, in proportion to their weights: share, expected values and noise."""
    count = min(max(len(part.draws), 1), most)
    if len(part.draws) == 1:
        return [(noise.weight, part.draws[0], noise) for noise in part.noises]
    edges = np.cumsum([noise.weight for noise in part.noises])
    chosen = np.searchsorted(edges / edges[-1], (np.arange(count) + 0.5) / count)
    mixed = np.random.default_rng(1).permutation(chosen)
    return [
        (1.0 / count, mean, part.noises[index]) for mean, index in zip(part.draws[:count], mixed.tolist(), strict=True)
    ]
