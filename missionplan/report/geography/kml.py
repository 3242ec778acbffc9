"""Tracks, fixes, circles of error and the plan as KML 2.2 (OGC 07-147r2), for Google Earth and other programs."""

from xml.etree import ElementTree

import numpy as np

from missionplan.exporters.maps.colours import COLOURS
from missionplan.exporters.maps.geometry import Origin, longitudes_latitudes
from missionplan.exporters.maps.kml import NAMESPACE, line, placemark, plan_folders, point, polygon, styles
from missionplan.exporters.xml import Element, add, document
from missionplan.report.geography.plan_view import describe, rings
from missionplan.report.geography.track_points import TrackPoint, sample_trials, track_points
from missionplan.results.simulation import Outcome


def track_kml(outcome: Outcome) -> str | None:
    """Write the planned, median and sample tracks, fixes, goals, circles and ellipses, clamped to the surface.

    Returns None when the mission has no origin. Placemarks have times where the mission has a start.
    """
    origin = outcome.tracks.origin
    if origin is None:
        return None
    root = ElementTree.Element("kml", xmlns=NAMESPACE)
    container = add(root, "Document")
    add(container, "name", outcome.provenance.mission)
    of_plan = f", SHA-256 of the mission {outcome.plan.digest}" if outcome.plan else ""
    run = f"missionplan, seed {outcome.provenance.seed}, {outcome.provenance.trials} trials{of_plan}"
    add(container, "description", run)
    styles(container, COLOURS)
    if outcome.plan is not None:
        plan_folders(container, outcome.plan, circles=False)
    _tracks(container, outcome, origin)
    _fixes(container, outcome, origin)
    _goals(container, outcome, origin)
    return document(root)


def _tracks(container: Element, outcome: Outcome, origin: Origin) -> None:
    median, samples = sample_trials(outcome)
    folder = add(container, "Folder")
    add(folder, "name", "Tracks")
    for trial, kind in [(median, "median track"), *((trial, "sample track") for trial in samples)]:
        points = track_points(outcome, trial)
        if len(points) > 1:
            span = {"begin_s": round(points[0].time, 1), "end_s": round(points[-1].time, 1)}
            times = (points[0].utc, points[-1].utc)
            mark = placemark(folder, f"{kind}, trial {trial}", kind, span, times)
            line(mark, longitudes_latitudes(np.array([point.position for point in points]).T, origin))


def _fixes(container: Element, outcome: Outcome, origin: Origin) -> None:
    """Where the median trial is at each fix, and its anchor."""
    median, _ = sample_trials(outcome)
    folder = add(container, "Folder")
    add(folder, "name", f"Fixes, trial {median}")
    for each in track_points(outcome, median):
        _fix(folder, each, origin)


def _fix(folder: Element, fix: TrackPoint, origin: Origin) -> None:
    (place,) = longitudes_latitudes(np.array(fix.position)[:, None], origin)
    point(placemark(folder, fix.name, fix.kind, fix.data(), (fix.utc,)), place)


def _goals(container: Element, outcome: Outcome, origin: Origin) -> None:
    drawn = list(rings(outcome))
    for phase, (goal, _) in outcome.tracks.targets.items():
        folder = add(container, "Folder")
        add(folder, "name", phase)
        for ring in (ring for ring in drawn if ring.phase == phase):
            polygon(placemark(folder, describe(ring), ring.kind), longitudes_latitudes(ring.line, origin))
        (place,) = longitudes_latitudes(np.array(goal)[:, None], origin)
        point(placemark(folder, f"{phase}: goal", "goal"), place)
