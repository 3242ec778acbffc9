"""A mission seen from above, for maps and globes: tracks, circles of error, mooring ellipses."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from missionplan.arrays import Array
from missionplan.exporters.maps.geometry import circle
from missionplan.report.wording import phase_in_words
from missionplan.results.simulation import Outcome, Tracks

SHARES = (0.5, 0.95)
"""Shares of the trials that circles and ellipses hold."""
_LEAST_POINTS = 10
"""Ends of a phase below which no share is drawn."""


@dataclass(frozen=True)
class Ring:
    """A closed line about where the trials end.

    Attributes
    ----------
    kind : str
        ``arrival circle`` or ``CEP`` of a transit, ``mooring circle`` or ``mooring ellipse`` of a mooring.
    phase : str
        Name of the phase.
    share : float
        Share of the trials inside; nan for a circle that the mission sets.
    radius : float
        Of a circle; for an ellipse, of the circle of equal area [m].
    line : array, shape (2, k)
        East and north, counter-clockwise, the last point equal to the first [m].
    """

    kind: str
    phase: str
    share: float
    radius: float
    line: Array


def rings(outcome: Outcome) -> Iterator[Ring]:
    """Yield the circle that the mission allows about every goal, and the CEP of the arrivals or ellipses of anchors."""
    moors = [phase.name for phase in outcome.phases if phase.kind == "moor"]
    for name, (goal, radius) in outcome.tracks.targets.items():
        moored = name in moors
        yield Ring("mooring circle" if moored else "arrival circle", name, math.nan, radius, circle(goal, radius))
        ends = finite(outcome.arrivals.get(name, np.empty((2, 0))))
        if ends.shape[1] < _LEAST_POINTS:
            continue
        for share in SHARES:
            if moored:
                line = ellipse(ends + np.array(goal)[:, None], share)
                yield Ring("mooring ellipse", name, share, math.sqrt(area(line) / math.pi), line)
            else:
                cep = circular_error(ends, share)
                yield Ring("CEP", name, share, cep, circle(goal, cep))


def describe(ring: Ring) -> str:
    """Describe a ring for other programs, in SI: ``ingress: CEP 50 %, 7.1 m``."""
    share = "" if math.isnan(ring.share) else f" {100.0 * ring.share:.0f} %"
    radius = "" if ring.kind == "mooring ellipse" else f", {ring.radius:.3g} m"
    return f"{phase_in_words(ring.phase)}: {ring.kind}{share}{radius}"


def finite(points: Array) -> Array:
    """Return the points, shape (2, n), that have both coordinates."""
    return np.asarray(points[:, np.all(np.isfinite(points), axis=0)])


def circular_error(misses: Array, share: float) -> float:
    """Return the radius about the goal that holds `share` of the misses, shape (2, n) [m]."""
    return float(np.quantile(np.hypot(*misses), share))


def ellipse(points: Array, share: float) -> Array:
    """Return the ellipse with the shape of the points' covariance that holds `share` of them, shape (2, 73).

    Its scale is the quantile of the points' Mahalanobis distances, so that it holds for any distribution; for a
    normal one it is √(−2 ln(1 − share)).
    """
    centre = points.mean(axis=1, keepdims=True)
    values, vectors = np.linalg.eigh(np.cov(points))
    root = vectors * np.sqrt(np.maximum(values, 1e-12)) @ vectors.T
    scale = float(np.quantile(np.linalg.norm(np.linalg.solve(root, points - centre), axis=0), share))
    return np.asarray(centre + scale * root @ circle((0.0, 0.0), 1.0))


def area(line: Array) -> float:
    """Return the area inside a closed line (shoelace formula); positive when it runs counter-clockwise [m²]."""
    east, north = line - line[:, :1]
    return float(0.5 * np.sum(east[:-1] * north[1:] - east[1:] * north[:-1]))


def track(tracks: Tracks, trial: int) -> Array:
    """Return the way points of one trial, shape (2, k); points that the trial does not have are left out [m]."""
    return finite(tracks.position[:, :, trial].T)


def median_trial(tracks: Tracks) -> int:
    """Find the trial that is nearest to the median.

    Of the trials that completed most phases, it is the one whose ends of phases lie nearest to their medians, each
    phase scaled by its own spread. Unlike a point-by-point median it is a track that a vehicle can take.
    """
    ends = np.array([_last(tracks.position[tracks.phase == phase]) for phase in np.unique(tracks.phase)])
    phases_done = np.all(np.isfinite(ends), axis=1).sum(axis=0)
    furthest = np.flatnonzero(phases_done == phases_done.max())
    done = ends[: phases_done.max()][:, :, furthest]
    deviation = np.hypot(*np.moveaxis(done - np.median(done, axis=2, keepdims=True), 1, 0))
    spread = np.maximum(np.median(deviation, axis=1, keepdims=True), 1e-9)
    return int(furthest[np.argmin(np.sum((deviation / spread) ** 2, axis=0))])


def _last(points: Array) -> Array:
    """Last point of each trial, shape (2, trials), among points of shape (points, 2, trials)."""
    has = np.all(np.isfinite(points), axis=1)
    last = len(points) - 1 - np.argmax(has[::-1], axis=0)
    return np.asarray(np.where(has.any(axis=0), points[last, :, np.arange(points.shape[2])].T, np.nan))
