"""The sets of causes of a navigation log: their priors, and the density of the data under each at one noise.

A set is some effects in the mean, and at most two that are random. Given a noise, the model is linear and Gaussian, and
all sets share the inner products of its columns (`inference.set_evidence`). Effects that are not linear are linearised
about the posterior mean of the likeliest set that has them.
"""

import itertools
import math
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.diagnosis.inference.marginal_likelihood import SCALES, GramMatrix, SetPriors, blocks_by_size
from missionplan.diagnosis.inference.selection import FURTHER, log_prior
from missionplan.diagnosis.legs.fitting import TransitFitting
from missionplan.diagnosis.legs.likelihood.hyperparameters import Hyperparameter, values_of
from missionplan.diagnosis.legs.likelihood.linearised import MIN_DOF, JointColumns, LinearisedGroup, TailBound
from missionplan.diagnosis.legs.terms import LegTerm, answers, at_size, refined
from missionplan.effects import CATALOGUE, named_effects
from missionplan.results.learned.evidence import Causes

MOST_IN_MEAN = 3
KEPT_COLUMNS = 2
"""Joint columns of some groups and terms that are kept."""
SETTLING = 3
"""Times that the current to which the vehicle may answer is taken anew."""
RELINEARISED, SETTLED = 4, 0.02
"""Most times that the columns are linearised anew, and change [slabs] below which they are not."""
Result = TypeVar("Result")
Noise = dict[tuple[str, str], float]
"""Logarithms of hyperparameters by effect and name."""


@dataclass(frozen=True)
class MeanSet:
    """A set's effects in the mean with a term, or none."""

    causes: Causes
    term: int = 0
    """Number of the term, from 1; 0 for none."""


@dataclass(frozen=True)
class RandomErrors:
    """Random effects with the hyperparameters of all noise."""

    effects: Causes
    hyperparameters: tuple[Hyperparameter, ...]
    reference: MeanSet
    """Likeliest set, about which heavy tails are bounded."""


class LegInference:
    """Computes the posterior of a model of legs.

    A set may have one of the terms.
    """

    def __init__(self, model: TransitFitting, terms: Sequence[LegTerm], jobs: int = 1) -> None:
        self.model, self._jobs = model, jobs
        self.always: LegTerm | None = None
        infos = [CATALOGUE[name] for name in model.candidates]
        self.in_mean = tuple(info.id for info in infos if info.part == "mean")
        self.random = tuple(info.id for info in infos if info.part == "covariance")
        self.catalogue = len(named_effects("transit"))
        self.uniform_currents = {i.id for i in infos if i.is_steady_current or i.is_modulated}
        self.bent = tuple(name for name in self.in_mean if not CATALOGUE[name].linear)
        subsets = [s for size in range(MOST_IN_MEAN + 1) for s in itertools.combinations(self.in_mean, size)]
        self.sets = tuple(MeanSet(causes) for causes in subsets)
        self._water = np.broadcast_to(model.site_current, (2, model.data.n))
        self._k = len(model.coordinates)
        self._groups: dict[Causes, LinearisedGroup] = {}
        self._take(terms)

    def _take(self, terms: Sequence[LegTerm]) -> None:
        """Take terms in the place of those so far: what is computed of them is forgotten."""
        self.terms = tuple(terms)
        self._sizes = np.array([term.columns.shape[2] for term in terms], dtype=int)
        self._known: dict[tuple[MeanSet, int], tuple[Array, Array]] = {}
        self._priors: dict[tuple[tuple[MeanSet, ...], tuple[int, ...]], SetPriors] = {}
        self._joined: dict[tuple[tuple[Causes, ...], tuple[int, ...]], JointColumns] = {}

    def beside(self, number: int, sets: Sequence[Causes]) -> "LegInference":
        """Return the inference of some sets that have the term of a number, with the neutral terms beside it."""
        result = LegInference(self.model, [term for term in self.terms if term.is_neutral], self._jobs)
        result.always, result.sets, result._water = self.terms[number - 1], tuple(map(MeanSet, sets)), self._water
        result._groups = {group: result._linearised(group, one.about) for group, one in self._groups.items()}
        return result

    def refine(self, law: RandomErrors, levels: Sequence[Array], scores: Array) -> MeanSet:
        """Try more moments about the likeliest of those at which something may change, and take the term at its size.

        Turns of the course are linear in small angles alone: the columns of the likeliest term are then those between
        nil and its size, beside the likeliest set. Returns the likeliest set of all, with its term.

        `levels`: logarithms of noises. `scores`, shape (j, s, 1 + t): of the sets at these.
        """
        level, row, column = np.unravel_index(np.argmax(scores[:, :, 1:]), scores[:, :, 1:].shape)
        best, likeliest = MeanSet(self.sets[row].causes, int(column) + 1), self.terms[column]
        mean = self._posterior_mean(law, levels[int(level)], best)
        terms = [term for term in (*self.terms, *refined(self.model, likeliest)) if term.is_alike(likeliest)]
        terms = [at_size(self.model, term, best.causes, mean[: self._k], mean[self.core :]) for term in terms]
        self._take([*(term for term in self.terms if not term.is_alike(likeliest)), *terms])
        plain = scores[:, :, 0].max(axis=0)
        if plain.max() > scores[level, row, column + 1]:
            return self.sets[int(np.argmax(plain))]
        return MeanSet(best.causes, 1 + next(i for i, term in enumerate(self.terms) if term.key == likeliest.key))

    def at_once(self, task: Callable[[Array], Result], noises: Iterable[Array]) -> list[Result]:
        """Run a task at some noises, `jobs` at once: most of its time is spent where threads do not wait for others."""
        if self._jobs < 2:
            return [task(logs) for logs in noises]
        with ThreadPoolExecutor(self._jobs) as threads:
            return list(threads.map(task, noises))

    # priors

    def log_prior(self, one: MeanSet, law: Causes) -> float:
        """Log prior odds of a set over none, a term with a name counted as a cause, a share of whose prior it has."""
        terms = [term for term in (self.always, self.terms[one.term - 1] if one.term else None) if term is not None]
        named = len(one.causes) + len(law) + sum(not term.is_neutral for term in terms)
        return log_prior(named, self.catalogue) + sum(term.log_share for term in terms)

    def log_priors(self, law: Causes) -> Array:
        """Those of all sets without a term and with each, shape (s, 1 + t); none of a set that is full."""
        plain = np.array([self.log_prior(one, law) for one in self.sets])[:, None]
        shares = np.array([term.log_share for term in self.terms])
        named = np.array([not term.is_neutral for term in self.terms])
        price = np.array([FURTHER if one.causes or law else math.log(self.catalogue) for one in self.sets])[:, None]
        full = np.array([len(one.causes) == MOST_IN_MEAN for one in self.sets])[:, None]
        with_term = plain + shares - price * named
        answer = np.array([term.answers or (self.always is not None and self.always.answers) for term in self.terms])
        nothing_to_answer = ~self._moves_water[:, None] & answer
        return np.concatenate([plain, np.where(full | nothing_to_answer, -np.inf, with_term)], axis=1)

    @cached_property
    def _moves_water(self) -> NDArray[np.bool_]:
        """Whether there is a current under each set, shape (s,)."""
        if np.any(self.model.site_current):
            return np.ones(len(self.sets), dtype=bool)
        return np.array([not self.uniform_currents.isdisjoint(one.causes) for one in self.sets])

    def group(self, one: MeanSet) -> Causes:
        """Effects of a set that are not linear: sets with the same ones share their columns."""
        return tuple(name for name in one.causes if name in self.bent)

    @cached_property
    def core(self) -> int:
        """Number of columns that act beside any term."""
        return int(self.linear(()).columns.shape[2]) - 1

    def prior(self, one: MeanSet, scale: int) -> tuple[Array, Array]:
        """Mean and factor of the prior of a set's coefficients, raw coordinates first."""
        if (one, scale) not in self._known:
            coordinates = self.model.prior(one.causes)
            size = self.core + (self.terms[one.term - 1].columns.shape[2] if one.term else 0)
            mean, factor = np.zeros(size), np.eye(size)
            mean[: self._k] = coordinates.mean
            coordinate_factor = coordinates.factor.copy()
            chosen = [i for name in one.causes for i in self.model.by_effect.get(name, ())]
            coordinate_factor[chosen] *= SCALES[scale]
            factor[: self._k, : self._k] = coordinate_factor
            first = self.core - (self.always.columns.shape[2] if self.always is not None else 0)
            factor[first:, first:] *= SCALES[scale]
            self._known[one, scale] = mean, factor
        return self._known[one, scale]

    def priors(self, sets: Iterable[MeanSet], scales: Iterable[int] = (1,)) -> SetPriors:
        """Priors of sets of one term, of each at some scales of the slabs."""
        key = tuple(sets), tuple(scales)
        if key not in self._priors:
            means, factors = zip(*(self.prior(*pair) for pair in itertools.product(*key)), strict=True)
            self._priors[key] = SetPriors(np.stack(means), np.stack(factors))
        return self._priors[key]

    # likelihood

    def linear(self, group: Causes) -> LinearisedGroup:
        """The linearised model of a group."""
        if group not in self._groups:
            self._groups[group] = self._linearised(group, self.model.expected)
        return self._groups[group]

    def _linearised(self, group: Causes, about: Array) -> LinearisedGroup:
        model = self.model
        linear = model.linearised(group, about, model.given_forms)
        raw = model.columns(about) if group else model.columns_as_expected
        y = model.y - (model.mean_error(about) - model.mean_error(model.expected)) + raw @ about
        always = self._of([] if self.always is None else [self.always])
        columns = [raw, linear.columns[:, :, self._k :], *always, y[:, :, None]]
        return LinearisedGroup(about, linear, np.concatenate(columns, axis=2))

    def _of(self, terms: Iterable[LegTerm]) -> list[Array]:
        return [answers(self.model, term, self._water) if term.answers else term.columns for term in terms]

    def joint(self, groups: tuple[Causes, ...], terms: tuple[int, ...]) -> JointColumns:
        """The columns of some groups and terms; those of the last few are kept."""
        if (groups, terms) not in self._joined:
            while len(self._joined) >= KEPT_COLUMNS:
                del self._joined[next(iter(self._joined))]
            same = [self.model.is_the_same_everywhere(coordinate.effect) for coordinate in self.model.coordinates]
            differ = np.append(~np.array(same, dtype=bool), np.ones(self.core - self._k + 1, dtype=bool))
            linear = {group: self.linear(group) for group in groups}
            further = self._of(self.terms[term - 1] for term in terms)
            self._joined[groups, terms] = JointColumns.of(linear, differ, further)
        return self._joined[groups, terms]

    def grams(
        self, law: RandomErrors, logs: Array, groups: Iterable[Causes], terms: Sequence[int]
    ) -> dict[Causes, GramMatrix]:
        """Inner products under a noise of each group's columns, those of some terms, and the data."""
        joint, values = self.joint(tuple(groups), tuple(terms)), values_of(law.hyperparameters, logs)
        noise, legs = self.model.noise_components(values), self.model._all_legs
        scale, modulation = np.ones(self.core + 1), self.linear(()).linear.prior_sd(values)[self._k :]
        scale[self._k : self._k + len(modulation)] = modulation
        independent = noise.independent(legs.under_way)
        if math.isinf(noise.dof):
            return joint.grams(legs.prediction(independent, noise.fix_sd, noise.process).whitened, scale)
        if noise.dof <= MIN_DOF:
            raise np.linalg.LinAlgError("the variance of the errors does not exist")
        variance = independent + noise.fix_sd**2 * legs.fix_variance()
        bounds = {group: self._bound(law, group, scale, variance, noise.dof) for group in joint.places}
        return joint.heavy_tailed(scale, variance, bounds)

    def _bound(self, law: RandomErrors, group: Causes, scale: Array, variance: Array, dof: float) -> TailBound:
        """Bound of errors with heavy tails, by the likeliest set in the columns of a group."""
        mean, factor = self.prior(law.reference, 1)
        columns = self.linear(group).columns * scale
        term_columns = self._of([self.terms[law.reference.term - 1]] if law.reference.term else [])
        design = np.concatenate([columns[:, :, :-1], *term_columns], axis=2)
        return TailBound.at(columns[:, :, -1] - design @ mean, design @ factor, variance, dof)

    def gram_of(self, law: RandomErrors, logs: Array, one: MeanSet) -> GramMatrix:
        """Inner products under a noise of the columns of a set, those of its term last, and the data."""
        group, terms = self.group(one), [one.term] if one.term else []
        gram = self.grams(law, logs, [group], terms)[group]
        return gram.joined(*self.blocks(terms)[0].tolist()) if terms else gram

    def log_density(self, law: RandomErrors, logs: Array, one: MeanSet) -> float:
        """Log density of the data under a set at one noise."""
        return self.gram_of(law, logs, one).log_density(*self.prior(one, 1))

    def log_densities(self, law: RandomErrors, logs: Array, sets: Sequence[MeanSet], terms: Sequence[int]) -> Array:
        """Log density at one noise under each of some sets without a term, and with each of some, shape (s, 1 + t)."""
        densities = np.empty((len(sets), 1 + len(terms)))
        by_group = grouped(sets, self.group)
        grams = self.grams(law, logs, by_group, terms)
        for group, members in by_group.items():
            densities[members] = self.with_terms([grams[group]], [sets[i] for i in members], terms, (1,))[0, :, 0]
        return densities

    def with_terms(
        self, grams: Sequence[GramMatrix], sets: Sequence[MeanSet], terms: Sequence[int], scales: Sequence[int]
    ) -> Array:
        """Log densities of sets of one group at each noise and scale, without a term and with each, (j, s, c, 1 + t).

        A set that is full has no term.
        """
        densities = np.full((len(grams), len(sets), len(scales), 1 + len(terms)), -np.inf)
        full = [i for i, one in enumerate(sets) if len(one.causes) == MOST_IN_MEAN]
        free = [i for i, one in enumerate(sets) if len(one.causes) < MOST_IN_MEAN]
        for members, beside in ((full, ()), (free, terms)):
            if members:
                priors = self.priors([sets[i] for i in members], scales)
                sds = np.tile([SCALES[scale] for scale in scales], len(members))
                logs = priors.log_densities(grams, self.blocks(beside), sds)
                densities[:, members, :, : 1 + len(beside)] = logs.reshape(len(grams), len(members), len(scales), -1)
        return densities

    def blocks(self, terms: Sequence[int]) -> NDArray[np.int_]:
        """Places of the columns of some terms among theirs, and their numbers, shape (t, 2)."""
        return blocks_by_size(self._sizes[np.array(terms, dtype=int) - 1])

    # search

    def relinearise(self, law: RandomErrors, logs: Array) -> None:
        """Linearise each group anew about the posterior mean of its likeliest set, and terms about the current."""
        slabs = np.array([coordinate.slab for coordinate in self.model.coordinates])
        for _ in range(RELINEARISED):
            moved = 0.0
            scores = self.log_densities(law, logs, self.sets, ())[:, 0] + self.log_priors(law.effects)[:, 0]
            for group, members in grouped(self.sets, self.group).items():
                if not group:
                    continue
                best = self.sets[max(members, key=lambda i: scores[i])]
                about = self._posterior_mean(law, logs, best)[: self._k]
                moved = max(moved, float(np.max(np.abs(about - self.linear(group).about) / slabs)))
                self._groups[group] = self._linearised(group, about)
            self._joined.clear()
            if moved < SETTLED:
                break
        self._settle_current(law, logs)

    def _posterior_mean(self, law: RandomErrors, logs: Array, one: MeanSet) -> Array:
        """Posterior mean of a set's coefficients at one noise, raw coordinates first, those of its term last."""
        return np.asarray(self.priors([one]).posterior([self.gram_of(law, logs, one)])[0][0, 0])

    def _settle_current(self, law: RandomErrors, logs: Array) -> None:
        """Take for the current to which the vehicle answers that of the likeliest set with an answer of any size.

        Along the course and across it the current is then estimated apart, whatever the answer's size.
        """
        free = [i for i, term in enumerate(self.terms, start=1) if term.answers and not term.is_neutral]
        if not free:
            return
        priors = self.log_priors(law.effects)[:, free]
        for _ in range(SETTLING):
            scores = self.log_densities(law, logs, self.sets, free)[:, 1:] + priors
            row, column = np.unravel_index(np.argmax(scores), scores.shape)
            best = MeanSet(self.sets[row].causes, free[column])
            mean = self._posterior_mean(law, logs, best)[: self._k]
            water = self.model.water(best.causes, mean)
            if np.allclose(water, self._water, atol=1e-4):
                break
            self._water = water
            self._joined.clear()


def grouped(items: Sequence[MeanSet], key: Callable[[MeanSet], Causes]) -> dict[Causes, list[int]]:
    """Indices of items by a key."""
    indices: dict[Causes, list[int]] = {}
    for index, item in enumerate(items):
        indices.setdefault(key(item), []).append(index)
    return indices
