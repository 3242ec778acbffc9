"""Axes along which a dive log's remainder may be smooth."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from missionplan.diagnose.descent_data import DiveLog
from missionplan.diagnose.residuals import Axis

Array = NDArray[np.float64]


def descent_axes(logs: Sequence[DiveLog], expected: Array, drag: Array) -> dict[str, Axis]:
    """Time, depth and speed, each a function that all dives share; time dive by dive; drag that grows with the dives.

    Parameters
    ----------
    logs : sequence of DiveLog
        The dives.
    expected : array, shape (N,)
        Depths that the model expects, dive after dive [m].
    drag : array, shape (N,)
        Their sensitivity to drag [m].
    """
    t = np.concatenate([log.t for log in logs])
    dive = np.repeat(np.arange(len(logs)), [len(log.t) for log in logs])
    speed = np.concatenate([_speed(log.t, expected[dive == k]) for k, log in enumerate(logs)])
    shared = np.ones((len(t), 1))
    own = (dive[:, None] == np.arange(len(logs))[None, :]).astype(float)
    axes = {
        "time": Axis("time", _unit(t), shared),
        "depth": Axis("depth", _unit(expected), shared),
        "speed": Axis("speed", _unit(speed), shared),
    }
    if len(logs) > 1:
        axes["run"] = Axis("run", _unit(t), own)
    if len(logs) > 2:
        trend = drag * (2.0 * _unit(dive.astype(float)) - 1.0)[:, 0]
        axes["trend"] = Axis("run", np.zeros((len(t), 1)), trend[:, None] / np.abs(trend).max())
    return axes


def _speed(t: Array, depth: Array) -> Array:
    return np.asarray(np.gradient(depth, t) if np.all(np.diff(t) > 0.0) else np.zeros_like(depth))


def _unit(values: Array) -> Array:
    return np.asarray((values - values.min()) / max(float(np.ptp(values)), 1e-9))[:, None]
