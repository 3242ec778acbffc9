"""Posterior probabilities of the sets of causes, the credible set, and rivals of a claimed set."""

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from missionplan.diagnosis.inference.selection import COMPLEXITY_PENALTY, Candidate, Selection
from missionplan.results.learned.evidence import Causes

CREDIBLE = 0.95

LogBayesFactors = Mapping[Causes, float]
"""Of sets whose evidence was checked by importance sampling: they replace those of the linearised models."""


def _score(candidate: Candidate, checked: LogBayesFactors) -> float:
    own = checked.get(candidate.causes)
    return candidate.score if own is None else candidate.score + own - candidate.log_bayes_factor


def posteriors(selection: Selection, checked: LogBayesFactors = MappingProxyType({})) -> dict[Causes, float]:
    """Return the posterior probability of each set, the empty one and supersets included, greatest first.

    Prior odds times Bayes factor, normalised (Kass & Raftery 1995, *J. Am. Stat. Assoc.* 90). Each non-empty set has
    prior 1/(size of the catalogue) relative to the empty set, so that the chance of a false claim does not grow with
    the catalogue (Scott & Berger 2010, *Ann. Stat.* 38, on multiplicity), and a factor exp(−3) for each cause beyond
    the first.
    """
    if selection.posterior:
        return dict(selection.posterior)
    logs = np.array([0.0] + [_score(one, checked) - np.log(selection.catalogue) for one in selection.ranking])
    weights = np.exp(logs - logs.max())
    weights /= weights.sum()
    found = dict(zip([(), *(one.causes for one in selection.ranking)], weights.tolist(), strict=True))
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
    for causes, probability in sorted(posterior.items(), key=lambda item: -item[1]):
        chosen.append(causes)
        total += probability
        if total >= CREDIBLE:
            break
    return chosen


def rivals(posterior: Mapping[Causes, float], claimed: Causes) -> list[Causes]:
    """Return the other sets within 3 nats of the claimed one, its supersets left out, greatest first."""
    least = posterior.get(claimed, 0.0) * np.exp(-COMPLEXITY_PENALTY)
    others = sorted(posterior.items(), key=lambda item: -item[1])
    return [c for c, p in others if c and c != claimed and p > least and not set(claimed) < set(c)]
