"""Which rows from a tank are the same measurement: by what was measured and the mode, not by what a run is called."""

import pandas as pd
import pytest
import yaml

from missionplan.datasets.tank import FRESH_WATER, read_tank_data
from missionplan.errors import InputError

SPRINGS = {"kind": "free-oscillation", "stiffness": "4000 N/m", "mass": "20 kg"}
MODES = pd.DataFrame({"mode": ["surge", "heave", "sway"], "frequency_hz": [1.8, 1.8, 1.5]})
THRUST = pd.DataFrame({"run": ["a", "a", "b"], "rpm": [600.0, 900.0, 1200.0], "thrust_n": [2.0, 4.5, 8.0]})


def read(tmp_path, settings, table):
    table.to_csv(tmp_path / "data.csv", index=False)
    (tmp_path / "dataset.yaml").write_text(yaml.safe_dump({"file": "data.csv", **settings}))
    return read_tank_data(tmp_path)


def test_runs_called_otherwise_are_the_same_measurements(tmp_path):
    thruster = {"kind": "thruster"}
    found = read(tmp_path, thruster, THRUST)
    assert len(set(found.identities)) == 3
    assert found.identities == read(tmp_path, thruster, THRUST.assign(run=["c", "d", "e"])).identities
    assert found.identities != read(tmp_path, thruster, THRUST.assign(thrust_n=[2.0, 4.5, 8.1])).identities
    twice = read(tmp_path, thruster, pd.concat([THRUST, THRUST.assign(run="again")]))
    assert twice.identities == found.identities
    assert twice.columns["rpm"].tolist() == THRUST["rpm"].tolist()
    assert "the rows stand 2 times over, and count once" in twice.notices


def test_modes_of_one_frequency_are_two_measurements(tmp_path):
    found = read(tmp_path, SPRINGS, MODES)
    assert found.labels["mode"] == ["surge", "heave", "sway"]
    assert len(set(found.identities)) == 3
    other = read(tmp_path, SPRINGS, MODES.assign(mode=["surge", "pitch", "sway"]))
    assert [a == b for a, b in zip(found.identities, other.identities, strict=True)].count(False) == 1


@pytest.mark.parametrize("times", [1, 2, 3])
def test_one_frequency_of_two_modes_is_no_table_written_twice(times, tmp_path):
    both = MODES[MODES["frequency_hz"] == 1.8]
    found = read(tmp_path, SPRINGS, pd.concat([both] * times))
    assert found.columns["frequency_hz"].tolist() == [1.8, 1.8]
    assert any("times over" in notice for notice in found.notices) == (times > 1)


def test_nines_are_no_forces_and_a_drag_along_the_motion_is_refused(tmp_path):
    drag = {"kind": "drag", "reference_area": "0.1 m^2", "reference_length": "2 m"}
    table = pd.DataFrame({"speed_m_s": [0.5, 1.0, 1.5], "force_n": [1.0, -999.0, 9.0]})
    found = read(tmp_path, drag, table)
    assert found.columns["force_n"].tolist() == [1.0, 9.0]
    assert "data.csv: 1 row left out without force_n" in found.notices
    with pytest.raises(InputError, match="most forces are not above 0"):
        read(tmp_path, drag, table.assign(force_n=[-1.0, -4.0, 9.0]))


def test_fresh_water_is_that_of_19_degrees():
    """Kestin, Sokolov & Wakeham 1978 (*J. Phys. Chem. Ref. Data* 7): 1.0266 mPa s; density 998.4 kg/m³."""
    density, viscosity = FRESH_WATER
    assert density == pytest.approx(998.4, rel=2e-3)
    assert viscosity == pytest.approx(1.0266e-3 / 998.4, rel=0.02)
