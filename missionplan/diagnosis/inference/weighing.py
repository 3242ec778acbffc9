"""The posterior of a model over all its sets of causes, each of which is linearised about its own best parameters.

Single causes are fitted. What a set of more causes adds is then known from the linearisations of its parts; sets that
may be among the likeliest by that are fitted themselves, and the others count as they are estimated.

What has no name may be beside any set: an effect of the catalogue that only says what the data follow, which is fitted
as the named ones are, or something smooth (Kennedy & O'Hagan 2001, *J. R. Stat. Soc. B* 63). All that has no name has
together the prior of one effect with a name, half of it the effects and half of it what is smooth.
"""

import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Protocol

import numpy as np

from missionplan.arrays import Array
from missionplan.diagnosis.inference.evidence_approximations import SampledEvidence
from missionplan.diagnosis.inference.model import CauseFit, FailedFit, Model, fitted
from missionplan.diagnosis.inference.selection import (
    FURTHER,
    Candidate,
    Selection,
    credible_set,
    log_prior,
    over_responses,
    probabilities,
    told_together,
)
from missionplan.errors import RunError
from missionplan.montecarlo.blocks import parallel_map
from missionplan.results.learned.evidence import Causes, Response

MOST_CAUSES = 3
FITTED_WITHIN = 5.0
"""Nats below the likeliest set within which one of several causes is fitted itself, where its last cause adds any."""
MOST_FITTED = 16
"""Sets of each size that are fitted, at most."""
SAMPLED_WITHIN, MOST_SAMPLED = 4.0, 6
"""Nats below the likeliest within which the evidence is computed by importance sampling, and sets at most."""
ROUNDS = 3
"""Times that sets of the credible set are fitted which were only estimated: others may take their places."""
EFFECTIVE = 10.0
"""Effective draws from which it replaces that of the linearised model: its logarithm is known to a third of a nat."""
MOST_BESIDE = 1
"""Named causes beside an effect without a name, at most."""
BESIDE_RESPONSES = 8
"""Likeliest sets beside which neutral responses are tried, beside nothing and single effects, named or not."""


@dataclass(frozen=True)
class NeutralResponses:
    """Neutral responses beside fits."""

    described: Sequence[tuple[str, str]]
    """Axis of each, and in words."""
    log_gains: Array
    """What each adds to the log evidence of each fit, shape (f, r)."""


class LinearisedModel(Model, Protocol):
    """A model whose sets are fitted one by one, and linearised there."""

    @property
    def untestable(self) -> Mapping[str, str]:
        """None, where every effect can show in such data."""
        return {}

    @property
    def unnamed(self) -> Mapping[str, tuple[str, str]]:
        """Candidates without a name: what each follows, and in words; none, where what has no name is smooth."""
        return {}

    def log_gains(self, fits: Sequence[CauseFit], supersets: Sequence[Sequence[Causes]]) -> list[Array]:
        """Return what further causes add to the log evidence of fits, for the supersets of each; infinite: not known.

        All sets are fitted then.
        """
        return [np.full(len(sets), np.inf) for sets in supersets]

    def all_sets(self, jobs: int = 1) -> Selection:
        """Return all sets of causes with their probabilities."""
        return weigh(self, jobs)

    def responses_beside(self, fits: Sequence[CauseFit]) -> NeutralResponses:
        """Return the neutral responses, by what the first fit leaves open, and their gains beside every fit."""
        ...

    def sampled_evidence(self, fit: CauseFit) -> SampledEvidence:
        """Evidence of a fit's causes by importance sampling."""
        ...


def weigh(model: LinearisedModel, jobs: int = 1) -> Selection:
    """Compute the posterior over all sets.

    Raises RunError when not even the base model can be fitted.
    """
    sets = _Sets(model, jobs)
    for size in range(1, MOST_CAUSES + 1):
        sets.fit(sets.promising(size))
    sets.sample()
    for _ in range(ROUNDS):
        sets.fit([causes for causes in sets.likely() if causes not in sets.fits])
    return sets.selection()


class _Sets:
    """Sets with their log evidence, as far as they have been fitted or estimated."""

    def __init__(self, model: LinearisedModel, jobs: int) -> None:
        self._model, self._jobs = model, jobs
        self.fits: dict[Causes, CauseFit] = {}
        self._failed: list[FailedFit] = []
        self._evidence: dict[Causes, float] = {}
        self._errors: dict[Causes, float] = {}
        self._gained: dict[Causes, float] = {}
        self._nearest: dict[Causes, Causes] = {}
        self._responses: NeutralResponses | None = None
        self._beside: list[Causes] = []
        self._unnamed = model.unnamed
        self._named = len(model.candidates) - len(self._unnamed)
        self.fit([()])
        if () not in self.fits:
            raise RunError(f"the base model cannot be fitted: {self._failed[0].reason}")

    def promising(self, size: int) -> list[Causes]:
        """Sets of a size to be fitted: those that may be among the likeliest."""
        every = [causes for causes in itertools.combinations(self._model.candidates, size) if self._is_possible(causes)]
        if size == 1:
            return every
        self._estimate(every)
        best = max(map(self._score, self._evidence))
        likely = [c for c in every if self._gained[c] > 0.0 and self._score(c) > best - FITTED_WITHIN]
        return sorted(likely, key=lambda causes: -self._score(causes))[:MOST_FITTED]

    def _is_possible(self, causes: Causes) -> bool:
        unnamed = sum(name in self._unnamed for name in causes)
        if unnamed > 1 or (unnamed and len(causes) > 1 + MOST_BESIDE):
            return False
        return not any(len(group & set(causes)) > 1 for group in self._model.alternatives)

    def _has_a_name(self, causes: Causes) -> bool:
        return not any(name in self._unnamed for name in causes)

    def _score(self, causes: Causes) -> float:
        return self._corrected(causes) + self._log_prior(causes)

    def _corrected(self, causes: Causes) -> float:
        """Log evidence."""
        # the linearised evidence of a set is too great by as much as that of its likeliest largest part
        parts = [part for part in self._errors if set(part) <= set(causes)]
        nearest = max(parts, key=lambda part: (len(part), self._evidence[part]), default=None)
        return self._evidence[causes] - (0.0 if nearest is None else self._errors[nearest])

    def _log_prior(self, causes: Causes) -> float:
        prior = log_prior(len(causes), self._named)
        return prior if self._has_a_name(causes) else prior - math.log(2.0 * len(self._unnamed))

    def _estimate(self, sets: Iterable[Causes]) -> None:
        """Estimate sets from each of their parts that were fitted, and take the greatest estimate.

        A part that is wrong alone may lie far from where it is in the set. Sets with an effect without a name are
        estimated from parts that have it: it is in the linearisation of no other.
        """
        by_part: dict[Causes, list[Causes]] = {}
        for causes in sets:
            has_a_name = self._has_a_name(causes)
            for part in [p for p in self.fits if set(p) < set(causes) and self._has_a_name(p) == has_a_name]:
                by_part.setdefault(part, []).append(causes)
        asked = [(self.fits[part], wanted) for part, wanted in by_part.items()]
        all_gains = parallel_map(partial(_log_gains, self._model), asked, jobs=self._jobs)
        estimates: dict[Causes, dict[Causes, float]] = {}
        for (part, wanted), gains in zip(by_part.items(), all_gains, strict=True):
            for causes, gain in zip(wanted, gains.tolist(), strict=True):
                estimates.setdefault(causes, {})[part] = self._evidence[part] + gain
        for causes, from_parts in estimates.items():
            self._nearest[causes] = max(from_parts, key=lambda part: from_parts[part])
            self._evidence[causes] = from_parts[self._nearest[causes]]
            self._gained[causes] = self._evidence[causes] - max(self._evidence[part] for part in from_parts)

    def fit(self, wanted: Sequence[Causes]) -> None:
        """Fit sets."""
        requests = [(causes, self._parts(causes)) for causes in wanted]
        for fit in fitted(self._model, requests, self._jobs):
            self._evidence.pop(fit.causes, None)
            if isinstance(fit, FailedFit):
                self._failed.append(fit)
            elif fit.possible:
                self.fits[fit.causes], self._evidence[fit.causes] = fit, fit.log_evidence

    def _parts(self, causes: Causes) -> list[CauseFit]:
        """Where a fit starts: the part by which the set is likeliest, then causes alone."""
        parts = [part for part in self.fits if set(part) < set(causes)]
        parts.sort(key=lambda part: -self._evidence[part])
        first = [self._nearest[causes]] if causes in self._nearest else parts[:1]
        return [self.fits[part] for part in (*first, *(p for p in parts if len(p) == 1 and p not in first))]

    def sample(self) -> None:
        """Correct the evidence of the likeliest sets by importance sampling, where that is known better.

        A set that was not sampled has the error of the linearisation of its likeliest part that was.
        """
        best = max(map(self._score, self.fits))
        likely = [c for c in sorted(self.fits, key=lambda c: -self._score(c)) if self._score(c) > best - SAMPLED_WITHIN]
        wanted = [self.fits[causes] for causes in likely[:MOST_SAMPLED]]
        for fit, evidence in zip(
            wanted, parallel_map(partial(_sampled, self._model), wanted, jobs=self._jobs), strict=True
        ):
            if evidence.effective >= EFFECTIVE:
                self._errors[fit.causes] = fit.log_evidence - evidence.log_evidence
        ranked = sorted(self.fits, key=lambda causes: -self._score(causes))
        self._beside = [c for i, c in enumerate(ranked) if i < BESIDE_RESPONSES or len(c) < 2]
        self._responses = self._model.responses_beside([self.fits[causes] for causes in self._beside])

    def log_masses(self) -> dict[tuple[Causes, int], float]:
        """Log evidence times prior of every set, beside each response, numbered from 1, or none."""
        masses = {(causes, 0): self._score(causes) for causes in self._evidence}
        if self._responses is None or not self._responses.described:
            return masses
        share = math.log(len(self._responses.described) * (2.0 if self._unnamed else 1.0))
        for causes, gains in zip(self._beside, self._responses.log_gains, strict=True):
            if len(causes) < MOST_CAUSES:
                mass = self._score(causes) - (FURTHER if causes else math.log(self._named)) - share
                masses |= {(causes, r): mass + g for r, g in enumerate(gains.tolist(), start=1)}
        return masses

    def probabilities(self) -> dict[Causes, float]:
        """Probability of each set, with a response or without, greatest first."""
        return over_responses(probabilities(self.log_masses()))

    def likely(self) -> list[Causes]:
        """Sets that hold 95 % of the probability as they are told, which are worth a fit of their own."""
        return credible_set(told_together(self.probabilities(), self._named))

    def selection(self) -> Selection:
        """Return what was found."""
        joint = probabilities(self.log_masses())
        posterior = over_responses(joint)
        ranked = [self.fits[causes] for causes in posterior if causes and causes in self.fits]
        base = self._score(())
        return Selection(
            self.fits[()],
            tuple(Candidate(fit, self._corrected(fit.causes) - base) for fit in ranked),
            tuple(self._failed),
            self._named,
            posterior,
            self._without_a_name(joint),
            nothing=joint[(), 0],
            not_computed=sum(p for causes, p in posterior.items() if causes not in self.fits),
            credible=tuple(credible_set(told_together(posterior, self._named))),
        )

    def _without_a_name(self, joint: Mapping[tuple[Causes, int], float]) -> tuple[Response, ...]:
        """What has no name with its probability: effects and what is smooth, those in the same words together."""
        smooth = self._responses.described if self._responses is not None else ()
        sums = dict.fromkeys([*self._unnamed.values(), *smooth], 0.0)
        for (causes, number), probability in joint.items():
            words = [self._unnamed[name] for name in causes if name in self._unnamed]
            for description in {*words, *([smooth[number - 1]] if number else [])}:
                sums[description] += probability
        return tuple(Response(*words, probability) for words, probability in sums.items())


def _log_gains(model: LinearisedModel, asked: Sequence[tuple[CauseFit, Sequence[Causes]]]) -> list[Array]:
    return model.log_gains([fit for fit, _ in asked], [supersets for _, supersets in asked])


def _sampled(model: LinearisedModel, fits: Sequence[CauseFit]) -> list[SampledEvidence]:
    return [model.sampled_evidence(fit) for fit in fits]
