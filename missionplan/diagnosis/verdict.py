"""Verdict: what may be said, by the rules of the contract and nothing else."""

from dataclasses import dataclass
from typing import Literal

from missionplan.diagnosis.inference.cross_validation import HeldOut
from missionplan.diagnosis.inference.discrepancy import Discrepancy
from missionplan.diagnosis.inference.selection import COMPLEXITY_PENALTY, Candidate, Selection, rivals

Verdict = Literal["adequate", "explained", "ambiguous", "partly-explained", "unexplained"]


@dataclass(frozen=True)
class Claim:
    """A claimed set with its rivals."""

    candidate: Candidate
    rivals: tuple[Candidate, ...]


def claim(selection: Selection, gain: HeldOut | None) -> Claim | None:
    """Claim the best non-empty set if its score exceeds 3 nats and its held-out gain is positive.

    Signs and sizes were judged before: impossible sets are not in the ranking.
    """
    if not selection.ranking or gain is None:
        return None
    best = selection.ranking[0]
    if best.score <= COMPLEXITY_PENALTY or gain.log_score_gain <= 0.0:
        return None
    return Claim(best, tuple(rivals(selection, best)))


def verdict(claimed: Claim | None, discrepancy: Discrepancy) -> Verdict:
    """The first that fits."""
    if claimed is None:
        return "unexplained" if discrepancy.significant else "adequate"
    if discrepancy.significant:
        return "partly-explained"
    return "ambiguous" if claimed.rivals else "explained"
