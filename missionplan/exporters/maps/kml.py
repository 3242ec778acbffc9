"""KML 2.2 (OGC 07-147r2): course, waypoints, arrival and mooring circles, for Google Earth."""

from collections.abc import Iterable, Mapping
from xml.etree import ElementTree

from missionplan.exporters.header import header, one_interval
from missionplan.exporters.maps.colours import WIDTHS, kml_colour
from missionplan.exporters.maps.geometry import circle, course_line, longitude_latitude, longitudes_latitudes
from missionplan.exporters.table import mooring_row, waypoint_row
from missionplan.exporters.xml import Element, add, document
from missionplan.results.plan import Plan, PlannedMooring, PlannedTransit

TITLE = "KML 2.2"
NEEDS_ORIGIN = True
NAMESPACE = "http://www.opengis.net/kml/2.2"

_KINDS = ("planned track", "waypoint", "mooring", "arrival circle", "mooring circle", "land", "keep-out")


def lost(plan: Plan) -> tuple[str, ...]:
    """Say what the form cannot hold."""
    return one_interval(plan)


def files(plan: Plan, stem: str) -> dict[str, str | bytes]:
    """Write one file, all of it clamped to the surface; depths are in the points' data."""
    root = ElementTree.Element("kml", xmlns=NAMESPACE)
    container = add(root, "Document")
    add(container, "name", plan.mission)
    add(container, "description", "\n".join(header(plan, TITLE, lost(plan))))
    styles(container, _KINDS)
    plan_folders(container, plan)
    return {f"{stem}.kml": document(root)}


def plan_folders(container: Element, plan: Plan, *, circles: bool = True) -> None:
    """Add a folder for each phase of a plan with an origin, with or without arrival and mooring circles."""
    for phase in plan.phases:
        folder = add(container, "Folder")
        add(folder, "name", f"{phase.name}: plan")
        if isinstance(phase, PlannedMooring):
            _mooring(folder, plan, phase, circles=circles)
        else:
            _transit(folder, plan, phase, circles=circles)
    if plan.fences:
        folder = add(container, "Folder")
        add(folder, "name", "Keep out")
        for fence in plan.fences:
            outline, *holes = fence.rings
            polygon(placemark(folder, fence.name, fence.kind, fence.limits), outline, holes)


def styles(container: Element, kinds: Iterable[str]) -> None:
    """Add the styles that placemarks of these kinds refer to."""
    for kind in kinds:
        style = add(container, "Style", id=style_id(kind))
        icon = add(style, "IconStyle")
        add(icon, "color", kml_colour(kind))
        add(icon, "scale", "0.7")
        line = add(style, "LineStyle")
        add(line, "color", kml_colour(kind, 102 if kind == "sample track" else 255))
        add(line, "width", f"{WIDTHS.get(kind, 2.0):g}")
        add(add(style, "PolyStyle"), "fill", "0")


def style_id(kind: str) -> str:
    """Return the name of the style of a kind."""
    return kind.replace(" ", "-")


def placemark(
    folder: Element, name: str, kind: str, data: Mapping[str, object] | None = None, times: tuple[str, ...] = ()
) -> Element:
    """Add a placemark without its geometry, which comes next.

    Parameters
    ----------
    folder : Element
    name, kind : str
        The kind gives the style.
    data : mapping, optional
        What viewers show; None is left out.
    times : tuple of str
        When, or begin and end; ISO 8601, empty where not known.
    """
    mark = add(folder, "Placemark")
    add(mark, "name", name)
    if all(times) and len(times) == 1:
        add(add(mark, "TimeStamp"), "when", times[0])
    elif all(times) and times:
        span = add(mark, "TimeSpan")
        add(span, "begin", times[0])
        add(span, "end", times[1])
    add(mark, "styleUrl", f"#{style_id(kind)}")
    known = {key: value for key, value in (data or {}).items() if value is not None}
    if known:
        extended = add(mark, "ExtendedData")
        for key, value in known.items():
            text = f"{value:.10g}" if isinstance(value, float) else str(value)
            add(add(extended, "Data", name=key), "value", text)
    return mark


def line(mark: Element, points: Iterable[Iterable[float]]) -> None:
    """Add a line through longitudes and latitudes [deg]."""
    geometry = add(mark, "LineString")
    add(geometry, "tessellate", "1")
    add(geometry, "coordinates", coordinates(points))


def polygon(mark: Element, ring: Iterable[Iterable[float]], holes: Iterable[Iterable[Iterable[float]]] = ()) -> None:
    """Add a polygon by its closed boundary, and those of its holes [deg]."""
    geometry = add(mark, "Polygon")
    add(geometry, "tessellate", "1")
    add(add(add(geometry, "outerBoundaryIs"), "LinearRing"), "coordinates", coordinates(ring))
    for hole in holes:
        add(add(add(geometry, "innerBoundaryIs"), "LinearRing"), "coordinates", coordinates(hole))


def point(mark: Element, place: Iterable[float]) -> None:
    """Add a point [deg]."""
    add(add(mark, "Point"), "coordinates", coordinates([place]))


def coordinates(points: Iterable[Iterable[float]]) -> str:
    """Write longitudes and latitudes [deg]."""
    return " ".join(",".join(f"{value:.7f}" for value in place) for place in points)


def _transit(folder: Element, plan: Plan, transit: PlannedTransit, *, circles: bool) -> None:
    origin, rule = plan.origin or (0.0, 0.0), transit.surfacing
    if len(transit.waypoints) > 1:
        data = {
            "depth_m": transit.depth,
            "speed_m_s": transit.speed,
            "surfacing_interval_m": rule.interval,
            "surfacing_interval_s": round(rule.interval_time, 1),
            "surface_time_s": rule.surface_time,
            "time_out_s": transit.time_out,
        }
        mark = placemark(folder, f"{transit.name}: planned track", "planned track", data)
        line(mark, longitudes_latitudes(course_line(transit.waypoints), origin))
    for waypoint in transit.waypoints:
        row = waypoint_row(transit, waypoint)
        point(placemark(folder, waypoint.name, "waypoint", row), longitude_latitude(waypoint, origin))
    if not circles:
        return
    name = f"{transit.name}: arrival circle, {transit.arrival_radius:.3g} m"
    ring = circle((transit.goal.east, transit.goal.north), transit.arrival_radius)
    polygon(placemark(folder, name, "arrival circle"), longitudes_latitudes(ring, origin))


def _mooring(folder: Element, plan: Plan, mooring: PlannedMooring, *, circles: bool) -> None:
    origin = plan.origin or (0.0, 0.0)
    row = mooring_row(mooring)
    point(placemark(folder, mooring.name, "mooring", row), longitude_latitude(mooring, origin))
    if not circles:
        return
    name = f"{mooring.name}: mooring circle, {mooring.radius:.3g} m"
    ring = circle((mooring.east, mooring.north), mooring.radius)
    polygon(placemark(folder, name, "mooring circle"), longitudes_latitudes(ring, origin))
