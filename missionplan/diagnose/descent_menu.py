"""Further dives that might tell two causes apart, and what they would bring."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from missionplan.diagnose.coordinates import Coordinate
from missionplan.diagnose.descent_data import MARGIN, MOST_SAMPLES, DiveLog
from missionplan.diagnose.descent_forward import DescentForward

Array = NDArray[np.float64]

MENU = (
    ("two dives with 0.4 times the anchor's weight", 0.4, 1.0, 1.0),
    ("two dives with a line three times as long", 1.0, 3.0, 1.0),
    ("two dives twice as deep", 1.0, 1.0, 2.0),
)
"""In words; factors on wet weight, line length and site depth. Cheapest first."""
LONGEST = 120.0


def planned(forward: DescentForward, entry: int | None) -> tuple[DiveLog, ...]:
    """Two dives of the menu, like the first two of the data but for the factor; depths are left zero.

    Parameters
    ----------
    forward : DescentForward
        The dives so far.
    entry : int or None
        Of `MENU`; None for the same dives again.
    """
    _, weight, line, depth = MENU[entry] if entry is not None else ("", 1.0, 1.0, 1.0)
    logs = []
    for log in forward.logs[:2]:
        site = log.site_depth * depth + (line - 1.0) * log.line_length
        logs.append(
            replace(log, wet_weight=log.wet_weight * weight, line_length=log.line_length * line, site_depth=site)
        )
    return tuple(_timed(forward, log) for log in logs)


def _timed(forward: DescentForward, log: DiveLog) -> DiveLog:
    """Sample a dive evenly until the base model nears touchdown."""
    grid = np.linspace(0.0, LONGEST, 600)
    places = np.arange(600)
    whole = replace(log, t=grid, depth=np.zeros(600), sd=np.ones(600), fine=grid, bins=places, shares=np.ones(600))
    none: tuple[Coordinate, ...] = ()
    depth = replace(forward, logs=(whole,)).readings(none, np.zeros((0, 1)))[:, 0]
    near = np.flatnonzero(depth > (1.0 - MARGIN) * (log.site_depth - log.line_length))
    end = grid[near[0]] if len(near) else LONGEST
    times = np.linspace(0.0, float(end), MOST_SAMPLES)
    sd = np.full(MOST_SAMPLES, float(np.median(log.sd)))
    return replace(
        log, t=times, depth=0.0 * times, sd=sd, fine=times, bins=np.arange(MOST_SAMPLES), shares=np.ones(MOST_SAMPLES)
    )


def filled(logs: tuple[DiveLog, ...], readings: Array) -> tuple[DiveLog, ...]:
    """Put readings, dive after dive, into logs."""
    parts = np.split(readings, np.cumsum([len(log.t) for log in logs])[:-1])
    return tuple(replace(log, depth=part) for log, part in zip(logs, parts, strict=True))
