"""One trial of a transit as a plain Python function, called by both frameworks.

Imports only the standard library, because it also runs in monaco's environment.
"""

import math
import random

DISTANCE, D_MAX, RADIUS, SIGMA, SURFACING_TIME, MAX_LEGS = 7408.0, 1852.0, 50.0, 0.035, 90.0, 400
SPEED, SPEED_SD = 1.25, 0.05
RUNS = {1: 9, 2: 3}
"""Runs of the cases per round, by workers, after a warm-up run; the minimum counts."""
MISSION = f"""\
name: A transit whose speed is uncertain
navigation:
  velocity_error: {{sigma: {SIGMA} m/s}}
  surfacing_time: {SURFACING_TIME} s
  max_legs: {MAX_LEGS}
phases:
  - transit:
      name: ingress
      from: [0 m, 0 m]
      to: [{DISTANCE} m, 0 m]
      speed: {{mean: {SPEED} m/s, sd: {SPEED_SD} m/s}}
      d_max: {D_MAX} m
      arrival_radius: {RADIUS} m
sweep: {{d_max: {{from: 0.1, to: 1.0, points: 16, of: distance}}}}
monte_carlo: {{trials: 8192, seed: 1}}
"""
"""The same transit as a mission."""


def transit_trial(speed: float, seed: int) -> tuple[float, int]:
    """Simulate one transit; return its duration [s] and its number of surfacings."""
    draw = random.Random(seed).gauss
    x, y, left, run, surfacings = -DISTANCE, 0.0, DISTANCE, 0.0, 0
    while left >= RADIUS and surfacings < MAX_LEGS:
        length = min(left, D_MAX)
        duration = length / speed
        x += -x / left * length + draw(0.0, SIGMA) * duration
        y += -y / left * length + draw(0.0, SIGMA) * duration
        left = math.hypot(x, y)
        run += length
        surfacings += 1
    return run / speed + SURFACING_TIME * surfacings, surfacings
