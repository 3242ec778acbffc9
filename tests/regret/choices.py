"""What is chosen with a mission, and what the choice loses when another mission is the truth."""

import copy
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from missionplan.mission import Mission
from missionplan.scenario.anchors import worst_case_weight
from missionplan.scenario.scenario import Scenario
from missionplan.studies.anchor.lightest_anchor import Demand, lightest_anchor
from missionplan.studies.anchor.sizing import AnchorTrials
from missionplan.studies.leg_length.sweep_dmax import sweep_dmax

REQUIRED = 0.95
"""Probability that an anchor must have."""
WORST = 1.0
"""Loss of a choice that never arrives, and the greatest of any: the whole mission."""
TRIED = np.geomspace(0.3, 3.0, 24)
"""Weights over the worst case's of which the likeliest to succeed is taken where none reaches the probability."""


@dataclass(frozen=True)
class LegChoice:
    """The d_max that is recommended for a mission, and what every d_max costs it."""

    chosen: int
    loss: np.ndarray

    @property
    def is_possible(self) -> bool:
        """Whether any d_max arrives."""
        return bool(np.isfinite(self.loss).any())

    @classmethod
    def of(cls, mission: Mission, trials: int) -> "LegChoice":
        """Sweep d_max; the loss is the time per arrival, in nominal times."""
        curve = sweep_dmax(mission, trials=trials, seed=3, method="monte-carlo").curves[0]
        arrived = np.array([point.arrived.value for point in curve.points])
        cost = np.array([point.cost for point in curve.points])
        with np.errstate(divide="ignore", invalid="ignore"):
            loss = np.where(arrived > 0.0, (1.0 + cost) / arrived, np.inf)
        return cls(curve.recommended_index, loss)

    def regret(self, truth: "LegChoice") -> float:
        """Loss beyond that of the best d_max when another mission is the truth, relative to it."""
        best = float(truth.loss.min())
        return min(float(truth.loss[self.chosen] / best - 1.0), WORST)

    def outcome(self, truth: "LegChoice") -> dict[str, float]:
        """Mean time per arrival where the truth holds, in nominal times; that of the best d_max."""
        return {"chosen": float(truth.loss[self.chosen]), "best": float(truth.loss.min())}


@dataclass(frozen=True)
class AnchorChoice:
    """The lightest anchor that reaches the probability in a mission [N]; where none does, the likeliest to succeed."""

    weight: float
    is_possible: bool
    trials: AnchorTrials

    @classmethod
    def of(cls, mission: Mission, trials: int) -> "AnchorChoice":
        """Search the lightest anchor."""
        means = Scenario.at_means(mission)
        moor = means.moor()
        study = AnchorTrials(mission, moor.name, None, trials, 3)
        start = worst_case_weight(means, moor)
        line = float(moor.line_length)
        asked = Demand("dives that succeed", REQUIRED, lambda found: found.good.value, is_hill=True)
        found = lightest_anchor(study.probabilities, [asked], start, line).weight
        if found is not None:
            return cls(found, True, study)
        tried = start * TRIED
        good = [study.probabilities(weight).good.value for weight in tried.tolist()]
        return cls(float(tried[int(np.argmax(good))]), False, study)

    def regret(self, truth: "AnchorChoice") -> float:
        """Needless weight over that of the anchor chosen in knowledge of the truth, or what is missing of the probability.

        Both are shares of what is asked: 10 % too heavy, or successful in 85.5 % of the dives instead of 95 %, is 0.1.
        """
        reached = truth.trials.probabilities(self.weight).good.value
        missing = max(REQUIRED - reached, 0.0) / REQUIRED
        return min(max(self.weight / truth.weight - 1.0, 0.0) + missing, WORST)

    def outcome(self, truth: "AnchorChoice") -> dict[str, float]:
        """Weight of the choice and of the best [N], and the share of dives that succeed where the truth holds."""
        reached = truth.trials.probabilities(self.weight).good.value
        return {"chosen": self.weight, "best": truth.weight, "success": reached}


def with_truth(mission: Mapping[str, Any], truth: Mapping[str, Any]) -> Mission:
    """The mission with the true effect."""
    return Mission.from_data({**copy.deepcopy(dict(mission)), "effects": [dict(truth)]})
