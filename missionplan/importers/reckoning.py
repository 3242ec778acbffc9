"""Dead reckoning made from heading, pitch and depth, or speed, where a vehicle's own stands still under water.

Whether a vehicle's dead reckoning is already carried with a current that it estimates, and how to take that out.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from missionplan.arrays import Array
from missionplan.importers.dives import Candidate
from missionplan.importers.geodesy import displacement, moved
from missionplan.importers.track import Fixes, Positions, Series, Track

LEAST_PITCH = 8.0
"""Pitch below which depth rate over its tangent is no speed [deg]."""
TURNING = 0.5
"""Share of the last speed that is kept there: between two readings about the turn of a yo the vehicle glides, turns and
glides again. Logs thinned to every other reading then lead to the same place (0.1 m of 1500 m off on average over 61
legs); with all of the last speed they lead 3 m farther, with none 3 m less far."""
ATTACK = 3.0
"""Angle of attack that is neglected [deg]: 2 to 4 deg for gliders (Merckelbach, Smeed and Griffiths 2010)."""
SPEED_ERROR = 0.05
"""Error of a logged speed over it, which logs do not tell: assumed."""
HEADING_ERROR = 0.035
"""Error of a compass [rad], 2 deg, which logs do not tell: assumed."""
LEAST_DEPTH = 2.0
"""Depth above which waves, not the glide, change the depth [m]: no way is made there."""
FASTEST_GLIDE = 2.0
"""Greatest horizontal speed that follows from pitch and depth rate [m/s]."""


def can_be_made(track: Track) -> bool:
    """Whether a track has what dead reckoning is made from."""
    return bool(len(track.heading) and (len(track.speed) or (len(track.pitch) and len(track.depth))))


def made_reckoning(
    track: Track, start: float, end: float, latitude: float, longitude: float, attack: float = 0.0
) -> Positions:
    """Reckon from a fix on to just before the next.

    The speed is the logged one, else the rate of the depth over the tangent of the pitch: the angle of attack is
    neglected. The vehicle's own declination is added to headings from magnetic north.

    `start`, `end`: times of the two fixes [s]. `latitude`, `longitude`: of the first [deg]. `attack`: angle of attack
    [deg]: the path is steeper than the pitch by it.
    """
    t = (track.speed if len(track.speed) else track.depth).within(start, np.nextafter(end, start)).t
    if len(t) < 2:
        return Positions()
    steps, middle = np.diff(t), 0.5 * (t[1:] + t[:-1])
    angle = np.radians(_at_turning(track.heading, t) + true_from_logged(track, t))
    heading = np.angle(np.exp(1j * angle[1:]) + np.exp(1j * angle[:-1]))
    speed = track.speed.at(middle) if len(track.speed) else _glide_speed(track, t, attack)
    east = np.append(0.0, np.cumsum(speed * np.sin(heading) * steps))
    north = np.append(0.0, np.cumsum(speed * np.cos(heading) * steps))
    return Positions(t, *moved(latitude, longitude, east, north))


def made_doubt(track: Track, line: Positions, end: float) -> float:
    """Standard deviation of the end of a made reckoning [m]: by the angle of attack, or the speed, and the heading.

    `line`: as made. `end`: time of the fix after the dive [s].
    """
    if len(line) < 2:
        return float("nan")
    first = float(line.latitude[0]), float(line.longitude[0])
    way = float(np.hypot(*displacement(*first, line.latitude[-1], line.longitude[-1])))
    if len(track.speed):
        along = SPEED_ERROR * way
    else:
        steeper = made_reckoning(track, float(line.t[0]), end, *first, attack=ATTACK)
        along = float(np.hypot(*displacement(
            steeper.latitude[-1], steeper.longitude[-1], line.latitude[-1], line.longitude[-1])))  # fmt: skip
    return float(np.hypot(along, HEADING_ERROR * way))


def _at_turning(heading: Series, t: Array) -> Array:
    """Interpolate a heading, the short way round [deg]; times increase."""
    first = max(int(np.searchsorted(heading.t, t[0], side="right")) - 1, 0)
    about = slice(first, int(np.searchsorted(heading.t, t[-1])) + 1)
    unwrapped = np.degrees(np.unwrap(np.radians(heading.values[about])))
    return np.asarray(np.interp(t, heading.t[about], unwrapped))


def true_from_logged(track: Track, t: Array) -> Array:
    """What is added to logged headings to count them from true north [deg]; 0 where nothing is known."""
    if track.heading_from == "true" or not len(track.declination):
        return np.zeros(np.shape(t))
    return track.declination.at(t)


def _glide_speed(track: Track, t: Array, attack: float) -> Array:
    """Horizontal speed between readings of the depth [m/s]."""
    depth, pitch = track.depth.at(t), track.pitch.at(t)
    sink = np.abs(np.diff(depth) / np.diff(t))
    slope = np.abs(0.5 * (pitch[1:] + pitch[:-1]))  # of the signed ones: the turn of a yo is flat
    steep = slope > LEAST_PITCH
    speed = np.where(steep, sink / np.tan(np.radians(np.where(steep, slope + attack, 45.0))), np.nan)
    last_steep = np.maximum.accumulate(np.where(steep, np.arange(len(speed)), -1))
    glide_speed = np.where(last_steep >= 0, speed[np.maximum(last_steep, 0)], 0.0) * np.where(steep, 1.0, TURNING)
    deep = 0.5 * (depth[1:] + depth[:-1]) > LEAST_DEPTH
    return np.asarray(np.where(deep, np.minimum(glide_speed, FASTEST_GLIDE), 0.0))


_FEWEST = 8
"""Legs from which the share of the current is measured."""
_LONG = 900.0
"""Time from which on a leg shows it [s]."""
_OLDEST = 86400.0
"""Age of an estimate that is still in use [s]."""


@dataclass(frozen=True)
class VehicleCurrent:
    """Share of the vehicle's estimate of the current in its dead reckoning."""

    share: float
    sd: float
    """Measured on the legs; nan where the log does not suffice."""
    times: Array
    east: Array
    north: Array
    """Start of each leg [s], and the estimate it dived with [m/s]."""

    @property
    def is_in(self) -> bool:
        """Whether the legs show that the dead reckoning holds the estimate."""
        return bool(self.share > 0.5 and self.share > 3.0 * self.sd)

    def taken_out(self, line: Positions) -> Positions:
        """Take the estimate out of a leg's positions."""
        if not len(line) or not self.is_in:
            return line
        leg = max(int(np.searchsorted(self.times, line.t[0], side="right")) - 1, 0)
        elapsed = line.t - self.times[leg]
        latitude, longitude = moved(
            line.latitude, line.longitude, -self.east[leg] * elapsed, -self.north[leg] * elapsed
        )
        return replace(line, latitude=latitude, longitude=longitude)


def current_in_reckoning(
    track: Track, fixes: Fixes, candidates: Sequence[Candidate], reckoned: Sequence[Positions]
) -> VehicleCurrent | None:
    """Measure how much of the vehicle's estimate of the current its dead reckoning holds; None if it logs none.

    Over the legs, the mean velocity of the dead reckoning is fitted by that made from heading and speed, turned and
    scaled, and the estimate the vehicle dived with: the estimate's factor is the share.
    """
    if not len(track.current_east) or not len(track.current_north):
        return None
    starts = np.array([fixes.t[dive.before] for dive in candidates], dtype=float)
    east, north = (
        np.nan_to_num([component.latest(t, t - _OLDEST) for t in starts])
        for component in (track.current_east, track.current_north)
    )
    share, sd = float("nan"), float("nan")
    if can_be_made(track):
        rows = [
            row
            for dive, line, estimate in zip(candidates, reckoned, east + 1j * north, strict=True)
            if (row := _velocities(track, fixes, dive, line, estimate)) is not None
        ]
        if len(rows) >= _FEWEST:
            share, sd = _fitted_share(np.array(rows))
    return VehicleCurrent(share, sd, starts, east, north)


def _velocities(
    track: Track, fixes: Fixes, dive: Candidate, line: Positions, estimate: complex
) -> tuple[complex, complex, complex] | None:
    """Mean velocities of one leg, east + i north: its dead reckoning's, the made one's and the estimate [m/s]."""
    start = float(fixes.t[dive.before])
    if not len(line) or line.t[-1] - start < _LONG:
        return None
    place = float(fixes.latitude[dive.before]), float(fixes.longitude[dive.before])
    made = made_reckoning(track, start, float(line.t[-1]), *place)
    if not len(made):
        return None
    duration = float(line.t[-1]) - start
    ways = (displacement(*place, positions.latitude[-1], positions.longitude[-1]) for positions in (line, made))
    velocity, through_water = (complex(east, north) / duration for east, north in ways)
    return velocity, through_water, estimate


def _fitted_share(rows: Array) -> tuple[float, float]:
    """Least squares of complex velocities: the real part of the estimate's factor, and its standard error."""
    target, design = rows[:, 0], rows[:, 1:]
    if np.linalg.matrix_rank(design) < design.shape[1]:
        return float("nan"), float("nan")
    factors = np.linalg.lstsq(design, target, rcond=None)[0]
    left = target - design @ factors
    variance = float(np.sum(np.abs(left) ** 2)) / (2 * (len(rows) - design.shape[1]))
    covariance = variance * np.linalg.inv(design.conj().T @ design)
    return float(factors[1].real), float(np.sqrt(covariance[1, 1].real))
