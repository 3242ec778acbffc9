"""Logs of messages of one voyage in many writings: order, names, types, frames, byte order, two vehicles mixed."""

import gzip
import re
import struct

import numpy as np
import pytest
from made_tracks import made
from test_structure import agree, alog

from missionplan.errors import InputError
from missionplan.importers import import_logs
from missionplan.importers import importer as stores
from missionplan.importers.geodesy import displacement

STEP = 40.0
VOYAGE = made(legs=4, duration=1200.0, pause=240.0, step=STEP)
ELSEWHERE = made(legs=4, duration=1200.0, pause=240.0, step=STEP, headings=[90.0, 80.0, 70.0, 60.0])


# --- IMC --------------------------------------------------------------------------------------------------------------
pytestmark = pytest.mark.filterwarnings("ignore::DeprecationWarning")


def imc_messages(voyage=VOYAGE, source=26, name=None, north=0.0, with_fixes=True):
    imcpy = pytest.importorskip("imcpy", reason="imcpy is not installed")
    track, found = voyage.track, []
    if name is not None:
        announce = imcpy.Announce()
        announce.sys_name, announce.timestamp = name, float(track.fixes.t[0])
        found.append(announce)
    for t, lat, lon in zip(track.fixes.t, track.fixes.latitude + north, track.fixes.longitude, strict=True):
        fix = imcpy.GpsFix()
        fix.timestamp, fix.lat, fix.lon, fix.hacc, fix.satellites = t, np.radians(lat), np.radians(lon), 3.0, 9
        fix.validity = 4 | 32
        found += [fix] if with_fixes else []
    for t, lat, lon in zip(track.reckoned.t, track.reckoned.latitude + north, track.reckoned.longitude, strict=True):
        state = imcpy.EstimatedState()
        state.timestamp, state.lat, state.lon = t, np.radians(lat), np.radians(lon)
        state.depth, state.psi = float(track.depth.at(t)), np.radians(float(track.heading.at(t)))
        found.append(state)
    for each in found:
        each.src = source
    return sorted(found, key=lambda each: each.timestamp)


def lsf(path, messages, packed=False):
    imcpy = pytest.importorskip("imcpy", reason="imcpy is not installed")
    path.parent.mkdir(parents=True, exist_ok=True)
    content = b"".join(imcpy.Packet.serialize(each) for each in messages)
    path.write_bytes(gzip.compress(content) if packed else content)
    return path


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    found = import_logs([lsf(tmp_path_factory.mktemp("plain") / "Data.lsf", imc_messages())])
    assert found.counted == 4
    np.testing.assert_allclose(found.table["t_start_s"], VOYAGE.starts, rtol=0.0, atol=0.01)
    return found


def test_messages_of_imc_in_any_order_packed_or_split(plain, tmp_path):
    messages = imc_messages()
    shuffled = [messages[k] for k in np.random.default_rng(3).permutation(len(messages))]
    agree(plain, import_logs([lsf(tmp_path / "a.lsf", shuffled)]))
    agree(plain, import_logs([lsf(tmp_path / "Data.lsf.gz", messages, packed=True)]))
    half = len(messages) // 2
    parts = [
        lsf(tmp_path / "b" / "2" / "Data.lsf", messages[:half]),
        lsf(tmp_path / "b" / "1" / "Data.lsf", messages[half:]),
    ]
    agree(plain, import_logs(parts))


def test_two_systems_of_imc_are_no_one_track(plain, tmp_path):
    own, other = imc_messages(name="lauv-one"), imc_messages(ELSEWHERE, source=30, name="lauv-two", north=0.01)
    both = sorted([*own, *other], key=lambda each: each.timestamp)
    together, apart = [lsf(tmp_path / "Data.lsf", both)], [lsf(tmp_path / "1" / "Data.lsf", own),
                                                         lsf(tmp_path / "2" / "Data.lsf", other)]  # fmt: skip
    for logs in (together, apart):
        with pytest.raises(InputError, match=r"lauv-one \(\d+ states, \d+ fixes\), lauv-two .*--vehicle lauv-one"):
            import_logs(logs)
        for name in ("lauv-one", "LAUV-ONE", "26"):
            agree(plain, import_logs(logs, vehicle=name))
        assert import_logs(logs, vehicle="lauv-two").counted == 4
        with pytest.raises(InputError, match="no system 'lauv-six'"):
            import_logs(logs, vehicle="lauv-six")


def test_states_of_others_that_come_over_the_radio_change_nothing(plain, tmp_path):
    heard = imc_messages(ELSEWHERE, source=30, name="manta", north=0.02, with_fixes=False)
    both = sorted([*imc_messages(name="lauv-one"), *heard], key=lambda each: each.timestamp)
    agree(plain, import_logs([lsf(tmp_path / "Data.lsf", both)]))


def test_big_endian_messages_of_imc_say_the_same(plain, tmp_path):
    """Fields are packed here by the description of the messages, most significant byte first."""
    imcpy = pytest.importorskip("imcpy", reason="imcpy is not installed")
    out = b""
    for each in imc_messages():
        swapped = imcpy.Packet.serialize(each)
        kind, size = struct.unpack("<HH", swapped[2:6])
        forms = {"EstimatedState": "ddf" + "f" * 17, "GpsFix": "HBHBBfddfBffffff"}
        form = forms[type(each).__name__]
        if struct.calcsize("<" + form) != size:
            pytest.skip("the library's fields are others")
        body = struct.pack(">" + form, *struct.unpack("<" + form, swapped[20:-2]))
        head = struct.pack(">HHHdHBHB", 0xFE54, kind, size, *struct.unpack("<dHBHB", swapped[6:20]))
        crc = 0
        for byte in head + body:
            crc ^= byte
            for _ in range(8):
                crc = crc >> 1 ^ (0xA001 if crc & 1 else 0)
        out += head + body + struct.pack(">H", crc)
    (tmp_path / "Data.lsf").write_bytes(out)
    agree(plain, import_logs([tmp_path / "Data.lsf"]))


# --- ROS --------------------------------------------------------------------------------------------------------------


class Bag:
    """Writes bags of either format by the rosbags library."""

    def __init__(self, path, kind="mcap"):
        pytest.importorskip("rosbags.rosbag2", reason="rosbags is not installed")
        from rosbags import rosbag1, rosbag2
        from rosbags.typesys import Stores, get_typestore

        self.is_first = kind == "bag"
        self.store = get_typestore(Stores.ROS1_NOETIC if self.is_first else Stores.ROS2_HUMBLE)
        plugins = {"mcap": rosbag2.StoragePlugin.MCAP, "db3": rosbag2.StoragePlugin.SQLITE3}
        self.writer = (rosbag1.Writer(path) if self.is_first else
                       rosbag2.Writer(path, version=9, storage_plugin=plugins[kind]))  # fmt: skip
        self.links = {}

    def __enter__(self):
        self.writer.open()
        return self

    def __exit__(self, *_):
        self.writer.close()

    def make(self, kind, *values, **named):
        return self.store.types[kind](*values, **named)

    def header(self, t, frame="map"):
        stamp = self.make("builtin_interfaces/msg/Time", sec=int(t), nanosec=round(t % 1.0 * 1e9))
        number = {"seq": 0} if self.is_first else {}
        return self.make("std_msgs/msg/Header", stamp=stamp, frame_id=frame, **number)

    def write(self, topic, kind, t, message):
        if topic not in self.links:
            self.links[topic] = self.writer.add_connection(topic, kind, typestore=self.store)
        serialize = self.store.serialize_ros1 if self.is_first else self.store.serialize_cdr
        self.writer.write(self.links[topic], int(t * 1e9), serialize(message, kind))

    def fix(self, topic, t, lat, lon):
        status = self.make("sensor_msgs/msg/NavSatStatus", status=0, service=1)
        self.write(topic, "sensor_msgs/msg/NavSatFix", t, self.make(
            "sensor_msgs/msg/NavSatFix", self.header(t, "gps"), status, latitude=lat, longitude=lon, altitude=0.0,
            position_covariance=np.diag([4.0, 4.0, 9.0]).ravel(), position_covariance_type=2))  # fmt: skip

    def pose(self, topic, t, east, north, depth, heading, ned=False, stamped=False, frame=None):
        yaw = np.radians(heading if ned else 90.0 - heading)
        place = (north, east, depth) if ned else (east, north, -depth)
        turn = self.make("geometry_msgs/msg/Quaternion", 0.0, 0.0, np.sin(yaw / 2.0), np.cos(yaw / 2.0))
        pose = self.make("geometry_msgs/msg/Pose", self.make("geometry_msgs/msg/Point", *place), turn)
        head = self.header(t, frame or ("odom_ned" if ned else "odom"))
        if stamped:
            kind = "geometry_msgs/msg/PoseStamped"
            self.write(topic, kind, t, self.make(kind, head, pose))
            return
        vector = [self.make("geometry_msgs/msg/Vector3", 0.0, 0.0, 0.0) for _ in range(2)]
        twist = self.make(
            "geometry_msgs/msg/TwistWithCovariance", self.make("geometry_msgs/msg/Twist", *vector), np.zeros(36)
        )
        with_covariance = self.make("geometry_msgs/msg/PoseWithCovariance", pose, np.zeros(36))
        kind = "nav_msgs/msg/Odometry"
        self.write(topic, kind, t, self.make(kind, head, "base", with_covariance, twist))


def fill(bag, voyage=VOYAGE, fix="/fix", odometry="/odom", within=(-np.inf, np.inf), flat=False, north=0.0, **pose):
    track = voyage.track
    inside = (track.reckoned.t >= within[0]) & (track.reckoned.t < within[1])
    t, lat, lon = track.reckoned.t[inside], track.reckoned.latitude[inside] + north, track.reckoned.longitude[inside]
    east, way = displacement(lat[0], lon[0], lat, lon)
    rows = [(k, "fix") for k in np.flatnonzero((track.fixes.t >= within[0]) & (track.fixes.t < within[1]))]
    times = [track.fixes.t[k] for k, _ in rows]
    rows += [(k, "pose") for k in range(len(t))]
    times += list(t)
    for n in np.argsort(times, kind="stable"):
        k, kind = rows[n]
        if kind == "fix":
            bag.fix(fix, track.fixes.t[k], track.fixes.latitude[k] + north, track.fixes.longitude[k])
            continue
        depth, heading = float(track.depth.at(t[k])), float(track.heading.at(t[k]))
        bag.pose(odometry, t[k], east[k], way[k], 0.0 if flat else depth, heading, **pose)
        if flat:
            bag.write("/depth", "std_msgs/msg/Float64", t[k], bag.make("std_msgs/msg/Float64", depth))


@pytest.mark.parametrize("kind", ["mcap", "db3", "bag"])
def test_bags_of_any_kind_names_types_and_frames_say_the_same(plain, tmp_path, kind):
    changes = [{}, {"stamped": True}, {"flat": True}]  # each type of message in each kind of bag
    if kind == "mcap":
        changes += [{"fix": "/gnss/raw", "odometry": "/nav/state"}, {"ned": True}, {"ned": True, "frame": "world"}]
        changes += [{"frame": "map_aligned"}, {"ned": True, "flat": True, "frame": "local-NED"}]
    for k, change in enumerate(changes):
        path = tmp_path / f"{k}.bag" if kind == "bag" else tmp_path / str(k)
        with Bag(path, kind) as bag:
            fill(bag, **change)
        found = import_logs([path])
        agree(plain, found, metres=2.0)
        np.testing.assert_allclose(found.table["heading_deg"], plain.table["heading_deg"], atol=0.2)


def test_what_a_bag_does_not_say_is_told_or_refused(plain, tmp_path):
    """Stamps an hour off the record; a depth that is none; positions in metres of a projection."""

    class Stamped(Bag):
        def header(self, t, frame="map"):
            return super().header(t + 3600.0, frame)

    class Projected(Bag):
        def pose(self, topic, t, east, north, *more, **others):
            super().pose(topic, t, east + 5e5, north + 5.3e6, *more, **others)

    with Stamped(tmp_path / "stamped") as bag:
        fill(bag, flat=True)
    found = import_logs([tmp_path / "stamped"])
    agree(plain, found, metres=2.0, seconds=3600.1)
    assert "stamps count as times, which are 3600 s after the record of their messages" in found.provenance.notices
    assert "axes are taken as east, north, up" in found.provenance.notices
    with Projected(tmp_path / "projected") as bag:
        fill(bag)
    with pytest.raises(InputError, match=r"positions are 53\d\d km from their origin: metres of a projection"):
        import_logs([tmp_path / "projected"])


def test_a_log_without_depths_says_what_a_dive_is(tmp_path):
    messages = imc_messages()
    for each in messages:
        if hasattr(each, "depth"):
            each.depth = -1.0  # none
    notices = import_logs([lsf(tmp_path / "Data.lsf", messages)]).provenance.notices
    assert "no depth is logged: a dive is what lies between fixes 60 s or more apart" in notices


def test_a_file_of_a_bag_without_its_description_is_read(plain, tmp_path):
    for kind in ("mcap", "db3"):
        with Bag(tmp_path / kind, kind) as bag:
            fill(bag)
        (tmp_path / kind / "metadata.yaml").unlink()
        agree(plain, import_logs([next((tmp_path / kind).iterdir())]), metres=2.0)


def test_bags_each_with_an_origin_of_its_own_are_one_track(plain, tmp_path):
    middle = 0.5 * (VOYAGE.ends[1] + VOYAGE.starts[2])
    for k, within in enumerate(((-np.inf, middle), (middle, np.inf))):
        with Bag(tmp_path / f"{k}.bag", "bag") as bag:
            fill(bag, within=within)
    agree(plain, import_logs([tmp_path]), metres=2.0)


def test_two_vehicles_in_one_bag_or_in_two_are_no_one_track(plain, tmp_path):
    with Bag(tmp_path / "both", "mcap") as bag:
        fill(bag, fix="/one/fix", odometry="/one/odom")
        fill(bag, ELSEWHERE, fix="/two/fix", odometry="/two/odom", north=0.01)
    for k, (voyage, name) in enumerate(((VOYAGE, "one"), (ELSEWHERE, "two"))):
        with Bag(tmp_path / f"apart-{k}.bag", "bag") as bag:
            fill(bag, voyage, fix=f"/{name}/fix", odometry=f"/{name}/odom", north=0.01 * k)
    for logs in ([tmp_path / "both"], sorted(tmp_path.glob("*.bag"))):
        with pytest.raises(InputError, match=r"several topics of gps: /one/fix, /two/fix.*--vehicle one"):
            import_logs(logs)
        agree(plain, import_logs(logs, vehicle="one"), metres=2.0)
    agree(plain, import_logs([tmp_path / "both"], names=["gps=/one/fix odometry=/one/odom"]), metres=2.0)


def test_two_vehicles_whose_topics_have_the_same_names_are_found_out(tmp_path):
    for k, voyage in enumerate((VOYAGE, ELSEWHERE)):
        with Bag(tmp_path / f"{k}.bag", "bag") as bag:
            fill(bag, voyage, north=0.01 * k)
    with pytest.raises(InputError, match="are they of two vehicles"):
        import_logs([tmp_path])


# --- MOOS -------------------------------------------------------------------------------------------------------------


def navigation_alone(path, in_metres=False):
    """A log of NAV_ variables alone, as a simulated vehicle or a gps that a filter takes in has it."""
    track = VOYAGE.track
    t = track.depth.t
    at = np.isin(t, track.fixes.t)
    lat, lon = (np.where(at, np.interp(t, track.fixes.t, getattr(track.fixes, axis)),
                         np.interp(t, track.reckoned.t, getattr(track.reckoned, axis)))
                for axis in ("latitude", "longitude"))  # fmt: skip
    east, north = displacement(48.0, -123.0, lat, lon)
    names = {"NAV_X": east, "NAV_Y": north} if in_metres else {"NAV_LAT": lat, "NAV_LONG": lon}
    lines = ["%% LOG FILE:  ./a.alog", "%% FILE OPENED ON  Tue Nov 14 22:13:20 2023", "%% LOGSTART  1700000000.0"]
    for k in range(len(t)):
        for name, values in {**names, "NAV_DEPTH": track.depth.values}.items():
            lines.append(f"{t[k] - 1.7e9:.3f} {name} pNav {values[k]:.9f}")
    path.write_text("\n".join(lines) + "\n")
    return path


def test_moos_with_positions_of_its_filter_alone(plain, tmp_path):
    found = import_logs([navigation_alone(tmp_path / "a.alog")])
    assert any("one position alone" in each for each in found.provenance.notices)
    agree(plain, found, metres=8.0, seconds=STEP + 0.1)  # the first row of a dive is taken for one at the surface
    (tmp_path / "metres").mkdir()
    path = navigation_alone(tmp_path / "metres" / "a.alog", in_metres=True)
    with pytest.raises(InputError, match="origin is not known"):
        import_logs([path])
    (tmp_path / "metres" / "targ._moos").write_text("// LatOrigin = 1\nLatOrigin = 48.0\nLongOrigin = -123.0 // here\n")
    agree(plain, import_logs([path]), metres=8.0, seconds=STEP + 0.1)


def test_fixes_of_moos_in_another_unit_are_named(tmp_path):
    text = alog(tmp_path / "a.alog").read_text()
    for name in ("GPS_LATITUDE", "GPS_LONGITUDE"):
        text = re.sub(rf"({name}  iNav  -?)(\d+)\.", r"\g<1>\g<2>00.", text)
    (tmp_path / "a.alog").write_text(text)
    with pytest.raises(InputError, match=r"no position that can be one in \d+ latitudes, such as 4800"):
        import_logs([tmp_path / "a.alog"])


def test_a_packed_log_of_moos(tmp_path):
    path = alog(tmp_path / "a.alog")
    (tmp_path / "b.alog.gz").write_bytes(gzip.compress(path.read_bytes()))
    agree(import_logs([path]), import_logs([tmp_path / "b.alog.gz"]))


def test_a_copy_of_a_log_is_read_once(tmp_path):
    path, copy = alog(tmp_path / "a.alog"), tmp_path / "copy.alog"
    copy.write_bytes(path.read_bytes())
    found = import_logs([path, copy])
    agree(import_logs([path]), found)
    assert ["the same as" in each for each in found.passed_over] == [True]
    assert len(found.sources) == 1


# --- NMEA, GPX --------------------------------------------------------------------------------------------------------


def own_table(path, voyage=VOYAGE, north=0.0):
    track = voyage.track
    lines = ["t,a,b,depth"]
    for t, lat, lon in zip(track.reckoned.t, track.reckoned.latitude + north, track.reckoned.longitude, strict=True):
        lines.append(f"{t},{lat:.8f},{lon:.8f},{float(track.depth.at(t)):.2f}")
    path.write_text("\n".join(lines) + "\n")
    return path


def nmea(path, voyage=VOYAGE, talker="GP", order=1, north=0.0, kinds=("GGA", "RMC"), start="", ahead=0.0, undated=0):
    pynmea2 = pytest.importorskip("pynmea2", reason="pynmea2 is not installed")
    lines = []
    fixes = voyage.track.fixes
    for t, lat, lon in zip(fixes.t, fixes.latitude + north, fixes.longitude, strict=True):
        moment = np.datetime64(round(t + ahead), "s").astype(object)
        angle = [np.floor(abs(x)) * 100 + abs(x) % 1 * 60 for x in (lat, lon)]
        place, clock = (f"{angle[0]:.5f}", "N", f"{angle[1]:011.5f}", "W"), f"{moment:%H%M%S}.00"
        made_of = {
            "GGA": (clock, *place, "1", "09", "0.8", "1", "M", "0", "M", "", ""),
            "RMC": (clock, "A", *place, "0.1", "90", f"{moment:%d%m%y}", "", "", "A"),
            "ZDA": (clock, f"{moment:%d}", f"{moment:%m}", f"{moment:%Y}", "00", "00"),
            "GSV": ("1", "1", "00"),
        }
        lines += [start + str(getattr(pynmea2, kind)(talker, kind, made_of[kind])) for kind in kinds
                  if kind in ("GGA", "GSV") or len(lines) >= undated][::order]  # fmt: skip
    path.write_text("\r\n".join(lines) + "\r\n")
    return path


def gpx(path, voyage=VOYAGE, order=1, north=0.0, zone="Z", namespace=True, tag="trkpt", version="1.1", every=0):
    """Write fixes as GPX by its public description (topografix.com/GPX/1/1), with nothing of the reader's library."""
    fixes, rows = voyage.track.fixes, []
    for t, lat, lon in list(zip(fixes.t, fixes.latitude + north, fixes.longitude, strict=True))[::order]:
        hours = 0 if zone == "Z" else int(zone[:3])
        moment = np.datetime64(round(t) + 3600 * hours, "s")
        rows.append(f'<{tag} lon="{lon:.8f}" lat="{lat:.8f}"><time>{moment}{zone}</time></{tag}>')
        if every and len(rows) % every == 0:
            rows.append("</trkseg><trkseg>")
    body = "".join(rows)
    body = f"<trk><trkseg>{body}</trkseg></trk>" if tag == "trkpt" else f"<rte>{body}</rte>" if tag == "rtept" else body
    space = f' xmlns="http://www.topografix.com/GPX/{version.replace(".", "/")}"' if namespace else ""
    path.write_text(f'<?xml version="1.0"?>\n<gpx version="{version}" creator="made"{space}>{body}</gpx>')
    return path


NAMES = ["time=t[epoch] dr_lat=a dr_lon=b depth=depth"]


def test_gpx_of_any_order_zone_version_and_kind_of_point_beside_a_table(plain, tmp_path):
    """Without a format named: the table beside the GPX file is read by `--map`."""
    table = own_table(tmp_path / "own.csv")
    changes = ({}, {"order": -1}, {"zone": "+02:00"}, {"zone": "-05:00"}, {"namespace": False}, {"version": "1.0"},
               {"tag": "wpt"}, {"tag": "rtept"}, {"every": 7})  # fmt: skip
    first = import_logs([table, gpx(tmp_path / "0.gpx")], format="track", names=NAMES)
    for number, change in enumerate(changes, start=1):
        agree(import_logs([table, gpx(tmp_path / f"{number}.gpx", **change)], names=NAMES), first)


def test_gpx_of_two_vehicles_is_no_track(tmp_path):
    table = own_table(tmp_path / "own.csv")
    both = [gpx(tmp_path / "a.gpx"), gpx(tmp_path / "b.gpx", north=0.5)]
    with pytest.raises(InputError, match="two vehicles"):
        import_logs([table, *both], names=NAMES)


def test_sentences_of_any_talker_order_and_kind(plain, tmp_path):
    table = own_table(tmp_path / "own.csv")
    changes = ({}, {"talker": "GN"}, {"order": -1}, {"kinds": ("RMC",)}, {"kinds": ("GGA", "ZDA")},
               {"kinds": ("ZDA", "GSV", "GGA")}, {"start": "1700000000.123 "})  # fmt: skip
    for k, change in enumerate(changes):
        path = nmea(tmp_path / f"{k}.nmea", **change)
        agree(plain, import_logs([table, path], format="track", names=NAMES))


@pytest.mark.parametrize("undated", [1, 6, 16])
def test_fixes_before_the_first_date_have_the_date_that_follows(plain, tmp_path, undated):
    """Midnight passes within them."""
    gps = nmea(tmp_path / "a.nmea", undated=undated)
    agree(plain, import_logs([own_table(tmp_path / "own.csv"), gps], format="track", names=NAMES))


@pytest.mark.parametrize("ahead", [3.0, 18.0, 60.0])
def test_a_clock_of_fixes_that_is_ahead_makes_no_leg_end_at_its_fix(tmp_path, ahead):
    """Else the position that has taken in the fix stood for the dead-reckoned one, and no leg erred."""
    table = own_table(tmp_path / "own.csv")
    plain, late = (
        import_logs([table, nmea(tmp_path / f"{shift:g}.nmea", ahead=shift)], format="track", names=NAMES)
        for shift in (0.0, ahead)
    )
    agree(plain, late, seconds=ahead + 0.1, metres=10.0)
    says = ["steps onto the fix before that is logged" in " ".join(each.provenance.notices) for each in (plain, late)]
    assert says == [False, True]


def test_a_clock_of_fixes_that_is_behind_is_told(tmp_path):
    gps = nmea(tmp_path / "a.nmea", ahead=-18.0)
    notices = import_logs([own_table(tmp_path / "own.csv"), gps], format="track", names=NAMES).provenance.notices
    assert any("that begin no dive stand in the log while the vehicle is under water" in each for each in notices)


def test_sentences_of_two_receivers_far_apart_are_found_out(tmp_path):
    table = own_table(tmp_path / "own.csv")
    one, two = nmea(tmp_path / "1.nmea"), nmea(tmp_path / "2.nmea", ELSEWHERE, north=0.02)
    with pytest.raises(InputError, match="are they of two vehicles"):
        import_logs([table, one, two], format="track", names=NAMES)


def test_fixes_without_a_date_are_named_as_such(tmp_path):
    gps, own = nmea(tmp_path / "1.nmea", kinds=("GGA",)), own_table(tmp_path / "own.csv")
    with pytest.raises(InputError, match=r"0 fixes that count[\s\S]*1\.nmea: passed over: its fixes have no date"):
        import_logs([own, gps], format="track", names=NAMES)


def test_rows_of_a_table_in_any_order_are_one_log(plain, tmp_path):
    gps = nmea(tmp_path / "1.nmea")
    lines = own_table(tmp_path / "own.csv").read_text().splitlines()
    for k, rows in enumerate((lines[:0:-1], np.random.default_rng(1).permutation(lines[1:]).tolist())):
        path = tmp_path / f"rows-{k}.csv"
        path.write_text("\n".join([lines[0], *rows]) + "\n")
        agree(plain, import_logs([path, gps], format="track", names=NAMES))


def test_readings_beyond_the_most_are_thinned_whatever_their_order(monkeypatch):
    monkeypatch.setattr(stores, "MOST", 1000)
    t = np.arange(20_000) * 0.1
    for order in (np.arange(len(t)), np.random.default_rng(8).permutation(len(t)), np.arange(len(t))[::-1]):
        samples, channels, columns = stores.Samples(("t", "x")), stores.ChannelStore(), stores.ColumnStore()
        for k in order:
            samples.add(t[k], 3.0 * t[k])
        for part in np.array_split(order, 7):
            channels.add("x", t[part], 3.0 * t[part])
            columns.add({"t": t[part], "depth": 3.0 * t[part]})
        kept = {"samples": np.sort(samples["t"]), "channels": channels.series("x").t, "columns": columns["t"]}
        for name, held in kept.items():
            assert 200 <= len(held) <= 1000, name
            assert np.diff(held).max() < 40.0, name  # no long time of the 2000 s is lost
        np.testing.assert_allclose(channels.series("x").values, 3.0 * kept["channels"])
