"""Parts of readers, by themselves: the Earth, what is nearest in time, from which origin a filter counts, doubts."""

from dataclasses import replace
from datetime import UTC, datetime

import numpy as np
import pandas as pd
import pyproj
import pytest

from missionplan.errors import InputError
from missionplan.importers.geodesy import displacement, metres_per_degree, model_declination
from missionplan.importers.importer import ChannelStore, PartlyReadError, Samples
from missionplan.importers.judging import judge_fixes
from missionplan.importers.mapping import MappedName, times
from missionplan.importers.readers import ardupilot, moos
from missionplan.importers.readers.track import _marks, check_cells
from missionplan.importers.reckoning import HEADING_ERROR
from missionplan.importers.starter import _glide_doubt
from missionplan.importers.track import Track, fixes, possible, series

GEOD = pyproj.Geod(ellps="WGS84")


@pytest.mark.parametrize("latitude", [-78.0, -33.5, 0.0, 12.0, 48.6, 70.0])
def test_a_degree_is_as_long_as_geodesics_say(latitude):
    step = 1e-4
    east, north = metres_per_degree(latitude)
    *_, along = GEOD.inv(0.0, latitude, step, latitude)
    *_, up = GEOD.inv(0.0, latitude - step, 0.0, latitude + step)
    assert float(east) == pytest.approx(along / step, abs=1e-3)
    assert float(north) == pytest.approx(up / (2.0 * step), abs=1e-3)


@pytest.mark.parametrize(("year", "is_known"), [(2007, False), (2009, True), (2031, True), (2034, False)])
def test_the_magnetic_models_reach_two_years_beyond_their_own(year, is_known):
    pytest.importorskip("pygeomag")
    found = model_declination(48.0, -123.0, datetime(year, 7, 1, tzinfo=UTC).timestamp())
    assert (found is not None) == is_known


@pytest.mark.parametrize(("year", "published"), [(2010, -6.13), (2015, -3.90), (2020, -1.28), (2025, 1.28)])
def test_each_magnetic_model_is_that_of_its_five_years(year, published):
    """The test values that NOAA publishes with each model: at 80° N, 0° E, its first day; the model before is off."""
    pytest.importorskip("pygeomag")
    angle = model_declination(80.0, 0.0, datetime(year, 1, 1, tzinfo=UTC).timestamp())
    assert angle == pytest.approx(published, abs=0.006)


def test_the_doubt_of_a_glide_is_of_the_legs_that_have_one():
    doubts = np.array([0.1, np.nan, 0.2, 0.15])
    assert _glide_doubt(doubts) == pytest.approx((0.15**2 - HEADING_ERROR**2) ** 0.5, abs=1e-3)
    assert np.isnan(_glide_doubt(np.full(3, np.nan)))


def test_a_latitude_takes_the_longitude_nearest_in_time_before_or_after_it():
    store = ChannelStore()
    store.add("lon", np.array([0.0, 1.0, 2.0, 20.0]), np.array([10.0, 11.0, 12.0, 30.0]))
    found = moos._nearest(store, "lon", np.array([-0.2, 1.4, 1.6, 2.9, 3.5, 19.4]))
    np.testing.assert_array_equal(found, [10.0, 11.0, 12.0, 12.0, np.nan, 30.0])


@pytest.mark.parametrize(("has_origin", "count"), [(True, 3), (False, 0)])
def test_a_filter_that_counts_from_an_origin_needs_that_origin(has_origin, count):
    samples = {
        "place": Samples(("t", "lat", "lon")),
        "plane": Samples(("t", "north", "east")),
        "origin": Samples(("t", "lat", "lon")),
    }
    for t in range(3):
        samples["plane"].add(float(t), 100.0 * t, 30.0 * t)
    if has_origin:
        samples["origin"].add(0.0, 48.5, -123.25)
    found, words = ardupilot._reckoned(samples)
    assert len(found) == count
    assert words == ("the autopilot's filter (north, east)" if count else "the autopilot logs no position of its own")
    if count:
        east, north = displacement(48.5, -123.25, found.latitude, found.longitude)
        assert east == pytest.approx([0.0, 30.0, 60.0], abs=2e-3)
        assert north == pytest.approx([0.0, 100.0, 200.0], abs=2e-3)


def test_times_of_another_form_are_refused_and_damaged_ones_passed_by():
    asked = MappedName("clock", "%m/%d/%Y %H:%M:%S")

    def check(*words, is_first=True):
        words = pd.Series(words, dtype=str)
        check_cells(words, times(words, asked.unit), asked, is_first=is_first)

    with pytest.raises(ValueError, match="1 of 2 times in clock are not as %m/%d/%Y %H:%M:%S says: '12h'"):
        check("", "12h")
    check("12h", "05/01/2026 00:00:00")
    check("", "")  # nothing is written
    days = [f"{day:02d}/06/2026 00:00:00" for day in range(8, 17)]  # of June, days first
    with pytest.raises(ValueError, match=r"4 of 9 .*'13/06/2026 00:00:00'"):
        check(*days)
    with pytest.raises(PartlyReadError, match="4 of 9"):
        check(*days, is_first=False)


def test_a_mark_counts_where_it_rises_from_nothing_or_nil():
    values = np.array([2.0, 2.0, 0.0, 1.0, 1.0, np.nan, 3.0, -1.0, 0.5])
    assert _marks(10.0 * np.arange(9), values) == (0.0, 30.0, 60.0, 80.0)


def test_the_least_period_of_the_helm_that_ends_is_planned(tmp_path):
    periods = {
        "BHV_PeriodicSurface": ("", "period", (6000, 86_400)),
        "BHV_Timer": ("name = interval_1\n", "duration", (5940, 7000)),
    }
    blocks = [
        f"Behavior = {kind}\n{{\n{name}{key} = {each}\n}}\n"
        for kind, (name, key, own) in periods.items()
        for each in own
    ]
    (tmp_path / "helm.bhv").write_text("".join(blocks) + "Behavior = BHV_PeriodicSurface\n{\nperiod = 0\n}\n")
    assert moos._planned([tmp_path / "a.alog"]) == 5940.0


def test_units_of_readers_are_those_given_or_usual():
    given = {name: MappedName(name, unit) for name, unit in (("depth", "ft"), ("speed", "kn"), ("hdop", "m"))}
    found = [moos._factor(given, *each) for each in (("depth",), ("speed",), ("hdop",), ("pitch", "rad"), ("heading",))]
    assert found == pytest.approx([0.3048, 1852.0 / 3600.0, 1.0, 180.0 / np.pi, 1.0], rel=1e-6)
    assert moos._factor({"pitch": MappedName("PITCH", "deg")}, "pitch", "rad") == 1.0


def test_readings_that_no_vehicle_has_are_left_out_and_those_of_another_unit_refused():
    none, t = fixes(np.empty(0), np.empty(0), np.empty(0)), np.arange(4.0)
    track = Track(
        "a", "track", none, heading=series(t, [10.0, 655.35, 359.0, -170.0]), speed=series(t, [1.0, -1.0, 2.0, 0.0])
    )
    found = possible(track)
    assert (found.heading.t.tolist(), found.heading.values.tolist()) == ([0.0, 2.0, 3.0], [10.0, 359.0, -170.0])
    assert found.speed is track.speed
    assert found.notices == ("1 of 4 readings of the heading are impossible, such as 655.35: left out",)
    with pytest.raises(InputError, match="3 of 4 readings of the speed are impossible, such as 1000"):
        possible(replace(track, speed=series(t, [1000.0, 1200.0, 900.0, 0.0])))


def test_angles_that_may_be_radians_are_told():
    near, none = np.array([0.85, 0.86]), np.zeros(2)
    t, turn = np.array([1.7e9, 1.7e9 + 1.0]), np.array([0.1, 6.2])
    told = possible(Track("a", "b", fixes(t, near, -2.0 * near), heading=series(t, turn))).notices
    assert [each.partition(" lie")[0] for each in told] == ["its fixes", "its headings"]
    assert not possible(Track("a", "b", fixes(t, near + 1.0, none), heading=series(t, 10.0 * turn))).notices


def test_a_dilution_that_is_always_nil_was_not_logged():
    t, none = np.arange(3.0), np.zeros(3)
    assert len(judge_fixes(fixes(t, none + 48.0, none, hdop=none)).good) == 3
    some = judge_fixes(fixes(t, none + 48.0, none, hdop=np.array([1.0, 1.0, 0.0]), valid=none + 1.0))
    assert np.isnan(judge_fixes(fixes(t, none + 48.0, none, hdop=none)).sd).all()
    assert some.by.tolist() == ["flag", "flag", "neighbours"]
