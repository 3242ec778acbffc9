"""The search for the likely sets of causes of a navigation log, for their noise, and for what may be beside them."""

import itertools
import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp

from missionplan.diagnosis.legs.likelihood.modulation import SHORTEST, Forms
from missionplan.diagnosis.legs.noise_integration import ComparedSets, NoiseSearch
from missionplan.diagnosis.legs.posterior import LegPosterior
from missionplan.diagnosis.legs.set_density import MOST_IN_MEAN, LegInference, MeanSet
from missionplan.effects import CATALOGUE, exclusive_groups
from missionplan.results.learned.evidence import Causes

KEPT, KEPT_WITH_TERM = 12.0, 9.0
"""Nats below the likeliest set within which a set is integrated, and one with a term; the others are stated."""
BESIDE = 3
"""Likeliest sets beside which oscillations that need not be steady are tried."""
WORTH_PAIRING = 3.0
"""Nats below the likeliest within which a random effect is tried together with another."""
LEAST_LIKELY = 0.05
"""Probability of a term with a name from which it is looked for what may be beside it."""


def laws_of(random: Causes) -> tuple[list[Causes], list[Causes]]:
    """Return single random effects, and pairs that describe different errors."""
    groups = exclusive_groups("transit")
    pairs: list[Causes] = [p for p in itertools.combinations(random, 2) if not any(len(g & set(p)) > 1 for g in groups)]
    return [(name,) for name in random], pairs


def infer(inference: LegInference) -> LegPosterior:
    """Compute the posterior."""
    nothing, rich = MeanSet(()), MeanSet(inference.in_mean)
    plain = NoiseSearch(inference, (), nothing)
    first = plain.likeliest(nothing)
    full = plain.likeliest(rich, plain.at(first))
    inference.relinearise(plain.errors, full.mode)
    levels = plain.levels(first, full)
    best = plain.likeliest(inference.refine(plain.errors, levels, plain.scores(levels)), plain.at(full))
    searches: dict[Causes, ComparedSets] = {(): plain.compared(first, best)}
    top = searches[()].top
    known = plain.at(plain.likeliest(top, plain.at(best)))
    for laws in laws_of(inference.random):
        highest = max(each.best for each in searches.values())
        for law in laws:
            if len(law) > 1 and all(searches[name,].best <= highest - WORTH_PAIRING for name in law):
                continue
            search = NoiseSearch(inference, law, top)
            searches[law] = search.compared(search.likeliest(nothing, plain.at(first)), search.likeliest(top, known))
    highest = max(each.best for each in searches.values())
    whole = float(logsumexp([logsumexp(each.scores) for each in searches.values()]))
    integrated, left = [], np.zeros(1 + len(inference.terms))
    for each in searches.values():
        chosen = _chosen(inference, each, highest)
        left += np.sum(np.where(chosen, 0.0, np.exp(each.scores - whole)), axis=0)
        if chosen.any():
            integrated.append(each.integrated(chosen))
    return LegPosterior(inference, tuple(integrated), left)


def _chosen(inference: LegInference, compared: ComparedSets, best: float) -> NDArray[np.bool_]:
    """Which sets are integrated, without a term and with which: the likely ones, and parts without their term."""
    least = np.full(compared.scores.shape[1], best - KEPT_WITH_TERM)
    least[0] = best - KEPT
    chosen = compared.scores > least
    chosen[:, 0] |= chosen.any(axis=1)
    if not compared.search.effects:
        chosen[inference.sets.index(MeanSet(())), 0] = True
    return np.asarray(chosen)


def beside_terms(posterior: LegPosterior) -> LegPosterior:
    """Weigh neutral terms beside the likeliest term with a name, where that is likely, and its random effects.

    A set has one term, so that beside a named effect which acts by one there would be nothing without a name.
    """
    inference, masses = posterior.inference, posterior.log_masses
    named = {key: mass for key, mass in masses.items() if key[1] and not inference.terms[key[1] - 1].is_neutral}
    whole = float(logsumexp(list(masses.values())))
    if not named or float(logsumexp(list(named.values()))) - whole < math.log(LEAST_LIKELY):
        return posterior
    causes, number = max(named, key=lambda key: named[key])
    effect, law = inference.terms[number - 1].effect, tuple(name for name in causes if name in inference.random)
    known = {one for one, term in named if term == number}
    in_mean = {tuple(name for name in one if name not in inference.random) for one in known}
    beside = inference.beside(number, sorted({(), *in_mean}))
    top, found = MeanSet(tuple(name for name in causes if name not in law)), dict(posterior.beside_terms)
    for random in dict.fromkeys([(), law]):
        search = NoiseSearch(beside, random, top)
        noise = search.likeliest(top)
        compared = search.compared(noise, noise)
        chosen = compared.scores > max(compared.best, named[causes, number]) - KEPT_WITH_TERM
        chosen[:, 0] = chosen[:, 1:].any(axis=1)
        for (one, term), mass in compared.integrated(chosen).masses().items() if chosen.any() else ():
            regular = posterior.in_order((*one.causes, *random))
            if term and regular in known:
                words = beside.terms[term - 1].axis, beside.terms[term - 1].description
                own = posterior.in_order((*regular, effect)), words
                found[own] = float(np.logaddexp(found.get(own, -np.inf), mass))
    return replace(posterior, beside_terms=found)


def with_forms(posterior: LegPosterior) -> LegPosterior:
    """Weigh oscillations that need not be steady, in records long enough to show them."""
    masses, forms = dict(posterior.log_masses), {}
    for causes in _modulated_sets(posterior):
        law = tuple(name for name in causes if name in posterior.inference.random)
        mean = MeanSet(tuple(name for name in causes if name not in law))
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
    likely = [causes for causes in posterior.named if set(causes) <= set(model.candidates)][:BESIDE]
    order = {name: index for index, name in enumerate(model.candidates)}
    found = {tuple(sorted({*causes, name}, key=order.__getitem__)) for causes in [(), *likely] for name in names}
    return sorted(found)
