"""Voyages of a vehicle that does not know what moves it: legs stepped through time, and their files.

Nothing of the package is used. Each leg is integrated in short steps: the water's velocity at the time, a heading that
the compass has wrong, a speed that its calibration has wrong, and random velocities.
"""

import csv
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import yaml
from numpy.typing import NDArray

Array = NDArray[np.float64]
STEPS = 24
"""Steps of a leg."""
SIDEREAL_DAY = 86164.0905


@dataclass(frozen=True)
class Truth:
    """What moves the vehicle beside what it knows.

    Attributes
    ----------
    names : tuple of str
        Effects of the catalogue that are there; empty for none, or for something outside it.
    current : callable
        Velocity of the water (east, north) of time and place [m/s].
    turn : callable
        Angle of the true heading clockwise of the compass's, of time and heading [rad].
    pace : callable
        Factor on the speed, of time and of the time since the leg began.
    wander : callable
        Random velocity of the steps of a voyage, from a generator and their times, shape (2, n) [m/s].
    onward : callable
        Random velocities of many vehicles, shape (2, n), from a generator, those of a time before, or None at the
        beginning, and the time since, shape (n,) [m/s, s].
    fix_sd : float
        Error of a fix beyond what is stated [m].
    stretch : callable
        Factors on the legs' own errors, of a generator and the number of legs.
    parameters : mapping
        True values, by ``effect.parameter``; of an oscillation also its cosine's and its sine's.
    outside : str
        What it is, where the catalogue has no such effect.
    """

    names: tuple[str, ...] = ()
    current: tuple[Callable[[float, Array], Array], ...] = ()
    turn: Callable[[float, float], float] = lambda t, heading: 0.0
    pace: Callable[[float, float], float] = lambda t, since: 1.0
    wander: Callable[[np.random.Generator, Array], Array] | None = None
    onward: Callable[[np.random.Generator, Array | None, Array], Array] | None = None
    fix_sd: float = 0.0
    stretch: Callable[[np.random.Generator, int], Array] | None = None
    parameters: dict[str, float] = field(default_factory=dict)
    outside: str = ""


@dataclass(frozen=True)
class Voyage:
    """Where and when a vehicle goes.

    Attributes
    ----------
    headings : array, shape (n,)
        Of the legs, as the compass has them [rad].
    under_way : float or array, shape (n,)
        Time of a leg [s].
    surface : float
        Time at the surface after it [s].
    speed : float or array, shape (n,)
        Through the water [m/s].
    sigma, fix : float
        Each leg's own velocity error, each axis [m/s]; a fix's error [m].
    latitude : float
        Of the first fix [deg].
    begins : float
        Time of the first fix [s].
    """

    headings: Array
    under_way: float | Array = 900.0
    surface: float = 60.0
    speed: float | Array = 1.2
    sigma: float = 0.02
    fix: float = 3.0
    latitude: float = 55.0
    begins: float = 0.0


def sail(voyage: Voyage, truth: Truth, rng: np.random.Generator) -> list[list[float]]:
    """Return the rows of the log: leg, times, and places of fix, reckoning and fix."""
    count, place, t = len(voyage.headings), np.zeros(2), voyage.begins
    under_way, speeds = (np.broadcast_to(each, count) for each in (voyage.under_way, voyage.speed))
    begins = voyage.begins + np.cumsum(under_way + voyage.surface) - under_way - voyage.surface
    own = voyage.sigma * rng.standard_normal((count, 2))
    if truth.stretch is not None:
        own *= truth.stretch(rng, count)[:, None]
    times = (begins[:, None] + np.outer(under_way / STEPS, np.arange(STEPS) + 0.5)).ravel()
    wandering = truth.wander(rng, times) if truth.wander is not None else np.zeros((2, times.size))
    sd, rows = float(np.hypot(voyage.fix, truth.fix_sd)), []
    fix = place + sd * rng.standard_normal(2)
    for leg, (heading, speed) in enumerate(zip(voyage.headings, speeds, strict=True)):
        begun, start, reckoned, step = t, fix.copy(), fix.copy(), under_way[leg] / STEPS
        for k in range(STEPS):
            now = begun + (k + 0.5) * step
            actual = heading + truth.turn(now, float(heading))
            through = speed * truth.pace(now, now - begun) * np.array([np.sin(actual), np.cos(actual)])
            water = sum((flow(now, place) for flow in truth.current), np.zeros(2))
            place = place + step * (through + water + own[leg] + wandering[:, leg * STEPS + k])
        reckoned += speed * under_way[leg] * np.array([np.sin(heading), np.cos(heading)])
        fix = place + sd * rng.standard_normal(2)
        t = begun + under_way[leg]
        rows.append([leg + 1, begun, t, *start, *reckoned, *fix])
        water = sum((flow(t, place) for flow in truth.current), np.zeros(2))
        place = place + voyage.surface * water
        t += voyage.surface
        fix = place + sd * rng.standard_normal(2)
    return rows


def write(folder: Path, rows: list[list[float]], fix: float) -> Path:
    """Write a log as a data set."""
    folder.mkdir(parents=True, exist_ok=True)
    names = ["leg", "t_start_s", "t_end_s", "x_start_m", "y_start_m", "x_dr_m", "y_dr_m", "x_end_m", "y_end_m"]
    with (folder / "legs.csv").open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(names)
        writer.writerows([row[0], *(f"{value:.3f}" for value in row[1:])] for row in rows)
    data = {
        "kind": "transit",
        "name": "A voyage",
        "file": "legs.csv",
        "noise": {"fix": f"{fix:g} m"},
        "source": "made up",
    }
    (folder / "dataset.yaml").write_text(yaml.safe_dump(data))
    return folder


def mission(voyage: Voyage, stated_sigma: float | None = None) -> dict[str, object]:
    """Return the mission of a vehicle that knows nothing of what moves it."""
    leg = voyage.speed * voyage.under_way
    return {
        "name": "voyage",
        "site": {"origin": {"latitude": f"{voyage.latitude} deg", "longitude": "0 deg"}},
        "navigation": {
            "velocity_error": {"sigma": f"{stated_sigma or voyage.sigma:.4f} m/s"},
            "surfacing_time": f"{voyage.surface:.0f} s",
            "fix_error": f"{voyage.fix:g} m",
        },
        "phases": [
            {
                "transit": {
                    "name": "way",
                    "from": ["0 m", "0 m"],
                    "to": [f"{8 * leg:.0f} m", "0 m"],
                    "speed": f"{voyage.speed:g} m/s",
                    "d_max": f"{leg:.0f} m",
                    "arrival_radius": f"{0.1 * leg:.0f} m",
                }
            }
        ],
        "monte_carlo": {"trials": 500, "seed": 1},
    }


def tide(
    amplitude: float, rng: np.random.Generator, period: float = 12.4206012 * 3600.0
) -> Callable[[float, Array], Array]:
    """An ellipse of a size, anyhow oriented, at any phase [m/s]."""
    tilt, phase, shape = rng.uniform(0.0, np.pi), rng.uniform(0.0, 2.0 * np.pi), rng.uniform(-0.5, 0.5)
    major = amplitude * np.array([np.sin(tilt), np.cos(tilt)])
    minor = shape * amplitude * np.array([np.cos(tilt), -np.sin(tilt)])

    def velocity(t: float, place: Array) -> Array:
        angle = 2.0 * np.pi * t / period + phase
        return np.asarray(major * np.cos(angle) + minor * np.sin(angle))

    return velocity
