"""Further dives that may discriminate between two causes."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from missionplan.arrays import Array
from missionplan.datasets.records import TOUCHDOWN_MARGIN
from missionplan.diagnosis.dives.forward import DescentForward
from missionplan.diagnosis.dives.preparation import MAX_SAMPLES, MIN_NOISE, MOVING_DEPTH, DiveLog

DESIGNS = (
    ("two dives with 0.4 times the anchor's weight", 0.4, 1.0, 1.0),
    ("two dives with a line three times as long", 1.0, 3.0, 1.0),
    ("two dives twice as deep", 1.0, 1.0, 2.0),
)
"""In words; factors on wet weight, line length and site depth. Cheapest first."""
LONGEST_DIVE = 120.0
"""Time of a proposed dive that is logged at most [s]."""


def design_dives(forward: DescentForward, entry: int | None) -> tuple[DiveLog, ...]:
    """Return two dives of a design: the first two of the data but for the factors. Depths are zero.

    Parameters
    ----------
    forward : DescentForward
        The dives so far.
    entry : int or None
        Of `DESIGNS`; None for the same dives again.
    """
    _, weight, line, depth = DESIGNS[entry] if entry is not None else ("", 1.0, 1.0, 1.0)
    logs = []
    for log in forward.logs[:2]:
        site = log.site_depth * depth + (line - 1.0) * log.line_length
        logs.append(
            replace(log, wet_weight=log.wet_weight * weight, line_length=log.line_length * line, site_depth=site)
        )
    return sampled_dives(forward, logs)


def sampled_dives(forward: DescentForward, logs: Sequence[DiveLog]) -> tuple[DiveLog, ...]:
    """Return dives sampled evenly until the base model nears touchdown; their depths are zero.

    The logs give the dives' anchors, lines and depths, and readings as noisy as theirs.
    """
    return tuple(
        _sampled(log, np.linspace(0.0, _near_touchdown(log, *run), MAX_SAMPLES))
        for log, run in _base_runs(forward, logs)
    )


def stretched_dives(forward: DescentForward, logs: Sequence[DiveLog]) -> tuple[DiveLog, ...]:
    """Return dives read as often as those of given logs, from the first motion until the base model nears touchdown.

    As many bins of readings as those logs have, so that each holds more of them, or fewer. Their depths are zero.

    `logs` have the anchors, lines and depths of the dives to come, and the times and readings of others.
    """
    return tuple(_stretched(log, *run) for log, run in _base_runs(forward, logs))


def _stretched(log: DiveLog, times: Array, depth: Array) -> DiveLog:
    begin, end = float(times[np.argmax(depth > MOVING_DEPTH)]), _near_touchdown(log, times, depth)
    factor = (end - begin) / float(log.t[-1] - log.t[0])
    t, fine = (begin + factor * (instants - log.t[0]) for instants in (log.t, log.fine))
    sd = np.maximum(log.sd / np.sqrt(factor), MIN_NOISE)
    return replace(log, t=t, depth=0.0 * t, sd=sd, fine=fine)


def _base_runs(forward: DescentForward, logs: Sequence[DiveLog]) -> list[tuple[DiveLog, tuple[Array, Array]]]:
    """Logs, each with times [s] and depths [m] of the dive by the base model."""
    times = np.linspace(0.0, LONGEST_DIVE, 600)
    long = replace(forward, logs=tuple(_sampled(log, times) for log in logs))
    depths = long.readings((), np.zeros((0, 1)))[:, 0].reshape(len(logs), -1)
    return [(log, (times, depth)) for log, depth in zip(logs, depths, strict=True)]


def _sampled(log: DiveLog, t: Array) -> DiveLog:
    """The same dive with single readings at other times."""
    sd = np.full(len(t), float(np.median(log.sd)))
    return replace(log, t=t, depth=0.0 * t, sd=sd, fine=t, bins=np.arange(len(t)), shares=np.ones(len(t)))


def _near_touchdown(log: DiveLog, times: Array, depth: Array) -> float:
    """When the base model nears touchdown [s]."""
    near = np.flatnonzero(depth > (1.0 - TOUCHDOWN_MARGIN) * (log.site_depth - log.line_length))
    return float(times[near[0]]) if len(near) else LONGEST_DIVE


def with_depths(logs: tuple[DiveLog, ...], readings: Array) -> tuple[DiveLog, ...]:
    """Return the logs with other readings, given dive after dive."""
    parts = np.split(readings, np.cumsum([len(log.t) for log in logs])[:-1])
    return tuple(replace(log, depth=part) for log, part in zip(logs, parts, strict=True))
