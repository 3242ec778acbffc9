"""Tracks and circles of error as KML 2.2 (OGC 07-147r2), for Google Earth and other programs."""

import re
from xml.etree import ElementTree

import numpy as np

from missionplan.arrays import Array
from missionplan.report.geography.geojson import describe, longitudes_latitudes, sample_trials
from missionplan.report.geography.plan_view import Ring, rings, track
from missionplan.results.simulation import Outcome

Element = ElementTree.Element

_NAMESPACE = "http://www.opengis.net/kml/2.2"
_STYLES = {
    "sample-track": ("66b27200", 1.0),
    "median-track": ("ff005ed5", 3.0),
    "arrival-circle": ("ff739e00", 2.0),
    "mooring-circle": ("ff739e00", 2.0),
    "CEP": ("ffe9b456", 2.0),
    "mooring-ellipse": ("ffa779cc", 2.0),
}
"""Colour (alpha, blue, green, red, as in KML) and width of the lines, by what they show."""
_NOT_IN_XML = re.compile("[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def track_kml(outcome: Outcome) -> str | None:
    """Write the median and sample tracks, goals, arrival circles, CEP and mooring ellipses, clamped to the surface.

    Returns None when the mission has no origin.
    """
    origin = outcome.tracks.origin
    if origin is None:
        return None
    root = ElementTree.Element("kml", xmlns=_NAMESPACE)
    document = _add(root, "Document")
    _add(document, "name", outcome.provenance.mission)
    _add(document, "description", f"missionplan, seed {outcome.provenance.seed}, {outcome.provenance.trials} trials")
    for name, (colour, width) in _STYLES.items():
        _style(document, name, colour, width)
    _tracks(document, outcome, origin)
    _goals(document, outcome, origin)
    ElementTree.indent(root, " ")
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ElementTree.tostring(root, encoding="unicode") + "\n"


def _tracks(document: Element, outcome: Outcome, origin: tuple[float, float]) -> None:
    median, samples = sample_trials(outcome)
    folder = _add(document, "Folder")
    _add(folder, "name", "Tracks")
    for trial, kind in [(median, "median track"), *((trial, "sample track") for trial in samples)]:
        points = track(outcome.tracks, trial)
        if points.shape[1] > 1:
            line = _add(_placemark(folder, f"{kind}, trial {trial}", kind.replace(" ", "-")), "LineString")
            _add(line, "tessellate", "1")
            _add(line, "coordinates", _coordinates(points, origin))


def _goals(document: Element, outcome: Outcome, origin: tuple[float, float]) -> None:
    drawn = list(rings(outcome))
    for phase, (goal, _) in outcome.tracks.targets.items():
        folder = _add(document, "Folder")
        _add(folder, "name", phase)
        for ring in (ring for ring in drawn if ring.phase == phase):
            _ring(folder, ring, origin)
        point = _add(_placemark(folder, f"{phase}: goal"), "Point")
        _add(point, "coordinates", _coordinates(np.array(goal)[:, None], origin))


def _ring(folder: Element, ring: Ring, origin: tuple[float, float]) -> None:
    polygon = _add(_placemark(folder, describe(ring), ring.kind.replace(" ", "-")), "Polygon")
    _add(polygon, "tessellate", "1")
    boundary = _add(_add(polygon, "outerBoundaryIs"), "LinearRing")
    _add(boundary, "coordinates", _coordinates(ring.line, origin))


def _style(document: Element, name: str, colour: str, width: float) -> None:
    style = ElementTree.SubElement(document, "Style", id=name)
    line = _add(style, "LineStyle")
    _add(line, "color", colour)
    _add(line, "width", f"{width:g}")
    _add(_add(style, "PolyStyle"), "fill", "0")


def _placemark(folder: Element, name: str, style: str = "") -> Element:
    placemark = _add(folder, "Placemark")
    _add(placemark, "name", name)
    if style:
        _add(placemark, "styleUrl", f"#{style}")
    return placemark


def _coordinates(points: Array, origin: tuple[float, float]) -> str:
    return " ".join(f"{longitude:.7f},{latitude:.7f}" for longitude, latitude in longitudes_latitudes(points, origin))


def _add(parent: Element, tag: str, text: str | None = None) -> Element:
    """Add an element; characters that XML cannot hold are replaced."""
    child = ElementTree.SubElement(parent, tag)
    if text is not None:
        child.text = _NOT_IN_XML.sub("\ufffd", text)
    return child
