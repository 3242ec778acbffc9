"""Choices between missions through a strait: those that touch its shores are seen to fail."""

import json
import math

import pytest
import scipy

from missionplan.mission import Mission
from missionplan.studies.exploration.explore import explore
from missionplan.studies.optimisation.optimise import optimise

pytestmark = pytest.mark.usefixtures("unassumed", "unplanned", "unranked", "unheld")

pytest.importorskip("shapely")
HALF_WIDTH = 25.0


@pytest.fixture
def strait(tmp_path):
    """A passage at 500 m, 50 m wide: one long leg drifts 12.5 m until there, legs of 150 m a few metres."""

    def shore(south, north):
        ring = [[490.0, south], [510.0, south], [510.0, north], [490.0, north], [490.0, south]]
        return {"type": "Polygon", "coordinates": [ring]}

    shapes = [shore(-900.0, -HALF_WIDTH), shore(HALF_WIDTH, 900.0)]
    (tmp_path / "land.geojson").write_text(json.dumps({"type": "GeometryCollection", "geometries": shapes}))
    transit = {"name": "out", "from": ["0 m", "0 m"], "to": ["1000 m", "0 m"], "speed": "1.2 m/s", "depth": "2 m"}
    return Mission.from_data(
        {
            "site": {"land": {"file": str(tmp_path / "land.geojson"), "projection": "local"}},
            "navigation": {"velocity_error": {"sigma": "0.03 m/s"}, "surfacing_time": "60 s", "fix_error": "1 m"},
            "phases": [{"transit": {**transit, "d_max": "150 m", "arrival_radius": "60 m"}}],
            "requirements": [{"quantity": "total.success", "probability": 0.98}],
        }
    )


LOST = 2.0 * scipy.special.ndtr(-HALF_WIDTH / (0.03 * 500.0 / 1.2))


def test_explore_counts_the_choices_that_touch_the_shore(strait):
    found = explore(strait, vary=["out.d_max=150 m,1 km"], trials=2000, seed=1)
    short, long = found.cells
    assert short.success.value > 0.999
    assert long.success.value == pytest.approx(1.0 - LOST, abs=4.0 * math.sqrt(LOST / 2000.0))


def test_optimise_takes_the_slower_choice_that_stays_clear(strait):
    found = optimise(strait, choose=["out.d_max=150 m,1 km"], aim="duration", trials=1000, seed=1)
    assert found.feasible
    assert found.chosen == {"out.d_max": "0.15 km"}
    tried = {each.values["out.d_max"]: each for each in found.tried}
    assert tried["1 km"].duration < tried["0.15 km"].duration
    assert not tried["1 km"].feasible
