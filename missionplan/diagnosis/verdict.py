"""Verdict: what may be said of a data set, by fixed rules (`docs/diagnosis.md`)."""

from dataclasses import dataclass
from types import MappingProxyType

from missionplan.diagnosis.inference.cross_validation import HeldOutComparison
from missionplan.diagnosis.inference.posterior import LogBayesFactors, rivals
from missionplan.diagnosis.inference.selection import Candidate, Selection
from missionplan.results.learned.evidence import CLAIM, Discrepancy, Verdict


@dataclass(frozen=True)
class Claim:
    """A claimed set with its rivals."""

    candidate: Candidate
    rivals: tuple[Candidate, ...]


def claim(
    selection: Selection, held_out: HeldOutComparison | None, checked: LogBayesFactors = MappingProxyType({})
) -> Claim | None:
    """Claim the best non-empty set if its score exceeds 4 nats and its held-out gain is positive.

    Signs and sizes were judged before: impossible sets are not in the ranking.

    Parameters
    ----------
    selection : Selection
        Every set that was tried.
    held_out : HeldOutComparison or None
        Of the best set, where it was measured.
    checked : mapping
        ln Bayes factors of the sets that were checked by importance sampling, for the rivals.
    """
    if not selection.ranking or held_out is None:
        return None
    best = selection.ranking[0]
    if best.score <= CLAIM or held_out.gain.log_score_gain <= 0.0:
        return None
    return Claim(best, tuple(rivals(selection, best, checked)))


def limited(verdict: Verdict, *, is_constant: bool, is_separable: bool) -> Verdict:
    """Return a verdict as far as a claimed cause that changes, or that looks like another, allows it."""
    if verdict in ("explained", "ambiguous") and not is_constant:
        return "partly-explained"
    return "ambiguous" if verdict == "explained" and not is_separable else verdict


def verdict(claimed: Claim | None, discrepancy: Discrepancy) -> Verdict:
    """Return the first verdict that fits."""
    if claimed is None:
        return "unexplained" if discrepancy.significant else "adequate"
    if discrepancy.significant:
        return "partly-explained"
    return "ambiguous" if claimed.rivals else "explained"
