"""GeoPackage (OGC 12-128): waypoints, courses and circles as layers, for QGIS and other programs; needs pyogrio."""

import struct
import tempfile
from collections.abc import Sequence
from importlib import import_module
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.errors import InputError, Problem
from missionplan.exporters.header import header, one_interval
from missionplan.exporters.maps.geometry import Origin, circle, course_line, longitudes_latitudes, parts
from missionplan.exporters.table import Cell, rows
from missionplan.packages import how_to_install
from missionplan.results.plan import Plan, PlannedMooring

TITLE = "GeoPackage"
NEEDS_ORIGIN = True

_POINT, _LINE, _POLYGON, _MULTI = 1, 2, 3, 3
"""Types of geometry in well-known binary, and what is added for several parts (OGC 06-103r4, table 6)."""


def lost(plan: Plan) -> tuple[str, ...]:
    """Say what the form cannot hold."""
    return one_interval(plan)


def files(plan: Plan, stem: str) -> dict[str, str | bytes]:
    """Write one file with the layers `waypoints`, `courses` and `circles`; their metadata hold the header.

    Raises
    ------
    InputError
        When pyogrio is not installed.
    """
    try:
        import_module("pyogrio")
    except ImportError as error:
        raise InputError([Problem(f"needs pyogrio: {how_to_install('gpkg')}", key="to")]) from error
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"{stem}.gpkg"
        _waypoints(path, plan)
        _courses(path, plan)
        _circles(path, plan)
        return {path.name: path.read_bytes()}


def _waypoints(path: Path, plan: Plan) -> None:
    table = list(rows(plan))
    places = [_wkb(_POINT, [(row["longitude_deg"], row["latitude_deg"])]) for row in table]
    _layer(path, plan, "waypoints", "Point", places, table)


def _courses(path: Path, plan: Plan) -> None:
    transits = [transit for transit in plan.transits if len(transit.waypoints) > 1]
    lines = [parts(_on_earth(course_line(transit.waypoints), plan.origin)) for transit in transits]
    table: list[dict[str, Cell]] = [
        {
            "phase": transit.name,
            "depth_m": transit.depth,
            "speed_m_s": transit.speed,
            "surfacing_interval_m": transit.surfacing.interval,
            "surfacing_interval_s": round(transit.surfacing.interval_time, 1),
            "surface_time_s": transit.surfacing.surface_time,
            "time_out_s": transit.time_out,
        }
        for transit in transits
    ]
    _layer(path, plan, "courses", *_shapes("LineString", _LINE, lines), table)


def _circles(path: Path, plan: Plan) -> None:
    shapes, table = [], []
    for phase in plan.phases:
        moored = isinstance(phase, PlannedMooring)
        place = phase if isinstance(phase, PlannedMooring) else phase.goal
        radius = phase.radius if isinstance(phase, PlannedMooring) else phase.arrival_radius
        shapes.append(parts(_on_earth(circle((place.east, place.north), radius), plan.origin), closed=True))
        kind: Cell = "mooring circle" if moored else "arrival circle"
        table.append({"phase": phase.name, "kind": kind, "radius_m": radius})
    _layer(path, plan, "circles", *_shapes("Polygon", _POLYGON, shapes), table)


def _layer(
    path: Path, plan: Plan, name: str, geometry: str, shapes: Sequence[bytes], table: Sequence[dict[str, Cell]]
) -> None:
    if not table:
        return
    from pyogrio import raw

    fields = list(table[0])
    raw.write(
        path,
        geometry=np.array(shapes, dtype=object),
        field_data=[_column([row[field] for row in table]) for field in fields],
        fields=fields,
        layer=name,
        driver="GPKG",
        geometry_type=geometry,
        crs="EPSG:4326",
        append=path.exists(),
        layer_metadata={"header": "\n".join(header(plan, TITLE, lost(plan))), "mission_sha256": plan.digest},
    )


def _column(cells: Sequence[Cell]) -> NDArray[np.generic]:
    """Return a column: of text, or of numbers where what is unknown is nan."""
    if any(isinstance(cell, str) for cell in cells):
        return np.array(cells, dtype=object)
    return np.array([np.nan if cell is None else cell for cell in cells], dtype=float)


def _on_earth(points: Array, origin: Origin | None) -> list[list[float]]:
    return longitudes_latitudes(points, origin or (0.0, 0.0))


def _shapes(geometry: str, kind: int, lines: Sequence[list[list[list[float]]]]) -> tuple[str, list[bytes]]:
    """Type of a layer's geometries, and these: all of several parts where one is cut at the antimeridian."""
    if all(len(each) == 1 for each in lines):
        return geometry, [_wkb(kind, each[0]) for each in lines]
    several = struct.pack("<BI", 1, kind + _MULTI)
    made = [several + struct.pack("<I", len(each)) + b"".join(_wkb(kind, part) for part in each) for each in lines]
    return f"Multi{geometry}", made


def _wkb(kind: int, points: Sequence[Sequence[Cell]]) -> bytes:
    """Write a geometry as well-known binary, little endian; a polygon by its one ring."""
    body = b"".join(struct.pack("<2d", *place) for place in points)
    count = b"" if kind == _POINT else struct.pack("<I", len(points))
    ring = struct.pack("<I", 1) if kind == _POLYGON else b""
    return struct.pack("<BI", 1, kind) + ring + count + body
