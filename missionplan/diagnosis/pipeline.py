"""What a diagnosis does to a model and its data, in the order of its steps, and what may be said of what it found."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
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
    Selection,
    WeighsAllSets,
    inclusion,
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


def claimed_set(selection: Selection) -> Causes:
    """Return the likeliest set, where something is there; of a family its likeliest member.

    Where something without a name is likely, named causes that may as well not be there are left out.
    """
    posterior = selection.posterior
    if 1.0 - selection.nothing < SURE or not posterior:
        return ()
    likeliest = max(posterior, key=lambda causes: posterior[causes])
    named = tuple(name for name in likeliest if CATALOGUE[name].tier != "neutral")
    if selection.none_of_these < LIKELY or not named or _probability(selection, named) >= SURE:
        return likeliest
    rest = tuple(name for name in likeliest if name not in named)
    return rest if rest in posterior else ()


def _probability(selection: Selection, causes: Causes) -> float:
    """Probability of a set, its supersets and those of the sets told as one with it counted."""
    alike = next((family for family in selection.families if causes in family), (causes,))
    return sum(p for other, p in selection.posterior.items() if any(set(one) <= set(other) for one in alike))


def verdict_of(selection: Selection, *, is_constant: bool = True) -> Verdict:
    """Return the first verdict that fits: no model is adequate where something without a name is likely."""
    none_of_these = selection.none_of_these
    if 1.0 - selection.nothing < SURE:
        return "unexplained" if none_of_these >= LIKELY else "adequate"
    claimed = claimed_set(selection)
    if not is_physical(claimed) or sum(p for causes, p in selection.posterior.items() if is_physical(causes)) < LIKELY:
        return "unexplained"
    if none_of_these >= LIKELY or not is_constant:
        return "partly-explained"
    is_all = _probability(selection, claimed) >= SURE and none_of_these <= 1.0 - SURE
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


def run_pipeline(
    model: WeighsAllSets,
    stage: Callable[[], None] = lambda: None,
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
    stage : callable
        Called after the search, after held-out predictions and after the tests of what is left.
    jobs : int
        Processes.
    search : bool
        Whether causes are looked for; else the base model alone is tested.
    selection : Selection, optional
        All sets of causes, where they have been searched.
    """
    try:
        weighed = selection or (model.all_sets(jobs) if search else _base_alone(model))
    except np.linalg.LinAlgError as error:
        raise RunError(f"the base model cannot be fitted: {error}") from error
    stage()
    held_out = _held_out(model, weighed, jobs)
    stage()
    fits = {one.causes: one.fit for one in weighed.ranking} | {(): weighed.base}
    likeliest = fits.get(max(weighed.posterior, key=lambda causes: weighed.posterior[causes]), weighed.base)
    wanted = [weighed.base] if likeliest is weighed.base else [weighed.base, likeliest]
    tested = parallel_map(partial(_tested_residuals, model), wanted, jobs=jobs)
    stage()
    (base_discrepancy, base_outlying), (left, outlying) = tested[0], tested[-1]
    if not search and left.significant:
        weighed = replace(weighed, nothing=0.0)
    best = fits.get(claimed_set(weighed), weighed.base)
    if best is weighed.base and weighed.none_of_these < LIKELY:  # else it is what the likeliest set leaves
        left, outlying = base_discrepancy, base_outlying
    return PipelineResult(best, weighed, held_out, left, base_discrepancy, outlying)


def _base_alone(model: Model) -> Selection:
    (base,) = fitted(model, [((), ())])
    if isinstance(base, FailedFit):
        raise RunError(f"the base model cannot be fitted: {base.reason}")
    return Selection(base, (), (), len(model.candidates))


def _held_out(model: Model, selection: Selection, jobs: int) -> dict[Causes, HeldOutComparison]:
    """Held-out predictions of the best few sets that could be claimed or rival the claim."""
    scored = [candidate for candidate in selection.ranking[:SCORED] if _contends(candidate, selection)]
    if not scored:
        return {}
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
    causes, selection = pipeline_result.best.causes, pipeline_result.selection
    not_constant = bound.not_constant(pipeline_result.best) if causes else ()
    verdict = verdict_of(selection, is_constant=not not_constant)
    if not causes and verdict != "adequate":  # also where the likeliest set cannot be fitted
        verdict = "unexplained"
    return Judgement(
        bound.limited_verdict(verdict),
        selection.credible,
        tuple(rivals(selection.posterior, causes)) if causes else (),
        not_constant,
        bound.suspect_labels(selection),
        selection.none_of_these,
        selection.nothing,
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
        inclusion(selection.posterior),
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
