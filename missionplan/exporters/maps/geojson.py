"""GeoJSON (RFC 7946) with simplestyle colours: course, waypoints, arrival and mooring circles."""

import json
from collections.abc import Iterable, Iterator
from typing import Any, cast

from missionplan.exporters.formats import header, one_interval
from missionplan.exporters.maps.geometry import (
    Origin,
    areas,
    circle,
    course_line,
    longitude_latitude,
    longitudes_latitudes,
    parts,
    simplestyle,
)
from missionplan.exporters.table import course_row, mooring_row, waypoint_row
from missionplan.results.plan import Plan, PlannedMooring, PlannedTransit

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
            yield _circle(phase.name, kind, centre, radius, origin)
    for fence in plan.fences:
        yield _areas_feature(areas(fence), fence.kind, name=fence.name, **fence.limits)


def _transit(transit: PlannedTransit, origin: Origin) -> Iterator[Feature]:
    if len(transit.waypoints) > 1:
        line = longitudes_latitudes(course_line(transit.waypoints), origin)
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


def _circle(phase: str, kind: str, centre: tuple[float, float], radius: float, origin: Origin) -> Feature:
    ring = longitudes_latitudes(circle(centre, radius), origin)
    return area_feature(ring, kind, name=f"{phase}: {kind}, {radius:.3g} m", phase=phase, radius_m=radius)


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
