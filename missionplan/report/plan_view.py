"""A mission seen from above: tracks, circles of error, mooring ellipses, and the frame of a map."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgba
from matplotlib.patches import PathPatch
from matplotlib.path import Path

from missionplan.arrays import Array
from missionplan.exporters.geojson import COLOURS, circle
from missionplan.report.axes import round_length
from missionplan.report.page import BLUE, GREEN, INK, PINK, SKY, YELLOW
from missionplan.report.quantities import quantity
from missionplan.report.wording import phase_in_words
from missionplan.results.simulation import Outcome, Tracks

WIDTH = 5.0
"""Of a figure [in], so that its text can be read on a telephone."""
SHARES = (0.5, 0.95)
"""Shares of the trials that circles and ellipses hold."""
_LEAST_POINTS = 10
"""Ends of a phase below which no share is drawn."""


@dataclass(frozen=True)
class Ring:
    """A closed line about where the trials end."""

    kind: str
    """``arrival circle`` or ``CEP`` of a transit, ``mooring circle`` or ``mooring ellipse`` of a mooring."""
    phase: str
    """Name of the phase."""
    share: float
    """Share of the trials inside; nan for a circle that the mission sets."""
    radius: float
    """Of a circle; for an ellipse, of the circle of equal area [m]."""
    line: Array
    """East and north, counter-clockwise, the last point equal to the first, shape (2, k) [m]."""

    @property
    def name(self) -> str:
        """Its kind, and the share of the trials that it holds."""
        return self.kind if math.isnan(self.share) else f"{self.kind}, {100.0 * self.share:.0f}\u00a0%"


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


_ASTRAY = 1.0
"""A track is astray that goes beyond where 95 % of them go by more than this share of those tracks' extent."""
_INSIDE = 0.95


@dataclass(frozen=True)
class Frame:
    """Limits of a map with equal scales."""

    west_east: tuple[float, float]
    south_north: tuple[float, float]
    """[m]"""
    shape: float
    """Height over width."""
    astray: int = 0
    """Tracks that leave it."""
    farthest: float = 0.0
    """How far beyond its edge the farthest of them goes [m]."""

    @property
    def width(self) -> float:
        """Of the map [m]."""
        return self.west_east[1] - self.west_east[0]

    @property
    def limits(self) -> Array:
        """West, east; south, north: shape (2, 2) [m]."""
        return np.array([self.west_east, self.south_north])

    def outliers_in_words(self) -> str:
        """Say which tracks the map does not show whole, where there are any."""
        if not self.astray:
            return ""
        tracks = "1 trial leaves" if self.astray == 1 else f"{self.astray} trials leave"
        return f" {tracks} the map, the farthest by {_rounded(self.farthest)}."


def _rounded(metres: float) -> str:
    kilometres = metres / 1000.0
    if kilometres < 1.0:
        return quantity(metres, "m", ".0f")
    return quantity(kilometres, "km", ".0f" if kilometres >= 10.0 else ".1f")


def frame(tracks: Sequence[Array], always: Sequence[Array] = (), tallest: float = 1.25) -> Frame:
    """Choose the limits of a map, of a shape neither flat nor tall.

    `tracks`, shape (2, k): of trials; those that go astray do not count. `always`, shape (2, k): lines that lie inside
    whatever happens, such as the circles about goals. `tallest`: most that its height may be of its width.
    """
    low, high, astray = _usual([track for track in tracks if track.shape[1]])
    for line in (line for line in always if line.shape[1]):
        low, high = np.minimum(low, line.min(axis=1)), np.maximum(high, line.max(axis=1))
    centre, size = (low + high) / 2.0, np.maximum(high - low, 1.0) * 1.08
    size = np.maximum(size, np.array([1.0 / tallest, 0.3]) * size[::-1])
    size[1] = max(size[1], 0.3 * size[0])
    lower, upper = centre - size / 2.0, centre + size / 2.0
    beyond = [float(np.maximum(lower[:, None] - track, track - upper[:, None]).max()) for track in astray]
    outside = [distance for distance in beyond if distance > 0.0]
    return Frame(
        (float(lower[0]), float(upper[0])),
        (float(lower[1]), float(upper[1])),
        float(size[1] / size[0]),
        len(outside),
        max(outside, default=0.0),
    )


def _usual(tracks: Sequence[Array]) -> tuple[Array, Array, list[Array]]:
    """Return the corners of what all tracks but those astray span, and the tracks that are."""
    if not tracks:
        return np.full(2, np.inf), np.full(2, -np.inf), []
    lows, highs = (np.array([edge(track, axis=1) for track in tracks]).T for edge in (np.min, np.max))
    low, high = np.quantile(lows, 1.0 - _INSIDE, axis=1), np.quantile(highs, _INSIDE, axis=1)
    reach = _ASTRAY * float(np.max(high - low))
    strays = np.any(lows < (low - reach)[:, None], axis=0) | np.any(highs > (high + reach)[:, None], axis=0)
    usual = ~strays if not strays.all() else np.ones_like(strays)
    astray = [track for track, stray in zip(tracks, ~usual, strict=True) if stray]
    return lows[:, usual].min(axis=1), highs[:, usual].max(axis=1), astray


def emptiest_corner(lines: Sequence[Array], limits: Array) -> tuple[bool, bool]:
    """Find the corner, (right, top), into which the fewest way points and points between them fall."""
    dense = [_between(line) for line in lines if line.shape[1]]
    across, up = (np.concatenate(dense, axis=1) - limits[:, :1]) / (limits[:, 1:] - limits[:, :1])
    corners = [(right, top) for right in (False, True) for top in (True, False)]
    crowd = [
        np.count_nonzero(((across > 0.6) if right else (across < 0.4)) & ((up > 0.65) if top else (up < 0.35)))
        for right, top in corners
    ]
    return corners[int(np.argmin(crowd))]


def _between(line: Array) -> Array:
    """Points along a line, ten per segment."""
    segment = np.arange(line.shape[1])
    fine = np.linspace(0.0, line.shape[1] - 1.0, 10 * line.shape[1])
    return np.array([np.interp(fine, segment, values) for values in line])


def north_and_scale(axes: Axes, width: float, corner: tuple[bool, bool]) -> None:
    """Draw the north arrow in a corner, and a scale bar beside it."""
    right, top = corner
    side, away = (0.97, -1.0) if right else (0.03, 1.0)
    foot = 0.8 if top else 0.06  # above the names of a flat map
    arrow = {"arrowstyle": "-|>", "color": INK, "linewidth": 1.2}
    axes.annotate("", (side, foot + 0.18), (side, foot), xycoords="axes fraction", arrowprops=arrow)
    align = "right" if right else "left"
    axes.text(side + 0.02 * away, foot + 0.04, "N", ha=align, weight="bold", transform=axes.transAxes, va="bottom")
    length, words = round_length(0.25 * width)
    start = side + 0.08 * away
    end = start + away * length / width
    axes.plot([start, end], [foot, foot], transform=axes.transAxes, color=INK, linewidth=2.5)
    axes.text(0.5 * (start + end), foot + 0.03, words, ha="center", transform=axes.transAxes, va="bottom")


def draw_region(axes: Axes, outlines: Sequence[Array], kind: str, zorder: float) -> None:
    """Draw land, shoal water or a zone kept out of: a polygon's outline, then its holes, shape (k, 2) each [m]."""
    shape = Path.make_compound_path(*(Path(ring, closed=True) for ring in outlines))
    if kind == "keep-out":  # lines alone: a fill of their colour would hide them
        style = {"facecolor": "none", "edgecolor": to_rgba(COLOURS[kind], 0.5), "hatch": "//"}
    else:
        style = {
            "facecolor": to_rgba(SKY, 0.15) if kind == "shoal" else to_rgba(COLOURS[kind], 0.4),
            "edgecolor": "none",
        }
    axes.add_patch(PathPatch(shape, zorder=zorder, **style))


_OF_RINGS = {"arrival circle": GREEN, "mooring circle": YELLOW, "CEP": BLUE, "mooring ellipse": PINK}


_DASHED = (0, (4, 2))
"""Line style of what holds 95 % of the trials."""


def draw_ring(axes: Axes, ring: Ring, line: Array, *, linewidth: float) -> None:
    """Draw the line of a circle or ellipse, shape (2, k), in the colour of its kind."""
    dashes = _DASHED if ring.share > 0.9 else "-"
    axes.plot(*line, color=_OF_RINGS[ring.kind], linestyle=dashes, linewidth=linewidth, label=ring.name)
