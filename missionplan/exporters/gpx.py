"""GPX 1.1: way points and a route, for plotters and hand-held receivers."""

from collections.abc import Mapping
from xml.etree import ElementTree

from missionplan.exporters import Content, document, filled, header, one_interval, zones_lost
from missionplan.exporters.table import Cell, course_row, mooring_row, waypoint_row
from missionplan.results.plan import Plan

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
    about = {"name": plan.mission, "desc": "\n".join(header(plan, TITLE, lost(plan)))}
    if plan.start is not None:
        about["time"] = plan.start.strftime("%Y-%m-%dT%H:%M:%SZ")
    routes: list[Content] = []
    for number, transit in enumerate(plan.transits, start=1):
        every = f"surfacing every {transit.surfacing.interval:g} m"
        kept = {key: value for key, value in course_row(transit).items() if key.startswith(("surfacing", "time"))}
        routes.append(
            {
                "name": transit.name,
                "desc": f"at {transit.depth:g} m and {transit.speed:g} m/s, {every}",
                "number": str(number),
                "extensions": _extensions({**kept, "arrival_radius_m": transit.arrival_radius}),
                "rtept": [_point(waypoint_row(transit, waypoint)) for waypoint in transit.waypoints],
            }
        )
    places = [_point(mooring_row(mooring)) for mooring in plan.moorings]
    return {f"{stem}.gpx": document(filled(root, {"metadata": about, "wpt": places, "rte": routes}))}


def _point(row: dict[str, Cell]) -> Content:
    depth = row["depth_m"]
    return {
        "@lat": f"{row['latitude_deg']:.8f}",
        "@lon": f"{row['longitude_deg']:.8f}",
        **({"ele": f"{-depth:g}"} if isinstance(depth, float) else {}),
        "name": str(row["name"]),
        "type": str(row["kind"]),
        "extensions": _extensions({k: value for k, value in row.items() if k not in _COLUMNS and value is not None}),
    }


def _extensions(values: Mapping[str, Cell]) -> Content:
    return {f"mp:{key}": f"{value:.10g}" if isinstance(value, float) else str(value) for key, value in values.items()}
