"""Dives of a vehicle whose drag is more than its mission's, mission after mission, by `tests.hidden_effects.dives`."""

import csv
from collections.abc import Mapping
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
import yaml

from missionplan.diagnosis.data_kind import bind_dataset
from missionplan.diagnosis.explanations import explained_missions
from missionplan.diagnosis.inference.model import CauseFit, fitted
from missionplan.mission import Mission
from tests.hidden_effects.dives.dynamics import Dive, DiveEffect
from tests.hidden_effects.dives.files import measure, mission_files
from tests.hidden_effects.dives.trials import draw_nuisances, draw_plan

DRAG = "drag-bias"
DIVES, LINE, SPREAD = 4, 4.0, 2.0
"""Dives a mission; length of the line [m]; weight of the heavy anchor over that of the light one."""
NUISANCE_DRAG = 0.007
BEGIN, DAYS = datetime(2026, 1, 10, tzinfo=UTC), 30
Record = tuple[list[str], list[list[str]], Mapping[str, object]]


class Diving:
    """A vehicle that dives with a light and a heavy anchor, each twice a mission.

    Parameters
    ----------
    rng : numpy.random.Generator
    truths : mapping
        Levels of its drag's error in each mission.
    """

    def __init__(self, rng: np.random.Generator, truths: Mapping[str, np.ndarray]) -> None:
        self.rng, self.truths = rng, truths
        plan = draw_plan(rng, "single", ())
        craft = plan.craft
        middle = craft.net_buoyancy + craft.drag(1.3)
        weights = [round(middle * SPREAD ** (k % 2 - 0.5), 2) for k in range(DIVES)]
        # the second pair of dives is by a line of twice the length
        dives = [Dive(w, LINE * (1 + k // 2), plan.site_depth, number=k) for k, w in enumerate(weights)]
        self.plan = replace(plan, dives=tuple(dives), states_depth=True, vehicle_form="inline")
        self.noise = draw_nuisances(rng, "single")
        self.mission = Mission.from_data(mission_files(self.plan, rng)[0])

    def record(self, number: int) -> Record:
        """Make a mission: header, rows and ``dataset.yaml`` of its dives."""
        factor = 1.0 + self.truths[DRAG][number] + NUISANCE_DRAG * float(self.rng.standard_normal())
        fouled = DiveEffect(lone_drag=factor, drag=lambda t, u, z, dive: factor)
        header, rows, told = measure(self.plan, self.noise, (fouled,), self.rng)
        return header, rows, told | {"start": (BEGIN + timedelta(days=DAYS * number)).isoformat()}

    def halves(self, record: Record) -> list[Record]:
        """Two dives of either weight, and the others."""
        header, rows, told = record
        found = []
        for names in (("dive-1", "dive-4"), ("dive-2", "dive-3")):
            runs = {name: told["runs"][name] for name in names}
            found.append((header, [row for row in rows if row[0] in names], {**told, "runs": runs}))
        return found

    def data(self, place: Path, record: Record) -> Path:
        """Write a record as a data set."""
        header, rows, told = record
        place.mkdir()
        (place / "dataset.yaml").write_text(yaml.safe_dump(dict(told)))
        with (place / "dives.csv").open("w", newline="") as file:
            csv.writer(file).writerows([header, *rows])
        return place

    def score(self, mission: Mission, place: Path) -> float:
        """Log evidence of a mission as it stands for dives that it has not seen, over its explanations."""
        logs = []
        for each in explained_missions(mission):
            (fit,) = fitted(bind_dataset(place, each.mission, 1).model, [((), ())], 1)
            logs.append(np.log(each.prior) + fit.log_evidence if isinstance(fit, CauseFit) else -np.inf)
        return float(np.logaddexp.reduce(logs))
