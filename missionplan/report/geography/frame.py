"""The frame of a map: limits that one trial gone astray does not set, a north arrow and a scale bar."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes

from missionplan.arrays import Array
from missionplan.report.axes import round_length
from missionplan.report.page import INK
from missionplan.report.quantities import quantity

_ASTRAY = 1.0
"""A track is astray that goes beyond where 95 % of them go by more than this share of those tracks' extent."""
_INSIDE = 0.95


@dataclass(frozen=True)
class Frame:
    """Limits of a map with equal scales.

    Attributes
    ----------
    west_east, south_north : (float, float)
        [m]
    shape : float
        Height over width.
    astray : int
        Tracks that leave it.
    farthest : float
        How far beyond its edge the farthest of them goes [m].
    """

    west_east: tuple[float, float]
    south_north: tuple[float, float]
    shape: float
    astray: int = 0
    farthest: float = 0.0

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


def frame(tracks: Sequence[Array], always: Sequence[Array] = ()) -> Frame:
    """Choose the limits of a map, of a shape neither flat nor tall.

    Parameters
    ----------
    tracks : sequence of array, shape (2, k)
        Of trials; those that go astray do not count.
    always : sequence of array, shape (2, k)
        Lines that lie inside whatever happens, such as the circles about goals.
    """
    low, high, astray = _usual([track for track in tracks if track.shape[1]])
    for line in (line for line in always if line.shape[1]):
        low, high = np.minimum(low, line.min(axis=1)), np.maximum(high, line.max(axis=1))
    centre, size = (low + high) / 2.0, np.maximum(high - low, 1.0) * 1.08
    size = np.maximum(size, np.array([0.8, 0.3]) * size[::-1])
    size[1] = max(size[1], 0.3 * size[0])
    lower, upper = centre - size / 2.0, centre + size / 2.0
    beyond = [_beyond(track, lower, upper) for track in astray]
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


def _beyond(track: Array, lower: Array, upper: Array) -> float:
    outside = np.maximum(lower[:, None] - track, track - upper[:, None])
    return float(outside.max())


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
    foot = 0.72 if top else 0.06
    arrow = {"arrowstyle": "-|>", "color": INK, "linewidth": 1.2}
    axes.annotate("", (side, foot + 0.24), (side, foot), xycoords="axes fraction", arrowprops=arrow)
    align = "right" if right else "left"
    axes.text(side + 0.02 * away, foot + 0.1, "N", ha=align, weight="bold", transform=axes.transAxes, va="bottom")
    length, words = round_length(0.25 * width)
    start = side + 0.08 * away
    end = start + away * length / width
    axes.plot([start, end], [foot, foot], transform=axes.transAxes, color=INK, linewidth=2.5)
    axes.text(0.5 * (start + end), foot + 0.03, words, ha="center", transform=axes.transAxes, va="bottom")
