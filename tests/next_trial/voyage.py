"""What a mission costs at the made-up sea, by code of its own: legs from fix to fix until the goal is near enough."""

from dataclasses import dataclass

import numpy as np

from .sea import NUISANCE_ANGLE, NUISANCE_CURRENT, NUISANCE_PACE, Array, Truth, Vehicle

MOST_LEGS = 400


@dataclass(frozen=True)
class Voyage:
    """There and back: distance [m], radius of arrival [m], and time of a surfacing [s]."""

    distance: float
    radius: float
    surfacing: float


def mean_minutes(
    truth: Truth, vehicle: Vehicle, voyage: Voyage, d_max: float, trials: int, rng: np.random.Generator
) -> float:
    """Return the mean time there and back with legs of at most `d_max` [min]."""
    angle = truth.compass + NUISANCE_ANGLE * rng.standard_normal(trials)
    pace = 1.0 + truth.pace + NUISANCE_PACE * rng.standard_normal(trials)
    water = np.array(truth.current)[:, None] + NUISANCE_CURRENT * rng.standard_normal((2, trials))
    here, clock = np.zeros((2, trials)), np.zeros(trials)
    for goal in (np.array([[0.0], [voyage.distance]]), np.zeros((2, 1))):
        under_way = np.ones(trials, dtype=bool)
        for _ in range(MOST_LEGS):
            fix = here + vehicle.fix * rng.standard_normal((2, trials))
            error = vehicle.sigma * rng.standard_normal((2, trials))
            left = goal - fix
            length = np.minimum(np.hypot(*left), d_max)
            time = length / vehicle.speed
            course = np.arctan2(left[0], left[1]) + angle
            through = vehicle.speed * pace * np.stack([np.sin(course), np.cos(course)])
            here = here + np.where(under_way, (through + water + error) * time, 0.0)
            clock += np.where(under_way, time + voyage.surfacing, 0.0)
            seen = here + vehicle.fix * rng.standard_normal((2, trials))
            under_way &= np.hypot(*(goal - seen)) > voyage.radius
            if not under_way.any():
                break
    return float(clock.mean() / 60.0)


def first_log_headings(pattern: str, count: int) -> Array:
    """Headings of a log [rad]: one way, there and back, or a corner."""
    turn = {"one way": 0.0, "there and back": np.pi, "corner": 0.5 * np.pi}[pattern]
    return np.asarray(np.where(np.arange(count) % 2, turn, 0.0))
