"""What each reader makes of one message or reading: units, axes, qualities and flags as the format's makers define them."""

from types import SimpleNamespace as Message

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from missionplan.importers.geodesy import displacement
from missionplan.importers.importer import ChannelStore, ColumnStore, ReadOptions, SourceLog, known_importers
from missionplan.importers.readers import ardupilot, imc, rosbag, seaglider, slocum, trajectory
from missionplan.importers.readers.netcdf import Variables
from missionplan.importers.track import fixes

NAN = float("nan")


def track_of(name, *files):
    return known_importers()[0][name].read(files, ReadOptions(), SourceLog())


def values_at(found, t):
    """Readings of a channel, which are at these times."""
    np.testing.assert_allclose(found.t, t, rtol=0.0, atol=1e-6)
    return found.values


# --- IMC (LSTS/imc, IMC.xml): radians; validity 0x4 position, 0x20 accuracy, 0x80 dilution; types 2 to 4 no receiver's ---


@pytest.mark.parametrize(
    ("validity", "kind", "quality"),
    [
        *[(0x4 | 0x20 | 0x80, 0, (2.5, 1.3, 9.0, 1.0)), (0x4 | 0x20, 1, (2.5, NAN, 9.0, 1.0))],
        *[(0x4 | 0x80, 0, (NAN, 1.3, 9.0, 1.0)), (0x4 | 0x40, 0, (NAN, NAN, 9.0, 1.0))],
        *[(0x20 | 0x80, 0, (NAN, NAN, NAN, 0.0)), *((0x4 | 0x20, kind, (NAN, NAN, NAN, 0.0)) for kind in (2, 3, 4))],
    ],
)
def test_a_fix_of_imc(validity, kind, quality):
    fix = {"lat": np.radians(48.5), "lon": np.radians(-123.25), "hacc": 2.5, "hdop": 1.3, "satellites": 9}
    found = imc._values("GpsFix", Message(timestamp=7.0, validity=validity, type=kind, **fix))
    assert found == pytest.approx((7.0, 48.5, -123.25, *quality), nan_ok=True)


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_states_of_imc_lie_north_and_east_of_their_reference(tmp_path):
    """`x` is north and `y` east of the latitude and longitude; psi is a heading, theta a pitch, a depth of -1 is none."""
    imcpy = pytest.importorskip("imcpy", reason="imcpy is not installed")
    made = []

    def add(kind, t, source=26, **fields):
        message = getattr(imcpy, kind)()
        message.timestamp, message.src = t, source
        for name, value in fields.items():
            setattr(message, name, value)
        made.append(message)

    t = 1.7e9 + 10.0 * np.arange(4)
    place = {"lat": np.radians(48.0), "lon": np.radians(-123.0)}
    for k in range(4):
        add("GpsFix", t[k], validity=4, **place)
        add("EstimatedState", t[k], x=100.0 * k, y=-30.0 * k, depth=-1.0, psi=-0.5, theta=0.25, **place)
        add("Depth", t[k] + 1.0, value=5.0 + k)
        add("Rpm", t[k] + 2.0, value=1200 + k)
        add("EulerAngles", t[k], psi=2.0, theta=1.0)
    path = tmp_path / "Data.lsf"
    path.write_bytes(b"".join(imcpy.Packet.serialize(each) for each in made))
    found = track_of("imc", path)
    east, north = displacement(48.0, -123.0, found.reckoned.latitude, found.reckoned.longitude)
    assert (east, north) == (
        pytest.approx(-30.0 * np.arange(4), abs=0.05),
        pytest.approx(100.0 * np.arange(4), abs=0.05),
    )
    assert values_at(found.heading, t) == pytest.approx(np.degrees(-0.5) + 360.0, abs=1e-4)
    assert values_at(found.pitch, t) == pytest.approx(np.degrees(0.25), abs=1e-4)
    assert values_at(found.depth, t + 1.0) == pytest.approx(5.0 + np.arange(4))
    assert values_at(found.rpm, t + 2.0) == pytest.approx(1200.0 + np.arange(4))
    assert found.heading_from == "true"
    path.write_bytes(
        b"".join(imcpy.Packet.serialize(each) for each in made if not isinstance(each, imcpy.EstimatedState))
    )
    without = track_of("imc", path)
    assert values_at(without.heading, t) == pytest.approx(np.degrees(2.0), abs=1e-4)
    assert values_at(without.pitch, t) == pytest.approx(np.degrees(1.0), abs=1e-4)


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
@pytest.mark.parametrize("ship", [20, 30])
def test_a_ship_that_only_logs_fixes_is_not_taken_for_the_vehicle(ship, tmp_path):
    """The system with the most states is the vehicle where none has both: fixes of another are not its own."""
    imcpy = pytest.importorskip("imcpy", reason="imcpy is not installed")
    made = []
    for k in range(3):
        for kind, source, count in (("EstimatedState", 26, 2), ("GpsFix", ship, 4)):
            for part in range(count):
                message = getattr(imcpy, kind)()
                message.timestamp, message.src, message.lat = 1.7e9 + 10.0 * k + part, source, 0.8
                made.append(message)
    path = tmp_path / "Data.lsf"
    path.write_bytes(b"".join(imcpy.Packet.serialize(each) for each in made))
    found = track_of("imc", path)
    assert (found.fixes.t.size, found.reckoned.t.size) == (0, 6)


# --- ArduPilot: MAVLink in 1e-7 deg, mm, cm of dilution; dataflash in its own units; instance or core 0 alone -----------


def gathered(*messages):
    found = ardupilot._Found()
    for kind, message in messages:
        ardupilot._add(found, kind, 7.0, message)
    return {
        name: {key: each[key].tolist() for key in ardupilot._COLUMNS[name]}
        for name, each in found.samples.items()
        if len(each)
    }, found


@pytest.mark.parametrize(
    ("eph", "h_acc", "seen", "kind", "quality"),
    [
        (123, 2500, 9, 3, (1.23, 2.5, 9.0, 1.0)),
        (65535, 0, 255, 4, (NAN, NAN, NAN, 1.0)),
        (123, 2500, 0, 2, (1.23, 2.5, 0.0, 0.0)),
    ],
)
def test_a_fix_of_mavlink(eph, h_acc, seen, kind, quality):
    raw = Message(lat=485000000, lon=-1232500000, eph=eph, h_acc=h_acc, satellites_visible=seen, fix_type=kind)
    found, told = gathered(("GPS_RAW_INT", raw))
    assert [each[0] for each in found["fix"].values()] == pytest.approx([7.0, 48.5, -123.25, *quality], nan_ok=True)
    assert (told.told["gps"], told.told["fix"]) == (1, int(quality[-1]))
    nowhere = Message(**{**vars(raw), "lat": 0, "lon": 0})
    assert gathered(("GPS_RAW_INT", nowhere))[1].told["fix"] == 0


def test_other_messages_of_an_autopilot():
    fix = {"Lat": 48.5, "Lng": -123.25, "HDop": 1.1, "NSats": 9}
    found, _ = gathered(
        ("GPS", Message(**fix, Status=3, I=0)), ("GPS", Message(**fix, Status=2)), ("GPS", Message(**fix, Status=3, I=1)),
        ("GLOBAL_POSITION_INT", Message(lat=485000000, lon=-1232500000, relative_alt=-2500)),
        ("POS", Message(Lat=48.5, Lng=-123.5)),
        ("XKF1", Message(C=0, PN=10.0, PE=-3.0)), ("NKF1", Message(PN=20.0, PE=-6.0)), ("XKF1", Message(C=1, PN=1.0, PE=1.0)),
        ("LOCAL_POSITION_NED", Message(x=30.0, y=-9.0)),
        ("CTUN", Message(Alt=-4.0)), ("BARO", Message(Alt=-6.0, I=0)), ("BARO", Message(Alt=-8.0, I=1)),
        ("ATT", Message(Yaw=350.0, Pitch=-5.0)),
        ("ATTITUDE", Message(yaw=-0.5, pitch=0.1, time_boot_ms=1500)),
        ("ORGN", Message(Type=0, Lat=48.0, Lng=-123.0)), ("ORGN", Message(Type=1, Lat=1.0, Lng=2.0)),
        ("GPS_GLOBAL_ORIGIN", Message(latitude=490000000, longitude=-1240000000)),
    )  # fmt: skip
    assert found["fix"]["valid"] == [1.0, 0.0]
    assert (found["fix"]["hdop"], found["fix"]["satellites"]) == ([1.1] * 2, [9.0] * 2)
    assert np.isnan(found["fix"]["accuracy"]).all()
    assert found["place"] == {"t": [7.0] * 2, "lat": pytest.approx([48.5] * 2), "lon": pytest.approx([-123.25, -123.5])}
    assert found["depth"]["depth"] == [2.5, 4.0]
    assert found["barometer"]["depth"] == [6.0]
    assert (found["plane"]["north"], found["plane"]["east"]) == ([10.0, 20.0, 30.0], [-3.0, -6.0, -9.0])
    assert found["attitude"]["heading"] == pytest.approx([350.0, np.degrees(-0.5)])
    assert found["attitude"]["pitch"] == pytest.approx([-5.0, np.degrees(0.1)])
    assert found["boot"]["since"] == [1.5]
    places = {"lat": pytest.approx([48.0, 49.0]), "lon": pytest.approx([-123.0, -124.0])}
    assert found["origin"] == {"t": [7.0] * 2, **places}


def test_what_an_autopilot_is_and_when_it_began_anew():
    beats = [("HEARTBEAT", Message(type=kind)) for kind in (12, 12, 6, 6, 6, 30, 2)]
    assert gathered(*beats)[1].kinds == {12: 2, 2: 1}  # ground stations and cameras are no vehicles
    told = [("MSG", Message(Message=words)) for words in ("ArduSub V4.1.0", "ArduCopter V4", "IMU0 is ArduSub")]
    assert gathered(*told)[1].kinds == {12: 1, 2: 1}
    boot = ardupilot.Samples(("t", "since"))
    for t, since in ((0.0, 100.0), (10.0, 110.0), (20.0, 109.5), (30.0, 2.0)):
        boot.add(t, since)
    assert [(each.t, each.at_surface_too) for each in ardupilot._restarts(boot)] == [(30.0, False)]
    week = Message(GWk=2288, GMS=252_818_000)  # gpsd's and NASA's converters: 2023-11-14 22:13:20 UTC, 18 s behind GPS
    assert ardupilot._gps_time(week) == 1_700_000_000.0


# --- ROS (REP 103, sensor_msgs, nav_msgs): east, north, up by quaternion; pascals; an unknown covariance is of type 0 ----


def head(t=3.25, frame="map"):
    return Message(stamp=Message(sec=int(t), nanosec=round(t % 1.0 * 1e9)), frame_id=frame)


@pytest.mark.parametrize(("kind", "variance", "status", "accuracy"), [(2, 4.0, 0, 13.0**0.5), (0, 4.0, 0, NAN), (2, 0.0, 0, NAN), (2, 4.0, -1, NAN)])  # fmt: skip
def test_a_fix_of_ros(kind, variance, status, accuracy):
    fix = Message(header=head(), latitude=48.5, longitude=-123.25, position_covariance=np.diag([variance, 9.0, 100.0]).ravel(),
                  position_covariance_type=kind, status=Message(status=status))  # fmt: skip
    assert rosbag._fix(fix, 99.0) == pytest.approx(
        (3.25, 48.5, -123.25, accuracy, float(status >= 0), 99.0), nan_ok=True
    )
    fix.header = head(0.0)
    assert rosbag._fix(fix, 99.0)[0] == 99.0  # no time in the header: that of its arrival


@pytest.mark.parametrize("angles", [(0.3, 0.2, -0.4), (-2.9, -0.7, 0.1), (1.5, 1.2, 3.0)])
def test_a_pose_of_ros_is_turned_as_its_quaternion_says(angles):
    """Yaw, pitch and roll, one after the other about the vehicle's own axes, by another library."""
    x, y, z, w = Rotation.from_euler("ZYX", angles).as_quat()
    pose = Message(position=Message(x=1.0, y=2.0, z=-3.0), orientation=Message(x=x, y=y, z=z, w=w))
    for frame, held, is_ned in (("odom", Message(pose=pose), 0.0), ("odom_NED", pose, 1.0)):
        found = rosbag._odometry(Message(header=head(frame=frame), pose=held), 99.0)
        assert found == pytest.approx((3.25, 1.0, 2.0, -3.0, angles[0], angles[1], is_ned))


def test_depths_of_ros_and_which_way_is_up():
    assert rosbag._depth(Message(header=head(), fluid_pressure=25_000.0), 99.0) == (3.25, 2.5, 1.0)
    assert rosbag._depth(Message(data=7.5), 99.0) == (99.0, 7.5, 0.0)
    z = np.linspace(0.0, 30.0, 100)
    assert [rosbag._is_downwards(each) for each in (z, -z, z - 15.0, 0.01 * z, z[:0])] == [
        True,
        False,
        False,
        False,
        False,
    ]


# --- Seaglider and OG1 -------------------------------------------------------------------------------------------------


def netcdf(**given):
    xarray = pytest.importorskip("xarray")
    return Variables(
        xarray.Dataset(
            {name: (dim, np.asarray(values), attributes) for name, (dim, values, attributes) in given.items()}
        )
    )


SINCE = {"units": "seconds since 1970-01-01"}


def test_a_dive_of_a_seaglider():
    gps, own = ("gps_info",), ("sg_data_point",)
    given = {
        "log_gps_time": (gps, [10.0, 20.0, 90.0], SINCE), "log_gps_lat": (gps, [48.0, 48.1, 48.2], {}), "log_gps_lon": (gps, [-123.0, -123.1, -123.2], {}),
        "log_gps_hpe": (gps, [3.0, -1.0, 0.0], {}), "log_gps_hdop": (gps, [1.1, 1.2, -1.0], {}), "log_gps_n_satellites": (gps, [9.0, -1.0, 7.0], {}),
        "log_gps_magvar": (gps, [15.5, 15.5, 15.6], {}),
        "time": (own, [30.0, 40.0], SINCE), "depth": (own, [5.0, 6.0], {"units": "meters"}), "eng_pitchAng": (own, [-20.0, -21.0], {}),
        "eng_head": (own, [100.0, 110.0], {}), "horz_speed": (own, [30.0, 31.0], {"units": "cm/s"}),
    }  # fmt: skip
    found = seaglider._dive(netcdf(**given))
    assert (found.fixes.t.tolist(), found.fixes.latitude.tolist()) == ([10.0, 20.0, 90.0], [48.0, 48.1, 48.2])
    assert found.fixes.longitude.tolist() == [-123.0, -123.1, -123.2]
    np.testing.assert_array_equal(found.fixes.accuracy, [3.0, NAN, NAN])
    np.testing.assert_array_equal(found.fixes.hdop, [1.1, 1.2, NAN])
    np.testing.assert_array_equal(found.fixes.satellites, [9.0, NAN, 7.0])
    assert values_at(found.declination, [10.0, 20.0, 90.0]).tolist() == [15.5, 15.5, 15.6]
    for name, values in (
        ("depth", [5.0, 6.0]),
        ("pitch", [-20.0, -21.0]),
        ("heading", [100.0, 110.0]),
        ("speed", [0.3, 0.31]),
    ):
        assert values_at(getattr(found, name), [30.0, 40.0]) == pytest.approx(values)
    ways = {
        "east_displacement_gsm": (own, [1.0, 2.0], {"units": "meters"}),
        "north_displacement_gsm": (own, [3.0, 4.0], {"units": "meters"}),
    }
    slope = seaglider._dive(netcdf(**given, **ways))
    assert [each.tolist() for each in slope.ways] == [[30.0, 40.0], [1.0, 2.0], [3.0, 4.0]]
    assert "glide slope" in slope.reckoning
    assert len(slope.speed) == 0  # it is in the displacements
    better = {
        name.removesuffix("_gsm"): (dims, [10.0 * each for each in values], {"units": "m"})
        for name, (dims, values, _) in ways.items()
    }
    model = seaglider._dive(netcdf(**given, **ways, **better))
    assert model.ways[1].tolist() == [10.0, 20.0]
    assert "hydrodynamic" in model.reckoning
    with pytest.raises(ValueError, match="fewer than two fixes"):
        seaglider._dive(netcdf(**{**given, "log_gps_lat": (gps, [48.0, NAN, NAN], {})}))


def test_a_phase_of_og1_that_is_surface_drift():
    flags = {"flag_meanings": "descent, ascent surface_drift", "flag_values": "1b, 2b, 5b"}
    file = netcdf(TIME=("n", [0.0, 1.0, 2.0], SINCE), PHASE=("n", [1.0, 5.0, 2.0], flags))
    assert values_at(seaglider._drifting(file, "PHASE"), [0.0, 1.0, 2.0]).tolist() == [0.0, 1.0, 0.0]
    assert len(seaglider._drifting(file, None)) == 0
    assert len(seaglider._drifting(netcdf(TIME=("n", [0.0], SINCE), PHASE=("n", [1.0], {})), "PHASE")) == 0


def test_a_deployment_of_og1():
    """Its model's speed leads on where it has neither displacements nor positions that it calls dead-reckoned."""
    gps, own = ("gps",), ("n",)
    given = {
        "TIME_GPS": (gps, [10.0, 20.0], SINCE), "LATITUDE_GPS": (gps, [48.0, 48.1], {}), "LONGITUDE_GPS": (gps, [-123.0, -123.1], {}),
        "LATITUDE_GPS_QC": (gps, [1.0, 4.0], {}), "TIME": (own, [30.0, 40.0], SINCE), "DEPTH": (own, [5.0, 6.0], {"units": "m"}),
        "PITCH": (own, [-20.0, -21.0], {}), "HEADING": (own, [100.0, 110.0], {}), "GLIDER_HORZ_VELO_MODEL": (own, [30.0, 31.0], {"units": "cm/s"}),
        "MAGNETIC_DECLINATION": (own, [15.0, 15.5], {}), "LATITUDE": (own, [48.2, 48.3], {}), "LONGITUDE": (own, [-123.2, -123.3], {}),
    }  # fmt: skip
    found = seaglider._deployment(netcdf(**given))
    assert (found.fixes.t.tolist(), found.fixes.latitude.tolist()) == ([10.0, 20.0], [48.0, 48.1])
    assert (found.fixes.longitude.tolist(), found.fixes.valid.tolist()) == ([-123.0, -123.1], [1.0, 0.0])
    for name, values in {"depth": [5.0, 6.0], "pitch": [-20.0, -21.0], "heading": [100.0, 110.0], "speed": [0.3, 0.31],
                         "declination": [15.0, 15.5]}.items():  # fmt: skip
        assert values_at(getattr(found, name), [30.0, 40.0]) == pytest.approx(values), name
    ways = {
        f"{axis}_displacement": (own, steps, {"units": "m"})
        for axis, steps in (("east", [1.0, 2.0]), ("north", [3.0, 4.0]))
    }
    led = seaglider._deployment(netcdf(**given, **ways))
    assert ([each.tolist() for each in led.ways], len(led.speed)) == ([[30.0, 40.0], [1.0, 2.0], [3.0, 4.0]], 0)
    flagged = seaglider._deployment(netcdf(**given, **ways, DEAD_RECKONING=(own, [0.0, 1.0], {})))
    assert (flagged.reckoned.t.tolist(), flagged.reckoned.latitude.tolist()) == ([40.0], [48.3])
    assert (flagged.reckoned.longitude.tolist(), flagged.ways[0].size, len(flagged.speed)) == ([-123.3], 0, 0)


def test_displacements_are_summed_from_each_fix_to_the_next():
    """In any order, against a plain loop; what comes before the first fix leads from nowhere."""
    rng = np.random.default_rng(2)
    t, steps = np.arange(0.0, 100.0, 7.0), rng.normal(0.0, 100.0, (2, 15))
    good = fixes(np.array([10.0, 49.0]), np.array([48.0, 48.2]), np.array([-123.0, -123.3]))
    order = rng.permutation(15)
    found = seaglider.summed(good, t[order], *steps[:, order])
    place, expected = None, {}
    for now, step in zip(t, steps.T, strict=True):
        for number, fixed in enumerate(good.t):
            if fixed <= now and (place is None or place[0] < number):
                place = [number, np.zeros(2)]
                at_fix = fixed == now
        if place is not None:
            place[1] = place[1] if at_fix and not place[1].any() else place[1] + step
            at_fix = False
            expected[now] = (place[0], place[1])
    assert found.t.tolist() == list(expected)
    for lat, lon, (number, way) in zip(found.latitude, found.longitude, expected.values(), strict=True):
        assert displacement(good.latitude[number], good.longitude[number], lat, lon) == pytest.approx(way, abs=0.5)


def test_a_trajectory_s_positions_are_those_that_its_flag_does_not_call_bad():
    """Heights are turned into depths, and all is in SI."""
    own = ("n",)
    file = netcdf(TIME=(own, [0.0, 1.0, 2.0], SINCE), LAT=(own, [48.0, 48.1, 48.2], {"units": "degrees_north"}), LAT_QC=(own, [1.0, 4.0, 0.0], {}),
                  LON=(own, [-123.0, -123.1, -123.2], {}), Z=(own, [-100.0, -200.0, -300.0], {"units": "cm", "positive": "up"}),
                  SPEED=(own, [50.0, 51.0, 52.0], {"units": "cm/s"}))  # fmt: skip
    store = ColumnStore()
    trajectory._add(store, file, {"lat": "LAT", "lon": "LON", "depth": "Z", "speed": "SPEED", "pitch": None})
    np.testing.assert_array_equal(store["lat"], [48.0, NAN, 48.2])
    assert (store["depth"].tolist(), store["lon"].tolist()) == ([1.0, 2.0, 3.0], [-123.0, -123.1, -123.2])
    assert store["speed"] == pytest.approx([0.5, 0.51, 0.52])


# --- Slocum, SeaExplorer, MOOS, Iver ------------------------------------------------------------------------------------


def test_qualities_of_a_slocum_s_fixes_are_those_of_their_moment():
    """The variation is positive west; `m_gps_status` is 0 of a good fix; nothing is told where nothing is logged."""
    store = ChannelStore()
    t = np.array([1.0, 2.0, 3.0])
    store.add("m_gps_lat", t, np.array([48.0, 48.1, 48.2]))
    store.add("m_gps_lon", t, np.array([-123.0, -123.1, -123.2]))
    store.add("m_gps_status", t[:2], np.array([0.0, 2.0]))
    store.add("m_gps_uncertainty", t[1:], np.array([5.0, 6.0]))
    store.add("m_gps_num_satellites", t[[0, 2]], np.array([7.0, 8.0]))
    found = slocum._fixes(store)
    assert (found.latitude.tolist(), found.longitude.tolist()) == ([48.0, 48.1, 48.2], [-123.0, -123.1, -123.2])
    np.testing.assert_array_equal(found.valid, [1.0, 0.0, NAN])
    np.testing.assert_array_equal(found.accuracy, [NAN, 5.0, 6.0])
    np.testing.assert_array_equal(found.satellites, [7.0, NAN, 8.0])


def test_a_slocum_s_mission_began_anew_where_its_start_moves_by_more_than_a_minute():
    store = ChannelStore()
    store.add("m_present_secs_into_mission", 1e9 + 100.0 * np.arange(5), np.array([500.0, 600.0, 641.0, 20.0, 120.0]))
    assert [(each.t, each.at_surface_too) for each in slocum._restarts(store)] == [(1e9 + 300.0, False)]


def test_columns_of_a_seaexplorer(tmp_path):
    rows = ["Timestamp;NavState;Heading;Declination;Pitch;Depth;Lat;Lon;DeadReckoning"]
    for k, (state, reckoned, minute) in enumerate(((116, 0, 0.0), (110, 1, 1.0), (100, 1, 2.0), (116, 0, 3.0))):
        rows.append(
            f"14/11/2023 22:13:2{k};{state};{100 + k}.5;-{2 + k};{10 - k};{5 * k};48{30 + minute:06.3f};-123{15 - minute:06.3f};{reckoned}"
        )
    (tmp_path / "sea001.1.gli.sub.1").write_text("\n".join(rows) + "\n")
    found, t = track_of("seaexplorer", tmp_path / "sea001.1.gli.sub.1"), 1.7e9 + np.arange(4)
    for name, values in (("heading", 100.5 + np.arange(4)), ("declination", -2.0 - np.arange(4)), ("pitch", 10.0 - np.arange(4)),
                         ("depth", 5.0 * np.arange(4)), ("at_surface", [1.0, 0.0, 0.0, 1.0])):  # fmt: skip
        assert values_at(getattr(found, name), t) == pytest.approx(values)
    assert (found.fixes.t.tolist(), found.reckoned.t.tolist()) == (t[[0, 3]].tolist(), t[1:3].tolist())
    assert found.reckoned.latitude == pytest.approx([48.0 + 31.0 / 60.0, 48.0 + 32.0 / 60.0])
    assert found.reckoned.longitude == pytest.approx([-123.0 - 14.0 / 60.0, -123.0 - 13.0 / 60.0])
    assert found.heading_from == "magnetic"


def test_fixes_of_a_seaexplorer_are_new_positions_and_the_first_after_dead_reckoning(tmp_path):
    """A log that begins under way repeats a fix of before; one taken just where the reckoning ended is one."""
    rows = ["Timestamp;NavState;Heading;Depth;Lat;Lon;DeadReckoning"]
    for k, (state, reckoned, minute) in enumerate(
        ((117, 0, 0), (116, 0, 1), (110, 1, 2), (116, 0, 2), (116, 0, 2), (116, 0, 3))
    ):
        rows.append(f"14/11/2023 22:13:2{k};{state};100;{5 * reckoned};483{minute}.000;-12315.000;{reckoned}")
    (tmp_path / "sea001.1.gli.sub.1").write_text("\n".join(rows) + "\n")
    found = track_of("seaexplorer", tmp_path / "sea001.1.gli.sub.1")
    assert (found.fixes.t - 1.7e9).tolist() == [1.0, 3.0, 5.0]


def test_variables_of_moos_and_its_node_report(tmp_path):
    """NAV_PITCH is in radians, NAV_HEADING in degrees from true north; the report stands for what is not logged itself."""
    lines = ["%% LOG FILE:  ./a.alog", "%% FILE OPENED ON  Tue Nov 14 22:13:20 2023", "%% LOGSTART  1700000000.0"]
    for k in range(3):
        values = {"GPS_LATITUDE": 48.0 + k, "GPS_LONGITUDE": -123.0 - k, "GPS_HDOP": 1.0 + k, "GPS_SATS": 7 + k, "NAV_PITCH": 0.1 * k,
                  "NAV_LAT": 48.5 + k, "NAV_LONG": -123.5 - k}  # fmt: skip
        lines += [f"{k}.5 {name} app {value}" for name, value in values.items()]
        lines.append(f"{k}.7 NODE_REPORT_LOCAL app NAME=a,X=1,SPD={1.0 + k},HDG={10 + k},DEP={2 + k},LAT=1,LON=2")
    (tmp_path / "a.alog").write_text("\n".join(lines) + "\n")
    found, t = track_of("moos", tmp_path / "a.alog"), 1.7e9 + np.arange(3) + 0.5
    assert values_at(found.pitch, t) == pytest.approx(np.degrees([0.0, 0.1, 0.2]))
    for name, values in (("speed", [1.0, 2.0, 3.0]), ("heading", [10.0, 11.0, 12.0]), ("depth", [2.0, 3.0, 4.0])):
        assert values_at(getattr(found, name), t + 0.2) == pytest.approx(values)
    assert (found.fixes.latitude.tolist(), found.fixes.longitude.tolist()) == (
        [48.0, 49.0, 50.0],
        [-123.0, -124.0, -125.0],
    )
    assert (found.fixes.hdop.tolist(), found.fixes.satellites.tolist()) == ([1.0, 2.0, 3.0], [7.0, 8.0, 9.0])
    assert found.reckoned.latitude.tolist() == [48.5, 49.5, 50.5]
    assert (found.heading_from, found.planned, found.breaks) == ("true", None, ())


def test_columns_of_an_iver(tmp_path):
    rows = [
        "Latitude;Longitude;Time;Date;Number of Sats;HDOP;C True Heading;Pitch Angle;DFS Depth (m);Vehicle Speed (kn)"
    ]
    rows += [
        f"48.{k};-123.{k};22:13:2{k};11/14/2023;{7 + k};{1.1 + k:.1f};{100 + k};{-3 * k};{2 * k};{1 + k}"
        for k in range(3)
    ]
    path = tmp_path / "a.log"
    path.write_text("\r\n".join(rows) + "\r\n")
    found, t = track_of("iver", path), 1.7e9 + np.arange(3)
    for name, values in (("heading", [100.0, 101.0, 102.0]), ("pitch", [0.0, -3.0, -6.0]), ("depth", [0.0, 2.0, 4.0])):
        assert values_at(getattr(found, name), t) == pytest.approx(values)
    assert values_at(found.speed, t) == pytest.approx(np.arange(1.0, 4.0) * 1852.0 / 3600.0, rel=1e-6)
    assert found.heading_from == "true"
    at_fix = np.isin(t, found.fixes.t)
    assert found.fixes.hdop == pytest.approx(np.array([1.1, 2.1, 3.1])[at_fix])
    assert found.fixes.satellites == pytest.approx(np.array([7.0, 8.0, 9.0])[at_fix])
