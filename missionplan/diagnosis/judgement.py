"""What may be said of a data set: the verdict with its limits, the credible set, and what the catalogue leaves out."""

from dataclasses import dataclass

from missionplan.diagnosis.data_kind import DataKind
from missionplan.diagnosis.inference.cross_validation import interval_coverage
from missionplan.diagnosis.inference.model import HeldOutScore
from missionplan.diagnosis.inference.selection import inclusion, rivals
from missionplan.diagnosis.pipeline import PipelineResult
from missionplan.results.learned.evidence import Causes, Coverage, Readings, Verdict


@dataclass(frozen=True)
class Judgement:
    """What may be said."""

    verdict: Verdict
    credible_set: tuple[Causes, ...]
    """Sets that hold 95 % of the probability."""
    rivals: tuple[Causes, ...]
    """Sets within 3 nats of the claimed one."""
    not_constant: Causes
    """Claimed causes that do not hold still."""
    suspect_labels: str
    """Which labels of the record look wrong; empty where none do."""
    none_of_these: float
    """Probability that something outside the catalogue is left."""
    coverage: Coverage | None
    """Of the 90 % intervals of the model claimed, else of the base model's, on data held out; None where unknown."""


def judge(bound: DataKind, found: PipelineResult) -> Judgement:
    """Judge what the pipeline found on a data set."""
    causes = found.best.causes
    not_constant = bound.not_constant(found.best) if causes else ()
    verdict = found.reading.verdict(is_constant=not not_constant)
    if not causes and verdict != "adequate":  # also where the likeliest set cannot be fitted
        verdict = "unexplained"
    return Judgement(
        bound.limited_verdict(verdict),
        found.credible_set,
        tuple(rivals(found.posterior, causes)) if causes else (),
        not_constant,
        bound.suspect_labels(found.selection),
        found.reading.none_of_these,
        interval_coverage(_held_out(found)),
    )


def _held_out(found: PipelineResult) -> tuple[HeldOutScore, ...]:
    """Held-out scores of the model that is believed; none where none were made."""
    own = found.held_out.get(found.best.causes)
    if own is not None:
        return own.extended
    return next((comparison.base for comparison in found.held_out.values()), ()) if not found.best.causes else ()


def read(bound: DataKind, found: PipelineResult) -> Readings:
    """Return what else the posterior says."""
    selection, best = found.selection, found.best
    return Readings(
        inclusion(found.posterior),
        selection.responses,
        selection.not_computed,
        tuple(family for family in selection.families if best.causes in family),
        bound.aliases(best) if best.causes else (),
        _predicts_better(bound, found) if best.causes else None,
    )


def _predicts_better(bound: DataKind, found: PipelineResult) -> bool | None:
    """Whether the claimed set predicts data kept away better, in single groups and all the way."""
    held_out = found.held_out.get(found.best.causes)
    if held_out is None:
        return None
    return held_out.gain.log_score_gain > 0.0 and bound.is_better_ahead(found.selection.base, found.best)
