"""Map of a simulated mission: tracks, goals and circles of error, seen from above."""

import math
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure as MatplotlibFigure

from missionplan.arrays import Array
from missionplan.report.geography.plan_view import median_trial, rings, track
from missionplan.report.page import INK, ORANGE, SKY, Figure, to_figure
from missionplan.report.simulation.close_ups import draw_ring
from missionplan.report.simulation.figures import WIDTH
from missionplan.results.simulation import Outcome

_MAPPED = 200
"""Trials drawn."""


def track_map(outcome: Outcome) -> Figure:
    """Draw tracks from above, with goals, arrival circles, CEP and mooring ellipses."""
    lines, everything = _lines(outcome), _everything(outcome)
    figure = MatplotlibFigure(figsize=(WIDTH, _frame(np.concatenate(everything, axis=1))[2]))
    draw_tracks(figure.add_subplot(), outcome)
    return to_figure(
        figure,
        "track-map",
        f"Map of {len(lines)} trials from above, with the goals of the phases; axes in metres, north is up.",
        f"{len(lines)} trials (light), the median trial (orange, a dot at each fix), and the circles and ellipses that "
        "the close-ups below explain. Both axes have the same scale.",
    )


def _lines(outcome: Outcome) -> list[Array]:
    """Tracks that are drawn."""
    tracks = outcome.tracks
    return [track(tracks, trial) for trial in range(min(tracks.position.shape[2], _MAPPED))]


def _everything(outcome: Outcome) -> list[Array]:
    return [*_lines(outcome), *(ring.line for ring in rings(outcome))]


def draw_tracks(axes: Axes, outcome: Outcome) -> None:
    """Draw tracks, the median trial, circles and ellipses, the north arrow and a scale."""
    tracks, lines, everything = outcome.tracks, _lines(outcome), _everything(outcome)
    west_east, south_north, _ = _frame(np.concatenate(everything, axis=1))
    axes.add_collection(LineCollection([line.T for line in lines], colors=SKY, linewidths=0.5, alpha=0.45))
    middle = track(tracks, median_trial(tracks))
    axes.plot(*middle, color=ORANGE, linewidth=1.4, marker="o", markersize=2.5, label="median trial")
    for ring in rings(outcome):
        draw_ring(axes, ring, ring.line, linewidth=1.0)
    axes.set(xlim=west_east, ylim=south_north, xlabel="east (m)", ylabel="north (m)", aspect="equal")
    corner = _emptiest_corner(everything, np.array([west_east, south_north]))
    _north_and_scale(axes, west_east[1] - west_east[0], corner)


def _frame(points: Array) -> tuple[tuple[float, float], tuple[float, float], float]:
    """Limits east and north [m], and the figure's height [in], for equal scales and a shape neither flat nor tall."""
    low, high = points.min(axis=1), points.max(axis=1)
    centre, size = (low + high) / 2.0, np.maximum(high - low, 1.0) * 1.08
    size = np.maximum(size, np.array([0.8, 0.3]) * size[::-1])
    size[1] = max(size[1], 0.3 * size[0])
    west_east, south_north = np.stack((centre - size / 2.0, centre + size / 2.0), axis=1).tolist()
    return tuple(west_east), tuple(south_north), 0.6 + (WIDTH - 0.9) * float(size[1] / size[0])


def _emptiest_corner(lines: Sequence[Array], limits: Array) -> tuple[bool, bool]:
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


def _north_and_scale(axes: Axes, width: float, corner: tuple[bool, bool]) -> None:
    """Draw the north arrow in a corner, and a scale bar beside it."""
    right, top = corner
    side, away = (0.97, -1.0) if right else (0.03, 1.0)
    foot = 0.72 if top else 0.06
    arrow = {"arrowstyle": "-|>", "color": INK, "linewidth": 1.2}
    axes.annotate("", (side, foot + 0.24), (side, foot), xycoords="axes fraction", arrowprops=arrow)
    align = "right" if right else "left"
    axes.text(side + 0.02 * away, foot + 0.1, "N", ha=align, weight="bold", transform=axes.transAxes, va="bottom")
    length = _round_length(0.25 * width)
    start = side + 0.08 * away
    end = start + away * length / width
    axes.plot([start, end], [foot, foot], transform=axes.transAxes, color=INK, linewidth=2.5)
    middle = 0.5 * (start + end)
    axes.text(middle, foot + 0.03, f"{length:g} m", ha="center", transform=axes.transAxes, va="bottom")


def _round_length(length: float) -> float:
    """Largest of 1, 2, 5 × 10ⁿ up to `length`."""
    power = 10.0 ** math.floor(math.log10(length))
    return max(step * power for step in (1.0, 2.0, 5.0) if step * power <= length)
