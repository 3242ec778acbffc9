"""The starter mission beside a data set, with what the legs say of it; and what these legs can and cannot show."""

import math
from dataclasses import dataclass

import numpy as np
import pandas as pd

from missionplan.arrays import Array
from missionplan.datasets.legs import MIN_LEGS
from missionplan.errors import counted
from missionplan.importers.geodesy import displacement
from missionplan.importers.reckoning import HEADING_ERROR

_FEWEST = 3
"""Legs from which their spread says something."""
_LEAST_SIGMA = 0.001
"""Velocity error that the starter mission has at least, each axis [m/s]."""


@dataclass(frozen=True)
class LegNumbers:
    """What the legs that count say of a mission."""

    latitude: float
    longitude: float
    """Of the first fix [deg]."""
    start: str
    """Of the first leg, ISO 8601."""
    sigma: float
    """Root mean square of the velocity errors about their mean, each axis [m/s]."""
    mean_error: tuple[float, float]
    """Mean velocity error, east and north [m/s]."""
    surfacing: float
    """Median time at the surface, from surfacing to the next leg's start [s]."""
    fix_sd: float
    """Median standard deviation of a fix, each axis [m]."""
    speed: float
    length: float
    duration: float
    """Medians of the legs [m/s, m, s]."""
    course: float
    """Mean course of the way through the water [deg]."""
    spread: float
    """Length of the mean unit vector of the courses: 1 for one course, 0 for all."""
    way: float
    """From the first fix to the last [m]."""
    record: float
    """Time from the first fix to the last [s]."""
    depth: float
    """Greatest depth [m]; nan where none was logged."""
    glide_doubt: float
    """Standard deviation, over it, of a speed made from pitch and depth rate; nan where none was made."""


def numbers_of(legs: pd.DataFrame) -> LegNumbers:
    """Gather what the legs that count say; of all legs where none counts."""
    kept = legs[legs["ok"] == 1] if (legs["ok"] == 1).any() else legs
    errors, ways, duration = _errors(kept)
    courses = np.exp(1j * np.arctan2(*ways))
    mean_course = complex(courses.mean())
    about = errors - errors.mean(axis=1, keepdims=True) if errors.shape[1] >= _FEWEST else errors
    pauses = kept["t_start_s"].to_numpy()[1:] - kept["t_end_s"].to_numpy()[:-1] + kept["surface_s"].to_numpy()[:-1]
    first, last = kept.iloc[0], kept.iloc[-1]
    end = displacement(*(float(angle) for angle in (first.lat_start, first.lon_start, last.lat_end, last.lon_end)))
    lengths = np.hypot(*ways)
    return LegNumbers(
        latitude=float(first.lat_start),
        longitude=float(first.lon_start),
        start=str(first.t_start),
        sigma=max(float(np.sqrt(np.mean(about**2))), _LEAST_SIGMA),
        mean_error=(float(errors[0].mean()), float(errors[1].mean())),
        surfacing=float(np.median(pauses)) if len(pauses) else float(kept["surface_s"].median()),
        fix_sd=float(kept["fix_sd_m"].median()),
        speed=float(np.median(lengths / duration)),
        length=float(np.median(lengths)),
        duration=float(np.median(duration)),
        course=math.degrees(float(np.angle(mean_course))) % 360.0,
        spread=abs(mean_course),
        way=float(np.hypot(*end)),
        record=float(last.t_end_s - first.t_start_s),
        depth=float(kept["max_depth_m"].max()),
        glide_doubt=_glide_doubt(kept["dr_sd_m"].to_numpy() / lengths),
    )


def _glide_doubt(doubts: Array) -> float:
    """Along the course, of the ends of made reckonings over their ways; the heading's share taken out."""
    squared = float(np.nanmedian(doubts)) ** 2 - HEADING_ERROR**2 if np.isfinite(doubts).any() else math.nan
    return round(math.sqrt(max(squared, 0.0)), 3) if math.isfinite(squared) else math.nan


def _errors(legs: pd.DataFrame) -> tuple[Array, Array, Array]:
    """Velocity error (2, n) [m/s], dead-reckoned way (2, n) [m] and time under way (n,) [s] of each leg."""
    start, reckoned, end = (
        (legs[f"lat_{name}"].to_numpy(), legs[f"lon_{name}"].to_numpy()) for name in ("start", "dr_end", "end")
    )
    duration = (legs["t_end_s"] - legs["t_start_s"] - legs["surface_s"]).to_numpy().clip(min=1.0)
    error, way = np.stack(displacement(*reckoned, *end)), np.stack(displacement(*start, *reckoned))
    return error / duration, way, duration


def mission_text(name: str, numbers: LegNumbers) -> str:
    """Write a starter mission: the legs again, from the first fix on, with the errors that they had."""
    speed, length = max(numbers.speed, 0.01), max(numbers.length, 1.0)
    distance = max(numbers.way, 4.0 * length)
    angle = math.radians(numbers.course)
    east, north = distance * math.sin(angle), distance * math.cos(angle)
    radius = max(2.0 * numbers.fix_sd, 0.02 * length, 10.0)
    return f"""\
# Written by missionplan import from a log: the same legs again, with the errors that they had. Change what you know
# better, then
#   missionplan diagnose mission.yaml .        what do the legs show that this mission lacks?
name: '{name.replace("'", "''")}'
start: {numbers.start}     # of the first leg: times of the data set count from it
site:
  origin: {{latitude: {numbers.latitude:.6f} deg, longitude: {numbers.longitude:.6f} deg}}     # the first fix
navigation:
  velocity_error: {{sigma: {_rounded(numbers.sigma)} m/s}}     # of the legs, about their mean, each axis
  surfacing_time: {_rounded(max(numbers.surfacing, 1.0))} s     # median: from surfacing to the fix on diving
  fix_error: {_rounded(max(numbers.fix_sd, 0.1))} m     # each axis
phases:
  - transit:
      name: survey
      from: [0 m, 0 m]
      to: [{east:.0f} m, {north:.0f} m]     # on the legs' mean course, {numbers.course:.0f} deg
      speed: {_rounded(speed)} m/s     # median, through the water
      d_max: {_rounded(length)} m     # median length of a leg
      arrival_radius: {_rounded(radius)} m
monte_carlo: {{trials: 5000, seed: 1}}
"""


def _rounded(value: float) -> str:
    """Three significant figures, never with an exponent."""
    digits = max(2 - math.floor(math.log10(abs(value))), 0) if value else 0
    return f"{value:.{digits}f}"


_PERSISTENCE = 20
"""Legs that usually show what persists from leg to leg; fewer do where it is strong."""
_TIDE = 12.42 * 3600.0
_ONE_COURSE = 0.9
"""Length of the courses' mean unit vector above which all legs go one way."""
_SURFACE_SHARE = 0.02
"""Share of the legs' time that is spent at the surface, from which drift there shows."""


def prospects(legs: pd.DataFrame, numbers: LegNumbers) -> tuple[tuple[str, str], ...]:
    """Return what may be found, and whether the legs suffice or what is lacking."""
    kept = legs[legs["ok"] == 1]
    some, too_few = counted(len(kept), "leg"), f"and {MIN_LEGS} are needed to diagnose anything"
    usual, way = f"where some {_PERSISTENCE} usually show it", f"nearly all legs go {numbers.course:.0f} deg"
    is_one_way = numbers.spread > _ONE_COURSE
    return (
        ("a mean current", f"yes: {some}" if len(kept) >= MIN_LEGS else f"no: {some}, {too_few}"),
        (
            "persistence, a random walk, heavy tails",
            f"yes: {some}" if len(kept) >= _PERSISTENCE else f"hardly: {some}, {usual}",
        ),
        (
            "compass and speed errors, apart from a current",
            f"no: {way}; legs on opposite courses would separate them"
            if is_one_way
            else "yes: the legs go several ways",
        ),
        _tide(numbers),
        _inertial(numbers),
        _surface(kept),
        _fix_error(kept),
    )


def _tide(numbers: LegNumbers) -> tuple[str, str]:
    what, hours = "a tide (M2, 12.4 h)", numbers.record / 3600.0
    if numbers.record < 0.5 * _TIDE:
        return what, f"no: the record lasts {hours:.1f} h, less than half a period"
    if numbers.duration > 0.5 * _TIDE:
        return what, f"hardly: a leg lasts {numbers.duration / 3600.0:.1f} h and averages over the period"
    return what, f"yes: the record lasts {hours:.0f} h"


def _inertial(numbers: LegNumbers) -> tuple[str, str]:
    what = "an inertial current"
    rate = 2.0 * 7.2921e-5 * abs(math.sin(math.radians(numbers.latitude)))
    period = 2.0 * math.pi / max(rate, 1e-9)
    hours = period / 3600.0
    if numbers.record < 0.5 * period:
        return what, f"no: the record lasts {numbers.record / 3600.0:.1f} h, the period there is {hours:.1f} h"
    return what, f"yes: the period there is {hours:.1f} h"


def _surface(kept: pd.DataFrame) -> tuple[str, str]:
    what = "drift at the surface"
    total = float((kept["t_end_s"] - kept["t_start_s"]).sum())
    share = float(kept["surface_s"].sum()) / total if total > 0.0 else 0.0
    if share < _SURFACE_SHARE:
        return what, f"hardly: {100.0 * share:.1f} % of the legs' time is at the surface"
    return what, f"yes: {100.0 * share:.0f} % of the legs' time is at the surface"


def _fix_error(kept: pd.DataFrame) -> tuple[str, str]:
    what = "errors of the fixes, apart from those under way"
    duration = (kept["t_end_s"] - kept["t_start_s"]).to_numpy()
    ratio = float(duration.max() / duration.min()) if len(duration) else 1.0
    if ratio < 2.0:
        return what, f"no: all legs are alike in length (longest over shortest {ratio:.1f})"
    return what, f"yes: the longest leg is {ratio:.1f} times the shortest"
