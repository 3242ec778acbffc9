"""KML 2.2 (OGC 07-147r2) of the same features as GeoJSON, for Google Earth, clamped to the surface."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any
from xml.etree import ElementTree

from missionplan.exporters import Content, document, filled, header, one_interval
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
    for feature in features(plan, circles=circles):
        phase = properties_of(feature).get("phase")
        folders.setdefault("Keep out" if phase is None else f"{phase}: plan", []).append(feature)
    return folders


def kml(name: str, description: str, folders: Mapping[str, Sequence[Feature]]) -> str:
    """Write a document of features, folder by folder.

    `folders`: as GeoJSON has them; a feature's kind gives its style, its properties are what viewers show of it.
    """
    shown = {properties_of(feature)["kind"] for folder in folders.values() for feature in folder}
    styles: list[Content] = [
        {
            "@id": kind.replace(" ", "-"),
            "IconStyle": {"color": kml_colour(kind), "scale": "0.7"},
            "LineStyle": {
                "color": kml_colour(kind, 102 if kind == "sample track" else 255),
                "width": f"{WIDTHS.get(kind, 2.0):g}",
            },
            "PolyStyle": {"fill": "0"},
        }
        for kind in COLOURS
        if kind in shown
    ]
    listed: list[Content] = [
        {"name": title, "Placemark": [_placemark(feature) for feature in contents]}
        for title, contents in folders.items()
    ]
    content: Content = {"name": name, "description": description, "Style": styles, "Folder": listed}
    return document(filled(ElementTree.Element("kml", xmlns=NAMESPACE), {"Document": content}))


def properties_of(feature: Feature) -> dict[str, Any]:
    """Return the properties of a feature but those by which viewers of GeoJSON colour it."""
    return {key: value for key, value in feature["properties"].items() if key not in STYLES}


def _placemark(feature: Feature) -> Content:
    data = properties_of(feature)
    kind, times = data["kind"], data.get("coordTimes", [data["time"]] if data.get("time") else [])
    mark: dict[str, Any] = {"name": data.pop("name")}
    if times:
        mark |= {"TimeSpan": {"begin": times[0], "end": times[-1]}} if times[1:] else {"TimeStamp": {"when": times[0]}}
    mark["styleUrl"] = f"#{kind.replace(' ', '-')}"
    data["kind"] = data.pop("waypoint", kind)
    if isinstance(data.get("elapsed_s"), list):
        data |= {"begin_s": data["elapsed_s"][0], "end_s": data["elapsed_s"][-1]}
        data = {key: value for key, value in data.items() if key not in _LISTED}
    fields = {key: value for key, value in data.items() if value is not None}
    if fields:
        texts = {key: f"{value:.10g}" if isinstance(value, float) else str(value) for key, value in fields.items()}
        mark["ExtendedData"] = {"Data": [{"@name": key, "value": text} for key, text in texts.items()]}
    shape, coordinates = feature["geometry"]["type"], feature["geometry"]["coordinates"]
    if not shape.startswith("Multi"):
        return {**mark, shape: _geometry(shape, coordinates)}
    part = shape.removeprefix("Multi")
    return {**mark, "MultiGeometry": {part: [_geometry(part, ring) for ring in coordinates]}}


def _geometry(kind: str, coordinates: Any) -> Content:
    """What is inside a geometry of one part."""
    if kind == "Point":
        return {"coordinates": _coordinates([coordinates])}
    if kind == "LineString":
        return {"tessellate": "1", "coordinates": _coordinates(coordinates)}
    outer, *inner = ({"LinearRing": {"coordinates": _coordinates(ring)}} for ring in coordinates)
    return {"tessellate": "1", "outerBoundaryIs": outer, "innerBoundaryIs": inner}


def _coordinates(points: Iterable[Iterable[float]]) -> str:
    return " ".join(",".join(f"{value:.7f}" for value in place) for place in points)
