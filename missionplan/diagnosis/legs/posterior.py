"""One posterior of a navigation log over all sets of causes, their sizes, the noise and neutral responses.

A set is some effects in the mean, one term at most (`terms`), and at most two effects that are random. Given a noise,
the model is linear and Gaussian (`set_density`); the noise is integrated over (`noise_integration`).
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from scipy.special import logsumexp

from missionplan.arrays import Array
from missionplan.diagnosis.coordinates import LOWER, UPPER, Coordinate, JointPosterior, estimates, is_possible
from missionplan.diagnosis.inference.evidence_approximations import Laplace
from missionplan.diagnosis.inference.marginal_likelihood import SCALES
from missionplan.diagnosis.inference.model import CauseFit
from missionplan.diagnosis.inference.selection import FURTHER, Candidate, Selection, credible_set, told_together
from missionplan.diagnosis.legs.fitting import TransitState, by_quantiles
from missionplan.diagnosis.legs.likelihood.mean import ActingTerm
from missionplan.diagnosis.legs.noise_integration import Law
from missionplan.diagnosis.legs.set_density import LegInference, MeanSet
from missionplan.diagnosis.legs.terms import without_a_name
from missionplan.effects import CATALOGUE, effects_of
from missionplan.results.learned.evidence import Causes, Response

LISTED = 12
"""Sets, at most, that are fitted for the report."""
LEAST_SHARE = 1e-6
"""Of a set's probability, below which one of its scales is left out of its moments."""


@dataclass(frozen=True)
class LegPosterior:
    """The posterior of a log over all sets."""

    inference: LegInference
    laws: tuple[Law, ...]
    left: Array
    """Estimated probability of the sets that were not integrated, without a term and with each, shape (1 + t,)."""
    masses: Mapping[tuple[Causes, int], float] | None = None
    """Of `log_masses` where they are not those of the laws."""
    forms: Mapping[Causes, TransitState] = field(default_factory=dict)
    """States of sets with oscillations that are not steady."""
    beside_terms: Mapping[tuple[Causes, tuple[str, str]], float] = field(default_factory=dict)
    """Log evidence times prior of sets that have a term with a name, with a neutral one besides, by its words."""

    @cached_property
    def log_masses(self) -> Mapping[tuple[Causes, int], float]:
        """Log evidence times prior of each set of causes of the mean and the noise with each term, or with none."""
        if self.masses is not None:
            return self.masses
        masses: dict[tuple[Causes, int], float] = {}
        for law in self.laws:
            masses |= {
                (self.in_order((*one.causes, *law.effects)), term): mass for (one, term), mass in law.masses().items()
            }
        return masses

    def in_order(self, names: Iterable[str]) -> Causes:
        """A set of causes of some names."""
        return tuple(sorted(names, key=self._order.__getitem__))

    @cached_property
    def _order(self) -> dict[str, int]:
        return {info.id: index for index, info in enumerate(effects_of("transit"))}

    @cached_property
    def _by_causes(self) -> dict[Causes, list[tuple[Causes, int]]]:
        """Of each set of causes, what of `log_masses` belongs to it, greatest first."""
        by_causes: dict[Causes, list[tuple[Causes, int]]] = {}
        for key in sorted(self.log_masses, key=lambda key: -self.log_masses[key]):
            # a set with the effect of its term, if that is one of an effect
            causes, term = key
            effect = self.inference.terms[term - 1].effect if term else ""
            by_causes.setdefault(self.in_order((*causes, effect)) if effect else causes, []).append(key)
        return by_causes

    @cached_property
    def _total(self) -> float:
        return float(logsumexp([*self.log_masses.values(), *self.beside_terms.values()]))

    @cached_property
    def probabilities(self) -> dict[Causes, float]:
        """Probability of each set of causes, with a smooth error or without; greatest first."""
        probabilities = {
            causes: sum(math.exp(self.log_masses[key] - self._total) for key in keys)
            for causes, keys in self._by_causes.items()
        }
        for (causes, _), mass in self.beside_terms.items():
            probabilities[causes] = probabilities.get(causes, 0.0) + math.exp(mass - self._total)
        return dict(sorted(probabilities.items(), key=lambda item: -item[1]))

    @property
    def named(self) -> dict[Causes, float]:
        """Probabilities of sets as they are listed, greatest first."""
        return told_together(self.probabilities, self.inference.catalogue)

    @property
    def responses(self) -> tuple[Response, ...]:
        """Neutral terms and smooth errors with their probabilities, greatest first."""
        by_term = self.left.copy()
        for (_, number), mass in self.log_masses.items():
            by_term[number] += math.exp(mass - self._total)
        probabilities: dict[tuple[str, str], float] = {}
        for term, probability in zip(self.inference.terms, by_term[1:].tolist(), strict=True):
            if term.is_neutral:
                key = term.axis, term.description
                probabilities[key] = probabilities.get(key, 0.0) + probability
        for (_, key), mass in self.beside_terms.items():
            probabilities[key] = probabilities.get(key, 0.0) + math.exp(mass - self._total)
        return tuple(Response(*key, p) for key, p in sorted(probabilities.items(), key=lambda item: -item[1]))

    @property
    def not_computed(self) -> float:
        """Estimate of the probability of the sets that were not integrated."""
        return min(float(self.left.sum()), 1.0)

    def _parts(self, causes: Causes) -> tuple[MeanSet, Causes]:
        """What a set of causes has in the mean, with the likeliest term, and of random effects."""
        regular, term = next(
            key for key in self._by_causes[causes] if not key[1] or self.inference.terms[key[1] - 1].effect
        )
        law = tuple(name for name in regular if name in self.inference.random)
        return MeanSet(tuple(name for name in regular if name not in law), term), law

    def evidence(self, causes: Causes) -> float:
        """Log evidence of a set without a smooth error, its prior taken out."""
        one, law = self._parts(causes)
        keys = [key for key in self._by_causes[causes] if bool(key[1]) == bool(one.term)]
        shares = [self.inference.terms[key[1] - 1].log_share if key[1] else 0.0 for key in keys]
        prior = self.inference.log_prior(one, law) - (shares[0] if one.term else 0.0)
        whole = float(logsumexp([self.log_masses[key] for key in keys]))
        return whole - prior - (float(logsumexp(shares)) if one.term else 0.0)

    def state(self, causes: Causes) -> TransitState:
        """State of a fit to a set: moments of its part of the posterior, over noises and slabs."""
        one, _ = self._parts(causes)
        term = self.inference.terms[one.term - 1].acting if one.term else None
        model = self.inference.model.with_term(term)
        law, shares = self._part(causes)
        over_noise, over_scales = shares.sum(axis=1), shares.sum(axis=0)
        mean, covariance = self._moments(law, one, shares)
        hyperparameters = model.hyperparameters(causes, model.given_forms)
        noise = law.noise_of(over_noise)
        place = {h.key: index for index, h in enumerate(law.hyperparameters)}
        places = [place.get(h.key) for h in hyperparameters]
        scale = float(over_scales @ np.log(SCALES))
        mode = np.array([scale if at is None else noise.mode[at] for at in places])
        spread = np.diag([0.25 if at is None else 0.0 for at in places])
        pairs = [(row, at) for row, at in enumerate(places) if at is not None]
        for row, i in pairs:
            for column, j in pairs:
                spread[row, column] = noise.covariance[i, j]
        about = mean if one.term else self.inference.linear(self.inference.group(one)).about
        linear = model.linearised(causes, about, model.given_forms)
        posterior = Laplace(self.evidence(causes), mode, spread)
        state = TransitState(model.given_forms, hyperparameters, posterior, mean, covariance, linear, term)
        return model.settled(causes, state) if one.term else state

    def _part(self, causes: Causes) -> tuple[Law, Array]:
        """Law of a set of causes, and the shares of noises and scales of it with its likeliest term, shape (j, c)."""
        one, random = self._parts(causes)
        law = next(law for law in self.laws if set(law.effects) == set(random))
        place = (0, *law.terms).index(one.term)
        logs = law.log_weights[law.sets.index(MeanSet(one.causes)), :, :, place]
        return law, np.exp(logs - logsumexp(logs))

    def _moments(self, law: Law, one: MeanSet, shares: Array) -> tuple[Array, Array]:
        """Posterior mean (k,) and covariance (k, k) of the coordinates of a set, those of its term last."""
        inference, k = self.inference, len(self.inference.model.coordinates)
        grams = law.grams[inference.group(one)]
        if one.term:
            first, size = inference.blocks(law.terms)[law.terms.index(one.term)].tolist()
            grams = [gram.joined(first, size) for gram in grams]
        kept = np.concatenate([np.arange(k), np.arange(inference.core, len(grams[0].products) - 1)])
        mean, covariance = np.zeros(len(kept)), np.zeros((len(kept), len(kept)))
        squares = np.zeros_like(covariance)
        for scale in range(len(SCALES)):
            if shares[:, scale].sum() < LEAST_SHARE:
                continue
            means, roots = inference.priors([one], [scale]).posterior(grams)
            means, roots, weights = means[:, 0, kept], roots[:, 0, kept], shares[:, scale]
            mean += weights @ means
            squares += (weights[:, None] * means).T @ means
            covariance += np.einsum("j,jik,jlk->il", weights, roots, roots)
        mean /= shares.sum()
        covariance += squares - np.outer(mean, mean)
        acting = inference.terms[one.term - 1].acting if one.term else None
        if acting is None:
            return mean, covariance
        unit = np.concatenate([np.ones(k), [coordinate.slab for coordinate in acting.coordinates]])
        order = inference.model.with_term(acting).from_last(acting)
        return (mean * unit)[order], (covariance * np.outer(unit, unit))[np.ix_(order, order)]

    def fit(self, causes: Causes) -> CauseFit:
        """Return a set as fitted: its state, with sizes and times of random effects by their quantiles."""
        unsteady_state = self.forms.get(causes)
        state = self.state(causes) if unsteady_state is None else unsteady_state
        fit = self.inference.model.with_term(state.term).fit_of(causes, state, self.evidence(causes))
        if unsteady_state is not None:
            return fit
        law, shares = self._part(causes)
        over_noise = shares.sum(axis=1)
        quantiles = {h.key: np.exp(_quantiles(law.at[:, i], over_noise)) for i, h in enumerate(law.hyperparameters)}
        parameters, after = (
            tuple(by_quantiles(estimate, quantiles.get((estimate.effect, estimate.name))) for estimate in several)
            for several in (fit.estimates, fit.given)
        )
        shape = self._shape(causes, state.term)
        found_of_shape = estimates(shape.coordinates, shape.mean, shape.covariance)
        return replace(fit, estimates=parameters + found_of_shape, given=after, posterior=fit.posterior.joined(shape))

    def _shape(self, causes: Causes, term: ActingTerm | None) -> JointPosterior:
        """The shapes of a set's term, by the probabilities of the values tried, between which any is as likely."""
        if term is None or not term.shapes:
            return JointPosterior((), np.zeros(0), np.zeros((0, 0)))
        strengths = [coordinate.name for coordinate in term.coordinates]
        alike = [
            ([float(np.asarray(acting.shapes[name])) for name in term.shapes], self.log_masses[key])
            for key in self._by_causes[causes]
            if key[1] and (acting := self.inference.terms[key[1] - 1].acting) is not None
            if [coordinate.name for coordinate in acting.coordinates] == strengths
        ]
        values, logs = np.array([shape for shape, _ in alike]), np.array([log for _, log in alike])
        shares = np.exp(logs - logsumexp(logs))
        mean = shares @ values
        between = [CATALOGUE[term.effect].parameters[name].searched != "course" for name in term.shapes]
        apart = between * np.array([np.diff(np.unique(column)).min(initial=np.ptp(column)) for column in values.T])
        variance = shares @ (values - mean) ** 2 + np.square(apart) / 12.0
        shapes = tuple(
            Coordinate(term.effect, name, "shape", math.log(value), 1.0, 0.0)
            for name, value in zip(term.shapes, mean.tolist(), strict=True)
        )
        return JointPosterior(shapes, np.log(mean), np.diag(variance / mean**2))

    def selection(self) -> Selection:
        """Return the sets with their probabilities, the likeliest fitted."""
        probabilities = self.probabilities
        listed = [causes for causes in probabilities if causes][:LISTED]
        listed += [causes for causes in credible_set(self.named) if causes and causes not in listed]
        fits = [self.fit(causes) for causes in listed]
        if unlike := self._of_impossible_size(fits):
            return self._without_names(unlike).selection()
        base = self.fit(())
        ruled_out = {fit.causes for fit in fits if not fit.possible}
        total = sum(p for causes, p in probabilities.items() if causes not in ruled_out)
        posterior = {causes: p / total for causes, p in probabilities.items() if causes not in ruled_out}
        nothing = self.log_masses[(), 0] - self._total

        return Selection(
            base,
            tuple(Candidate(fit, fit.log_evidence - base.log_evidence) for fit in fits if fit.possible),
            (),
            self.inference.catalogue,
            posterior,
            self.responses,
            self._families(posterior),
            math.exp(nothing) / total,
            self.not_computed,
            tuple(credible_set(told_together(posterior, self.inference.catalogue))),
        )

    def _of_impossible_size(self, fits: Sequence[CauseFit]) -> set[int]:
        """Numbers of named effects' terms whose size, in the likeliest set that has them, is none of the effect's.

        It is that for which the evidence speaks, too: a fit whose columns change with the size may settle elsewhere.
        """
        verdicts: dict[int, bool] = {}
        for fit in fits:
            one, _ = self._parts(fit.causes)
            term = self.inference.terms[one.term - 1].acting if one.term else None
            if term is None or one.term in verdicts or CATALOGUE[term.effect].tier == "neutral":
                continue
            law, shares = self._part(fit.causes)
            mean, covariance = self._moments(law, one, shares)
            coordinates = self.inference.model.with_term(term).coordinates
            indices = [index for index, coordinate in enumerate(coordinates) if coordinate in term.coordinates]
            weighed = estimates([coordinates[i] for i in indices], mean[indices], covariance[np.ix_(indices, indices)])
            verdicts[one.term] = is_possible(
                [*weighed, *(estimate for estimate in fit.estimates if estimate.effect == term.effect)]
            )
        return {number for number, possible in verdicts.items() if not possible}

    def _without_names(self, numbers: set[int]) -> "LegPosterior":
        """Return the posterior in which some terms are neutral: their size is none of their effect's."""
        inference, named = copy(self.inference), self.inference.terms
        inference.terms = without_a_name(named, numbers)
        masses = dict(self.log_masses)
        for causes, number in self.log_masses:
            if number in numbers:
                price = FURTHER if causes else math.log(inference.catalogue)
                share = inference.terms[number - 1].log_share - named[number - 1].log_share
                masses[causes, number] += price + share
        effects = {named[number - 1].effect for number in numbers}
        beside = {key: mass for key, mass in self.beside_terms.items() if effects.isdisjoint(key[0])}
        return replace(self, inference=inference, masses=masses, beside_terms=beside)

    def _families(self, posterior: Mapping[Causes, float]) -> tuple[tuple[Causes, ...], ...]:
        """Sets that differ in a steady or an oscillating current, where the record does not show whether it turns."""
        by_rest: dict[frozenset[str], list[Causes]] = {}
        for causes in posterior:
            for name in set(causes) & self.inference.uniform_currents:
                by_rest.setdefault(frozenset(causes) - {name}, []).append(causes)
        families = []
        for rest, members in by_rest.items():
            steady = [c for c in members if any(CATALOGUE[n].is_steady_current for n in set(c) - rest)]
            if steady:
                alike = [c for c in members if abs(self._score(c) - self._score(steady[0])) < FURTHER]
                if len(alike) > 1:
                    families.append(tuple(alike))
        return tuple(families)

    def _score(self, causes: Causes) -> float:
        """Log evidence times prior of a set of causes without a smooth error."""
        terms = self.inference.terms
        keys = [k for k in self._by_causes.get(causes, ()) if not k[1] or terms[k[1] - 1].effect]
        return float(logsumexp([self.log_masses[key] for key in keys])) if keys else -math.inf


def _quantiles(values: Array, shares: Array) -> Array:
    """The 5, 50 and 95 % quantiles of weighted values, interpolated between the middles of their shares."""
    order = np.argsort(values)
    weights = shares[order]
    return np.asarray(np.interp((LOWER, 0.5, UPPER), np.cumsum(weights) - 0.5 * weights, values[order]))
