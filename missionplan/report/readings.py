"""What a figure shows, for the page's script: axes with their scales, curves, points and bars, series to switch off."""

import json
import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.container import BarContainer
from matplotlib.patches import StepPatch

from missionplan.arrays import Array
from missionplan.mission.schema.place import Geographic, to_geographic
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
_HALF_A_STEP = 0.5
"""Within which of a bar's middle its name stands, on an axis of names, one a whole number."""


@dataclass(frozen=True)
class Slider:
    """A control along a figure's horizontal axis: at each place, what the page says of it."""

    label: str
    """What it moves over."""
    places: Sequence[float]
    """On the horizontal axis of the figure's first axes, increasing."""
    texts: Sequence[str]
    """One for each place."""
    start: int = 0
    """Index of the place at which it stands first."""


@dataclass(frozen=True)
class Shown:
    """What a page adds to a figure."""

    slider: Slider | None = None
    origin: tuple[float, float] | None = None
    """Latitude and longitude of the origin of a map's metres [rad]."""


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


def readings(figure: "MatplotlibFigure", series: dict[str, list[str]], shown: Shown) -> str:
    """Write what a drawn figure shows as JSON; empty where nothing can be read off it."""
    panels = [panel for axes in figure.axes if (panel := _panel(figure, axes, shown.origin)) is not None]
    if not panels:
        return ""
    contents: dict[str, object] = {"axes": panels}
    if len(series) > 1:
        contents["series"] = [{"name": name, "ids": ids} for name, ids in series.items()]
    if (slider := shown.slider) is not None:
        contents["slider"] = {
            "label": slider.label,
            "x": [_short(place / size_of_unit(figure.axes[0].xaxis)) for place in slider.places],
            "text": list(slider.texts),
            "start": slider.start,
        }
    return json.dumps(contents, ensure_ascii=False, separators=(",", ":"), allow_nan=False)


def _panel(figure: "MatplotlibFigure", axes: "Axes", origin: tuple[float, float] | None) -> dict[str, object] | None:
    """Box in points from the top left, limits, scales and labels of one axes, and the data drawn on it."""
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
    panel: dict[str, object] = {
        "box": [round(edge, 1) for edge in box],
        "x": x or {"lim": list(map(_short, axes.get_xlim()))},
        "y": y or {"lim": list(map(_short, axes.get_ylim()))},
        "lines": list(_lines(axes)) if x and y else [],
        "bars": list(_bars(axes)),
    }
    if origin is not None and axes.get_aspect() == 1.0:
        panel["earth"] = _earth(axes, origin)
    return panel


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
    """Curves and points; of an axes that names some of its curves, the named ones alone."""
    named = any(not str(line.get_label()).startswith("_") for line in axes.lines)
    for line in axes.lines:
        is_point = line.get_linestyle() == "None"
        if named and str(line.get_label()).startswith("_") and not is_point:
            continue
        points = np.array([np.asarray(line.get_xdata(), dtype=float), np.asarray(line.get_ydata(), dtype=float)])
        points /= np.array([[size_of_unit(axes.xaxis)], [size_of_unit(axes.yaxis)]])
        if line.get_transform() == axes.transData and (is_point or points.shape[1] >= _LEAST_POINTS):
            label = str(line.get_label())
            yield {"name": "" if label.startswith("_") else typeset(label), "points": _thinned(points)}


def _bars(axes: "Axes") -> Iterator[dict[str, object]]:
    """Bars with their corners and what they show: a bar's length, or of a histogram the share of each bin."""
    sizes = (size_of_unit(axes.xaxis), size_of_unit(axes.yaxis))
    for container in axes.containers:
        if isinstance(container, BarContainer):
            lying = container.orientation == "horizontal"
            for bar in container.patches:
                low, length = (bar.get_x(), bar.get_width()) if lying else (bar.get_y(), bar.get_height())
                at, thick = (bar.get_y(), bar.get_height()) if lying else (bar.get_x(), bar.get_width())
                along, across = (axes.xaxis, axes.yaxis) if lying else (axes.yaxis, axes.xaxis)
                name = _tick_at(across, at + 0.5 * thick)
                words = _with_unit(along, length / size_of_unit(along))
                span = ((low, low + length), (at, at + thick))
                yield _bar(span if lying else span[::-1], sizes, f"{name}: {words}" if name else words)
    for patch in axes.patches:
        if isinstance(patch, StepPatch):
            heights, edges, _ = patch.get_data()
            for height, left, right in zip(heights, edges[:-1], edges[1:], strict=True):
                ends = _with_unit(axes.xaxis, left / sizes[0], right / sizes[0])
                text = f"{ends}: {_with_unit(axes.yaxis, height / sizes[1])}"
                yield _bar(((left, right), (0.0, axes.get_ylim()[1])), sizes, text)


def _bar(
    span: tuple[tuple[float, float], tuple[float, float]], sizes: tuple[float, float], text: str
) -> dict[str, object]:
    """Bar with its ends along both axes, in the reader's units."""
    ends = [_short(end / size) for pair, size in zip(span, sizes, strict=True) for end in sorted(pair)]
    return {"ends": ends, "text": typeset(text)}


def _tick_at(axis: "Axis", place: float) -> str:
    """Label of the tick at a place, of an axis of names; empty on one of numbers, or where there is none."""
    if has_numbers(axis):
        return ""
    near = [
        text.get_text()
        for at, text in zip(axis.get_ticklocs(), axis.get_ticklabels(), strict=False)
        if abs(at - place) < _HALF_A_STEP
    ]
    return " ".join(near[0].split()) if near else ""


def _with_unit(axis: "Axis", *values: float) -> str:
    """Write values of an axis with the unit that its label ends with."""
    unit = re.search(r"\(([^()]*)\)$", axis.label.get_text().strip())
    return " to ".join(f"{value:.4g}" for value in values) + (f" {unit[1]}" if unit else "")


def _earth(axes: "Axes", origin: tuple[float, float]) -> list[list[float]]:
    """Latitude and longitude at the origin of a map's axes, and their change along each [deg].

    Linear over the map, which within 10 km of its middle is right to a few metres.
    """
    (west, east), (south, north) = axes.get_xlim(), axes.get_ylim()
    sizes = (size_of_unit(axes.xaxis), size_of_unit(axes.yaxis))
    corners = np.array([[west, east, west], [south, south, north]])
    place = Geographic.model_construct(latitude=origin[0], longitude=origin[1])
    angles = np.degrees(to_geographic(corners[0], corners[1], place))
    a, b, c = angles.T
    dx, dy = (b - a) * sizes[0] / (east - west), (c - a) * sizes[1] / (north - south)
    zero = a - dx * west / sizes[0] - dy * south / sizes[1]
    return [[round(float(value), 10) for value in row] for row in zip(zero, dx, dy, strict=True)]


def _thinned(points: Array) -> list[list[float]]:
    points = points[:, np.all(np.isfinite(points), axis=0)]
    step = max(1, math.ceil(points.shape[1] / _MOST_POINTS))
    return [[_short(x), _short(y)] for x, y in points[:, ::step].T]


def _short(value: float) -> float:
    return float(f"{value:.5g}")
