"""Dead reckoning made from heading, pitch, depth or speed, against closed forms; the current that a vehicle's own holds."""

from dataclasses import replace

import numpy as np
import pytest
from made_tracks import made

from missionplan.importers.dives import Candidate
from missionplan.importers.geodesy import displacement, moved
from missionplan.importers.reckoning import (
    can_be_made,
    current_in_reckoning,
    made_doubt,
    made_reckoning,
    true_from_logged,
)
from missionplan.importers.track import Positions, Series, Track, fixes

LATITUDE, LONGITUDE = 48.0, -123.0
T = np.arange(0.0, 1001.0, 10.0)


def track(**channels):
    nothing = fixes(np.empty(0), np.empty(0), np.empty(0))
    return Track("made", "made", nothing, **{"heading_from": "true", **channels})


def even(value):
    return Series(T, np.full(T.shape, value))


def ends(found, **given):
    """East and north of the last place, and its time, of a reckoning from 100 s to 905 s."""
    line = made_reckoning(found, 100.0, 905.0, LATITUDE, LONGITUDE, **given)
    assert (line.t[0], line.t[-1]) == (100.0, 900.0)
    return np.array(displacement(LATITUDE, LONGITUDE, line.latitude[-1], line.longitude[-1]))


@pytest.mark.parametrize("heading", [0.0, 30.0, 120.0, 225.0, 359.0])
def test_way_is_speed_by_time_along_the_heading(heading):
    way = 1.3 * 800.0 * np.array([np.sin(np.radians(heading)), np.cos(np.radians(heading))])
    assert ends(track(heading=even(heading), speed=even(1.3))) == pytest.approx(way, abs=0.05)


def test_a_heading_that_turns_through_north_is_not_one_to_the_south():
    turning = Series(T, np.where(T % 20.0 == 0.0, 350.0, 10.0))
    assert ends(track(heading=turning, speed=even(1.0))) == pytest.approx([0.0, 800.0], abs=0.05)


def test_a_speed_that_grows_and_a_heading_that_turns_are_integrated():
    """At 2 mm/s² from 0.2 m/s on; and a quarter of a circle to starboard, as long as the way."""
    assert ends(track(heading=even(0.0), speed=Series(T, 0.002 * T))) == pytest.approx([0.0, 800.0], abs=0.05)
    turning = Series(T, 90.0 * (T - 100.0) / 800.0)
    radius = 800.0 / (0.5 * np.pi)
    assert ends(track(heading=turning, speed=even(1.0))) == pytest.approx([radius, radius], abs=0.05)


def test_declination_is_added_to_magnetic_headings_alone():
    logged = {"heading": even(80.0), "speed": even(1.0), "declination": even(10.0)}
    assert ends(track(**logged, heading_from="magnetic")) == pytest.approx([800.0, 0.0], abs=0.05)
    assert ends(track(**logged)) == pytest.approx(
        800.0 * np.array([np.sin(np.radians(80.0)), np.cos(np.radians(80.0))]), abs=0.05
    )
    assert true_from_logged(track(heading=even(80.0), heading_from="magnetic"), T) == pytest.approx(0.0 * T)


@pytest.mark.parametrize("nose", [1.0, -1.0])
def test_a_glide_is_the_depth_s_rate_over_the_tangent_of_the_path(nose):
    """0.15 m/s of depth at a pitch of 20°, and a path 3° steeper where the angle of attack is known; no way near the surface."""
    depth = Series(T, np.maximum(0.15 * (T if nose < 0.0 else T[-1] - T), 0.0) + 5.0)
    glide = track(heading=even(90.0), pitch=even(20.0 * nose), depth=depth)
    for attack in (0.0, 3.0):
        way = 800.0 * 0.15 / np.tan(np.radians(20.0 + attack))
        assert ends(glide, attack=attack) == pytest.approx([way, 0.0], abs=0.05)
    assert ends(replace(glide, depth=Series(T, depth.values * 0.01))) == pytest.approx([0.0, 0.0], abs=1e-6)
    fast = replace(glide, depth=Series(T, 10.0 * depth.values))
    assert ends(fast) == pytest.approx([1600.0, 0.0], abs=0.1)  # no glide is faster than 2 m/s


def test_between_glides_half_the_speed_is_kept_and_none_before_the_first():
    flat = (T >= 300.0) & (T <= 500.0)
    pitch = Series(T, np.where(flat | (T < 200.0), 0.0, -20.0))
    glide = track(heading=even(0.0), pitch=pitch, depth=Series(T, 0.15 * T + 5.0))
    middle = 105.0 + 10.0 * np.arange(80)
    slope = np.interp(middle, T, np.abs(pitch.values))
    steep = np.where(slope > 8.0, 0.15 / np.tan(np.radians(np.where(slope > 8.0, slope, 20.0))), np.nan)
    last, way = 0.0, 0.0
    for each in steep:
        last = last if np.isnan(each) else each
        way += 10.0 * (0.5 * last if np.isnan(each) else each)
    assert ends(glide) == pytest.approx([0.0, way], abs=0.05)


def test_the_doubt_of_a_reckoning_is_that_of_speed_or_attack_and_heading():
    found = track(heading=even(90.0), speed=even(1.0))
    line = made_reckoning(found, 100.0, 905.0, LATITUDE, LONGITUDE)
    assert made_doubt(found, line, 905.0) == pytest.approx(800.0 * np.hypot(0.05, 0.035), rel=1e-3)
    glide = track(heading=even(90.0), pitch=even(-20.0), depth=Series(T, 0.15 * T + 5.0))
    line = made_reckoning(glide, 100.0, 905.0, LATITUDE, LONGITUDE)
    ways = [800.0 * 0.15 / np.tan(np.radians(angle)) for angle in (20.0, 23.0)]
    assert made_doubt(glide, line, 905.0) == pytest.approx(np.hypot(ways[0] - ways[1], 0.035 * ways[0]), rel=1e-3)
    assert np.isnan(made_doubt(found, Positions(), 905.0))


def test_what_is_needed_for_a_reckoning():
    heading, pitch, depth, speed = even(0.0), even(20.0), even(5.0), even(1.0)
    assert can_be_made(track(heading=heading, speed=speed))
    assert can_be_made(track(heading=heading, pitch=pitch, depth=depth))
    for lacking in ({"speed": speed}, {"heading": heading, "pitch": pitch}, {"heading": heading, "depth": depth}):
        assert not can_be_made(track(**lacking))


@pytest.mark.parametrize("share", [0.0, 1.0])
def test_the_share_of_the_vehicle_s_current_in_its_reckoning_is_found_and_taken_out(share):
    """Estimates that change from leg to leg, in a reckoning that holds them or does not, turned by 2° and 3 % too long."""
    voyage = made(legs=12)
    rng = np.random.default_rng(4)
    estimates = rng.normal(0.0, 0.1, (2, 12))
    parts = []
    for start, end, (east, north) in zip(voyage.starts, voyage.ends, estimates.T, strict=True):
        plain = made_reckoning(voyage.track, start, end, LATITUDE, LONGITUDE)
        way = np.array(displacement(LATITUDE, LONGITUDE, plain.latitude, plain.longitude))
        turned = 1.03 * np.array([[np.cos(0.035), np.sin(0.035)], [-np.sin(0.035), np.cos(0.035)]]) @ way
        elapsed = plain.t - start
        carried = turned + share * np.array([east, north])[:, None] * elapsed
        parts.append(Positions(plain.t, *moved(LATITUDE, LONGITUDE, *carried)))
    logged = replace(
        voyage.track,
        current_east=Series(voyage.starts - 5.0, estimates[0]),
        current_north=Series(voyage.starts - 5.0, estimates[1]),
    )
    count = len(voyage.starts)
    t = np.sort(np.concatenate((voyage.starts, voyage.ends)))
    known = fixes(t, np.full(2 * count, LATITUDE), np.full(2 * count, LONGITUDE))
    candidates = [Candidate(2 * k, 2 * k + 1, 100.0, 0.0, voyage.ends[k], voyage.ends[k]) for k in range(count)]
    found = current_in_reckoning(logged, known, candidates, parts)
    assert found.share == pytest.approx(share, abs=0.01)
    assert found.is_in == (share == 1.0)
    assert (found.east, found.north) == (pytest.approx(estimates[0]), pytest.approx(estimates[1]))
    line = parts[3]
    taken = found.taken_out(line)
    off = np.array(displacement(line.latitude, line.longitude, taken.latitude, taken.longitude))
    assert off == pytest.approx(-share * estimates[:, 3:4] * (line.t - voyage.starts[3]), abs=0.5)
    assert current_in_reckoning(voyage.track, known, candidates, parts) is None


def test_an_estimate_of_the_current_is_in_use_for_a_day():
    voyage = made(legs=2)
    logged = Series(voyage.starts[:1] - 86_399.0, np.array([0.2]))
    t = np.sort(np.concatenate((voyage.starts, voyage.ends)))
    known = fixes(t, np.full(4, LATITUDE), np.full(4, LONGITUDE))
    dives = [Candidate(2 * k, 2 * k + 1, 100.0, 0.0, voyage.ends[k], voyage.ends[k]) for k in range(2)]
    of = replace(voyage.track, current_east=logged, current_north=logged)
    assert current_in_reckoning(of, known, dives, [Positions(), Positions()]).east.tolist() == [0.2, 0.0]
