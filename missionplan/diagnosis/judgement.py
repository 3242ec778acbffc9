"""What may be said of a data set: the verdict with its limits, the credible set, and what the catalogue leaves out."""

import math
from dataclasses import dataclass

from missionplan.diagnosis.data_kind import DataKind
from missionplan.diagnosis.inference.interval_coverage import interval_coverage
from missionplan.diagnosis.inference.model import HeldOutScore
from missionplan.diagnosis.pipeline import PipelineResult
from missionplan.diagnosis.verdict import limited
from missionplan.results.learned.evidence import Causes, Coverage, Discrepancy, Verdict


@dataclass(frozen=True)
class Judgement:
    """What may be said.

    Attributes
    ----------
    verdict : str
    credible_set : tuple
        Sets that hold 95 % of the probability, and those that the data cannot separate from the claimed one.
    rivals : tuple
        Sets within 3 nats of the claimed one, and those.
    inseparable : tuple
        Those.
    not_constant : tuple of str
        Claimed causes that do not hold still.
    suspect_labels : str
        Which labels of the record look wrong; empty where none do.
    none_of_these : float
        Probability that something outside the catalogue is left.
    coverage : Coverage or None
        Of the 90 % intervals of the model claimed, else of the base model's, on data held out; None where unknown.
    """

    verdict: Verdict
    credible_set: tuple[Causes, ...]
    rivals: tuple[Causes, ...]
    inseparable: tuple[Causes, ...]
    not_constant: Causes
    suspect_labels: str
    none_of_these: float
    coverage: Coverage | None


def judge(bound: DataKind, found: PipelineResult, jobs: int = 1) -> Judgement:
    """Judge what the pipeline found on a data set, by so many processes."""
    causes = found.best.causes
    inseparable = bound.inseparable(causes) if causes else ()
    not_constant = bound.not_constant(found.best) if causes else ()
    rivals = tuple(rival.causes for rival in found.claimed.rivals) if found.claimed else ()
    suspect = bound.suspect_labels(found.selection.base, found.best, jobs)
    verdict = limited(found.verdict, is_constant=not not_constant and not suspect, is_separable=not inseparable)
    if suspect and not causes:
        verdict = "unexplained"
    return Judgement(
        bound.limited_verdict(verdict),
        tuple(dict.fromkeys((*found.credible_set, *inseparable))),
        tuple(dict.fromkeys((*rivals, *inseparable))),
        inseparable,
        not_constant,
        suspect,
        none_of_these(found.discrepancy, found.selection.catalogue),
        interval_coverage(_held_out(found)),
    )


def _held_out(found: PipelineResult) -> tuple[HeldOutScore, ...]:
    """Held-out scores of the model that is believed; none where none were made."""
    own = found.held_out.get(found.best.causes)
    if own is not None:
        return own.extended
    return next((comparison.base for comparison in found.held_out.values()), ()) if found.claimed is None else ()


def none_of_these(left: Discrepancy, catalogue: int) -> float:
    """Return the probability that something which no cause of the catalogue explains is left.

    Its prior odds are those of one cause more. The evidence is the Bayes factor of the smooth discrepancy, or the
    most that the p-values of the residual tests can mean, −1/(e·p·ln p), where that is more (Sellke, Bayarri & Berger
    2001, *Am. Stat.* 55).

    Parameters
    ----------
    left : Discrepancy
        What the claimed model leaves.
    catalogue : int
        Number of effects that the data could show.
    """
    smallest = min((test.p_value * len(left.tests) for test in left.tests), default=1.0)
    smallest = min(max(smallest, 1e-300), 1.0 / math.e)
    evidence = max(left.log_bayes_factor, -math.log(-math.e * smallest * math.log(smallest)))
    log_odds = evidence - math.log(catalogue + 1.0)
    return 1.0 / (1.0 + math.exp(-log_odds)) if log_odds > -700.0 else 0.0
