"""Model of a navigation log for the diagnosis: fits of sets of causes, the search for likely ones, and predictions."""

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular
from scipy.special import logsumexp

from missionplan.arrays import Array
from missionplan.datasets.records import TransitData
from missionplan.diagnosis.inference.axes import Axis
from missionplan.diagnosis.inference.block_covariance import BlockCovariance, errors_ahead
from missionplan.diagnosis.inference.discrepancy import Residuals
from missionplan.diagnosis.inference.marginal_likelihood import QUANTILE_95, Normal
from missionplan.diagnosis.inference.model import CauseFit, FailedFit, FitRequest, HeldOutScore
from missionplan.diagnosis.inference.selection import Selection
from missionplan.diagnosis.legs.designs import DESIGNS, designs_for, with_further_legs
from missionplan.diagnosis.legs.fitting import TransitFitting
from missionplan.diagnosis.legs.likelihood.covariance import ALL_LEGS
from missionplan.diagnosis.legs.likelihood.linearised import LinearisedLegs
from missionplan.diagnosis.legs.likelihood.modulation import SHORTEST, Forms
from missionplan.diagnosis.legs.noise_integration import ComparedSets, NoiseSearch
from missionplan.diagnosis.legs.posterior import LegPosterior
from missionplan.diagnosis.legs.set_density import MOST_IN_MEAN, LegInference, MeanSet
from missionplan.diagnosis.legs.smooth_axes import transit_axes
from missionplan.diagnosis.legs.terms import terms_of
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
    noise = plain.at(plain.likeliest(top, plain.at(best)))
    for laws in laws_of(inference.random):
        highest = max(comparison.best for comparison in searches.values())
        for law in laws:
            if len(law) > 1 and all(searches[name,].best <= highest - WORTH_PAIRING for name in law):
                continue
            search = NoiseSearch(inference, law, top)
            searches[law] = search.compared(search.likeliest(nothing, plain.at(first)), search.likeliest(top, noise))
    highest = max(comparison.best for comparison in searches.values())
    whole = float(logsumexp([logsumexp(comparison.scores) for comparison in searches.values()]))
    integrated, left = [], np.zeros(1 + len(inference.terms))
    for comparison in searches.values():
        # which sets are integrated, without a term and with which: the likely ones, and parts without their term
        least = np.full(comparison.scores.shape[1], highest - KEPT_WITH_TERM)
        least[0] = highest - KEPT
        chosen = comparison.scores > least
        chosen[:, 0] |= chosen.any(axis=1)
        if not comparison.search.effects:
            chosen[inference.sets.index(MeanSet(())), 0] = True
        chosen = np.asarray(chosen)
        left += np.sum(np.where(chosen, 0.0, np.exp(comparison.scores - whole)), axis=0)
        if chosen.any():
            integrated.append(comparison.integrated(chosen))
    return LegPosterior(inference, tuple(integrated), left)


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
    sets = {one for one, term in named if term == number}
    in_mean = {tuple(name for name in one if name not in inference.random) for one in sets}
    beside = inference.beside(number, sorted({(), *in_mean}))
    top, log_masses = MeanSet(tuple(name for name in causes if name not in law)), dict(posterior.beside_terms)
    for random in dict.fromkeys([(), law]):
        search = NoiseSearch(beside, random, top)
        noise = search.likeliest(top)
        compared = search.compared(noise, noise)
        chosen = compared.scores > max(compared.best, named[causes, number]) - KEPT_WITH_TERM
        chosen[:, 0] = chosen[:, 1:].any(axis=1)
        for (one, term), mass in compared.integrated(chosen).masses().items() if chosen.any() else ():
            regular = posterior.in_order((*one.causes, *random))
            if term and regular in sets:
                words = beside.terms[term - 1].axis, beside.terms[term - 1].description
                key = posterior.in_order((*regular, effect)), words
                log_masses[key] = float(np.logaddexp(log_masses.get(key, -np.inf), mass))
    return replace(posterior, beside_terms=log_masses)


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
    mission_effects = {prior.effect for prior in model.given}
    names = [name for name in model.candidates if CATALOGUE[name].is_modulated and name not in mission_effects]
    if not names or float(np.ptp(model.data.middle)) < SHORTEST:
        return []
    likely = [causes for causes in posterior.named if set(causes) <= set(model.candidates)][:BESIDE]
    order = {name: index for index, name in enumerate(model.candidates)}
    sets = {tuple(sorted({*causes, name}, key=order.__getitem__)) for causes in [(), *likely] for name in names}
    return sorted(sets)


ALTERNATIVES = exclusive_groups("transit")
"""Effects of which a set holds at most one: each describes how the errors are random."""


@dataclass(frozen=True)
class TransitModel(TransitFitting):
    """Base model of a mission's transit with every cause that the record could show."""

    @property
    def alternatives(self) -> Sequence[frozenset[str]]:
        """Groups of effects of which a set holds at most one."""
        return ALTERNATIVES

    def fit_all(self, wanted: Sequence[FitRequest]) -> list[CauseFit | FailedFit]:
        """Fit several sets of causes; one that cannot be fitted says why."""
        fits: list[CauseFit | FailedFit] = []
        for causes, near in wanted:
            try:
                fits.append(self.fit(causes, near))
            except np.linalg.LinAlgError as error:
                fits.append(FailedFit(causes, str(error)))
        return fits

    def all_sets(self, jobs: int = 1) -> Selection:
        """Return all sets of causes with their probabilities."""
        return with_forms(beside_terms(infer(LegInference(self, terms_of(self), jobs)))).selection()

    def residuals(self, fit: CauseFit) -> Residuals:
        """Velocity errors leg by leg (first axis, second axis, next leg) and their covariance under a fit."""
        return self.residuals_along(fit, transit_axes(self.data, self.leg, self.axes))

    def residuals_along(self, fit: CauseFit, axes: Sequence[Axis]) -> Residuals:
        """Return the residuals with other axes to look along."""
        series, groups = np.tile([0, 1], self.data.n), np.repeat(self.data.labels, 2)
        covariance = self.error_covariance(fit, fit.state.linear)
        return Residuals(leg_by_leg(fit.state.linear.y), covariance, series, axes, groups)

    def error_covariance(self, fit: CauseFit, linear: LinearisedLegs) -> BlockCovariance:
        """Covariance of errors leg by leg under a fit's noise and the coefficients' priors: axes are independent."""
        values = fit.state.values
        noise, both = self.noise(values), 2 * np.arange(self.data.n)
        columns = linear.columns * linear.prior_sd(values)
        return BlockCovariance((both, both + 1), (noise[0], noise[1]), leg_by_leg(columns))

    def predicted(self, fit: CauseFit, seen: NDArray[np.int_], wanted: NDArray[np.int_]) -> Normal:
        """Predict legs from others under a fit, by the precision of all of them (Rue & Held 2005, Theorem 2.5).

        `fit`: hyperparameters to use: those of a fit to the legs seen, or of an earlier part of them. `seen`, `wanted`:
        the legs seen and the m legs predicted.

        Returns
        -------
        tuple of array
            Mean, shape (2, m), and covariance, shape (2m, 2m), leg by leg, of the velocity errors beyond the base
            model's mean [m/s].
        """
        linear, noise = fit.state.linear, self.noise_components(fit.state.values)
        rows = np.union1d(seen, wanted)
        legs, places = self.markov_covariance(rows), np.searchsorted(rows, wanted)
        ones = np.zeros((2, len(rows), 2 * len(places)))
        for axis in (0, 1):
            ones[axis, places, 2 * np.arange(len(places)) + axis] = 1.0
        columns = linear.columns[:, rows] * linear.prior_sd(fit.state.values)
        joined = np.concatenate([columns, ones, linear.y[:, rows, None]], axis=2)
        gram, _ = legs.gram(joined, noise.independent(legs.under_way), noise.fix_sd, noise.process)
        k = columns.shape[2]
        factor = np.linalg.cholesky(gram[:k, :k] + np.eye(k))
        half = solve_triangular(factor, gram[:k, k:], lower=True, check_finite=False)
        precision = gram[k:, k:] - half.T @ half
        covariance = np.asarray(np.linalg.inv(precision[:-1, :-1]), dtype=float)
        return self.y[:, wanted] - (covariance @ precision[:-1, -1]).reshape(-1, 2).T, covariance

    def one_step_errors(self, fit: CauseFit) -> Array:
        """Error of each leg's prediction from the legs before it, on the principal axes, shape (2, n) [m/s]."""
        linear, values, legs = fit.state.linear, fit.state.values, self._all_legs
        noise = self.noise_components(values)
        prediction = legs.prediction(noise.independent(legs.under_way), noise.fix_sd, noise.process)
        joined = linear.joined * np.append(linear.prior_sd(values), 1.0)
        sd = np.sqrt(prediction.variance)
        white = leg_by_leg(prediction.whitened(joined).ahead / sd[:, :, None])
        return sd * errors_ahead(white[:, :-1], white[:, -1], 2).reshape(-1, 2).T

    def blocks(self) -> list[NDArray[np.int_]]:
        """Blocks of consecutive legs to hold out: neighbours' errors are correlated (Roberts et al. 2017)."""
        count = int(np.clip(self.data.n // 5, 4, 8))
        return [np.asarray(block) for block in np.array_split(np.arange(self.data.n), count)]

    def held_out(self, fits: Sequence[CauseFit]) -> list[list[HeldOutScore]]:
        """Predict each block of legs from the others, with hyperparameters fitted to the others alone."""
        return [[self._block_score(fit, block) for block in self.blocks()] for fit in fits]

    def last_part_ahead(self, fit: CauseFit) -> HeldOutScore:
        """Predict the last third of the legs, all the way, with a fit to those before."""
        return self._block_score(fit, np.arange(self.data.n - self.data.n // 3, self.data.n))

    def _block_score(self, fit: CauseFit, block: NDArray[np.int_]) -> HeldOutScore:
        others = np.setdiff1d(np.arange(self.data.n), block)
        trained, model = self.refitted(fit, others), self.with_term(fit.state.term)
        state = trained.state
        whole, seen = (
            model.marginal(state.hyperparameters, state.posterior.mode, state.linear, rows)
            for rows in (ALL_LEGS, others)
        )
        log_score = whole.log_density - seen.log_density
        mean, covariance = model.predicted(trained, others, block)
        error = leg_by_leg(self.y[:, block] - mean)
        off = error * np.repeat(self.data.weight[block], 2)
        standardised = error / np.sqrt(np.diag(covariance))
        name = f"legs {self.data.labels[block[0]]} to {self.data.labels[block[-1]]}"
        inside = int((np.abs(standardised) <= QUANTILE_95).sum())
        return HeldOutScore(name, log_score, float(off @ off), inside, error.size, tuple(standardised.tolist()))

    @property
    def designs(self) -> Sequence[str]:
        """Further legs, in words, cheapest first."""
        return [DESIGNS[index] for index in designs_for(self.data)]

    def discrimination(self, first: CauseFit, second: CauseFit, entry: int | None) -> float:
        """Expected log Bayes factor of the first fit over the second, were the first true.

        `first`, `second`: fits to compare. `entry`: of `designs`, added to the log; None for the log alone.
        """
        model = self if entry is None else self.of_longer(with_further_legs(self.data, designs_for(self.data)[entry]))
        acting = model.with_term(first.state.term)
        mask = np.array([coordinate.effect in first.causes for coordinate in acting.coordinates])
        signal = acting.columns_at(first) @ np.where(mask, first.state.mean - acting.expected, 0.0)
        truth = model.error_covariance(first, model.linearised(()))
        entropies = []
        for fit in (first, second):
            acting = model.with_term(fit.state.term)
            linear = acting.linearised(fit.causes, fit.state.linear.about, fit.state.forms)
            usual = acting.columns_at(fit) @ (linear.prior.mean - acting.expected)
            covariance = acting.error_covariance(fit, linear)
            entropies.append(covariance.cross_entropy(truth, leg_by_leg(signal - usual)))
        return max(entropies[1] - entropies[0], 0.0)

    def columns_at(self, fit: CauseFit) -> Array:
        """Columns of the coordinates, where a term has to be linearised about a fit as this has it, shape (2, n, k)."""
        return self.columns_as_expected if self.acting is None else self.columns(fit.state.linear.about)

    def of_longer(self, data: TransitData) -> "TransitModel":
        """Return the model of the log with further legs after it."""
        added = np.repeat(self.base.mean(axis=1, keepdims=True), data.n - self.data.n, axis=1)
        current = np.broadcast_to(self.site_current, (2, self.data.n))
        current = np.concatenate(
            [current, np.repeat(current.mean(axis=1, keepdims=True), added.shape[1], axis=1)], axis=1
        )
        base = np.concatenate([self.base, added], axis=1)
        return replace(self, data=data, base=base, site_current=current, only=self.with_term(None).coordinates)


def leg_by_leg(values: Array) -> Array:
    """Values on both axes, shape (2, n, …), leg by leg: (2n, …)."""
    return values.swapaxes(0, 1).reshape(-1, *values.shape[2:])
