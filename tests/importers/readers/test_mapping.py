"""What cells of a log say in each way of writing: angles, times, numbers with units, names with theirs."""

from datetime import UTC, datetime, timedelta

import numpy as np
import pandas as pd
import pytest

from missionplan.errors import InputError
from missionplan.importers.geodesy import displacement, moved
from missionplan.importers.mapping import (
    MappedName,
    angles,
    flags,
    mapped,
    plain_numbers,
    quantities,
    read_mapping,
    times,
)

MOMENT = datetime(2023, 11, 14, 22, 13, 20, 500_000, tzinfo=UTC)
SECONDS = MOMENT.timestamp()


def series(*words):
    return pd.Series(words, dtype=str)


@pytest.mark.parametrize(
    ("word", "unit", "degrees"),
    [
        *[("48.652", "deg", 48.652), (" -123,25 ", "deg", -123.25), ("0.848", "rad", np.degrees(0.848))],
        *[
            ("4839.12", "ddmm", 48.652),
            ("-12315.0", "DDMM.MMM", -123.25),
            ("12315.0W", "dm", -123.25),
            ("-030.0", "ddmm", -0.5),
        ],
        *[("48 39.12 N", "deg", 48.652), ("48°39.12'S", "deg", -48.652), ("W 123 15 36", "deg", -123.26)],
        *[("123°28'30\"W", "deg", -123.475), ("E 7", "deg", 7.0), ("-7 W", "deg", -7.0), ("-48 39.12", "deg", -48.652)],
        *[("48-39.12S", "deg", -48.652), ("-12315.0W", "ddmm", -123.25)],
        *[("-0 30", "deg", -0.5), ("4839.12 s", "ddmm", -48.652), ("0012.0 e", "ddmm", 0.2)],
    ],
)
def test_degrees_in_every_writing(word, unit, degrees):
    assert angles(series("", word, "none"), unit) == pytest.approx([np.nan, degrees, np.nan], abs=1e-9, nan_ok=True)


@pytest.mark.parametrize(("word", "unit"), [("7 O", "deg"), ("O 7°", "deg"), ("00730.0 O", "ddmm")])
def test_a_direction_that_is_east_in_one_tongue_and_west_in_another_is_refused(word, unit):
    with pytest.raises(InputError, match="is O east"):
        angles(series(word), unit)


def test_flags_of_fixes_in_words_and_numbers():
    assert flags(series("A", "V", "true", "No", "1", "0", "", "2")).tolist()[:6] == [1.0, 0.0] * 3
    assert np.isnan(flags(series("", "A"))[0])
    with pytest.raises(InputError, match="given '3d', expected numbers, A or V"):
        flags(series("A", "3D"))


def test_numbers_that_stand_for_none():
    words = series("-999", "-9999.0", "9999", "-999.9", "1e20", "999", "-99", "0")
    assert plain_numbers(words) == pytest.approx([np.nan] * 5 + [999.0, -99.0, 0.0], nan_ok=True)


@pytest.mark.parametrize(
    ("word", "unit"),
    [
        *[(MOMENT.isoformat(), "iso"), ("2023-11-15T00:13:20.5+02:00", "utc"), ("2023-11-14 22:13:20.5", "")],
        *[
            (f"{SECONDS:.1f}", "epoch"),
            (f"{SECONDS:.1f}", "s"),
            (f"{SECONDS * 1e3:.0f}", "ms"),
            (f"{SECONDS * 1e6:.0f}", "us"),
        ],
        *[
            (f"{SECONDS * 1e9:.0f}", "ns"),
            (f"{SECONDS / 86400.0:.9f}", "days"),
            (f"{SECONDS / 86400.0 + 719529.0:.9f}", "matlab"),
        ],
        (f"{1.0 + (MOMENT - datetime(2023, 1, 1, tzinfo=UTC)) / timedelta(days=1):.9f}", "doy:2023"),
        *[("14.11.2023 22:13:20.5", "%d.%m.%Y %H:%M:%S"), ("11/14/2023 22:13:20.50", "%m/%d/%Y %H:%M:%S")],
    ],
)
def test_a_moment_in_every_writing(word, unit):
    assert times(series(word, "", "none"), unit) == pytest.approx([SECONDS, np.nan, np.nan], abs=1e-4, nan_ok=True)


def test_whole_seconds_stand_beside_parts_of_them_and_a_unit_that_is_none_is_refused():
    found = times(series("14.11.2023 22:13:20", "14.11.2023 22:13:20.5"), "%d.%m.%Y %H:%M:%S")
    assert found == pytest.approx([SECONDS - 0.5, SECONDS], abs=1e-6)
    for unit in ("doy", "doy:23", "weeks"):
        with pytest.raises(InputError, match="expected iso, epoch"):
            times(series("1"), unit)


@pytest.mark.parametrize(
    ("unit", "wanted", "one"),
    [
        *[
            ("m", "m", 1.0),
            ("ft", "m", 0.3048),
            ("cm", "m", 0.01),
            ("kn", "m/s", 1852.0 / 3600.0),
            ("rad", "deg", 57.29577951),
        ],
        *[("bar", "m", 10.0), ("dbar", "m", 1.0), ("Pa", "m", 1e-4), ("anything", "", 1.0)],
    ],
)
def test_numbers_in_a_unit_come_in_the_wanted_one(unit, wanted, one):
    assert quantities(series("2", "-1,5", ""), unit, wanted) == pytest.approx(
        [2.0 * one, -1.5 * one, np.nan], nan_ok=True
    )


def test_a_unit_of_another_kind_is_refused():
    for unit, wanted in (("kg", "m"), ("bar", "m/s"), ("m", "deg")):
        with pytest.raises(InputError):
            quantities(series("1"), unit, wanted)


def test_names_are_parted_from_their_units():
    found = read_mapping(["time=Date+Time[%d.%m.%Y %H:%M:%S] lat=Lat (deg) lon = x[rad]", "depth=z"])
    assert found == {
        "time": MappedName("Date+Time", "%d.%m.%Y %H:%M:%S"),
        "lat": MappedName("Lat (deg) lon = x", "rad"),
        "depth": MappedName("z", "m"),
    }
    assert [mapped(name, "v").unit for name in ("time", "pitch", "speed", "gps")] == ["iso", "deg", "m/s", ""]
    with pytest.raises(InputError, match="did you mean") as refused:
        read_mapping(["latt=x", "lat="])
    assert len(refused.value.problems) == 2
    assert "without a name, expected lat=NAME" in str(refused.value.problems[1])


@pytest.mark.parametrize("latitude", [-60.0, 0.0, 48.0])
@pytest.mark.parametrize("longitude", [-123.0, 179.99])
def test_a_way_on_earth_and_back(latitude, longitude):
    """Against the ellipsoid's geodesics by another library."""
    geod = pytest.importorskip("pyproj").Geod(ellps="WGS84")
    east, north = np.array([1500.0, -2500.0, 0.0]), np.array([800.0, -300.0, 4000.0])
    there = moved(latitude, longitude, east, north)
    lon, lat, _ = geod.fwd(
        np.full(3, longitude), np.full(3, latitude), np.degrees(np.arctan2(east, north)), np.hypot(east, north)
    )
    turn = np.remainder(there[1] - lon + 180.0, 360.0) - 180.0
    assert np.abs(there[0] - lat).max() * 111e3 < 3.0
    assert np.abs(turn).max() * 111e3 * np.cos(np.radians(latitude)) < 3.0
    back = displacement(latitude, longitude, *there)
    assert np.array(back) == pytest.approx(np.array([east, north]), abs=1.0)
