"""A sea and a vehicle in it, sailed in steps: what they are, a log of legs, and a mission by fixes."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
SPEED, FIX, SIGMA, SURFACING = 1.1, 3.0, 0.04, 60.0
"""Speed by the log [m/s]; standard deviations of a fix [m] and of a leg's velocity error [m/s]; time at the surface [s]."""
D_MAX, RADIUS = 1000.0, 60.0
M2 = 2.0 * np.pi / (12.4206012 * 3600.0)
STEPS = 20
"""Of a leg."""


@dataclass(frozen=True)
class Sea:
    """What the mission does not know; every field is neutral by default.

    Attributes
    ----------
    low : float
        By how much the compass reads low [rad].
    pace : float
        Share by which the vehicle is faster than its log.
    current, tide : array, shape (2,)
        Steady, and amplitude of one by the period of M2 [m/s].
    phase : float
        Of the tide at the start of the log [rad].
    """

    low: float
    pace: float
    current: Array
    tide: Array
    phase: float

    @classmethod
    def drawn(cls, rng: np.random.Generator) -> "Sea":
        """Draw what is there: each of the first three in half of all seas, a tide in three of ten."""
        here = rng.random(4) < (0.5, 0.5, 0.5, 0.3)
        low, pace = np.radians(3.0) * rng.standard_normal(), 0.04 * rng.standard_normal()
        current, tide = 0.08 * rng.standard_normal(2), 0.1 * rng.standard_normal(2)
        return cls(here[0] * low, here[1] * pace, here[2] * current, here[3] * tide, rng.uniform(0.0, 2.0 * np.pi))

    def moved(self, clock: float, heading: float, seconds: float, error: Array) -> Array:
        """Way over ground of a leg of a heading by the compass, shape (2,) [m]."""
        course, way = heading + self.low, np.zeros(2)
        own = SPEED * (1.0 + self.pace) * np.array([np.sin(course), np.cos(course)])
        for step in range(STEPS):
            then = clock + (step + 0.5) * seconds / STEPS
            way += (own + self.current + self.tide * np.cos(M2 * then + self.phase) + error) * seconds / STEPS
        return way


def log(sea: Sea, rng: np.random.Generator) -> str:
    """Sail 12 to 39 legs, all round or within some 30° of a course, and return their table, comma-separated."""
    count, is_round = int(rng.integers(12, 40)), rng.random() < 0.6
    rows = ["leg,t_start_s,t_end_s,x_start_m,y_start_m,x_dr_m,y_dr_m,x_end_m,y_end_m"]
    clock, place = 0.0, np.zeros(2)
    for number in range(count):
        heading = rng.uniform(-np.pi, np.pi) if is_round else rng.normal(1.0, 0.3)
        seconds = 60.0 * int(rng.integers(8, 18))
        known = place + FIX * rng.standard_normal(2)
        reckoned = known + SPEED * seconds * np.array([np.sin(heading), np.cos(heading)])
        place = place + sea.moved(clock, heading, seconds, SIGMA * rng.standard_normal(2))
        fix = place + FIX * rng.standard_normal(2)
        times, places = (clock, clock + seconds), (*known, *reckoned, *fix)
        rows.append(",".join([str(number + 1), *(f"{time:.1f}" for time in times), *(f"{x:.2f}" for x in places)]))
        clock += seconds + SURFACING
    return "\n".join(rows) + "\n"


def sailed(sea: Sea, clock: float, goal: Array, rng: np.random.Generator) -> float:
    """Sail to a goal in legs of at most `D_MAX` that aim at it from each fix, and return how long it takes [s]."""
    place, fix, now = np.zeros(2), np.zeros(2), clock
    for _ in range(400):
        left = goal - fix
        if np.hypot(*left) < RADIUS:
            return now - clock
        seconds = min(float(np.hypot(*left)), D_MAX) / SPEED
        error = SIGMA * rng.standard_normal(2)
        place = place + sea.moved(now, float(np.arctan2(left[0], left[1])), seconds, error)
        now += seconds + SURFACING
        fix = place + FIX * rng.standard_normal(2)
    raise RuntimeError("a goal that is never reached")
