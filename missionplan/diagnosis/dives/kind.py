"""Dive logs as a kind of data, with residuals reading by reading and the misfit in the planner's terms."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Self

import numpy as np
import pandas as pd

from missionplan.datasets.dives import read_descent
from missionplan.diagnosis.coordinates import Coordinate
from missionplan.diagnosis.data_kind import DataKind, PutOff
from missionplan.diagnosis.dives.consistency import EXCHANGED, not_constant
from missionplan.diagnosis.dives.model import DescentModel, check_leaves_surface, descent_model
from missionplan.diagnosis.dives.preparation import PreparedDives, prepare_dives
from missionplan.diagnosis.inference.model import CauseFit
from missionplan.diagnosis.inference.selection import LIKELY, Selection
from missionplan.diagnosis.learned_data import as_then, unlearned
from missionplan.mission import Mission
from missionplan.results.learned.evidence import Causes


@dataclass(frozen=True)
class DescentKind(DataKind):
    """Depth against time, dive by dive."""

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

    def residual_table(self, base: CauseFit, best: CauseFit) -> pd.DataFrame:
        """Return one row a reading."""
        places = np.stack([base.state.linear.at, best.state.linear.at], axis=1)
        depths = self.model.forward.readings(self.model.coordinates, places)
        logs = self.model.forward.logs
        return pd.DataFrame(
            {
                "run": np.concatenate([np.full(len(log.t), log.name) for log in logs]),
                "t_s": np.concatenate([log.t for log in logs]),
                "depth_m": self.model.y,
                "base_m": depths[:, 0],
                "extended_m": depths[:, 1],
                "residual_base_m": self.model.y - depths[:, 0],
                "residual_extended_m": self.model.y - depths[:, 1],
                "innovation_base": self.model.innovations(base),
                "innovation_extended": self.model.innovations(best),
            }
        )

    def misfit(self, residuals: pd.DataFrame) -> str:
        """Describe how late or early the vehicle is where the logs end, on the mean and at worst."""
        late = {}
        for name, run in residuals.groupby("run", sort=False):
            last, half = run.tail(max(3, len(run) // 10)), run.tail(len(run) // 2)
            speed = max(float(np.polyfit(half["t_s"], half["base_m"], 1)[0]), LEAST_SPEED)
            late[str(name)] = float((-last["residual_base_m"]).mean()) / speed, float(last["depth_m"].mean())
        mean_delay, mean_depth = (float(np.mean([entry[k] for entry in late.values()])) for k in (0, 1))
        worst = max(late, key=lambda name: abs(late[name][0]))
        delay, depth = late[worst]
        return (
            f"The vehicle arrives {abs(mean_delay):.1f} s {_late_or_early(mean_delay)} at {mean_depth:.0f} m on the "
            f"mean of the dives; the farthest off is {worst}, {abs(delay):.1f} s {_late_or_early(delay)} at "
            f"{depth:.0f} m."
        )

    def shares_explained(self, base: CauseFit, fits: Sequence[CauseFit], residuals: pd.DataFrame) -> list[float]:
        """Return the share of the squared depth residuals that goes with each fit."""
        return descent_shares(self.model, base, fits)

    def not_constant(self, best: CauseFit) -> Causes:
        """Return the causes whose strengths differ from dive to dive."""
        return not_constant(self.model, best)

    def put_off(self) -> Iterator[PutOff]:
        """Yield what the dives take as exact, what is put in its place, and the model then."""
        heavy = [replace(dive, wet_weight=1.02 * dive.wet_weight) for dive in self.data.dives]
        long = [replace(dive, line_length=1.02 * dive.line_length) for dive in self.data.dives]
        late = [replace(dive, t=1.01 * dive.t, fine=1.01 * dive.fine) for dive in self.data.dives]
        for words, otherwise, dives in (
            ("anchors weigh what their labels say", "2 % more", heavy),
            ("lines are as long as stated", "2 % longer", long),
            ("the clock runs right", "one that is 1 % slow", late),
        ):
            yield words, otherwise, descent_model(replace(self.data, dives=tuple(dives)), self.mission)

    def suspect_labels(self, selection: Selection) -> str:
        """Say between which dives the labels of the weights look exchanged."""
        is_likely = any(what == EXCHANGED and probability >= LIKELY for _, what, probability in selection.responses)
        return str(self.model.exchanged_labels(selection.base)) if is_likely else ""


LEAST_SPEED = 0.05
"""Speed below which a depth error is not converted to a delay with the speed itself [m/s]."""


def descent_shares(model: DescentModel, base: CauseFit, fits: Sequence[CauseFit]) -> list[float]:
    """Return the share of the base model's squared residuals that goes with each set, by one call of the phase."""
    places = np.stack([fit.state.linear.at for fit in (base, *fits)], axis=1)
    left = (model.y[:, None] - model.forward.readings(model.coordinates, places)) / model.units[:, None]
    before, *after = (float(value) for value in np.sum(left**2, axis=0))
    return [float(np.clip(1.0 - value / max(before, 1e-30), 0.0, 1.0)) for value in after]


def _late_or_early(delay: float) -> str:
    return "late" if delay > 0 else "early"
