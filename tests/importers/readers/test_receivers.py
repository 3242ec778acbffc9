"""Fixes of receivers, NMEA 0183 and GPX, sentence by sentence: sides of the Earth, dates, midnight, what is no fix."""

import gzip
from datetime import UTC, datetime
from functools import reduce

import numpy as np
import pytest

from missionplan.importers.importer import Samples
from missionplan.importers.readers.receivers import FIX_COLUMNS, add_gpx, add_nmea, is_gpx, is_nmea

NOON = datetime(2023, 11, 14, 12, 0, 0, tzinfo=UTC).timestamp()


def read(path, *sentences):
    """Fixes that sentences without their sums say, by column."""
    sums = (reduce(lambda total, letter: total ^ ord(letter), each, 0) for each in sentences)
    path.write_text("".join(f"${each}*{one:02X}\r\n" for each, one in zip(sentences, sums, strict=True)))
    found = Samples(FIX_COLUMNS)
    add_nmea(path, found)
    return {name: found[name] for name in FIX_COLUMNS}


def rmc(clock="120000", place="4839.12,N,12315.0,W", status="A", day="141123"):
    return f"GPRMC,{clock},{status},{place},0.1,90,{day},,,A"


def gga(clock="120000", place="4839.12,N,12315.0,W", quality="1"):
    return f"GPGGA,{clock},{place},{quality},09,0.8,1,M,0,M,,"


@pytest.fixture
def path(tmp_path):
    pytest.importorskip("pynmea2")
    return tmp_path / "a.nmea"


@pytest.mark.parametrize(("north", "east"), [("N", "E"), ("N", "W"), ("S", "E"), ("S", "W")])
def test_a_fix_on_each_side_of_the_earth(path, north, east):
    place = f"4839.12,{north},12315.0,{east}"
    found = read(path, gga(place=place), rmc(place=place))
    assert {name: values.tolist() for name, values in found.items()} == {
        "t": [NOON],
        "lat": [pytest.approx(48.652 * (1.0 if north == "N" else -1.0))],
        "lon": [pytest.approx(123.25 * (1.0 if east == "E" else -1.0))],
        "hdop": [0.8],
        "satellites": [9.0],
        "valid": [1.0],
    }


def test_what_a_receiver_calls_no_fix_is_none(path):
    assert read(path, rmc(status="V"))["valid"].tolist() == [0.0]
    assert read(path, gga(), rmc(status="V"))["valid"].tolist() == [0.0]
    assert read(path, rmc(), gga(quality="0"))["valid"].tolist() == [0.0]
    for quality in "678":  # estimated, manual, simulated
        assert read(path, rmc(), gga(quality=quality))["valid"].tolist() == [0.0]
    for mode in "NEMS":
        assert read(path, rmc()[:-1] + mode)["valid"].tolist() == [0.0]
    assert read(path, rmc()[:-2])["valid"].tolist() == [1.0]  # of before modes
    dated = "GPZDA,120000,14,11,2023,00,00"
    assert read(path, dated, gga(quality="0"))["valid"].tolist() == [0.0]
    assert read(path, dated, gga(quality="2"))["valid"].tolist() == [1.0]
    with pytest.raises(ValueError, match="no fixes"):
        read(path, rmc(place=",,,"))
    with pytest.raises(ValueError, match="no date: sentences RMC or ZDA"):
        read(path, gga())


def test_the_day_goes_on_where_sentences_name_none(path):
    """A date holds until midnight, and a clock that goes back a little is no day."""
    found = read(path, rmc("235958"), gga("235959"), gga("000001"), gga("000000"), rmc("120000", day="161123"))
    midnight = NOON + 43200.0
    assert (found["t"] - midnight).tolist() == [-2.0, -1.0, 1.0, 0.0, 129600.0]


def test_a_damaged_sentence_is_passed_over(path):
    path.write_text("noise $GPRMC,120000,A,4839.12,N,12315.0,W,0.1,90,141123,,,A*00\n")
    with pytest.raises(ValueError, match="no fixes"):
        add_nmea(path, Samples(FIX_COLUMNS))


def test_other_talkers_and_sentences_hold_fixes_too(path):
    place, dated = "4839.12,N,12315.0,W", "GNZDA,120000,14,11,2023,00,00"
    assert read(path, dated, f"IIGLL,{place},120000,A,A")["valid"].tolist() == [1.0]
    assert read(path, dated, f"IIGLL,{place},120000,V,N")["valid"].tolist() == [0.0]
    found = read(path, dated, f"GNGNS,120000,{place},AAN,11,0.8,1,0,,")
    assert (found["lat"].tolist(), found["valid"].tolist()) == ([pytest.approx(48.652)], [1.0])
    assert read(path, dated, f"GNGNS,120000,{place},NNE,11,0.8,1,0,,")["valid"].tolist() == [0.0]


def test_sums_are_asked_for_where_a_file_has_them(path):
    found = Samples(FIX_COLUMNS)
    path.write_text(f"2026-05-01 10:20:30 ${rmc()}\n")
    add_nmea(path, found)
    assert found["t"].tolist() == [NOON]
    read(path, gga(), rmc())
    cut = f"{path.read_text()}${rmc('120001')[:-9]}\n"  # in the middle of the date
    path.write_text(cut)
    found = Samples(FIX_COLUMNS)
    add_nmea(path, found)
    assert found["t"].tolist() == [NOON]


def test_points_of_a_gpx_file_with_times(tmp_path):
    """Of its tracks; of routes and waypoints where it has none; a zone is honoured, and none is UTC."""

    def point(kind, time, more=""):
        return f'<{kind} lat="-48.5" lon="123.25">{f"<time>{time}</time>" if time else ""}{more}</{kind}>'

    def places(body):
        (tmp_path / "a.gpx").write_text(
            f'<gpx version="1.1" creator="x" xmlns="http://www.topografix.com/GPX/1/1">{body}</gpx>'
        )
        found = Samples(FIX_COLUMNS)
        add_gpx(tmp_path / "a.gpx", found)
        return {name: found[name].tolist() for name in FIX_COLUMNS}

    more = "<sat>7</sat><hdop>1.5</hdop>"
    times = ("2023-11-14T12:00:00Z", "2023-11-14T13:00:01+01:00", "2023-11-14T12:00:02", "")
    track = f"<trk><trkseg>{''.join(point('trkpt', each, more) for each in times)}</trkseg></trk>"
    aside = point("wpt", "2023-11-14T12:00:09Z")
    found = places(aside + track)
    assert found["t"] == [NOON, NOON + 1.0, NOON + 2.0]
    assert (found["lat"], found["lon"]) == ([-48.5] * 3, [123.25] * 3)
    assert (found["hdop"], found["satellites"]) == ([1.5] * 3, [7.0] * 3)
    assert np.isnan(found["valid"]).all()
    found = places(f"{aside}<rte>{point('rtept', times[0])}</rte>")
    assert found["t"] == [NOON + 9.0, NOON]
    assert np.isnan(found["hdop"]).all()
    places(
        f"<trk><trkseg>{''.join(point('trkpt', times[0], f'<fix>{each}</fix>') for each in ('none', '3d'))}</trkseg></trk>"
    )
    found = Samples(FIX_COLUMNS)
    for encoding in ("latin-1", "utf-16"):
        written = f'<?xml version="1.0" encoding="{encoding}"?>{(tmp_path / "a.gpx").read_text()}<!-- Ø -->'
        (tmp_path / "b.gpx.gz").write_bytes(gzip.compress(written.encode(encoding)))
        add_gpx(tmp_path / "b.gpx.gz", found)
    assert found["valid"].tolist() == [0.0, 1.0] * 2


def test_files_of_fixes_are_recognised(tmp_path):
    assert is_gpx(tmp_path / "A.GPX", b"")
    assert is_gpx(tmp_path / "a.xml", b"<?xml?><gpx>")
    assert is_nmea(tmp_path / "a.NME", b"")
    assert is_nmea(tmp_path / "a.txt", b"$GPRMC,1")
    assert is_nmea(tmp_path / "a.txt", b"\xef\xbb\xbf$GNGGA,1")
    assert is_nmea(tmp_path / "a.txt", b"started\n2026-05-01T10:20:30Z $IIGLL,1")
    assert not is_nmea(tmp_path / "a.txt", b"x" * 50 + b"$GPRMC,1")
    assert not is_nmea(tmp_path / "a.txt", b"$PUBX,1")
    assert not is_gpx(tmp_path / "a.xml", b"<kml>")
