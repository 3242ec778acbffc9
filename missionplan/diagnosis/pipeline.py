"""What a diagnosis does to a model and its data, in the order of its steps, and what may be said of what it found."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from missionplan.diagnosis.data_kind import DataKind
from missionplan.diagnosis.inference.discrepancy import discrepancy, outlying_groups
from missionplan.diagnosis.inference.model import (
    CauseFit,
    FailedFit,
    HeldOutComparison,
    HeldOutScore,
    Model,
    compare_held_out,
    fitted,
    interval_coverage,
)
from missionplan.diagnosis.inference.selection import (
    LIKELY,
    Candidate,
    Progress,
    Selection,
    WeighsAllSets,
    inclusion,
    no_progress,
    rivals,
)
from missionplan.effects import CATALOGUE
from missionplan.errors import RunError
from missionplan.montecarlo.blocks import parallel_map
from missionplan.results.learned.evidence import (
    SURE,
    Causes,
    Discrepancy,
    Judgement,
    OutlyingGroup,
    Readings,
    Verdict,
)


@dataclass(frozen=True)
class Reading:
    """What a posterior says."""

    posterior: Mapping[Causes, float]
    """Probability of each set of causes."""
    nothing: float
    """That nothing is there: no cause, and nothing that no cause explains."""
    none_of_these: float
    """That something which no cause explains is there."""
    families: Sequence[Sequence[Causes]] = ()
    """Sets that differ in nothing that these data show, and that are told as one."""

    @property
    def claimed(self) -> Causes:
        """The likeliest set, where something is there; of a family its likeliest member.

        Where something without a name is likely, named causes that may as well not be there are left out.
        """
        if 1.0 - self.nothing < SURE or not self.posterior:
            return ()
        likeliest = max(self.posterior, key=lambda causes: self.posterior[causes])
        named = tuple(name for name in likeliest if CATALOGUE[name].tier != "neutral")
        if self.none_of_these < LIKELY or not named or self.probability(named) >= SURE:
            return likeliest
        rest = tuple(name for name in likeliest if name not in named)
        return rest if rest in self.posterior else ()

    def probability(self, causes: Causes) -> float:
        """Probability of a set, its supersets and those of the sets told as one with it counted."""
        alike = next((family for family in self.families if causes in family), (causes,))
        supersets = [other for other in self.posterior if any(set(one) <= set(other) for one in alike)]
        return sum(self.posterior[other] for other in supersets)

    def verdict(self, *, is_constant: bool = True) -> Verdict:
        """Return the first verdict that fits: no model is adequate where something without a name is likely."""
        if 1.0 - self.nothing < SURE:
            return "unexplained" if self.none_of_these >= LIKELY else "adequate"
        claimed = self.claimed
        if not is_physical(claimed) or sum(p for causes, p in self.posterior.items() if is_physical(causes)) < LIKELY:
            return "unexplained"
        if self.none_of_these >= LIKELY or not is_constant:
            return "partly-explained"
        is_all = self.probability(claimed) >= SURE and self.none_of_these <= 1.0 - SURE
        return "explained" if is_all else "ambiguous"


def is_physical(causes: Causes) -> bool:
    """Whether a set names a physical cause; the others only describe the errors."""
    return any(CATALOGUE[name].tier == "physical" for name in causes)


SCORED = 3
"""Sets whose held-out gain is measured, at most."""
CONTENDING = 6.0
"""Nats below the best score within which a set's held-out gain is measured."""

OutlyingGroups = tuple[OutlyingGroup, ...]
"""Groups and their p-values."""


@dataclass(frozen=True)
class PipelineResult:
    """Everything that was found."""

    reading: Reading
    """What the posterior says."""
    best: CauseFit
    """The claimed set's fit, else the base model's."""
    selection: Selection
    """All sets."""
    held_out: Mapping[Causes, HeldOutComparison]
    """Predictions of held-out data by the best sets, beside the base model's."""
    discrepancy: Discrepancy
    base_discrepancy: Discrepancy
    """What the claimed model leaves, and the base model."""
    outlying_groups: OutlyingGroups
    """Groups that the best model cannot explain, with p-values."""

    @property
    def posterior(self) -> Mapping[Causes, float]:
        """Probability of each set."""
        return self.selection.posterior

    @property
    def credible_set(self) -> tuple[Causes, ...]:
        """Sets that hold 95 % of the probability, best first."""
        return self.selection.credible

    @property
    def verdict(self) -> Verdict:
        """What the posterior says, whether causes hold still not asked."""
        return self.reading.verdict()


def run_pipeline(
    model: WeighsAllSets,
    progress: Progress = no_progress,
    jobs: int = 1,
    *,
    search: bool = True,
    selection: Selection | None = None,
) -> PipelineResult:
    """Diagnose a model of a data set.

    Raises RunError when not even the base model can be fitted.

    Parameters
    ----------
    model : WeighsAllSets
        Base model and catalogue, bound to the data.
    progress : callable
        Called with what is being done.
    jobs : int
        Processes.
    search : bool
        Whether causes are looked for; else the base model alone is tested.
    selection : Selection, optional
        All sets of causes, where they have been searched.
    """
    try:
        selection = selection or (model.all_sets(progress, jobs) if search else _base_alone(model))
    except np.linalg.LinAlgError as error:
        raise RunError(f"the base model cannot be fitted: {error}") from error
    held_out = _held_out(model, selection, progress, jobs)
    fits = {one.causes: one.fit for one in selection.ranking} | {(): selection.base}
    progress("testing what is left", 0, 1)
    likeliest = fits.get(max(selection.posterior, key=lambda causes: selection.posterior[causes]), selection.base)
    wanted = [selection.base] if likeliest is selection.base else [selection.base, likeliest]
    tested = parallel_map(partial(_tested_residuals, model), wanted, jobs=jobs)
    (base_discrepancy, base_outlying), (left, outlying) = tested[0], tested[-1]
    nothing = selection.nothing if search or not left.significant else 0.0
    reading = Reading(selection.posterior, nothing, selection.none_of_these, selection.families)
    best = fits.get(reading.claimed, selection.base)
    if best is selection.base and reading.none_of_these < LIKELY:  # else it is what the likeliest set leaves
        left, outlying = base_discrepancy, base_outlying
    return PipelineResult(reading, best, selection, held_out, left, base_discrepancy, outlying)


def _base_alone(model: Model) -> Selection:
    (base,) = fitted(model, [((), ())])
    if isinstance(base, FailedFit):
        raise RunError(f"the base model cannot be fitted: {base.reason}")
    return Selection(base, (), (), (), len(model.candidates))


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


def _tested_residuals(model: Model, fits: Sequence[CauseFit]) -> list[tuple[Discrepancy, OutlyingGroups]]:
    """For each fit, the discrepancy of what it leaves and its outlying groups."""
    return [(discrepancy(left), outlying_groups(left)) for left in map(model.residuals, fits)]


def judge(bound: DataKind, pipeline_result: PipelineResult) -> Judgement:
    """Judge what the pipeline found on a data set."""
    causes = pipeline_result.best.causes
    not_constant = bound.not_constant(pipeline_result.best) if causes else ()
    verdict = pipeline_result.reading.verdict(is_constant=not not_constant)
    if not causes and verdict != "adequate":  # also where the likeliest set cannot be fitted
        verdict = "unexplained"
    return Judgement(
        bound.limited_verdict(verdict),
        pipeline_result.credible_set,
        tuple(rivals(pipeline_result.posterior, causes)) if causes else (),
        not_constant,
        bound.suspect_labels(pipeline_result.selection),
        pipeline_result.reading.none_of_these,
        pipeline_result.reading.nothing,
        interval_coverage(_held_out_scores(pipeline_result)),
    )


def _held_out_scores(pipeline_result: PipelineResult) -> tuple[HeldOutScore, ...]:
    """Held-out scores of the model that is believed; none where none were made."""
    comparison = pipeline_result.held_out.get(pipeline_result.best.causes)
    if comparison is not None:
        return comparison.extended
    return (
        next((comparison.base for comparison in pipeline_result.held_out.values()), ())
        if not pipeline_result.best.causes
        else ()
    )


def read(bound: DataKind, pipeline_result: PipelineResult) -> Readings:
    """Return what else the posterior says."""
    selection, best = pipeline_result.selection, pipeline_result.best
    return Readings(
        inclusion(pipeline_result.posterior),
        selection.responses,
        selection.not_computed,
        tuple(family for family in selection.families if best.causes in family),
        bound.aliases(best) if best.causes else (),
        _predicts_better(bound, pipeline_result) if best.causes else None,
        bound.wrong_fixes(best),
        bound.confounded_with_reckoning(best),
    )


def _predicts_better(bound: DataKind, pipeline_result: PipelineResult) -> bool | None:
    """Whether the claimed set predicts data kept away better, in single groups and all the way."""
    held_out = pipeline_result.held_out.get(pipeline_result.best.causes)
    if held_out is None:
        return None
    return held_out.gain.log_score_gain > 0.0 and bound.is_better_ahead(
        pipeline_result.selection.base, pipeline_result.best
    )
