"""Held-out gain: how much better the extended model predicts data that it was not fitted to.

Each group (a run, a block of legs) is left out in turn and predicted from the others: leave-one-group-out
cross-validation, scored by the log density (Gneiting & Raftery 2007, *J. Am. Stat. Assoc.* 102, section 4.1: a
strictly proper rule).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from missionplan.diagnosis.inference.model import HeldOutScore
from missionplan.results.learned.evidence import HeldOutGain


@dataclass(frozen=True)
class HeldOutComparison:
    """Two models' predictions of the same held-out groups.

    Attributes
    ----------
    base, extended : tuple of HeldOutScore
        Group by group.
    """

    gain: HeldOutGain
    """Of the extended model over the base model, all groups together."""
    base: tuple[HeldOutScore, ...]
    extended: tuple[HeldOutScore, ...]


def compare_held_out(base: Sequence[HeldOutScore], extended: Sequence[HeldOutScore]) -> HeldOutComparison:
    """Compare two models' scores on the same groups.

    The standard error of the summed difference is √n times the standard deviation of the groups' differences
    (Vehtari, Gelman & Gabry 2017, *Stat. Comput.* 27, Eq. 24).
    """
    difference = np.array([b.log_score - a.log_score for a, b in zip(base, extended, strict=True)])
    spread = float(difference.std(ddof=1)) if len(difference) > 1 else math.nan
    (rmse_base, coverage_base), (rmse_extended, coverage_extended) = _overall(base), _overall(extended)
    gain = HeldOutGain(
        log_score_gain=float(difference.sum()),
        paired_se=spread * math.sqrt(len(difference)),
        groups_improved=int((difference > 0.0).sum()),
        groups=len(difference),
        rmse_base=rmse_base,
        rmse_extended=rmse_extended,
        coverage_90_base=coverage_base,
        coverage_90_extended=coverage_extended,
    )
    return HeldOutComparison(gain, tuple(base), tuple(extended))


def _overall(scores: Sequence[HeldOutScore]) -> tuple[float, float]:
    """Root mean square error, and share of values inside their 90 % intervals, of all groups together."""
    count = sum(score.count for score in scores)
    rmse = math.sqrt(sum(score.squared_error for score in scores) / count)
    return rmse, sum(score.inside for score in scores) / count
