"""Tables and NetCDF of one voyage in many writings: order of columns and rows, separators, units, dimensions, vehicles."""

from datetime import UTC, datetime, timedelta

import numpy as np
import pytest
from made_tracks import made
from test_ardupilot import dataflash
from test_new_formats import cf, iver, one_position
from test_structure import VOYAGE as SEA_VOYAGE
from test_structure import agree, gli, og1, seaglider

from missionplan.errors import InputError
from missionplan.importers import import_logs

ELSEWHERE = made(legs=3, duration=1200.0, pause=240.0, step=20.0, headings=[45.0, 90.0, 135.0])


def rewritten(path, source, change):
    """Write the lines of a table again, each changed as a list of cells; the first has the names."""
    lines = [line.split(";") for line in source.read_text().splitlines()]
    path.write_text("\n".join(";".join(cells) for cells in change(lines)) + "\n")
    return path


def turned(lines):
    order = np.random.default_rng(5).permutation(len(lines[0]))
    return [[cells[k] for k in order] for cells in lines]


def quoted(lines):
    return [[f'"{name}"' for name in lines[0]], *lines[1:]]


def backwards(lines):
    return [lines[0], *lines[:0:-1]]


def mixed(lines):
    return [lines[0], *np.random.default_rng(6).permutation(np.array(lines[1:], dtype=object)).tolist()]


def spaced(lines):
    return [[f" {cell} " for cell in cells] for cells in lines]


def with_more(lines):
    return [["Temperature", *lines[0], "Voltage"], *(["9.1", *cells, "28.4"] for cells in lines[1:])]


def ended(lines):
    """Rows that end with a separator, under names that do not."""
    return [lines[0], *([*cells, ""] for cells in lines[1:])]


CHANGES = (turned, quoted, backwards, mixed, spaced, with_more, ended)


@pytest.mark.parametrize("change", CHANGES)
def test_a_seaexplorers_columns_and_rows_in_any_order(tmp_path, change):
    source = gli(tmp_path / "sea001.1.gli.sub.1")
    found = import_logs([rewritten(tmp_path / "sea001.1.gli.sub.2", source, change)])
    agree(import_logs([source]), found, metres=0.5)


@pytest.mark.parametrize("change", CHANGES)
def test_an_ivers_columns_and_rows_in_any_order(tmp_path, change):
    source = iver(tmp_path / "a.log")
    agree(import_logs([source]), import_logs([rewritten(tmp_path / "b.log", source, change)]))


def test_an_ivers_log_with_commas_feet_and_metres_a_second(tmp_path):
    source = iver(tmp_path / "a.log")
    plain = import_logs([source])
    (tmp_path / "b.csv").write_text(source.read_text().replace(";", ","))
    agree(plain, import_logs([tmp_path / "b.csv"]))

    def in_feet(lines):
        k = lines[0].index("DFS Depth (m)")
        lines[0][k] = "DFS Depth (ft)"
        return [lines[0], *([*cells[:k], f"{float(cells[k]) / 0.3048:.3f}", *cells[k + 1 :]] for cells in lines[1:])]

    agree(plain, import_logs([rewritten(tmp_path / "c.log", source, in_feet)]))


def test_times_of_another_form_are_named(tmp_path):
    def short_years(lines):
        k = lines[0].index("Date")
        return [lines[0], *([*cells[:k], cells[k][:-4] + cells[k][-2:], *cells[k + 1 :]] for cells in lines[1:])]

    with pytest.raises(InputError, match=r"b\.log: passed over: .* times in Date\+Time are not as %m/%d/%Y %H:%M:%S"):
        import_logs([rewritten(tmp_path / "b.log", iver(tmp_path / "a.log"), short_years)])


@pytest.mark.parametrize(
    ("name", "hours", "is_told"), [("20230405_UTC.log", -6, True), ("a.log", 0, True), ("a.log", -6, False)]
)
def test_an_ivers_days_are_told_from_its_months(tmp_path, name, hours, is_told):
    later = datetime(2023, 4, 5, tzinfo=UTC) - datetime(2023, 11, 14, tzinfo=UTC) + timedelta(hours=hours)

    def moved(form):
        lines = [line.split(";") for line in iver(tmp_path / "source.txt").read_text().splitlines()]
        day, clock = lines[0].index("Date"), lines[0].index("Time")
        for cells in lines[1:]:
            then = datetime.strptime(f"{cells[day]} {cells[clock]}", "%m/%d/%Y %H:%M:%S.%f").replace(tzinfo=UTC) + later
            cells[day], cells[clock] = f"{then:{form}}", f"{then:%H:%M:%S}"
        (tmp_path / name).write_text("\n".join(";".join(cells) for cells in lines))
        return import_logs([tmp_path / name])

    months, days = moved("%m/%d/%Y"), moved("%d/%m/%Y")
    doubts = ["tells the day from the month" in " ".join(each.provenance.notices) for each in (months, days)]
    assert doubts == [not is_told] * 2
    if is_told:
        agree(months, days)
        assert 0.0 < months.table["t_start_s"].iloc[0] - datetime(2023, 4, 4, tzinfo=UTC).timestamp() < 2 * 86400.0


def test_ivers_of_two_names_are_asked_for(tmp_path):
    for k, name in enumerate(("IVER2-135", "IVER2-136")):
        iver(tmp_path / f"2023_UTC_0_box_{name}.log", decimals=bool(k))
    with pytest.raises(InputError, match=r"IVER2-135 \(1 file\), IVER2-136 \(1 file\)"):
        import_logs([tmp_path])


def test_trajectories_with_dimensions_and_rows_in_any_order(tmp_path):
    netcdf = pytest.importorskip("netCDF4", reason="netCDF4 is not installed")
    plain = import_logs([cf(tmp_path / "a.nc")])
    with netcdf.Dataset(cf(tmp_path / "b.nc"), "a") as file:  # rows in no order of time
        order = np.random.default_rng(7).permutation(len(file["time"]))
        for name in ("time", "lat", "lon", "z", "heading"):
            file[name][:] = file[name][:][order]
    agree(plain, import_logs([tmp_path / "b.nc"]))
    t, lat, lon, depth, _ = one_position()
    for k, (dims, unit) in enumerate(((("obs", "trajectory"), "days since 1950-01-01T00:00:00Z"),
                                      (("trajectory", "obs"), "milliseconds since 1970-01-01"))):  # fmt: skip
        with netcdf.Dataset(tmp_path / f"c{k}.nc", "w") as file:
            file.featureType = "Trajectory"
            file.createDimension("obs", len(t))
            file.createDimension("trajectory", 1)
            file.createDimension("letters", 4)
            name = file.createVariable("name", "S1", ("trajectory", "letters"))
            name.cf_role = "trajectory_id"
            name[:] = np.array([list("auv1")], dtype="S1")
            days = t / 86400.0 + 7305.0
            columns = {"when": (days if "days" in unit else t * 1e3, {"units": unit, "standard_name": "time"}),
                       "LATITUDE": (np.radians(lat), {"units": "radians", "standard_name": "LATITUDE"}),
                       "LONGITUDE": (np.radians(lon), {"units": "radians", "standard_name": "longitude"}),
                       "p": (depth * 1e4, {"units": "Pa", "standard_name": "sea_water_pressure"})}  # fmt: skip
            for key, (values, attributes) in columns.items():
                variable = file.createVariable(key, "f8", dims, fill_value=-9999.0)
                variable.setncatts(attributes)
                variable[:] = np.reshape(values, (-1, 1) if dims[0] == "obs" else (1, -1))
        agree(plain, import_logs([tmp_path / f"c{k}.nc"]))


def test_og1_of_two_gliders_are_asked_for(tmp_path):
    netcdf = pytest.importorskip("netCDF4", reason="netCDF4 is not installed")
    og1(tmp_path / "a.nc")
    with netcdf.Dataset(og1(tmp_path / "b.nc", upper=False), "a") as file:
        file.id = "sg034_20231114T000000_delayed"
    with pytest.raises(InputError, match=r"sg033 \(1 file\), sg034 \(1 file\)"):
        import_logs([tmp_path])
    assert import_logs([tmp_path], vehicle="SG034").counted == 4


def test_positions_of_og1_are_in_their_unit(tmp_path):
    netcdf = pytest.importorskip("netCDF4", reason="netCDF4 is not installed")
    plain = import_logs([og1(tmp_path / "a.nc")])
    with netcdf.Dataset(og1(tmp_path / "b.nc"), "a") as file:
        for each in (
            each for name, each in file.variables.items() if name.lower().startswith(("latitude", "longitude"))
        ):
            each[:] = np.radians(each[:])
            each.units = "radian"
    agree(plain, import_logs([tmp_path / "b.nc"]))


def test_a_seaglider_without_its_model_is_reckoned_aloud(tmp_path):
    """Raw files of a dive have headings and pitches, and no displacements."""
    netcdf = pytest.importorskip("netCDF4", reason="netCDF4 is not installed")
    plain = import_logs([seaglider(tmp_path / "a")])
    for path in sorted(seaglider(tmp_path / "b").iterdir()):
        with netcdf.Dataset(path, "a") as file:
            for name in ("east_displacement", "north_displacement", "horz_speed"):
                file.renameVariable(name, f"not_{name}")
            t = file["time"][:]
            track = SEA_VOYAGE.track
            for name, values in (("eng_head", track.heading.at(t)), ("eng_pitchAng", track.pitch.held(t))):
                variable = file.createVariable(name, "f8", ("sg_data_point",))
                variable[:] = values
            variation = file.createVariable("log_gps_magvar", "f8", ("gps_info",))
            variation[:] = 0.0
    found = import_logs([tmp_path / "b"])
    assert repr(found).splitlines()[1].startswith("The logs hold no dead reckoning: it was made from heading")
    agree(plain, found, metres=60.0)


def test_dataflash_logs_of_two_autopilots_are_asked_for_or_found_out(tmp_path):
    pytest.importorskip("pymavlink", reason="pymavlink is not installed")
    one, two = dataflash(tmp_path / "1.BIN"), dataflash(tmp_path / "2.BIN", ELSEWHERE, satellites=11)
    with pytest.raises(InputError, match="are they of two vehicles"):
        import_logs([one, two])
    numbers = (b"ArduSub V4.1.0", b"003E0037 31365118 3835373")
    for path, last in ((one, b"1"), (two, b"2")):
        data = path.read_bytes()
        path.write_bytes(
            data.replace(numbers[0].ljust(64, b"\0"), (numbers[0] + b" " + numbers[1] + last).ljust(64, b"\0"))
        )
    with pytest.raises(InputError, match=r"003E00373136511838353731 \(1 file\), 003E00373136511838353732"):
        import_logs([one, two])
    assert import_logs([one, two], vehicle="003E00373136511838353732").counted == 3


MAP = ["time=time", "lat=lat", "lon=lon", "dr_lat=dr_lat", "dr_lon=dr_lon", "depth=depth"]


def table(path, heading="depth", size=1.0, zero=0.0, day=None, before=""):
    """Write a voyage's fixes and dead reckoning; depths in a unit, times by ISO 8601 or as days since some zero."""
    rows = [f"time,lat,lon,dr_lat,dr_lon,{heading}", *before.splitlines()]
    track = SEA_VOYAGE.track
    at = np.union1d(track.fixes.t, track.reckoned.t)
    fixed, own = np.searchsorted(track.fixes.t, at), np.searchsorted(track.reckoned.t, at)
    for t, k, j in zip(at, fixed, own, strict=True):
        is_fix, is_own = t in track.fixes.t, t in track.reckoned.t
        fix = (track.fixes.latitude[k], track.fixes.longitude[k]) if is_fix else ("", "")
        place = (track.reckoned.latitude[j], track.reckoned.longitude[j]) if is_own else ("", "")
        when = f"{datetime.fromtimestamp(t, UTC):%Y-%m-%dT%H:%M:%S.%f}Z" if day is None else f"{t / day + zero:.10f}"
        rows.append(",".join(map(str, (when, *fix, *place, float(track.depth.at(np.array([t]))[0]) / size))))
    path.write_text("\n".join(rows) + "\n")
    return path


def test_a_unit_behind_a_heading_or_in_a_row_below_is_the_columns(tmp_path):
    plain = import_logs([table(tmp_path / "a.csv")], names=MAP)
    for heading, before in [("depth (ft)", ""), ("depth [ft]", ""), ("depth", "UTC,deg,deg,deg,deg,ft")]:
        path = table(tmp_path / "b.csv", heading, 0.3048, before=before)
        agree(plain, import_logs([path], names=[*MAP[:-1], f"depth={heading}"]))
        agree(plain, import_logs([path], names=MAP))
    path = table(tmp_path / "b.csv", "depth_ft", 0.3048)
    agree(plain, import_logs([path], names=[*MAP[:-1], "depth=depth_ft"]))


def test_days_of_spreadsheets_are_read_and_other_ages_named(tmp_path):
    plain = import_logs([table(tmp_path / "a.csv")], names=MAP)
    path = table(tmp_path / "b.csv", zero=25569.0, day=86400.0)
    agree(plain, import_logs([path], names=["time=time[excel]", *MAP[1:]]))
    with pytest.raises(InputError, match=r"its fixes are of the years from 209\d on .are they in another unit"):
        import_logs([path], names=["time=time[days]", *MAP[1:]])
    with pytest.raises(InputError, match=r"its fixes are of the years from 5\d{4} on"):
        import_logs([table(tmp_path / "c.csv", day=1e-3)], names=["time=time[epoch]", *MAP[1:]])
    path = table(tmp_path / "c.csv", zero=-SEA_VOYAGE.track.fixes.t[0], day=1.0)
    told = import_logs([path], names=["time=time[s]", *MAP[1:]]).provenance.notices
    assert any("from 1970 on: they have no date" in each for each in told)


def test_one_row_of_another_year_is_no_jump_of_the_clock(tmp_path):
    """The sizes of a glider's sensors stand where it begins, and again where two of its tables are joined."""
    path = table(tmp_path / "a.csv", day=1.0)
    names = ["time=time[epoch]", *MAP[1:]]
    plain = import_logs([path], names=names)
    lines = path.read_text().splitlines()
    (tmp_path / "b.csv").write_text("\n".join([lines[0], "8,8,8,8,8,4", *lines[1:50], "8,8,8,8,8,4", *lines[50:]]))
    agree(plain, import_logs([tmp_path / "b.csv"], names=names))


TABLE_NAMES = ["time=time lat=lat lon=lon dr_lat=a dr_lon=b depth=depth heading_true=heading"]


def columns(path, head="time,lat,lon,a,b,depth,heading", cell=lambda name, value: value):
    """Write a table of fixes and dead-reckoned positions, each cell as `cell` has it."""
    track, rows = ELSEWHERE.track, []
    for t in np.union1d(track.fixes.t, track.reckoned.t):
        place = []
        for part in (track.fixes, track.reckoned):
            k = np.flatnonzero(part.t == t)
            place += [f"{values[k[0]]:.7f}" if len(k) else "" for values in (part.latitude, part.longitude)]
        row = [f"{np.datetime64(round(t), 's')}", *place, f"{float(track.depth.at(t)):.2f}"]
        names = ("time", "lat", "lon", "a", "b", "depth", "heading")
        row = zip(names, [*row, f"{float(track.heading.at(t)):.2f}"], strict=True)
        rows.append(",".join(cell(name, value) if value else "" for name, value in row))
    path.write_text("\n".join([head, *rows]) + "\n")
    return import_logs([path], format="track", names=TABLE_NAMES)


@pytest.mark.parametrize(
    ("head", "cell", "words"),
    [
        ("time", lambda name, value: f"{value} m" if name == "depth" else value, r"cells in depth are not as m says"),
        ("time (EST)", lambda _, value: value, r"the column 'time \(EST\)' says 'EST': expected UTC, or a zone behind"),
        ("time [UTC+2]", lambda _, value: value, r"says 'UTC\+2': expected UTC"),
    ],
)
def test_what_cells_and_headings_say_is_not_passed_by(tmp_path, head, cell, words):
    with pytest.raises(InputError, match=words):
        columns(tmp_path / "a.csv", f"{head},lat,lon,a,b,depth,heading", cell)


def test_a_zone_behind_each_time_goes_before_that_of_the_heading(tmp_path):
    plain = columns(tmp_path / "a.csv")
    zoned = columns(
        tmp_path / "b.csv",
        "time (local),lat,lon,a,b,depth,heading",
        lambda name, value: f"{value}+00:00" if name == "time" else value,
    )
    agree(plain, zoned)


def test_longitudes_toward_west_are_not_counted_east(tmp_path):
    def unsigned(name, value):
        return value.removeprefix("-") if name in ("lon", "b") else value

    with pytest.raises(InputError, match=r"the column 'lon .W.' counts toward south or west"):
        columns(tmp_path / "a.csv", "time,lat,lon (W),a,b,depth,heading", unsigned)
