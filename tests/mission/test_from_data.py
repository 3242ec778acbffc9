"""`Mission.from_data`: a mission from its data, as `load` reads it from a file."""

import copy
from pathlib import Path

import pytest
import yaml

from missionplan import Mission, load
from missionplan.errors import InputError

MISSIONS = Path(__file__).parents[2] / "missions"

DATA = {
    "name": "short",
    "navigation": {"velocity_error": {"sigma": "0.035 m/s"}, "surfacing_time": "90 s"},
    "phases": [
        {
            "transit": {
                "name": "ingress",
                "from": ["0 m", "0 m"],
                "to": ["4 nmi", "0 m"],
                "speed": "1.25 m/s",
                "d_max": "4 nmi",
                "arrival_radius": "50 m",
            }
        }
    ],
}


@pytest.mark.parametrize("path", sorted(MISSIONS.glob("*.yaml")), ids=lambda path: path.stem)
def test_shipped_missions_survive_the_round_trip(path: Path) -> None:
    mission = load(path)
    again = Mission.from_data(mission.raw, file=mission.file)
    assert dict(again) == dict(mission)  # all sections; the files that were read are none of them
    assert (again.raw, again.file, again.quantities()) == (mission.raw, mission.file, mission.quantities())


def test_the_data_are_copied() -> None:
    data = copy.deepcopy(DATA)
    mission = Mission.from_data(data)
    data["navigation"]["surfacing_time"] = "1 s"
    assert mission.raw == DATA
    assert mission.file == ""


def test_every_problem_at_once_and_without_lines() -> None:
    data = copy.deepcopy(DATA) | {"monte_carlo": {"trials": -5}, "vehicel": {}}
    data["phases"][0]["transit"]["speed"] = 1.25
    with pytest.raises(InputError) as caught:
        Mission.from_data(data, file="extended")
    assert {(problem.file, problem.line, problem.key) for problem in caught.value.problems} == {
        ("extended", None, "phases[0].transit.speed"),
        ("extended", None, "monte_carlo.trials"),
        ("extended", None, "vehicel"),
    }
    assert "did you mean vehicle?" in str(caught.value)


def test_sections_are_checked_against_each_other() -> None:
    data = copy.deepcopy(DATA) | {
        "sweep": {"phase": "egress"},
        "requirements": [{"quantity": "ingress.duration", "at_most": "5 m", "probability": 0.9}],
    }
    with pytest.raises(InputError) as caught:
        Mission.from_data(data)
    assert [problem.key for problem in caught.value.problems] == ["sweep.phase", "requirements[0].at_most"]


def test_a_vehicle_may_be_named_by_its_path(tmp_path: Path) -> None:
    hull = {"hull": {"length": "1 m", "diameter": "0.1 m"}}
    (tmp_path / "auv.yaml").write_text(yaml.safe_dump(hull))
    mission = Mission.from_data(DATA | {"vehicle": str(tmp_path / "auv.yaml")})
    assert mission.raw["vehicle"] == hull
    with pytest.raises(InputError, match=r"vehicle: given 'none\.yaml'; there is no such file"):
        Mission.from_data(DATA | {"vehicle": "none.yaml"})
