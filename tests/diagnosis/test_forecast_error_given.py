"""The error that a mission expects of its forecast, as a diagnosis of legs holds it and writes it."""

import numpy as np
import pytest
import yaml

from missionplan.diagnosis.given import forecast_notice, with_forecast_error
from missionplan.diagnosis.given.priors import given_priors
from missionplan.effects import effects_of
from missionplan.mission import load
from missionplan.results.learned.evidence import ParameterEstimate

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
    expected = mission(tmp_path, {"sigma": "0.06 m/s", "time": "2 h", "length": "3 km"})
    found = [
        ParameterEstimate(PERSISTS, "sigma", 0.08, 0.008, 0.067, 0.093, "m/s"),
        ParameterEstimate(PERSISTS, "time", 10800.0, 2000.0, 8000.0, 14000.0, "s"),
    ]
    error = with_forecast_error(expected.raw, expected, found)["site"]["current"]["error"]
    assert error == {
        "sigma": {"median": "0.08 m/s", "factor": pytest.approx(np.exp(0.1), rel=1e-4)},
        "time": {"median": "10800 s", "factor": pytest.approx(np.exp(2.0 / 10.8), rel=1e-4)},
    }
    without = mission(tmp_path)
    assert with_forecast_error(without.raw, without, found) == without.raw, "without one of its own it keeps the effect"


def test_an_error_that_persists_beside_a_forecast_is_said_to_be_the_forecasts(tmp_path):
    (said,) = forecast_notice(mission(tmp_path), (PERSISTS,))
    assert "site.current.error" in said
    assert forecast_notice(mission(tmp_path), ("compass-bias",)) == ()
    assert forecast_notice(mission(tmp_path, {"sigma": "0.06 m/s", "time": "2 h"}), (PERSISTS,)) == ()
