"""One posterior of a navigation log over all sets of causes, their sizes, the noise and neutral responses.

A set is some effects in the mean, and at most two that are random. Given a noise, the model is linear and Gaussian, and
all sets share the inner products of its columns (`inference.set_evidence`). The noise is integrated over by importance
sampling (Owen 2013, *Monte Carlo Theory, Methods and Examples*, chapter 9) from a mixture of Student-t laws about the
likeliest noise without a cause and with the likeliest ones. Effects that are not linear are linearised about the
posterior mean of the likeliest set that has them.
"""

import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from scipy.special import logsumexp

from missionplan.arrays import Array
from missionplan.diagnosis.coordinates import LOWER, UPPER
from missionplan.diagnosis.inference.laplace import Laplace
from missionplan.diagnosis.inference.model import CauseFit
from missionplan.diagnosis.inference.posterior import credible_set
from missionplan.diagnosis.inference.selection import FURTHER, Candidate, Selection
from missionplan.diagnosis.inference.set_evidence import SCALES
from missionplan.diagnosis.legs.fitting import by_quantiles
from missionplan.diagnosis.legs.likelihood.modulation import SHORTEST, Forms
from missionplan.diagnosis.legs.noise_integration import ComparedSets, Law, NoiseSearch
from missionplan.diagnosis.legs.responses import Response
from missionplan.diagnosis.legs.set_density import MOST_IN_MEAN, LegInference, MeanSet
from missionplan.diagnosis.legs.state import TransitState
from missionplan.effects import CATALOGUE, exclusive_groups
from missionplan.results.learned.evidence import Causes

KEPT = 12.0
"""Nats below the likeliest set within which a set is integrated; what the others hold is stated."""
LISTED = 12
"""Sets, at most, that are fitted for the report."""
BESIDE = 3
"""Likeliest sets beside which oscillations that need not be steady are tried."""
LEAST_SHARE = 1e-6
"""Of a set's probability, below which one of its scales is left out of its moments."""
WORTH_PAIRING = 3.0
"""Nats below the likeliest within which a random effect is tried together with another."""


def laws_of(random: Causes) -> tuple[list[Causes], list[Causes]]:
    """Return single random effects, and pairs that describe different errors."""
    groups = exclusive_groups("transit")
    pairs: list[Causes] = [p for p in itertools.combinations(random, 2) if not any(len(g & set(p)) > 1 for g in groups)]
    return [(name,) for name in random], pairs


def infer(inference: LegInference) -> "LegPosterior":
    """Compute the posterior."""
    nothing, rich = MeanSet((), 0), MeanSet(inference.in_mean, 0)
    plain = NoiseSearch(inference, (), nothing)
    first = plain.likeliest(nothing)
    full = plain.likeliest(rich, plain.at(first))
    inference.relinearise(plain.errors, full.mode)
    searches: dict[Causes, ComparedSets] = {(): plain.compared(first, full)}
    top = searches[()].top
    known = plain.at(plain.likeliest(top, plain.at(full)))
    singles, pairs = laws_of(inference.random)
    for law in singles:
        search = NoiseSearch(inference, law, top)
        searches[law] = search.compared(search.likeliest(nothing, plain.at(first)), search.likeliest(top, known))
    best = max(each.best for each in searches.values())
    for law in pairs:
        if any(searches[name,].best > best - WORTH_PAIRING for name in law):
            search = NoiseSearch(inference, law, top)
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
    masses, forms = dict(posterior.log_masses), {}
    for causes in _modulated_sets(posterior):
        law = tuple(name for name in causes if name in posterior.inference.random)
        mean = MeanSet(tuple(name for name in causes if name not in law), 0)
        if len(mean.causes) > MOST_IN_MEAN:
            continue
        try:
            evidence, gain, state = posterior.inference.model.over_forms(causes)
        except np.linalg.LinAlgError:
            continue
        steady = masses.get((causes, 0))
        prior = posterior.inference.log_prior(mean, law)
        masses[causes, 0] = evidence + prior if steady is None else steady + gain
        if state.forms != Forms() or steady is None:
            forms[causes] = state
    return replace(posterior, masses=masses, forms=forms) if forms or masses != posterior.log_masses else posterior


def _modulated_sets(posterior: LegPosterior) -> list[Causes]:
    """Sets with an oscillation that need not be steady, beside nothing and the likeliest sets."""
    model = posterior.inference.model
    given = {each.effect for each in model.given}
    names = [name for name in model.candidates if CATALOGUE[name].is_modulated and name not in given]
    if not names or float(np.ptp(model.data.middle)) < SHORTEST:
        return []
    likely = list(posterior.probabilities)[:BESIDE]
    order = {name: index for index, name in enumerate(model.candidates)}
    found = {tuple(sorted({*causes, name}, key=order.__getitem__)) for causes in [(), *likely] for name in names}
    return sorted(found)
