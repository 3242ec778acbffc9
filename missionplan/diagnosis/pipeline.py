"""The method from end to end on a model of the data: select, measure the gain, test the remainder, judge."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from missionplan.diagnosis.inference.cross_validation import HeldOut, held_out_gain
from missionplan.diagnosis.inference.discrepancy import Discrepancy, discrepancy
from missionplan.diagnosis.inference.model import CauseFit, Model
from missionplan.diagnosis.inference.residual_tests import outlying_groups
from missionplan.diagnosis.inference.selection import Candidate, Progress, Selection, credible_set, posteriors, select
from missionplan.diagnosis.verdict import Claim, Verdict, claim, verdict
from missionplan.montecarlo.parallel_map import parallel_map
from missionplan.results.diagnosis import Causes

SCORED = 3
"""Sets whose held-out gain is measured."""


def silent(what: str, done: int, of: int) -> None:
    """Report no progress."""


@dataclass(frozen=True)
class PipelineResult:
    """Everything that was found.

    Attributes
    ----------
    verdict : str
        By the rules of the contract.
    claimed : Claim or None
        The set claimed, and its rivals.
    best : CauseFit
        The claimed set's fit, else the base model's.
    selection : Selection
        Every set that was tried.
    posterior : mapping
        Probability of each set.
    credible_set : tuple
        Sets that hold 95 %, best first.
    gains : mapping
        Held-out gain of the best sets.
    checks : mapping
        Their ln Bayes factors by importance sampling.
    discrepancy, base_discrepancy : Discrepancy
        What the claimed model leaves, and the base model.
    outlying_groups : tuple
        Groups that the best model cannot explain, with p-values.
    """

    verdict: Verdict
    claimed: Claim | None
    best: CauseFit
    selection: Selection
    posterior: Mapping[Causes, float]
    credible_set: tuple[Causes, ...]
    gains: Mapping[Causes, HeldOut]
    checks: Mapping[Causes, float]
    discrepancy: Discrepancy
    base_discrepancy: Discrepancy
    outlying_groups: tuple[tuple[str, float], ...]


def run_pipeline(model: Model, progress: Progress = silent, jobs: int = 1) -> PipelineResult:
    """Diagnose a model of a data set.

    Parameters
    ----------
    model : Model
        Base model and catalogue, bound to the data.
    progress : callable
        Told what is being done.
    jobs : int
        Processes.
    """
    selection = select(model, progress, jobs)
    gains = _gains(model, selection, progress, jobs)
    checks = _checks(model, selection, tuple(gains), jobs)
    best = selection.ranking[0] if selection.ranking else None
    claimed = claim(selection, gains.get(best.causes) if best else None)
    progress("testing the remainder", 0, 1)
    chosen = claimed.candidate.fit if claimed is not None else selection.base
    fits = [selection.base] if claimed is None else [selection.base, chosen]
    looked_at = parallel_map(partial(_looked_at, model), fits, jobs=jobs)
    (base_discrepancy, _), (left, outlying) = looked_at[0], looked_at[-1]
    posterior = posteriors(selection, claimed.candidate.causes if claimed else None)
    return PipelineResult(
        verdict(claimed, left),
        claimed,
        chosen,
        selection,
        posterior,
        tuple(credible_set(posterior)),
        gains,
        checks,
        left,
        base_discrepancy,
        outlying,
    )


def _gains(model: Model, selection: Selection, progress: Progress, jobs: int) -> dict[Causes, HeldOut]:
    """Held-out gain of the best few sets that could be claimed or rival the claim."""
    scored = [candidate for candidate in selection.ranking[:SCORED] if _is_contender(candidate, selection)]
    if not scored:
        return {}
    progress("predicting held-out data", 0, 1)
    fits = [selection.base, *(candidate.fit for candidate in scored)]
    base, *extended = parallel_map(model.held_out, fits, jobs=jobs)
    return {candidate.causes: held_out_gain(base, scores) for candidate, scores in zip(scored, extended, strict=True)}


def _checks(model: Model, selection: Selection, scored: tuple[Causes, ...], jobs: int) -> dict[Causes, float]:
    """Bayes factors (ln) of the sets that were scored, by importance sampling."""
    if not scored:
        return {}
    fits = {candidate.causes: candidate.fit for candidate in selection.ranking}
    wanted = [selection.base, *(fits[causes] for causes in scored)]
    base, *found = parallel_map(partial(_log_evidences, model), wanted, jobs=jobs)
    return {causes: log_evidence - base for causes, log_evidence in zip(scored, found, strict=True)}


def _looked_at(model: Model, fits: Sequence[CauseFit]) -> list[tuple[Discrepancy, tuple[tuple[str, float], ...]]]:
    """What each fit leaves: its remainder, and its outlying groups."""
    residuals = [model.residuals(fit) for fit in fits]
    return [(discrepancy(each), outlying_groups(each)) for each in residuals]


def _log_evidences(model: Model, fits: Sequence[CauseFit]) -> list[float]:
    return [model.sampled_evidence(fit).log_evidence for fit in fits]


def _is_contender(candidate: Candidate, selection: Selection) -> bool:
    return candidate.score > max(0.0, selection.ranking[0].score - 6.0) and np.isfinite(candidate.score)
