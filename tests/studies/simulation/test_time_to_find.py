"""How long a boat searches by the sheet, and by an expanding square from the last fix.

A thousand losses drift by the published equations (Allen & Plourde 1999; Breivik & Allen 2008), carried by code of this
test. Both boats leave the last fix an hour after the hour to worry, go at the same speed, and see what comes within half
the sweep width. What is not found within a day counts as a day.
"""

import numpy as np
import pytest

import missionplan
from missionplan.mission import Mission
from missionplan.results.whereabouts import AFLOAT

pytestmark = pytest.mark.usefixtures("unplanned", "unranked", "unheld")

SPEED, WIDTH = 5.0, 200.0
"""Of the boat [m/s], and its sweep width for a low torpedo [m]."""
BEGUN, STEP, LASTING = 3600.0, 20.0, 86_400.0
"""When the search begins after the hour to worry, its step and the most that it lasts [s]."""
LOSSES = 1000
MISSION = {
    "name": "Out and not back",
    "start": "2026-06-01T08:00Z",
    "site": {"origin": {"latitude": "37.25 deg", "longitude": "-76.38 deg"}, "depth": "30 m"},
    "navigation": {"velocity_error": {"sigma": "0.02 m/s"}, "surfacing_time": "60 s"},
    "phases": [
        {
            "transit": {
                "from": ["0 m", "0 m"],
                "to": ["800 m", "0 m"],
                "depth": "2 m",
                "speed": "1.5 m/s",
                "d_max": "300 m",
                "arrival_radius": "150 m",
            }
        }
    ],
    "monte_carlo": {"trials": 3000, "seed": 1},
}


def lost(rng, begun, times, current, wind, tide):
    """Places of the losses at times since the mission's start, shape (2, losses, times), each from its last fix on."""
    blow, course = rng.normal(*wind, LOSSES), np.radians(20.0 + rng.normal(0.0, 25.0, LOSSES))
    down = 0.0107 * blow + 0.0447 + rng.normal(0.0, 0.054, LOSSES)
    right = rng.choice([-1.0, 1.0], LOSSES) * 0.0041 * blow + rng.normal(0.0, 0.054, LOSSES)
    water, toward = rng.normal(*current, LOSSES), np.radians(60.0)
    velocity = np.stack(
        (
            water * np.sin(toward) + down * np.sin(course) + right * np.cos(course),
            water * np.cos(toward) + down * np.cos(course) - right * np.sin(course),
        )
    )
    fix = np.stack((rng.uniform(0.0, 800.0, LOSSES), np.zeros(LOSSES)))
    clock = begun * rng.random(LOSSES)
    places = fix[..., None] + velocity[..., None] * (times - clock[:, None])
    turn = 2.0 * np.pi / 44_714.16
    places[1] += tide / turn * (np.sin(turn * times) - np.sin(turn * clock[:, None]))
    return fix, places


def square(count):
    """Corners of an expanding square about the origin: legs of one sweep width, one, two, two, three …, shape (2, k)."""
    lengths = np.repeat(np.arange(1, count), 2) * WIDTH
    turns = 1j ** np.arange(lengths.size)
    corners = np.concatenate(([0.0], np.cumsum(lengths * turns)))
    return np.stack((corners.real, corners.imag))


def along(corners, run):
    """Places on a track after so many metres, shape (2, k)."""
    legs = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(corners)))))
    return np.stack([np.interp(run, legs, axis) for axis in corners])


def found_after(boat, places):
    """Time of each loss until the boat, shape (2, k) or (2, losses, k), comes near it [s]."""
    boat = boat if boat.ndim == 3 else boat[:, None]
    near = np.hypot(*(places - boat)) <= 0.5 * WIDTH
    return np.where(near.any(axis=1), near.argmax(axis=1) * STEP, LASTING)


SEAS = (
    ((0.2, 0.08), (5.0, 1.5), 0.0),
    ((0.2, 0.08), (12.0, 2.0), 0.0),
    ((0.1, 0.05), (6.0, 1.5), 0.15),
)
"""Mean and standard deviation of the current and of the wind, and amplitude of the tide [m/s]."""


def times_to_find(current, wind, tide):
    """Time of each loss until it is found by the sheet, and from the last fix [s]."""
    speed = {"mean": f"{current[0]} m/s", "sd": f"{current[1]} m/s"}
    blows = {"speed": {"mean": f"{wind[0]} m/s", "sd": f"{wind[1]} m/s"}, "from": {"mean": "200 deg", "sd": "25 deg"}}
    site = {**MISSION["site"], "current": [{"down_to": "30 m", "speed": speed, "toward": "60 deg"}], "wind": blows}
    data = {**MISSION, "site": site, "effects": [{"tidal-current": {"m2_north": f"{tide} m/s"}}] if tide else []}
    sheet = missionplan.simulate(Mission.from_data(data)).overdue
    ran = np.arange(0.0, LASTING, STEP)
    times = sheet.worry_after + BEGUN + ran
    fix, places = lost(np.random.default_rng(12), sheet.worry_after, times, current, wind, tide)
    legs = along(square(120), SPEED * ran)
    from_fix = found_after(fix[..., None] + legs[:, None], places)
    begin = moving_place(sheet, ran)
    way = np.hypot(*(begin[:, 0][:, None] - fix)) / SPEED  # from the last fix to where the sheet says to begin
    late = np.maximum(ran - way[:, None], 0.0)
    legs = np.stack([np.interp(SPEED * late, SPEED * ran, axis) for axis in legs])
    boat = np.where(ran < way[:, None], np.inf, begin[:, None] + legs)
    return found_after(boat, places), from_fix


def moving_place(sheet, ran):
    """Where the sheet says to begin, from hour to hour; after the last area as before it, shape (2, k)."""
    areas = [area for area in sheet.areas if area.way == AFLOAT and area.share == 0.5 and area.overdue >= BEGUN]
    hours = np.array([area.overdue for area in areas]) - BEGUN
    places = np.array([[area.densest_east, area.densest_north] for area in areas]).T
    rate = (places[:, -1] - places[:, -2]) / (hours[-1] - hours[-2])
    places = np.append(places, places[:, -1:] + rate[:, None] * LASTING, axis=1)
    return np.stack([np.interp(ran, np.append(hours, hours[-1] + LASTING), axis) for axis in places])


@pytest.mark.parametrize(
    ("current", "wind", "tide"), [*(pytest.param(*sea, marks=pytest.mark.slow) for sea in SEAS[:-1]), SEAS[-1]]
)
def test_the_sheet_finds_sooner_than_an_expanding_square_from_the_last_fix(current, wind, tide):
    by_sheet, from_fix = times_to_find(current, wind, tide)
    assert by_sheet.mean() <= 0.7 * from_fix.mean()
    assert np.mean(by_sheet < LASTING) > np.mean(from_fix < LASTING)
