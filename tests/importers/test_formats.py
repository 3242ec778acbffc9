"""Each format, written from one made track, gives the legs of that track."""

import inspect
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from made_tracks import made

from missionplan.errors import InputError
from missionplan.importers import import_logs
from missionplan.importers.cutting import cut
from missionplan.importers.dives import LegRules
from missionplan.importers.mapping import angles, ddmm_to_degrees, degrees_of, times

LEGS = 4


@pytest.fixture(scope="module")
def log():
    return made(legs=LEGS, duration=1800.0, pause=180.0, step=30.0)


@pytest.fixture(scope="module")
def expected(log):
    return cut(log.track, LegRules()).legs


def assert_same_legs(result, expected, metres=0.5):
    assert len(result.table) == len(expected) == LEGS
    np.testing.assert_allclose(result.table["t_start_s"], expected["t_start_s"], atol=0.6)
    np.testing.assert_allclose(result.table["t_end_s"], expected["t_end_s"], atol=0.6)
    for name in ("start", "dr_end", "end"):
        for axis, scale in (("lat", 111_200.0), ("lon", 74_600.0)):
            away = (result.table[f"{axis}_{name}"].to_numpy() - expected[f"{axis}_{name}"].to_numpy()) * scale
            assert np.abs(away).max() < metres


def ddmm(value):
    return np.sign(value) * (100.0 * np.floor(np.abs(value)) + 60.0 * (np.abs(value) % 1.0))


@pytest.fixture(scope="module")
def table(log):
    """Rows of fixes, dead-reckoned positions and depths, blank where a row has none."""
    track = log.track
    parts = [
        pd.DataFrame({"t": track.fixes.t, "lat": track.fixes.latitude, "lon": track.fixes.longitude, "hdop": 1.0}),
        pd.DataFrame({"t": track.reckoned.t, "dr_lat": track.reckoned.latitude, "dr_lon": track.reckoned.longitude}),
        pd.DataFrame({"t": track.depth.t, "depth": track.depth.values, "heading": track.heading.values}),
    ]
    merged = parts[0]
    for part in parts[1:]:
        merged = merged.merge(part, on="t", how="outer")
    return merged.sort_values("t")


WRITINGS = {
    "epoch": (lambda t: t, "epoch", lambda x: x, "deg", lambda z: z, "m", ","),
    "iso": (lambda t: pd.to_datetime(t, unit="s").dt.strftime("%Y-%m-%dT%H:%M:%S.%fZ"), "iso", lambda x: x, "deg",
            lambda z: z / 0.3048, "ft", ";"),
    "pattern": (lambda t: pd.to_datetime(t, unit="s").dt.strftime("%d.%m.%Y %H:%M:%S"), "%d.%m.%Y %H:%M:%S", ddmm, "ddmm",
                lambda z: z * 10.0, "dbar", "\t"),
    "doy": (lambda t: (t - pd.Timestamp("2023-01-01").timestamp()) / 86400.0 + 1.0, "doy:2023", np.radians, "rad",
            lambda z: z * 100.0, "cm", "|"),
}  # fmt: skip


@pytest.mark.parametrize("writing", WRITINGS)
def test_tables_of_any_writing(table, expected, tmp_path, writing):
    time, time_unit, angle, angle_unit, deep, deep_unit, separator = WRITINGS[writing]
    if writing == "pattern":
        deep = lambda z: z  # noqa: E731
    rows = pd.DataFrame({
        "UTC": time(table["t"]), "Latitude": angle(table["lat"]), "Longitude": angle(table["lon"]),
        "own lat": angle(table["dr_lat"]), "own lon": angle(table["dr_lon"]), "z": deep(table["depth"]), "HDOP": table["hdop"],
        "unused": "words, with a comma",
    })  # fmt: skip
    path = tmp_path / "log.csv"
    path.write_text("# a preface\n" + rows.to_csv(index=False, sep=separator, float_format="%.10f"))
    names = [
        f"time=UTC[{time_unit}] lat=Latitude[{angle_unit}] lon=Longitude[{angle_unit}] depth=z[{deep_unit}]",
        f"dr_lat=own lat[{angle_unit}]", f"dr_lon=own lon[{angle_unit}]", "hdop=HDOP",
    ]  # fmt: skip
    assert_same_legs(import_logs([path], names=names), expected)


def test_decimal_commas_and_a_mapping_file(table, expected, tmp_path):
    rows = table.rename(columns={"t": "Zeit", "lat": "Breite", "lon": "Länge", "depth": "Tiefe"})
    path = tmp_path / "log.csv"
    path.write_text(rows.to_csv(index=False, sep=";", decimal=",", float_format="%.9f"), encoding="utf-8")
    names = tmp_path / "names.yaml"
    names.write_text(
        "time: Zeit[epoch]\nlat: Breite\nlon: Länge\ndepth: Tiefe[m]\ndr_lat: dr_lat\ndr_lon: dr_lon\n",
        encoding="utf-8",
    )
    assert_same_legs(import_logs([path], names=[str(names)]), expected)


def test_one_position_alone_is_split_at_the_surface(log, expected, tmp_path):
    track = log.track
    own = pd.DataFrame({"t": track.reckoned.t, "lat": track.reckoned.latitude, "lon": track.reckoned.longitude})
    fixed = pd.DataFrame({"t": track.fixes.t, "lat": track.fixes.latitude, "lon": track.fixes.longitude})
    rows = pd.concat([fixed, own]).drop_duplicates("t").sort_values("t")
    rows["depth"] = track.depth.at(rows["t"].to_numpy())
    path = tmp_path / "auv.csv"
    path.write_text(rows.to_csv(index=False, float_format="%.9f"))
    names = ["time=t[epoch] lat=lat lon=lon depth=depth"]
    result = import_logs([path], names=names)
    assert any("one position alone" in notice for notice in result.provenance.notices)
    assert len(result.table) == LEGS
    for depth in (-rows["depth"], rows["depth"] + 10.1, rows["depth"].where(np.arange(len(rows)) % 50 != 7, -9999.0)):
        path.write_text(rows.assign(depth=depth).to_csv(index=False, float_format="%.9f").upper(), encoding="utf-16")
        other = import_logs([path], names=names)  # heights, an absolute pressure, -9999 for none; UTF-16, in capitals
        np.testing.assert_allclose(other.table["t_end_s"], result.table["t_end_s"])
        np.testing.assert_allclose(other.table["lat_dr_end"], result.table["lat_dr_end"], atol=1e-6)
    np.testing.assert_allclose(result.table["t_end_s"], expected["t_end_s"])
    np.testing.assert_allclose(result.table["lat_end"], expected["lat_end"], atol=1e-6)


def test_gpx_and_nmea_join_a_table(log, table, expected, tmp_path):
    gpxpy, pynmea2 = pytest.importorskip("gpxpy"), pytest.importorskip("pynmea2")
    own = table.dropna(subset=["dr_lat"]).rename(columns={"dr_lat": "a", "dr_lon": "b"})
    own["depth"] = log.track.depth.at(own["t"].to_numpy())
    (tmp_path / "own.csv").write_text(own[["t", "a", "b", "depth"]].to_csv(index=False, float_format="%.9f"))
    names = ["time=t[epoch] dr_lat=a dr_lon=b depth=depth"]
    gpx = gpxpy.gpx.GPX()
    gpx.tracks.append(gpxpy.gpx.GPXTrack())
    gpx.tracks[0].segments.append(gpxpy.gpx.GPXTrackSegment())
    sentences = []
    for t, lat, lon in zip(log.track.fixes.t, log.track.fixes.latitude, log.track.fixes.longitude, strict=True):
        moment = pd.Timestamp(t, unit="s", tz="UTC").to_pydatetime()
        gpx.tracks[0].segments[0].points.append(gpxpy.gpx.GPXTrackPoint(lat, lon, time=moment))
        place = (f"{ddmm(lat):.5f}", "N", f"{abs(ddmm(lon)):.5f}", "W")
        clock = f"{moment:%H%M%S}.00"
        sentences.append(pynmea2.GGA("GP", "GGA", (clock, *place, "1", "09", "0.8", "1", "M", "0", "M", "", "")))
        sentences.append(pynmea2.RMC("GP", "RMC", (clock, "A", *place, "0.1", "90", f"{moment:%d%m%y}", "", "", "A")))
    (tmp_path / "fixes.gpx").write_text(gpx.to_xml())
    (tmp_path / "fixes.nmea").write_text("\r\n".join(str(each) for each in sentences) + "\r\n$GPRMC,broken*00\r\n")
    by_gpx = import_logs([tmp_path / "own.csv", tmp_path / "fixes.gpx"], format="track", names=names)
    assert_same_legs(by_gpx, expected)
    by_nmea = import_logs([tmp_path / "own.csv", tmp_path / "fixes.nmea"], format="track", names=names)
    assert_same_legs(by_nmea, expected)
    np.testing.assert_allclose(by_nmea.table["fix_sd_m"], 0.8 * 5.0 / np.sqrt(2.0), atol=1e-3)


def test_a_netcdf_track(log, table, expected, tmp_path):
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("netCDF4")
    data = xarray.Dataset({name: ("n", table[name].to_numpy()) for name in ("lat", "lon", "dr_lat", "dr_lon", "depth")})
    data["when"] = ("n", (table["t"].to_numpy() - 1.6e9) / 60.0)
    data["when"].attrs["units"] = "minutes since 2020-09-13T12:26:40"
    data.to_netcdf(tmp_path / "track.nc")
    names = ["time=when lat=lat lon=lon dr_lat=dr_lat dr_lon=dr_lon depth=depth"]
    assert_same_legs(import_logs([tmp_path / "track.nc"], names=names), expected)


def test_a_moos_log(log, expected, tmp_path):
    track, start = log.track, float(log.track.fixes.t[0]) - 10.0
    lines = ["%% LOG FILE:       ./made.alog", f"%% LOGSTART           {start}"]
    rows = [(t, "GPS_LATITUDE", value) for t, value in zip(track.fixes.t, track.fixes.latitude, strict=True)]
    rows += [(t + 0.01, "GPS_LONGITUDE", value) for t, value in zip(track.fixes.t, track.fixes.longitude, strict=True)]
    rows += [(t, "NAV_LAT", value) for t, value in zip(track.reckoned.t, track.reckoned.latitude, strict=True)]
    rows += [(t, "NAV_LONG", value) for t, value in zip(track.reckoned.t, track.reckoned.longitude, strict=True)]
    rows += [(t, "NAV_DEPTH", value) for t, value in zip(track.depth.t, track.depth.values, strict=True)]
    rows += [(t, "NAV_HEADING", value) for t, value in zip(track.heading.t, track.heading.values, strict=True)]
    rows += [(t, "DB_CLIENTS", "pNodeReporter,pLogger") for t in track.depth.t[::7]]
    lines += [f"{t - start:.3f} {name} app {value}" for t, name, value in sorted(rows)]
    (tmp_path / "made.alog").write_text("\n".join(lines) + "\n")
    result = import_logs([tmp_path / "made.alog"])
    assert_same_legs(result, expected)
    assert result.table["heading_deg"].notna().all()


def test_a_moos_log_in_metres(log, expected, tmp_path):
    from missionplan.importers.geodesy import displacement

    track, start = log.track, float(log.track.fixes.t[0])
    origin = (48.01, -123.02)
    east, north = displacement(*origin, track.reckoned.latitude, track.reckoned.longitude)
    lines = [f"%% LOGSTART {start}"]
    rows = [(t, "MY_LAT", value) for t, value in zip(track.fixes.t, track.fixes.latitude, strict=True)]
    rows += [(t, "MY_LON", value) for t, value in zip(track.fixes.t, track.fixes.longitude, strict=True)]
    rows += [(t, "NAV_X", value) for t, value in zip(track.reckoned.t, east, strict=True)]
    rows += [(t, "NAV_Y", value) for t, value in zip(track.reckoned.t, north, strict=True)]
    rows += [(t, "NAV_DEPTH", value) for t, value in zip(track.depth.t, track.depth.values, strict=True)]
    lines += [f"{t - start:.3f} {name} app {value:.9f}" for t, name, value in sorted(rows)]
    (tmp_path / "made.alog").write_text("\n".join(lines) + "\n")
    named = import_logs([tmp_path / "made.alog"], names=["lat=MY_LAT lon=MY_LON", f"origin={origin[0]},{origin[1]}"])
    assert_same_legs(named, expected, metres=2.0)
    found = import_logs([tmp_path / "made.alog"], names=["lat=MY_LAT lon=MY_LON"])
    assert_same_legs(found, expected, metres=2.0)


def test_an_og1_file_with_its_flag_of_dead_reckoning(log, table, expected, tmp_path):
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("netCDF4")
    own = table["dr_lat"].notna().to_numpy()
    data = xarray.Dataset({
        "LATITUDE_GPS": ("n", table["lat"].to_numpy()), "LONGITUDE_GPS": ("n", table["lon"].to_numpy()),
        "LATITUDE": ("n", table["dr_lat"].to_numpy()), "LONGITUDE": ("n", table["dr_lon"].to_numpy()),
        "DEPTH": ("n", table["depth"].to_numpy()), "DEAD_RECKONING": ("n", own.astype("i1")),
        "TIME": ("n", table["t"].to_numpy()),
    })  # fmt: skip
    data["TIME"].attrs["units"] = "seconds since 1970-01-01T00:00:00Z"
    data.to_netcdf(tmp_path / "glider.nc")
    result = import_logs([tmp_path / "glider.nc"])
    assert result.format == "og1"
    assert "DEAD_RECKONING" in result.reckoning
    assert_same_legs(result, expected)


def test_a_seaexplorer_log_packed_and_damaged(tmp_path):
    import gzip
    from pathlib import Path

    text = (Path(__file__).parent / "made.gli").read_bytes()
    (tmp_path / "made.7.gli.sub.1.gz").write_bytes(gzip.compress(text))
    (tmp_path / "made.7.gli.sub.2.gz").write_bytes(gzip.compress(text.replace(b"2023", b"2024"))[:500])
    (tmp_path / "made.7.gli.sub.3").write_bytes(text[:90] + b"\n")
    (tmp_path / "notes.txt").write_text("calm sea")
    result = import_logs([tmp_path])
    assert len(result.table) == 3
    assert any("made.7.gli.sub.2.gz" in each for each in result.passed_over)
    assert any("notes.txt: passed over: no log of a known format" in each for each in result.passed_over)


def test_what_cannot_be_read_is_said_at_once(tmp_path):
    with pytest.raises(InputError, match="no such file or folder"):
        import_logs([tmp_path / "missing"])
    (tmp_path / "a.txt").write_text("nothing")
    with pytest.raises(InputError, match="no log of a known format"):
        import_logs([tmp_path])
    with pytest.raises(InputError, match="did you mean seaglider"):
        import_logs([tmp_path], format="seaglidr")
    (tmp_path / "b.csv").write_text("t,lat\n1,2\n")
    with pytest.raises(InputError, match="which columns have time and position"):
        import_logs([tmp_path / "b.csv"], format="track")
    with pytest.raises(InputError, match="no column lonn"):
        import_logs([tmp_path / "b.csv"], names=["time=t[epoch] lat=lat lon=lonn"])
    with pytest.raises(InputError, match="did you mean depth"):
        import_logs([tmp_path / "b.csv"], names=["dept=z"])
    with pytest.raises(InputError, match="time in 'fortnights'"):
        import_logs([tmp_path / "b.csv"], names=["time=t[fortnights] lat=lat lon=lat"])


def test_a_track_is_moved_to_a_made_up_place(table, expected, tmp_path):
    path = tmp_path / "log.csv"
    path.write_text(table.to_csv(index=False, float_format="%.9f"))
    names = ["time=t[epoch] lat=lat lon=lon dr_lat=dr_lat dr_lon=dr_lon depth=depth"]
    here, there = import_logs([path], names=names), import_logs([path], names=names, shift_origin=(10.0, 20.0))
    assert there.table["lat_start"].iloc[0] == pytest.approx(10.0, abs=0.01)
    written = "".join(str(content) for content in there.files().values())
    assert "48.0" not in written
    for name in ("velocity_error_mean_east", "velocity_error_mean_north", "leg_length"):
        assert getattr(there.figures, name) == pytest.approx(getattr(here.figures, name), rel=2e-3, abs=1e-4)


@pytest.mark.parametrize(
    ("word", "value"),
    [("48.652", 48.652), ("48 39.12 N", 48.652), ("48°39'07.2\"N", 48.652), ("W 123 28.473", -123.47455),
     ("123:28:28.4W", -123.474556), ("-12.5", -12.5), ("-12 30", -12.5), ("north", np.nan), ("48,652", 48.652)],
)  # fmt: skip
def test_degrees_as_people_write_them(word, value):
    assert degrees_of(word) == pytest.approx(value, abs=1e-6, nan_ok=True)


def test_degrees_and_minutes_in_one_number():
    np.testing.assert_allclose(ddmm_to_degrees(np.array([4839.12, -12328.473])), [48.652, -123.47455], atol=1e-9)
    np.testing.assert_allclose(angles(pd.Series(["4839.12N", "12328.473W"]), "ddmm"), [48.652, -123.47455], atol=1e-9)


def test_times_without_a_zone_are_utc():
    both = times(pd.Series(["2023-11-14 22:13:20", "2023-11-15T00:13:20+02:00", "", "soon"]), "iso")
    np.testing.assert_allclose(both[:2], 1_700_000_000.0)
    assert np.isnan(both[2:]).all()


def test_a_clock_that_steps_back_is_told(log, table, tmp_path):
    rows = table.copy()
    middle = (rows["t"] > log.starts[1] + 600.0) & (rows["t"] < log.starts[1] + 900.0)
    rows["written"] = rows["t"] + np.where(middle, 400.0, 0.0)
    path = tmp_path / "log.csv"
    path.write_text(rows.to_csv(index=False, float_format="%.9f"))
    result = import_logs([path], names=["time=written[epoch] lat=lat lon=lon dr_lat=dr_lat dr_lon=dr_lon depth=depth"])
    assert result.dives["ok"].tolist() == [1, 0, 1, 1]
    assert "clock jumps back" in result.dives["reason"][1]


def test_a_gridded_position_without_dead_reckoning_is_said(log, tmp_path):
    track = replace(log.track)
    rows = pd.DataFrame({"t": track.fixes.t, "lat": track.fixes.latitude, "lon": track.fixes.longitude})
    path = tmp_path / "fixes.csv"
    path.write_text(rows.to_csv(index=False, float_format="%.9f"))
    with pytest.raises(InputError, match="none has a dead-reckoned end"):
        import_logs([path], names=["time=t[epoch] lat=lat lon=lon"])


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_an_imc_log_whole_and_cut_off(log, expected, tmp_path):
    imcpy = pytest.importorskip("imcpy")
    track, messages = log.track, []
    fixed = zip(track.fixes.t, np.radians(track.fixes.latitude), np.radians(track.fixes.longitude), strict=True)
    for t, lat, lon in fixed:
        fix = imcpy.GpsFix()
        fix.timestamp, fix.lat, fix.lon, fix.hacc, fix.satellites = t, lat, lon, 3.0, 9
        fix.validity = 4 | 32  # position and accuracy
        messages.append(fix)
    for t, lat, lon in zip(track.reckoned.t, track.reckoned.latitude, track.reckoned.longitude, strict=True):
        state = imcpy.EstimatedState()
        state.timestamp, state.lat, state.lon = t, np.radians(lat), np.radians(lon)
        state.depth, state.psi = float(track.depth.at(t)), np.radians(float(track.heading.at(t)))
        messages.append(state)
        rpm = imcpy.Rpm()
        rpm.timestamp, rpm.value = t, 1200
        messages.append(rpm)
    messages.append(imcpy.Temperature())
    messages.sort(key=lambda each: each.timestamp)
    content = b"".join(imcpy.Packet.serialize(each) for each in messages)
    (tmp_path / "Data.lsf").write_bytes(content)
    result = import_logs([tmp_path])
    assert result.format == "imc"
    assert_same_legs(result, expected)
    np.testing.assert_allclose(result.table["fix_sd_m"], 3.0 / np.sqrt(2.0), atol=1e-3)
    assert (result.table["rpm"] == 1200.0).all()
    assert list(tmp_path.iterdir()) == [tmp_path / "Data.lsf"]  # no index is left beside the log
    (tmp_path / "Data.lsf").write_bytes(content[: len(content) * 6 // 10])
    part = import_logs([tmp_path])
    assert len(part.table) == 2
    assert any("ends within a message" in each for each in part.passed_over)


@pytest.fixture(scope="module", params=[1, 2])
def bag(request, log, tmp_path_factory):
    """A bag of each ROS, with fixes and odometry in metres from the first fix."""
    pytest.importorskip("rosbags.rosbag1")
    from rosbags.rosbag1 import Writer as Writer1
    from rosbags.rosbag2 import Writer as Writer2
    from rosbags.typesys import Stores, get_typestore

    from missionplan.importers.geodesy import displacement

    first = request.param == 1
    folder = tmp_path_factory.mktemp(f"ros{request.param}")
    store = get_typestore(Stores.ROS1_NOETIC if first else Stores.ROS2_HUMBLE)
    t = store.types
    track = log.track
    place = displacement(
        track.fixes.latitude[0], track.fixes.longitude[0], track.reckoned.latitude, track.reckoned.longitude
    )

    def header(time):
        stamp = t["builtin_interfaces/msg/Time"](sec=int(time), nanosec=round((time % 1.0) * 1e9))
        number = {"seq": 0} if first else {}
        return t["std_msgs/msg/Header"](stamp=stamp, frame_id="map", **number)

    def fix(k):
        return t["sensor_msgs/msg/NavSatFix"](
            header(track.fixes.t[k]), t["sensor_msgs/msg/NavSatStatus"](status=0, service=1),
            latitude=track.fixes.latitude[k], longitude=track.fixes.longitude[k], altitude=0.0,
            position_covariance=np.diag([4.0, 4.0, 9.0]).ravel(), position_covariance_type=2,
        )  # fmt: skip

    def odometry(k):
        yaw = np.radians(90.0 - float(track.heading.at(track.reckoned.t[k])))
        vector = t["geometry_msgs/msg/Vector3"]
        point = t["geometry_msgs/msg/Point"](place[0][k], place[1][k], -float(track.depth.at(track.reckoned.t[k])))
        turn = t["geometry_msgs/msg/Quaternion"](0.0, 0.0, np.sin(yaw / 2.0), np.cos(yaw / 2.0))
        pose = t["geometry_msgs/msg/PoseWithCovariance"](t["geometry_msgs/msg/Pose"](point, turn), np.zeros(36))
        twist = t["geometry_msgs/msg/Twist"](vector(0.0, 0.0, 0.0), vector(0.0, 0.0, 0.0))
        return t["nav_msgs/msg/Odometry"](
            header(track.reckoned.t[k]), "base", pose, t["geometry_msgs/msg/TwistWithCovariance"](twist, np.zeros(36))
        )

    newest = {"version": 9} if "version" in inspect.signature(Writer2).parameters else {}
    writer = Writer1(folder / "made.bag") if first else Writer2(folder / "made", **newest)
    serialize = store.serialize_ros1 if first else store.serialize_cdr
    with writer:
        topics = {"/fix": "sensor_msgs/msg/NavSatFix", "/odom": "nav_msgs/msg/Odometry"}
        links = {topic: writer.add_connection(topic, kind, typestore=store) for topic, kind in topics.items()}
        for topic, make, times_of in (("/fix", fix, track.fixes.t), ("/odom", odometry, track.reckoned.t)):
            for k, time in enumerate(times_of):
                writer.write(links[topic], int(time * 1e9), serialize(make(k), topics[topic]))
    return folder


def test_a_ros_bag(bag, expected):
    result = import_logs([bag])
    assert result.format == "rosbag"
    assert_same_legs(result, expected, metres=2.0)
    np.testing.assert_allclose(result.table["fix_sd_m"], 2.0, atol=1e-3)
    assert result.table["max_depth_m"].min() > 90.0


def test_a_topic_that_a_bag_lacks_is_said(bag):
    with pytest.raises(InputError, match=r"no topic '/gps'; there is /fix"):
        import_logs([bag], names=["gps=/gps"])
