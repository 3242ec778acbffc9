"""What a posterior over sets of causes says: of single causes, the credible set, and rivals of a claimed set."""

import math
from collections.abc import Hashable, Mapping
from typing import TypeVar

import numpy as np
from scipy.special import logsumexp

from missionplan.diagnosis.inference.selection import FURTHER
from missionplan.results.learned.evidence import Causes

CREDIBLE = 0.95

K = TypeVar("K", bound=Hashable)


def probabilities(log_masses: Mapping[K, float]) -> dict[K, float]:
    """Return the probabilities of what has these logarithms of evidence times prior, greatest first."""
    total = float(logsumexp(list(log_masses.values())))
    found = {key: math.exp(mass - total) for key, mass in log_masses.items()}
    return dict(sorted(found.items(), key=lambda item: -item[1]))


def over_responses(found: Mapping[tuple[Causes, int], float]) -> dict[Causes, float]:
    """Return the probability of each set of causes, whatever the response beside it, greatest first."""
    added: dict[Causes, float] = {}
    for (causes, _), probability in found.items():
        added[causes] = added.get(causes, 0.0) + probability
    return dict(sorted(added.items(), key=lambda item: -item[1]))


def told_together(posterior: Mapping[Causes, float]) -> dict[Causes, float]:
    """Return the probabilities of sets as they are listed, greatest first.

    A set is told with one of its parts where the data do not speak for the causes that it has beyond that: it is then
    less likely by more than the 3 nats that the prior charges for them.
    """
    found: dict[Causes, float] = {}
    for causes, probability in posterior.items():
        parts = [other for other in posterior if other and set(other) < set(causes)]
        likeliest = max(parts, key=lambda part: posterior[part], default=causes)
        told = likeliest if probability < posterior[likeliest] * math.exp(-FURTHER) else causes
        found[told] = found.get(told, 0.0) + probability
    return dict(sorted(found.items(), key=lambda item: -item[1]))


def inclusion(posterior: Mapping[Causes, float]) -> dict[str, float]:
    """Probability of each effect, over all sets that have it."""
    found: dict[str, float] = {}
    for causes, probability in posterior.items():
        for name in causes:
            found[name] = found.get(name, 0.0) + probability
    return found


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
