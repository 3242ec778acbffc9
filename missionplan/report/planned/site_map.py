"""The site on a map: where the mission starts, its goals, the straight way, and how the surface current sets."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import chain, pairwise
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as MatplotlibFigure
from matplotlib.patheffects import AbstractPathEffect, withStroke
from matplotlib.text import Annotation

from missionplan.exporters.maps.geometry import circle
from missionplan.mission.geodesy import to_plane
from missionplan.mission.schema.site import Geographic
from missionplan.mission.units import QuantityError, parse_number_with_unit
from missionplan.report.axes import name_axis
from missionplan.report.geography.frame import emptiest_corner, frame, north_and_scale
from missionplan.report.page import BLUE, GREEN, INK, ORANGE, Figure, to_figure
from missionplan.report.planned.chart import draw_chart
from missionplan.report.quantities import quantity
from missionplan.results.plain_data import mapping, mappings

_WIDTH = 5.0
_NAME_BELOW = 0.08
"""Room that a name below its place takes, of the map's longer side."""
Point = tuple[float, float]
"""East and north of the origin [m]."""


@dataclass(frozen=True)
class Goal:
    """A point that the mission names: the start, where a transit ends, where it moors.

    Attributes
    ----------
    name : str
    place : (float, float)
        East and north of the origin [m].
    radius : float
        Within which it is reached, or the anchor may lie; 0 for the start [m].
    """

    name: str
    place: Point
    radius: float


def site_map(data: Mapping[str, object]) -> Figure | None:
    """Draw the site of a mission; None where no transit says where it goes."""
    goals = list(_goals(data))
    if len(goals) < 2:
        return None
    way = np.array([goal.place for goal in goals]).T
    circles = [circle(goal.place, goal.radius) for goal in goals if goal.radius]
    named = list(_names(goals))
    shown = frame([], [way, *circles, *_room_for_names(named, way)])
    figure = MatplotlibFigure(figsize=(_WIDTH, 0.6 + (_WIDTH - 0.9) * shown.shape))
    axes = figure.add_subplot()
    axes.set(xlim=shown.west_east, ylim=shown.south_north, aspect="equal")
    name_axis(axes.xaxis, "east", "m")
    name_axis(axes.yaxis, "north", "m")
    problem = _draw_chart(axes, data)
    for start, end in pairwise(goals):
        axes.plot(*zip(start.place, end.place, strict=True), color=BLUE, linewidth=1.4)
    for line in circles:
        axes.plot(*line, color=ORANGE, linewidth=1.2)
    _write_names(axes, named, way)
    north_and_scale(axes, shown.width, emptiest_corner([way, *circles], shown.limits))
    if _has_picture(data):
        _on_white(axes)
    words = "; ".join(
        f"{name} at {quantity(place[0], 'm', '.0f')} east, {quantity(place[1], 'm', '.0f')} north"
        for name, place in named
    )
    return to_figure(
        figure,
        "site",
        f"Map of the site: {words}.",
        "The straight way, and the circles within which a transit has arrived or the anchor may lie; east and "
        f"north of the origin.{problem}",
    )


def _draw_chart(axes: Axes, data: Mapping[str, object]) -> str:
    """Draw the chart that the mission names, where it names one; returns what is to be said of it."""
    file, origin = mapping(data.get("site")).get("chart"), _origin(data)
    if not isinstance(file, str) or origin is None:
        return ""
    problem = draw_chart(axes, file, origin)
    return f" {problem}" if problem else f" Chart: {Path(file).name}; not for navigation."


def _names(goals: list[Goal]) -> Iterator[tuple[str, Point]]:
    """Join the names of the goals that are one place."""
    places: dict[Point, list[str]] = {}
    for goal in goals:
        rounded = (round(goal.place[0], 1), round(goal.place[1], 1))
        names = places.setdefault(rounded, [])
        if goal.name not in names:
            names.append(goal.name)
    for place, names in places.items():
        yield ", ".join(names), place


def _write_names(axes: Axes, named: list[tuple[str, Point]], way: np.ndarray) -> None:
    """Write each name beside its place: towards the map's middle, and on the side that the way does not take."""
    middle = way.mean(axis=1)
    for name, (east, north) in named:
        right = east > middle[0]
        axes.plot(east, north, "o", color=INK, markersize=4)
        axes.annotate(
            name,
            (east, north),
            (-8 if right else 8, 8 if _runs_below(way, (east, north)) else -14),
            textcoords="offset points",
            ha="right" if right else "left",
            color=GREEN,
            weight="bold",
        )


def _room_for_names(named: list[tuple[str, Point]], way: np.ndarray) -> Iterator[np.ndarray]:
    """Points that must lie on the map too, so that no name below a place runs into the axis."""
    room = _NAME_BELOW * float(np.ptp(way, axis=1).max())
    for _, (east, north) in named:
        if not _runs_below(way, (east, north)):
            yield np.array([[east], [north - room]])


def _runs_below(way: np.ndarray, place: Point) -> bool:
    """Whether the way goes on from a place to the south, or level."""
    near = np.flatnonzero(np.hypot(*(way - np.array(place)[:, None])) < 1.0)
    beside = [index for index in (*(near - 1), *(near + 1)) if 0 <= index < way.shape[1] and index not in near]
    return bool(np.mean(way[1, beside] - place[1]) <= 0.0) if beside else True


def _has_picture(data: Mapping[str, object]) -> bool:
    """Whether the mission's chart is a picture, which may be dark."""
    file = mapping(data.get("site")).get("chart")
    return isinstance(file, str) and Path(file).suffix.lower() in (".tif", ".tiff")


def _on_white(axes: Axes) -> None:
    """Put names, north arrow, scale and way on white, in colours that a page's dark theme leaves alone."""
    light: list[AbstractPathEffect] = [withStroke(linewidth=4.0, foreground="white", alpha=0.8)]
    for text in axes.texts:
        if text.get_color() == INK:
            text.set_color("black")
        if text.get_text():
            text.set_bbox({"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1.0})
        elif isinstance(text, Annotation) and text.arrow_patch is not None:
            text.arrow_patch.set(color="black", path_effects=light)
    for line in axes.lines:
        if line.get_color() == INK:
            line.set_color("black")
        line.set_path_effects(light)


def _goals(data: Mapping[str, object]) -> Iterator[Goal]:
    """Yield the start and the goals in the order of the phases; a mooring is where the transit before it ends."""
    origin = _origin(data)
    phases = data.get("phases")
    here: Point | None = None
    for kind, section in chain.from_iterable(entry.items() for entry in mappings(phases)):
        if not isinstance(section, Mapping):
            continue
        name = str(section.get("name", kind))
        if kind == "transit":
            begin, end = _place(section.get("from"), origin), _place(section.get("to"), origin)
            if here is None and begin is not None:
                yield Goal("start", begin, 0.0)
            if end is not None:
                here = end
                yield Goal(name, end, _length(section.get("arrival_radius")))
        elif kind == "moor" and here is not None:
            yield Goal(name, here, _length(section.get("radius")))


def _origin(data: Mapping[str, object]) -> Geographic | None:
    written = mapping(data.get("site")).get("origin")
    if not isinstance(written, Mapping):
        return None
    latitude, longitude = (_number(written.get(key), "rad") for key in ("latitude", "longitude"))
    if math.isnan(latitude + longitude):
        return None
    return Geographic.model_construct(latitude=latitude, longitude=longitude)


def _place(value: object, origin: Geographic | None) -> Point | None:
    """Read a position as the mission does, distributions at their means; None where it has none."""
    if isinstance(value, Mapping) and origin is not None:
        latitude, longitude = (np.array([_number(value.get(key), "rad")]) for key in ("latitude", "longitude"))
        east, north = to_plane(latitude, longitude, origin)
        found = float(east[0]), float(north[0])
    elif isinstance(value, list | tuple) and len(value) == 2:
        found = _length(value[0]), _length(value[1])
    else:
        return None
    return found if all(map(math.isfinite, found)) else None


def _length(value: object) -> float:
    return _number(value, "m")


def _number(value: object, unit: str) -> float:
    """Read a quantity, of a distribution about its middle; nan where that cannot be done."""
    if isinstance(value, Mapping):
        if "choices" in value and isinstance(value["choices"], list | tuple):
            return _number(value["choices"][0], unit)
        if {"low", "high"} == set(value):
            return 0.5 * (_number(value["low"], unit) + _number(value["high"], unit))
        value = value.get("mean", value.get("median"))
    try:
        return parse_number_with_unit(value, unit)
    except QuantityError:
        return math.nan
