"""Whether dives agree with each other: the labels of their weights, and a claimed cause the same in all.

Exchanged labels are a mistake in the log book, and no cause of the catalogue. The base model is laid against the dives
with the labels of two dives exchanged, or of two weights in all dives, and again while that helps; it competes with
causes and with all else that has no name. Dives are independent given what they share, so that each dive under each
label is linearised once, and every exchange is a sum.
"""

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from scipy.special import logsumexp

from missionplan.diagnosis.dives.fitting import DescentFitting
from missionplan.diagnosis.dives.likelihood import NoiseGridLikelihood
from missionplan.diagnosis.inference.discrepancy import differing_causes
from missionplan.diagnosis.inference.model import CauseFit
from missionplan.diagnosis.inference.selection import FURTHER
from missionplan.results.learned.evidence import Causes

if TYPE_CHECKING:
    from missionplan.diagnosis.dives.model import DescentModel

EXCHANGED = "labels of anchors exchanged between dives in the log book"

Labels = tuple[int, ...]
"""Of each dive, the number of its weight."""


@dataclass(frozen=True)
class ExchangedLabels:
    """The likeliest exchange of labels."""

    dives: tuple[str, ...]
    """Those whose labels differ from the log book's."""
    weights: tuple[float, ...]
    """Which they would have [N]."""
    log_gain: float
    """What the exchanges tried add to the log evidence of the base model, each as likely as the others of its step."""

    def __str__(self) -> str:
        listed = ", ".join(f"{weight:.4g} N in {name}" for name, weight in zip(self.dives, self.weights, strict=True))
        return (
            f"The labels of the weights look exchanged between {', '.join(self.dives)}: with {listed} the mission as "
            f"it stands predicts the dives better than as they are labelled (log Bayes factor {self.log_gain:.0f}). "
            "Check the log book before anything else."
        )


def exchanged_labels(model: DescentFitting, base: CauseFit) -> ExchangedLabels | None:
    """Weigh exchanges of labels beside the base model; None where all dives have one.

    Only weights of the log book are exchanged. An exchange beyond the first costs as much as a further cause.
    """
    logs = model.forward.logs
    weights = sorted({log.wet_weight for log in logs})
    if len(weights) < 2:
        return None
    log_book: Labels = tuple(weights.index(log.wet_weight) for log in logs)
    likelihoods, exchange, reached, prior = _labelled(model, base, weights), log_book, -math.inf, FURTHER
    whole, gains = base.state.likelihood, list[float]()
    while others := sorted(set(_exchanges(exchange)) - {log_book}):
        exchanged = (_changed(whole, likelihoods, labels, log_book) for labels in others)
        evidence = [float(logsumexp(swap.log_joint(base.state.prior_sd))) - base.log_evidence for swap in exchanged]
        first = int(np.argmax(evidence))
        if evidence[first] < reached + FURTHER:
            break
        prior -= math.log(len(others)) + FURTHER
        gains.append(float(logsumexp(evidence)) + prior)
        exchange, reached = others[first], evidence[first]
    changed = [dive for dive in range(len(logs)) if exchange[dive] != log_book[dive]]
    names = tuple(logs[dive].name for dive in changed)
    return ExchangedLabels(names, tuple(weights[exchange[dive]] for dive in changed), float(logsumexp(gains)))


def _exchanges(labels: Labels) -> Iterator[Labels]:
    """Labels with those of two dives exchanged, and with two weights exchanged in all dives."""
    for i, j in itertools.combinations(range(len(labels)), 2):
        if labels[i] != labels[j]:
            yield tuple(labels[{i: j, j: i}.get(dive, dive)] for dive in range(len(labels)))
    for a, b in itertools.combinations(sorted(set(labels)), 2):
        yield tuple({a: b, b: a}.get(label, label) for label in labels)


def _labelled(model: DescentFitting, base: CauseFit, weights: Sequence[float]) -> list[NoiseGridLikelihood]:
    """Likelihoods of the base model with each weight in all dives."""
    likelihoods = []
    for weight in weights:
        logs = tuple(replace(log, wet_weight=weight) for log in model.forward.logs)
        relabelled = replace(model, forward=replace(model.forward, logs=logs))
        (linear,) = relabelled.linearise([((), base.state.linear.at)])
        likelihoods.append(relabelled.likelihood(linear))
    return likelihoods


def _changed(
    whole: NoiseGridLikelihood, likelihoods: Sequence[NoiseGridLikelihood], labels: Labels, log_book: Labels
) -> NoiseGridLikelihood:
    """Likelihood of all dives as of one with other labels, from that with their own, by the dives that change."""
    gram, determinant = whole.grams.copy(), whole.log_determinants.copy()
    for dive, (label, written) in enumerate(zip(labels, log_book, strict=True)):
        if label != written:
            gram[:, 0] += likelihoods[label].grams[:, dive] - likelihoods[written].grams[:, dive]
            determinant[:, 0] += likelihoods[label].log_determinants[:, dive]
            determinant[:, 0] -= likelihoods[written].log_determinants[:, dive]
    return replace(whole, grams=gram, log_determinants=determinant)


def not_constant(model: "DescentModel", fit: CauseFit) -> Causes:
    """Return the causes whose strengths differ from dive to dive.

    A line that jams on its spool in some dives looks like a late clock, but not like the same one in all.
    """
    counts = [len(rows) for rows in model.parts]
    columns = {}
    for name in fit.causes:
        indices = [i for i, c in enumerate(model.coordinates) if c.effect == name and c.kind != "shape"]
        columns[name] = fit.state.linear.columns[:, indices]
    return differing_causes(partial(model.residuals_along, fit), columns, [np.repeat(np.eye(len(counts)), counts, 0)])
