"""The error that a mission expects of its forecast, as a diagnosis of legs holds it and writes it."""

import copy

import pytest
import yaml

from missionplan.diagnosis.forecast_error import as_forecast_error, forecast_notice
from missionplan.diagnosis.given.priors import given_priors
from missionplan.effects import effects_of
from missionplan.mission import load

PERSISTS = "persistent-error"


def mission(folder, error=None):
    rows = [f"{t},0,0.1,0.0" for t in (0, 86_400)]
    (folder / "current.csv").write_text("\n".join(["t_s,depth_m,east_m_s,north_m_s", *rows]))
    data = {
        "site": {"current": {"file": "current.csv"} | ({"error": error} if error else {})},
        "navigation": {"velocity_error": {"sigma": "0.03 m/s"}, "surfacing_time": "90 s"},
        "phases": [
            {
                "transit": {
                    "name": "out",
                    "from": ["0 m", "0 m"],
                    "to": ["8 km", "0 m"],
                    "speed": "2 m/s",
                    "d_max": "1 km",
                    "arrival_radius": "60 m",
                }
            }
        ],
    }
    (folder / "mission.yaml").write_text(yaml.safe_dump(data))
    return load(folder / "mission.yaml")


def test_the_error_is_part_of_what_the_mission_knows(tmp_path):
    expected = mission(tmp_path, {"sigma": {"median": "0.06 m/s", "factor": 1.5}, "time": "2 h"})
    (given,) = given_priors(expected, effects_of("transit"))
    assert given.effect == PERSISTS
    prior = {estimate.name: estimate for estimate in given.prior}
    assert prior["sigma"].value == pytest.approx(0.06, rel=0.02)
    assert prior["time"].value == pytest.approx(7200.0, rel=0.01)
    assert given_priors(mission(tmp_path), effects_of("transit")) == ()


def test_along_a_track_a_length_shortens_its_memory(tmp_path):
    expected = mission(tmp_path, {"sigma": "0.06 m/s", "time": "2 h", "length": "7200 m"})
    (given,) = given_priors(expected, effects_of("transit"))
    assert {e.name: e.value for e in given.prior}["time"] == pytest.approx(2400.0, rel=0.01)


def test_what_is_found_of_it_is_written_where_the_mission_has_it(tmp_path):
    raw = copy.deepcopy(dict(mission(tmp_path, {"sigma": "0.06 m/s", "time": "2 h", "length": "3 km"}).raw))
    found = {"sigma": {"mean": "0.08 m/s", "sd": "0.01 m/s"}, "time": "3 h"}
    written = as_forecast_error(raw | {"effects": [{PERSISTS: found}, {"compass-bias": {"angle": "1 deg"}}]})
    assert written["site"]["current"]["error"] == found
    assert written["effects"] == [{"compass-bias": {"angle": "1 deg"}}]
    without = copy.deepcopy(dict(mission(tmp_path).raw)) | {"effects": [{PERSISTS: found}]}
    assert as_forecast_error(without) == without, "a mission without an error of its own keeps the effect"


def test_an_error_that_persists_beside_a_forecast_is_said_to_be_the_forecasts(tmp_path):
    (said,) = forecast_notice(mission(tmp_path), (PERSISTS,))
    assert "site.current.error" in said
    assert forecast_notice(mission(tmp_path), ("compass-bias",)) == ()
    assert forecast_notice(mission(tmp_path, {"sigma": "0.06 m/s", "time": "2 h"}), (PERSISTS,)) == ()
