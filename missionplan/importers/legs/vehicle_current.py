"""Whether a vehicle's dead reckoning is already carried with a current that it estimates, and how to take that out."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from missionplan.arrays import Array
from missionplan.importers.geodesy import displacement, moved
from missionplan.importers.legs.candidates import Candidate
from missionplan.importers.legs.made_reckoning import can_be_made, made_reckoning
from missionplan.importers.track import Fixes, Positions, Track

_FEWEST = 8
"""Legs from which the share of the current is measured."""
_LONG = 900.0
"""Time from which on a leg shows it [s]."""
_OLDEST = 86400.0
"""Age of an estimate that is still in use [s]."""


@dataclass(frozen=True)
class VehicleCurrent:
    """Share of the vehicle's estimate of the current in its dead reckoning.

    Attributes
    ----------
    share, sd : float
        Measured on the legs; nan where the log does not suffice.
    times, east, north : array
        Start of each leg [s], and the estimate it dived with [m/s].
    """

    share: float
    sd: float
    times: Array
    east: Array
    north: Array

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
    starts = np.array([fixes.t[each.before] for each in candidates], dtype=float)
    east, north = (
        np.nan_to_num([each.latest(t, t - _OLDEST) for t in starts])
        for each in (track.current_east, track.current_north)
    )
    share, sd = float("nan"), float("nan")
    if can_be_made(track):
        rows = [
            row
            for each, line, estimate in zip(candidates, reckoned, east + 1j * north, strict=True)
            if (row := _velocities(track, fixes, each, line, estimate)) is not None
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
    ways = (displacement(*place, each.latitude[-1], each.longitude[-1]) for each in (line, made))
    own, through_water = (complex(east, north) / duration for east, north in ways)
    return own, through_water, estimate


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
