"""The method from end to end on any model of data: select causes, score them held out, test what is left, judge."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import cast

import numpy as np

from missionplan.diagnosis.inference.adequacy.discrepancy import discrepancy, none_of_these
from missionplan.diagnosis.inference.adequacy.residual_tests import outlying_groups
from missionplan.diagnosis.inference.cross_validation import HeldOutComparison, compare_held_out
from missionplan.diagnosis.inference.importance_sampling import SampledEvidence
from missionplan.diagnosis.inference.model import CauseFit, Model, SearchedModel
from missionplan.diagnosis.inference.posterior import credible_set, posteriors
from missionplan.diagnosis.inference.selection import Candidate, Progress, Selection, no_progress, select
from missionplan.diagnosis.verdict import Reading
from missionplan.montecarlo.parallel.mapping import parallel_map
from missionplan.results.learned.evidence import Causes, Discrepancy, ParameterEstimate, Verdict

SCORED = 3
"""Sets whose held-out gain is measured, at most."""
EFFECTIVE = 10.0
"""Effective draws from which a Bayes factor by importance sampling replaces that of the linearised model: its logarithm
is then known to a third of a nat."""
CONTENDING = 6.0
"""Nats below the best score within which a set's held-out gain is measured."""

OutlyingGroups = tuple[tuple[str, float], ...]
"""Groups and their p-values."""


@dataclass(frozen=True)
class PipelineResult:
    """Everything that was found.

    Attributes
    ----------
    reading : Reading
        What the posterior says.
    best : CauseFit
        The claimed set's fit, else the base model's.
    selection : Selection
        Every set that was tried.
    posterior : mapping
        Probability of each set.
    credible_set : tuple
        Sets that hold 95 % of the probability, best first.
    held_out : mapping
        Predictions of held-out data by the best sets, beside the base model's.
    sampled : mapping
        Their ln Bayes factors by importance sampling.
    discrepancy, base_discrepancy : Discrepancy
        What the claimed model leaves, and the base model.
    outlying_groups : tuple
        Groups that the best model cannot explain, with p-values.
    """

    reading: Reading
    best: CauseFit
    selection: Selection
    posterior: Mapping[Causes, float]
    credible_set: tuple[Causes, ...]
    held_out: Mapping[Causes, HeldOutComparison]
    sampled: Mapping[Causes, float]
    discrepancy: Discrepancy
    base_discrepancy: Discrepancy
    outlying_groups: OutlyingGroups

    @property
    def verdict(self) -> Verdict:
        """What the posterior says, whether causes hold still not asked."""
        return self.reading.verdict()

    def without_learning(self, known: tuple[ParameterEstimate, ...]) -> "PipelineResult":
        """Return what was found with the mission's own effects as they were known before."""
        base = replace(self.selection.base, given=known, correlations=())
        return replace(self, selection=replace(self.selection, base=base), best=base)


def run_pipeline(
    model: Model, progress: Progress = no_progress, jobs: int = 1, *, search: bool = True
) -> PipelineResult:
    """Diagnose a model of a data set.

    Parameters
    ----------
    model : Model
        Base model and catalogue, bound to the data.
    progress : callable
        Called with what is being done.
    jobs : int
        Processes.
    search : bool
        Whether causes are looked for; else the base model alone is tested.
    """
    selection = select(model, progress, jobs, search=search)
    held_out = _held_out(model, selection, progress, jobs)
    found = {} if selection.posterior else _sampled(model, selection, tuple(held_out), jobs)
    sampled = {causes: each.log_evidence for causes, each in found.items()}
    checked = {causes: each.log_evidence for causes, each in found.items() if each.effective >= EFFECTIVE}
    posterior = posteriors(selection, checked)
    fits = {one.causes: one.fit for one in selection.ranking} | {(): selection.base}
    progress("testing what is left", 0, 1)
    likeliest = fits.get(max(posterior, key=lambda causes: posterior[causes]), selection.base)
    wanted = [selection.base] if likeliest is selection.base else [selection.base, likeliest]
    tested = parallel_map(partial(_tested_residuals, model), wanted, jobs=jobs)
    (base_discrepancy, _), (left, outlying) = tested[0], tested[-1]
    other = selection.none_of_these
    other = none_of_these(left, selection.catalogue) if other is None else other
    nothing = selection.nothing
    if nothing is None:
        nothing = 0.0 if left.significant else posterior[()]
    reading = Reading(posterior, nothing, other, selection.families)
    best = fits.get(reading.claimed, selection.base)
    if best is selection.base:
        left, outlying = base_discrepancy, tested[0][1]
    return PipelineResult(
        reading=reading,
        best=best,
        selection=selection,
        posterior=posterior,
        credible_set=selection.credible or tuple(credible_set(posterior)),
        held_out=held_out,
        sampled=sampled,
        discrepancy=left,
        base_discrepancy=base_discrepancy,
        outlying_groups=outlying,
    )


def _held_out(model: Model, selection: Selection, progress: Progress, jobs: int) -> dict[Causes, HeldOutComparison]:
    """Held-out predictions of the best few sets that could be claimed or rival the claim."""
    scored = [candidate for candidate in selection.ranking[:SCORED] if _contends(candidate, selection)]
    if not scored:
        return {}
    progress("predicting held-out data", 0, 1)
    fits = [selection.base, *(candidate.fit for candidate in scored)]
    base, *extended = parallel_map(model.held_out, fits, jobs=jobs)
    return {
        candidate.causes: compare_held_out(base, scores) for candidate, scores in zip(scored, extended, strict=True)
    }


def _contends(candidate: Candidate, selection: Selection) -> bool:
    return candidate.score > max(0.0, selection.ranking[0].score - CONTENDING) and np.isfinite(candidate.score)


def _sampled(model: Model, selection: Selection, scored: Sequence[Causes], jobs: int) -> dict[Causes, SampledEvidence]:
    """Bayes factors (ln) by importance sampling of the sets that were scored, with the effective draws."""
    if not scored:
        return {}
    fits = {candidate.causes: candidate.fit for candidate in selection.ranking}
    wanted = [selection.base, *(fits[causes] for causes in scored)]
    base, *found = parallel_map(partial(_sampled_evidences, cast(SearchedModel, model)), wanted, jobs=jobs)
    return {
        causes: SampledEvidence(each.log_evidence - base.log_evidence, min(each.effective, base.effective))
        for causes, each in zip(scored, found, strict=True)
    }


def _sampled_evidences(model: SearchedModel, fits: Sequence[CauseFit]) -> list[SampledEvidence]:
    return [model.sampled_evidence(fit) for fit in fits]


def _tested_residuals(model: Model, fits: Sequence[CauseFit]) -> list[tuple[Discrepancy, OutlyingGroups]]:
    """For each fit, the discrepancy of what it leaves and its outlying groups."""
    residuals = [model.residuals(fit) for fit in fits]
    return [(discrepancy(each), outlying_groups(each)) for each in residuals]
