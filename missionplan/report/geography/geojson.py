"""Tracks and circles of error as GeoJSON (RFC 7946), for QGIS and other programs."""

import json
import math
from collections.abc import Iterator, Mapping

import numpy as np

from missionplan.arrays import Array
from missionplan.mission.geodesy import to_geographic
from missionplan.mission.schema.site import Geographic
from missionplan.report.geography.plan_view import Ring, median_trial, rings, track
from missionplan.results.simulation import Outcome

Feature = Mapping[str, object]
"""A feature or a geometry of GeoJSON."""

SAMPLES = 50
"""Number of sample tracks written."""


def track_geojson(outcome: Outcome) -> str | None:
    """Write the median and sample tracks, goals, arrival circles, CEP and mooring ellipses.

    Returns None when the mission has no origin. Longitudes continue across the antimeridian, beyond ±180°, so that
    no feature is torn apart.
    """
    origin = outcome.tracks.origin
    if origin is None:
        return None
    features = [*_track_features(outcome, origin), *_ring_features(outcome, origin), *_goal_features(outcome, origin)]
    collection = {"type": "FeatureCollection", "name": outcome.provenance.mission, "features": features}
    return json.dumps(collection, ensure_ascii=False, allow_nan=False, indent=1) + "\n"


def longitudes_latitudes(points: Array, origin: tuple[float, float]) -> list[list[float]]:
    """Return longitude and latitude [deg] of points of shape (2, n), rounded to about a centimetre."""
    place = Geographic.model_construct(latitude=origin[0], longitude=origin[1])
    latitude, longitude = to_geographic(points[0], points[1], place)
    longitude = origin[1] + np.remainder(longitude - origin[1] + math.pi, 2.0 * math.pi) - math.pi
    rounded: list[list[float]] = np.round(np.degrees((longitude, latitude)).T, 7).tolist()
    return rounded


def sample_trials(outcome: Outcome) -> tuple[int, list[int]]:
    """Choose the median trial, and others that show the spread."""
    median = median_trial(outcome.tracks)
    trials = range(outcome.tracks.position.shape[2])
    return median, [trial for trial in trials if trial != median][:SAMPLES]


def describe(ring: Ring) -> str:
    """Describe a ring: ``ingress: CEP 50 %, 7.1 m``."""
    share = "" if math.isnan(ring.share) else f" {100.0 * ring.share:.0f} %"
    radius = "" if ring.kind == "mooring ellipse" else f", {ring.radius:.3g} m"
    return f"{ring.phase}: {ring.kind}{share}{radius}"


def _track_features(outcome: Outcome, origin: tuple[float, float]) -> Iterator[Feature]:
    median, samples = sample_trials(outcome)
    for trial, kind in [*((trial, "sample track") for trial in samples), (median, "median track")]:
        line = track(outcome.tracks, trial)
        if line.shape[1] > 1:
            geometry = {"type": "LineString", "coordinates": longitudes_latitudes(line, origin)}
            yield _feature(geometry, name=f"{kind}, trial {trial}", kind=kind, trial=trial)


def _ring_features(outcome: Outcome, origin: tuple[float, float]) -> Iterator[Feature]:
    for ring in rings(outcome):
        geometry = {"type": "Polygon", "coordinates": [longitudes_latitudes(ring.line, origin)]}
        share = None if math.isnan(ring.share) else ring.share
        yield _feature(
            geometry, name=describe(ring), kind=ring.kind, phase=ring.phase, share=share, radius_m=round(ring.radius, 3)
        )


def _goal_features(outcome: Outcome, origin: tuple[float, float]) -> Iterator[Feature]:
    for name, (goal, _) in outcome.tracks.targets.items():
        (point,) = longitudes_latitudes(np.array(goal)[:, None], origin)
        yield _feature({"type": "Point", "coordinates": point}, name=f"{name}: goal", kind="goal", phase=name)


def _feature(geometry: Feature, **properties: object) -> Feature:
    return {"type": "Feature", "geometry": geometry, "properties": properties}
