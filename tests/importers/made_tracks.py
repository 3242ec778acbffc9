"""A made glider's track, of which everything is known."""

from dataclasses import dataclass

import numpy as np

from missionplan.importers.geodesy import moved
from missionplan.importers.track import Track, fixes, positions, series

LATITUDE, LONGITUDE = 48.0, -123.0
START = 1_700_000_000.0


@dataclass(frozen=True)
class Made:
    """A track, with the true velocity error and the times and ends of each leg."""

    track: Track
    starts: np.ndarray
    ends: np.ndarray
    current: np.ndarray


def made(
    legs=10, *, current=(0.1, -0.05), speed=0.3, duration=3600.0, pause=600.0, step=20.0, headings=None, depth=100.0,
    reckoned=True, with_attitude=True, **given,
):  # fmt: skip
    """Yo after yo in a constant current: at the surface the vehicle takes a fix a minute and drifts, under water it
    reckons from its last fix.
    """
    headings = np.radians(np.linspace(0.0, 300.0, legs) if headings is None else headings)
    current = np.array(current)
    place, t = np.zeros(2), START
    fix_t, fix_place, own_t, own_place, depth_t, depths, turn, nose = [], [], [], [], [], [], [], []
    starts, ends = [], []
    for k in range(legs):
        for _ in range(int(pause // 60)):
            fix_t.append(t), fix_place.append(place.copy()), depth_t.append(t), depths.append(0.0)
            turn.append(headings[k]), nose.append(0.0)
            own_t.append(t), own_place.append(place.copy())
            place, t = place + current * 60.0, t + 60.0
        starts.append(fix_t[-1])
        begin, reckon, t = fix_place[-1], fix_place[-1].copy(), fix_t[-1]
        steps = int(duration // step)
        for j in range(1, steps):
            now = t + j * step
            share = j / steps
            own = reckon + speed * step * j * np.array([np.sin(headings[k]), np.cos(headings[k])])
            own_t.append(now), own_place.append(own)
            depth_t.append(now), depths.append(depth * (1.0 - abs(2.0 * share - 1.0)))
            turn.append(headings[k])
            nose.append(np.degrees(np.arctan(2.0 * depth / duration / speed)) * (1.0 if share >= 0.5 else -1.0))
        t += duration
        way = speed * (steps - 1) * step
        place = begin + way * np.array([np.sin(headings[k]), np.cos(headings[k])]) + current * duration
        ends.append(t)
    fix_t.append(t), fix_place.append(place), depth_t.append(t), depths.append(0.0), turn.append(0.0), nose.append(0.0)
    lat, lon = moved(LATITUDE, LONGITUDE, *np.array(fix_place).T)
    own_lat, own_lon = moved(LATITUDE, LONGITUDE, *np.array(own_place).T)
    channels = {
        "fixes": fixes(np.array(fix_t), lat, lon, hdop=np.full(len(fix_t), 1.0)),
        "depth": series(np.array(depth_t), np.array(depths)),
    }
    if reckoned:
        channels["reckoned"] = positions(np.array(own_t), own_lat, own_lon)
        channels["reckoning"] = "made up"
    if with_attitude:
        channels["heading"] = series(np.array(depth_t), np.degrees(np.array(turn)) % 360.0)
        channels["pitch"] = series(np.array(depth_t), np.array(nose))
    track = Track("made", "made", **{**channels, "heading_from": "true", **given})
    return Made(track, np.array(starts), np.array(ends), current)
