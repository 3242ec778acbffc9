"""The whole way: plan → export → a vehicle that shares nothing with the model → its log → import → diagnosis."""

import re

import dune
import numpy as np
import pytest
from helm import Helm
from logs import EPOCH, Log, write_alog, write_lsf
from pyproj import Proj
from sea import Sea, Voyage

import missionplan
from missionplan.mission import Mission

SIDE = 4500.0
CORNERS = [(0.0, SIDE), (SIDE, SIDE), (SIDE, 0.0), (0.0, 0.0)]
ROUNDS = 2


def survey() -> Mission:
    """Round a square twice: legs of at most 1500 m on four headings."""
    phases = []
    for number in range(4 * ROUNDS):
        east, north = CORNERS[number % 4]
        transit = {"name": f"side {number + 1}", "to": [f"{east} m", f"{north} m"], "depth": "10 m"}
        transit |= {"speed": "1.25 m/s", "d_max": "1500 m", "arrival_radius": "40 m"}
        phases.append({"transit": transit | ({"from": ["0 m", "0 m"]} if number == 0 else {})})
    return Mission.from_data(
        {
            "name": "Round trip",
            "site": {"origin": {"latitude": "54.3 deg", "longitude": "10.2 deg"}},
            "navigation": {"velocity_error": {"sigma": "0.02 m/s"}, "surfacing_time": "60 s", "fix_error": "3 m"},
            "phases": phases,
        },
        file="survey.yaml",
    )


def diagnosed(mission: Mission, log_file, folder):
    imported = missionplan.import_logs([log_file])
    imported.save(folder)
    return imported, missionplan.diagnose(mission, folder, plan=False)


def logged(sailed, origin: tuple[float, float], plane: Proj) -> Log:
    """What the vehicle knew, in places on Earth; headings in degrees."""
    base, found = plane(*origin[::-1]), Log()
    for time, east, north in sailed.fixes:
        longitude, latitude = plane(base[0] + east, base[1] + north, inverse=True)
        found.fixes.append((EPOCH + time, latitude, longitude))
    for time, east, north, depth, heading, speed in sailed.states:
        longitude, latitude = plane(base[0] + east, base[1] + north, inverse=True)
        found.states.append((EPOCH + time, latitude, longitude, depth, np.degrees(heading) % 360.0, speed))
    return found


def moos(folder, sea: Sea) -> Log:
    (path,) = missionplan.export(survey(), "moos", out=folder, seed=1).files
    text = path.read_text()
    origin = tuple(float(re.search(rf"{key}\s*=\s*(\S+)", text)[1]) for key in ("LatOrigin", "LongOrigin"))
    sailed = Helm(text, Voyage(sea, np.random.default_rng(11)), 0.3, fix_every=2.0).sail(200_000.0)
    assert not sailed.aborted
    return logged(sailed, origin, Proj(proj="utm", zone=32, ellps="WGS84"))


def sea(**hidden: float) -> Sea:
    return Sea((), 0.015, 3.0, 60.0, **hidden)


@pytest.mark.slow
def test_moos_a_compass_that_is_off(tmp_path):
    write_alog(tmp_path / "sailed.alog", moos(tmp_path, sea(compass_bias=2.5)))
    imported, found = diagnosed(survey(), tmp_path / "sailed.alog", tmp_path / "data")
    assert imported.format == "moos"
    assert imported.counted >= 20
    assert found.causes == ("compass-bias",)
    assert _angle(found) == pytest.approx(2.5, abs=0.4)


@pytest.mark.slow
def test_moos_nothing_hidden_is_adequate(tmp_path):
    write_alog(tmp_path / "sailed.alog", moos(tmp_path, sea()))
    _, found = diagnosed(survey(), tmp_path / "sailed.alog", tmp_path / "data")
    assert found.verdict == "adequate"


@pytest.mark.usefixtures("among_few")
def test_neptus_a_speed_log_that_is_off(tmp_path):
    pytest.importorskip("imcpy")
    (path,) = missionplan.export(survey(), "neptus", out=tmp_path, seed=1).files
    home, plans = dune.read(path.read_bytes())
    assert len(plans) == 8
    sailed = dune.sail(plans, Voyage(sea(speed_error=-0.04), np.random.default_rng(11)))
    plane = Proj(proj="aeqd", lat_0=home[0], lon_0=home[1], ellps="WGS84")
    write_lsf(tmp_path / "Data.lsf", logged(sailed, home, plane))
    imported, found = diagnosed(survey(), tmp_path / "Data.lsf", tmp_path / "data")
    assert imported.format == "imc"
    assert imported.counted >= 24
    assert found.causes == ("speed-scale",)
    (value,) = (each.value for each in found.ranking[0].parameters)
    assert value == pytest.approx(-0.04, abs=0.01)


def _angle(found) -> float:
    (value,) = (each.value for each in found.ranking[0].parameters)
    return float(np.degrees(value))
