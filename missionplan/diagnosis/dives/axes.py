"""Axes along which a dive log's remainder may be smooth."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from missionplan.arrays import Array
from missionplan.diagnosis.dives.linearised import DiveLinearisation, LinearisedDescent
from missionplan.diagnosis.dives.preparation import DiveLog
from missionplan.diagnosis.dives.unknown_force import PLACES, force_axes
from missionplan.diagnosis.inference.axes import Axis, AxisScale, pointwise, scaled


def descent_axes(model: LinearisedDescent, linear: DiveLinearisation) -> list[Axis]:
    """Errors of the depth, forces on all dives, and what differs from dive to dive.

    Parameters
    ----------
    model : LinearisedDescent
        The dives.
    linear : DiveLinearisation
        Where the model is fitted.
    """
    logs, readings = model.forward.logs, linear.readings
    speed = np.concatenate([_speed(log, readings[rows]) for log, rows in zip(logs, model.parts, strict=True)])
    extents = {"time": np.concatenate([log.t for log in logs]), "depth": readings, "speed": speed}
    shared = [_error(name, values) for name, values in extents.items()]
    forces = force_axes(model.forward.coarse, model.coordinates, linear.at, linear.release_delays, extents)
    return [*shared, *forces, *_dive_by_dive(logs, extents["time"], linear.sensitivity("drag"))]


def _error(name: str, values: Array) -> Axis:
    """Error of the depth read that changes with what is named, the same in all dives."""
    axis = pointwise(name, f"an error of the depth read that changes with {name}", scaled(values))
    measure = AxisScale(float(values.min()), float(values.max()), PLACES[name], "Error of the depth read (m)")
    return replace(axis, measure=measure)


def _dive_by_dive(logs: Sequence[DiveLog], t: Array, drag: Array) -> list[Axis]:
    """Each dive's own error of the depth against time; drag that changes from dive to dive in order, with the line.

    Parameters
    ----------
    logs : sequence of DiveLog
        The dives.
    t, drag : array, shape (N,)
        Times of all readings [s] and their sensitivity to drag [m].
    """
    dive = np.repeat(np.arange(len(logs)), [len(log.t) for log in logs])
    axes = []
    if len(logs) > 1:
        own = (dive[:, None] == np.arange(len(logs))[None, :]).astype(float)
        axes.append(pointwise("run", "an error of the depth read that changes with time, dive by dive", scaled(t), own))
    if len(logs) > 2:
        axes.append(_slope("drag that grows or falls from dive to dive", drag, dive.astype(float)))
    lines = np.array([log.line_length for log in logs])[dive]
    if np.ptp(lines) > 0.0:
        axes.append(_slope("drag that changes with the line's length", drag, lines))
    return axes


def _slope(words: str, drag: Array, values: Array) -> Axis:
    """Drag that grows in proportion to what the dives differ in, shape (N,), about its mean."""
    return Axis("run", words, np.zeros((1, 1)), (drag * (values - values.mean()))[:, None])


def _speed(log: DiveLog, depth: Array) -> Array:
    return np.asarray(np.gradient(depth, log.t) if np.all(np.diff(log.t) > 0.0) else np.zeros_like(depth))
