"""The points of a trial's track: what happened there, and when."""

import math
from dataclasses import dataclass
from datetime import timedelta

from missionplan.report.geography.plan_view import median_trial
from missionplan.results.plan import PlannedMooring, PlannedTransit
from missionplan.results.simulation import Outcome

SAMPLES = 50
"""Number of sample tracks written."""
_MOORED = ("anchor", "surfacing", "fix")


@dataclass(frozen=True)
class TrackPoint:
    """A point of a track.

    Attributes
    ----------
    name : str
        Such as ``ingress: surfacing 2``.
    kind : str
        ``start``, ``surfacing`` (with the fix on surfacing), ``fix`` (on diving), ``anchor`` or ``hover``.
    phase : str
    position : (float, float)
        True position, east and north [m].
    time : float
        Since the mission's start [s].
    utc : str
        The same as ISO 8601; empty where the mission has no start.
    depth : float or None
        Run depth of the leg that ended here, or of the water for an anchor [m].
    """

    name: str
    kind: str
    phase: str
    position: tuple[float, float]
    time: float
    utc: str
    depth: float | None

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
    tracks, found = outcome.tracks, []
    names, kinds = list(tracks.targets), {phase.name: phase.kind for phase in outcome.phases}
    number = dict.fromkeys(range(len(names)), -1)
    for place, time, index in zip(
        tracks.position[:, :, trial].tolist(), tracks.time[:, trial].tolist(), tracks.phase.tolist(), strict=True
    ):
        number[index] += 1
        if not all(map(math.isfinite, (*place, time))):
            continue
        phase = names[index]
        kind, ordinal = _kind(kinds.get(phase, "transit"), number[index])
        name = f"{phase}: {kind}{f' {ordinal}' if ordinal else ''}"
        position = (place[0], place[1])
        found.append(TrackPoint(name, kind, phase, position, time, _utc(outcome, time), _depth(outcome, phase)))
    return found


def _kind(phase: str, number: int) -> tuple[str, int]:
    """Kind of the point of that number, from 0, of a phase of that kind, and its own number."""
    if phase == "moor":
        return _MOORED[number], 0
    if phase != "transit":
        return "hover", 0
    if number == 0:
        return "start", 0
    return ("surfacing" if number % 2 else "fix"), (number + 1) // 2


def _depth(outcome: Outcome, phase: str) -> float | None:
    plan = outcome.plan
    depths = {each.name: _planned_depth(each) for each in plan.phases} if plan else {}
    label = next((each.label for each in outcome.phases if each.name == phase), phase)
    depth = depths.get(label, math.nan)
    return round(depth, 3) if math.isfinite(depth) else None


def _planned_depth(planned: PlannedTransit | PlannedMooring) -> float:
    return planned.water_depth if isinstance(planned, PlannedMooring) else planned.depth


def _utc(outcome: Outcome, time: float) -> str:
    start = outcome.plan.start if outcome.plan else None
    return (start + timedelta(seconds=round(time, 1))).strftime("%Y-%m-%dT%H:%M:%SZ") if start else ""
