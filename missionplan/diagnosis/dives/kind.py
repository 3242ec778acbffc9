"""Dive logs as a kind of data."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Self

import pandas as pd

from missionplan.datasets.dives import read_descent
from missionplan.diagnosis.coordinates import Coordinate
from missionplan.diagnosis.data_kind import DataKind
from missionplan.diagnosis.dives.consistency.constancy import not_constant
from missionplan.diagnosis.dives.consistency.labels import EXCHANGED
from missionplan.diagnosis.dives.model import DescentModel
from missionplan.diagnosis.dives.model_factory import check_leaves_surface, descent_model
from missionplan.diagnosis.dives.preparation import PreparedDives, prepare_dives
from missionplan.diagnosis.dives.tables import descent_misfit, descent_residuals, descent_shares
from missionplan.diagnosis.given.effects import GivenEffect
from missionplan.diagnosis.inference.model import CauseFit
from missionplan.diagnosis.inference.selection import LIKELY, Selection
from missionplan.diagnosis.learned_data import as_then, unlearned
from missionplan.diagnosis.plan_gain import anchor_choice, plan_gain
from missionplan.mission import Mission
from missionplan.results.learned.diagnosis import PlanGain
from missionplan.results.learned.evidence import Causes


@dataclass(frozen=True)
class DescentKind(DataKind):
    """Depth against time, dive by dive."""

    ids = ("descent",)

    kind: str
    mission: Mission
    data: PreparedDives
    model: DescentModel

    @classmethod
    def bind(cls, kind: str, folder: Path, mission: Mission, seed: int) -> Self:
        """Read the dives and bind the mission's first mooring to them."""
        measured = read_descent(folder, mission)
        check_leaves_surface(measured, mission)
        data = unlearned(prepare_dives(measured), mission)
        then = as_then(data, mission, data.date)
        return cls(kind, then, data, descent_model(data, then))

    @property
    def model_coordinates(self) -> Sequence[Coordinate]:
        """Parameters of all causes as the model fits them."""
        return self.model.coordinates

    @property
    def given(self) -> tuple[GivenEffect, ...]:
        """The mission's own effects that the data could show."""
        return self.model.given

    def residual_table(self, base: CauseFit, best: CauseFit) -> pd.DataFrame:
        """Return one row a reading."""
        return descent_residuals(self.model, base, best)

    def misfit(self, residuals: pd.DataFrame) -> str:
        """Describe how late or early the vehicle is."""
        return descent_misfit(residuals)

    def shares_explained(self, base: CauseFit, fits: Sequence[CauseFit], residuals: pd.DataFrame) -> list[float]:
        """Return the share of the squared depth residuals that goes with each fit."""
        return descent_shares(self.model, base, fits)

    def not_constant(self, best: CauseFit) -> Causes:
        """Return the causes whose strengths differ from dive to dive."""
        return not_constant(self.model, best)

    def suspect_labels(self, found: Selection) -> str:
        """Say between which dives the labels of the weights look exchanged."""
        is_likely = any(what == EXCHANGED and probability >= LIKELY for _, what, probability in found.responses)
        return str(self.model.exchanged_labels(found.base)) if is_likely else ""

    def plan_gain(self, base: Mission, extended: Mapping[str, object], *, seed: int, jobs: int) -> PlanGain:
        """Compare the anchors chosen."""
        return plan_gain(anchor_choice, base, extended, seed=seed, jobs=jobs)
