"""Land and zones kept out of, from GeoJSON, GeoPackage or a shapefile."""

import json
import math
import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from missionplan.arrays import Array
from missionplan.errors import InputError, Problem, shown
from missionplan.identity import how_to_install
from missionplan.mission.schema.place import BathymetryFile, Geographic, to_geographic, to_plane
from missionplan.mission.units import QuantityError, parse_number_with_unit
from missionplan.moments import moment_of, utc
from missionplan.phases.zones import Zone

DEGREES = "EPSG:4326"
LOCAL = "local"
Transform = Callable[[Array, Array], tuple[Array, Array]]


@dataclass(frozen=True)
class Chart:
    """A file of a place, and the part of the plane that is wanted of it."""

    key: str
    """Of the mission file, such as ``site.land``."""
    written: BathymetryFile
    """Of polygons, one that asks for no variable and direction."""
    origin: Geographic | None
    """None where all coordinates are local."""
    low: Array
    high: Array
    """Shape (2,). South-west and north-east corner of what is wanted [m]."""

    @property
    def path(self) -> Path:
        """Path of the file."""
        return Path(self.written.file)

    @property
    def asked_up(self) -> bool:
        """Whether values count up, as far as the mission says."""
        return self.written.positive != "down"

    def problem(self, message: str, hint: str = "") -> InputError:
        """Return the error of the file."""
        return InputError([Problem(message, self.written.file, key=self.key, hint=hint)])

    def system(self, named: str | None) -> str:
        """Return the reference system of the coordinates: the mission's word, else the file's, else degrees."""
        return self.written.projection or named or DEGREES

    def to_plane(self, x: Array, y: Array, system: str) -> Array:
        """East and north of the origin, shape (2, n), of coordinates in a reference system [m].

        Raises InputError when nobody knows the system, or the coordinates are not of it.
        """
        if system == LOCAL:
            return np.stack((x, y)).astype(float)
        longitude, latitude = (x, y) if system == DEGREES else self._transform(system, DEGREES)(x, y)
        if not (np.isfinite(longitude).all() and np.isfinite(latitude).all()) or np.abs(latitude).max(initial=0) > 90:
            hint = f"{self.key}.projection: EPSG:… names it; `local` is for metres east and north of the origin"
            raise self.problem(f"its coordinates are not of {'degrees' if system == DEGREES else system}", hint)
        origin = self._origin()
        beside = longitude_beside(np.asarray(longitude), origin)
        return np.stack(to_plane(np.radians(latitude), np.radians(beside), origin))

    def from_plane(self, places: Array, system: str) -> Array:
        """Coordinates in a reference system, shape (2, n), of places east and north of the origin [m]."""
        if system == LOCAL:
            return places
        latitude, longitude = to_geographic(places[0], places[1], self._origin())
        x, y = longitude_beside(np.degrees(longitude), self._origin()), np.degrees(latitude)
        return np.stack((x, y) if system == DEGREES else self._transform(DEGREES, system)(x, y))

    def wanted(self, count: int = 33) -> Array:
        """Places over the wanted part of the plane, its edges among them, shape (2, count²) [m]."""
        axes = [np.linspace(a, b, count) for a, b in zip(self.low, self.high, strict=True)]
        return np.stack([axis.ravel() for axis in np.meshgrid(*axes)])

    def _origin(self) -> Geographic:
        if self.origin is None:
            raise self.problem("needs the site's origin, by which it is placed")
        return self.origin

    def _transform(self, begin: str, end: str) -> Transform:
        from pyproj import Transformer
        from pyproj.exceptions import ProjError

        try:
            transform: Transform = Transformer.from_crs(begin, end, always_xy=True).transform
        except ProjError as error:
            named = next(system for system in (begin, end) if system != DEGREES)
            message = f"given {named[:60]!r}, which is no reference system: {str(error).partition(':')[0]}"
            raise InputError([Problem(message, self.written.file, key=f"{self.key}.projection")]) from None
        return transform


def longitude_beside(longitude: Array, origin: Geographic) -> Array:
    """Longitudes within 180° of the origin's: neither the date line nor a file's convention matters [deg]."""
    middle = math.degrees(origin.longitude)
    return np.asarray((longitude - middle + 180.0) % 360.0 - 180.0 + middle)


if TYPE_CHECKING:
    from shapely import Geometry

Feature = tuple["Geometry", Mapping[str, object]]
GEOJSON = (".geojson", ".json")
VECTOR = (".gpkg", ".shp")
_LONGEST_EDGE = 0.01
"""Of a polygon in degrees, before it is placed: longer edges are cut, since parallels bend [deg]."""


def features(chart: Chart) -> tuple[list[Feature], str]:
    """Return geometries with their properties, and the reference system of their coordinates.

    Raises InputError when a library is missing or the file cannot be read.
    """
    try:
        import shapely  # noqa: F401
    except ImportError:
        raise chart.problem("reading polygons needs shapely", how_to_install("place")) from None
    ending = chart.path.suffix.lower()
    if ending in GEOJSON:
        return _geojson(chart)
    if ending in VECTOR:
        return _vector(chart)
    raise chart.problem(f"given {shown(chart.path.name)}; expected {', '.join((*GEOJSON, *VECTOR))}")


def _geojson(chart: Chart) -> tuple[list[Feature], str]:
    """Geometries, and their reference system: degrees, or what files of before RFC 7946 name as `crs`."""
    from shapely.errors import ShapelyError
    from shapely.geometry import shape

    try:
        data = json.loads(chart.path.read_text(encoding="utf-8-sig"))
        shapes = [(shape(geometry), properties) for geometry, properties in _parts(data)]
        system = str(data.get("crs", {}).get("properties", {}).get("name", ""))
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError, ShapelyError) as error:
        raise chart.problem(f"cannot be read as GeoJSON: {type(error).__name__}: {error}") from None
    return shapes, chart.system(None if re.search(r"CRS84$|\D4326$|^$", system) else system)


def _parts(data: Any) -> Iterator[tuple[Mapping[str, Any], Mapping[str, object]]]:
    """Yield the geometries of a GeoJSON object with the properties of their features."""
    if not isinstance(data, Mapping) or not isinstance(data.get("type"), str):
        raise ValueError("expected an object with a `type`")
    if data["type"] == "FeatureCollection":
        for feature in data["features"]:
            yield from _parts(feature)
    elif data["type"] == "Feature":
        properties = data.get("properties") or {}
        if not isinstance(properties, Mapping):
            raise ValueError("the `properties` of a feature are no object")
        if data["geometry"] is not None:
            yield data["geometry"], properties
    else:
        yield data, {}


def _vector(chart: Chart) -> tuple[list[Feature], str]:
    try:
        import pyogrio
        import shapely
    except ImportError:
        hint = how_to_install("place")
        raise chart.problem("reading GeoPackage and shapefiles needs pyogrio and shapely", hint) from None
    try:
        layers = [name for name, kind in pyogrio.list_layers(chart.path) if kind is not None]
        shapes: list[Feature] = []
        system: str | None = None
        for layer in layers:
            meta, _, wkb, columns = pyogrio.raw.read(chart.path, layer=layer)
            system, names = meta["crs"] or system, [str(name) for name in meta["fields"]]
            rows = zip(*columns, strict=True) if len(columns) else ((),) * len(wkb)
            shapes += [
                (geometry, dict(zip(names, row, strict=True)))
                for geometry, row in zip(shapely.from_wkb(wkb), rows, strict=True)
                if geometry is not None
            ]
    except Exception as error:  # GDAL's drivers raise many kinds for what is damaged
        raise chart.problem(f"cannot be read: {str(error).partition(chr(10))[0]}") from None
    return shapes, chart.system(system)


def read_zones(chart: Chart, start: datetime | None, *, is_land: bool) -> tuple[list[Zone], float]:
    """Read polygons into the plane, those that lie in the wanted part of it; and how far the nearest corner is [m].

    Raises InputError when the file cannot be read, has no polygon, or a property is wrong.

    `start`: of the mission, from which the times of zones count. `is_land`: land has no times and depths.
    """
    import shapely

    shapes, system = features(chart)
    box = shapely.box(*chart.low, *chart.high)
    windows = _windows(chart) if system == DEGREES else []
    zones: list[Zone] = []
    count = 0
    for number, (geometry, properties) in enumerate(shapes, start=1):
        parts = _polygons(_across_date_line(geometry) if system == DEGREES else _moved(chart, geometry, system))
        count += len(parts)
        placed = [polygon for part in parts for polygon in _placed(chart, part, windows)] if windows else parts
        near = [part for part in placed if shapely.intersects(part, box)]
        if near:
            name = str(properties.get("name") or f"{chart.path.stem} {number}")
            limits: list[dict[str, float]] = [{}] if is_land else _limits(chart, properties, name, start)
            zones += [Zone(shapely.union_all(near), name, is_land=is_land, **limit) for limit in limits]
    if not count:
        raise chart.problem("holds no polygons", "coastlines are lines: land needs polygons")
    corners = shapely.get_coordinates([geometry for geometry, _ in shapes]) if not zones else np.empty((0, 2))
    return zones, float(np.hypot(*chart.to_plane(corners[:, 0], corners[:, 1], system)).min(initial=np.inf))


def _polygons(geometry: "Geometry") -> "list[Geometry]":
    """Polygons of a geometry, valid: those of collections too."""
    import shapely

    if geometry.geom_type == "Polygon" and geometry.is_valid:
        return [] if geometry.is_empty else [geometry]
    if geometry.geom_type == "Polygon":
        return _polygons(shapely.make_valid(geometry, method="structure", keep_collapsed=False))
    parts = shapely.get_parts(geometry) if hasattr(geometry, "geoms") else ()
    return [polygon for part in parts for polygon in _polygons(part)]


def _across_date_line(geometry: "Geometry") -> "Geometry":
    """Let the longitudes of polygons that cross the date line go on beyond it: from 179.9 to -179.9 is no way back.

    An edge of a whole turn, as that of a pole, stays.
    """
    import shapely

    if geometry.geom_type != "Polygon":
        parts = shapely.get_parts(geometry) if hasattr(geometry, "geoms") else ()
        return shapely.GeometryCollection([_across_date_line(part) for part in parts])
    rings = [shapely.get_coordinates(ring) for ring in shapely.get_rings(geometry)]
    steps = np.abs(np.diff(np.concatenate([np.zeros((0, 2)), *rings])[:, 0]))
    if not np.any((steps > 180.0) & (steps < 360.0)):
        return geometry
    start = rings[0][0, 0]
    moved = [np.unwrap(np.append(start, ring[:, 0]), period=360.0)[1:] - ring[:, 0] for ring in rings]
    turned = [ring[:, 0] + 360.0 * np.round(away / 360.0) for ring, away in zip(rings, moved, strict=True)]
    if any(longitude[0] != longitude[-1] for longitude in turned):  # round a pole
        return geometry
    shell, *holes = (np.stack((east, ring[:, 1]), axis=1) for east, ring in zip(turned, rings, strict=True))
    return shapely.Polygon(shell, holes)


def _windows(chart: Chart) -> list[tuple[float, float, float, float]]:
    """West, south, east and north of what is wanted, with a rim, in each convention of longitude [deg]."""
    longitude, latitude = chart.from_plane(chart.wanted(), DEGREES)
    low, high = np.array([longitude.min(), latitude.min()]), np.array([longitude.max(), latitude.max()])
    rim = 0.1 * (high - low)
    (west, south), (east, north) = low - rim, high + rim
    return [(west - turn, south, east - turn, north) for turn in (-360.0, 0.0, 360.0)]


def _moved(chart: Chart, geometry: "Geometry", system: str) -> "Geometry":
    """Move a geometry from a reference system into the plane."""
    import shapely

    if system == LOCAL:
        return geometry
    return shapely.transform(
        shapely.force_2d(geometry), lambda points: chart.to_plane(points[:, 0], points[:, 1], system).T
    )


def _placed(chart: Chart, polygon: "Geometry", windows: list[tuple[float, float, float, float]]) -> "list[Geometry]":
    """Place what lies in the windows of a polygon in degrees, which may be a continent, in the plane."""
    import shapely

    west, south, east, north = polygon.bounds
    if not (-361.0 <= west <= east <= 361.0 and -90.001 <= south <= north <= 90.001):
        hint = f"{chart.key}.projection: EPSG:… names their system; `local` is for metres from the origin"
        raise chart.problem("its coordinates are not degrees", hint)
    cut = [shapely.clip_by_rect(polygon, *window) for window in windows]
    parts = [shapely.segmentize(part, _LONGEST_EDGE) for piece in cut for part in _polygons(piece)]
    return [piece for part in parts for piece in _polygons(_moved(chart, part, DEGREES))]


_BLANKS = ("", "None", "nan", "NaT")
"""Properties that a feature of a table has none of."""


def _limits(
    chart: Chart, properties: Mapping[str, object], name: str, start: datetime | None
) -> list[dict[str, float]]:
    """Read when and at which depths a zone holds; two, where it forbids both what is above and what is below."""
    entries = {str(key).lower(): value for key, value in properties.items() if str(value) not in _BLANKS}
    times: dict[str, float] = {}
    for key, field in (("from", "since"), ("to", "until")):
        if key in entries:
            times[field] = _since_start(chart, entries[key], f"{name}: {key}", start)
    keys = [key for key in ("above", "below") if key in entries]
    depths: dict[str, float] = {key: _depth(chart, entries[key], f"{name}: {key}") for key in keys}
    if times.get("since", -math.inf) > times.get("until", math.inf):
        raise chart.problem(f"{name}: `from` is after `to`")
    if len(depths) == 2 and depths["above"] <= depths["below"]:
        return [{**times, "above": depths["above"]}, {**times, "below": depths["below"]}]
    return [{**times, **depths}]


def _since_start(chart: Chart, value: object, what: str, start: datetime | None) -> float:
    if start is None:
        raise chart.problem(f"{what}: given {shown(value)}; the mission needs its `start` (UTC)")
    try:
        moment = value if isinstance(value, datetime) else moment_of(str(value))
        return (utc(moment) - utc(start)).total_seconds()
    except (ValueError, OverflowError) as error:
        raise chart.problem(
            f"{what}: given {shown(value)}, expected a time such as 2026-06-01T08:00Z: {error}"
        ) from None


def _depth(chart: Chart, value: object, what: str) -> float:
    """Read a depth: a bare number is in metres."""
    depth: float | None = None
    with suppress(ValueError):
        depth = None if isinstance(value, bool) else float(str(value))
    try:
        depth = parse_number_with_unit(value, "m") if depth is None else depth
    except QuantityError as error:
        raise chart.problem(f"{what}: {error}") from None
    if depth < 0.0:
        raise chart.problem(f"{what}: given {shown(value)}, expected a depth, positive down")
    return depth
