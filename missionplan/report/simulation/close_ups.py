"""Close-ups of where each phase of a simulated mission ends, about its goal."""

import math
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as MatplotlibFigure
from matplotlib.lines import Line2D

from missionplan.arrays import Array
from missionplan.report.axes import name_axis
from missionplan.report.geography.plan_view import Ring, finite, rings
from missionplan.report.page import BLUE, GREEN, INK, PINK, SKY, YELLOW, Figure, to_figure
from missionplan.report.quantities import quantity
from missionplan.report.simulation.figures import WIDTH
from missionplan.report.wording import phase_in_words
from missionplan.results.simulation import Outcome

_COLOURS = {"arrival circle": GREEN, "mooring circle": YELLOW, "CEP": BLUE, "mooring ellipse": PINK}
_DASHED = (0, (4, 2))
"""Line style of what holds 95 % of the trials."""


def draw_ring(axes: Axes, ring: Ring, line: Array, *, linewidth: float) -> None:
    """Draw the line of a circle or ellipse, shape (2, k), in the colour of its kind."""
    axes.plot(*line, color=_COLOURS[ring.kind], linestyle=_DASHED if ring.share > 0.9 else "-", linewidth=linewidth)


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
    handles = [Line2D([], [], color=colour, label=kind) for kind, colour in _COLOURS.items() if kind in kinds]
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
    axes.plot(*ends[:, :500], ".", color=SKY, markersize=2.0, alpha=0.6)
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
