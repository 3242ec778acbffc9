"""Surveys without effects: courses, times, nuisances."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from .catalogue import Array, LegConditions

CURRENT_SD, COMPASS_SD, SPEED_SD = 0.004, np.radians(0.15), 0.002
"""Prior uncertainty without any misfit: mean current [m/s], compass [rad], relative speed."""
NARROW = np.radians(10.0)
"""Half the range of headings of a narrow survey [rad]."""
MAX_COURSE_LENGTH = 120e3
"""Length of a one-way course [m]."""
RANDOM = {"persistent-error", "random-walk", "fix-error", "heavy-tails"}
PERIODIC = {"tidal-current", "inertial-current"}
NEED_SEVERAL_HEADINGS = {"compass-bias", "compass-deviation", "speed-scale", "mean-current"}


@dataclass(frozen=True)
class Survey:
    """Everything about the legs except effects and noise."""

    pattern: str
    targets: Array
    """Target of each leg, shape (legs, 2) [m]."""
    heading: Array | None
    """Heading steered on each leg whatever its target, shape (legs,) [rad], or None."""
    planned: Array
    speed: Array
    surface: Array
    pause: Array
    sigma: float
    fix: float
    latitude: float
    longitude: float
    current: Array
    compass: float
    pace: float

    @property
    def conditions(self) -> LegConditions:
        """Conditions that the builders depend on."""
        span = float(self.planned.sum() + self.surface.sum() + self.pause.sum())
        extent = float(np.sqrt(np.mean(np.sum(self.targets**2, axis=1))))
        leg_time = float(np.median(self.planned))
        speed = float(self.speed.mean())
        return LegConditions(self.latitude, span, extent, self.planned.size, leg_time, speed, self.sigma)


def draw_survey(rng: np.random.Generator, scenario: str, wanted: Sequence[str]) -> Survey:
    """Draw a survey of 60 to 300 legs; longer than three days where a period must be resolved."""
    names = set(wanted)
    periodic = bool(names & PERIODIC)
    pattern = _draw_pattern(rng, scenario, names)
    legs, leg_time, speed = _draw_length(rng, scenario, names, pattern)
    spread = rng.uniform(0.5, 0.8) if "fix-error" in names else rng.choice([0.05, 0.2, 0.5])
    planned = leg_time * np.exp(spread * rng.uniform(-1.0, 1.0, legs))
    speeds = np.full(legs, speed)
    if rng.random() < 0.3 and scenario != "tie":
        speeds = speed * (1.0 + 0.15 * rng.uniform(-1.0, 1.0, legs))
    surface = _draw_surface_times(rng, legs, leg_time, "surface-drift" in names)
    high, low = ((40.0, 50.0), (13.0, 18.0)) if periodic else ((30.0, 60.0), (5.0, 30.0))
    latitude = rng.uniform(*(high if rng.random() < 0.7 else low))
    heading = rng.uniform(0.0, 2.0 * np.pi)
    step = float(np.mean(planned * speeds))
    return Survey(
        pattern=pattern,
        targets=_targets(rng, pattern, planned * speeds, step, heading),
        heading=_fixed_headings(rng, scenario, heading, legs),
        planned=planned,
        speed=np.round(speeds, 3),
        surface=np.round(np.minimum(surface, 0.4 * planned)),
        pause=rng.uniform(10.0, 60.0, legs),
        sigma=rng.uniform(0.015, 0.04),
        fix=rng.uniform(2.0, 12.0),
        latitude=latitude * (1.0 if rng.random() < 0.6 else -1.0),
        longitude=rng.uniform(-170.0, 170.0),
        current=CURRENT_SD * np.clip(rng.standard_normal(2), -1.0, 1.0),
        compass=COMPASS_SD * float(np.clip(rng.standard_normal(), -2.0, 2.0)),
        pace=SPEED_SD * float(np.clip(rng.standard_normal(), -2.0, 2.0)),
    )


def _fixed_headings(rng: np.random.Generator, scenario: str, heading: float, legs: int) -> Array | None:
    """One heading for a tie, headings within a narrow range, or None."""
    if scenario == "tie":
        return np.full(legs, heading)
    return heading + NARROW * rng.uniform(-1.0, 1.0, legs) if scenario == "narrow" else None


def _draw_pattern(rng: np.random.Generator, scenario: str, names: set[str]) -> str:
    patterns = ["lawnmower", "survey", "out-and-back", "triangle", "one-heading"]
    if names & (PERIODIC | NEED_SEVERAL_HEADINGS | {"current-shear"}) or scenario in ("pair", "outside"):
        patterns = ["lawnmower", "survey", "triangle"]
    return "one-heading" if scenario in ("tie", "narrow") else str(rng.choice(patterns))


def _draw_length(rng: np.random.Generator, scenario: str, names: set[str], pattern: str) -> tuple[int, float, float]:
    """Number of legs, typical time of a leg [s] and speed [m/s]."""
    legs = int(rng.integers(140 if names & RANDOM else 60, 301))
    if scenario in ("pair", "outside"):
        legs = max(legs, 100)
    leg_time = float(np.exp(rng.uniform(np.log(1200.0), np.log(7200.0))))
    if "fix-error" in names:
        leg_time = rng.uniform(400.0, 1200.0)
    if names & PERIODIC:
        leg_time = max(leg_time, 5.0 * 86400.0 / legs)
    speed = rng.uniform(0.3, 1.5)
    if pattern in ("one-heading", "out-and-back"):
        # at lower speeds a compass error would not exceed the uncertainty of the current
        slowest = 0.7 if scenario in ("tie", "narrow") else 0.25
        speed = max(slowest, min(speed, MAX_COURSE_LENGTH / (legs * leg_time)))
        leg_time = min(leg_time, MAX_COURSE_LENGTH / (legs * speed))
    return legs, leg_time, speed


def _draw_surface_times(rng: np.random.Generator, legs: int, leg_time: float, drifting: bool) -> Array:
    waits = rng.uniform(60.0, 300.0)
    surface = waits * np.exp((0.9 if drifting else 0.5) * rng.standard_normal(legs))
    if drifting:
        surface *= max(1.0, 0.1 * leg_time / waits)
    return surface


def _targets(rng: np.random.Generator, pattern: str, lengths: Array, step: float, heading: float) -> Array:
    """Return the ends of the planned legs relative to the origin."""
    legs = lengths.size
    k = np.arange(legs)
    if pattern == "one-heading":
        angle = np.full(legs, heading)
    elif pattern == "out-and-back":
        angle = heading + np.pi * (k >= legs // 2)
    elif pattern == "lawnmower":
        row = int(rng.integers(3, 8))
        place = k % (2 * row + 2)
        angle = heading + np.select([place < row, place == row, place < 2 * row + 1], [0.0, 0.5, 1.0], 0.5) * np.pi
        # a second pass back over the area, so that it stays an area
        angle = np.where(k < legs // 2, angle, angle + np.where(np.isin(place, [row, 2 * row + 1]), np.pi, 0.0))
    elif pattern == "triangle":
        angle = heading + 2.0 * np.pi / 3.0 * ((k // int(rng.integers(2, 8))) % 3)
    else:
        return _random_courses(rng, lengths, step)
    return np.cumsum(lengths[:, None] * np.column_stack([np.sin(angle), np.cos(angle)]), axis=0)


def _random_courses(rng: np.random.Generator, lengths: Array, step: float) -> Array:
    """Random courses that turn back when far from the origin."""
    reach = step * np.sqrt(lengths.size) * 0.6
    here, ends = np.zeros(2), []
    for length in lengths:
        angle = rng.uniform(0.0, 2.0 * np.pi)
        if np.hypot(*here) > reach:
            angle = np.arctan2(-here[0], -here[1]) + rng.uniform(-0.8, 0.8)
        here = here + length * np.array([np.sin(angle), np.cos(angle)])
        ends.append(here)
    return np.array(ends)


def with_scaled_nuisances(survey: Survey, rng: np.random.Generator) -> Survey:
    """Return a survey with nuisances of half to twice the usual size, as for controls."""
    scale = float(np.exp(rng.uniform(np.log(0.5), np.log(2.0))))
    scaled = {name: scale * getattr(survey, name) for name in ("current", "compass", "pace", "sigma", "fix")}
    return replace(survey, **scaled)
