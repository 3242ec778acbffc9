"""The starter folder: everything in it runs, and nothing is written over."""

import math

import numpy as np
import pytest

from missionplan.datasets.legs import read_transit
from missionplan.errors import InputError
from missionplan.mission import load
from missionplan.studies.init import COMPASS_BIAS, LEGS, init, sea_trial
from missionplan.studies.simulation.simulate import simulate


@pytest.fixture(scope="module")
def starter(tmp_path_factory):
    folder = tmp_path_factory.mktemp("starter")
    init(folder)
    return folder


def test_the_files_are_those_named(tmp_path):
    written = init(tmp_path / "new" / "folder")
    names = {str(path.relative_to(tmp_path / "new/folder")) for path in written}
    schemas = {"schema/mission.json", "schema/vehicle.json", "schema/dataset.json"}
    assert names == {"mission.yaml", "vehicle.yaml", "sea-trial/dataset.yaml", "sea-trial/legs.csv"} | schemas
    assert all(path.stat().st_size > 500 for path in written)


def test_the_same_files_are_written_every_time(starter, tmp_path):
    for path in init(tmp_path):
        assert path.read_bytes() == (starter / path.relative_to(tmp_path)).read_bytes()


def test_its_mission_is_valid_and_works(starter):
    mission = load(starter / "mission.yaml")
    assert mission.notices() == ()
    outcome = simulate(mission, trials=2000, sheet=False)
    assert outcome.requirements_met
    assert not any(requirement.undecided for requirement in outcome.requirements)


def test_nothing_is_written_over(starter, tmp_path):
    (tmp_path / "mission.yaml").write_text("mine")
    with pytest.raises(InputError, match=r"mission\.yaml: is there already"):
        init(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["mission.yaml"]
    with pytest.raises(InputError) as caught:
        init(starter)
    assert len(caught.value.problems) == 7


def test_other_files_are_left_alone(tmp_path):
    (tmp_path / "notes.txt").write_text("mine")
    init(tmp_path)
    assert (tmp_path / "notes.txt").read_text() == "mine"


def test_a_file_in_the_folders_place_is_refused(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="a folder was expected"):
        init(tmp_path / "file")


def test_the_sea_trial_can_be_read_and_has_the_stated_compass_bias(starter):
    mission = load(starter / "mission.yaml")
    data = read_transit(starter / "sea-trial", mission)
    assert data.n == LEGS
    assert data.notices == ()
    # Errors across the course, less the mean error over the four headings, which is the current's.
    course = data.dead_reckoned - data.start
    course = course / np.hypot(*course)
    error = data.velocity_error - data.velocity_error.mean(axis=1, keepdims=True)
    right = error[0] * course[1] - error[1] * course[0]
    speed = 1.5
    noise = math.hypot(0.03, 2.0 * math.sqrt(2.0) * speed / 400.0) / math.sqrt(LEGS)
    assert right.mean() == pytest.approx(speed * math.sin(COMPASS_BIAS), abs=4.0 * noise)


def test_without_a_bias_and_noise_the_log_is_the_current_alone(starter):
    text = (starter / "mission.yaml").read_text()
    quiet = text.replace("sigma: 0.03 m/s", "sigma: 1e-9 m/s").replace("fix_error: 2 m", "fix_error: 0 m")
    (starter / "quiet.yaml").write_text(quiet)
    legs = sea_trial(load(starter / "quiet.yaml"), legs=8, compass_bias=0.0)
    time = legs["t_end_s"] - legs["t_start_s"]
    east, north = ((legs[f"{axis}_end_m"] - legs[f"{axis}_dr_m"]) / time for axis in "xy")
    speed = 0.8 * 1852.0 / 3600.0
    assert np.allclose(east, speed * math.sin(math.radians(60.0)), atol=1e-3)
    assert np.allclose(north, speed * math.cos(math.radians(60.0)), atol=1e-3)


def test_the_second_round_of_the_loop_is_there_too(tmp_path):
    written = init(tmp_path, loop=True)
    assert {path.parent.name for path in written} == {tmp_path.name, "first-log", "both-logs", "third-log"}
    for path in (tmp_path / "mission.yaml", tmp_path / "next-trial.yaml"):
        assert load(path).transits
    with pytest.raises(InputError, match="is there already"):
        init(tmp_path, loop=True)
