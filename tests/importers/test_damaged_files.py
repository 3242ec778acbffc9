"""Whatever a file holds: it is read, passed over, or refused in words; and numbers are read back as they were written."""

import contextlib
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from missionplan.errors import InputError
from missionplan.importers import import_logs
from missionplan.importers.mapping import angles, ddmm_to_degrees, degrees_of, times

MADE = (Path(__file__).parent / "made.gli").read_bytes()
MOOS = b"%% LOGSTART 1700000000\n" + b"".join(
    f"{k} {name} app {value}\n".encode()
    for k in range(0, 4000, 20)
    for name, value in (
        ("GPS_LATITUDE", 48.0),
        ("GPS_LONGITUDE", -123.0),
        ("NAV_DEPTH", k % 400 / 10.0),
        ("NAV_X", k / 10.0),
    )
)
STARTS = {
    "one.gli": ("seaexplorer", MADE),
    "one.gli.gz": ("seaexplorer", b"\x1f\x8b\x08\x00"),
    "one.sbd": ("slocum", b"dbd_label:    DBD(dinkum_binary_data)file\n"),
    "p1230001.nc": ("seaglider", b"\x89HDF\r\n\x1a\n"),
    "one.nc": ("og1", b"CDF\x01"),
    "one.lsf": ("imc", b"\x54\xfe\x5e\x01\x10\x00"),
    "one.alog": ("moos", MOOS),
    "one.bag": ("rosbag", b"#ROSBAG V2.0\n"),
    "one.gpx": ("track", b"<?xml version='1.0'?><gpx><trk>"),
    "one.nmea": ("track", b"$GPRMC,081836,A,3751.65,S,14507.36,E,000.0,360.0,130998,011.3,E*62\n"),
}
NEEDED = {"slocum": "dbdreader", "seaglider": "netCDF4", "og1": "netCDF4", "imc": "imcpy", "rosbag": "rosbags"}


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("name", STARTS)
@settings(max_examples=12, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.floats(0.0, 1.0), st.binary(max_size=300))
def test_a_damaged_file_is_never_a_traceback(tmp_path, name, share, junk):
    format_name, start = STARTS[name]
    if format_name in NEEDED:
        pytest.importorskip(NEEDED[format_name])
    path = tmp_path / name
    path.write_bytes(start[: int(share * len(start))] + junk)
    with contextlib.suppress(InputError):
        import_logs([path], format=format_name)


@given(st.floats(-90.0, 90.0))
def test_degrees_and_minutes_are_read_back(value):
    size, sign = abs(value), np.sign(value) or 1.0
    minutes = 60.0 * (size - np.floor(size))
    assert ddmm_to_degrees(np.array([sign * (100.0 * np.floor(size) + minutes)]))[0] == pytest.approx(value, abs=1e-9)
    letter = "N" if sign > 0 else "S"
    assert degrees_of(f"{int(size)} {minutes:.9f} {letter}") == pytest.approx(value, abs=1e-9)
    assert angles(pd.Series([f"{value:.9f}".replace(".", ",")]), "deg")[0] == pytest.approx(value, abs=1e-8)


@given(st.integers(0, 4_000_000_000_000), st.sampled_from(["iso", "%d/%m/%Y %H:%M:%S.%f", "epoch", "ms", "days"]))
def test_times_are_read_back(milliseconds, unit):
    t = milliseconds / 1000.0
    moment = datetime.fromtimestamp(t, UTC)
    words = {"iso": moment.isoformat(), "epoch": repr(t), "ms": str(milliseconds), "days": repr(t / 86400.0)}
    word = words.get(unit) or moment.strftime(unit)
    assert times(pd.Series([word]), unit)[0] == pytest.approx(t, abs=2e-3)
