"""Each rule by which a track is cut into legs, on made tracks of which everything is known."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from made_tracks import LATITUDE, LONGITUDE, START, made

from missionplan.importers.cutting import cut, of_the_clock
from missionplan.importers.dives import Depths, LegRules, find_candidates, logged_again
from missionplan.importers.geodesy import displacement, moved
from missionplan.importers.judging import (
    _ALLOWED,
    _DRIFT,
    REPEATED,
    _confirmed,
    _gap_at_surface,
    _jump,
    judge_fixes,
)
from missionplan.importers.track import Break, Series, Track, fixes, positions, series

RULES = LegRules()


def velocity_errors(legs):
    east, north = displacement(*(legs[name].to_numpy() for name in ("lat_dr_end", "lon_dr_end", "lat_end", "lon_end")))
    return np.stack([east, north]) / (legs["t_end_s"] - legs["t_start_s"]).to_numpy()


def test_legs_are_from_the_last_fix_before_to_the_first_after():
    log = made(legs=6)
    found = cut(log.track, RULES)
    np.testing.assert_allclose(found.legs["t_start_s"], log.starts)
    np.testing.assert_allclose(found.legs["t_end_s"], log.ends)
    assert (found.legs["ok"] == 1).all()
    assert (found.legs["lag_dr_end_s"] == 20.0).all()


@settings(max_examples=15, deadline=None)
@given(
    st.tuples(st.floats(-0.5, 0.5), st.floats(-0.5, 0.5)),
    st.floats(0.1, 2.5),
    st.integers(1, 12),
    st.sampled_from([1800.0, 3600.0, 7200.0]),
    st.sampled_from([5.0, 20.0, 60.0, 110.0]),
)
def test_the_error_of_a_leg_is_the_current(current, speed, legs, duration, step):
    log = made(legs=legs, current=current, speed=speed, duration=duration, step=step)
    found = cut(log.track, RULES)
    assert len(found.legs) == legs
    # the track was made on the plane about its beginning, which meridians that converge bend far from it
    far = np.hypot(*displacement(LATITUDE, LONGITUDE, found.legs["lat_end"], found.legs["lon_end"])).max()
    bent = np.tan(np.radians(LATITUDE)) * far * np.hypot(*current) / 6.371e6
    np.testing.assert_allclose(velocity_errors(found.legs).T, np.tile(current, (legs, 1)), atol=1e-4 + bent)


@settings(max_examples=10, deadline=None)
@given(st.tuples(st.floats(-0.3, 0.3), st.floats(-0.3, 0.3)), st.floats(0.15, 0.38))
def test_dead_reckoning_is_made_where_the_position_stands_still(current, speed):
    log = made(legs=5, current=current, speed=speed, reckoned=False)
    found = cut(log.track, RULES)
    assert "made from heading" in found.reckoning
    np.testing.assert_allclose(velocity_errors(found.legs).T, np.tile(current, (5, 1)), atol=0.03 * speed + 0.005)


def test_a_fix_that_every_row_repeats_until_the_next_is_taken_once():
    log = made(legs=6)
    true = log.track.fixes
    rows = log.track.depth.t
    last = np.searchsorted(true.t, rows, side="right") - 1
    held = fixes(rows, true.latitude[last], true.longitude[last])
    found = cut(replace(log.track, fixes=held), RULES)
    assert (found.legs["ok"] == 1).all()
    np.testing.assert_allclose(velocity_errors(found.legs).T, np.tile(log.current, (6, 1)), atol=2e-3)
    assert np.abs(found.legs["t_start_s"] - log.starts).max() <= 60.0  # copies above the depth of the surface


def test_a_yo_read_half_as_often_leads_to_the_same_place():
    ways = {}
    for step in (20.0, 40.0):
        log = made(legs=1, step=step, duration=4800.0, headings=[0.0], reckoned=False)
        t = log.track.depth.t
        phase = ((t - log.starts[0]) % 1200.0) / 1200.0  # four yos, each of which turns at a reading
        under = (t > log.starts[0]) & (t < log.ends[0])
        depth = np.where(under, 10.0 + 60.0 * (1.0 - np.abs(2.0 * phase - 1.0)), 0.0)
        pitch = np.degrees(np.arctan(0.1 / 0.3)) * np.where(phase < 0.5, -1.0, 1.0)
        legs = cut(replace(log.track, depth=series(t, depth), pitch=series(t, pitch)), RULES).legs
        places = (legs[name].iloc[0] for name in ("lat_start", "lon_start", "lat_dr_end", "lon_dr_end"))
        ways[step] = float(displacement(*places)[1])
    assert ways[20.0] == pytest.approx(0.3 * 4800.0, rel=0.03)
    assert ways[40.0] == pytest.approx(ways[20.0], rel=0.03)


def test_a_frozen_position_is_recognised():
    log = made(legs=5)
    frozen = np.searchsorted(log.starts, log.track.reckoned.t, side="right") - 1
    last = np.searchsorted(log.track.fixes.t, log.starts[np.maximum(frozen, 0)])
    under = log.track.depth.at(log.track.reckoned.t) > 0.0
    own = log.track.reckoned
    latitude = np.where(under, log.track.fixes.latitude[last], own.latitude)
    longitude = np.where(under, log.track.fixes.longitude[last], own.longitude)
    found = cut(replace(log.track, reckoned=positions(own.t, latitude, longitude)), RULES)
    assert any("stands still under water" in notice for notice in found.notices)
    np.testing.assert_allclose(velocity_errors(found.legs).T, np.tile(log.current, (5, 1)), atol=0.015)


def test_a_position_that_ignores_fixes_is_moved_to_each_fix():
    log = made(legs=8)
    own = log.track.reckoned
    # its own line goes on from the start, without any fix: what it has gathered of the current stays in
    drifted = np.stack([(own.t - START) * axis for axis in log.current])
    without_fixes = positions(own.t, *moved(own.latitude, own.longitude, *(-drifted)))
    on_the_way = np.searchsorted(log.starts, own.t, side="right") > 0
    found = cut(replace(log.track, reckoned=without_fixes), RULES)
    assert on_the_way.any()
    assert any("goes on across its fixes" in notice for notice in found.notices)
    # each leg's positions now differ from the fix by what the line gained within the leg alone
    gained = velocity_errors(found.legs).T - np.tile(log.current, (8, 1))
    np.testing.assert_allclose(gained, np.tile(log.current, (8, 1)), atol=0.01)


def test_the_vehicles_own_current_is_recognised_and_taken_out():
    rng = np.random.default_rng(3)
    log = made(legs=16, current=(0.0, 0.0))
    estimates = rng.normal(0.0, 0.05, (2, 16))
    own = log.track.reckoned
    leg = np.clip(np.searchsorted(log.starts, own.t, side="left") - 1, 0, None)
    elapsed = np.where(own.t > log.starts[leg], own.t - log.starts[leg], 0.0)
    elapsed = np.where(own.t > log.ends[leg], 0.0, elapsed)
    carried = positions(own.t, *moved(own.latitude, own.longitude, *(estimates[:, leg] * elapsed)))
    track = replace(
        log.track,
        reckoned=carried,
        current_east=series(log.starts - 30.0, estimates[0]),
        current_north=series(log.starts - 30.0, estimates[1]),
    )
    left_in, taken_out = cut(track, RULES), cut(track, LegRules(take_out_current=True))
    assert left_in.current.share == pytest.approx(1.0, abs=0.1)
    assert left_in.current.is_in
    np.testing.assert_allclose(velocity_errors(left_in.legs), -estimates, atol=0.003)
    np.testing.assert_allclose(velocity_errors(taken_out.legs), 0.0, atol=0.003)
    unused = cut(replace(track, reckoned=own), LegRules(take_out_current=True))
    assert not unused.current.is_in
    np.testing.assert_allclose(velocity_errors(unused.legs), 0.0, atol=0.003)


def test_a_flag_goes_before_a_count_and_neighbours_before_a_dilution():
    log = made(legs=4)
    good = log.track.fixes
    n, ninth = len(good), np.arange(len(good)) == 9
    counted = replace(good, valid=np.ones(n), satellites=np.zeros(n))
    assert not judge_fixes(counted).reasons
    flagged = replace(good, valid=np.where(ninth, 0.0, 1.0), satellites=np.full(n, 9.0))
    assert judge_fixes(flagged).reasons == ("not valid by its flag",)
    diluted = replace(good, hdop=np.where(ninth, 20.0, 1.0))
    assert not judge_fixes(diluted).reasons  # the fix a minute before confirms it
    later = np.where(np.arange(n) > 9, good.t + 600.0, good.t)
    assert not judge_fixes(replace(diluted, t=later + np.where(ninth, 30.0, 0.0))).reasons  # 90 s before, not 150 s
    alone = replace(diluted, t=later + np.where(ninth, 300.0, 0.0))
    assert judge_fixes(alone).reasons == ("dilution of precision above 8",)
    few = replace(good, satellites=np.where(ninth, 2.0, 9.0), latitude=good.latitude + np.where(ninth, 0.002, 0.0))
    assert judge_fixes(few).reasons == ("fewer than 4 satellites",)
    uncounted = replace(good, satellites=np.zeros(n))
    assert not judge_fixes(uncounted).reasons


def test_the_accuracy_of_a_fix_goes_with_its_leg():
    log = made(legs=4)
    last = np.isin(log.track.fixes.t, log.ends)
    accuracy = np.where(last, 20.0, 4.0)
    found = cut(replace(log.track, fixes=replace(log.track.fixes, accuracy=accuracy)), RULES)
    np.testing.assert_allclose(found.legs["fix_sd_m"], 20.0 / np.sqrt(2.0))


@settings(max_examples=25, deadline=None)
@given(st.integers(1, 38), st.floats(500.0, 50_000.0), st.floats(0.0, 6.28))
@example(8, 633.0, 0.0)  # the last of a surfacing, towards the next one
def test_a_wrong_fix_is_left_out(which, away, angle):
    log = made(legs=4)
    fixed = log.track.fixes
    which = which % (len(fixed) - 2) + 1
    latitude, longitude = fixed.latitude.copy(), fixed.longitude.copy()
    place = moved(latitude[which], longitude[which], away * np.sin(angle), away * np.cos(angle))
    latitude[which], longitude[which] = (float(each) for each in place)
    found = judge_fixes(fixes(fixed.t, latitude, longitude))
    gap = min(np.diff(fixed.t)[[which - 1, which]])
    if gap <= 60.0 and away > 1500.0:
        assert found.rejected.t.tolist() == [fixed.t[which]]
    assert set(found.rejected.t) <= {fixed.t[which]}


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (lambda log: {"breaks": (Break(log.starts[2] + 1000.0, "the clock jumps back (30 s)"),)}, "clock jumps back"),
        (
            lambda log: {"breaks": (Break(log.ends[1] + 1.0, "the clock jumps back", until=log.starts[2] + 1.0),)},
            "back",
        ),
        (lambda log: {"breaks": (Break(log.starts[2] + 1000.0, "a restart", at_surface_too=False),)}, "a restart"),
        (lambda log: {"depth": without(log.track.depth, log.starts[2] + 600.0, log.starts[2] + 1200.0)}, "a gap"),
        (lambda log: {"reckoned": jumping(log, 2)}, "jumps under water"),
        (lambda log: {"reckoned": cut_short(log, 2)}, "dead reckoning ends long before the fix"),
    ],
)
def test_a_spoilt_leg_is_left_out_with_the_reason(change, reason):
    log = made(legs=5)
    found = cut(replace(log.track, **change(log)), RULES)
    assert found.dives["ok"].tolist() == [1, 1, 0, 1, 1]
    assert reason in found.dives["reason"][2]


@pytest.mark.parametrize(("count", "more"), [(1, ""), (2, ", and 1 time more"), (3, ", and 2 times more")])
def test_clocks_that_jump_are_told_with_how_often_more(count, more):
    log = made(legs=3)
    jumps = tuple(Break(float(log.starts[k]) + 900.0, "the clock jumps back (30 s)") for k in range(count))
    quiet = Break(float(log.starts[0]) + 950.0, "a restart", at_surface_too=False)
    (told,) = of_the_clock(replace(log.track, breaks=(*jumps, quiet)))
    assert told == (
        f"the clock jumps back (30 s) to 2023-11-14T22:37:20.000Z{more}: times before or after are wrong by as much"
    )


def test_a_restart_at_the_surface_spoils_nothing():
    log = made(legs=5)
    at_surface = Break(float(log.ends[1]) + 100.0, "a restart", at_surface_too=False)
    assert (cut(replace(log.track, breaks=(at_surface,)), RULES).dives["ok"] == 1).all()


def test_short_legs_do_not_count_and_are_told():
    log = made(legs=3, duration=800.0)
    found = cut(log.track, LegRules(shortest=900.0))
    assert found.dives["reason"].tolist() == ["shorter than 15 min (13.3 min)"] * 3
    assert (cut(log.track, LegRules(shortest=600.0)).dives["ok"] == 1).all()


def test_short_is_what_is_short_for_the_plan_or_for_the_vehicle():
    log = made(legs=3, duration=800.0)
    assert (cut(log.track, RULES).dives["ok"] == 1).all()
    assert (cut(replace(log.track, planned=1200.0), RULES).dives["ok"] == 1).all()
    assert (cut(replace(log.track, planned=1800.0), RULES).dives["ok"] == 0).all()
    assert (cut(replace(log.track, shortest=1800.0), RULES).dives["ok"] == 0).all()


def test_a_fix_logged_late_ends_no_leg_and_is_told():
    log = made(legs=5)
    late = log.starts[2] + 300.0  # under water
    fixed = log.track.fixes
    before = int(np.searchsorted(fixed.t, log.starts[2]))
    shifted = fixed.t.copy()
    shifted[before] = late
    found = cut(replace(log.track, fixes=replace(fixed, t=shifted)), RULES)
    assert len(found.dives) == 5
    assert found.dives["t_start_s"][2] == late
    assert any("logged late on 1 of 5 dives" in notice for notice in found.notices)


@pytest.mark.parametrize(
    ("depths", "surfaced"),
    [
        ([0.0, 50.0, 0.0, 40.0, 80.0], 194.0),  # it came up at the third reading, and went down again
        ([0.0, 50.0, 60.0, None, 80.0], 400.0),  # in a hole, it is not known when
        ([0.0, 50.0, 0.0, 40.0, 60.0, None, 80.0], 600.0),  # the last of both
        ([0.0, 50.0, 60.0, None, 0.0, 80.0], 390.0),
        ([0.0, 0.0, 60.0, 70.0, 80.0], None),
    ],
)
def test_a_fix_logged_under_water_ends_the_dive_before_the_last_time_at_the_surface(depths, surfaced):
    rows = [(100.0 * k, each) for k, each in enumerate(depths) if each is not None]
    t, values = np.array(rows).T
    at = fixes(np.array([0.0, t[-1]]), np.full(2, LATITUDE), np.full(2, LONGITUDE))
    found = find_candidates(at, series(t, values), Depths(5.0, 3.0), 150.0)
    assert [(each.surfaced, each.reckoned_to) for each in found] == [(pytest.approx(surfaced),) * 2] * bool(surfaced)


def test_an_old_fix_is_one_of_both_its_latitude_and_its_longitude_logged_again_before_a_new_one():
    depth = series(np.arange(7) * 100.0, np.array([0.0, 50.0, 0.0, 0.0, 0.0, 50.0, 0.0]))
    moments = np.array([0.0, 200.0, 300.0, 400.0, 600.0])
    for latitudes, longitudes, again in (
        ([1.0, 1.0, 2.0, 2.0, 3.0], [5.0, 5.0, 6.0, 6.0, 7.0], [1]),
        ([1.0, 1.0, 2.0, 2.0, 3.0], [5.0, 5.1, 6.0, 6.0, 7.0], []),  # farther east
        ([1.0, 1.1, 2.0, 2.0, 3.0], [5.0, 5.0, 6.0, 6.0, 7.0], []),
        ([1.0, 1.0, 1.0, 1.0, 3.0], [5.0, 5.0, 5.0, 5.0, 7.0], []),  # it may have stayed in its place
    ):
        good = fixes(moments, np.array(latitudes), np.array(longitudes))
        assert np.flatnonzero(logged_again(good, depth, Depths(5.0, 3.0))).tolist() == again


def test_a_shallow_vehicles_dives_are_found():
    assert len(cut(made(legs=5, depth=2.0, with_attitude=False).track, RULES).legs) == 5


def test_without_depth_a_dive_is_a_time_without_fixes():
    log = made(legs=5)
    found = cut(replace(log.track, depth=Series()), RULES)
    dived = found.legs[found.legs["ok"] == 1]
    np.testing.assert_allclose(dived["t_start_s"], log.starts)
    assert (dived["surface_s"] == 0.0).all()


def test_time_at_the_surface_before_the_fix_is_told():
    log = made(legs=3)
    fixed = log.track.fixes
    t = np.where(np.isin(fixed.t, log.ends), fixed.t + 50.0, fixed.t)
    found = cut(replace(log.track, fixes=replace(fixed, t=t)), RULES)
    # it rises at 100 m in 30 min, and is at the surface above 3 m
    np.testing.assert_allclose(found.legs["surface_s"], 50.0 + 3.0 / (100.0 / 1800.0))


def without(depth, start, end):
    kept = (depth.t < start) | (depth.t > end)
    return Series(depth.t[kept], depth.values[kept])


def jumping(log, leg):
    own = log.track.reckoned
    after = (own.t > log.starts[leg] + 1800.0) & (own.t < log.ends[leg])
    return positions(own.t, np.where(after, own.latitude + 0.01, own.latitude), own.longitude)


def cut_short(log, leg):
    own = log.track.reckoned
    kept = (own.t < log.starts[leg] + 900.0) | (own.t >= log.ends[leg])
    return positions(own.t[kept], own.latitude[kept], own.longitude[kept])


def eastward(t, metres):
    """Positions on the equator, so many metres east of a meridian."""
    return positions(np.array(t), np.zeros(len(t)), 10.0 + np.degrees(np.array(metres) / 6_378_137.0))


@pytest.mark.parametrize(("metres", "told"), [(111.0, True), (109.0, False)])
def test_a_position_jumps_under_water_that_goes_fifty_metres_more_than_any_vehicle(metres, told):
    """Ten seconds at 6 m/s are 60 m."""
    said = _jump(eastward([0.0, 10.0, 20.0, 30.0], [0.0, 50.0, 50.0 + metres, 60.0 + metres]))
    assert said == (f"the dead-reckoned position jumps under water ({metres:.0f} m)" if told else "")
    assert _jump(eastward([0.0], [0.0])) == ""


def test_an_hour_without_a_reading_before_the_fix_is_told_from_whichever_was_read_last():
    track = Track(
        "a",
        "a",
        fixes([], [], []),
        depth=series(np.array([10.0, 130.0]), np.zeros(2)),
        reckoned=eastward([200.0], [0.0]),
    )
    assert _gap_at_surface(track, 100.0, 3801.0) == "nothing was logged before the fix (3601 s)"
    assert _gap_at_surface(track, 100.0, 3799.0) == ""
    assert _gap_at_surface(track, 300.0, 3901.0) == "nothing was logged before the fix (3601 s)"  # nothing since


def test_a_fix_is_confirmed_by_the_good_one_nearest_in_time_where_drift_brings_it():
    """Beside fixes at 0 and 1000 s: as far off as scatter and the drift of the time between have it, and no farther."""
    away = _ALLOWED + _DRIFT * 100.0
    t, metres = [0.0, 100.0, 100.5, 900.0, 1000.0], [0.0, away - 1.0, away + 2.0, 5000.0 - away + 1.0, 5000.0]
    given = eastward(t, metres)
    found = _confirmed(fixes(given.t, given.latitude, given.longitude), np.array([True, False, False, False, True]))
    assert found.tolist() == [True, True, False, True, True]


@pytest.mark.parametrize(("after", "is_old"), [(59.0, False), (60.0, True)])
def test_the_same_place_a_minute_later_is_no_new_fix_where_the_next_one_jumps(after, is_old):
    metres = [0.0, 0.0, 1000.0, 1000.5, 1001.0, 1001.5]
    given = eastward([0.0, after, *(after + np.arange(10.0, 50.0, 10.0))], metres)
    found = judge_fixes(fixes(given.t, given.latitude, given.longitude))
    assert (REPEATED in found.reasons) == is_old


def test_a_leg_has_the_declination_of_its_start():
    log = made(legs=3)
    growing = Series(START + np.array([0.0, 1e5]), np.array([0.0, 10.0]))
    found = cut(replace(log.track, declination=growing, heading_from="magnetic"), RULES)
    np.testing.assert_allclose(found.dives["declination_deg"], 1e-4 * (log.starts - START))
