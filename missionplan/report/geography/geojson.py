"""Tracks, fixes, circles of error and the plan as GeoJSON (RFC 7946), for QGIS and other programs."""

import json
import math
from collections.abc import Iterator

import numpy as np

from missionplan.exporters.maps.geojson import Feature, area_feature, feature, line_feature
from missionplan.exporters.maps.geojson import features as plan_features
from missionplan.exporters.maps.geometry import Origin, longitudes_latitudes, parts
from missionplan.report.geography.plan_view import describe, rings
from missionplan.report.geography.track_points import TrackPoint, sample_trials, track_points
from missionplan.results.simulation import Outcome


def track_geojson(outcome: Outcome) -> str | None:
    """Write the planned, median and sample tracks, fixes, goals, arrival circles, CEP and mooring ellipses.

    Returns None when the mission has no origin. Longitudes continue across the antimeridian, beyond ±180°, so that
    no feature is torn apart. Times are seconds since the mission's start, and UTC where the mission has a start.
    """
    origin = outcome.tracks.origin
    if origin is None:
        return None
    features = [
        *(plan_features(outcome.plan, circles=False) if outcome.plan else ()),
        *_track_features(outcome, origin),
        *_fix_features(outcome, origin),
        *_ring_features(outcome, origin),
        *_goal_features(outcome, origin),
    ]
    collection = {
        "type": "FeatureCollection",
        "name": outcome.provenance.mission,
        **({"mission_sha256": outcome.plan.digest} if outcome.plan else {}),
        "features": features,
    }
    return json.dumps(collection, ensure_ascii=False, allow_nan=False, indent=1) + "\n"


def _track_features(outcome: Outcome, origin: Origin) -> Iterator[Feature]:
    median, samples = sample_trials(outcome)
    for trial, kind in [*((trial, "sample track") for trial in samples), (median, "median track")]:
        points = track_points(outcome, trial)
        if len(points) > 1:
            line = longitudes_latitudes(np.array([point.position for point in points]).T, origin)
            times = _times(points) if len(parts(line)) == 1 else {}  # a cut line has points of no known time
            yield line_feature(line, kind, name=f"{kind}, trial {trial}", trial=trial, **times)


def _times(points: list[TrackPoint]) -> dict[str, object]:
    """Times of the points of a line; `coordTimes` is what viewers of GeoJSON read."""
    utc = [point.utc for point in points]
    known = {"coordTimes": utc} if all(utc) else {}
    return {"elapsed_s": [round(point.time, 1) for point in points], **known}


def _fix_features(outcome: Outcome, origin: Origin) -> Iterator[Feature]:
    """Where the median trial is at each fix, and its anchor."""
    median, _ = sample_trials(outcome)
    for point in track_points(outcome, median):
        (place,) = longitudes_latitudes(np.array(point.position)[:, None], origin)
        data = {key: value for key, value in point.data().items() if value is not None}
        yield feature("Point", place, point.kind, name=point.name, trial=median, **data)


def _ring_features(outcome: Outcome, origin: Origin) -> Iterator[Feature]:
    for ring in rings(outcome):
        share = None if math.isnan(ring.share) else ring.share
        boundary = longitudes_latitudes(ring.line, origin)
        radius = round(ring.radius, 3)
        yield area_feature(boundary, ring.kind, name=describe(ring), phase=ring.phase, share=share, radius_m=radius)


def _goal_features(outcome: Outcome, origin: Origin) -> Iterator[Feature]:
    for name, (goal, _) in outcome.tracks.targets.items():
        (point,) = longitudes_latitudes(np.array(goal)[:, None], origin)
        yield feature("Point", point, "goal", name=f"{name}: goal", phase=name)
