"""What a figure shows, for the page's script: axes with their scales, curves to read off, series to switch off."""

import json
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from missionplan.arrays import Array
from missionplan.report.axes import has_numbers, size_of_unit
from missionplan.report.wording import typeset

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure as MatplotlibFigure

_MOST_POINTS = 200
"""Of a curve; more are not told apart on a screen."""
_LEAST_POINTS = 3


@dataclass(frozen=True)
class Slider:
    """A control along a figure's horizontal axis: at each place, what the page says of it.

    Attributes
    ----------
    label : str
        What it moves over.
    places : sequence of float
        On the horizontal axis of the figure's first axes, increasing.
    texts : sequence of str
        One for each place.
    start : int
        Index of the place at which it stands first.
    """

    label: str
    places: Sequence[float]
    texts: Sequence[str]
    start: int = 0


def name_series(figure: "MatplotlibFigure") -> dict[str, list[str]]:
    """Give every labelled artist an id; returns the ids of each label. To be called before the figure is drawn."""
    series: dict[str, list[str]] = {}
    for number, (label, artist) in enumerate(_labelled(figure)):
        identity = f"series-{number}"
        artist.set_gid(identity)
        series.setdefault(label, []).append(identity)
    return series


def _labelled(figure: "MatplotlibFigure") -> Iterator[tuple[str, "Artist"]]:
    for axes in figure.axes:
        for container in axes.containers:
            label = str(container.get_label())
            if label and not label.startswith("_"):
                yield from ((typeset(label), child) for child in container.get_children())
        for artist in (*axes.lines, *axes.collections, *axes.patches):
            label = str(artist.get_label())
            if label and not label.startswith("_"):
                yield typeset(label), artist


def readings(figure: "MatplotlibFigure", series: dict[str, list[str]], slider: Slider | None) -> str:
    """Write what a drawn figure shows as JSON; empty where nothing can be read off it."""
    panels = [panel for axes in figure.axes if (panel := _panel(figure, axes)) is not None]
    if not panels:
        return ""
    found: dict[str, object] = {"axes": panels}
    if len(series) > 1:
        found["series"] = [{"name": name, "ids": ids} for name, ids in series.items()]
    if slider is not None:
        found["slider"] = {
            "label": slider.label,
            "x": [_short(place / size_of_unit(figure.axes[0].xaxis)) for place in slider.places],
            "text": list(slider.texts),
            "start": slider.start,
        }
    return json.dumps(found, ensure_ascii=False, separators=(",", ":"), allow_nan=False)


def _panel(figure: "MatplotlibFigure", axes: "Axes") -> dict[str, object] | None:
    """Box in points from the top left, limits, scales, labels and curves of one axes."""
    if axes.name != "rectilinear" or not axes.get_visible() or not axes.axison:
        return None
    across = [other.xaxis for other in axes.get_shared_x_axes().get_siblings(axes)]
    up = [other.yaxis for other in axes.get_shared_y_axes().get_siblings(axes)]
    x, y = _dimension(axes.xaxis, across, axes.get_xlim()), _dimension(axes.yaxis, up, axes.get_ylim())
    if x is None and y is None:
        return None
    width, height = figure.get_size_inches() * 72.0
    place = axes.get_position()
    box = [place.x0 * width, (1.0 - place.y1) * height, place.width * width, place.height * height]
    return {"box": [round(edge, 1) for edge in box], "x": x, "y": y, "lines": list(_lines(axes)) if x and y else []}


def _dimension(axis: "Axis", shared: Sequence["Axis"], limits: tuple[float, float]) -> dict[str, object] | None:
    """Limits, scale and label of an axis, or of one that shares it; None where it has no label or no numbers."""
    label = axis.label.get_text() or next(filter(None, (other.label.get_text() for other in shared)), "")
    if not label or not has_numbers(axis):
        return None
    size = size_of_unit(axis)
    return {
        "lim": [_short(limit / size) for limit in limits],
        "log": axis.get_scale() == "log",
        "label": " ".join(label.split()),
    }


def _lines(axes: "Axes") -> Iterator[dict[str, object]]:
    named = any(not str(line.get_label()).startswith("_") for line in axes.lines)
    for line in axes.lines:
        if named and str(line.get_label()).startswith("_"):
            continue
        points = np.array([np.asarray(line.get_xdata(), dtype=float), np.asarray(line.get_ydata(), dtype=float)])
        points /= np.array([[size_of_unit(axes.xaxis)], [size_of_unit(axes.yaxis)]])
        if line.get_transform() == axes.transData and points.shape[1] >= _LEAST_POINTS:
            label = str(line.get_label())
            yield {"name": "" if label.startswith("_") else typeset(label), "points": _thinned(points)}


def _thinned(points: Array) -> list[list[float]]:
    points = points[:, np.all(np.isfinite(points), axis=0)]
    step = max(1, math.ceil(points.shape[1] / _MOST_POINTS))
    return [[_short(x), _short(y)] for x, y in points[:, ::step].T]


def _short(value: float) -> float:
    return float(f"{value:.5g}")
