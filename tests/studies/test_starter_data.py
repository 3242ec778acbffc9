"""Starter data sets: each is valid as it stands, and the command that its comments name runs on it."""

import pytest

from missionplan.diagnosis.diagnose import diagnose
from missionplan.errors import InputError
from missionplan.mission import load
from missionplan.studies.identification import identify
from missionplan.studies.init import DATA_KINDS, init, init_data
from missionplan.studies.validate import validate

TANK = ("drag", "free-oscillation", "thruster", "propeller-transient")


@pytest.mark.parametrize("kind", DATA_KINDS)
def test_it_is_valid(kind, tmp_path):
    written = init_data(kind, tmp_path / "data")
    assert all(path.is_file() for path in written)
    (found,) = validate([tmp_path / "data"])
    assert not found.problems
    assert kind in found.summary
    assert ("score" in {each.command for each in found.table}) == (kind in ("transit", "descent"))


@pytest.mark.parametrize("kind", TANK)
def test_tank_data_are_identified(kind, tmp_path):
    init_data(kind, tmp_path)
    assert identify(tmp_path).estimates


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["transit", "descent", "summary"])
def test_data_of_a_mission_are_diagnosed(kind, tmp_path):
    init(tmp_path)
    init_data(kind, tmp_path / "data")
    result = diagnose(load(tmp_path / "mission.yaml"), tmp_path / "data", plan=False, jobs=1)
    assert result.verdict in ("adequate", "explained", "ambiguous", "partly-explained", "unexplained")


def test_nothing_is_overwritten_and_an_unknown_kind_is_said(tmp_path):
    init_data("drag", tmp_path)
    with pytest.raises(InputError, match="is there already"):
        init_data("drag", tmp_path)
    with pytest.raises(InputError, match="did you mean descent"):
        init_data("decent", tmp_path)
