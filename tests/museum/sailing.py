"""Legs of a vehicle whose course, speed and water are what a recipe says, integrated in short steps."""

import csv
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import yaml
from numpy.typing import NDArray

Array = NDArray[np.float64]
STEPS = 20
"""Steps of a leg."""


@dataclass(frozen=True)
class Moment:
    """A step of a leg: time and time since the leg's fix [s], heading steered [rad], speed reckoned [m/s], depth [m]."""

    t: float
    since: float
    heading: float
    speed: float
    depth: float
    place: Array


@dataclass(frozen=True)
class Recipe:
    """What the vehicle does that its reckoning does not know; all neutral by default.

    Attributes
    ----------
    turn : callable
        Angle of the true course clockwise of the one steered [rad].
    pace : callable
        Factor on the speed reckoned.
    water : callable
        Velocity of the water, east and north [m/s].
    along : float
        What the vehicle answers to the water's velocity along its course, of what it answers across.
    """

    turn: Callable[[Moment], float] = lambda m: 0.0
    pace: Callable[[Moment], float] = lambda m: 1.0
    water: Callable[[Moment], Array] = lambda m: np.zeros(2)
    along: float = 1.0


@dataclass(frozen=True)
class Log:
    """Where and when a vehicle goes: headings [rad], times under way [s], speeds [m/s] and depths [m] of its legs."""

    headings: Array
    under_way: Array
    speeds: Array
    depths: Array
    sigma: float = 0.02
    fix: float = 3.0
    surface: float = 60.0


def drawn(rng: np.random.Generator, count: int) -> Log:
    """Draw a log all round the compass, of one speed or of several, of one depth or of several."""
    under_way = rng.uniform(400.0, 1200.0) * rng.uniform(0.6, 1.4, count)
    speed = rng.uniform(1.0, 1.8)
    speeds = speed * (rng.choice([0.7, 1.0, 1.3], count) if rng.random() < 0.4 else np.ones(count))
    depths = rng.uniform(5.0, 150.0, count) if rng.random() < 0.4 else np.full(count, 20.0)
    return Log(rng.uniform(0.0, 2.0 * np.pi, count), under_way, speeds, depths)


def velocity_errors(log: Log, recipe: Recipe) -> Array:
    """Velocity error of each leg without any noise, shape (n, 2) [m/s]."""
    place, t, found = np.zeros(2), 0.0, []
    for heading, time, speed, depth in zip(log.headings, log.under_way, log.speeds, log.depths, strict=True):
        begun = place.copy()
        for step in range(STEPS):
            since = (step + 0.5) * time / STEPS
            moment = Moment(t + since, since, float(heading), float(speed), float(depth), place)
            course = heading + recipe.turn(moment)
            water, ahead = recipe.water(moment), np.array([np.sin(heading), np.cos(heading)])
            water = water + (recipe.along - 1.0) * float(water @ ahead) * ahead
            through = speed * recipe.pace(moment) * np.array([np.sin(course), np.cos(course)])
            place = place + time / STEPS * (through + water)
        reckoned = speed * time * np.array([np.sin(heading), np.cos(heading)])
        found.append((place - begun - reckoned) / time)
        t += time + log.surface
    return np.array(found)


def write(folder: Path, log: Log, errors: Array, rng: np.random.Generator) -> Path:
    """Write a log with noise as a data set."""
    folder.mkdir(parents=True, exist_ok=True)
    place, t, rows = np.zeros(2), 0.0, []
    for leg, (heading, time, speed) in enumerate(zip(log.headings, log.under_way, log.speeds, strict=True)):
        fix = place + log.fix * rng.standard_normal(2)
        through = speed * time * np.array([np.sin(heading), np.cos(heading)])
        place = place + through + time * (errors[leg] + log.sigma * rng.standard_normal(2))
        after = place + log.fix * rng.standard_normal(2)
        rows.append([t, t + time, *fix, *(fix + through), *after, log.depths[leg]])
        t += time + log.surface
    names = ["t_start_s", "t_end_s", "x_start_m", "y_start_m", "x_dr_m", "y_dr_m", "x_end_m", "y_end_m", "depth_m"]
    with (folder / "legs.csv").open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["leg", *names])
        writer.writerows([number, *(f"{value:.3f}" for value in row)] for number, row in enumerate(rows, start=1))
    data = {"kind": "transit", "name": "Legs", "file": "legs.csv", "noise": {"fix": f"{log.fix:g} m"}, "source": "made"}
    (folder / "dataset.yaml").write_text(yaml.safe_dump(data))
    return folder


def mission(log: Log, current: Array | None = None) -> dict[str, object]:
    """Return the mission of a vehicle that knows nothing of its fault, and of a current if one is given."""
    leg = float(np.median(log.speeds * log.under_way))
    site: dict[str, object] = {"origin": {"latitude": "50 deg", "longitude": "0 deg"}}
    if current is not None:
        toward = float(np.degrees(np.arctan2(*current))) % 360.0
        site["current"] = {"speed": f"{float(np.hypot(*current)):.4f} m/s", "toward": f"{toward:.2f} deg"}
    transit = {
        "name": "way",
        "from": ["0 m", "0 m"],
        "to": [f"{8 * leg:.0f} m", "0 m"],
        "speed": f"{float(np.median(log.speeds)):.3f} m/s",
        "d_max": f"{leg:.0f} m",
        "arrival_radius": f"{0.1 * leg:.0f} m",
    }
    return {
        "name": "museum",
        "site": site,
        "navigation": {
            "velocity_error": {"sigma": f"{log.sigma} m/s"},
            "surfacing_time": f"{log.surface:.0f} s",
            "fix_error": f"{log.fix:g} m",
        },
        "phases": [{"transit": transit}],
        "monte_carlo": {"trials": 500, "seed": 1},
    }
