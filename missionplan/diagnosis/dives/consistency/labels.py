"""Labels of weights that look exchanged between dives: a mistake in the log book, and no cause of the catalogue.

The base model is laid against the dives with the labels of two dives exchanged, or of two weights in all dives, again
and again while that helps. Dives are independent given what they share, so that each dive under each label is
linearised once, and every exchange is a sum.
"""

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from scipy.special import logsumexp

from missionplan.diagnosis.dives.fitting import log_joint_with_noise
from missionplan.diagnosis.dives.likelihood import NoiseGridLikelihood
from missionplan.diagnosis.dives.model import DescentModel
from missionplan.diagnosis.inference.model import CauseFit
from missionplan.montecarlo.parallel.mapping import parallel_map

STRONG = 3.0
"""Nats by which an exchange must beat the best set of causes, and each further exchange the one before."""

Labels = tuple[int, ...]
"""Of each dive, the number of its weight."""


@dataclass(frozen=True)
class ExchangedLabels:
    """Labels that explain dives better than any cause."""

    dives: tuple[str, ...]
    """Those whose labels differ from the log book's."""
    weights: tuple[float, ...]
    """Which they would have [N]."""
    log_bayes_factor: float
    """Over the best set of causes, less ln of the number of exchanges tried."""

    def __str__(self) -> str:
        listed = ", ".join(f"{weight:.4g} N in {name}" for name, weight in zip(self.dives, self.weights, strict=True))
        return (
            f"The labels of the weights look exchanged between {', '.join(self.dives)}: with {listed} the mission as "
            f"it stands predicts the dives better than with any cause (log Bayes factor {self.log_bayes_factor:.0f}). "
            "Check the log book before anything else."
        )


def exchanged_labels(model: DescentModel, base: CauseFit, best: CauseFit, jobs: int = 1) -> ExchangedLabels | None:
    """Find exchanged labels that explain the dives clearly better than the best set of causes.

    Only weights of the log book are exchanged: a weight that was never written down is not found.

    Parameters
    ----------
    model : DescentModel
        Of the dives.
    base, best : CauseFit
        The base model, and the best set of causes or the base model again.
    jobs : int
        Processes.
    """
    logs = model.forward.logs
    weights = sorted({log.wet_weight for log in logs})
    own: Labels = tuple(weights.index(log.wet_weight) for log in logs)
    if len(weights) < 2:
        return None
    likelihoods = parallel_map(partial(_labelled, model, base), weights, jobs=jobs)
    found, reached, tried = own, base.log_evidence, 0
    while True:
        others = sorted(set(_exchanges(found)))
        evidence = [_log_evidence(likelihoods, labels, base) for labels in others]
        first = int(np.argmax(evidence))
        tried += len(others)
        if evidence[first] < reached + STRONG:
            break
        found, reached = others[first], evidence[first]
    gain = reached - best.log_evidence - math.log(tried)
    if found == own or gain < STRONG:
        return None
    changed = [dive for dive in range(len(logs)) if found[dive] != own[dive]]
    names = tuple(logs[dive].name for dive in changed)
    return ExchangedLabels(names, tuple(weights[found[dive]] for dive in changed), gain)


def _exchanges(labels: Labels) -> Iterator[Labels]:
    """Labels with those of two dives exchanged, and with two weights exchanged in all dives."""
    for i, j in itertools.combinations(range(len(labels)), 2):
        if labels[i] != labels[j]:
            yield tuple(labels[{i: j, j: i}.get(dive, dive)] for dive in range(len(labels)))
    for a, b in itertools.combinations(sorted(set(labels)), 2):
        yield tuple({a: b, b: a}.get(label, label) for label in labels)


def _labelled(model: DescentModel, base: CauseFit, weights: Sequence[float]) -> list[NoiseGridLikelihood]:
    """Likelihoods of the base model with each weight in all dives."""
    found = []
    for weight in weights:
        logs = tuple(replace(log, wet_weight=weight) for log in model.forward.logs)
        relabelled = replace(model, forward=replace(model.forward, logs=logs))
        (linear,) = relabelled.linearise([((), base.state.linear.at)])
        found.append(relabelled.likelihood(linear))
    return found


def _log_evidence(likelihoods: Sequence[NoiseGridLikelihood], labels: Labels, base: CauseFit) -> float:
    """Log evidence of the base model with each dive under its label."""
    dives = list(enumerate(labels))
    together = NoiseGridLikelihood(
        np.stack([likelihoods[label].grams[:, dive] for dive, label in dives], axis=1),
        np.stack([likelihoods[label].log_determinants[:, dive] for dive, label in dives], axis=1),
        likelihoods[0].counts,
    )
    return float(logsumexp(log_joint_with_noise(together.marginals(base.state.prior_sd))))
