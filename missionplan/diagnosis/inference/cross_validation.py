"""Held-out gain: how much better the extended model predicts data that it was not fitted to.

Each group (a run, a block of legs) is left out in turn and predicted from the others: leave-one-group-out
cross-validation, scored by the log density (Gneiting & Raftery 2007, *J. Am. Stat. Assoc.* 102, section 4.1: a
strictly proper rule).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from missionplan.arrays import Array
from missionplan.diagnosis.inference.marginal_likelihood import QUANTILE_95
from missionplan.diagnosis.inference.model import HeldOutScore
from missionplan.montecarlo.statistics import wilson
from missionplan.results.learned.evidence import Coverage, HeldOutGain


@dataclass(frozen=True)
class HeldOutComparison:
    """Two models' predictions of the same held-out groups."""

    gain: HeldOutGain
    """Of the extended model over the base model, all groups together."""
    base: tuple[HeldOutScore, ...]
    extended: tuple[HeldOutScore, ...]
    """Group by group."""


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


STATED = 0.9
"""Probability of the intervals."""


def interval_coverage(scores: Sequence[HeldOutScore]) -> Coverage | None:
    """Count values inside their intervals, and fit the factor where they are too many or too few.

    A conformal factor: the quantile of the standardised errors of held-out groups (Vovk, Gammerman & Shafer 2005,
    *Algorithmic Learning in a Random World*), assessed on groups that it was not fitted to.

    Parameters
    ----------
    scores : sequence of HeldOutScore
        With standardised errors.

    Returns
    -------
    Coverage or None
        None without standardised errors, or of a single group.
    """
    groups = [np.abs(np.array(score.standardised)) for score in scores if score.standardised]
    if len(groups) < 2:
        return None
    together = np.concatenate(groups)
    inside, count = _inside(together, 1.0), len(together)
    found = wilson(inside, count)
    if found.low <= STATED <= found.high:
        return Coverage(inside, count, 1.0, inside)
    others = (np.concatenate([*groups[:index], *groups[index + 1 :]]) for index in range(len(groups)))
    scaled = sum(_inside(group, _factor(rest)) for group, rest in zip(groups, others, strict=True))
    return Coverage(inside, count, _factor(together), scaled)


def _factor(sizes: Array) -> float:
    return float(np.quantile(sizes, STATED)) / QUANTILE_95


def _inside(sizes: Array, factor: float) -> int:
    return int(np.count_nonzero(sizes <= factor * QUANTILE_95))
