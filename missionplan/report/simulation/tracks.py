"""Tracks, fixes, circles of error and the plan as GeoJSON (RFC 7946) and KML 2.2 (OGC 07-147r2)."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import timedelta
from itertools import chain

import numpy as np

from missionplan.errors import counted
from missionplan.exporters.geojson import (
    Feature,
    Origin,
    area_feature,
    collection,
    feature,
    line_feature,
    longitudes_latitudes,
    parts,
)
from missionplan.exporters.kml import kml, plan_folders, properties_of
from missionplan.exporters.table import known
from missionplan.report.plan_view import describe, median_trial, rings
from missionplan.results.plan import PlannedMooring
from missionplan.results.simulation import Outcome

SAMPLES = 50
"""Number of sample tracks written."""
_MOORED = ("anchor", "surfacing", "fix")


@dataclass(frozen=True)
class TrackPoint:
    """A point of a track."""

    name: str
    """Such as ``ingress: surfacing 2``."""
    kind: str
    """``start``, ``surfacing`` (with the fix on surfacing), ``fix`` (on diving), ``anchor`` or ``hover``."""
    phase: str
    position: tuple[float, float]
    """True position, east and north [m]."""
    time: float
    """Since the mission's start [s]."""
    utc: str
    """The same as ISO 8601; empty where the mission has no start."""
    depth: float | None
    """Run depth of the leg that ended here, or of the water for an anchor [m]."""

    def data(self) -> dict[str, object]:
        """Return what viewers show of it; None where not known."""
        return {
            "phase": self.phase,
            "elapsed_s": round(self.time, 1),
            "time": self.utc or None,
            "depth_m": self.depth if self.kind in ("surfacing", "anchor") else None,
        }


def sample_trials(outcome: Outcome) -> tuple[int, list[int]]:
    """Choose the median trial, and others that show the spread."""
    median = median_trial(outcome.tracks)
    trials = range(outcome.tracks.position.shape[2])
    return median, [trial for trial in trials if trial != median][:SAMPLES]


def track_points(outcome: Outcome, trial: int) -> list[TrackPoint]:
    """Return the points that a trial has, in the order of time."""
    tracks, points = outcome.tracks, []
    names, kinds = list(tracks.targets), {phase.name: phase.kind for phase in outcome.phases}
    number = dict.fromkeys(range(len(names)), -1)
    for place, time, index in zip(
        tracks.position[:, :, trial].tolist(), tracks.time[:, trial].tolist(), tracks.phase.tolist(), strict=True
    ):
        number[index] += 1
        if not all(map(math.isfinite, (*place, time))):
            continue
        kind, ordinal = _kind(kinds.get(names[index], "transit"), number[index])
        phase = _label(outcome, names[index])
        name = f"{phase}: {kind}{f' {ordinal}' if ordinal else ''}"
        position = (place[0], place[1])
        points.append(TrackPoint(name, kind, phase, position, time, _utc(outcome, time), _depth(outcome, phase)))
    return points


def _kind(phase: str, number: int) -> tuple[str, int]:
    """Kind of the point of that number, from 0, of a phase of that kind, and its own number."""
    if phase == "moor":
        return _MOORED[number], 0
    if phase != "transit":
        return "hover", 0
    if number == 0:
        return "start", 0
    return ("surfacing" if number % 2 else "fix"), (number + 1) // 2


def _label(outcome: Outcome, phase: str) -> str:
    """What the mission calls a phase, of which key paths may only have the place."""
    return next((candidate.label for candidate in outcome.phases if candidate.name == phase), phase)


def _depth(outcome: Outcome, label: str) -> float | None:
    for planned in outcome.plan.phases if outcome.plan else ():
        if planned.name == label:
            return known(planned.water_depth if isinstance(planned, PlannedMooring) else planned.depth, 3)
    return None


def _utc(outcome: Outcome, time: float) -> str:
    start = outcome.plan.start if outcome.plan else None
    return (start + timedelta(seconds=round(time, 1))).strftime("%Y-%m-%dT%H:%M:%SZ") if start else ""


def track_geojson(outcome: Outcome) -> str | None:
    """Write the planned, median and sample tracks, fixes, goals, arrival circles, CEP and mooring ellipses.

    Returns None when the mission has no origin. Times are seconds since the mission's start, and UTC where the mission
    has a start.
    """
    folders = _folders(outcome)
    if folders is None:
        return None
    says = {"mission_sha256": outcome.plan.digest} if outcome.plan else {}
    return collection(outcome.provenance.mission, chain(*folders.values()), **says)


def track_kml(outcome: Outcome) -> str | None:
    """Write the same as KML, clamped to the surface; None when the mission has no origin."""
    folders = _folders(outcome)
    if folders is None:
        return None
    of_plan = f", SHA-256 of the mission {outcome.plan.digest}" if outcome.plan else ""
    run = f"missionplan, seed {outcome.provenance.seed}, {counted(outcome.provenance.trials, 'trial')}{of_plan}"
    return kml(outcome.provenance.mission, run, folders)


def _folders(outcome: Outcome) -> dict[str, list[Feature]] | None:
    """Return all that is shown, by folders: the plan, tracks, fixes of the median trial, and about every goal."""
    origin = outcome.tracks.origin
    if origin is None:
        return None
    median, _ = sample_trials(outcome)
    folders = plan_folders(outcome.plan, circles=False) if outcome.plan else {}
    folders["Tracks"] = list(_track_features(outcome, origin))
    fixes = folders[f"Fixes, trial {median}"] = []  # where it is at each fix, and its anchor
    for point in track_points(outcome, median):
        (place,) = longitudes_latitudes(np.array(point.position)[:, None], origin)
        data = {key: value for key, value in point.data().items() if value is not None}
        fixes.append(feature("Point", place, point.kind, name=point.name, trial=median, **data))
    about = []
    for ring in rings(outcome):
        share = None if math.isnan(ring.share) else ring.share
        properties = {"name": describe(ring), "phase": _label(outcome, ring.phase), "share": share}
        boundary = longitudes_latitudes(ring.line, origin)
        about.append(area_feature(boundary, ring.kind, **properties, radius_m=round(ring.radius, 3)))
    for name, (goal, _) in outcome.tracks.targets.items():
        (place,) = longitudes_latitudes(np.array(goal)[:, None], origin)
        label = _label(outcome, name)
        about.append(feature("Point", place, "goal", name=f"{label}: goal", phase=label))
    for shape in about:
        folders.setdefault(str(properties_of(shape)["phase"]), []).append(shape)
    return folders


def _track_features(outcome: Outcome, origin: Origin) -> Iterator[Feature]:
    median, samples = sample_trials(outcome)
    for trial, kind in [*((trial, "sample track") for trial in samples), (median, "median track")]:
        points = track_points(outcome, trial)
        if len(points) > 1:
            line = longitudes_latitudes(np.array([point.position for point in points]).T, origin)
            utc = [point.utc for point in points]
            times: dict[str, object] = {}
            if len(parts(line)) == 1:  # a cut line has points of no known time
                times = {"elapsed_s": [round(point.time, 1) for point in points]}
                times |= {"coordTimes": utc} if all(utc) else {}  # what viewers of GeoJSON read
            yield line_feature(line, kind, name=f"{kind}, trial {trial}", trial=trial, **times)
