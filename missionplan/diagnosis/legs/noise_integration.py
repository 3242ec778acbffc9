"""The noise of a navigation log under some random effects: where it is likely, and the sets integrated over it.

The noise is integrated over by importance sampling (Owen 2013, *Monte Carlo Theory, Methods and Examples*, chapter 9)
from a mixture of Student-t laws about the likeliest noise without a cause and with the likeliest ones.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammaincinv, logsumexp, ndtri

from missionplan.arrays import Array
from missionplan.diagnosis.inference.evidence_approximations import Laplace, even_points, laplace, log_student_density
from missionplan.diagnosis.inference.marginal_likelihood import SCALE_PRIOR, SCALES, GramMatrix
from missionplan.diagnosis.legs.likelihood.hyperparameters import Hyperparameter, HyperparameterPrior
from missionplan.diagnosis.legs.set_density import LegInference, MeanSet, Noise, RandomErrors, grouped
from missionplan.results.learned.evidence import Causes

EFFECTIVE = 12.0
"""Effective points below which the noise is drawn anew about what the points show of it."""
DRAWN, MOST_DRAWN = 32, 256
"""Points of the noise about each anchor, at first, and where too few of them count."""
TAILS, WIDENED = 5, 1.25
"""Degrees of freedom of the law from which they are drawn, and factor on its standard deviations."""
WIDEST = 1.5
"""Largest standard deviation of that law along any direction [logarithms]."""
BETWEEN = (0.0, 0.5, 1.0)
"""Places between the noise without causes and with all of them where sets are compared first."""
QUIETER = (-0.35, -0.7)
"""What is added to ln σ_v of the last of these: a term may explain what else is left to the noise."""
BESIDE = 5.0
"""Nats below the best within which the likeliest noise of the best set with a term, or without one, is found too."""


@dataclass(frozen=True)
class Law:
    """Random effects with sets in the mean, integrated over the noise."""

    effects: Causes
    hyperparameters: tuple[Hyperparameter, ...]
    at: Array
    """Logarithms of the noise at its points, shape (j, h)."""
    sets: tuple[MeanSet, ...]
    """Without a term."""
    terms: tuple[int, ...]
    """Numbers of those that stand beside them."""
    log_weights: Array
    """Shape (s, j, c, 1 + t). Of each set at each noise and scale of the slabs, without a term and with each, prior
    included; their sum is the evidence times the prior."""
    grams: Mapping[Causes, Sequence[GramMatrix]]
    """By group, the inner products at each noise."""

    @property
    def effective(self) -> float:
        """Effective number of noises (Owen 2013, section 9.3)."""
        shares = self._shares
        return 1.0 / float(np.sum(shares**2))

    @property
    def _shares(self) -> Array:
        logs = logsumexp(self.log_weights, axis=(0, 2, 3))
        return np.asarray(np.exp(logs - logsumexp(logs)))

    def masses(self) -> dict[tuple[MeanSet, int], float]:
        """Log evidence times prior of each set that was integrated, without a term (0) and with the number of each."""
        masses: dict[tuple[MeanSet, int], float] = {}
        for one, logs in zip(self.sets, logsumexp(self.log_weights, axis=(1, 2)), strict=True):
            masses |= {(one, term): float(mass) for term, mass in zip((0, *self.terms), logs, strict=True)}
        return {key: mass for key, mass in masses.items() if mass > -np.inf}

    def noise(self) -> Laplace:
        """Mean and covariance of the noise's posterior as drawn."""
        return self.noise_of(self._shares)

    def noise_of(self, shares: Array) -> Laplace:
        """Mean and covariance of the noise with shares of its points, shape (j,)."""
        mean = shares @ self.at
        apart = self.at - mean
        spread = (shares[:, None] * apart).T @ apart + np.diag(np.full(len(mean), 1e-4))
        return Laplace(math.nan, mean, spread)


class NoiseSearch:
    """The noise of some random effects: where it is likely, and which sets are likely with it."""

    def __init__(self, inference: LegInference, effects: Causes, reference: MeanSet) -> None:
        model = inference.model
        self.inference, self.effects = inference, effects
        self.hyperparameters = model.hyperparameters(effects, model.given_forms)
        self.errors = RandomErrors(effects, self.hyperparameters, reference)
        self.prior = HyperparameterPrior.of(self.hyperparameters, model.given_in_covariance)

    def likeliest(self, one: MeanSet, start: Noise | None = None, *, integrate: bool = False) -> Laplace:
        """Find the likeliest noise with a set, and with its spread if that is wanted."""
        start = start or {}

        def log_posterior(logs: Array) -> float:
            return self.prior.log_density(logs) + self.inference.log_density(self.errors, logs, one)

        centre = np.array([start.get(h.key, h.centre) for h in self.hyperparameters])
        starts = [centre]
        for index, h in enumerate(self.hyperparameters):
            if h.law in ("student", "reciprocal") and h.key not in start:
                starts += [centre + sign * h.spread * np.eye(len(centre))[index] for sign in (-1.0, 1.0)]
        spread = np.diag([min(0.1, h.spread**2) for h in self.hyperparameters])
        return laplace(log_posterior, starts, spread, integrate=integrate, keep_inside=True)

    def at(self, posterior: Laplace) -> Noise:
        """The noise at a mode, by name."""
        return {h.key: float(value) for h, value in zip(self.hyperparameters, posterior.mode, strict=True)}

    def levels(self, plain: Laplace, rich: Laplace) -> list[Array]:
        """Noises at which sets are compared: between two likeliest ones, and of σ_v alone quieter ones.

        Random effects are compared after that, from the noise of the likeliest set with its term.
        """
        sigma = np.array([h.key == ("", "sigma_v") for h in self.hyperparameters])
        between = [plain.mode + share * (rich.mode - plain.mode) for share in BETWEEN]
        return between + [rich.mode + less * sigma for less in QUIETER if not self.effects]

    def scores(self, levels: Sequence[Array]) -> Array:
        """Log density and prior of all sets at some noises, without a term and with each, shape (j, s, 1 + t)."""
        inference = self.inference
        terms = range(1, len(inference.terms) + 1)
        inference.joint(tuple(grouped(inference.sets, inference.group)), tuple(terms))

        def at(logs: Array) -> Array:
            return self.prior.log_density(logs) + inference.log_densities(self.errors, logs, inference.sets, terms)

        return np.stack(inference.at_once(at, levels)) + inference.log_priors(self.effects)

    def compared(self, plain: Laplace, rich: Laplace) -> "ComparedSets":
        """Compare all sets without a term and with each, each at its likeliest of a few noises."""
        return ComparedSets(self, plain, rich, self.scores(self.levels(plain, rich)).max(axis=0))

    def integrated(self, anchors: Sequence[Laplace], chosen: NDArray[np.bool_], count: int) -> Law:
        """Integrate sets over the noise, with a number of points about each anchor.

        `chosen`, shape (s, 1 + t): which sets, without a term and with which.
        """
        inference = self.inference
        at, log_proposal = _drawn(anchors, count)
        rows = np.flatnonzero(chosen.any(axis=1))
        sets = tuple(inference.sets[row] for row in rows)
        terms = tuple((np.flatnonzero(chosen[:, 1:].any(axis=0)) + 1).tolist())
        kept, grams = self._inner_products(at, sets, terms)
        base = np.array([self.prior.log_density(at[i]) - log_proposal[i] - math.log(len(at)) for i in kept])
        priors = inference.log_priors(self.effects)
        wanted = np.where(chosen, priors, -np.inf)[rows][:, [0, *terms]]
        logs = self._log_weights(sets, terms, grams, base) + wanted[:, None, None, :]
        return Law(self.effects, self.hyperparameters, at[kept], sets, terms, logs, grams)

    def _inner_products(
        self, at: Array, sets: Sequence[MeanSet], terms: Sequence[int]
    ) -> tuple[list[int], dict[Causes, list[GramMatrix]]]:
        """Return which noises are possible, and the inner products of each group of sets at these."""
        inference, groups = self.inference, tuple(grouped(sets, self.inference.group))

        def of(logs: Array) -> dict[Causes, GramMatrix] | None:
            try:
                return inference.grams(self.errors, logs, groups, terms)
            except np.linalg.LinAlgError:
                return None

        possible = [index for index, logs in enumerate(at) if math.isfinite(self.prior.log_density(logs))]
        inference.joint(groups, tuple(terms))
        grams = inference.at_once(of, at[possible])
        kept = [index for index, by_group in zip(possible, grams, strict=True) if by_group is not None]
        return kept, {group: [by_group[group] for by_group in grams if by_group is not None] for group in groups}

    def _log_weights(
        self,
        sets: Sequence[MeanSet],
        terms: Sequence[int],
        grams: Mapping[Causes, Sequence[GramMatrix]],
        base: Array,
    ) -> Array:
        """Log density of the data of each set at each noise and scale of the slabs, shape (s, j, c, 1 + t)."""
        inference = self.inference
        logs = np.empty((len(sets), len(base), len(SCALES), 1 + len(terms)))
        for group, members in grouped(sets, inference.group).items():
            densities = inference.with_terms(grams[group], [sets[i] for i in members], terms, range(len(SCALES)))
            logs[members] = densities.swapaxes(0, 1) + base[:, None, None] + np.log(SCALE_PRIOR)[:, None]
        return logs


@dataclass(frozen=True)
class ComparedSets:
    """Sets compared under some random effects."""

    search: NoiseSearch
    plain: Laplace
    rich: Laplace
    """The likeliest noise without causes in the mean, and with many."""
    scores: Array
    """Log density and prior of all sets at their likeliest noises, without a term and with each, shape (s, 1 + t)."""

    @property
    def best(self) -> float:
        """Greatest score."""
        return float(self.scores.max())

    @property
    def top(self) -> MeanSet:
        """The likeliest set."""
        return self._best_of(self.scores)[0]

    def _best_of(self, scores: Array, first: int = 0) -> tuple[MeanSet, float]:
        """The likeliest set of those whose terms begin with the first, and its score."""
        row, term = np.unravel_index(np.argmax(scores), scores.shape)
        return MeanSet(self.search.inference.sets[row].causes, first + int(term)), float(scores[row, term])

    def integrated(self, chosen: NDArray[np.bool_]) -> Law:
        """Integrate some of the sets over the noise, from the likeliest noises of the best and without causes."""
        nothing, search = MeanSet(()), self.search
        parts = [
            self._best_of(self.scores[:, :1]),
            *([self._best_of(self.scores[:, 1:], 1)] if chosen[:, 1:].any() else []),
        ]
        tops = [one for one, score in parts if score > self.best - BESIDE]
        anchors = [search.likeliest(one, search.at(self.rich), integrate=True) for one in tops]
        if chosen[search.inference.sets.index(nothing), 0] and nothing not in tops:
            anchors.append(search.likeliest(nothing, search.at(self.plain), integrate=True))
        law, count = search.integrated(anchors, chosen, DRAWN), DRAWN
        while law.effective < EFFECTIVE and count < MOST_DRAWN:
            count *= 2
            law = search.integrated([*anchors, law.noise()], chosen, count)
        return law


def _drawn(anchors: Sequence[Laplace], count: int) -> tuple[Array, Array]:
    """Points of a mixture of Student-t laws about modes, shape (j, h), and its log density there."""
    parts = [_proposal(anchor) for anchor in anchors]
    size = len(anchors[0].mode)
    even = even_points(count, size + 1)
    scale = 2.0 * gammaincinv(0.5 * TAILS, even[:, -1]) / TAILS
    at = np.concatenate([mode + (ndtri(even[:, :-1]) @ factor.T) / np.sqrt(scale)[:, None] for mode, factor in parts])
    logs = np.stack([log_student_density(at, mode, factor, TAILS) for mode, factor in parts])
    return at, np.asarray(logsumexp(logs, axis=0) - math.log(len(parts)))


def _proposal(anchor: Laplace) -> tuple[Array, Array]:
    values, vectors = np.linalg.eigh(anchor.covariance)
    sd = np.clip(WIDENED * np.sqrt(np.maximum(values, 1e-8)), 1e-3, WIDEST)
    return anchor.mode, np.asarray(np.linalg.cholesky((vectors * sd**2) @ vectors.T))
