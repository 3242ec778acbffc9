"""The sets of causes of a navigation log: their priors, and the density of the data under each at one noise.

A set is some effects in the mean, and at most two that are random. Given a noise, the model is linear and Gaussian, and
all sets share the inner products of its columns (`inference.set_evidence`). Effects that are not linear are linearised
about the posterior mean of the likeliest set that has them.
"""

import itertools
import math
from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammaln

from missionplan.arrays import Array
from missionplan.diagnosis.inference.marginal_likelihood import student_marginal
from missionplan.diagnosis.inference.selection import log_prior
from missionplan.diagnosis.inference.set_evidence import SCALES, GramMatrix, SetPriors
from missionplan.diagnosis.legs.fitting import TransitFitting
from missionplan.diagnosis.legs.likelihood.hyperparameters import Hyperparameter, values_of
from missionplan.diagnosis.legs.likelihood.linearised import LinearisedLegs
from missionplan.diagnosis.legs.likelihood.selected_legs import MIN_DOF
from missionplan.diagnosis.legs.responses import Response
from missionplan.effects import CATALOGUE, effects_of
from missionplan.results.learned.evidence import Causes

MOST_IN_MEAN = 3
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
class RandomErrors:
    """Random effects with the hyperparameters of all noise.

    Attributes
    ----------
    effects : tuple of str
    hyperparameters : tuple of Hyperparameter
    reference : MeanSet
        Likeliest set, about which heavy tails are bounded.
    """

    effects: Causes
    hyperparameters: tuple[Hyperparameter, ...]
    reference: MeanSet


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
        """Log prior odds of a set over none, a response counted as a cause."""
        shared = math.log(len(self.responses)) if one.response else 0.0
        return log_prior(len(one.causes) + len(law) + (one.response > 0), self.catalogue) - shared

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

    def gram(self, law: RandomErrors, logs: Array, group: Causes, responses: Collection[int]) -> GramMatrix:
        """Inner products of a group's columns under a noise, those of other responses nil."""
        full = self.linear(group).joined.shape[2]
        acting = np.unique(np.concatenate([self.places(number) for number in {0, law.reference.response, *responses}]))
        kept = np.append(acting, full - 1)
        small = self._gram(law, logs, group, kept)
        products = np.zeros((full, full))
        products[np.ix_(kept, kept)] = small.products
        return GramMatrix(products, small.log_normaliser)

    def _gram(self, law: RandomErrors, logs: Array, group: Causes, kept: NDArray[np.int_]) -> GramMatrix:
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

    def log_densities(self, law: RandomErrors, logs: Array, sets: Sequence[MeanSet], scale: int) -> Array:
        """Log density of the data under each of some sets at one noise, shape (s,)."""
        found = np.full(len(sets), -np.inf)
        for group, members in grouped(sets, self.group).items():
            gram = self.gram(law, logs, group, {sets[i].response for i in members})
            for response, own in grouped([sets[i] for i in members], lambda one: one.response).items():
                places = [members[i] for i in own]
                part = gram.part(self.places(response))
                priors = self.priors([sets[i] for i in places], scale)
                found[places] = priors.log_densities([part])[0] if len(places) > 1 else priors.log_density(part)
        return found

    # search

    def relinearise(self, law: RandomErrors, logs: Array) -> None:
        """Linearise each group anew about the posterior mean of its likeliest set."""
        slabs = np.array([coordinate.slab for coordinate in self.model.coordinates])
        plain = [one for one in self.sets if not one.response]
        for _ in range(RELINEARISED):
            moved = 0.0
            scores = self.log_densities(law, logs, plain, 1) + [self.log_prior(one, law.effects) for one in plain]
            for group, members in grouped(plain, self.group).items():
                if not group:
                    continue
                best = plain[max(members, key=lambda i: scores[i])]
                mean, _ = self.priors([best], 1).posterior([self.gram(law, logs, group, ()).part(self.places(0))])
                about = mean[0, 0, : self._k]
                moved = max(moved, float(np.max(np.abs(about - self.linear(group).about) / slabs)))
                self._groups[group] = self._linearised(group, about)
            if moved < SETTLED:
                break


def grouped(items: Sequence[MeanSet], key: Callable[[MeanSet], K]) -> dict[K, list[int]]:
    """Indices of items by a key."""
    found: dict[K, list[int]] = {}
    for index, item in enumerate(items):
        found.setdefault(key(item), []).append(index)
    return found
