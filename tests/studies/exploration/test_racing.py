"""A race finds the best of a full exploration with a part of its trials."""

from pathlib import Path

import numpy as np
import pytest

import missionplan
from missionplan.mission import Mission
from missionplan.studies.exploration.cells import CellTrials
from missionplan.studies.exploration.explore import race

MISSIONS = Path(__file__).parents[3] / "missions"


@pytest.fixture(scope="module")
def mission():
    return missionplan.load(MISSIONS / "chesapeake.yaml")


def test_a_race_ends_with_the_numbers_of_a_full_exploration(mission):
    data = {**mission.raw, "phases": mission.raw["phases"][:1], "requirements": mission.raw["requirements"][:1]}
    way_in, vary = Mission.from_data(data, file=mission.file), ["ingress.speed=0.8:1.6:0.4 m/s"]
    full, raced = (
        missionplan.explore(way_in, vary, aim="energy", trials=1500, only_best=only) for only in (False, True)
    )
    assert raced.best == full.best
    assert raced.best_cell.quantities == full.best_cell.quantities
    assert raced.provenance.options["trials_run"] < full.provenance.options["trials_run"]
    assert any(cell.dropped for cell in raced.cells)
    assert raced.windows == ()


def made_cells(seed, trials=2000, cells=40):
    """Trials of cells whose costs differ by little and share most of their noise; every other misses a requirement."""
    rng = np.random.default_rng(seed)
    common, own = rng.normal(size=trials), rng.normal(size=(cells, trials))
    costs = 30.0 + 0.05 * rng.permutation(cells)[:, None] + common + 0.1 * own
    met = rng.random((cells, trials)) < np.where(np.arange(cells) % 2, 0.9, 0.999)[:, None]
    return costs, met


@pytest.mark.parametrize("seed", range(5))
def test_the_best_that_meets_its_requirement_is_not_dropped(mission, seed):
    costs, met = made_cells(seed)
    one = mission.model_copy(update={"requirements": mission.requirements[:1]})  # 95 % arrive

    def run(items):
        found = [CellTrials({})] * len(costs)
        for cell, _, size in items:
            columns = {"total.success": met[cell, :size], "requirement 0": met[cell, :size]}
            columns["total.energy_wh"] = costs[cell, :size]
            found[cell] = CellTrials(columns)
        return found

    result = race(one, len(costs), 2000, "energy", run)
    feasible = [cell for cell in range(len(costs)) if met[cell].mean() >= 0.95]
    best = min(feasible, key=lambda cell: costs[cell].mean())
    assert best not in result.dropped
    assert result.spent < 0.5 * costs.size
