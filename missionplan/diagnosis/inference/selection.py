"""Sets of causes with their probabilities, and what a posterior over all says: single causes, credible set, rivals."""

import itertools
import math
from collections.abc import Hashable, Mapping
from dataclasses import dataclass, field
from typing import Protocol, TypeVar

import numpy as np
from scipy.special import logsumexp

from missionplan.diagnosis.inference.model import CauseFit, FailedFit, Model
from missionplan.results.learned.evidence import Causes, Response

FURTHER = 3.0
"""Nats of prior that each cause beyond the first costs."""

LIKELY = 0.5
"""Probability from which something is likelier than not."""


def log_prior(count: int, catalogue: int) -> float:
    """Log prior odds of a set of so many causes over none, of a catalogue of so many effects with a name.

    Each single cause has 1/(size of the catalogue), so that the chance of a false claim does not grow with the
    catalogue (Scott & Berger 2010, *Ann. Stat.* 38, on multiplicity), and each further one e⁻³ more.
    """
    return -math.log(catalogue) - FURTHER * (count - 1) if count else 0.0


@dataclass(frozen=True)
class Candidate:
    """A set of causes against the base model."""

    fit: CauseFit
    """The set fitted."""
    log_bayes_factor: float
    """ln evidence over the base model's."""

    @property
    def causes(self) -> Causes:
        """The set."""
        return self.fit.causes

    @property
    def score(self) -> float:
        """Log Bayes factor less the prior's penalty of each cause beyond the first; 0 for the base model."""
        return self.log_bayes_factor - FURTHER * (len(self.causes) - 1) if self.causes else 0.0


@dataclass(frozen=True)
class Selection:
    """All sets, those that are likely fitted."""

    base: CauseFit
    """The base model."""
    ranking: tuple[Candidate, ...]
    """Fitted sets that are possible and not empty, likeliest first."""
    failed: tuple[FailedFit, ...]
    """Sets that could not be fitted, and why."""
    catalogue: int
    """Number of effects in the catalogue."""
    posterior: Mapping[Causes, float] = field(default_factory=lambda: {(): 1.0})
    """Probability of each set."""
    responses: tuple[Response, ...] = ()
    """Neutral responses."""
    families: tuple[tuple[Causes, ...], ...] = ()
    """Sets that differ in nothing that the data show, and that are told as one."""
    nothing: float = 1.0
    """Probability that neither a cause nor a response is there."""
    not_computed: float = 0.0
    """Probability of sets that were not fitted, by estimates."""
    credible: tuple[Causes, ...] = ((),)
    """Sets that hold 95 % of the probability."""

    @property
    def none_of_these(self) -> float:
        """Probability of a neutral response."""
        return min(sum(p for *_, p in self.responses), 1.0)


class WeighsAllSets(Model, Protocol):
    """A model that computes the posterior of all its sets at once."""

    def all_sets(self, jobs: int = 1) -> Selection:
        """Return the sets with their probabilities, by so many processes."""
        ...


CREDIBLE = 0.95

K = TypeVar("K", bound=Hashable)


def probabilities(log_masses: Mapping[K, float]) -> dict[K, float]:
    """Return the probabilities of what has these logarithms of evidence times prior, greatest first."""
    total = float(logsumexp(list(log_masses.values())))
    shares = {key: math.exp(mass - total) for key, mass in log_masses.items()}
    return dict(sorted(shares.items(), key=lambda item: -item[1]))


def over_responses(joint: Mapping[tuple[Causes, int], float]) -> dict[Causes, float]:
    """Return the probability of each set of causes, whatever the response beside it, greatest first."""
    added: dict[Causes, float] = {}
    for (causes, _), probability in joint.items():
        added[causes] = added.get(causes, 0.0) + probability
    return dict(sorted(added.items(), key=lambda item: -item[1]))


def told_together(posterior: Mapping[Causes, float], catalogue: int) -> dict[Causes, float]:
    """Return the probabilities of sets as they are listed, greatest first.

    A set is told with one of its parts where the data speak against the causes that it has beyond that: a Bayes factor
    below 1.
    """
    representative: dict[Causes, Causes] = {}
    sums: dict[Causes, float] = {}
    for causes in sorted(posterior, key=len):
        smaller = (itertools.combinations(causes, size) for size in range(1, len(causes)))
        parts = [part for part in itertools.chain.from_iterable(smaller) if part in posterior]
        prior = math.exp(log_prior(len(causes), catalogue))
        better = [
            part
            for part in parts
            if posterior[causes] * math.exp(log_prior(len(part), catalogue)) < posterior[part] * prior
        ]
        representative[causes] = representative[max(better, key=posterior.__getitem__)] if better else causes
        sums[representative[causes]] = sums.get(representative[causes], 0.0) + posterior[causes]
    return dict(sorted(sums.items(), key=lambda item: -item[1]))


def inclusion(posterior: Mapping[Causes, float]) -> dict[str, float]:
    """Probability of each effect, over all sets that have it."""
    sums: dict[str, float] = {}
    for causes, probability in posterior.items():
        for name in causes:
            sums[name] = sums.get(name, 0.0) + probability
    return sums


def credible_set(posterior: Mapping[Causes, float]) -> list[Causes]:
    """Return the smallest list of sets that holds 95 % of the probability, best first.

    The highest-posterior-density region of a discrete variable (Box & Tiao 1973, *Bayesian Inference in Statistical
    Analysis*).
    """
    chosen: list[Causes] = []
    total = 0.0
    whole = min(sum(posterior.values()), 1.0)
    for causes, probability in sorted(posterior.items(), key=lambda item: -item[1]):
        chosen.append(causes)
        total += probability
        if total >= CREDIBLE * whole:
            break
    return chosen


def rivals(posterior: Mapping[Causes, float], claimed: Causes) -> list[Causes]:
    """Return the other sets within 3 nats of the claimed one, its supersets left out, greatest first."""
    least = posterior.get(claimed, 0.0) * np.exp(-FURTHER)
    others = sorted(posterior.items(), key=lambda item: -item[1])
    return [c for c, p in others if c and c != claimed and p > least and not set(claimed) < set(c)]
