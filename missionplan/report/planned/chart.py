"""A chart behind the map of the site, from a local file: GeoJSON (coast, depths) or GeoTIFF (a scanned chart)."""

import json
import math
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes

from missionplan.arrays import Array
from missionplan.mission.geodesy import to_geographic, to_plane
from missionplan.mission.schema.site import Geographic
from missionplan.report.page import GREY, SKY
from missionplan.report.quantities import quantity

_LAND = "#d9cfae"
_PIXELS = 300
"""Of the picture along each side of the map."""
_SCALE, _TIE_POINT, _KEYS = 33550, 33922, 34735
"""Tags of GeoTIFF 1.1: pixel scale, tie point, key directory."""
_GEOGRAPHIC, _PROJECTED = 2048, 3072
"""Keys of GeoTIFF 1.1: EPSG code of the geographic and of the projected reference system."""


def draw_chart(axes: Axes, file: str, origin: Geographic) -> str:
    """Draw a chart behind what is on the axes, in metres about the origin; returns why it cannot be read."""
    path = Path(file)
    try:
        if path.suffix.lower() in (".tif", ".tiff"):
            _draw_picture(axes, path, origin)
        else:
            _draw_features(axes, json.loads(path.read_text(encoding="utf-8")), origin)
    except Exception as error:  # readers of other people's files raise many kinds, and a report is worth more than one
        return f"The chart {path.name} cannot be read ({type(error).__name__}: {error})."
    return ""


def _draw_features(axes: Axes, data: object, origin: Geographic) -> None:
    """Draw polygons as land, or as shoal water where they have a depth, and lines, labelled with their depth."""
    for kind, points, depth in _shapes(data, None):
        longitude, latitude = np.radians(np.array([point[:2] for point in points], dtype=float).T)
        east, north = to_plane(latitude, longitude, origin)
        if kind == "Polygon":
            colour, alpha = (_LAND, 0.9) if depth is None else (SKY, 0.15)
            axes.fill(east, north, color=colour, alpha=alpha, linewidth=0.0, zorder=0.5)
        else:
            axes.plot(east, north, color=GREY, linewidth=0.7, zorder=0.6)
            if depth is not None:
                middle = len(east) // 2
                axes.annotate(
                    quantity(depth, "m", "g"), (east[middle], north[middle]), fontsize=7, color=GREY, clip_on=True
                )


def _shapes(data: object, depth: float | None) -> Iterator[tuple[str, list[list[float]], float | None]]:
    """Yield the rings and lines of a GeoJSON object, with the depth that its feature has [m]."""
    if not isinstance(data, Mapping):
        raise ValueError("expected a GeoJSON object")
    kind, coordinates = data.get("type"), list(data.get("coordinates") or ())
    if kind == "FeatureCollection":
        for feature in data["features"]:
            yield from _shapes(feature, None)
    elif kind == "Feature":
        found = (data.get("properties") or {}).get("depth")
        if data.get("geometry") is not None:
            yield from _shapes(data["geometry"], float(found) if isinstance(found, int | float) else None)
    elif kind == "GeometryCollection":
        for geometry in data["geometries"]:
            yield from _shapes(geometry, depth)
    elif kind == "Polygon":
        yield "Polygon", coordinates[0], depth
    elif kind == "MultiPolygon":
        yield from (("Polygon", polygon[0], depth) for polygon in coordinates)
    elif kind == "LineString":
        yield "LineString", coordinates, depth
    elif kind == "MultiLineString":
        yield from (("LineString", line, depth) for line in coordinates)


def _draw_picture(axes: Axes, path: Path, origin: Geographic) -> None:
    """Draw the part of a GeoTIFF that the axes show, warped to metres about the origin."""
    from PIL.TiffImagePlugin import TiffImageFile
    from pyproj import Transformer

    with TiffImageFile(path) as picture:
        scale, tie = picture.tag_v2[_SCALE], picture.tag_v2[_TIE_POINT]
        system = _reference_system(picture.tag_v2[_KEYS])
        pixels = np.asarray(picture.convert("RGB"))
    (west, east), (south, north) = axes.get_xlim(), axes.get_ylim()
    x, y = np.meshgrid(np.linspace(west, east, _PIXELS), np.linspace(north, south, _PIXELS))
    latitude, longitude = to_geographic(x.ravel(), y.ravel(), origin)
    transformer = Transformer.from_crs(4326, system, always_xy=True)
    across, up = transformer.transform(np.degrees(longitude), np.degrees(latitude))
    column = np.floor(tie[0] + (np.asarray(across) - tie[3]) / scale[0])
    row = np.floor(tie[1] - (np.asarray(up) - tie[4]) / scale[1])
    shown = _picked(pixels, row, column)
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


def _reference_system(keys: tuple[int, ...]) -> int:
    """Return the EPSG code that a GeoTIFF's key directory names."""
    entries = {keys[place]: keys[place + 3] for place in range(4, len(keys), 4)}
    code = entries.get(_PROJECTED) or entries.get(_GEOGRAPHIC)
    if code is None or math.isclose(code, 32767):  # 32767: defined by the user
        raise ValueError("it names no EPSG code")
    return int(code)
