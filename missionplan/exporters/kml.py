"""KML 2.2 (OGC 07-147r2) of the same features as GeoJSON, for Google Earth, clamped to the surface."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any
from xml.etree import ElementTree

from missionplan.exporters import Element, add, document, header, one_interval
from missionplan.exporters.geojson import COLOURS, STYLES, WIDTHS, Feature, features, kml_colour
from missionplan.results.plan import Plan

TITLE = "KML 2.2"
NEEDS_ORIGIN = True
lost = one_interval
NAMESPACE = "http://www.opengis.net/kml/2.2"

_LISTED = ("elapsed_s", "coordTimes")
"""Properties with a value for each point of a line; a placemark has its first and last."""


def files(plan: Plan, stem: str) -> dict[str, str | bytes]:
    """Write one file; depths are in the points' data."""
    return {f"{stem}.kml": kml(plan.mission, "\n".join(header(plan, TITLE, lost(plan))), plan_folders(plan))}


def plan_folders(plan: Plan, *, circles: bool = True) -> dict[str, list[Feature]]:
    """Return the features of a plan with an origin by the folders that they are shown in: phases, and zones."""
    folders: dict[str, list[Feature]] = {f"{phase.name}: plan": [] for phase in plan.phases}
    for each in features(plan, circles=circles):
        phase = properties_of(each).get("phase")
        folders.setdefault("Keep out" if phase is None else f"{phase}: plan", []).append(each)
    return folders


def kml(name: str, description: str, folders: Mapping[str, Sequence[Feature]]) -> str:
    """Write a document of features, folder by folder.

    `folders`: as GeoJSON has them; a feature's kind gives its style, its properties are what viewers show of it.
    """
    root = ElementTree.Element("kml", xmlns=NAMESPACE)
    container = add(root, "Document")
    add(container, "name", name)
    add(container, "description", description)
    shown = {properties_of(each)["kind"] for folder in folders.values() for each in folder}
    for kind in (kind for kind in COLOURS if kind in shown):
        _style(container, kind)
    for title, held in folders.items():
        folder = add(container, "Folder")
        add(folder, "name", title)
        for each in held:
            _placemark(folder, each)
    return document(root)


def properties_of(feature: Feature) -> dict[str, Any]:
    """Return the properties of a feature but those by which viewers of GeoJSON colour it."""
    return {key: value for key, value in feature["properties"].items() if key not in STYLES}


def _style(container: Element, kind: str) -> None:
    style = add(container, "Style", id=kind.replace(" ", "-"))
    icon = add(style, "IconStyle")
    add(icon, "color", kml_colour(kind))
    add(icon, "scale", "0.7")
    line = add(style, "LineStyle")
    add(line, "color", kml_colour(kind, 102 if kind == "sample track" else 255))
    add(line, "width", f"{WIDTHS.get(kind, 2.0):g}")
    add(add(style, "PolyStyle"), "fill", "0")


def _placemark(folder: Element, feature: Feature) -> None:
    data = properties_of(feature)
    kind, times = data["kind"], data.get("coordTimes", [data["time"]] if data.get("time") else [])
    mark = add(folder, "Placemark")
    add(mark, "name", data.pop("name"))
    if len(times) == 1:
        add(add(mark, "TimeStamp"), "when", times[0])
    elif times:
        span = add(mark, "TimeSpan")
        add(span, "begin", times[0])
        add(span, "end", times[-1])
    add(mark, "styleUrl", f"#{kind.replace(' ', '-')}")
    data["kind"] = data.pop("waypoint", kind)
    if isinstance(data.get("elapsed_s"), list):
        data |= {"begin_s": data["elapsed_s"][0], "end_s": data["elapsed_s"][-1]}
        data = {key: value for key, value in data.items() if key not in _LISTED}
    known = {key: value for key, value in data.items() if value is not None}
    if known:
        extended = add(mark, "ExtendedData")
        for key, value in known.items():
            text = f"{value:.10g}" if isinstance(value, float) else str(value)
            add(add(extended, "Data", name=key), "value", text)
    _geometry(mark, feature["geometry"])


def _geometry(parent: Element, geometry: Any) -> None:
    """Add a geometry; one of several parts as these."""
    kind, held = geometry["type"], geometry["coordinates"]
    if kind.startswith("Multi"):
        several = add(parent, "MultiGeometry")
        for part in held:
            _geometry(several, {"type": kind.removeprefix("Multi"), "coordinates": part})
        return
    drawn = add(parent, kind)
    if kind == "Point":
        add(drawn, "coordinates", _coordinates([held]))
        return
    add(drawn, "tessellate", "1")
    if kind == "LineString":
        add(drawn, "coordinates", _coordinates(held))
        return
    for number, ring in enumerate(held):
        boundary = add(drawn, "innerBoundaryIs" if number else "outerBoundaryIs")
        add(add(boundary, "LinearRing"), "coordinates", _coordinates(ring))


def _coordinates(points: Iterable[Iterable[float]]) -> str:
    return " ".join(",".join(f"{value:.7f}" for value in place) for place in points)
