"""Selection of causes: sets of one, two or three effects searched by evidence, physically impossible ones left out.

A set's evidence is its marginal likelihood, which by itself penalises parameters that the data do not need (MacKay
2003, *Information Theory, Inference, and Learning Algorithms*, chapter 28); sets are compared by Bayes factors (Kass &
Raftery 1995, *J. Am. Stat. Assoc.* 90). Not all sets are fitted: a beam search extends the best sets by one cause at a
time, and discards sets that are far less probable than the best or no better than a part of themselves, as Occam's
window does (Madigan & Raftery 1994, *J. Am. Stat. Assoc.* 89).
"""

import itertools
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol, cast, runtime_checkable

import numpy as np

from missionplan.diagnosis.inference.fitting import fitted
from missionplan.diagnosis.inference.model import CauseFit, FailedFit, Model, SearchedModel
from missionplan.errors import RunError
from missionplan.results.learned.evidence import Causes

COMPLEXITY_PENALTY = 3.0
"""Nats that each cause beyond the first must add: "strong" evidence, 20 to 1, on the scale of Kass & Raftery (1995,
section 3.2)."""
PRUNE_BELOW = -4.0
"""Nats of estimated gain below which a further cause is not fitted."""
BEAM = 3
"""Sets of each size that are extended."""
EXTRA_PAIRS = 8
"""Pairs outside the beam that are fitted as well, by their estimated gain."""
MOST_CAUSES = 3

Progress = Callable[[str, int, int], None]
"""Called with what is being done, how many of how many."""

Extension = tuple[Causes, CauseFit]
"""A set to fit, and the fit that it extends by a cause."""


@runtime_checkable
class WeighsAllSets(Protocol):
    """A model that computes the posterior of all its sets at once."""

    def all_sets(self) -> "Selection":
        """Return the sets with their probabilities."""
        ...


def no_progress(what: str, done: int, of: int) -> None:
    """Report no progress."""


@dataclass(frozen=True)
class Candidate:
    """A set of causes against the base model.

    Attributes
    ----------
    fit : CauseFit
        The set fitted.
    log_bayes_factor : float
        ln evidence over the base model's.
    """

    fit: CauseFit
    log_bayes_factor: float

    @property
    def causes(self) -> Causes:
        """The set."""
        return self.fit.causes

    @property
    def score(self) -> float:
        """Log Bayes factor less the penalty of each cause beyond the first; 0 for the base model."""
        return self.log_bayes_factor - COMPLEXITY_PENALTY * (len(self.causes) - 1) if self.causes else 0.0


@dataclass(frozen=True)
class Selection:
    """Every set that was tried.

    Attributes
    ----------
    base : CauseFit
        The base model.
    ranking : tuple of Candidate
        Possible non-empty sets, best score first.
    impossible : tuple of Candidate
        Sets whose best fit is not possible (`CauseFit.possible`).
    failed : tuple of FailedFit
        Sets that could not be fitted, and why.
    catalogue : int
        Number of effects in the catalogue.
    posterior : mapping
        Probability of each set; empty where that is left to `inference.posterior.posteriors`.
    responses : tuple
        Neutral responses by axis and in words, with their probabilities.
    families : tuple
        Sets that differ in nothing that the data show, and that are told as one.
    nothing : float or None
        Probability that neither a cause nor a response is there; None: that of the empty set.
    not_computed : float
        Estimate of the probability of sets that were not computed.
    credible : tuple
        Sets that hold 95 % of the probability; empty where that is left to `inference.posterior.credible_set`.
    """

    base: CauseFit
    ranking: tuple[Candidate, ...]
    impossible: tuple[Candidate, ...]
    failed: tuple[FailedFit, ...]
    catalogue: int
    posterior: Mapping[Causes, float] = field(default_factory=dict)
    responses: tuple[tuple[str, str, float], ...] = ()
    families: tuple[tuple[Causes, ...], ...] = ()
    nothing: float | None = None
    not_computed: float = 0.0
    credible: tuple[Causes, ...] = ()

    @property
    def none_of_these(self) -> float | None:
        """Probability of a neutral response; None where none was in the model."""
        return min(sum(p for *_, p in self.responses), 1.0) if self.responses else None


def select(model: Model, progress: Progress = no_progress, jobs: int = 1, *, search: bool = True) -> Selection:
    """Fit the base model, every cause alone, and pairs and triples about the best.

    Parameters
    ----------
    model : Model
        Model of the data.
    progress : callable
        Called with what is being done.
    jobs : int
        Processes that fit.
    search : bool
        Whether causes are looked for; else the base model alone is fitted.

    Raises
    ------
    RunError
        When not even the base model can be fitted.
    """
    if search and isinstance(model, WeighsAllSets):
        progress("weighing all sets of causes", 0, 1)
        try:
            return model.all_sets()
        except np.linalg.LinAlgError as error:
            raise RunError(f"the base model cannot be fitted: {error}") from error
    base = fitted(model, [((), ())])[0]
    if isinstance(base, FailedFit):
        raise RunError(f"the base model cannot be fitted: {base.reason}")
    if not search:
        return Selection(base, (), (), (), len(model.candidates))
    tried = _Search(cast(SearchedModel, model), base)
    frontier: Sequence[Candidate] = [Candidate(base, 0.0)]
    for size in range(1, MOST_CAUSES + 1):
        wanted = tried.extensions(frontier, size)
        progress(f"fitting sets of {size}", 0, len(wanted))
        tried.fit(wanted, jobs)
        frontier = tried.frontier(size)
        if tried.is_over(frontier):
            break
    return tried.selection()


class _Search:
    """Sets tried so far."""

    def __init__(self, model: SearchedModel, base: CauseFit) -> None:
        self._model, self._base = model, base
        self._tried: dict[frozenset[str], Candidate] = {}
        self._failed: list[FailedFit] = []
        self._order = {name: index for index, name in enumerate(model.candidates)}

    def extensions(self, frontier: Sequence[Candidate], size: int) -> list[Extension]:
        """Sets of a size to be fitted, and the fits that they extend."""
        wanted = self._extended(frontier)
        if size > 1:
            wanted = [
                (causes, parent)
                for causes, parent in wanted
                if self._model.estimated_gain(causes, parent) > PRUNE_BELOW
            ]
        if size == 2:
            wanted += self._masked_pairs(frozenset(causes) for causes, _ in wanted)
        return wanted

    def _extended(self, frontier: Sequence[Candidate]) -> list[Extension]:
        """Every set of the frontier with one cause more."""
        found: dict[frozenset[str], CauseFit] = {}
        for parent, name in itertools.product(frontier, self._model.candidates):
            together = frozenset({*parent.causes, name})
            if len(together) > len(parent.causes) and self._is_new(together):
                found.setdefault(together, parent.fit)
        return [(tuple(sorted(causes, key=self._order.__getitem__)), parent) for causes, parent in found.items()]

    def _masked_pairs(self, wanted: Iterable[frozenset[str]]) -> list[Extension]:
        """Pairs of great estimated gain whose causes, alone, may mask each other and not be among the best."""
        known = set(wanted)
        pairs = [
            pair
            for pair in itertools.combinations(self._model.candidates, 2)
            if frozenset(pair) not in known and self._is_new(frozenset(pair))
        ]
        gains = {pair: self._model.estimated_gain(pair, self._base) for pair in pairs}
        likely = sorted((pair for pair in pairs if np.isfinite(gains[pair])), key=lambda pair: -gains[pair])
        return [(pair, self._base) for pair in likely[:EXTRA_PAIRS]]

    def _is_new(self, causes: frozenset[str]) -> bool:
        """Whether a set was not tried yet and holds no two effects that exclude each other."""
        return causes not in self._tried and not any(len(group & causes) > 1 for group in self._model.alternatives)

    def fit(self, wanted: Sequence[Extension], jobs: int) -> None:
        """Fit sets, each started from the fit that it extends and from its causes alone."""
        requests = [(causes, (parent, *self._alone(causes, parent))) for causes, parent in wanted]
        for fit in fitted(self._model, requests, jobs):
            if isinstance(fit, FailedFit):
                self._failed.append(fit)
            else:
                self._tried[frozenset(fit.causes)] = Candidate(fit, fit.log_evidence - self._base.log_evidence)

    def _alone(self, causes: Causes, parent: CauseFit) -> list[CauseFit]:
        alone = [self._tried.get(frozenset({name})) for name in causes if name not in parent.causes]
        return [candidate.fit for candidate in alone if candidate is not None]

    def frontier(self, size: int) -> list[Candidate]:
        """The best sets of a size, which are to be extended."""
        own = [candidate for candidate in self._ranked() if len(candidate.causes) == size]
        return [candidate for candidate in own if size == 1 or self._passes_penalty(candidate)][:BEAM]

    def is_over(self, frontier: Sequence[Candidate]) -> bool:
        """Whether no extension of the frontier could be claimed."""
        if not frontier:
            return True
        best = self._ranked()[0].score
        return frontier[0].score < best - COMPLEXITY_PENALTY or best <= 0.0

    def selection(self) -> Selection:
        """What was found."""
        ranked = self._ranked()
        return Selection(
            base=self._base,
            ranking=tuple(each for each in ranked if each.fit.possible and self._exceeds_errors_of_shape(each)),
            impossible=tuple(each for each in ranked if not each.fit.possible),
            failed=tuple(self._failed),
            catalogue=len(self._model.candidates),
        )

    def _ranked(self) -> list[Candidate]:
        return sorted(self._tried.values(), key=lambda candidate: -candidate.score)

    def _passes_penalty(self, candidate: Candidate) -> bool:
        """Whether each cause of a set adds what its prior costs, and more than errors of shape."""
        return self._adds(candidate, COMPLEXITY_PENALTY)

    def _exceeds_errors_of_shape(self, candidate: Candidate) -> bool:
        """Whether each cause of a set adds more than what errors of the others' shapes may, where they add any."""
        return self._adds(candidate, -np.inf)

    def _adds(self, candidate: Candidate, least: float) -> bool:
        if len(candidate.causes) == 1:
            return True
        parts = [self._tried.get(frozenset(candidate.causes) - {name}) for name in candidate.causes]
        gains = [(candidate.log_bayes_factor - part.log_bayes_factor, part) for part in parts if part is not None]
        shape = [self._model.minimum_evidence_gain(part.causes) * part.log_bayes_factor for _, part in gains]
        return all(
            gain >= max(least, error if gain > 0.0 else -np.inf) for (gain, _), error in zip(gains, shape, strict=True)
        )
