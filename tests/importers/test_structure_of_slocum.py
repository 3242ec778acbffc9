"""Slocum files of one voyage, packed here bit by bit after the format's description, in many writings.

Format: Teledyne Webb Research, dinkum binary data: a header of text, the list of sensors or its name, known bytes for the
byte order, then cycles: two bits a sensor say whether it is not updated, the same, or new.
"""

import os
import struct
import subprocess
import sys
from importlib.util import find_spec

import numpy as np
import pytest
from made_tracks import made
from test_structure import agree

from missionplan.errors import InputError
from missionplan.importers import import_logs
from missionplan.importers.importer import ReadOptions, SourceLog, known_importers

pytestmark = pytest.mark.skipif(not find_spec("dbdreader"), reason="dbdreader is not installed")
VOYAGE = made(legs=4, duration=2400.0, pause=600.0, step=20.0)
FLIGHT = {"m_present_time": 8, "m_gps_lat": 8, "m_gps_lon": 8, "m_gps_status": 1, "m_lat": 8, "m_lon": 8, "m_gps_mag_var": 4, "m_depth": 4,
          "m_heading": 4, "m_pitch": 4, "m_present_secs_into_mission": 4, "x_other": 2}  # fmt: skip


def ddmm(value):
    return np.sign(value) * (np.floor(abs(value)) * 100 + abs(value) % 1 * 60)


def cycles(voyage=VOYAGE, old_fix=False):
    """Cycles of the vehicle's computer: what is new in each; with the old fix set again on surfacing where asked."""
    track, last = voyage.track, {}
    times = np.unique(np.concatenate([track.fixes.t, track.depth.t, track.reckoned.t]))
    for t in times:
        row = {"m_present_time": t, "m_gps_mag_var": 0.0, "m_present_secs_into_mission": t - times[0]}
        k, j, i = (np.flatnonzero(part.t == t) for part in (track.fixes, track.reckoned, track.depth))
        if len(k):
            fix = {"m_gps_lat": ddmm(track.fixes.latitude[k[0]]), "m_gps_lon": ddmm(track.fixes.longitude[k[0]])}
            last = {**fix, "m_gps_status": 0}
            row |= last
        if len(j):
            row |= {"m_lat": ddmm(track.reckoned.latitude[j[0]]), "m_lon": ddmm(track.reckoned.longitude[j[0]])}
        if len(i):
            row |= {"m_depth": track.depth.values[i[0]], "m_heading": np.radians(track.heading.values[i[0]]),
                    "m_pitch": np.radians(track.pitch.values[i[0]])}  # fmt: skip
        yield row
        if old_fix and len(i) and np.isin(round(t + 20.0, 3), np.round(voyage.ends, 3)):
            yield {"m_present_time": t + 12.0, "m_depth": 0.0, **last}


def dbd(path, rows, *, sensors=FLIGHT, factored=None, big=False, name="unit-2023-318-0-0", order=1, in_header=True):
    """Write a file; its sensor list goes to `factored` (a .cac) where it is given."""
    path.parent.mkdir(parents=True, exist_ok=True)
    names = list(sensors)[::order]
    lines = "".join(f"s: T {k:4d} {k:4d} {sensors[each]} {each} unit\n" for k, each in enumerate(names))
    mark = ">" if big else "<"
    form = {1: "b", 2: "h", 4: "f", 8: "d"}
    state_bytes = -(-len(names) // 4)
    head = {
        "dbd_label": "DBD(dinkum_binary_data)file", "encoding_ver": 5, "num_ascii_tags": 14, "all_sensors": "F",
        "the8x3_filename": "01600000", "full_filename": name, "filename_extension": path.suffix[1:],
        "mission_name": "TEST.MI", "fileopen_time": "Tue_Nov_14_22:13:20_2023", "total_num_sensors": len(names),
        "sensors_per_cycle": len(names), "state_bytes_per_cycle": state_bytes, "sensor_list_crc": "ABCD1234",
        "sensor_list_factored": int(not in_header),
    }  # fmt: skip
    out = "".join(f"{key}:    {value}\n" for key, value in head.items()).encode()
    out += lines.encode() if in_header else b""
    if factored is not None:
        factored.write_text(lines)
    out += b"sa" + struct.pack(f"{mark}hfd", 0x1234, 123.456, 123456789.12345)
    before = {}
    rows = list(rows)
    for row in (rows[0], *rows):  # the first cycle has what was known before the file was begun
        states, values = 0, b""
        for each in names:
            state = 0 if each not in row else 1 if before.get(each) == row[each] and each != "m_present_time" else 2
            states = states << 2 | state
            if state == 2:
                kind = form[sensors[each]]
                values += struct.pack(mark + kind, round(row[each]) if kind in "bh" else row[each])
        before |= row
        states <<= 2 * (4 * state_bytes - len(names))
        out += b"d" + states.to_bytes(state_bytes, "big") + values
    path.write_bytes(out + b"X")
    return path


def packed(data):
    """Pack blocks of 32 kB as the vehicle does: the size of each, then LZ4."""
    block = pytest.importorskip("lz4.block")
    out = b""
    for k in range(0, len(data), 32768):
        part = block.compress(data[k : k + 32768], store_size=False)
        out += struct.pack(">H", len(part)) + part
    return out


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    found = import_logs([dbd(tmp_path_factory.mktemp("slocum") / "unit-2023-318-0-0.dbd", cycles())])
    assert found.counted == 4
    np.testing.assert_allclose(found.table["t_start_s"], VOYAGE.starts, rtol=0.0, atol=0.01)
    return found


def test_sensors_in_any_order_and_bytes_in_either(plain, tmp_path):
    for k, change in enumerate(({"order": -1}, {"big": True})):
        agree(plain, import_logs([dbd(tmp_path / f"{k}.sbd", cycles(), **change)]))
    agree(plain, import_logs([dbd(tmp_path / "UPPER.MBD", cycles())]))


def test_lists_of_sensors_beside_the_files_in_another_file_or_packed(plain, tmp_path):
    rows = list(cycles())
    half = len(rows) // 2
    path = dbd(tmp_path / "a" / "x.sbd", rows, in_header=False, factored=tmp_path / "list.cac")
    with pytest.raises(InputError, match="--cache"):
        import_logs([path])
    (tmp_path / "a" / "ABCD1234.CAC").write_bytes((tmp_path / "list.cac").read_bytes())
    agree(plain, import_logs([tmp_path / "a"]))
    (tmp_path / "a" / "ABCD1234.CAC").unlink()
    (tmp_path / "a" / "abcd1234.ccc").write_bytes(packed((tmp_path / "list.cac").read_bytes()))
    agree(plain, import_logs([tmp_path / "a"]))
    later = [dbd(tmp_path / "b" / "1.sbd", rows[:half], in_header=False), dbd(tmp_path / "b" / "2.sbd", rows[half:])]
    agree(plain, import_logs(later))  # the second file holds the list of the first


def test_packed_files(plain, tmp_path):
    (tmp_path / "unit-2023-318-0-0.scd").write_bytes(packed(dbd(tmp_path / "a.sbd", cycles()).read_bytes()))
    (tmp_path / "a.sbd").unlink()
    agree(plain, import_logs([tmp_path]))


def test_depth_from_the_science_computer(plain, tmp_path):
    without = {name: size for name, size in FLIGHT.items() if name != "m_depth"}
    rows = list(cycles())
    dbd(tmp_path / "1.dbd", rows, sensors=without)
    science = [{"sci_m_present_time": row["m_present_time"] + 0.3, "sci_water_pressure": row["m_depth"] / 10.0}
               for row in rows if "m_depth" in row]  # fmt: skip
    dbd(tmp_path / "1.ebd", science, sensors={"sci_m_present_time": 8, "sci_water_pressure": 4})
    agree(plain, import_logs([tmp_path]), seconds=1.0)


def test_a_vehicle_without_positions_of_its_own_is_reckoned_aloud(plain, tmp_path):
    without = {name: size for name, size in FLIGHT.items() if name not in ("m_lat", "m_lon")}
    found = import_logs([dbd(tmp_path / "1.sbd", cycles(), sensors=without)])
    assert repr(found).splitlines()[1].startswith("The logs hold no dead reckoning: it was made from heading")
    agree(plain, found, metres=60.0)


def test_the_old_fix_set_again_on_surfacing_is_no_fix(plain, tmp_path):
    found = import_logs([dbd(tmp_path / "1.sbd", cycles(old_fix=True))])
    agree(plain, found)
    assert found.rejected_reasons == {"the fix before the dive, logged again": 4}


def test_a_fix_that_the_receiver_calls_none_is_none(plain, tmp_path):
    """`m_gps_status` is 0 of a good fix; the others lie 20 km away."""
    rows = [{**row, "m_gps_status": 1, "m_gps_lat": row["m_gps_lat"] + 10.0, "m_present_time": row["m_present_time"] + 7.0}
            for row in cycles() if "m_gps_lat" in row]  # fmt: skip
    both = sorted([*cycles(), *rows], key=lambda row: row["m_present_time"])
    found = import_logs([dbd(tmp_path / "1.sbd", both)])
    agree(plain, found)
    assert sum(found.rejected_reasons.values()) == len(rows)


def test_the_variation_of_the_compass_is_positive_west(tmp_path):
    """A compass 0.2 rad off to the east of what it should be, where the variation is 0.2 rad west, leads the same way."""
    without = {name: size for name, size in FLIGHT.items() if name not in ("m_lat", "m_lon")}
    turned = [{**row, "m_gps_mag_var": 0.2} | ({"m_heading": row["m_heading"] + 0.2} if "m_heading" in row else {})
              for row in cycles()]  # fmt: skip
    true = import_logs([dbd(tmp_path / "1" / "a.sbd", cycles(), sensors=without)])
    agree(true, import_logs([dbd(tmp_path / "2" / "a.sbd", turned, sensors=without)]), metres=1.0)


def test_its_estimate_of_the_current_is_east_along_x_and_north_along_y(tmp_path):
    rows = [{**row, "m_water_vx": 0.25, "m_water_vy": -0.5} for row in cycles()]
    path = dbd(tmp_path / "1.sbd", rows, sensors=FLIGHT | {"m_water_vx": 4, "m_water_vy": 4})
    track = known_importers()[0]["slocum"].read([path], ReadOptions(), SourceLog())
    assert (set(track.current_east.values), set(track.current_north.values)) == ({0.25}, {-0.5})


@pytest.mark.parametrize(("away", "left"), [(1200.0, 3), (-200.0, 4), (20.0, 4)])
def test_a_mission_begun_again_under_water_spoils_its_leg_and_at_the_surface_none(away, left, tmp_path):
    again = VOYAGE.starts[2] + away
    rows = [{**row, "m_present_secs_into_mission": row["m_present_time"] - (again if row["m_present_time"] >= again else VOYAGE.starts[0])}
            for row in cycles() if row["m_present_time"] >= VOYAGE.starts[0] - 300.0]  # fmt: skip
    found = import_logs([dbd(tmp_path / "1.sbd", rows)])
    assert found.counted == left
    assert found.reasons == ({"a new mission was started": 1} if left < 4 else {})


def test_two_gliders_are_asked_for(plain, tmp_path):
    dbd(tmp_path / "1.sbd", cycles())
    dbd(tmp_path / "2.sbd", list(cycles())[:-1], name="other-2023-318-0-0")
    with pytest.raises(InputError, match=r"other \(1 file\), unit \(1 file\)"):
        import_logs([tmp_path])
    agree(plain, import_logs([tmp_path], vehicle="unit"))
    for k in (1, 2):  # packed, under the names of the card
        (tmp_path / f"0160000{k}.scd").write_bytes(packed((tmp_path / f"{k}.sbd").read_bytes()))
        (tmp_path / f"{k}.sbd").unlink()
    with pytest.raises(InputError, match=r"other \(1 file\), unit \(1 file\)"):
        import_logs([tmp_path])


@pytest.mark.parametrize(("home", "says"), [("here", None), ("file/below", "a folder at home, which cannot be made")])
def test_the_library_makes_its_folder_at_home_or_says_why_not(tmp_path, home, says):
    """Found on a fresh machine: two processes that import it at once made the same folder."""
    (tmp_path / "file").write_text("")
    code = "from missionplan.importers.readers.slocum import _library; _library('dbdreader')"
    runs = [
        subprocess.Popen(
            [sys.executable, "-c", code], env={**os.environ, "HOME": str(tmp_path / home)}, stderr=subprocess.PIPE
        )
        for _ in range(2)
    ]
    for run in runs:
        words = run.communicate()[1].decode()
        assert says in words if says else run.returncode == 0 and not words
