"""The whole way: plan → export → a vehicle that shares nothing with the model → its log → import → diagnosis."""

import re
from pathlib import Path

import numpy as np
import pytest
from simulated_vehicle import Order, Vehicle, orders_of_bhv, orders_of_nmisz, write_alog, write_lsf

import missionplan
from missionplan.mission import Mission

SIDE = 4500.0
CORNERS = [(0.0, SIDE), (SIDE, SIDE), (SIDE, 0.0), (0.0, 0.0)]
ROUNDS = 2
UTM_32 = 32632


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


def moos(mission: Mission, folder) -> tuple[tuple[float, float], list[Order]]:
    (path,) = missionplan.export(mission, "moos", out=folder).files
    return orders_of_bhv(path.read_text(), UTM_32)


def neptus(mission: Mission, folder) -> tuple[tuple[float, float], list[Order]]:
    (path,) = missionplan.export(mission, "neptus", out=folder).files
    return orders_of_nmisz(path.read_bytes())


def vehicle(origin: tuple[float, float], **hidden: float) -> Vehicle:
    return Vehicle(*origin, np.random.default_rng(11), **hidden)


def test_moos_a_compass_that_is_off(tmp_path):
    origin, orders = moos(survey(), tmp_path)
    assert [order.interval for order in orders] == [1200.0] * 8
    write_alog(tmp_path / "sailed.alog", vehicle(origin, compass_bias=2.5).sail(orders))
    imported, found = diagnosed(survey(), tmp_path / "sailed.alog", tmp_path / "data")
    assert imported.format == "moos"
    assert imported.counted >= 20
    assert found.causes == ("compass-bias",)
    assert _angle(found) == pytest.approx(2.5, abs=0.4)


def test_moos_nothing_hidden_is_adequate(tmp_path):
    origin, orders = moos(survey(), tmp_path)
    write_alog(tmp_path / "sailed.alog", vehicle(origin).sail(orders))
    _, found = diagnosed(survey(), tmp_path / "sailed.alog", tmp_path / "data")
    assert found.verdict == "adequate"


def test_neptus_a_speed_log_that_is_off(tmp_path):
    pytest.importorskip("imcpy")
    origin, orders = neptus(survey(), tmp_path)
    assert len(orders) == 24
    write_lsf(tmp_path / "Data.lsf", vehicle(origin, speed_error=-0.04).sail(orders))
    imported, found = diagnosed(survey(), tmp_path / "Data.lsf", tmp_path / "data")
    assert imported.format == "imc"
    assert imported.counted == 24
    assert found.causes == ("speed-scale",)
    (value,) = (each.value for each in found.ranking[0].parameters)
    assert value == pytest.approx(-0.04, abs=0.01)


def test_the_vehicle_shares_nothing_with_the_model():
    source = (Path(__file__).parent / "simulated_vehicle.py").read_text()
    imported = {line.split()[1].split(".")[0] for line in source.splitlines() if re.match(r"\s*(from|import) ", line)}
    assert "missionplan" not in imported
    assert {"numpy", "pyproj", "imcpy"} <= imported


def _angle(found) -> float:
    (value,) = (each.value for each in found.ranking[0].parameters)
    return float(np.degrees(value))
