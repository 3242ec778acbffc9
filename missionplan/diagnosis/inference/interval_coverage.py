"""Whether prediction intervals hold what they should, and by how much wider they would."""

from collections.abc import Sequence

import numpy as np

from missionplan.arrays import Array
from missionplan.diagnosis.inference.marginal_likelihood import QUANTILE_95
from missionplan.diagnosis.inference.model import HeldOutScore
from missionplan.montecarlo.statistics import wilson
from missionplan.results.learned.evidence import Coverage

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
