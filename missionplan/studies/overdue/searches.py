"""Searches that found nothing: where they looked, when, and what they would have seen."""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.errors import InputError, Problem, shown
from missionplan.mission import Mission
from missionplan.mission.geodesy import to_plane
from missionplan.mission.views import required_origin
from missionplan.moments import moment_of
from missionplan.results.overdue import AFLOAT, WAYS

MAX_BYTES = 20_000_000
"""Of a file of searches."""


@dataclass(frozen=True)
class Search:
    """An area that was searched without finding the vehicle."""

    polygons: tuple[tuple[Array, ...], ...]
    """Rings of each part, the outer one first, shape (2, k) [m]."""
    detection: float
    """Probability that a vehicle in it would have been found."""
    time: float
    """When, since the mission's start [s]."""
    way: str = AFLOAT
    """Of being lost in which it would have been found: a boat sees what floats, a sonar what lies on the seafloor."""

    def missed(self, places: Array) -> Array:
        """Probability that the search misses a vehicle at places of shape (2, n), shape (n,)."""
        inside = np.zeros(places.shape[1], dtype=bool)
        for rings in self.polygons:
            inside |= np.logical_xor.reduce([encloses(ring, places) for ring in rings])
        return np.where(inside, 1.0 - self.detection, 1.0)


def encloses(ring: Array, places: Array) -> NDArray[np.bool_]:
    """Whether a closed ring, shape (2, k), encloses places, shape (2, n): a line east of one crosses it oddly often."""
    odd = np.zeros(places.shape[1], dtype=bool)
    for (x1, y1), (x2, y2) in zip(ring.T, np.roll(ring, -1, axis=1).T, strict=True):
        if y1 != y2:
            between = (y1 > places[1]) != (y2 > places[1])
            odd ^= between & (places[0] < (x2 - x1) * (places[1] - y1) / (y2 - y1) + x1)
    return odd


def read_searches(path: Path, mission: Mission) -> tuple[Search, ...]:
    """Read GeoJSON polygons with the properties `probability_of_detection`, `time` and perhaps `way`, by their times.

    Raises
    ------
    InputError
        With every feature that is wrong, or when the mission lacks `start` or `site.origin`.
    """
    name = str(path)
    if mission.start is None:
        raise InputError([Problem("searches have dates: the mission needs its `start` (UTC)", name)])
    required_origin(mission, "searches are placed by it")
    try:
        if path.stat().st_size > MAX_BYTES:
            raise InputError([Problem(f"is larger than {MAX_BYTES // 1_000_000} MB", name)])
        document = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError([Problem(f"cannot be read: {error.strerror or error}", name)]) from None
    except (ValueError, RecursionError) as error:
        raise InputError([Problem(f"is no GeoJSON: {error}", name)]) from None
    features = _features(document, name)
    problems: list[Problem] = []
    found = []
    for number, feature in enumerate(features):
        try:
            found.append(_search(feature, mission))
        except (ValueError, TypeError, KeyError, OverflowError) as error:
            problems.append(Problem(str(error), name, key=f"features[{number}]"))
    if problems:
        raise InputError(problems)
    return tuple(sorted(found, key=lambda search: search.time))


def _features(document: object, name: str) -> Sequence[Mapping[str, Any]]:
    kind = document.get("type") if isinstance(document, dict) else None
    features = document.get("features") if kind == "FeatureCollection" and isinstance(document, dict) else None
    if kind == "Feature" and isinstance(document, dict):
        features = [document]
    if not isinstance(features, list) or not features or not all(isinstance(each, dict) for each in features):
        raise InputError([Problem("expected GeoJSON with one or more features", name)])
    return features


def _search(feature: Mapping[str, Any], mission: Mission) -> Search:
    properties = feature.get("properties") or {}
    detection, time = properties.get("probability_of_detection"), properties.get("time")
    if isinstance(detection, bool) or not isinstance(detection, int | float) or not 0.0 <= detection <= 1.0:
        raise ValueError(f"probability_of_detection: given {shown(detection)}, expected a number from 0 to 1")
    if time is None:
        raise ValueError("time: missing; expected a date and time such as 2026-06-01T14:30Z")
    try:
        moment = moment_of(time)
    except (ValueError, OverflowError) as error:
        raise ValueError(f"time: {error}") from None
    assert mission.start is not None
    polygons = tuple(_polygons(feature.get("geometry"), mission))
    way = properties.get("way", AFLOAT)
    if way not in WAYS:
        raise ValueError(f"way: given {shown(way)}, expected one of {', '.join(WAYS)}")
    return Search(polygons, float(detection), (moment - mission.start).total_seconds(), way)


def _polygons(geometry: object, mission: Mission) -> Iterator[tuple[Array, ...]]:
    kind = geometry.get("type") if isinstance(geometry, dict) else None
    if kind not in ("Polygon", "MultiPolygon") or not isinstance(geometry, dict):
        raise ValueError(f"geometry: given {shown(kind)}, expected a Polygon or a MultiPolygon")
    parts = geometry.get("coordinates")
    for part in [parts] if kind == "Polygon" else parts or ():
        yield tuple(_ring(ring, mission) for ring in part or ())


def _ring(ring: Any, mission: Mission) -> Array:
    points = np.array([[float(x) for x in point[:2]] for point in ring])
    if points.ndim != 2 or points.shape[0] < 3 or points.shape[1] != 2 or not np.isfinite(points).all():
        raise ValueError("geometry: a ring has three or more points of longitude and latitude")
    if np.abs(points[:, 1]).max() > 90.0 or np.abs(points[:, 0]).max() > 360.0:
        raise ValueError("geometry: expected longitudes and latitudes in degrees, in this order")
    origin = required_origin(mission, "searches are placed by it")
    longitude, latitude = np.radians(points).T
    beside = (longitude - origin.longitude + np.pi) % (2.0 * np.pi) - np.pi
    longitude = origin.longitude + beside
    return np.stack(to_plane(latitude, longitude, origin))
