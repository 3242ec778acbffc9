"""GPX 1.1: way points and a route, for plotters and hand-held receivers."""

from collections.abc import Mapping
from xml.etree import ElementTree

from missionplan.exporters import Element, add, document, header, one_interval, zones_lost
from missionplan.exporters.table import Cell, course_row, mooring_row, waypoint_row
from missionplan.results.plan import Plan, PlannedTransit

TITLE = "GPX 1.1"
NEEDS_ORIGIN = True

_GPX = "http://www.topografix.com/GPX/1/1"
_OWN = "urn:missionplan:plan:1"
_COLUMNS = ("name", "phase", "kind", "latitude_deg", "longitude_deg", "east_m", "north_m")
"""What the point itself says, not its extensions."""


def lost(plan: Plan) -> tuple[str, ...]:
    """Say what the form cannot hold."""
    return (
        "speed, time-out, rule for surfacing and mooring but in extensions that other programs ignore",
        *one_interval(plan),
        *zones_lost(plan, "GPX holds points and lines"),
    )


def files(plan: Plan, stem: str) -> dict[str, str | bytes]:
    """Write one file: a way point for each mooring, and a route for each transit."""
    root = ElementTree.Element("gpx", {"xmlns": _GPX, "xmlns:mp": _OWN, "version": "1.1", "creator": "missionplan"})
    metadata = add(root, "metadata")
    add(metadata, "name", plan.mission)
    add(metadata, "desc", "\n".join(header(plan, TITLE, lost(plan))))
    if plan.start is not None:
        add(metadata, "time", plan.start.strftime("%Y-%m-%dT%H:%M:%SZ"))
    for mooring in plan.moorings:
        _point(root, "wpt", mooring_row(mooring))
    for number, transit in enumerate(plan.transits, start=1):
        _route(root, number, transit)
    return {f"{stem}.gpx": document(root)}


def _route(root: Element, number: int, transit: PlannedTransit) -> None:
    rule = transit.surfacing
    route = add(root, "rte")
    add(route, "name", transit.name)
    add(route, "desc", f"at {transit.depth:g} m and {transit.speed:g} m/s, surfacing every {rule.interval:g} m")
    add(route, "number", str(number))
    kept = {key: value for key, value in course_row(transit).items() if key.startswith(("surfacing", "time"))}
    _extensions(route, {**kept, "arrival_radius_m": transit.arrival_radius})
    for waypoint in transit.waypoints:
        _point(route, "rtept", waypoint_row(transit, waypoint))


def _point(parent: Element, tag: str, row: dict[str, Cell]) -> None:
    point = add(parent, tag, lat=f"{row['latitude_deg']:.8f}", lon=f"{row['longitude_deg']:.8f}")
    depth = row["depth_m"]
    if isinstance(depth, float):
        add(point, "ele", f"{-depth:g}")
    add(point, "name", str(row["name"]))
    add(point, "type", str(row["kind"]))
    _extensions(point, {key: value for key, value in row.items() if key not in _COLUMNS and value is not None})


def _extensions(parent: Element, values: Mapping[str, Cell]) -> None:
    extensions = add(parent, "extensions")
    for key, value in values.items():
        add(extensions, f"mp:{key}", f"{value:.10g}" if isinstance(value, float) else str(value))
