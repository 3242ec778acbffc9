"""What a mission costs at the made-up sea, by code of its own: legs from fix to fix until the goal is near enough.

Currents are those at the run depth, as the catalogue has them: the surface lies still.
"""

from dataclasses import dataclass, replace

import numpy as np

from tests.calibration.voyages import Truth

from .sea import NUISANCE_ANGLE, NUISANCE_CURRENT, NUISANCE_PACE, Array, Vehicle

MOST_LEGS, PARTS = 400, 4
"""Legs after which a way has failed; parts of a leg, at whose middles velocities are taken."""


@dataclass(frozen=True)
class Voyage:
    """There and back: distance [m], radius of arrival [m], and time of a surfacing [s]."""

    distance: float
    radius: float
    surfacing: float


def on_a_day(truth: Truth, rng: np.random.Generator, *vehicles: int) -> Truth:
    """Return a truth with the little by which compass, log and current differ from record to record."""
    angle = NUISANCE_ANGLE * rng.standard_normal(vehicles)
    pace = NUISANCE_PACE * rng.standard_normal(vehicles)
    water = NUISANCE_CURRENT * rng.standard_normal((2, *vehicles))
    return replace(
        truth,
        turn=lambda t, heading: truth.turn(t, heading) + angle,
        pace=lambda t, since: truth.pace(t, since) + pace,
        current=(*truth.current, lambda t, place: water),
    )


def mean_loss(
    truth: Truth, vehicle: Vehicle, voyage: Voyage, d_max: float, trials: int, failure: float, rng: np.random.Generator
) -> float:
    """Return the mean time there and back with legs of at most `d_max`, or `failure` where it does not end [min]."""
    today = on_a_day(truth, rng, trials)
    here, clock, wandering = np.zeros((2, trials)), np.zeros(trials), np.zeros((2, trials))
    if today.onward is not None:
        wandering = today.onward(rng, None, np.zeros(trials))
    sd, arrived = float(np.hypot(vehicle.fix, today.fix_sd)), np.ones(trials, dtype=bool)
    fix = here + sd * rng.standard_normal((2, trials))
    for goal in (np.array([[0.0], [voyage.distance]]), np.zeros((2, 1))):
        under_way = arrived.copy()
        for _ in range(MOST_LEGS):
            error = vehicle.sigma * rng.standard_normal((2, trials))
            if today.stretch is not None:
                error *= today.stretch(rng, trials)
            left = goal - fix
            length = np.minimum(np.hypot(*left), d_max)
            heading, part = np.arctan2(left[0], left[1]), np.where(under_way, length / vehicle.speed, 0.0) / PARTS
            for k in range(PARTS):
                now = clock + 0.5 * part
                course = heading + today.turn(now, heading)
                through = vehicle.speed * today.pace(now, (k + 0.5) * part) * np.stack([np.sin(course), np.cos(course)])
                here, clock = here + part * (through + _water(today, now, here) + error + wandering), clock + part
                if today.onward is not None:
                    wandering = today.onward(rng, wandering, part)
            seen = here + sd * rng.standard_normal((2, trials))
            clock = clock + np.where(under_way, voyage.surfacing, 0.0)
            fix = here + sd * rng.standard_normal((2, trials))
            under_way &= np.hypot(*(goal - seen)) > voyage.radius
            if not under_way.any():
                break
        arrived &= ~under_way
    return float(np.where(arrived, clock / 60.0, failure).mean())


def _water(truth: Truth, now: Array, here: Array) -> Array:
    return sum((np.reshape(flow(now, here), (2, -1)) for flow in truth.current), np.zeros((2, 1)))


def first_log_headings(pattern: str, count: int) -> Array:
    """Headings of a log [rad]: one way, there and back, or a corner."""
    turn = {"one way": 0.0, "there and back": np.pi, "corner": 0.5 * np.pi}[pattern]
    return np.asarray(np.where(np.arange(count) % 2, turn, 0.0))
