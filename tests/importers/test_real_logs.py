"""Raw logs of three makes of gliders against reference legs made by an independent script; skipped if absent."""

from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from missionplan.datasets.legs import read_transit
from missionplan.errors import InputError
from missionplan.importers import import_logs
from missionplan.importers.dives import LegRules
from missionplan.importers.geodesy import displacement
from missionplan.mission import load

RAW = Path(__file__).parents[2].parent / "shared" / "data" / "raw"


def raw(name):
    if not (RAW / name).is_dir():
        pytest.skip(f"no raw logs: {RAW / name}")
    return RAW / name


def needs(module):
    """Skip where a package is not installed; it is imported by the reader, not here."""
    if not find_spec(module):
        pytest.skip(f"{module} is not installed")


@pytest.fixture(scope="module")
def slocum():
    needs("dbdreader")
    return import_logs([raw("slocum-saanich")])


@pytest.fixture(scope="module")
def seaexplorer():
    return import_logs([raw("seaexplorer-sea035")])


@pytest.fixture(scope="module")
def seaglider():
    pytest.importorskip("netCDF4", reason="netCDF4 is not installed")
    return import_logs([raw("seaglider-sg561")])


def compared(result, folder):
    """Each reference leg beside the leg that begins with it: differences in time [s] and place [m]."""
    reference, legs = pd.read_csv(raw(folder) / "legs-reference.csv"), result.dives
    rows = []
    for _, wanted in reference.iterrows():
        found = legs.loc[(legs["t_start_s"] - wanted["t_start_s"]).abs().idxmin()]
        row = {f"d{name}": found[name] - wanted[name] for name in ("t_start_s", "t_end_s")}
        for name in ("start", "dr_end", "end"):
            places = (found[f"lat_{name}"], found[f"lon_{name}"], wanted[f"lat_{name}"], wanted[f"lon_{name}"])
            row[f"{name}_m"] = float(np.hypot(*displacement(*places)))
        way = displacement(wanted["lat_start"], wanted["lon_start"], wanted["lat_dr_end"], wanted["lon_dr_end"])
        rows.append({**row, "way_m": float(np.hypot(*way)), "ok": found["ok"], "wanted_ok": wanted.get("ok", 1)})
    return pd.DataFrame(rows)


def assert_fixes_agree(rows):
    assert rows[["dt_start_s", "dt_end_s"]].abs().max().max() <= 1.0
    assert rows[["start_m", "end_m"]].max().max() <= 5.0


def test_a_slocums_legs_are_those_of_the_reference(slocum):
    rows = compared(slocum, "slocum-saanich")
    assert len(slocum.table) == 31
    assert slocum.counted == 20
    assert_fixes_agree(rows)
    assert rows["dr_end_m"].max() <= 5.0
    assert list(rows["ok"]) == list(rows["wanted_ok"])


def test_a_slocums_dives_without_dead_reckoning_are_told_too(slocum):
    assert len(slocum.dives) == 34
    without = slocum.dives[~slocum.dives["leg"].isin(slocum.table["leg"])]
    assert len(without) == 3
    assert without["reason"].str.contains("dead-reckon|dead reckoning").all()


def test_a_slocum_carries_its_dead_reckoning_with_the_current_it_estimates(slocum):
    assert slocum.figures.current_in_reckoning == pytest.approx(1.0, abs=0.3)
    assert any("was left in" in notice for notice in slocum.provenance.notices)


def test_that_current_can_be_taken_out(slocum):
    without = import_logs([raw("slocum-saanich")], rules=LegRules(take_out_current=True))
    assert without.counted == 20
    assert any("it was taken out" in notice for notice in without.provenance.notices)
    ends = [result.table[["lat_dr_end", "lon_dr_end"]].to_numpy().T for result in (slocum, without)]
    moved = np.hypot(*displacement(*ends[0], *ends[1]))
    assert 10.0 < np.median(moved) < 300.0  # some hundredths of a metre a second for an hour or three
    np.testing.assert_array_equal(slocum.table["lat_end"], without.table["lat_end"])


@pytest.mark.slow
def test_a_seagliders_legs_are_those_of_the_reference(seaglider):
    rows = compared(seaglider, "seaglider-sg561")
    assert len(seaglider.table) == seaglider.counted == 8
    assert_fixes_agree(rows)
    assert rows["dr_end_m"].max() <= 5.0
    assert seaglider.table["fix_sd_m"].between(2.0, 8.0).all()


@pytest.mark.slow  # 97 files; a few of another one are read always
def test_a_seaexplorers_legs_are_those_of_the_reference(seaexplorer):
    rows = compared(seaexplorer, "seaexplorer-sea035")
    assert len(seaexplorer.table) == 61
    assert seaexplorer.counted == 59
    assert list(rows["ok"]) == list(rows["wanted_ok"])
    assert_fixes_agree(rows)
    # the reference takes each step's heading from its later row and makes no way in a turn: both are of first order
    assert (rows["dr_end_m"] > 10.0).sum() <= 1
    assert rows["dr_end_m"].max() <= 11.0


@pytest.mark.slow
def test_a_position_that_stands_still_is_told(seaexplorer):
    assert any("stands still under water" in notice for notice in seaexplorer.provenance.notices)
    assert seaexplorer.reckoning == "made from heading, with pitch and depth rate"


@pytest.mark.parametrize(
    ("folder", "module", "counted"),
    [pytest.param("seaglider-sg180", "netCDF4", 6, marks=pytest.mark.slow), ("og1-sg033", "netCDF4", 10), ("seaexplorer-sea046", "numpy", 3),
     ("moos-helm", "numpy", 20), ("slocum-bass2015", "dbdreader", 2)],
)  # fmt: skip
def test_legs_of_further_vehicles_are_those_of_the_reference(folder, module, counted):
    needs(module)
    result = import_logs([raw(folder)])
    assert result.counted == counted
    rows = compared(result, folder)
    assert_fixes_agree(rows)
    assert list(rows["ok"]) == list(rows["wanted_ok"])
    with_end = rows["dr_end_m"].notna()
    assert rows.loc[with_end, "dr_end_m"].max() <= 10.0
    assert with_end[rows["wanted_ok"] == 1].all()  # of the Slocum's 13 days without data no position is known


@pytest.mark.slow
def test_copies_of_a_file_are_read_once(seaexplorer):
    repeated = [each for each in seaexplorer.passed_over if "the same as" in each]
    assert len(repeated) == 2
    assert len(seaexplorer.sources) == 97


@pytest.mark.slow
def test_the_declination_that_was_logged_is_checked(seaexplorer):
    pytest.importorskip("pygeomag", reason="pygeomag is not installed")
    assert any("is that of the World Magnetic Model" in notice for notice in seaexplorer.provenance.notices)


def test_the_declination_is_that_of_the_model(slocum):
    pytest.importorskip("pygeomag", reason="pygeomag is not installed")
    assert slocum.table["declination_deg"].iloc[0] == pytest.approx(15.8, abs=0.2)


@pytest.mark.parametrize(
    "name", ["slocum", *(pytest.param(each, marks=pytest.mark.slow) for each in ("seaexplorer", "seaglider"))]
)
def test_what_is_written_is_a_data_set_for_the_starter_mission(name, request, tmp_path):
    result = request.getfixturevalue(name)
    folder = result.save(tmp_path / "data")
    mission = load(folder / "mission.yaml")
    data = read_transit(folder, mission)
    assert data.n == result.counted
    assert float(np.hypot(*data.start[:, 0])) < 1.0  # the origin is the first fix
    assert data.has_surface_time
    listed = set((folder / "all-dives.csv").read_text().splitlines()[0].split(","))
    assert {"ok", "reason", "t_start", "max_depth_m"} <= listed


def test_pygliders_time_series_is_refused_with_words():
    pytest.importorskip("netCDF4", reason="netCDF4 is not installed")
    with pytest.raises(InputError, match="holds no dead reckoning"):
        import_logs([raw("pyglider-l0")])
