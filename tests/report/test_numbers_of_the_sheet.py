"""Every number of the sheet for the boat, read back: clocks, places, sizes, areas, and what is left to be searched."""

import json
import math
import re
from datetime import UTC, datetime
from types import SimpleNamespace

import numpy as np
import pytest
from pyproj import Geod

from missionplan.report.quantities import reading_in
from missionplan.report.simulation import overdue as sheet
from missionplan.results.whereabouts import ExpectedTime, Overdue, SearchArea

NAN = math.nan
ORIGIN = (math.radians(-17.5), math.radians(179.99))


def outcome(start=None, origin=ORIGIN):
    data = {} if start is None else {"start": start}
    return SimpleNamespace(
        provenance=SimpleNamespace(data=data, mission="made"),
        tracks=SimpleNamespace(origin=origin, targets={}),
        overdue=None,
    )


def area(way="adrift at the surface", after="", **changes):
    square = np.array([[0.0, 300.0, 300.0, 0.0, 0.0], [0.0, 0.0, 200.0, 200.0, 0.0]])
    given = {
        "overdue": 21_600.0, "share": 0.95, "polygons": ((square,),), "centre_east": 1.0, "centre_north": 2.0,
        "densest_east": 3000.0, "densest_north": -4000.0, "half_length": 812.0, "half_width": 391.0,
        "toward": math.radians(37.0), "missed": 0.43, "trials": 77, "is_assumed": False,
    }  # fmt: skip
    return SearchArea(way=way, after=after, **{**given, **changes})


def time(name="back", p50=3601.0, p95=7200.0, p99=9000.0, p999=NAN, energy_left=12.34):
    return ExpectedTime(name, 0.87, p50, p95, p99, p999, energy_left)


@pytest.mark.parametrize(
    ("seconds", "start", "words"),
    [
        (3660.0, None, "1:01 h"),
        (3660.1, None, "1:02 h"),  # never sooner than it is
        (NAN, None, ""),
        (86_340.0, "2026-06-01T00:30Z", "23:59 h (02 Jun 00:29 UTC)"),
        (3661.0, "2026-06-01T23:00+02:00", "1:02 h (01 Jun 22:02 UTC, 02 Jun 00:02 +02:00)"),
        (360_060.0, "2026-06-01T00:00:30Z", "100:01 h (05 Jun 04:01 UTC)"),
    ],
)
def test_a_clock_is_rounded_up_and_in_both_zones(seconds, start, words):
    assert sheet._clock(seconds, sheet._start(outcome(start))) == words.replace(" h", "\u00a0h")


def test_a_start_that_is_none_is_left_out():
    assert sheet._start(outcome()) is None
    assert sheet._start(outcome("no time")) is None


@pytest.mark.parametrize(
    ("angle", "words"),
    [(60.1008, "60° 06.05′ N"), (-0.5, "0° 30.00′ S"), (17.99999, "18° 00.00′ N"), (-179.0083, "179° 00.50′ S")],
)
def test_angles_are_in_degrees_and_minutes(angle, words):
    assert sheet.in_minutes(angle, "NS").replace("\u00a0", " ") == words


def degrees(words):
    """Latitude and longitude [deg] of a place as the sheet writes it."""
    parts = re.fullmatch(r"(\d+)° ([\d.]+)′ ([NS]), (\d+)° ([\d.]+)′ ([EW])", words.replace("\u00a0", " ")).groups()
    signs = {"N": 1, "S": -1, "E": 1, "W": -1}
    return [signs[letter] * (float(whole) + float(minutes) / 60.0) for whole, minutes, letter in (parts[:3], parts[3:])]


def test_a_search_begins_where_the_vehicle_is_most_likely_across_the_date_line_too():
    latitude, longitude = degrees(sheet._place(outcome(), (3000.0, -4000.0)))
    east, north, _ = Geod(ellps="WGS84").fwd(179.99, -17.5, math.degrees(math.atan2(3000.0, -4000.0)), 5000.0)
    assert (longitude, latitude) == pytest.approx((east, north), abs=0.0051 / 60.0)
    assert longitude < 0.0
    assert sheet._place(outcome(origin=None), (3000.0, -4000.0)) == "3000\u00a0m E, −4000\u00a0m N"


def test_the_table_of_areas_has_those_of_95_percent_with_their_numbers():
    circle = area("not released", "moor", half_length=96.0, half_width=96.0, overdue=0.0, is_assumed=True)
    wide = area("on the seafloor", overdue=0.0, half_length=2400.0, half_width=700.0, toward=0.0)
    after = area(after="moor", overdue=3600.0, missed=1.0)
    found = Overdue((time(),), {}, (area(share=0.9), area(), circle, wide, after), searches=2)
    table = sheet._areas(outcome(), found)
    rows = [[cell.replace("\u00a0", " ") for cell in row] for row in table.rows]
    assert [row[:2] for row in rows] == [
        ["adrift at the surface, 77 trials", "6 h"],
        ["not released (at moor), assumed", "at any time"],
        ["on the seafloor, 77 trials", "at any time"],
        ["adrift at the surface (after moor), 77 trials", "1 h"],
    ]
    assert [row[3] for row in rows] == ["812 × 391 m, 37°", "96 m (circle)", "2400 × 700 m, 0°", "812 × 391 m, 37°"]
    assert {row[4] for row in rows} == {"0.060 km²"}
    assert {row[2] for row in rows} == {
        sheet._place(outcome(), (3000.0, -4000.0)).replace("\u00a0", " ")
    }  # the densest
    assert [row[5] for row in rows] == ["43 %", "43 %", "43 %", "100 %"]
    assert len(sheet._areas(outcome(), Overdue((time(),), {}, (area(),))).rows[0]) == 5  # nothing was searched


@pytest.mark.parametrize(
    ("system", "small", "large", "size"),
    [
        ("", "2500 m²", "0.060 km²", "812 × 391 m, 37°"),
        ("metric", "2500 m²", "0.060 km²", "812 × 391 m, 37°"),
        ("nautical", "2500 m²", "0.0175 nmi²", "812 × 391 m, 37°"),
        ("imperial", "26 900 ft²", "0.0232 mi²", "2660 × 1280 ft, 37°"),
    ],
)
def test_areas_are_in_squares_of_the_reader_s_unit(system, small, large, size):
    little = area(polygons=((0.5 * np.array([[0.0, 100.0, 100.0, 0.0, 0.0], [0.0, 0.0, 100.0, 100.0, 0.0]]),),))
    with reading_in(system):
        found = [sheet._area(little), sheet._area(area()), sheet._size(area())]
        told = [each.replace("\u00a0", " ").replace("\u202f", " ") for each in found]
    numbers = [float(re.match(r"[\d. ]+", each)[0].replace(" ", "")) for each in (small, large)]
    squares = {"m²": 1.0, "km²": 1e6, "nmi²": 1852.0**2, "ft²": 0.3048**2, "mi²": 1609.344**2}
    for text, number, metres in zip((small, large), numbers, (2500.0, 60_000.0), strict=True):
        assert number * squares[text.split()[-1]] == pytest.approx(metres, rel=0.03)
    assert told[1:] == [large, size]
    assert told[0] == small


def test_times_tell_hours_trials_and_the_battery_left():
    rows = sheet._times(Overdue((time("out, arrival"), time(p999=10_000.0)), {}, ()), None).rows
    assert rows[0] == ("out, arrival", "87 %", "1:01", "2:00", "2:30", "", "12.3")
    assert rows[1][5] == "2:47"
    assert "Blank" in sheet._times(Overdue((time(), time(p999=10_000.0)), {}, ()), None).caption
    without = sheet._times(Overdue((time(energy_left=NAN),), {}, ()), datetime(2026, 7, 4, 6, tzinfo=UTC))
    assert "Blank" not in without.caption
    assert len(without.rows[0]) == len(without.columns)
    last = dict(zip(without.columns, without.rows[0], strict=True))["99 %"]  # so few trials tell of no later hour
    assert last.replace("\u00a0", " ") == "2:30 h (04 Jul 08:30 UTC)"
    assert [len(list(sheet._battery(Overdue((time(energy_left=left),), {}, ())))) for left in (NAN, 3.0)] == [1, 0]


def test_the_words_tell_the_share_that_is_back_and_that_never_is():
    few = Overdue((time(),), {}, ())
    words = sheet._why(few, None).replace("\u00a0", " ")
    assert words.startswith(
        "By 2:30 h after the start, 99 of 100 missions that come back are back; half are by 1:01 h."
    )
    assert "So few trials tell of no later hour" in words
    assert words.endswith("In the model every mission comes back: what keeps it away is not in the model.")
    many = Overdue((time(p999=10_000.0),), {"out: out of energy": 0.021, "moor: flooded early": 0.034}, ())
    words = sheet._why(many, None).replace("\u00a0", " ")
    assert words.startswith("By 2:47 h after the start, 999 of 1000 missions")
    assert "So few" not in words
    assert "5.5 % never do in the model" in words
    assert words.endswith(f"most of them because of {sheet.failure_in_words('moor: flooded early')}.")
    least = Overdue((time(p99=NAN),), {}, ())
    assert sheet._why(least, None).replace("\u00a0", " ").startswith("By 2:00 h after the start, 19 of 20 missions")


def test_areas_in_geojson_lie_where_they_are_with_all_their_numbers():
    hole = np.array([[100.0, 100.0, 200.0, 100.0], [50.0, 100.0, 50.0, 50.0]])
    made = outcome()
    made.overdue = Overdue((time(),), {}, (area(polygons=((*area().polygons[0], hole),)),))
    (found,) = json.loads(sheet.search_areas_geojson(made))["features"]
    geod, rings = Geod(ellps="WGS84"), found["geometry"]["coordinates"][0]
    for ring, wanted in zip(rings, (area().polygons[0][0], hole), strict=True):
        for (longitude, latitude), (east, north) in zip(ring, wanted.T, strict=True):
            azimuth, _, distance = geod.inv(179.99, -17.5, longitude, latitude)
            there = distance * np.array([np.sin(np.radians(azimuth)), np.cos(np.radians(azimuth))])
            assert there == pytest.approx([east, north], abs=0.1)
    told = found["properties"]
    assert told["name"].replace("\u00a0", " ") == "adrift at the surface, 6 h, 95 %"
    assert (told["overdue_s"], told["share"], told["half_length_m"], told["missed_by_searches"]) == (
        21_600.0,
        0.95,
        812.0,
        0.43,
    )
    assert sheet.search_areas_geojson(outcome()) is None
    made.tracks.origin = None
    assert sheet.search_areas_geojson(made) is None


def test_the_map_has_the_areas_of_95_percent_in_kilometres_and_their_hours(monkeypatch):
    seen = {}
    monkeypatch.setattr(
        sheet, "to_figure", lambda figure, name, alt, *words, **more: seen.update(figure=figure, alt=alt)
    )
    made = outcome()
    made.tracks.targets = {"moor": ((150.0, -700.0), 20.0)}
    wide = np.array([[-900.0, 900.0, 900.0, -900.0, -900.0], [-400.0, -400.0, 800.0, 800.0, -400.0]])
    areas = (
        area(share=0.5, polygons=((2.0 * wide,),)),
        area(),
        area("on the seafloor", overdue=0.0, polygons=((wide,),)),
    )
    sheet._map(made, Overdue((time(),), {}, areas))
    (axes,) = seen["figure"].axes
    drift, seafloor, cross = (np.array(line.get_data()) for line in axes.get_lines())
    assert (drift[0].max(), drift[1].max()) == pytest.approx((0.3, 0.2))
    assert seafloor == pytest.approx(wide / 1000.0)
    assert cross.ravel() == pytest.approx([0.15, -0.7])
    assert [text.get_text() for text in axes.texts] == ["+6\u00a0h"]
    assert seen["alt"].replace("\u00a0", " ").endswith("adrift at the surface and on the seafloor.")
