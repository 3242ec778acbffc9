"""ArduSub logs, written here byte by byte after the formats' descriptions: no public one with surfacings was found."""

import struct
from pathlib import Path

import numpy as np
import pytest
from made_tracks import made
from test_structure import agree

from missionplan.errors import InputError
from missionplan.importers import import_logs
from missionplan.importers.readers.ardupilot import _records

pytest.importorskip("pymavlink", reason="pymavlink is not installed")
VOYAGE = made(legs=3, duration=1200.0, pause=240.0, step=20.0)
RAW = Path(__file__).parents[2].parent / "shared" / "data" / "raw" / "ardupilot"
LEAP = 18.0


def rows(voyage):
    """Times with what is known then: a fix, the vehicle's own place, depth and heading."""
    track = voyage.track
    for t in np.unique(np.concatenate([track.fixes.t, track.depth.t, track.reckoned.t])):
        k, j, i = (np.flatnonzero(part.t == t) for part in (track.fixes, track.reckoned, track.depth))
        yield (
            float(t),
            (track.fixes.latitude[k[0]], track.fixes.longitude[k[0]]) if len(k) else None,
            (track.reckoned.latitude[j[0]], track.reckoned.longitude[j[0]]) if len(j) else None,
            (track.depth.values[i[0]], track.heading.values[i[0]], track.pitch.values[i[0]]) if len(i) else None,
        )


def dataflash(path, voyage=VOYAGE, firmware="ArduSub V4.1.0", satellites=12, week_name="GWk"):
    formats = {
        128: (b"FMT", "BBnNZ", "Type,Length,Name,Format,Columns", "<BB4s16s64s"),
        129: (b"MSG", "QZ", "TimeUS,Message", "<Q64s"),
        130: (b"GPS", "QBIHBcLL", f"TimeUS,Status,GMS,{week_name},NSats,HDop,Lat,Lng", "<QBIHBhii"),
        131: (b"POS", "QLLf", "TimeUS,Lat,Lng,Alt", "<Qiif"),
        132: (b"CTUN", "Qff", "TimeUS,ThI,Alt", "<Qff"),
        133: (b"ATT", "Qccc", "TimeUS,Roll,Pitch,Yaw", "<Qhhh"),
    }

    def message(kind, *values):
        return b"\xa3\x95" + bytes([kind]) + struct.pack(formats[kind][3], *values)

    out = [message(128, kind, struct.calcsize(packed) + 3, name, form.encode(), labels.encode())
           for kind, (name, form, labels, packed) in formats.items()]  # fmt: skip
    first = float(voyage.track.depth.t[0])
    out.append(message(129, 1, firmware.encode()))
    out.append(message(130, 2, 1, 0, 1356, 0, 9999, 0, 0))  # a receiver without a fix knows no week
    for t, fix, own, state in rows(voyage):
        us = int((t - first + 5.0) * 1e6)
        if fix is not None:
            week, rest = divmod(t - 315964800.0 + LEAP, 604800.0)
            place = (round(each * 1e7) for each in fix)
            out.append(message(130, us, 3, round(rest * 1000), int(week), satellites, 100, *place))
        if own is not None:
            out.append(message(131, us, *(round(each * 1e7) for each in own), 0.0))
        if state is not None:
            out.append(message(132, us, 0.0, -state[0]))
            out.append(message(133, us, 0, round(state[2] * 100), round(state[1] * 100) - (state[1] > 300) * 36000))
    path.write_bytes(b"".join(out))
    return path


def crc(data, extra):
    value = 0xFFFF
    for byte in (*data, extra):
        low = (byte ^ value) & 0xFF
        low = (low ^ (low << 4)) & 0xFF
        value = (value >> 8) ^ (low << 8) ^ (low << 3) ^ (low >> 4)
    return struct.pack("<H", value & 0xFFFF)


def packet(t, kind, extra, system, payload):
    body = bytes([len(payload), 0, system, 1, kind]) + payload
    return struct.pack(">Q", round(t * 1e6)) + b"\xfe" + body + crc(body, extra)


def telemetry(path, voyage=VOYAGE, kind=12, systems=(1,)):
    out = []
    first = float(voyage.track.depth.t[0])
    for t, fix, own, state in rows(voyage):
        ms = int((t - first) * 1000)
        for system in systems:
            out.append(packet(t, 0, 50, system, struct.pack("<IBBBBB", 0, kind, 3, 0, 4, 3)))
            if fix is not None:
                place = (round(each * 1e7) for each in fix)
                out.append(
                    packet(t, 24, 24, system, struct.pack("<QiiiHHHHBB", 0, *place, 0, 100, 65535, 0, 0, 3, 255))
                )
            if own is not None or state is not None:
                depth = state[0] if state is not None else np.interp(t, voyage.track.depth.t, voyage.track.depth.values)
                place = own if own is not None else (0.0, 0.0)
                out.append(
                    packet(
                        t,
                        33,
                        104,
                        system,
                        struct.pack(
                            "<IiiiihhhH",
                            ms,
                            *(round(each * 1e7) for each in place),
                            0,
                            round(-1000 * depth),
                            0,
                            0,
                            0,
                            0,
                        ),
                    )
                )
            if state is not None:
                out.append(
                    packet(
                        t,
                        30,
                        39,
                        system,
                        struct.pack("<Iffffff", ms, 0.0, np.radians(state[2]), np.radians(state[1]), 0.0, 0.0, 0.0),
                    )
                )
        out.append(packet(t, 0, 50, 255, struct.pack("<IBBBBB", 0, 6, 8, 0, 4, 3)))  # the ground station
    path.write_bytes(b"".join(out))
    return path  # fmt: skip


@pytest.fixture(scope="module")
def flashed(tmp_path_factory):
    return import_logs([dataflash(tmp_path_factory.mktemp("flash") / "1.BIN")])


def test_a_dataflash_logs_legs_are_those_of_the_voyage(flashed):
    assert flashed.counted == 3
    np.testing.assert_allclose(flashed.table["t_start_s"], VOYAGE.starts, rtol=0.0, atol=0.01)
    np.testing.assert_allclose(flashed.table["heading_deg"], [0.0, 150.0, 300.0], atol=0.1)
    assert flashed.reckoning.startswith("the autopilot's own estimate")


def test_a_telemetry_log_says_the_same_and_the_ground_station_is_no_vehicle(flashed, tmp_path):
    agree(flashed, import_logs([telemetry(tmp_path / "1.tlog")]), metres=0.1, seconds=0.01)


def test_two_vehicles_in_one_telemetry_log_are_asked_for(flashed, tmp_path):
    path = telemetry(tmp_path / "2.tlog", systems=(1, 7))
    with pytest.raises(InputError, match=r"several systems: 1 .*7 .*--vehicle 1"):
        import_logs([path])
    agree(flashed, import_logs([path], vehicle="7"), metres=0.1, seconds=0.01)


def test_a_log_that_ends_within_a_message_is_read_as_far(flashed, tmp_path):
    path = dataflash(tmp_path / "cut.BIN")
    path.write_bytes(path.read_bytes()[:-7])
    agree(flashed, import_logs([path]), metres=0.1, seconds=0.01)


def test_what_does_not_dive_is_refused_as_such(tmp_path):
    with pytest.raises(InputError, match="a multicopter, which does not dive"):
        import_logs([dataflash(tmp_path / "1.BIN", firmware="ArduCopter V4.3.1")])
    with pytest.raises(InputError, match="a boat, which does not dive"):
        import_logs([telemetry(tmp_path / "1.tlog", kind=11)])


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("small.BIN", "no GPS message"),
        pytest.param("small.tlog", "no dive between", marks=pytest.mark.slow),
        ("copter-flight.tlog", "does not dive"),
    ],
)
def test_public_logs_without_dives_are_refused_with_the_right_reason(name, why):
    if not (RAW / name).exists():
        pytest.skip(f"no raw logs: {RAW / name}")
    with pytest.raises(InputError, match=why):
        import_logs([RAW / name])


def test_records_of_a_public_log_are_those_that_its_makers_library_reads():
    if not (RAW / "small.BIN").exists():
        pytest.skip(f"no raw logs: {RAW / 'small.BIN'}")
    mavutil = pytest.importorskip("pymavlink.mavutil", reason="pymavlink is not installed")
    kinds = ("CTUN", "ATT", "BARO", "XKF1", "MSG")
    log = mavutil.mavlink_connection(str(RAW / "small.BIN"))
    theirs = []
    while (message := log.recv_match(type=list(kinds))) is not None:
        theirs.append(message)
    log.close()
    ours = list(_records(RAW / "small.BIN", kinds))
    assert [kind for kind, _ in ours] == [each.get_type() for each in theirs]
    for (_, own), other in zip(ours, theirs, strict=True):
        for name, value in vars(own).items():
            assert getattr(other, name) == (value if isinstance(value, str) else pytest.approx(value, nan_ok=True))


def test_what_is_no_message_within_a_log_is_passed_over(flashed, tmp_path):
    path = dataflash(tmp_path / "noisy.BIN")
    data = path.read_bytes()
    cut = data.index(b"\xa3\x95\x83", len(data) // 2)  # before a position
    path.write_bytes(data[:cut] + b"\xa3\x95\x07\x00noise\xa3" + data[cut:])
    agree(flashed, import_logs([path]), metres=0.1, seconds=0.01)


def test_messages_that_lack_a_field_are_named(tmp_path):
    with pytest.raises(InputError, match=r"passed over: .*'GWk'"):
        import_logs([dataflash(tmp_path / "old.BIN", week_name="Week")])
