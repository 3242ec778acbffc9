"""One posterior of a navigation log over all sets of causes, their sizes, the noise and neutral responses.

A set is some effects in the mean, and at most two that are random. Given a noise, the model is linear and Gaussian, and
all sets share the inner products of its columns (`inference.set_evidence`). The noise is integrated over by importance
sampling (Owen 2013, *Monte Carlo Theory, Methods and Examples*, chapter 9) from a mixture of Student-t laws about the
likeliest noise without a cause and with the likeliest ones. Effects that are not linear are linearised about the
posterior mean of the likeliest set that has them.
"""

import itertools
import math
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammaincinv, gammaln, logsumexp, ndtri

from missionplan.arrays import Array
from missionplan.diagnosis.coordinates import LOWER, UPPER
from missionplan.diagnosis.inference.importance_sampling import even_points, log_student_density
from missionplan.diagnosis.inference.laplace import Laplace, laplace
from missionplan.diagnosis.inference.marginal_likelihood import student_marginal
from missionplan.diagnosis.inference.model import CauseFit
from missionplan.diagnosis.inference.posterior import credible_set
from missionplan.diagnosis.inference.selection import Candidate, Selection
from missionplan.diagnosis.inference.set_evidence import SCALE_PRIOR, SCALES, GramMatrix, SetPriors
from missionplan.diagnosis.legs.fitting import TransitFitting, by_quantiles
from missionplan.diagnosis.legs.likelihood.hyperparameters import Hyperparameter, HyperparameterPrior, values_of
from missionplan.diagnosis.legs.likelihood.linearised import LinearisedLegs
from missionplan.diagnosis.legs.likelihood.modulation import SHORTEST, Forms
from missionplan.diagnosis.legs.likelihood.selected_legs import MIN_DOF
from missionplan.diagnosis.legs.responses import Response
from missionplan.diagnosis.legs.state import TransitState
from missionplan.effects import CATALOGUE, effects_of, exclusive_groups
from missionplan.results.learned.evidence import Causes

FURTHER = 3.0
"""Nats of prior that each cause beyond the first costs."""
MOST_IN_MEAN = 3
KEPT = 12.0
"""Nats below the likeliest set within which a set is integrated; what the others hold is stated."""
LISTED = 12
"""Sets, at most, that are fitted for the report."""
BESIDE = 3
"""Likeliest sets beside which oscillations that need not be steady are tried."""
LEAST_SHARE = 1e-6
"""Of a set's probability, below which one of its scales is left out of its moments."""
EFFECTIVE = 12.0
"""Effective points below which the noise is drawn anew about what the points show of it."""
WORTH_PAIRING = 3.0
"""Nats below the likeliest within which a random effect is tried together with another."""
DRAWN, MOST_DRAWN = 32, 256
"""Points of the noise about each anchor, at first, and where too few of them count."""
TAILS, WIDENED = 5, 1.25
"""Degrees of freedom of the law from which they are drawn, and factor on its standard deviations."""
WIDEST = 1.5
"""Largest standard deviation of that law along any direction [logarithms]."""
BETWEEN = (0.0, 0.5, 1.0)
"""Places between the noise without causes and with all of them where sets are compared first."""
RELINEARISED, SETTLED = 4, 0.02
"""Most times that the columns are linearised anew, and change [slabs] below which they are not."""


K = TypeVar("K")
Noise = dict[tuple[str, str], float]
"""Logarithms of hyperparameters by effect and name."""


@dataclass(frozen=True)
class MeanSet:
    """A set's effects in the mean with a neutral response, or none.

    Attributes
    ----------
    causes : tuple of str
    response : int
        Number of the response, from 1; 0 for none.
    """

    causes: Causes
    response: int


@dataclass(frozen=True)
class Law:
    """Random effects with sets in the mean, integrated over the noise.

    Attributes
    ----------
    effects : tuple of str
    hyperparameters : tuple of Hyperparameter
    at : array, shape (j, h)
        Logarithms of the noise at its points.
    sets : tuple of MeanSet
    log_weights : array, shape (s, j, c)
        Of each set at each noise and scale of the slabs, prior included; their sum is the evidence times the prior.
    grams : mapping
        By group, the inner products at each noise.
    """

    effects: Causes
    hyperparameters: tuple[Hyperparameter, ...]
    at: Array
    sets: tuple[MeanSet, ...]
    log_weights: Array
    grams: Mapping[Causes, Sequence[GramMatrix]]

    @property
    def effective(self) -> float:
        """Effective number of noises (Owen 2013, section 9.3)."""
        shares = self._shares
        return 1.0 / float(np.sum(shares**2))

    @property
    def _shares(self) -> Array:
        logs = logsumexp(self.log_weights, axis=(0, 2))
        return np.asarray(np.exp(logs - logsumexp(logs)))

    def noise(self) -> Laplace:
        """Mean and covariance of the noise's posterior as drawn."""
        return self.noise_of(self._shares)

    def noise_of(self, shares: Array) -> Laplace:
        """Mean and covariance of the noise with shares of its points, shape (j,)."""
        mean = shares @ self.at
        apart = self.at - mean
        spread = (shares[:, None] * apart).T @ apart + np.diag(np.full(len(mean), 1e-4))
        return Laplace(math.nan, mean, spread)


@dataclass(frozen=True)
class _Linear:
    """The model of a group of sets, linearised: its columns, data and their places."""

    about: Array
    linear: LinearisedLegs
    joined: Array


class LegInference:
    """Computes the posterior of a model of legs.

    Parameters
    ----------
    model : TransitFitting
    responses : sequence of Response
        Neutral ones.
    """

    def __init__(self, model: TransitFitting, responses: Sequence[Response]) -> None:
        self.model, self.responses = model, tuple(responses)
        infos = [CATALOGUE[name] for name in model.candidates]
        self.in_mean = tuple(info.id for info in infos if info.part == "mean")
        self.random = tuple(info.id for info in infos if info.part == "covariance")
        self.catalogue = len(effects_of("transit"))
        self.uniform_currents = {i.id for i in infos if i.is_steady_current or i.is_modulated}
        self.bent = tuple(name for name in self.in_mean if not CATALOGUE[name].linear)
        subsets = [s for size in range(MOST_IN_MEAN + 1) for s in itertools.combinations(self.in_mean, size)]
        numbers = range(len(self.responses) + 1)
        self.sets = tuple(MeanSet(s, r) for s in subsets for r in numbers if not r or len(s) < MOST_IN_MEAN)
        self._k = len(model.coordinates)
        self._known: dict[tuple[MeanSet, int], tuple[Array, Array]] = {}
        self._groups: dict[Causes, _Linear] = {}

    # priors

    def log_prior(self, one: MeanSet, law: Causes) -> float:
        """Log prior odds of a set over none: 1/(catalogue) for the first effect, e⁻³ more for each further one."""
        count = len(one.causes) + len(law) + (one.response > 0)
        shared = math.log(len(self.responses)) if one.response else 0.0
        return -math.log(self.catalogue) - FURTHER * (count - 1) - shared if count else 0.0

    def group(self, one: MeanSet) -> Causes:
        """Effects of a set that are not linear: sets with the same ones share their columns."""
        return tuple(name for name in one.causes if name in self.bent)

    def places(self, response: int) -> NDArray[np.int_]:
        """Columns that act beside a response."""
        core = np.arange(self._core)
        sizes = [r.columns.shape[2] for r in self.responses]
        first = self._core + sum(sizes[: response - 1]) if response else 0
        return np.concatenate([core, np.arange(first, first + sizes[response - 1])]) if response else core

    @cached_property
    def _core(self) -> int:
        return int(self.linear(()).linear.columns.shape[2])

    def prior(self, one: MeanSet, scale: int) -> tuple[Array, Array]:
        """Mean and factor of the prior of a set's coefficients, raw coordinates first."""
        if (one, scale) not in self._known:
            coordinates = self.model.prior(one.causes)
            size = len(self.places(one.response))
            mean, factor = np.zeros(size), np.eye(size)
            mean[: self._k] = coordinates.mean
            own = coordinates.factor.copy()
            chosen = [i for name in one.causes for i in self.model.by_effect.get(name, ())]
            own[chosen] *= SCALES[scale]
            factor[: self._k, : self._k] = own
            factor[self._core :, self._core :] *= SCALES[scale]
            self._known[one, scale] = mean, factor
        return self._known[one, scale]

    def priors(self, sets: Iterable[MeanSet], scale: int) -> SetPriors:
        """Priors of sets of one response."""
        means, factors = zip(*(self.prior(one, scale) for one in sets), strict=True)
        return SetPriors(np.stack(means), np.stack(factors))

    # likelihood

    def linear(self, group: Causes) -> _Linear:
        """The linearised model of a group."""
        if group not in self._groups:
            self._groups[group] = self._linearised(group, self.model.expected)
        return self._groups[group]

    def _linearised(self, group: Causes, about: Array) -> _Linear:
        model = self.model
        linear = model.linearised(group, about, model.given_forms)
        raw = model.columns(about) if group else model.columns_as_expected
        y = model.y - (model.mean_error(about) - model.mean_error(model.expected)) + raw @ about
        modulations = linear.columns[:, :, self._k :]
        columns = [raw, modulations, *(r.columns for r in self.responses), y[:, :, None]]
        return _Linear(about, linear, np.concatenate(columns, axis=2))

    def gram(self, law: "_LawSearch", logs: Array, group: Causes, responses: Collection[int]) -> GramMatrix:
        """Inner products of a group's columns under a noise, those of other responses nil."""
        full = self.linear(group).joined.shape[2]
        acting = np.unique(np.concatenate([self.places(number) for number in {0, law.reference.response, *responses}]))
        kept = np.append(acting, full - 1)
        small = self._gram(law, logs, group, kept)
        products = np.zeros((full, full))
        products[np.ix_(kept, kept)] = small.products
        return GramMatrix(products, small.log_normaliser)

    def _gram(self, law: "_LawSearch", logs: Array, group: Causes, kept: NDArray[np.int_]) -> GramMatrix:
        own, values = self.linear(group), values_of(law.hyperparameters, logs)
        noise, legs = self.model.noise_components(values), self.model._all_legs
        joined = own.joined[:, :, kept]
        if self._core > self._k:
            joined[:, :, self._k : self._core] *= own.linear.prior_sd(values)[self._k :]
        independent = noise.independent(legs.under_way)
        if math.isinf(noise.dof):
            products, log_determinant = legs.gram(joined, independent, noise.fix_sd, noise.process)
            return GramMatrix.of(products, log_determinant, 2 * self.model.data.n)
        if noise.dof <= MIN_DOF:
            raise np.linalg.LinAlgError("the variance of the errors does not exist")
        variance = independent + noise.fix_sd**2 * legs.fix_variance()
        return self._heavy_tailed(joined, variance, noise.dof, law.reference, kept)

    def _heavy_tailed(
        self, joined: Array, variance: Array, dof: float, reference: MeanSet, kept: NDArray[np.int_]
    ) -> GramMatrix:
        """A normal lower bound of Student-t errors that touches them where a reference set is likeliest.

        ln t of a leg is at least a parabola in its residuals with the weight (ν + 2)/(ν − 2 + q) of iterated least
        squares (Lange, Little & Taylor 1989; Jaakkola & Jordan 2000, *Stat. Comput.* 10).
        """
        mean, factor = self.prior(reference, 1)
        design = joined[:, :, np.searchsorted(kept, self.places(reference.response))]
        y = joined[:, :, -1] - design @ mean
        white = design @ factor
        found = student_marginal(y, white, np.ones(len(mean)), variance, dof)
        squared = np.sum((y - white @ found.mean) ** 2 / variance, axis=0)
        weight = (dof + 2.0) / (dof - 2.0 + squared)
        constant = gammaln(0.5 * dof + 1.0) - gammaln(0.5 * dof) - math.log(math.pi * (dof - 2.0))
        log_normaliser = len(squared) * constant - 0.5 * float(np.log(variance).sum())
        log_normaliser += float(np.sum(0.5 * weight * squared - 0.5 * (dof + 2.0) * np.log1p(squared / (dof - 2.0))))
        weighted = joined * (weight / variance)[:, :, None]
        return GramMatrix(np.einsum("ijk,ijl->kl", weighted, joined), log_normaliser)

    def log_densities(self, law: "_LawSearch", logs: Array, sets: Sequence[MeanSet], scale: int) -> Array:
        """Log density of the data under each of some sets at one noise, shape (s,)."""
        found = np.full(len(sets), -np.inf)
        for group, members in _grouped(sets, self.group).items():
            gram = self.gram(law, logs, group, {sets[i].response for i in members})
            for response, own in _grouped([sets[i] for i in members], lambda one: one.response).items():
                places = [members[i] for i in own]
                part = gram.part(self.places(response))
                priors = self.priors([sets[i] for i in places], scale)
                found[places] = priors.log_densities([part])[0] if len(places) > 1 else priors.log_density(part)
        return found

    # search

    def relinearise(self, law: "_LawSearch", logs: Array) -> None:
        """Linearise each group anew about the posterior mean of its likeliest set."""
        slabs = np.array([coordinate.slab for coordinate in self.model.coordinates])
        plain = [one for one in self.sets if not one.response]
        for _ in range(RELINEARISED):
            moved = 0.0
            scores = self.log_densities(law, logs, plain, 1) + [self.log_prior(one, law.effects) for one in plain]
            for group, members in _grouped(plain, self.group).items():
                if not group:
                    continue
                best = plain[max(members, key=lambda i: scores[i])]
                mean, _ = self.priors([best], 1).posterior([self.gram(law, logs, group, ()).part(self.places(0))])
                about = mean[0, 0, : self._k]
                moved = max(moved, float(np.max(np.abs(about - self.linear(group).about) / slabs)))
                self._groups[group] = self._linearised(group, about)
            if moved < SETTLED:
                break


def _grouped(items: Sequence[MeanSet], key: Callable[[MeanSet], K]) -> dict[K, list[int]]:
    """Indices of items by a key."""
    found: dict[K, list[int]] = {}
    for index, item in enumerate(items):
        found.setdefault(key(item), []).append(index)
    return found


class _LawSearch:
    """The noise of some random effects: where it is likely, and which sets are likely with it."""

    def __init__(self, inference: LegInference, effects: Causes, reference: MeanSet) -> None:
        self.inference, self.effects, self.reference = inference, effects, reference
        model = inference.model
        self.hyperparameters = model.hyperparameters(effects, model.given_forms)
        self.prior = HyperparameterPrior.of(self.hyperparameters, model.given_in_covariance)

    def likeliest(self, one: MeanSet, start: Noise | None = None, *, integrate: bool = False) -> Laplace:
        """Find the likeliest noise with a set, and with its spread if that is wanted."""
        start = start or {}

        def log_posterior(logs: Array) -> float:
            return self.prior.log_density(logs) + float(self.inference.log_densities(self, logs, [one], 1)[0])

        centre = np.array([start.get(h.key, h.centre) for h in self.hyperparameters])
        starts = [centre]
        for index, h in enumerate(self.hyperparameters):
            if h.law in ("student", "reciprocal") and h.key not in start:
                starts += [centre + sign * h.spread * np.eye(len(centre))[index] for sign in (-1.0, 1.0)]
        spread = np.diag([min(0.1, h.spread**2) for h in self.hyperparameters])
        return laplace(log_posterior, starts, spread, integrate=integrate, keep_inside=True)

    def at(self, found: Laplace) -> Noise:
        """The noise at a mode, by name."""
        return {h.key: float(value) for h, value in zip(self.hyperparameters, found.mode, strict=True)}

    def compared(self, plain: Laplace, rich: Laplace) -> "_Compared":
        """Compare all sets, each at its likeliest of a few noises."""
        inference = self.inference
        priors = np.array([inference.log_prior(one, self.effects) for one in inference.sets])
        found = [
            self.prior.log_density(logs) + inference.log_densities(self, logs, inference.sets, 1)
            for logs in (plain.mode + share * (rich.mode - plain.mode) for share in BETWEEN)
        ]
        return _Compared(self, plain, rich, np.asarray(np.max(found, axis=0) + priors))

    def integrated(self, anchors: Sequence[Laplace], sets: Sequence[MeanSet], count: int) -> Law:
        """Integrate sets over the noise, with a number of points about each anchor."""
        at, log_proposal = _drawn(anchors, count)
        inference = self.inference
        in_groups = _grouped(sets, inference.group)
        groups = {group: {sets[i].response for i in own} for group, own in in_groups.items()}
        kept: list[int] = []
        grams: dict[Causes, list[GramMatrix]] = {group: [] for group in groups}
        for index, logs in enumerate(at):
            if not math.isfinite(self.prior.log_density(logs)):
                continue
            try:
                own = {group: inference.gram(self, logs, group, numbers) for group, numbers in groups.items()}
            except np.linalg.LinAlgError:
                continue
            kept.append(index)
            for group, gram in own.items():
                grams[group].append(gram)
        base = np.array([self.prior.log_density(at[i]) - log_proposal[i] - math.log(len(at)) for i in kept])
        logs_of = np.empty((len(sets), len(kept), len(SCALES)))
        for (group, response), members in _grouped(sets, lambda one: (inference.group(one), one.response)).items():
            chosen, places = [sets[i] for i in members], inference.places(response)
            for scale in range(len(SCALES)):
                if scale != 1 and not response and not any(one.causes for one in chosen):
                    logs_of[members, :, scale] = -np.inf
                    continue
                priors = inference.priors(chosen, scale)
                share = math.log(SCALE_PRIOR[scale])
                parts = [gram.part(places) for gram in grams[group]]
                logs_of[members, :, scale] = priors.log_densities(parts).T + base + share
        logs_of += np.array([inference.log_prior(one, self.effects) for one in sets])[:, None, None]
        for i, one in enumerate(sets):
            if not one.causes and not one.response:
                logs_of[i, :, 1] -= math.log(SCALE_PRIOR[1])
        return Law(self.effects, self.hyperparameters, at[kept], tuple(sets), logs_of, grams)


@dataclass(frozen=True)
class _Compared:
    """Sets compared under some random effects.

    Attributes
    ----------
    search : _LawSearch
    plain, rich : Laplace
        The likeliest noise without causes in the mean, and with many.
    scores : array, shape (s,)
        Log density and prior of all sets at their likeliest noises.
    """

    search: _LawSearch
    plain: Laplace
    rich: Laplace
    scores: Array

    @property
    def best(self) -> float:
        """Greatest score."""
        return float(self.scores.max())

    @property
    def top(self) -> MeanSet:
        """The likeliest set."""
        return self.search.inference.sets[int(np.argmax(self.scores))]

    def integrated(self, sets: Sequence[MeanSet]) -> Law:
        """Integrate some of the sets over the noise, from the likeliest noises of the best and without causes."""
        nothing, search = MeanSet((), 0), self.search
        anchors = [search.likeliest(self.top, search.at(self.rich), integrate=True)]
        if nothing in sets and self.top != nothing:
            anchors.append(search.likeliest(nothing, search.at(self.plain), integrate=True))
        law, count = search.integrated(anchors, sets, DRAWN), DRAWN
        while law.effective < EFFECTIVE and count < MOST_DRAWN:
            count *= 2
            law = search.integrated([*anchors, law.noise()], sets, count)
        return law


def _drawn(anchors: Sequence[Laplace], count: int) -> tuple[Array, Array]:
    """Points of a mixture of Student-t laws about modes, shape (j, h), and its log density there."""
    parts = [_proposal(found) for found in anchors]
    size = len(anchors[0].mode)
    even = even_points(count, size + 1)
    scale = 2.0 * gammaincinv(0.5 * TAILS, even[:, -1]) / TAILS
    at = np.concatenate([mode + (ndtri(even[:, :-1]) @ factor.T) / np.sqrt(scale)[:, None] for mode, factor in parts])
    logs = np.stack([log_student_density(at, mode, factor, TAILS) for mode, factor in parts])
    return at, np.asarray(logsumexp(logs, axis=0) - math.log(len(parts)))


def _proposal(found: Laplace) -> tuple[Array, Array]:
    values, vectors = np.linalg.eigh(found.covariance)
    sd = np.clip(WIDENED * np.sqrt(np.maximum(values, 1e-8)), 1e-3, WIDEST)
    return found.mode, np.asarray(np.linalg.cholesky((vectors * sd**2) @ vectors.T))


def laws_of(random: Causes) -> tuple[list[Causes], list[Causes]]:
    """Return single random effects, and pairs that describe different errors."""
    groups = exclusive_groups("transit")
    pairs: list[Causes] = [p for p in itertools.combinations(random, 2) if not any(len(g & set(p)) > 1 for g in groups)]
    return [(name,) for name in random], pairs


def infer(inference: LegInference) -> "LegPosterior":
    """Compute the posterior."""
    nothing, rich = MeanSet((), 0), MeanSet(inference.in_mean, 0)
    plain = _LawSearch(inference, (), nothing)
    first = plain.likeliest(nothing)
    full = plain.likeliest(rich, plain.at(first))
    inference.relinearise(plain, full.mode)
    searches: dict[Causes, _Compared] = {(): plain.compared(first, full)}
    top = searches[()].top
    known = plain.at(plain.likeliest(top, plain.at(full)))
    singles, pairs = laws_of(inference.random)
    for law in singles:
        search = _LawSearch(inference, law, top)
        searches[law] = search.compared(search.likeliest(nothing, plain.at(first)), search.likeliest(top, known))
    best = max(each.best for each in searches.values())
    for law in pairs:
        if any(searches[name,].best > best - WORTH_PAIRING for name in law):
            search = _LawSearch(inference, law, top)
            searches[law] = search.compared(search.likeliest(nothing, plain.at(first)), search.likeliest(top, known))
    best = max(each.best for each in searches.values())
    laws, left = [], [-np.inf]
    for each in searches.values():
        likely = {one.causes for one, score in zip(inference.sets, each.scores, strict=True) if score > best - KEPT}
        likely |= set() if each.search.effects else {()}
        chosen = each.scores > best - KEPT
        chosen |= np.array([not one.response and one.causes in likely for one in inference.sets])
        left.append(float(logsumexp(each.scores[~chosen])))
        if chosen.any():
            own = [one for one, kept in zip(inference.sets, chosen, strict=True) if kept]
            laws.append(each.integrated(own))
    return LegPosterior(inference, tuple(laws), float(logsumexp(left)) - best)


@dataclass(frozen=True)
class LegPosterior:
    """The posterior of a log over all sets.

    Attributes
    ----------
    inference : LegInference
    laws : tuple of Law
    left : float
        Log of what the sets that were not integrated hold, over the likeliest.
    masses : mapping, optional
        Of `log_masses` where they are not those of the laws.
    forms : mapping
        States of sets with oscillations that are not steady.
    """

    inference: LegInference
    laws: tuple[Law, ...]
    left: float
    masses: Mapping[tuple[Causes, int], float] | None = None
    forms: Mapping[Causes, TransitState] = field(default_factory=dict)

    @cached_property
    def log_masses(self) -> Mapping[tuple[Causes, int], float]:
        """Log evidence times prior of each set of causes with each response."""
        if self.masses is not None:
            return self.masses
        found: dict[tuple[Causes, int], float] = {}
        order = {name: index for index, name in enumerate(self.inference.model.candidates)}
        for law in self.laws:
            for one, logs in zip(law.sets, law.log_weights, strict=True):
                causes = tuple(sorted((*one.causes, *law.effects), key=order.__getitem__))
                found[causes, one.response] = float(logsumexp(logs))
        return found

    @cached_property
    def probabilities(self) -> dict[Causes, float]:
        """Probability of each set of causes, with a neutral response or without; greatest first."""
        total = logsumexp(list(self.log_masses.values()))
        found: dict[Causes, float] = {}
        for (causes, _), mass in self.log_masses.items():
            found[causes] = found.get(causes, 0.0) + math.exp(mass - total)
        return dict(sorted(found.items(), key=lambda item: -item[1]))

    @property
    def named(self) -> dict[Causes, float]:
        """Probabilities of sets as they are listed, greatest first.

        A statistical description names no cause: where a set is likelier without it, its probability goes with that.
        """
        found: dict[Causes, float] = {}
        for causes, probability in self.probabilities.items():
            listed = self._described(causes)
            found[listed] = found.get(listed, 0.0) + probability
        return dict(sorted(found.items(), key=lambda item: -item[1]))

    def _described(self, causes: Causes) -> Causes:
        """A set without the descriptions without which it is likelier."""
        for name in set(causes) & set(self.inference.random):
            rest = tuple(other for other in causes if other != name)
            if self.log_masses.get((rest, 0), -math.inf) > self.log_masses.get((causes, 0), math.inf):
                return self._described(rest)
        return causes

    @property
    def responses(self) -> tuple[tuple[Response, float], ...]:
        """Neutral responses with their probabilities."""
        total = logsumexp(list(self.log_masses.values()))
        return tuple(
            (response, sum(math.exp(m - total) for (_, own), m in self.log_masses.items() if own == number))
            for number, response in enumerate(self.inference.responses, start=1)
        )

    @property
    def not_computed(self) -> float:
        """Estimate of the probability of the sets that were not integrated."""
        return math.exp(min(self.left, 0.0))

    def evidence(self, causes: Causes) -> float:
        """Log evidence of a set without a response, its prior taken out."""
        law = tuple(name for name in causes if name in self.inference.random)
        mean = MeanSet(tuple(name for name in causes if name not in law), 0)
        return self.log_masses[causes, 0] - self.inference.log_prior(mean, law)

    def state(self, causes: Causes) -> TransitState:
        """State of a fit to a set: moments of its part of the posterior, over noises and slabs."""
        model = self.inference.model
        law, wanted, shares = self._part(causes)
        over_noise, over_scales = shares.sum(axis=1), shares.sum(axis=0)
        mean, covariance = self._moments(law, wanted, shares)
        hyperparameters = model.hyperparameters(causes, model.given_forms)
        noise = law.noise_of(over_noise)
        place = {h.key: index for index, h in enumerate(law.hyperparameters)}
        own = [place.get(h.key) for h in hyperparameters]
        scale = float(over_scales @ np.log(SCALES))
        mode = np.array([scale if at is None else noise.mode[at] for at in own])
        spread = np.diag([0.25 if at is None else 0.0 for at in own])
        known = [(row, at) for row, at in enumerate(own) if at is not None]
        for row, i in known:
            for column, j in known:
                spread[row, column] = noise.covariance[i, j]
        about = self.inference.linear(self.inference.group(wanted)).about
        linear = model.linearised(causes, about, model.given_forms)
        return TransitState(
            model.given_forms, hyperparameters, Laplace(self.evidence(causes), mode, spread), mean, covariance, linear
        )

    def _part(self, causes: Causes) -> tuple[Law, MeanSet, Array]:
        """Law and mean set of a set of causes, and its shares of noises and scales, shape (j, c)."""
        law = next(law for law in self.laws if set(law.effects) == set(causes) & set(self.inference.random))
        wanted = MeanSet(tuple(name for name in causes if name not in law.effects), 0)
        logs = law.log_weights[law.sets.index(wanted)]
        return law, wanted, np.exp(logs - logsumexp(logs))

    def _over_noise(self, causes: Causes) -> tuple[Law, Array]:
        law, _, shares = self._part(causes)
        return law, shares.sum(axis=1)

    def _moments(self, law: Law, one: MeanSet, shares: Array) -> tuple[Array, Array]:
        """Posterior mean (k,) and covariance (k, k) of the coordinates of a set."""
        inference, k = self.inference, len(self.inference.model.coordinates)
        grams = [gram.part(inference.places(0)) for gram in law.grams[inference.group(one)]]
        mean, covariance, squares = np.zeros(k), np.zeros((k, k)), np.zeros((k, k))
        for scale in range(len(SCALES)):
            if shares[:, scale].sum() < LEAST_SHARE:
                continue
            means, roots = inference.priors([one], scale).posterior(grams)
            means, roots, weights = means[:, 0, :k], roots[:, 0, :k], shares[:, scale]
            mean += weights @ means
            squares += (weights[:, None] * means).T @ means
            covariance += np.einsum("j,jik,jlk->il", weights, roots, roots)
        mean /= shares.sum()
        return mean, covariance + squares - np.outer(mean, mean)

    def fit(self, causes: Causes) -> CauseFit:
        """Return a set as fitted: its state, with sizes and times of random effects by their quantiles."""
        known = self.forms.get(causes)
        state = self.state(causes) if known is None else known
        fit = self.inference.model.fit_of(causes, state, self.evidence(causes))
        if known is not None:
            return fit
        law, shares = self._over_noise(causes)
        found = {h.key: np.exp(_quantiles(law.at[:, i], shares)) for i, h in enumerate(law.hyperparameters)}
        estimates, given = (
            tuple(by_quantiles(each, found.get((each.effect, each.name))) for each in several)
            for several in (fit.estimates, fit.given)
        )
        return replace(fit, estimates=estimates, given=given)

    def selection(self) -> Selection:
        """Return the sets with their probabilities, the likeliest fitted."""
        probabilities = self.probabilities
        listed = [causes for causes in probabilities if causes][:LISTED]
        listed += [causes for causes in credible_set(self.named) if causes and causes not in listed]
        fits = [self.fit(causes) for causes in listed]
        base = self.fit(())
        impossible = [fit for fit in fits if not fit.possible]
        ruled_out = {fit.causes for fit in impossible}
        total = sum(p for causes, p in probabilities.items() if causes not in ruled_out)
        posterior = {causes: p / total for causes, p in probabilities.items() if causes not in ruled_out}
        nothing = self.log_masses[(), 0] - float(logsumexp(list(self.log_masses.values())))

        def candidate(fit: CauseFit) -> Candidate:
            return Candidate(fit, fit.log_evidence - base.log_evidence)

        return Selection(
            base,
            tuple(candidate(fit) for fit in fits if fit.possible),
            tuple(candidate(fit) for fit in impossible),
            (),
            self.inference.catalogue,
            posterior,
            tuple((response.axis, response.description, p) for response, p in self.responses),
            self._families(posterior),
            math.exp(nothing) / total,
            self.not_computed,
            tuple(credible_set({c: p for c, p in self.named.items() if c not in ruled_out})),
        )

    def _families(self, posterior: Mapping[Causes, float]) -> tuple[tuple[Causes, ...], ...]:
        """Sets that differ in a steady or an oscillating current, where the record does not show whether it turns."""
        found: dict[frozenset[str], list[Causes]] = {}
        for causes in posterior:
            for name in set(causes) & self.inference.uniform_currents:
                found.setdefault(frozenset(causes) - {name}, []).append(causes)
        families = []
        for rest, members in found.items():
            steady = [c for c in members if any(CATALOGUE[n].is_steady_current for n in set(c) - rest)]
            if steady:
                alike = [c for c in members if abs(self._score(c) - self._score(steady[0])) < FURTHER]
                if len(alike) > 1:
                    families.append(tuple(alike))
        return tuple(families)

    def _score(self, causes: Causes) -> float:
        return self.log_masses.get((causes, 0), -math.inf)


def _quantiles(values: Array, shares: Array) -> Array:
    """The 5, 50 and 95 % quantiles of weighted values, interpolated between the middles of their shares."""
    order = np.argsort(values)
    weights = shares[order]
    return np.asarray(np.interp((LOWER, 0.5, UPPER), np.cumsum(weights) - 0.5 * weights, values[order]))


def with_forms(posterior: LegPosterior) -> LegPosterior:
    """Weigh oscillations that need not be steady, in records long enough to show them."""
    model = posterior.inference.model
    given = {each.effect for each in model.given}
    names = [name for name in model.candidates if CATALOGUE[name].is_modulated and name not in given]
    if not names or float(np.ptp(model.data.middle)) < SHORTEST:
        return posterior
    likely = list(posterior.probabilities)[:BESIDE]
    order = {name: index for index, name in enumerate(model.candidates)}
    tried = {tuple(sorted({*causes, name}, key=order.__getitem__)) for causes in [(), *likely] for name in names}
    masses, forms = dict(posterior.log_masses), {}
    for causes in sorted(tried):
        law = tuple(name for name in causes if name in posterior.inference.random)
        mean = MeanSet(tuple(name for name in causes if name not in law), 0)
        if len(mean.causes) > MOST_IN_MEAN:
            continue
        try:
            evidence, gain, state = model.over_forms(causes)
        except np.linalg.LinAlgError:
            continue
        steady = masses.get((causes, 0))
        prior = posterior.inference.log_prior(mean, law)
        masses[causes, 0] = evidence + prior if steady is None else steady + gain
        if state.forms != Forms() or steady is None:
            forms[causes] = state
    return replace(posterior, masses=masses, forms=forms)
