"""Predictions of the same values without the mission: by the past in several ways, or by a plain wider σ.

Each predicts from the groups before; its spread is that of its own errors so far. Values are taken as a rate (a leg's
error over its time under way) or as a curve (a dive's departure from the bare mission, at the same times).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from missionplan.arrays import Array

GAINS = np.array([0.05, 0.1, 0.2, 0.3, 0.45, 0.6, 0.8, 1.0])
"""Gains of the random walk seen through noise: what of the last error is taken over."""
MEMORIES = (0.5, 0.8, 0.95)
"""What a stationary persistent error keeps of itself from one group to the next."""

Past = Callable[[int, int], Array]
"""The values of an earlier group as a prediction of those of a later one: of (later, earlier)."""


@dataclass(frozen=True)
class Point:
    """Predictions of all values, with the standard deviation of each."""

    mean: Array
    sd: Array


def yardsticks(values: Sequence[Array], past: Past, scales: Sequence[Array], first_sd: float) -> dict[str, Point]:
    """Predict every group from those before it, or by the size of their errors alone.

    Parameters
    ----------
    values : sequence of array
        Of each group, as departures from what is expected without effects.
    past : callable
        The values of an earlier group, carried over to the times of a later one.
    scales : sequence of array
        Of the values of each group: an error over its scale has the same spread in all groups (a leg's time under way).
    first_sd : float
        Spread of an error over its scale before any is seen; it counts as one.
    """
    count = len(values)
    carried = [[past(later, earlier) for earlier in range(later)] for later in range(count)]

    def mean_of_past(group: int) -> Array:
        return np.asarray(np.mean(carried[group], axis=0)) if group else np.zeros_like(values[0])

    def last(group: int) -> Array:
        return carried[group][-1] if group else np.zeros_like(values[0])

    by_gain = [
        _with_spread(
            values, [_smoothed(each, gain, own) for each, own in zip(carried, values, strict=True)], scales, first_sd
        )
        for gain in GAINS.tolist()
    ]
    pairs = list(zip(carried, values, strict=True))
    by_memory = [
        _with_spread(values, [_remembered(each, gain, kept, own) for each, own in pairs], scales, first_sd)
        for gain in GAINS[1::2].tolist()
        for kept in MEMORIES
    ]
    found = {
        "mean_of_past": _with_spread(values, [mean_of_past(group) for group in range(count)], scales, first_sd),
        "last_leg": _with_spread(values, [last(group) for group in range(count)], scales, first_sd),
        "random_walk": _best_so_far(values, by_gain),
        "persistent": _best_so_far(values, by_memory),
        "wider_sigma": _with_spread(values, [np.zeros_like(value) for value in values], scales, first_sd),
    }
    return {name: _joined(points) for name, points in found.items()}


def with_spread(values: Sequence[Array], means: Sequence[Array], scales: Sequence[Array], first_sd: float) -> Point:
    """Add to predictions of every group the spread of their errors before it; as in `yardsticks`."""
    return _joined(_with_spread(values, means, scales, first_sd))


def _joined(points: Sequence[Point]) -> Point:
    return Point(np.concatenate([p.mean for p in points]), np.concatenate([p.sd for p in points]))


def _smoothed(past: Sequence[Array], gain: float, like: Array) -> Array:
    """Exponentially weighted mean of the past: the prediction of a random walk seen through noise (Muth 1960)."""
    if not past:
        return np.zeros_like(like)
    weights = gain * (1.0 - gain) ** np.arange(len(past) - 1, -1, -1.0)
    weights[0] += max(1.0 - weights.sum(), 0.0)
    return np.asarray(np.tensordot(weights / weights.sum(), np.array(past), axes=1))


def _remembered(past: Sequence[Array], gain: float, kept: float, like: Array) -> Array:
    """Prediction of a stationary persistent error seen through noise, which forgets: the steady Kalman filter's."""
    if not past:
        return np.zeros_like(like)
    weights = kept * gain * (kept * (1.0 - gain)) ** np.arange(len(past) - 1, -1, -1.0)
    return np.asarray(np.tensordot(weights, np.array(past), axes=1))


def _with_spread(
    values: Sequence[Array], means: Sequence[Array], scales: Sequence[Array], first_sd: float
) -> list[Point]:
    """Add the spread of the errors before each group."""
    total, count, found = first_sd**2, 1, []
    for value, mean, scale in zip(values, means, scales, strict=True):
        found.append(Point(mean, scale * np.sqrt(total / count)))
        if len(found) > 1:  # the first has no past: its error is not that of the method
            total, count = total + float(np.sum(((value - mean) / scale) ** 2)), count + value.size
        if len(found) == 2:
            total, count = total - first_sd**2, count - 1
    return found


def _best_so_far(values: Sequence[Array], by_gain: Sequence[list[Point]]) -> list[Point]:
    """For each group the gain that has predicted those before it best."""
    scores, found = np.zeros(len(by_gain)), []
    for group, value in enumerate(values):
        found.append(by_gain[int(np.argmax(scores))][group])
        for index, points in enumerate(by_gain):
            scores[index] += float(np.sum(log_density(value, points[group])))
    return found


def log_density(value: Array, point: Point) -> Array:
    """Ln density of normal predictions at what was measured."""
    sd = np.maximum(point.sd, 1e-9)
    return np.asarray(-0.5 * ((value - point.mean) / sd) ** 2 - np.log(sd) - 0.5 * np.log(2.0 * np.pi))
