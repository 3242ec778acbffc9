"""Gain: how much better the extended model predicts data that it has not seen."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from missionplan.diagnosis.inference.model import HeldOutScore
from missionplan.results.diagnosis import HeldOutGain


@dataclass(frozen=True)
class HeldOut(HeldOutGain):
    """Held-out scores of an extended model beside the base model's, with those of each group."""

    base: tuple[HeldOutScore, ...]
    extended: tuple[HeldOutScore, ...]


def held_out_gain(base: Sequence[HeldOutScore], extended: Sequence[HeldOutScore]) -> HeldOut:
    """Compare two models' scores on the same groups."""
    difference = np.array([b.log_score - a.log_score for a, b in zip(base, extended, strict=True)])
    spread = float(difference.std(ddof=1)) if len(difference) > 1 else math.nan
    (rmse_base, coverage_base), (rmse_extended, coverage_extended) = _overall(base), _overall(extended)
    return HeldOut(
        float(difference.sum()),
        spread * math.sqrt(len(difference)),
        int((difference > 0.0).sum()),
        len(difference),
        rmse_base,
        rmse_extended,
        coverage_base,
        coverage_extended,
        tuple(base),
        tuple(extended),
    )


def _overall(scores: Sequence[HeldOutScore]) -> tuple[float, float]:
    count = sum(score.count for score in scores)
    rmse = math.sqrt(sum(score.squared_error for score in scores) / count)
    return rmse, sum(score.inside for score in scores) / count
