"""Where a simulated mission goes, in plan."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from missionplan.arrays import Array
from missionplan.report.geography.plan_view import (
    Ring,
    finite,
    median_trial,
    rings,
    track,
)
from missionplan.report.page import BLUE, GREEN, INK, ORANGE, PINK, SKY, YELLOW, Figure, to_figure
from missionplan.report.simulation.figures import WIDTH
from missionplan.results.simulation import Outcome

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_MAPPED = 200
_LOOKS = {"arrival circle": GREEN, "mooring circle": YELLOW, "CEP": BLUE, "mooring ellipse": PINK}
_OUTER = (0, (4, 2))
"""Dashes of what holds 95 %."""


def track_map(outcome: Outcome) -> Figure:
    """Show tracks in plan, with goals, arrival circles, CEP and mooring ellipses."""
    from matplotlib.collections import LineCollection
    from matplotlib.figure import Figure as MatplotlibFigure

    tracks = outcome.tracks
    shown = min(tracks.position.shape[2], _MAPPED)
    lines = [track(tracks, trial) for trial in range(shown)]
    middle = track(tracks, median_trial(tracks))
    drawn = list(rings(outcome))
    everything = np.concatenate([*lines, *(ring.line for ring in drawn)], axis=1)
    west_east, south_north, height = _frame(everything)
    figure = MatplotlibFigure(figsize=(WIDTH, height))
    axes = figure.add_subplot()
    axes.add_collection(LineCollection([line.T for line in lines], colors=SKY, linewidths=0.5, alpha=0.45))
    axes.plot(*middle, color=ORANGE, linewidth=1.4, marker="o", markersize=2.5, label="median trial")
    for ring in drawn:
        axes.plot(*ring.line, **_look(ring), linewidth=1.0)
    axes.set(xlim=west_east, ylim=south_north, xlabel="east (m)", ylabel="north (m)", aspect="equal")
    corner = _emptiest_corner([*lines, *(ring.line for ring in drawn)], np.array([west_east, south_north]))
    _north_and_scale(axes, west_east[1] - west_east[0], corner)
    return to_figure(
        figure,
        "track-map",
        f"Map of {shown} trials from above, with the goals of the phases; axes in metres, north is up.",
        f"{shown} trials (light), the median trial (orange, a dot at each fix), and the circles and ellipses that the "
        "close-ups below explain. Axes are equal.",
    )


def _frame(points: Array) -> tuple[tuple[float, float], tuple[float, float], float]:
    """Limits east and north [m], and the figure's height [in], for equal axes that are not too flat or too tall."""
    low, high = points.min(axis=1), points.max(axis=1)
    centre, size = (low + high) / 2.0, np.maximum(high - low, 1.0) * 1.08
    size = np.maximum(size, np.array([0.8, 0.3]) * size[::-1])
    size[1] = max(size[1], 0.3 * size[0])
    west_east, south_north = np.stack((centre - size / 2.0, centre + size / 2.0), axis=1).tolist()
    return tuple(west_east), tuple(south_north), 0.6 + (WIDTH - 0.9) * float(size[1] / size[0])


def _look(ring: Ring) -> dict[str, Any]:
    return {"color": _LOOKS[ring.kind], "linestyle": _OUTER if ring.share > 0.9 else "-"}


def _emptiest_corner(lines: Sequence[Array], limits: Array) -> tuple[bool, bool]:
    """Find the corner, (right, top), that the fewest way points and points between them fall into."""
    dense = [_between(line) for line in lines if line.shape[1]]
    across, up = (np.concatenate(dense, axis=1) - limits[:, :1]) / (limits[:, 1:] - limits[:, :1])
    corners = [(right, top) for right in (False, True) for top in (True, False)]
    crowd = [
        np.count_nonzero(((across > 0.6) if right else (across < 0.4)) & ((up > 0.65) if top else (up < 0.35)))
        for right, top in corners
    ]
    return corners[int(np.argmin(crowd))]


def _between(line: Array) -> Array:
    """Points along a line, ten a stretch."""
    stretch = np.arange(line.shape[1])
    fine = np.linspace(0.0, line.shape[1] - 1.0, 10 * line.shape[1])
    return np.array([np.interp(fine, stretch, values) for values in line])


def _north_and_scale(axes: "Axes", width: float, corner: tuple[bool, bool]) -> None:
    """Draw the north arrow in a corner, and a scale bar beside it."""
    right, top = corner
    side, away = (0.97, -1.0) if right else (0.03, 1.0)
    foot = 0.72 if top else 0.06
    arrow = {"arrowstyle": "-|>", "color": INK, "linewidth": 1.2}
    axes.annotate("", (side, foot + 0.24), (side, foot), xycoords="axes fraction", arrowprops=arrow)
    words: dict[str, Any] = {"transform": axes.transAxes, "va": "bottom"}
    axes.text(side + 0.02 * away, foot + 0.1, "N", ha="right" if right else "left", weight="bold", **words)
    length = _nice(0.25 * width)
    start = side + 0.08 * away
    end = start + away * length / width
    axes.plot([start, end], [foot, foot], transform=axes.transAxes, color=INK, linewidth=2.5)
    axes.text(0.5 * (start + end), foot + 0.03, f"{length:g} m", ha="center", **words)


def _nice(length: float) -> float:
    """Largest of 1, 2, 5 × 10ⁿ up to `length`."""
    power = 10.0 ** math.floor(math.log10(length))
    return max(step * power for step in (1.0, 2.0, 5.0) if step * power <= length)


def close_ups(outcome: Outcome) -> Figure | None:
    """Show where each phase ends, about its goal."""
    from matplotlib.figure import Figure as MatplotlibFigure
    from matplotlib.lines import Line2D

    drawn = [ring for ring in rings(outcome) if not math.isnan(ring.share)]
    names = [name for name in outcome.tracks.targets if any(ring.phase == name for ring in drawn)]
    if not names:
        return None
    columns = min(2, len(names))
    rows = math.ceil(len(names) / columns) if len(names) > 1 else 2
    figure = MatplotlibFigure(figsize=(WIDTH, 2.5 * rows if len(names) % 2 else 2.5 * rows + 0.7))
    panels = figure.subplots(rows, columns, squeeze=False).ravel()
    for axes, name in zip(panels, names, strict=False):
        _close_up(axes, outcome, name)
    kinds = sorted({ring.kind for ring in rings(outcome)}, key=list(_LOOKS).index)
    handles = [Line2D([], [], color=_LOOKS[kind], label=kind) for kind in kinds]
    lines: tuple[tuple[Any, str], ...] = (("-", "holds 50 %"), (_OUTER, "holds 95 %"))
    handles += [Line2D([], [], color=INK, linestyle=style, label=text) for style, text in lines]
    for axes in panels[len(names) :]:
        axes.axis("off")
        axes.legend(handles=handles, loc="center")
    if len(panels) == len(names):
        figure.legend(handles=handles, loc="outside lower center", ncols=2)
    words = "; ".join(f"{ring.phase} {100 * ring.share:.0f} % within {ring.radius:.3g} m" for ring in drawn[:6])
    return to_figure(
        figure,
        "arrivals",
        f"Where each phase ends, about its goal, with circles of error: {words}.",
        "True positions at the end of a transit, and of the anchors, about the goal (cross). CEP: the circle about the "
        "goal that holds that share of the trials that came so far. The mooring circle, too, is drawn about the goal; "
        "the mission's radius counts from the last fix.",
    )


def _close_up(axes: "Axes", outcome: Outcome, name: str) -> None:
    goal = np.array(outcome.tracks.targets[name][0])[:, None]
    ends = finite(outcome.arrivals[name])
    axes.plot(*ends[:, :500], ".", color=SKY, markersize=2.0, alpha=0.6)
    axes.plot(0.0, 0.0, "+", color=INK, markersize=8)
    reach = 0.0
    for ring in rings(outcome):
        if ring.phase == name:
            axes.plot(*(ring.line - goal), **_look(ring), linewidth=1.4)
            reach = max(reach, float(np.abs(ring.line - goal).max()))
    limits = (-1.15 * reach, 1.15 * reach)
    axes.set(xlim=limits, ylim=limits, aspect="equal", title=name, xlabel="east (m)", ylabel="north (m)")
