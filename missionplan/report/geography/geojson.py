"""Tracks and circles of error as GeoJSON (RFC 7946), for QGIS and its like."""

import json
import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from missionplan.arrays import Array
from missionplan.mission.geodesy import to_geographic
from missionplan.mission.schema.site import Geographic
from missionplan.report.geography.plan_view import Ring, median_trial, rings, track
from missionplan.results.simulation import Outcome

SAMPLES = 50
"""Sample tracks written."""


def track_geojson(outcome: Outcome) -> str | None:
    """Write the median and sample tracks, goals, arrival circles, CEP and mooring ellipses.

    Returns None when the mission has no origin. Longitudes run on across the antimeridian, beyond ±180°, so that
    no feature is torn apart.
    """
    if outcome.tracks.origin is None:
        return None
    collection = {"type": "FeatureCollection", "name": outcome.provenance.mission, "features": list(_features(outcome))}
    return json.dumps(collection, ensure_ascii=False, allow_nan=False, indent=1) + "\n"


def longitudes_latitudes(points: Array, origin: tuple[float, float]) -> list[list[float]]:
    """Longitude and latitude [deg] of points of shape (2, n), to about a centimetre."""
    place = Geographic.model_construct(latitude=origin[0], longitude=origin[1])
    latitude, longitude = to_geographic(points[0], points[1], place)
    longitude = origin[1] + np.remainder(longitude - origin[1] + math.pi, 2.0 * math.pi) - math.pi
    rounded: list[list[float]] = np.round(np.degrees((longitude, latitude)).T, 7).tolist()
    return rounded


def sample_trials(outcome: Outcome) -> tuple[int, list[int]]:
    """Choose the trial that stands for all, and others that show their spread."""
    median = median_trial(outcome.tracks)
    trials = range(outcome.tracks.position.shape[2])
    return median, [trial for trial in trials if trial != median][:SAMPLES]


def describe(ring: Ring) -> str:
    """Say what a ring is: ``ingress: CEP 50 %, 7.1 m``."""
    share = "" if math.isnan(ring.share) else f" {100.0 * ring.share:.0f} %"
    radius = "" if ring.kind == "mooring ellipse" else f", {ring.radius:.3g} m"
    return f"{ring.phase}: {ring.kind}{share}{radius}"


def _features(outcome: Outcome) -> Iterator[dict[str, Any]]:
    tracks = outcome.tracks
    assert tracks.origin is not None
    median, samples = sample_trials(outcome)
    for trial, kind in [*((trial, "sample track") for trial in samples), (median, "median track")]:
        line = track(tracks, trial)
        if line.shape[1] > 1:
            geometry = {"type": "LineString", "coordinates": longitudes_latitudes(line, tracks.origin)}
            yield _feature(geometry, name=f"{kind}, trial {trial}", kind=kind, trial=trial)
    for ring in rings(outcome):
        geometry = {"type": "Polygon", "coordinates": [longitudes_latitudes(ring.line, tracks.origin)]}
        share = None if math.isnan(ring.share) else ring.share
        yield _feature(
            geometry, name=describe(ring), kind=ring.kind, phase=ring.phase, share=share, radius_m=round(ring.radius, 3)
        )
    for name, (goal, _) in tracks.targets.items():
        (point,) = longitudes_latitudes(np.array(goal)[:, None], tracks.origin)
        yield _feature({"type": "Point", "coordinates": point}, name=f"{name}: goal", kind="goal", phase=name)


def _feature(geometry: dict[str, Any], **properties: Any) -> dict[str, Any]:
    return {"type": "Feature", "geometry": geometry, "properties": properties}
