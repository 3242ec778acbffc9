"""Maps of a simulated mission: tracks, goals and circles of error from above, and close-ups of where phases end."""

import math
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure as MatplotlibFigure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from missionplan.arrays import Array
from missionplan.exporters.maps.geometry import COLOURS
from missionplan.report.axes import name_axis
from missionplan.report.geography.plan_view import (
    Frame,
    Ring,
    draw_region,
    emptiest_corner,
    finite,
    frame,
    median_trial,
    north_and_scale,
    rings,
    track,
)
from missionplan.report.page import BLUE, GREEN, GREY, INK, ORANGE, PINK, SKY, YELLOW, Figure, to_figure
from missionplan.report.planned.site_map import name_goals
from missionplan.report.quantities import quantity
from missionplan.report.simulation.figures import WIDTH, draw_profile
from missionplan.report.wording import phase_in_words
from missionplan.results.decision import SeaChart
from missionplan.results.simulation import Outcome

_OF_RINGS = {"arrival circle": GREEN, "mooring circle": YELLOW, "CEP": BLUE, "mooring ellipse": PINK}
_DASHED = (0, (4, 2))
"""Line style of what holds 95 % of the trials."""


def draw_ring(axes: Axes, ring: Ring, line: Array, *, linewidth: float) -> None:
    """Draw the line of a circle or ellipse, shape (2, k), in the colour of its kind."""
    dashes = _DASHED if ring.share > 0.9 else "-"
    axes.plot(*line, color=_OF_RINGS[ring.kind], linestyle=dashes, linewidth=linewidth, label=ring.name)


def close_ups(outcome: Outcome) -> Figure | None:
    """Draw where each phase ends, about its goal; None where too few trials reach any goal."""
    drawn = [ring for ring in rings(outcome) if not math.isnan(ring.share)]
    names = [name for name in outcome.tracks.targets if any(ring.phase == name for ring in drawn)]
    if not names:
        return None
    figure, panels, spare = _panels(len(names))
    for axes, name in zip(panels, names, strict=True):
        _close_up(axes, outcome, name)
    _legend(figure, spare, {ring.kind for ring in rings(outcome)})
    words = "; ".join(
        f"{phase_in_words(ring.phase)} {100 * ring.share:.0f} % within {quantity(ring.radius, 'm', '.3g')}"
        for ring in drawn[:6]
    )
    return to_figure(
        figure,
        "arrivals",
        f"Where each phase ends, about its goal, with circles of error: {words}.",
        "True positions at the end of a transit, and of the anchors, about the goal (cross). CEP: the circle about the "
        "goal that holds that share of the trials that reached it. The mooring circle, too, is drawn about the goal; "
        "the mission's radius counts from the last fix.",
    )


def _panels(count: int) -> tuple[MatplotlibFigure, Sequence[Axes], Sequence[Axes]]:
    """Return a figure with so many panels, two in a row, and the panel that is left over, for the legend."""
    columns = min(2, count)
    rows = math.ceil(count / columns) if count > 1 else 2
    figure = MatplotlibFigure(figsize=(WIDTH, 2.5 * rows if count % 2 else 2.5 * rows + 0.7))
    axes = list(figure.subplots(rows, columns, squeeze=False).ravel())
    return figure, axes[:count], axes[count:]


def _legend(figure: MatplotlibFigure, spare: Sequence[Axes], kinds: set[str]) -> None:
    """Explain the lines in the spare panel, or below the figure where there is none."""
    handles = [Line2D([], [], color=colour, label=kind) for kind, colour in _OF_RINGS.items() if kind in kinds]
    handles.append(Line2D([], [], color=INK, linestyle="-", label="holds 50 %"))
    handles.append(Line2D([], [], color=INK, linestyle=_DASHED, label="holds 95 %"))
    for axes in spare:
        axes.axis("off")
        axes.legend(handles=handles, loc="center")
    if not spare:
        figure.legend(handles=handles, loc="outside lower center", ncols=2)


def _close_up(axes: Axes, outcome: Outcome, name: str) -> None:
    goal = np.array(outcome.tracks.targets[name][0])[:, None]
    ends = finite(outcome.arrivals[name])
    axes.plot(*ends[:, :500], ".", color=SKY, markersize=2.0, alpha=0.6, label="trials")
    axes.plot(0.0, 0.0, "+", color=INK, markersize=8)
    reach = 0.0
    for ring in rings(outcome):
        if ring.phase == name:
            line = ring.line - goal
            draw_ring(axes, ring, line, linewidth=1.4)
            reach = max(reach, float(np.abs(line).max()))
    limits = (-1.15 * reach, 1.15 * reach)
    axes.set(xlim=limits, ylim=limits, aspect="equal", title=phase_in_words(name))
    name_axis(axes.xaxis, "east", "m")
    name_axis(axes.yaxis, "north", "m")


_MAPPED = 200
"""Trials drawn."""


def mission_figure(outcome: Outcome) -> Figure:
    """Draw the mission as simulated: from above where it moves over ground, and its depth against time."""
    moves = moves_over_ground(outcome)
    heights = [0.6 + (WIDTH - 0.9) * _frame(outcome).shape, 1.9] if moves else [1.9]
    figure = MatplotlibFigure(figsize=(WIDTH, sum(heights)))
    panels = figure.subplots(len(heights), 1, squeeze=False, height_ratios=heights).ravel()
    if moves:
        draw_tracks(panels[0], outcome)
    draw_profile(panels[-1], outcome)
    seen = "from above, north up, and their depth against time" if moves else "as depth against time"
    failed = int(np.count_nonzero(~outcome.tracks.success[:_MAPPED]))
    count = min(outcome.tracks.success.size, _MAPPED)
    crosses = f" {failed} of them fail (orange, a cross where they end)." if failed else " None of them fails."
    lines = f" Circles and ellipses are those of the close-ups.{_place_in_words(outcome)}" if moves else ""
    astray = _frame(outcome).outliers_in_words() if moves else ""
    return to_figure(
        figure,
        "mission",
        f"{count} trials of the mission {seen}.{crosses}",
        f"{count} trials (light) {seen}; dark: the median trial.{crosses}{lines}{astray}",
        origin=outcome.tracks.origin,
    )


def moves_over_ground(outcome: Outcome) -> bool:
    """Whether any phase has somewhere to go."""
    return any(radius > 0.0 for _, radius in outcome.tracks.targets.values())


def _place_in_words(outcome: Outcome) -> str:
    if outcome.chart is None:
        return ""
    depths = " Grey lines: depth of the water at the start." if outcome.chart.depth is not None else ""
    kinds = {kind for kind, _ in outcome.chart.shapes}
    return f"{depths}{' Brown: land.' if 'land' in kinds else ''}{' Hatched: keep out.' if 'keep-out' in kinds else ''}"


def _draw_place(axes: Axes, chart: SeaChart, shown: Frame) -> None:
    """Draw depths, land and zones kept out of behind the tracks; of depths what is shown, so that labels are in it."""
    if chart.depth is not None:
        columns, rows = (
            slice(max(int(np.searchsorted(axis, low)) - 1, 0), int(np.searchsorted(axis, high)) + 1)
            for axis, (low, high) in ((chart.east, shown.west_east), (chart.north, shown.south_north))
        )
        east, north, water = chart.east[columns], chart.north[rows], np.ma.masked_invalid(chart.depth[rows, columns])
        if min(water.shape) > 1 and water.count():
            levels = MaxNLocator(6).tick_values(float(water.min()), float(water.max()))
            axes.contourf(east, north, -water, [0.0, 1e5], colors=[COLOURS["land"]], alpha=0.35, zorder=0.1)
            drawn = axes.contour(east, north, water, levels, colors=GREY, linewidths=0.5, zorder=0.2)
            axes.clabel(drawn, fontsize=7, fmt=lambda depth: quantity(depth, "m", "g"))
    for kind, outlines in chart.shapes:
        draw_region(axes, outlines, kind, zorder=0.3)


def _lines(outcome: Outcome) -> list[Array]:
    """Tracks that are drawn."""
    tracks = outcome.tracks
    return [track(tracks, trial) for trial in range(min(tracks.position.shape[2], _MAPPED))]


def _circles(outcome: Outcome) -> list[Array]:
    return [ring.line for ring in rings(outcome)]


def _frame(outcome: Outcome) -> Frame:
    return frame(_lines(outcome), _circles(outcome))


def draw_tracks(axes: Axes, outcome: Outcome) -> None:
    """Draw tracks, the median trial, circles and ellipses, the north arrow and a scale."""
    tracks, lines, shown = outcome.tracks, _lines(outcome), _frame(outcome)
    if outcome.chart is not None:
        _draw_place(axes, outcome.chart, shown)
    fails = ~tracks.success[: len(lines)]
    for failing, colour in ((False, SKY), (True, ORANGE)):
        drawn = [line.T for line, fail in zip(lines, fails, strict=True) if fail == failing]
        axes.add_collection(LineCollection(drawn, colors=colour, linewidths=0.5, alpha=0.45))
    for line in (line for line, fail in zip(lines, fails, strict=True) if fail and line.size):
        axes.plot(*line[:, -1], "x", color=ORANGE, markersize=4)
    middle = track(tracks, median_trial(tracks))
    axes.plot(*middle, color=INK, linewidth=1.2, marker="o", markersize=2.5, label="median trial")
    for ring in rings(outcome):
        draw_ring(axes, ring, ring.line, linewidth=1.0)
    name_goals(axes, outcome.provenance.data)
    axes.set(xlim=shown.west_east, ylim=shown.south_north, aspect="equal")
    name_axis(axes.xaxis, "east", "m")
    name_axis(axes.yaxis, "north", "m")
    north_and_scale(axes, shown.width, emptiest_corner([*lines, *_circles(outcome)], shown.limits))
