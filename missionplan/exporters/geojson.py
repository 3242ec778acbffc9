"""GeoJSON (RFC 7946) with simplestyle colours; points on Earth, circles and colours for all maps."""

import itertools
import json
import math
from collections.abc import Iterable, Iterator, Sequence
from typing import Any, cast

import numpy as np

from missionplan.arrays import Array
from missionplan.exporters import header, one_interval
from missionplan.exporters.table import course_row, mooring_row, waypoint_row
from missionplan.mission.schema.place import Geographic, to_geographic
from missionplan.results.plan import Plan, PlannedMooring, PlannedTransit
from missionplan.results.plan_places import Fence, Waypoint

Origin = tuple[float, float]
"""Latitude and longitude [rad]."""


def longitudes_latitudes(points: Array, origin: Origin) -> list[list[float]]:
    """Return longitude and latitude [deg] of points of shape (2, n), rounded to about a centimetre.

    Longitudes lie between -180° and 180°.
    """
    place = Geographic.model_construct(latitude=origin[0], longitude=origin[1])
    latitude, longitude = to_geographic(points[0], points[1], place)
    longitude = np.remainder(longitude + math.pi, 2.0 * math.pi) - math.pi
    rounded: list[list[float]] = np.round(np.degrees((longitude, latitude)).T, 7).tolist()
    return rounded


def parts(places: Sequence[list[float]], *, closed: bool = False) -> list[list[list[float]]]:
    """Cut a line, or the closed boundary of an area, where it crosses the antimeridian (RFC 7946, section 3.1.9).

    `places` [deg]. `closed`: whether it bounds an area: each part is closed again, along the antimeridian.

    Returns
    -------
    list of lists of [longitude, latitude]
        One where it does not cross.
    """
    cut: list[list[list[float]]] = [[list(places[0])]]
    for before, after in itertools.pairwise(places):
        if abs(after[0] - before[0]) > 180.0:
            side = math.copysign(180.0, before[0])
            share = (side - before[0]) / ((after[0] + 2.0 * side - before[0]) or 1.0)
            latitude = round(before[1] + share * (after[1] - before[1]), 7)
            cut[-1].append([side, latitude])
            cut.append([[-side, latitude]])
        cut[-1].append(list(after))
    if not closed or len(cut) == 1:
        return cut
    cut[0] = cut.pop()[:-1] + cut[0]  # the last part runs on into the first, on the same side
    return [[*part, part[0]] for part in cut]


def areas(fence: Fence) -> list[list[list[list[float]]]]:
    """Return a zone as areas, in several where it crosses the antimeridian, each its boundary and then its holes.

    Boundaries are closed and counter-clockwise, holes clockwise (RFC 7946, section 3.1.6), as longitudes and latitudes
    [deg].
    """
    import shapely  # whoever has a zone has it
    from shapely.geometry.polygon import orient

    first = math.degrees(fence.outline[0][1])
    rings = [
        [(first + math.remainder(math.degrees(corner[1]) - first, 360.0), math.degrees(corner[0])) for corner in ring]
        for ring in (fence.outline, *fence.holes)
    ]
    whole = shapely.Polygon(rings[0], rings[1:])
    west, _, east, _ = whole.bounds
    sides = (
        [(0.0, whole)]
        if west >= -180.0 and east <= 180.0
        else [
            (turn, shapely.intersection(whole, shapely.box(turn - 180.0, -90.0, turn + 180.0, 90.0)))
            for turn in (-360.0, 0.0, 360.0)
        ]
    )
    return [
        [
            [[longitude - turn, latitude] for longitude, latitude in ring.coords]
            for ring in (part.exterior, *part.interiors)
        ]
        for turn, side in sides
        for part in map(orient, (polygon for polygon in shapely.get_parts(side) if polygon.area > 0.0))
    ]


def longitude_latitude(point: Waypoint | PlannedMooring, origin: Origin) -> list[float]:
    """Return longitude and latitude of a planned point [deg]."""
    return longitudes_latitudes(np.array([[point.east], [point.north]]), origin)[0]


def circle(centre: tuple[float, float], radius: float, points: int = 72) -> Array:
    """Return a closed circle, shape (2, points + 1), counter-clockwise."""
    angle = np.linspace(0.0, 2.0 * math.pi, points + 1)
    return np.array(centre)[:, None] + radius * np.array([np.cos(angle), np.sin(angle)])


COLOURS = {
    "planned track": "#666666",
    "median track": "#d55e00",
    "sample track": "#56b4e9",
    "arrival circle": "#009e73",
    "mooring circle": "#e69f00",
    "CEP": "#0072b2",
    "mooring ellipse": "#cc79a7",
    "goal": "#222222",
    "waypoint": "#666666",
    "surfacing": "#d55e00",
    "mooring": "#cc79a7",
    "start": "#222222",
    "fix": "#009e73",
    "anchor": "#cc79a7",
    "hover": "#d55e00",
    "search area": "#d55e00",
    "land": "#8c7a3c",
    "keep-out": "#d55e00",
}
"""By kind, as #rrggbb."""
STYLES = ("marker-color", "marker-size", "stroke", "stroke-width", "stroke-opacity", "fill", "fill-opacity")
"""Properties of simplestyle."""
WIDTHS = {"planned track": 2.0, "median track": 3.0, "sample track": 1.0}
"""Of lines in pixels, where not 2."""


def kml_colour(kind: str, alpha: int = 255) -> str:
    """Return the colour of a kind as KML writes it: alpha, blue, green, red."""
    red, green, blue = COLOURS[kind][1:3], COLOURS[kind][3:5], COLOURS[kind][5:7]
    return f"{alpha:02x}{blue}{green}{red}"


def simplestyle(kind: str, geometry: str) -> dict[str, object]:
    """Return the properties by which GeoJSON viewers colour a feature (simplestyle 1.1)."""
    if geometry == "Point":
        return {"marker-color": COLOURS[kind], "marker-size": "small"}
    style: dict[str, object] = {"stroke": COLOURS[kind], "stroke-width": WIDTHS.get(kind, 2.0)}
    if kind == "sample track":
        style["stroke-opacity"] = 0.4
    return style if geometry != "Polygon" else {**style, "fill": COLOURS[kind], "fill-opacity": 0.05}


TITLE = "GeoJSON"
NEEDS_ORIGIN = True
lost = one_interval

Feature = dict[str, Any]


def files(plan: Plan, stem: str) -> dict[str, str | bytes]:
    """Write one file."""
    says = {"mission_sha256": plan.digest, "header": header(plan, TITLE, lost(plan))}
    return {f"{stem}.geojson": collection(plan.mission, features(plan), **says)}


def collection(name: str | None, features: Iterable[Feature], **says: object) -> str:
    """Write a collection with what else it says of itself, one feature a line."""
    head = _text({"type": "FeatureCollection", "name": name, **says}).removesuffix("}")
    lines = ",\n".join(map(_text, features))
    return f'{head}, "features": [\n{lines}\n]}}\n'


def _text(data: dict[str, Any]) -> str:
    return json.dumps(data, ensure_ascii=False, allow_nan=False)


def features(plan: Plan, *, circles: bool = True) -> Iterator[Feature]:
    """Yield the features of a plan with an origin, with or without arrival and mooring circles."""
    origin = cast("Origin", plan.origin)
    for phase in plan.phases:
        if isinstance(phase, PlannedMooring):
            yield from _mooring(phase, origin)
            centre, radius, kind = (phase.east, phase.north), phase.radius, "mooring circle"
        else:
            yield from _transit(phase, origin)
            centre, radius, kind = (phase.goal.east, phase.goal.north), phase.arrival_radius, "arrival circle"
        if circles:
            ring, name = longitudes_latitudes(circle(centre, radius), origin), f"{phase.name}: {kind}, {radius:.3g} m"
            yield area_feature(ring, kind, name=name, phase=phase.name, radius_m=radius)
    for fence in plan.fences:
        yield _areas_feature(areas(fence), fence.kind, name=fence.name, **fence.limits)


def _transit(transit: PlannedTransit, origin: Origin) -> Iterator[Feature]:
    if len(transit.waypoints) > 1:
        course = np.array([[waypoint.east, waypoint.north] for waypoint in transit.waypoints]).T
        line = longitudes_latitudes(course, origin)
        yield line_feature(
            line,
            "planned track",
            name=f"{transit.name}: planned track",
            phase=transit.name,
            **course_row(transit),
        )
    for waypoint in transit.waypoints:
        row = {**waypoint_row(transit, waypoint), "waypoint": waypoint.kind}
        del row["kind"]
        yield feature("Point", longitude_latitude(waypoint, origin), "waypoint", **row)


def _mooring(mooring: PlannedMooring, origin: Origin) -> Iterator[Feature]:
    row = mooring_row(mooring)
    del row["kind"]
    yield feature("Point", longitude_latitude(mooring, origin), "mooring", **row)


def line_feature(line: list[list[float]], kind: str, **properties: object) -> Feature:
    """Return the feature of a line, in two where it crosses the antimeridian."""
    cut = parts(line)
    return (
        feature("LineString", line, kind, **properties)
        if len(cut) == 1
        else _multi("LineString", cut, kind, properties)
    )


def area_feature(ring: list[list[float]], kind: str, **properties: object) -> Feature:
    """Return the feature of an area by its closed boundary, in two where it crosses the antimeridian."""
    return _areas_feature([[part] for part in parts(ring, closed=True)], kind, **properties)


def _areas_feature(cut: list[list[list[list[float]]]], kind: str, **properties: object) -> Feature:
    return feature("Polygon", cut[0], kind, **properties) if len(cut) == 1 else _multi("Polygon", cut, kind, properties)


def _multi(geometry: str, coordinates: object, kind: str, properties: dict[str, object]) -> Feature:
    made = feature(geometry, coordinates, kind, **properties)
    return {**made, "geometry": {"type": f"Multi{geometry}", "coordinates": coordinates}}


def feature(geometry: str, coordinates: object, kind: str, **properties: object) -> Feature:
    """Return a feature, with its kind and its colours."""
    shape = {"type": geometry, "coordinates": coordinates}
    return {
        "type": "Feature",
        "geometry": shape,
        "properties": {"kind": kind, **properties, **simplestyle(kind, geometry)},
    }
