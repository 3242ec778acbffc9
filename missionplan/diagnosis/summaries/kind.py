"""Summaries of dives as a kind of data, with residuals number by number and the misfit in the planner's terms.

They are bound to the mission's first mooring at its means.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Self

import numpy as np
import pandas as pd

from missionplan.datasets.summaries import SummaryData, read_summary
from missionplan.diagnosis.data_kind import DataKind
from missionplan.diagnosis.dives.kind import descent_shares
from missionplan.diagnosis.dives.model_factory import descent_builder, given_on_descent
from missionplan.diagnosis.given.effects import GivenEffect
from missionplan.diagnosis.inference.model import CauseFit
from missionplan.diagnosis.learned_data import as_then, unlearned
from missionplan.diagnosis.plan_gain import anchor_choice, plan_gain
from missionplan.diagnosis.summaries.model import SummaryForward, SummaryModel, as_log
from missionplan.mission import Mission
from missionplan.results.learned.diagnosis import PlanGain
from missionplan.results.learned.evidence import Verdict


def summary_model(data: SummaryData, mission: Mission) -> SummaryModel:
    """Bind a mission's first mooring to summaries of dives.

    Raises
    ------
    InputError
        When the mission lacks what a descent needs.
    """
    logs = tuple(as_log(test) for test in data.tests)
    return SummaryModel(SummaryForward(descent_builder(mission), logs, tests=data.tests), given_on_descent(mission))


@dataclass(frozen=True)
class SummaryKind(DataKind):
    """A few numbers of each dive, as papers print them."""

    ids = ("summary",)

    kind: str
    mission: Mission
    data: SummaryData
    model: SummaryModel

    @classmethod
    def bind(cls, kind: str, folder: Path, mission: Mission, seed: int) -> Self:
        """Read the tests and bind the mission's first mooring to them."""
        data = unlearned(read_summary(folder, mission), mission)
        then = as_then(data, mission, data.date)
        return cls(kind, then, data, summary_model(data, then))

    @property
    def given(self) -> tuple[GivenEffect, ...]:
        """The mission's own effects that the data could show."""
        return self.model.given

    def residual_table(self, base: CauseFit, best: CauseFit) -> pd.DataFrame:
        """Return one row a number."""
        return summary_residuals(self.model, base, best)

    def misfit(self, residuals: pd.DataFrame) -> str:
        """Describe the number that is farthest off."""
        return summary_misfit(residuals)

    def shares_explained(self, base: CauseFit, fits: Sequence[CauseFit], residuals: pd.DataFrame) -> list[float]:
        """Return the share of the squared residuals, in standard deviations, that goes with each fit."""
        return descent_shares(self.model, base, fits)

    def plan_gain(self, base: Mission, extended: Mapping[str, object], *, seed: int, jobs: int) -> PlanGain:
        """Compare the anchors chosen."""
        return plan_gain(anchor_choice, base, extended, seed=seed, jobs=jobs)

    def limited_verdict(self, verdict: Verdict) -> Verdict:
        """Return at most ``ambiguous``: a few numbers, their times shifted by hand, prove no cause."""
        return "ambiguous" if verdict == "explained" else verdict


WORDS = {"terminal_velocity_m_s": ("terminal velocity", "m/s"), "descent_time_s": ("descent time", "s")}
"""Quantities in words, and their units."""


def summary_residuals(model: SummaryModel, base: CauseFit, best: CauseFit) -> pd.DataFrame:
    """Return one row a number: measured, both models', and residuals in standard deviations.

    Where a test has a simulated number too, ``measured`` is less that, and a model's is less the base model's.
    """
    places = np.stack([base.state.linear.at, best.state.linear.at], axis=1)
    found = model.forward.readings(model.coordinates, places)
    tests = model.forward.tests
    return pd.DataFrame(
        {
            "run": np.repeat([test.name for test in tests], [len(test.quantities) for test in tests]),
            "quantity": [quantity for test in tests for quantity in test.quantities],
            "less_simulated": [relative for test in tests for relative in test.relative],
            "measured": model.y,
            "sd": model.units,
            "base": found[:, 0],
            "extended": found[:, 1],
            "residual_base_sd": (model.y - found[:, 0]) / model.units,
            "residual_extended_sd": (model.y - found[:, 1]) / model.units,
        }
    )


def summary_misfit(table: pd.DataFrame) -> str:
    """Describe the number that is farthest from the base model's, in standard deviations."""
    worst = table.iloc[int(np.argmax(np.abs(table["residual_base_sd"].to_numpy())))]
    words, unit = WORDS[worst["quantity"]]
    off = worst["measured"] - worst["base"]
    return (
        f"Of {len(table)} numbers of {table['run'].nunique()} tests the farthest from the simulation is the {words} of "
        f"{worst['run']}, {abs(off):.2f} {unit} {'above' if off > 0.0 else 'below'} it, "
        f"{abs(worst['residual_base_sd']):.1f} standard deviations."
    )
