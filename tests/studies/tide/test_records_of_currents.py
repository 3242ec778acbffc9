"""Records of a current as files say them, and what `tide` says of a record: shares, errors held out, the fragment."""

import math
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
import yaml

import missionplan
from missionplan.errors import InputError
from missionplan.studies.tide.harmonic_analysis import HarmonicFit, tidal_velocity
from missionplan.studies.tide.result import read_current_record

BEGINS = 1775001600.0  # 2026-04-01
TIME = BEGINS + 3600.0 * np.arange(4)
DEPTH = np.array([5.0, 12.0, 30.0])
EAST = np.arange(12.0).reshape(4, 3) / 10.0
NORTH = 0.05 - EAST[::-1]
EAST[2, 1] = NORTH[2, 1] = math.nan


def profiler(path, order=slice(None), down=slice(None), levels=DEPTH, factor=1.0, names=("u", "v"), turned=False,
             units="m s-1", axis=(), standard=("", ""), places=()):  # fmt: skip
    xarray = pytest.importorskip("xarray", reason="xarray is not installed")
    dims, fields = ("depth", "time") if turned else ("time", "depth"), {}
    for name, whole, called in zip(names, (EAST, NORTH), standard, strict=True):
        values = factor * whole[order][:, down]
        attrs = {"units": units} | ({"standard_name": called} if called else {})
        fields[name] = (dims, values.T if turned else values, attrs)
    hours = ("time", (TIME[order] - BEGINS) / 3600.0, {"units": "hours since 2026-04-01"})
    depth = ("depth", levels[down], {"units": "m", "positive": "down", **dict(axis)})
    xarray.Dataset(fields, {"time": hours, "depth": depth, **dict(places)}).to_netcdf(path)
    return read_current_record(path)


def same(found, latitude=math.nan):
    np.testing.assert_allclose(found.time, TIME, atol=1e-3)
    np.testing.assert_allclose(found.depth, DEPTH)
    np.testing.assert_allclose(found.east, EAST, atol=1e-9)
    np.testing.assert_allclose(found.north, NORTH, atol=1e-9)
    assert found.latitude == pytest.approx(latitude, nan_ok=True)


def test_profilers_in_netcdf_written_otherwise_say_the_same(tmp_path):
    path, back = tmp_path / "adcp.nc", slice(None, None, -1)
    same(profiler(path))
    same(profiler(path, order=back))
    same(profiler(path, down=back))
    same(profiler(path, order=[2, 0, 3, 1], down=[1, 2, 0], turned=True))
    same(profiler(path, levels=-DEPTH, axis={"positive": "up"}))
    same(profiler(path, levels=DEPTH / 1e3, axis={"units": "km"}))
    same(profiler(path, factor=100.0, units="cm s-1"))
    same(profiler(path, names=("UCUR", "VCUR")))
    same(profiler(path, names=("a", "b"), standard=[f"{way}ward_sea_water_velocity" for way in ("east", "north")]))
    same(profiler(path, places={"lat": -33.0}), math.radians(-33.0))
    same(profiler(path, places={"latitude": ("place", [48.0, 49.0])}))  # of which of the two?
    filled = profiler(path, factor=20.0)  # faster than any sea: a fill value
    expected = np.where(np.abs(20.0 * EAST) <= 12.0, 20.0 * EAST, math.nan)
    np.testing.assert_allclose(filled.east, expected)
    with pytest.raises(InputError, match="most of its currents are faster than 12 m/s"):
        profiler(path, factor=100.0)


def test_one_time_without_a_date_among_others_is_refused(tmp_path):
    times = np.array([600.0, *TIME[1:]])
    rows = pd.DataFrame({"t_s": times, "depth_m": 5.0, "east_m_s": EAST[:, 0], "north_m_s": NORTH[:, 0]})
    rows.to_csv(tmp_path / "mixed.csv", index=False)
    with pytest.raises(InputError, match="its times are seconds, and nothing says since when"):
        read_current_record(tmp_path / "mixed.csv")


def test_what_stands_for_none_in_both_components_is_no_current(tmp_path, monkeypatch):
    spoiled = [np.where(np.arange(12).reshape(4, 3) % 4 == 0, 9.99, whole) for whole in (EAST, NORTH)]
    rows = pd.DataFrame({"t_s": np.repeat(TIME, 3), "depth_m": np.tile(DEPTH, 4), "east_m_s": spoiled[0].ravel(),
                         "north_m_s": spoiled[1].ravel()})  # fmt: skip
    rows.to_csv(tmp_path / "record.csv", index=False)
    with pytest.raises(InputError, match=r"record\.csv:2: is impossible"):
        read_current_record(tmp_path / "record.csv")
    for name, whole in zip(("EAST", "NORTH"), spoiled, strict=True):
        monkeypatch.setitem(globals(), name, whole)
    found = profiler(tmp_path / "adcp.nc")
    assert np.isnan(found.east).sum() == np.isnan(found.north).sum() == 4


def test_what_flags_call_bad_or_ranges_not_valid_is_no_current(tmp_path):
    xarray = pytest.importorskip("xarray", reason="xarray is not installed")
    path = tmp_path / "adcp.nc"
    profiler(path, names=("UCUR", "VCUR"))
    with xarray.open_dataset(path, decode_times=False) as file:
        plain = file.load()
    flags = ("time", "depth"), np.array([[1, 1, 2], [4, 1, 1], [1, 1, 9], [1, 3, 1]], dtype="int8")
    is_bad = np.isin(flags[1], (3, 4, 9))
    for name, told in (("UCUR_QC", ""), ("UCUR_flag", "UCUR_flag note")):
        flagged = plain.assign({name: flags})
        flagged["UCUR"].attrs["ancillary_variables"] = told
        flagged.to_netcdf(path)
        np.testing.assert_array_equal(np.isnan(read_current_record(path).east), is_bad | np.isnan(EAST))
    plain["UCUR"].attrs = {"units": "m s-1", "valid_max": 0.85}
    plain.to_netcdf(path)
    np.testing.assert_array_equal(np.isnan(read_current_record(path).east), ~(EAST <= 0.85))


def test_components_of_another_way_and_times_that_stand_twice_are_refused(tmp_path):
    for ways in (("north", "east"), ("west", "north")):
        with pytest.raises(
            InputError, match=f"u is a {ways[0]}ward_sea_water_velocity; expected the current toward east"
        ):
            profiler(tmp_path / "adcp.nc", standard=[f"{way}ward_sea_water_velocity" for way in ways])
    with pytest.raises(InputError, match="has times that stand twice"):
        profiler(tmp_path / "adcp.nc", order=[0, 1, 1, 2])
    rows = pd.DataFrame({"t_s": 1e3 * TIME, "depth_m": 5.0, "east_m_s": EAST[:, 0], "north_m_s": NORTH[:, 0]})
    rows.to_csv(tmp_path / "ms.csv", index=False)
    with pytest.raises(InputError, match=r"ms\.csv: its times are yet to come"):
        read_current_record(tmp_path / "ms.csv")


def test_a_csv_in_any_order_of_rows_with_gaps(tmp_path):
    rows = pd.DataFrame(
        [(TIME[k], DEPTH[m], EAST[k, m], NORTH[k, m]) for k in range(4) for m in range(3)],
        columns=["t_s", "depth_m", "east_m_s", "north_m_s"],
    )
    path = tmp_path / "record.csv"
    dated = rows.assign(t_s=[pd.Timestamp(t, unit="s", tz="UTC").isoformat() for t in rows["t_s"]])
    dated.sample(frac=1.0, random_state=2).to_csv(path, index=False)
    same(read_current_record(path))
    dated.drop(index=7).to_csv(path, index=False)  # a row that is not there is a gap as well
    same(read_current_record(path))
    began = pd.Timestamp(BEGINS, unit="s", tz="UTC").to_pydatetime()
    rows.to_csv(path, index=False)  # seconds since 1970 need no start, and none is added
    same(read_current_record(path))
    same(read_current_record(path, began))
    since = rows.assign(t_s=rows["t_s"] - BEGINS)
    since.to_csv(path, index=False)
    same(read_current_record(path, began))
    pd.concat([dated, dated.iloc[[4]]]).to_csv(path, index=False)
    with pytest.raises(InputError, match=r"record\.csv:14: this row has the time and depth of an earlier one"):
        read_current_record(path)


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    """Twenty-six days of M2, a mean and noise at two depths, the deeper one weaker and noisier."""
    path = tmp_path_factory.mktemp("tide") / "record.csv"
    seconds = 7200.0 * np.arange(26 * 12)
    wave, noise = 2.0 * np.pi * seconds / 44714.16, np.random.default_rng(4).standard_normal((2, 2, seconds.size))
    tables = []
    for k, (depth, size, sd) in enumerate([(6.0, 0.4, 0.02), (20.0, 0.2, 0.05)]):
        velocity = {"east_m_s": 0.1 + size * np.cos(wave) + sd * noise[k, 0], "north_m_s": -0.05 + 0.5 * size * np.sin(
            wave) + sd * noise[k, 1]}  # fmt: skip
        tables.append(pd.DataFrame({"t_s": seconds, "depth_m": depth, **velocity}))
    pd.concat(tables).to_csv(path, index=False)
    return missionplan.tide(path, latitude=0.7, start="2026-04-01T00:00:00Z"), tables


def test_what_a_record_says_of_itself(found):
    result, tables = found
    assert (result.begins, result.days) == pytest.approx((BEGINS, 26.0 - 1.0 / 12.0))
    assert [each.depth for each in result.depths] == [6.0, 20.0]
    assert (result.shown.depth, result.shown.samples) == (6.0, 312)
    np.testing.assert_allclose(result.measured, tables[0][["east_m_s", "north_m_s"]].to_numpy().T)
    assert [words.partition(" that")[0] for words in result.unresolved] == ["shorter than the half year"]


@pytest.mark.parametrize(("index", "sd"), [(0, 0.02), (1, 0.05)])
def test_shares_of_a_record_and_what_its_end_shows(found, index, sd):
    result, tables = found
    tide, table = result.depths[index], tables[index]
    velocity, time = table[["east_m_s", "north_m_s"]].to_numpy().T, BEGINS + table["t_s"].to_numpy()
    assert (tide.east, tide.north) == pytest.approx((0.1, -0.05), abs=3.0 * sd / math.sqrt(312))
    left = velocity - tidal_velocity(tide.constituents, time, 0.7)
    assert tide.tidal_share == pytest.approx(1.0 - left.var(axis=1).sum() / velocity.var(axis=1).sum(), abs=1e-9)
    assert tide.residual == pytest.approx(sd, rel=0.15)
    held = tide.held_out
    assert held.samples == 78  # a quarter of 312
    assert held.error == pytest.approx(sd, rel=0.25)
    assert 0.8 < held.coverage < 0.98


def test_the_fragment_holds_every_depth_in_degrees_and_the_error_of_the_worst(found):
    result, _ = found
    text = result.fragment()
    worst = result.depths[1]
    said = f"{{sigma: {worst.residual:.4f} m/s, time: {max(worst.residual_time / 3600.0, 0.01):.2f} h}}"
    assert f"error: {said}" in text
    for tide, written in zip(result.depths, yaml.safe_load(text)["depths"], strict=True):
        assert written["depth"] == f"{tide.depth:g} m"
        assert (written["east"], written["north"]) == (f"{tide.east:.4f} m/s", f"{tide.north:.4f} m/s")
        for wave, row in zip(tide.constituents, written["constituents"], strict=True):
            numbers = (wave.major, wave.minor, math.degrees(wave.toward), math.degrees(wave.phase))
            assert row["name"] == wave.name
            assert [float(row[key].split()[0]) for key in ("major", "minor", "toward", "phase")] == pytest.approx(
                numbers, abs=0.006
            )
    frame = result.to_frame()
    first = frame[frame["depth_m"] == 20.0].iloc[0]
    assert (first["constituent"], first["toward_deg"]) == ("M2", math.degrees(worst.constituents[0].toward))
    assert first["toward_deg"] == pytest.approx(90.0, abs=3.0)  # the longer axis lies east


def test_the_errors_of_a_fit_are_in_a_forecast_s_twice():
    fit = SimpleNamespace(
        constituents=(), mean_error=0.03, residual=SimpleNamespace(sd=0.1), coefficient_variance=lambda names: 0.0016
    )
    assert HarmonicFit.spread.fget(fit) == pytest.approx(math.sqrt(0.015))  # 0.1² + 2 (0.03² + 0.04²)
