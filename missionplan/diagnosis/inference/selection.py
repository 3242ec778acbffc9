"""Selection: one, two or three causes at once, by evidence; physical impossibilities out; posteriors."""

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from missionplan.diagnosis.inference.model import CauseFit, FailedFit, FitRequest, Model
from missionplan.errors import RunError
from missionplan.montecarlo.parallel_map import parallel_map
from missionplan.results.diagnosis import Causes

COMPLEXITY_PENALTY = 3.0
"""Nats that each cause beyond the first must earn, and that a claim must exceed."""
PRUNE_BELOW = -4.0
"""Nats of quick promise below which a further cause is not fitted."""
RETRIES = 2
"""Pairs that are tried again when they ended where they are impossible."""
BEAM = 3
EXTRA_PAIRS = 8
"""Pairs outside the beam that are fitted as well, by their quick promise."""
MOST_CAUSES = 3
CREDIBLE = 0.95

Progress = Callable[[str, int, int], None]
"""What is done, how many of how many."""


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
        """Log Bayes factor less the price of each cause beyond the first; 0 for the base model."""
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
        Sets whose best fit has a sign or size that an effect cannot have, or one that may as well be nil.
    failed : tuple of FailedFit
        Sets that could not be fitted, and why.
    catalogue : int
        Number of effects that the data could show.
    """

    base: CauseFit
    ranking: tuple[Candidate, ...]
    impossible: tuple[Candidate, ...]
    failed: tuple[FailedFit, ...]
    catalogue: int


def select(model: Model, progress: Progress = lambda what, done, of: None, jobs: int = 1) -> Selection:
    """Fit the base model, every cause alone, and pairs and triples about the best (a beam).

    Parameters
    ----------
    model : Model
        Model of the data.
    progress : callable
        Told what is being done.
    jobs : int
        Processes that fit.

    Raises
    ------
    RunError
        When not even the base model can be fitted.
    """
    base = _fitted(model, [((), ())])[0]
    if isinstance(base, FailedFit):
        raise RunError(f"the base model cannot be fitted: {base.reason}")
    tried: dict[frozenset[str], Candidate] = {}
    failed: list[FailedFit] = []
    frontier: list[Candidate] = [Candidate(base, 0.0)]
    alone: dict[str, CauseFit] = {}
    for size in range(1, MOST_CAUSES + 1):
        wanted = _extensions(frontier, model, set(tried))
        if size > 1:
            wanted = [
                (causes, parent) for causes, parent in wanted if model.estimated_gain(causes, parent) > PRUNE_BELOW
            ]
        if size == 2:
            wanted += _promising(model, base, {*tried, *(frozenset(causes) for causes, _ in wanted)})
        progress(f"fitting sets of {size}", 0, len(wanted))
        for fit in _fitted(model, [(causes, _parts(causes, parent, alone)) for causes, parent in wanted], jobs):
            if isinstance(fit, FailedFit):
                failed.append(fit)
                continue
            tried[frozenset(fit.causes)] = Candidate(fit, fit.log_evidence - base.log_evidence)
            if size == 1:
                alone[fit.causes[0]] = fit
        best = sorted(tried.values(), key=lambda candidate: -candidate.score)
        frontier = [c for c in best if len(c.causes) == size and (size == 1 or _passes_penalty(c, tried, model))][:BEAM]
        if not frontier or frontier[0].score < best[0].score - COMPLEXITY_PENALTY or best[0].score <= 0.0:
            break
    possible = [candidate for candidate in best if candidate.fit.possible and _passes_penalty(candidate, tried, model)]
    impossible = [candidate for candidate in best if not candidate.fit.possible]
    return Selection(base, tuple(possible), tuple(impossible), tuple(failed), len(model.candidates))


def _fitted(model: Model, wanted: Sequence[FitRequest], jobs: int = 1) -> list[CauseFit | FailedFit]:
    """Fit several sets, pairs that ended badly once more from the start, and improve on the best of them."""
    fits = parallel_map(model.fit_all, wanted, jobs=jobs)
    for index, other in _tried_again(model, wanted, fits, jobs):
        if isinstance(other, CauseFit) and other.possible:
            fits[index] = other
    best = max((fit.log_evidence for fit in fits if isinstance(fit, CauseFit)), default=0.0)
    return parallel_map(partial(model.relinearised, best=best), fits, jobs=jobs)


def _tried_again(
    model: Model, wanted: Sequence[FitRequest], fits: Sequence[CauseFit | FailedFit], jobs: int
) -> list[tuple[int, CauseFit | FailedFit]]:
    """Fit the best pairs that ended where they are impossible without the places of their parts to start from."""
    lost = [
        (fit.log_evidence, index)
        for index, fit in enumerate(fits)
        if isinstance(fit, CauseFit)
        and len(fit.causes) == 2
        and not fit.possible
        and model.may_be_multimodal(fit.causes)
    ]
    again = [index for _, index in sorted(lost, reverse=True)[:RETRIES]]
    fitted = parallel_map(model.fit_all, [(wanted[index][0], ()) for index in again], jobs=jobs)
    return list(zip(again, fitted, strict=True))


def _promising(model: Model, base: CauseFit, known: set[frozenset[str]]) -> list[tuple[Causes, CauseFit]]:
    """Find pairs that promise much together though neither is among the best alone: causes that hide each other."""
    pairs = [
        pair
        for pair in itertools.combinations(model.candidates, 2)
        if frozenset(pair) not in known and not _exclusive(frozenset(pair), model)
    ]
    estimated_gains = {pair: model.estimated_gain(pair, base) for pair in pairs}
    likely = sorted(
        (pair for pair in pairs if np.isfinite(estimated_gains[pair])), key=lambda pair: -estimated_gains[pair]
    )
    return [(pair, base) for pair in likely[:EXTRA_PAIRS]]


def _exclusive(causes: frozenset[str], model: Model) -> bool:
    return any(len(group & causes) > 1 for group in model.alternatives)


def _parts(causes: Causes, parent: CauseFit, alone: dict[str, CauseFit]) -> tuple[CauseFit, ...]:
    return (parent, *(alone[name] for name in causes if name in alone and name not in parent.causes))


def _passes_penalty(candidate: Candidate, tried: dict[frozenset[str], Candidate], model: Model) -> bool:
    """Whether each cause of a set adds enough to the rest of it."""
    parts = [tried.get(frozenset(candidate.causes) - {name}) for name in candidate.causes]
    asked = [
        part.log_bayes_factor
        + max(COMPLEXITY_PENALTY, model.minimum_evidence_gain(part.causes) * part.log_bayes_factor)
        for part in parts
        if part is not None
    ]
    return len(candidate.causes) == 1 or candidate.log_bayes_factor >= max(asked, default=-np.inf)


def _extensions(
    frontier: Sequence[Candidate], model: Model, tried: set[frozenset[str]]
) -> list[tuple[Causes, CauseFit]]:
    order = {name: index for index, name in enumerate(model.candidates)}
    found: dict[frozenset[str], CauseFit] = {}
    for parent in frontier:
        for name in model.candidates:
            together = frozenset({*parent.causes, name})
            if len(together) > len(parent.causes) and not _exclusive(together, model) and together not in tried:
                found.setdefault(together, parent.fit)
    return [(tuple(sorted(causes, key=order.__getitem__)), parent) for causes, parent in found.items()]


def posteriors(selection: Selection, claimed: Causes | None) -> dict[Causes, float]:
    """Posterior probability of each set, the empty one included; supersets of a claimed set are left out.

    Each non-empty set has prior 1/(size of the catalogue) relative to the empty set.
    """
    kept = [candidate for candidate in selection.ranking if claimed is None or not set(claimed) < set(candidate.causes)]
    logs = np.array([0.0] + [candidate.score - np.log(selection.catalogue) for candidate in kept])
    weights = np.exp(logs - logs.max())
    weights /= weights.sum()
    return dict(zip([(), *(candidate.causes for candidate in kept)], weights.tolist(), strict=True))


def credible_set(posterior: dict[Causes, float]) -> list[Causes]:
    """Smallest list of sets that holds 95 % of the probability, best first."""
    chosen: list[Causes] = []
    total = 0.0
    for causes, probability in sorted(posterior.items(), key=lambda item: -item[1]):
        chosen.append(causes)
        total += probability
        if total >= CREDIBLE:
            break
    return chosen


def rivals(selection: Selection, claimed: Candidate) -> list[Candidate]:
    """Other sets within 3 nats of the claimed one, its supersets aside."""
    return [
        candidate
        for candidate in selection.ranking
        if candidate.causes != claimed.causes
        and not set(claimed.causes) < set(candidate.causes)
        and candidate.score > claimed.score - COMPLEXITY_PENALTY
    ]
