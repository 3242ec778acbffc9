"""A made-up sea for a vehicle whose compass, log and water may be off; it imports nothing of the package.

Legs are sailed in steps of a minute. Every record has nuisances of its own: a slight current, a compass and a log that
differ a little from what they usually are.
"""

import csv
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import yaml
from numpy.typing import NDArray

Array = NDArray[np.float64]
MINUTE, PAUSE = 60.0, 60.0
NUISANCE_ANGLE, NUISANCE_PACE, NUISANCE_CURRENT = np.radians(0.15), 0.002, 0.004


@dataclass(frozen=True)
class Truth:
    """What is off: compass [rad], log (relative), and the water's velocity east and north [m/s]."""

    compass: float = 0.0
    pace: float = 0.0
    current: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True)
class Vehicle:
    """Speed [m/s], standard deviation of a leg's velocity error [m/s] and of a fix [m], each axis."""

    speed: float = 1.1
    sigma: float = 0.03
    fix: float = 3.0


def sail(
    truth: Truth, vehicle: Vehicle, headings: Array, lengths: Array, begin: float, rng: np.random.Generator
) -> list[list[str]]:
    """Sail legs on headings [rad from north] of given lengths [m] from a time on [s]: the rows of a log."""
    angle = truth.compass + NUISANCE_ANGLE * rng.standard_normal()
    pace = truth.pace + NUISANCE_PACE * rng.standard_normal()
    water = np.array(truth.current) + NUISANCE_CURRENT * rng.standard_normal(2)
    here, clock, rows = np.zeros(2), begin, []
    for number, (heading, length) in enumerate(zip(headings, lengths, strict=True)):
        start = here + vehicle.fix * rng.standard_normal(2)
        reckoned, clock_start = start.copy(), clock
        error = vehicle.sigma * rng.standard_normal(2)
        left = length / vehicle.speed
        while left > 0.0:
            step = min(MINUTE, left)
            through = vehicle.speed * step * np.array([np.sin(heading), np.cos(heading)])
            course = heading + angle
            here = here + (1.0 + pace) * vehicle.speed * step * np.array([np.sin(course), np.cos(course)])
            here = here + (water + error) * step
            reckoned, clock, left = reckoned + through, clock + step, left - step
        end = here + vehicle.fix * rng.standard_normal(2)
        places = [f"{value:.3f}" for point in (start, reckoned, end) for value in point]
        rows.append([str(number + 1), f"{clock_start:.1f}", f"{clock:.1f}", *places])
        clock += PAUSE
    return rows


HEADER = ["leg", "t_start_s", "t_end_s", "x_start_m", "y_start_m", "x_dr_m", "y_dr_m", "x_end_m", "y_end_m"]


def write_log(folder: Path, vehicle: Vehicle, rows: Sequence[Sequence[str]], runs: Sequence[int] | None = None) -> Path:
    """Write a data set of kind ``transit``; `runs` are the numbers of the legs' runs, by default one run."""
    folder.mkdir(parents=True, exist_ok=True)
    told = {
        "kind": "transit",
        "name": "Legs at a made-up sea",
        "file": "legs.csv",
        "source": "made up",
        "noise": {"fix": f"{vehicle.fix} m"},
    }
    (folder / "dataset.yaml").write_text(yaml.safe_dump(told), encoding="utf-8")
    with (folder / "legs.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow([*HEADER, "run"] if runs is not None else HEADER)
        for number, row in enumerate(rows):
            writer.writerow([str(number + 1), *row[1:], *([str(runs[number])] if runs is not None else [])])
    return folder


def mission(
    vehicle: Vehicle, distance: float = 3000.0, d_max: float = 800.0, surfacing: float = 60.0, radius: float = 60.0
) -> dict[str, object]:
    """Return a mission there and back that does not know what is off."""
    out = {
        "name": "out",
        "from": ["0 m", "0 m"],
        "to": ["0 m", f"{distance} m"],
        "speed": f"{vehicle.speed} m/s",
        "d_max": f"{d_max} m",
        "arrival_radius": f"{radius} m",
    }
    back = {key: value for key, value in out.items() if key != "from"} | {"name": "back", "to": ["0 m", "0 m"]}
    return {
        "name": "There and back",
        "site": {"origin": {"latitude": "37 deg", "longitude": "-76 deg"}},
        "navigation": {
            "velocity_error": {"sigma": f"{vehicle.sigma} m/s"},
            "surfacing_time": f"{surfacing} s",
            "fix_error": f"{vehicle.fix} m",
        },
        "phases": [{"transit": out}, {"transit": back}],
        "monte_carlo": {"trials": 1000, "seed": 1},
    }
