"""Legs on one heading, or few of them, with a cause that they cannot tell from others."""

from typing import Any

import numpy as np

from .ambiguous_dives import Hidden

CAUSES = ("speed-scale", "mean-current", "compass-bias", "persistent-error")
FIX, SURFACING = 3.0, 90.0
STEPS = 30
"""Of a leg, for a current that changes on the way."""


def draw_legs(seed: int) -> Hidden:
    """Draw a transit to plan, and legs within ±10° of a heading that were run before it."""
    rng = np.random.default_rng([seed, 72])
    speed, sigma, count = rng.uniform(0.9, 1.5), rng.uniform(0.015, 0.04), int(rng.integers(10, 31))
    middle = rng.uniform(0.0, 2.0 * np.pi)
    heading = middle + np.radians(10.0) * rng.uniform(-1.0, 1.0, count)
    time = rng.uniform(500.0, 1100.0, count)
    turn, pace, current, truth = _cause(str(rng.choice(CAUSES)), rng, middle, float(np.sum(time + SURFACING)))
    rows, start, here = [], 0.0, np.zeros(2)
    for number in range(count):
        made = heading[number] + turn
        moved = speed * pace * time[number] * _along(made) + current(start, time[number])
        moved = moved + sigma * time[number] * rng.standard_normal(2)
        first, last = here + FIX * rng.standard_normal(2), here + moved + FIX * rng.standard_normal(2)
        reckoned = first + speed * time[number] * _along(heading[number])
        cells = [start, start + time[number], *first, *reckoned, *last]
        rows.append([str(number + 1), *(f"{value:.3f}" for value in cells)])
        start, here = start + time[number] + SURFACING, here + moved
    names = [f"{axis}_{point}_m" for point in ("start", "dr", "end") for axis in ("x", "y")]
    dataset = {"kind": "transit", "name": "Legs", "file": "legs.csv", "source": "made up", "noise": {"fix": f"{FIX} m"}}
    mission = _mission(rng, speed, sigma)
    return Hidden("legs", mission, dataset, ["leg", "t_start_s", "t_end_s", *names], rows, truth)


def _along(heading: float) -> np.ndarray:
    return np.array([np.sin(heading), np.cos(heading)])


def _cause(name: str, rng: np.random.Generator, middle: float, span: float) -> tuple[float, float, Any, dict[str, Any]]:
    """Turn of the course, factor on the speed, displacement by a current over a leg, and the truth of one cause."""
    sign = 1.0 if rng.random() < 0.5 else -1.0

    def still(start: float, time: float) -> np.ndarray:
        return np.zeros(2)

    if name == "speed-scale":
        size = sign * rng.uniform(0.04, 0.12)
        return 0.0, 1.0 + size, still, {name: {"fraction": size}}
    if name == "compass-bias":
        size = sign * np.radians(rng.uniform(2.0, 8.0))
        return size, 1.0, still, {name: {"angle": f"{size} rad"}}
    if name == "mean-current":
        quarter = (
            0.5 * np.pi * rng.integers(4)
        )  # along the legs or across them: else they show that it is none of these
        velocity = rng.uniform(0.05, 0.15) * _along(middle + quarter + rng.uniform(-0.1, 0.1))
        return 0.0, 1.0, lambda start, time: velocity * time, {name: _components(velocity)}
    size, memory = rng.uniform(0.05, 0.12), rng.uniform(0.2, 1.0) * span
    t = np.arange(0.0, 1.2 * span, 30.0)
    keep = np.exp(-30.0 / memory)
    wander = np.empty((2, t.size))
    wander[:, 0] = rng.standard_normal(2)
    for k in range(1, t.size):
        wander[:, k] = keep * wander[:, k - 1] + np.sqrt(1.0 - keep**2) * rng.standard_normal(2)

    def carried(start: float, time: float) -> np.ndarray:
        moments = start + (np.arange(STEPS) + 0.5) * time / STEPS
        return time * size * np.array([np.interp(moments, t, axis).mean() for axis in wander])

    return 0.0, 1.0, carried, {name: {"sigma": f"{size} m/s", "time": f"{memory} s"}}


def _components(velocity: np.ndarray) -> dict[str, str]:
    return {"east": f"{velocity[0]} m/s", "north": f"{velocity[1]} m/s"}


def _mission(rng: np.random.Generator, speed: float, sigma: float) -> dict[str, Any]:
    """A transit to plan, on any course; the mission's velocity error is within a fifth of the true one."""
    goal = rng.uniform(5e3, 1e4) * _along(rng.uniform(0.0, 2.0 * np.pi))
    transit = {
        "name": "out",
        "from": ["0 m", "0 m"],
        "to": [f"{goal[0]:.0f} m", f"{goal[1]:.0f} m"],
        "speed": f"{speed:.4f} m/s",
        "d_max": "1 km",
        "arrival_radius": f"{rng.uniform(50.0, 150.0):.0f} m",
    }
    navigation = {
        "velocity_error": {"sigma": f"{sigma * rng.uniform(0.8, 1.25):.4f} m/s"},
        "surfacing_time": f"{SURFACING} s",
        "fix_error": f"{FIX} m",
        "drift_compensation": str(rng.choice(["none", "mean", "last-leg"])),
    }
    return {
        "name": "Transit",
        "site": {"origin": {"latitude": "37 deg", "longitude": "-76 deg"}},
        "navigation": navigation,
        "phases": [{"transit": transit}],
        "sweep": {"d_max": {"from": 0.1, "to": 1.0, "points": 10, "of": "distance"}},
    }
