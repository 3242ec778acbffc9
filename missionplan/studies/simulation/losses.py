"""Where and when trials are lost, for each way to fail and part of the mission; and searches that found nothing."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.errors import InputError, Problem, shown
from missionplan.mission import Mission
from missionplan.mission.documents import read_json
from missionplan.mission.schema.place import to_plane
from missionplan.mission.views import required_origin
from missionplan.moments import moment_of
from missionplan.results.entries import mapping
from missionplan.results.failures import Failure
from missionplan.results.whereabouts import AFLOAT, WAYS, Way
from missionplan.studies.simulation.phase_trials import Flags, PhaseTrials

FEWEST_FAILED = 20
"""Trials that failed in a way, from which its search area is taken; with fewer, others are assumed to fail so."""
_SINKING = (Failure.AGROUND, Failure.FLOODED_EARLY, f"{Failure.EQUIPMENT}, sunk", f"{Failure.EQUIPMENT}, lost")
_HELD = (Failure.NOT_SURFACED, f"{Failure.EQUIPMENT}, moored")


@dataclass(frozen=True)
class Losses:
    """Trials that were lost in one way, in one part of the mission."""

    way: Way
    after: str
    """Name of the mooring that they lie at, or after which they drift; empty where the way has no such part."""
    trials: NDArray[np.intp]
    """Of the block, shape (n,)."""
    position: Array
    """Where they were lost, shape (2, n) [m]."""
    clock: Array
    """When, shape (n,) [s]."""
    is_assumed: bool
    """Whether they are assumed to be lost so: too few trials were."""


def losses(
    phases: Sequence[PhaseTrials], failed_at: Mapping[tuple[str, str], Flags], generator: np.random.Generator
) -> list[Losses]:
    """Return the losses of each way, in the order of the mission.

    `phases`: transits and moorings, with the tracks of all trials. `failed_at`, shape (n,): trials that failed for
    good, by phase and reason. `generator`: of the moments at which trials are assumed to fail.
    """
    moorings = [number for number, phase in enumerate(phases) if phase.kind == "moor"]
    bounds = sorted({0, *moorings, len(phases)})
    parts = [phases[first:end] for first, end in pairwise(bounds)]  # up to the first mooring, then from each
    transits = [phase for phase in phases if phase.kind == "transit"]

    def failed(within: Sequence[PhaseTrials], counts: Callable[[str], bool]) -> Flags:
        names = {phase.name for phase in within}
        flags = [one for (name, why), one in failed_at.items() if name in names and counts(why)]
        return np.asarray(np.any(flags, axis=0))

    all_losses = []
    for mooring in (phases[number] for number in moorings):
        there = mooring.anchor, mooring.start
        all_losses += _lost("not released", mooring.name, there, (failed([mooring], lambda why: why in _HELD), *there))
    for part in parts:
        # from where those that failed so were last at a fix, else, after a mooring, from any fix
        after = part[0].name if part[0].kind == "moor" else ""
        assumed = None if not after and len(parts) > 1 else _at_random_fix(part, generator)
        flags = failed(part, lambda why: why not in (*_SINKING, *_HELD))
        all_losses += _lost("adrift at the surface", after, assumed, (flags, *_last_fix(part)))
    if transits:
        flags = failed(phases, lambda why: why in _SINKING)
        all_losses += _lost("on the seafloor", "", _on_the_way(transits, generator), (flags, *_last_fix(phases)))
        all_losses += _lost("still under way", "", _on_the_way(transits[-1:], generator), None)
    return all_losses


def _lost(
    way: Way, after: str, assumed: tuple[Array, Array] | None, failed: tuple[Flags, Array, Array] | None
) -> list[Losses]:
    """Those that failed so, where they are enough, else all that are assumed to, where they were at a known place."""
    for tried, is_assumed in ((failed, False), (None if assumed is None else (np.True_, *assumed), True)):
        if tried is not None:
            flags, place, clock = tried
            chosen = np.flatnonzero(flags & np.isfinite(clock) & np.isfinite(place).all(axis=0))
            if chosen.size >= FEWEST_FAILED:
                return [Losses(way, after, chosen, place[:, chosen], clock[chosen], is_assumed)]
    return []


def _last_fix(phases: Sequence[PhaseTrials]) -> tuple[Array, Array]:
    """Where and when each trial was last at a fix of these phases."""
    track, time = _tracks(phases)
    return _at_row(track, time, np.max(np.where(np.isfinite(time), np.arange(len(time))[:, None], -1), axis=0))


def _tracks(phases: Sequence[PhaseTrials]) -> tuple[Array, Array]:
    return np.concatenate([phase.track for phase in phases]), np.concatenate([phase.track_time for phase in phases])


def _at_random_fix(phases: Sequence[PhaseTrials], generator: np.random.Generator) -> tuple[Array, Array]:
    """A fix of each trial, at the surface, each as likely as any other."""
    track, time = _tracks(phases)
    if phases[0].kind == "moor":
        track, time = track[1:], time[1:]  # the anchor's touchdown is not at the surface
    return _at_row(track, time, _random_row(np.isfinite(time), generator))


def _on_the_way(phases: Sequence[PhaseTrials], generator: np.random.Generator) -> tuple[Array, Array]:
    """A place of each trial between two fixes of one transit, each leg as likely as any other."""
    track, time = _tracks(phases)
    dives = np.concatenate([np.arange(len(phase.track_time)) % 2 == 0 for phase in phases])  # and by turns surfacings
    row = _random_row(dives[:-1, None] & np.isfinite(time[:-1]) & np.isfinite(time[1:]), generator)
    share = generator.random(time.shape[1])
    (first, begun), (second, ended) = (
        _at_row(track, time, row),
        _at_row(track, time, np.minimum(row + 1, len(time) - 1)),
    )
    return first + share * (second - first), begun + share * (ended - begun)


def _random_row(possible: Flags, generator: np.random.Generator) -> NDArray[np.intp]:
    """A row of each trial where it is possible, -1 where none is."""
    keys = np.where(possible, generator.random(possible.shape), -1.0)
    return np.where(possible.any(axis=0), np.argmax(keys, axis=0), -1)


def _at_row(track: Array, time: Array, row: NDArray[np.intp]) -> tuple[Array, Array]:
    """Place and time of a row of each trial; no time where the row is -1."""
    numbers = np.arange(row.size)
    return track[row, :, numbers].T, np.where(row >= 0, time[row, numbers], np.nan)


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

    Raises InputError with every feature that is wrong, or when the mission lacks `start` or `site.origin`.
    """
    name = str(path)
    if mission.start is None:
        raise InputError([Problem("searches have dates: the mission needs its `start` (UTC)", name)])
    required_origin(mission, "searches are placed by it")
    features = _features(read_json(path, max_bytes=MAX_BYTES), name)
    problems: list[Problem] = []
    searches = []
    for number, feature in enumerate(features):
        try:
            searches.append(_search(feature, mission))
        except (ValueError, TypeError, KeyError, OverflowError) as error:
            problems.append(Problem(str(error), name, key=f"features[{number}]"))
    if problems:
        raise InputError(problems)
    return tuple(sorted(searches, key=lambda search: search.time))


def _features(document: object, name: str) -> Sequence[Mapping[str, Any]]:
    written = mapping(document)
    features = {"FeatureCollection": written.get("features"), "Feature": [written]}.get(str(written.get("type")))
    if not isinstance(features, list) or not features or not all(isinstance(feature, dict) for feature in features):
        raise InputError([Problem("expected GeoJSON with one or more features", name)])
    return features


def _search(feature: Mapping[str, Any], mission: Mission) -> Search:
    properties = mapping(feature.get("properties"))
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
    written: Mapping[str, Any] = mapping(geometry)
    kind, parts = written.get("type"), written.get("coordinates")
    if kind not in ("Polygon", "MultiPolygon"):
        raise ValueError(f"geometry: given {shown(kind)}, expected a Polygon or a MultiPolygon")
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
