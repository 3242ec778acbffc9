"""The site on a map, with its chart: where the mission starts, its goals, the straight way."""

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

from missionplan.arrays import Array
from missionplan.errors import InputError
from missionplan.exporters.geojson import circle
from missionplan.mission.schema.place import BathymetryFile, Geographic, to_plane
from missionplan.mission.units import QuantityError, parse_number_with_unit
from missionplan.report.axes import name_axis
from missionplan.report.page import BLUE, GREEN, GREY, INK, ORANGE, Figure, to_figure
from missionplan.report.plan_view import draw_region, emptiest_corner, frame, north_and_scale
from missionplan.report.quantities import quantity
from missionplan.report.wording import shortened
from missionplan.results.entries import mapping, mappings
from missionplan.scenario.grid_files import placed_pixels
from missionplan.scenario.polygons import LOCAL, Chart, features

_PICTURES = (".tif", ".tiff")
_PIXELS = 300
"""Of the picture along each side of the map."""


def _draw_file(axes: Axes, chart: Chart, kind: str) -> str:
    """Draw a file behind what is on the axes, in metres about the origin; returns why it cannot be read."""
    try:
        if chart.path.suffix.lower() in _PICTURES:
            _draw_picture(axes, chart)
        else:
            _draw_features(axes, chart, kind)
    except InputError as error:
        return f"The chart {chart.path.name} {error.problems[0].message}."
    except Exception as error:  # readers of other people's files raise many kinds, and a report is worth more than one
        return f"The chart {chart.path.name} cannot be read ({type(error).__name__}: {error})."
    return ""


def _draw_features(axes: Axes, chart: Chart, kind: str) -> None:
    """Draw polygons as land or a zone, as shoal water where they have a depth, and lines with their depth."""
    shapes, system = features(chart)
    for geometry, properties in shapes:
        depth = properties.get("depth")
        for part in getattr(geometry, "geoms", (geometry,)):
            rings = (part.exterior, *part.interiors) if part.geom_type == "Polygon" else (part,)
            points = [np.array(ring.coords) for ring in rings]
            lines = [chart.to_plane(ring[:, 0], ring[:, 1], system) for ring in points]
            if part.geom_type == "Polygon":
                draw_region(axes, [line.T for line in lines], kind if depth is None else "shoal", zorder=0.5)
                continue
            axes.plot(*lines[0], color=GREY, linewidth=0.7, zorder=0.6)
            if isinstance(depth, int | float):
                middle = lines[0][:, lines[0].shape[1] // 2]
                axes.annotate(quantity(depth, "m", "g"), tuple(middle), fontsize=7, color=GREY, clip_on=True)


def _draw_picture(axes: Axes, chart: Chart) -> None:
    """Draw the part of a GeoTIFF that the axes show, warped to metres about the origin."""
    from PIL.TiffImagePlugin import TiffImageFile

    with TiffImageFile(chart.path) as picture:
        (left, wide), (top, high), system = placed_pixels(chart, picture.tag_v2)
        pixels = np.asarray(picture.convert("RGB"))
    (west, east), (south, north) = axes.get_xlim(), axes.get_ylim()
    x, y = np.meshgrid(np.linspace(west, east, _PIXELS), np.linspace(north, south, _PIXELS))
    across, up = chart.from_plane(np.stack((x.ravel(), y.ravel())), chart.system(system))
    shown = _picked(pixels, np.floor((up - top) / high), np.floor((across - left) / wide))
    if not shown[..., 3].any():
        raise ValueError("it does not show the site")
    axes.imshow(shown, extent=(west, east, south, north), aspect="equal", zorder=0.4, interpolation="nearest")
    axes.set(xlim=(west, east), ylim=(south, north))


def _picked(pixels: Array, row: Array, column: Array) -> Array:
    """Pick pixels by row and column, clear where there are none: shape (`_PIXELS`, `_PIXELS`, 4)."""
    height, width = pixels.shape[:2]
    inside = (row >= 0) & (row < height) & (column >= 0) & (column < width)
    shown = np.zeros((_PIXELS * _PIXELS, 4), dtype=np.uint8)
    shown[inside, :3] = pixels[row[inside].astype(int), column[inside].astype(int)]
    shown[inside, 3] = 255
    return np.asarray(shown.reshape(_PIXELS, _PIXELS, 4))


_WIDTH = 5.0
_NAME_BELOW = 0.08
"""Room that a name below its place takes, of the map's longer side."""
_NAME_HEIGHT = 16
"""Of a row of names [points]."""
_LETTER = 0.025
"""Width of a letter of a name, of the way's longer side."""
Point = tuple[float, float]
"""East and north of the origin [m]."""


@dataclass(frozen=True)
class Goal:
    """A point that the mission names: the start, where a transit ends, where it moors."""

    name: str
    place: Point
    """East and north of the origin [m]."""
    radius: float
    """Within which it is reached, or the anchor may lie; 0 for the start [m]."""


def site_map(data: Mapping[str, object]) -> Figure | None:
    """Draw the site of a mission; None where no transit says where it goes."""
    goals = list(_goals(data))
    if len(goals) < 2:
        return None
    way, named = _named(goals)
    circles = [circle(goal.place, goal.radius) for goal in goals if goal.radius]
    shown = frame([], [way, *circles, *room_for_names(data)])
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
    name_goals(axes, data)
    north_and_scale(axes, shown.width, emptiest_corner([way, *circles], shown.limits))
    file = mapping(data.get("site")).get("chart")
    if isinstance(file, str) and Path(file).suffix.lower() in _PICTURES:  # which may be dark
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
        origin=(origin.latitude, origin.longitude) if (origin := _origin(data)) is not None else None,
    )


_DRAWN = (".json", ".geojson", ".gpkg", ".shp", *_PICTURES)
"""Endings of files that are drawn."""


def _draw_chart(axes: Axes, data: Mapping[str, object]) -> str:
    """Draw the chart, the land and the zones that the mission names; returns what is to be said of them."""
    site, origin, words = mapping(data.get("site")), _origin(data), ""
    corners = np.array([axes.get_xlim(), axes.get_ylim()])
    for key in ("chart", "land", "keep_out"):
        written = {"file": site.get(key)} if isinstance(site.get(key), str) else mapping(site.get(key))
        file, projection = written.get("file"), written.get("projection")
        if not isinstance(file, str) or not file.lower().endswith(_DRAWN):
            continue
        if origin is None and projection != LOCAL:
            continue
        file_of = BathymetryFile.model_construct(file=file, projection=projection)
        kind = "keep-out" if key == "keep_out" else "land"
        problem = _draw_file(axes, Chart(f"site.{key}", file_of, origin, *corners.T), kind)
        words += f" {problem}" if problem else f" Chart: {Path(file).name}; not for navigation."
    return words


def _named(goals: list[Goal]) -> tuple[np.ndarray, list[tuple[str, Point]]]:
    """Straight way through the goals, shape (2, k) [m], and the places with the names of the goals that are there."""
    places: dict[Point, list[str]] = {}
    for goal in goals:
        rounded = (round(goal.place[0], 1), round(goal.place[1], 1))
        names = places.setdefault(rounded, [])
        if goal.name not in names:
            names.append(goal.name)
    way = np.array([goal.place for goal in goals]).reshape(-1, 2).T
    return way, [(", ".join(names), place) for place, names in places.items()]


def name_goals(axes: Axes, data: Mapping[str, object]) -> None:
    """Write the names of a mission's start and goals on a map of it: towards its middle, off the way."""
    way, named = _named(list(_goals(data)))
    for (name, (east, north)), row in zip(named, _rows_of_names(way, named), strict=True):
        right = east > way[0].mean()
        axes.plot(east, north, "o", color=INK, markersize=4)
        axes.annotate(
            name,
            (east, north),
            (-8 if right else 8, _NAME_HEIGHT * row - 3),
            textcoords="offset points",
            ha="right" if right else "left",
            color=GREEN,
            weight="bold",
        )


def _rows_of_names(way: np.ndarray, named: list[tuple[str, Point]]) -> list[int]:
    """Row in which each name stands, counted up from its place: another where it would run into one at its height."""
    size, rows = max(float(np.ptp(way, axis=1).max()) if named else 0.0, 1.0), list[int]()
    for number, (name, (east, north)) in enumerate(named):
        row = step = 1 if _runs_below(way, (east, north)) else -1
        beside = [
            (other, rows[at])
            for at, (other, place) in enumerate(named[:number])
            if abs(place[0] - east) / size < _LETTER * len(f"{name}{other}") and abs(place[1] - north) < 0.1 * size
        ]
        while row in {taken for _, taken in beside}:
            row += step
        rows.append(row)
    return rows


def room_for_names(data: Mapping[str, object]) -> Iterator[np.ndarray]:
    """Points that must lie on a map of a mission, so that no name below a place runs into its axis."""
    way, named = _named(list(_goals(data)))
    for (_, (east, north)), row in zip(named, _rows_of_names(way, named), strict=True):
        if row < 0:
            yield np.array([[east], [north + _NAME_BELOW * row * float(np.ptp(way, axis=1).max())]])


def _runs_below(way: np.ndarray, place: Point) -> bool:
    """Whether the way goes on from a place to the south, or level."""
    near = np.flatnonzero(np.hypot(*(way - np.array(place)[:, None])) < 1.0)
    beside = [index for index in (*(near - 1), *(near + 1)) if 0 <= index < way.shape[1] and index not in near]
    return bool(np.mean(way[1, beside] - place[1]) <= 0.0) if beside else True


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
        name = shortened(str(section.get("name", kind)))
        if kind == "transit":
            begin, end = _place(section.get("from"), origin), _place(section.get("to"), origin)
            if here is None and begin is not None:
                yield Goal("start", begin, 0.0)
            if end is not None:
                here = end
                yield Goal(name, end, _metres(section.get("arrival_radius")))
        elif kind == "moor" and here is not None:
            yield Goal(name, here, _metres(section.get("radius")))


def _origin(data: Mapping[str, object]) -> Geographic | None:
    return _on_earth(mapping(data.get("site")).get("origin"))


def _on_earth(written: object) -> Geographic | None:
    """Read a latitude and longitude as the mission does, minutes too; None where there is none."""
    try:
        return Geographic.model_validate(written)
    except ValueError:
        return None


def _place(value: object, origin: Geographic | None) -> Point | None:
    """Read a position as the mission does, distributions at their means; None where it has none."""
    if origin is not None and (there := _on_earth(value)) is not None:
        east, north = to_plane(np.array([there.latitude]), np.array([there.longitude]), origin)
        place = float(east[0]), float(north[0])
    elif isinstance(value, list | tuple) and len(value) == 2:
        place = _metres(value[0]), _metres(value[1])
    else:
        return None
    return place if all(map(math.isfinite, place)) else None


def _metres(value: object) -> float:
    """Read a length, of a distribution about its middle; nan where that cannot be done."""
    if isinstance(value, Mapping):
        if "choices" in value and isinstance(value["choices"], list | tuple):
            return _metres(value["choices"][0])
        if {"low", "high"} == set(value):
            return 0.5 * (_metres(value["low"]) + _metres(value["high"]))
        value = value.get("mean", value.get("median"))
    try:
        return parse_number_with_unit(value, "m")
    except QuantityError:
        return math.nan
