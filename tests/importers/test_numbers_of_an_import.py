"""Every number that an import tells of its legs, against plain loops over legs made by hand; and parts of a track."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pandas as pd
import pytest
import yaml
from made_tracks import made
from pyproj import Geod

from missionplan.errors import InputError
from missionplan.importers import _of_current, geodesy, transit_data
from missionplan.importers.cutting import cut, leg_picture
from missionplan.importers.descents import _lines as lines_of_depth
from missionplan.importers.dives import LegRules, depths_of, longest_gap
from missionplan.importers.judging import fix_sd
from missionplan.importers.reckoning import HEADING_ERROR, VehicleCurrent
from missionplan.importers.sources import Reading
from missionplan.importers.starter import mission_text, numbers_of, prospects
from missionplan.importers.track import Break, Positions, Series, Track, clock_jumps, fixes
from missionplan.mission import Mission

GEOD = Geod(ellps="WGS84")
NAN = math.nan


def placed(latitude, longitude, east, north):
    lon, lat, _ = GEOD.fwd(longitude, latitude, math.degrees(math.atan2(east, north)), math.hypot(east, north))
    return lat, lon


def legs(count=5, seed=3):
    """Legs of differing lengths toward the north-east, with errors and pauses by chance; two do not count."""
    rng = np.random.default_rng(seed)
    rows, at, t = [], (37.0, -76.0), 1.7e9
    for k in range(count):
        way, error = rng.uniform(300.0, 900.0, 2), rng.normal(0.0, 0.05, 2)
        surface, lasting, pause = rng.uniform(20.0, 60.0), rng.uniform(600.0, 2500.0), rng.uniform(5.0, 30.0)
        reckoned = placed(*at, *way)
        end = placed(*reckoned, *(error * (lasting - surface)))
        stamp = pd.Timestamp(t, unit="s", tz="UTC").isoformat()
        rows.append((k + 1, stamp, t, t + lasting, *at, *reckoned, *end, surface, rng.uniform(2.0, 6.0), rng.uniform(20.0, 90.0),
                     rng.uniform(60.0, 200.0), int(k not in (1, 3)), way, error))  # fmt: skip
        t, at = t + lasting + pause, end
    names = ("leg t_start t_start_s t_end_s lat_start lon_start lat_dr_end lon_dr_end lat_end lon_end surface_s fix_sd_m "
             "max_depth_m dr_sd_m ok way error")  # fmt: skip
    return pd.DataFrame(rows, columns=names.split())


@pytest.mark.parametrize("counted", [3, 2, 0])
def test_what_the_legs_that_count_say_of_a_mission(counted):
    """All of them where none counts; of fewer than three the errors are not taken about their mean."""
    table = legs()
    table["ok"] = [1, 0, int(counted > 2), 0, int(counted > 1)] if counted else 0
    kept = [row for row in table.to_dict("records") if row["ok"] or not counted]
    errors, ways = (np.array([row[name] for row in kept]) for name in ("error", "way"))
    about = errors - errors.mean(axis=0) if len(kept) >= 3 else errors
    lengths, times = np.hypot(*ways.T), np.array([row["t_end_s"] - row["t_start_s"] - row["surface_s"] for row in kept])
    pauses = [b["t_start_s"] - a["t_end_s"] + a["surface_s"] for a, b in pairwise(kept)]
    unit = ways / lengths[:, None]
    first, last = kept[0], kept[-1]
    found = numbers_of(table)
    assert (found.latitude, found.longitude, found.start) == (first["lat_start"], first["lon_start"], first["t_start"])
    assert found.sigma == pytest.approx(math.sqrt((about**2).mean()), rel=2e-3)
    assert found.mean_error == pytest.approx(tuple(errors.mean(axis=0)), abs=2e-4)
    assert found.surfacing == pytest.approx(np.median(pauses))
    assert found.fix_sd == pytest.approx(np.median([row["fix_sd_m"] for row in kept]))
    assert found.speed == pytest.approx(np.median(lengths / times), rel=1e-3)
    assert (found.length, found.duration) == pytest.approx((np.median(lengths), np.median(times)), rel=1e-3)
    assert found.course == pytest.approx(math.degrees(math.atan2(*unit.mean(axis=0))), abs=0.1)
    assert found.spread == pytest.approx(np.hypot(*unit.mean(axis=0)), abs=1e-4)
    way = GEOD.inv(first["lon_start"], first["lat_start"], last["lon_end"], last["lat_end"])[2]
    assert found.way == pytest.approx(way, rel=1e-3)
    assert found.record == pytest.approx(last["t_end_s"] - first["t_start_s"])
    assert found.depth == max(row["max_depth_m"] for row in kept)
    doubt = float(np.median([row["dr_sd_m"] / length for row, length in zip(kept, lengths, strict=True)]))
    assert found.glide_doubt == pytest.approx(math.sqrt(doubt**2 - HEADING_ERROR**2), abs=1e-3)


def test_a_leg_alone_has_its_own_time_at_the_surface_and_the_least_error():
    one = legs(1)
    one[["lat_dr_end", "lon_dr_end"]] = one[["lat_end", "lon_end"]]
    found = numbers_of(one)
    assert (found.surfacing, found.sigma) == (one["surface_s"][0], 0.001)
    assert math.isnan(numbers_of(one.assign(dr_sd_m=NAN)).glide_doubt)
    assert numbers_of(one.assign(dr_sd_m=1e-3)).glide_doubt == 0.0  # the heading's share is more than all of it


@pytest.mark.parametrize(
    ("changes", "goal", "arrival"),
    [
        ({}, 4.0 * 747.0, 14.94),  # four legs are farther than from the first fix to the last
        ({"way": 9000.0}, 9000.0, 14.94),
        ({"way": 9000.0, "fix_sd": 11.0}, 9000.0, 22.0),
        ({"way": 9000.0, "length": 120.0, "fix_sd": 3.0}, 9000.0, 10.0),
    ],
)
def test_the_starter_mission_sails_the_legs_again(changes, goal, arrival):
    found = replace(numbers_of(legs()), length=747.0, way=50.0, fix_sd=4.0, course=120.0, speed=0.4321, sigma=0.0317)
    found = replace(found, **changes)
    text = mission_text("a 'made' one", found)
    data = yaml.safe_load(text)
    (phase,) = data["phases"]
    value = {
        key: float(str(each).split()[0])
        for key, each in phase["transit"].items()
        if key in ("speed", "d_max", "arrival_radius")
    }
    east, north = (float(each.split()[0]) for each in phase["transit"]["to"])
    assert (east, north) == pytest.approx(
        (goal * math.sin(2.0 * math.pi / 3.0), goal * math.cos(2.0 * math.pi / 3.0)), abs=0.5
    )
    assert value == pytest.approx({"speed": 0.432, "d_max": found.length, "arrival_radius": arrival}, rel=5e-3)
    assert data["navigation"]["velocity_error"]["sigma"] == "0.0317 m/s"
    assert float(data["navigation"]["surfacing_time"].split()[0]) == pytest.approx(found.surfacing, rel=5e-3)
    assert float(data["navigation"]["fix_error"].split()[0]) == pytest.approx(found.fix_sd, rel=5e-3)
    assert data["site"]["origin"] == {"latitude": "37.000000 deg", "longitude": "-76.000000 deg"}
    assert data["name"] == "a 'made' one"
    mission = Mission.from_data(data)
    assert mission.start.timestamp() == 1.7e9


LONG = 12.42 * 3600.0
INERTIAL = math.pi / (7.2921e-5 * math.sin(math.radians(37.0)))


@pytest.mark.parametrize(
    ("changes", "what", "verdict"),
    [
        ({"spread": 0.91}, "compass and speed errors", "no: nearly all legs go 120 deg"),
        ({"spread": 0.89}, "compass and speed errors", "yes"),
        ({"record": 0.49 * LONG}, "a tide", "no: the record lasts 6.1 h, less than half a period"),
        ({"record": 0.51 * LONG, "duration": 0.49 * LONG}, "a tide", "yes: the record lasts 6 h"),
        ({"record": 3.0 * LONG, "duration": 0.51 * LONG}, "a tide", "hardly: a leg lasts 6.3 h"),
        ({"record": 0.49 * INERTIAL}, "an inertial current", f"no: the record lasts {0.49 * INERTIAL / 3600.0:.1f} h, the period there is {INERTIAL / 3600.0:.1f} h"),
        ({"record": 0.51 * INERTIAL}, "an inertial current", f"yes: the period there is {INERTIAL / 3600.0:.1f} h"),
    ],
)  # fmt: skip
def test_what_the_whole_record_can_show(changes, what, verdict):
    table = legs(9).assign(ok=1)
    found = replace(numbers_of(table), course=120.0, **changes)
    (told,) = (words for name, words in prospects(table, found) if name.startswith(what))
    assert told.startswith(verdict)


def test_what_the_number_of_legs_and_their_times_can_show():
    def told(count, surface, shortest):
        table = legs(30).assign(ok=(np.arange(30) < count).astype(int))
        table["t_end_s"] = table["t_start_s"] + np.where(np.arange(30) == 4, shortest, 1000.0)
        table["surface_s"] = surface
        return {
            name: words.partition(":")[0] + ":" + words.partition(":")[2]
            for name, words in prospects(table, numbers_of(table))
        }

    enough, few = told(20, 20.5, 499.0), told(7, 18.4, 501.0)
    assert enough["a mean current"] == "yes: 20 legs"
    assert few["a mean current"].startswith("no: 7 legs, and 8 are needed")
    assert enough["persistence, a random walk, heavy tails"] == "yes: 20 legs"
    assert told(19, 20.5, 499.0)["persistence, a random walk, heavy tails"].startswith("hardly: 19 legs")
    assert enough["drift at the surface"] == "yes: 2 % of the legs' time is at the surface"
    assert few["drift at the surface"] == "hardly: 2.0 % of the legs' time is at the surface"
    assert enough["errors of the fixes, apart from those under way"] == "yes: the longest leg is 2.0 times the shortest"
    assert few["errors of the fixes, apart from those under way"].startswith(
        "no: all legs are alike in length (longest over shortest 2.0)"
    )


@pytest.fixture(scope="module")
def imported():
    log = made(legs=5, current=(0.1, -0.05))
    bad = replace(log.track.fixes, hdop=np.where(log.track.fixes.t == log.starts[3] - 120.0, 99.0, 1.0))
    reading = Reading(replace(log.track, fixes=bad), "made", (), (), {}, 0.0)
    return log, transit_data(reading, LegRules(), explain=[2])


def test_figures_are_those_of_the_legs(imported):
    log, found = imported
    figures = found.figures.summary()
    assert figures["fixes"] == len(log.track.fixes)
    assert figures["velocity_error_mean_east_m_s"] == pytest.approx(0.1 * 3600.0 / 3600.0, abs=2e-3)
    assert figures["velocity_error_mean_north_m_s"] == pytest.approx(-0.05, abs=2e-3)
    assert figures["leg_length_m"] == pytest.approx(0.3 * 3580.0, rel=2e-3)
    surface = 3.0 / (100.0 / 1800.0)  # it rises at 100 m in half an hour
    assert figures["leg_duration_s"] == pytest.approx(3600.0 - surface, abs=0.5)
    assert figures["speed_m_s"] == pytest.approx(0.3 * 3580.0 / (3600.0 - surface), rel=2e-3)
    assert figures["surfacing_time_s"] == pytest.approx(540.0 + surface, abs=0.5)
    assert figures["fix_sd_m"] == pytest.approx(5.0 / math.sqrt(2.0), abs=1e-3)
    assert figures["record_s"] == log.ends[-1] - log.starts[0]
    assert figures["max_depth_m"] == pytest.approx(100.0)
    assert math.isnan(figures["made_reckoning_sd_m"])
    assert math.isnan(figures["current_in_reckoning"])
    assert found.dataset["noise"] == {"fix": "3.54 m"}


def test_made_reckoning_is_as_sure_as_on_the_leg_in_the_middle_and_left_out_dives_are_counted_by_reason():
    log = made(legs=5, reckoned=False)
    t = log.track.depth.t
    speed = Series(t, np.where(t < log.ends[0], 0.9, np.where(t < log.ends[1], 0.35, 0.3)))
    track = replace(log.track, speed=speed, breaks=(Break(float(log.starts[3]) + 900.0, "a restart"),))
    found = transit_data(Reading(track, "made", (), (), {}, 0.0), LegRules())
    assert found.reasons == {"a restart": 1}
    sds = found.table.groupby("leg")["dr_sd_m"].first()
    assert sds.mean() > np.median(sds) + 10.0
    assert found.figures.made_reckoning_sd == pytest.approx(np.median(sds), abs=0.06)


def test_what_is_drawn_lies_about_the_first_fix_of_the_first_leg(imported):
    log, found = imported
    begin = np.flatnonzero(log.track.fixes.t == log.starts[0])[0]
    origin = log.track.fixes.longitude[begin], log.track.fixes.latitude[begin]

    def away(latitude, longitude):
        azimuth, _, distance = GEOD.inv(*(np.full(np.shape(latitude), each) for each in origin), longitude, latitude)
        return np.stack((distance * np.sin(np.radians(azimuth)), distance * np.cos(np.radians(azimuth))))

    lines, table = found.lines, found.table
    assert lines.fixes == pytest.approx(away(log.track.fixes.latitude, log.track.fixes.longitude), abs=0.5)
    assert lines.leg_starts == pytest.approx(away(table["lat_start"], table["lon_start"]), abs=0.5)
    assert lines.leg_ends[0] == pytest.approx(away(table["lat_dr_end"], table["lon_dr_end"]), abs=0.5)
    assert lines.leg_ends[1] == pytest.approx(away(table["lat_end"], table["lon_end"]), abs=0.5)
    assert [line.shape[1] for line in lines.reckoned] == [179] * 5
    assert lines.depth_t.tolist() == log.track.depth.t.tolist()
    assert lines.depth == pytest.approx(log.track.depth.values)


def test_the_picture_of_a_leg_counts_from_its_start_a_quarter_of_an_hour_around(imported):
    log, found = imported
    (picture,) = found.pictures
    start, end = log.starts[1], log.ends[1]
    near = [t - start for t in log.track.fixes.t if start - 900.0 <= t <= end + 900.0]
    assert picture.row == 1
    assert picture.fix_t.tolist() == near
    at = near.index(0.0)
    assert picture.fixes[:, at] == pytest.approx([0.0, 0.0])
    assert picture.fixes[:, at - 1] == pytest.approx([-6.0, 3.0], abs=0.05)  # a minute before, in the current
    assert (picture.reckoned_t[0], picture.reckoned_t[-1]) == (20.0, 3580.0)
    assert np.hypot(*picture.reckoned[:, -1]) == pytest.approx(0.3 * 3580.0, rel=1e-3)
    assert (picture.depth_t.min(), picture.depth_t.max()) == (-900.0, 3600.0 + 540.0 + 360.0)
    assert picture.depth[picture.depth_t == 1800.0] == pytest.approx([100.0])
    assert picture.reasons == ()


def test_fixes_that_do_not_count_are_in_the_picture_of_the_legs_they_lie_about():
    log = made(legs=3, current=(0.1, -0.05))
    fixed = log.track.fixes
    valid = np.where(np.isin(fixed.t, [log.starts[0] - 60.0, log.starts[2] - 120.0]), 0.0, 1.0)
    parts = cut(replace(log.track, fixes=replace(fixed, valid=valid)), LegRules())
    picture = leg_picture(parts, 2)
    assert picture.rejected_t.tolist() == [-120.0]
    assert picture.rejected == pytest.approx(np.array([[-12.0], [6.0]]), abs=0.05)  # two minutes before, in the current
    assert picture.reasons == ("not valid by its flag",)
    assert -120.0 not in picture.fix_t


def test_what_is_said_of_a_current_that_the_vehicle_estimates():
    def said(share, sd, **rules):
        current = VehicleCurrent(share, sd, np.zeros(1), np.zeros(1), np.zeros(1))
        return " ".join(_of_current(replace(parts, current=current), LegRules(**rules)))

    parts = cut(made(legs=3).track, LegRules())
    assert _of_current(parts, LegRules()) == ()
    assert "do not show" in said(NAN, NAN)
    assert "0.30 ± 0.05" in said(0.3, 0.05)
    assert "hold none of it" in said(0.3, 0.05)
    assert "hold none of it" in said(0.9, 0.31)  # three standard errors do not reach
    assert "was left in" in said(0.95, 0.1)
    assert "was taken out" in said(0.95, 0.1, take_out_current=True)


# parts of a track


def test_readings_within_at_and_before_a_moment():
    found = Series(np.array([0.0, 10.0, 20.0, 30.0]), np.array([1.0, 2.0, 4.0, 8.0]))
    assert found.within(10.0, 20.0).values.tolist() == [2.0, 4.0]
    assert found.at(np.array([-5.0, 5.0, 15.0, 99.0])).tolist() == [1.0, 1.5, 3.0, 8.0]
    np.testing.assert_array_equal(found.held(np.array([-1.0, 0.0, 9.9, 10.0, 99.0])), [NAN, 1.0, 1.0, 2.0, 8.0])
    assert [found.latest(t, 10.0) for t in (10.0, 19.9, 20.0)] == [2.0, 2.0, 4.0]
    assert math.isnan(found.latest(5.0, 1.0))
    assert math.isnan(found.latest(-1.0, -9.0))
    assert np.isnan(Series().at(np.zeros(2))).all()
    assert np.isnan(Series().held(np.zeros(2))).all()
    line = Positions(found.t, found.values, -found.values)
    assert line.within(10.0, 30.0).latitude.tolist() == [2.0, 4.0]  # not the fix that ends it


def test_a_part_of_a_track_has_what_was_logged_then():
    log = made(legs=6).track
    marked = replace(log, marks=(log.fixes.t[0], log.fixes.t[20], log.fixes.t[-1]), declination=Series(np.zeros(1), np.array([3.0])),
                     breaks=tuple(Break(float(t), "x") for t in log.fixes.t))  # fmt: skip
    begin, end = log.fixes.t[20], log.fixes.t[-1]
    part = marked.within(begin, end)
    for name in ("fixes", "reckoned", "depth", "heading", "pitch"):
        t = getattr(marked, name).t
        assert getattr(part, name).t.tolist() == t[(t >= begin) & (t < end)].tolist(), name
    assert part.marks == (begin,)
    assert [each.t for each in part.breaks] == part.fixes.t.tolist()
    assert part.declination.values.tolist() == [3.0]  # told once, for all times


def test_deployments_are_parted_by_a_month_of_silence_and_begin_with_a_fix():
    day = 86_400.0
    t = np.array([0.0, 1.0, 31.5, 32.0, 40.0, 100.0]) * day
    known = fixes(t, np.full(6, 48.0), np.full(6, -123.0))
    track = Track("a", "a", known)
    spans = track.deployments()
    assert [known.t[(known.t >= a) & (known.t < b)].tolist() for a, b in spans] == [(t[:2]).tolist(), t[2:5].tolist()]
    heard = replace(track, depth=Series(t[:1] + 20.0 * day, np.zeros(1)))
    assert len(heard.deployments()) == 1  # it was not silent


@pytest.mark.parametrize(
    ("deep", "given", "dive", "surface"),
    [
        (100.0, None, 5.0, 3.0),
        (12.0, None, 3.0, 1.8),
        (0.8, None, 0.3, 0.18),
        (100.0, 2.0, 2.0, 1.2),
        (8.0, 40.0, 40.0, 3.0),
    ],
)
def test_what_counts_as_a_dive_and_as_the_surface(deep, given, dive, surface):
    depth = Series(np.arange(101.0), np.concatenate([np.full(90, deep), np.zeros(11)]))
    found = depths_of(depth, LegRules(dive_depth=given))
    assert (found.dive, found.surface) == pytest.approx((dive, surface))


def test_the_longest_gap_is_two_minutes_or_four_intervals_or_as_given():
    slow, quick = (Series(np.arange(9) * step, np.zeros(9)) for step in (100.0, 5.0))
    assert [longest_gap(each, LegRules()) for each in (slow, quick, Series())] == [400.0, 120.0, 120.0]
    assert longest_gap(slow, LegRules(longest_gap=7.0)) == 7.0


def test_a_clock_that_steps_back_more_than_a_second_is_told_unless_the_rows_are_in_no_order():
    t = np.arange(100.0)
    t[60:] -= 30.0
    (found,) = clock_jumps(t)
    assert (found.t, found.reason, found.at_surface_too) == (30.0, "the clock jumps back (29 s)", True)
    assert found.until == 56.0  # times from 30 s to there stand twice
    (single,) = clock_jumps(np.where(np.arange(100) == 50, 9e9, np.arange(100.0)))
    assert (single.t, single.until) == (51.0, -np.inf)
    assert not clock_jumps(np.where(np.arange(100) == 50, 48.5, np.arange(100.0)))
    assert not clock_jumps(np.where(np.arange(100) == 50, 8.0, np.arange(100.0)))
    assert not clock_jumps(np.arange(100.0)[::-1])
    assert not clock_jumps(np.random.default_rng(1).permutation(100.0 * np.arange(100.0)))


def test_stated_accuracy_goes_before_dilution():
    """Both are of the plane; an axis has √2 less."""
    t = np.arange(4.0)
    known = fixes(
        t, np.full(4, 48.0), -123.0 + t, accuracy=np.array([4.0, NAN, 6.0, NAN]), hdop=np.array([1.0, 2.0, NAN, NAN])
    )
    np.testing.assert_allclose(fix_sd(known), np.array([4.0, 10.0, 6.0, NAN]) / math.sqrt(2.0))


@pytest.mark.parametrize("latitude", [-60.0, 48.0])
def test_the_origin_of_metres_is_found_by_the_fix_nearest_in_time(latitude):
    """The earliest of those that are as near; one two minutes away tells nothing."""
    origin, t = (latitude, 179.95), np.arange(0.0, 1000.0, 100.0)
    east, north = 5000.0 + 3.0 * t, -2000.0 - 2.0 * t
    places = np.array([placed(*origin, x, y) for x, y in zip(east, north, strict=True)])
    wrong = places[5] + 0.01  # the reckoning has erred by then
    known = fixes(np.array([t[3] + 0.2, t[5], t[7] + 30.0]), *np.array([places[3], wrong, wrong]).T)
    found = geodesy.plane_positions(t, east, north, known, None)
    off = GEOD.inv(found.longitude, found.latitude, places[:, 1], places[:, 0])[2]
    assert off.max() < 0.5
    named = geodesy.plane_positions(t, east, north, known, origin)
    assert GEOD.inv(named.longitude, named.latitude, places[:, 1], places[:, 0])[2].max() < 0.5
    with pytest.raises(InputError, match="origin is not known"):
        geodesy.plane_positions(t, east, north, fixes(t[-1:] + 121.0, *places[:1].T), None)
    assert len(geodesy.plane_positions(np.array([NAN]), east[:1], north[:1], known, None)) == 0


def test_a_vehicle_s_declination_is_the_median_but_for_its_zeros_and_the_model_s_where_it_has_none(monkeypatch):
    asked = []
    monkeypatch.setattr(geodesy, "model_declination", lambda *place: asked.append(place) or 15.0)
    log = made(legs=3).track
    middle = len(log.fixes) // 2
    where = log.fixes.latitude[middle], log.fixes.longitude[middle], log.fixes.t[middle]
    turned = replace(log, heading_from="magnetic")
    told = geodesy.with_declination(
        replace(turned, declination=Series(np.arange(5.0), np.array([0.0, 0.0, 0.0, 12.0, 14.0])))
    )
    assert "is 13.0 deg, but the World Magnetic Model has 15.0 deg" in told.notices[-1]
    assert "turned by -2.0 deg" in told.notices[-1]
    near = geodesy.with_declination(replace(turned, declination=Series(np.zeros(1), np.array([13.6]))))
    assert "is that of the World Magnetic Model" in near.notices[-1]
    added = geodesy.with_declination(turned)
    assert (added.declination.t.tolist(), added.declination.values.tolist()) == ([where[2]], [15.0])
    assert asked == [where] * 3
    for kind in ("true", "unknown"):
        assert not len(geodesy.with_declination(replace(log, heading_from=kind)).declination)
    monkeypatch.setattr(geodesy, "model_declination", lambda *place: None)
    assert (
        "was not checked"
        in geodesy.with_declination(replace(turned, declination=Series(np.zeros(1), np.ones(1)))).notices[-1]
    )
    assert "taken as from true north" in geodesy.with_declination(turned).notices[-1]


def test_a_track_moved_to_a_made_up_place_keeps_distances_and_directions():
    log = made(legs=2).track
    found = geodesy.shifted(log, -33.0, 151.0)
    assert (found.fixes.latitude[0], found.fixes.longitude[0]) == pytest.approx((-33.0, 151.0))
    for old, new in ((log.fixes, found.fixes), (log.reckoned, found.reckoned)):
        ways = [GEOD.inv(np.full(len(each), base.longitude[0]), np.full(len(each), base.latitude[0]), each.longitude, each.latitude)
                for each, base in ((old, log.fixes), (new, found.fixes))]  # fmt: skip
        assert ways[0][2] == pytest.approx(ways[1][2], abs=0.5)
        far = ways[0][2] > 500.0
        turn = np.remainder(ways[0][0] - ways[1][0] + 180.0, 360.0) - 180.0
        assert np.abs(turn[far]).max() < 0.1
    for latitude, longitude in ((85.1, 0.0), (-85.1, 0.0), (0.0, 180.1)):
        with pytest.raises(InputError, match="expected a latitude to 85 deg"):
            geodesy.shifted(log, latitude, longitude)
    assert geodesy.shifted(replace(log, fixes=log.fixes[:0]), 1.0, 2.0).reckoned is log.reckoned


def test_of_long_records_of_depth_every_so_many_readings_are_drawn():
    found = lines_of_depth(Series(np.arange(12_500.0), np.arange(12_500.0) * 2.0))
    assert found.depth_t.tolist() == list(range(0, 12_500, 3))
    assert found.depth == pytest.approx(2.0 * found.depth_t)
