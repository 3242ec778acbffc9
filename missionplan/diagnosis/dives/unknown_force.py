"""A force that nobody has named, on all dives alike: what would be read of it, by the descent phase itself.

A remainder may be smooth in the readings (a sensor's error) or in what moves the vehicle. The second differs from
dive to dive as weights do, and builds up: a force that comes late leaves its mark on what follows only.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.diagnosis.coordinates import Coordinate
from missionplan.diagnosis.dives.forward import DescentForward
from missionplan.diagnosis.inference.axes import Axis, AxisScale
from missionplan.phases.hooks import DescentEffect

PLACES = {"time": "Time since separation (s)", "speed": "Speed (m/s)", "depth": "Depth (m)"}
NODES = 17
"""Places along an axis at which the force is given."""
SHARE = 0.002
"""Step of the differences, of the drag or of the wet weight: more would shift the speeds by a good part of a hat."""
SLOW = 0.4
"""Slowest place of the axis, of the greatest speed: terminal speeds lie above it, and slower is on the way to them."""


@dataclass(frozen=True)
class UnknownForce(DescentEffect):
    """Drag or lift that is a hat function of time, speed or depth; every field a float or an array over trials.

    The hat is 1 at `centre` and falls to 0 over `width` to either side; beyond `ends`, the axis' own, it is level.
    """

    drag_in_time: Scalars = 0.0
    """Share of both bodies' drag, against the time since the line is taut [s]."""
    drag_at_speed: Scalars = 0.0
    """Share of both bodies' drag, against the speed through the water [m/s]."""
    lift_at_depth: Scalars = 0.0
    """Upward force [N] against the vehicle's depth [m]."""
    centre: Scalars = 0.0
    width: Scalars = 1.0
    ends: tuple[Scalars, Scalars] = (0.0, 1.0)

    def drag_factor(self, since_taut: Scalars, speed: Scalars) -> Scalars:
        """Return the factor on both bodies' drag."""
        return 1.0 + self.drag_in_time * self._hat(since_taut) + self.drag_at_speed * self._hat(speed)

    def lift(self, depth: Scalars) -> Scalars:
        """Return the upward force [N]."""
        return self.lift_at_depth * self._hat(depth)

    def _hat(self, at: Scalars) -> Array:
        return np.maximum(0.0, 1.0 - np.abs(np.clip(at, *self.ends) - self.centre) / self.width)


def force_axes(
    forward: DescentForward, coordinates: Sequence[Coordinate], at: Array, delays: Array, extents: dict[str, Array]
) -> list[Axis]:
    """Axes along which a force on all dives may be smooth.

    Parameters
    ----------
    forward : DescentForward
        The dives.
    coordinates : sequence of Coordinate, length k
        Of the model.
    at : array, shape (k,)
        Where it is fitted.
    delays : array, shape (d,)
        Lateness of each dive's separation [s].
    extents : mapping
        Values at the readings of ``time`` [s], ``speed`` [m/s] and ``depth`` [m], shape (N,).
    """
    ends = {name: (float(values.min()), float(values.max())) for name, values in extents.items()}
    ends["speed"] = (SLOW * ends["speed"][1], ends["speed"][1])
    weight = np.array([log.wet_weight for log in forward.logs])
    shares = np.full(len(weight), SHARE)
    kinds = [
        _Kind("time", "drag that changes with time", "drag_in_time", shares, "Time since the line is taut (s)"),
        _Kind("speed", "drag that changes with speed", "drag_at_speed", shares, PLACES["speed"]),
        _Kind("depth", "a lift that changes with depth", "lift_at_depth", shares * weight.mean(), PLACES["depth"]),
        # a train that sinks steadily has as much drag as weight
        _Kind("depth", "drag that changes with depth", "lift_at_depth", shares * weight, PLACES["depth"]),
    ]
    effect = _every(kinds, ends)
    settings = np.repeat(at[:, None], 1 + NODES * len(kinds), axis=1)
    with_it = replace(forward, given=(*forward.given, effect))
    readings = with_it.readings(coordinates, settings, np.broadcast_to(delays, (settings.shape[1], len(delays))))
    columns = np.split(readings[:, 1:] - readings[:, :1], len(kinds), axis=1)
    places = np.linspace(0.0, 1.0, NODES)[:, None]
    return [
        Axis(kind.name, kind.words, places, own, kind.measure(*ends[kind.name]))
        for kind, own in zip(kinds, columns, strict=True)
    ]


class _Kind(NamedTuple):
    """A kind of force: its axis, in words, the field of the effect, the step for each dive, and the axis' label."""

    name: str
    words: str
    field: str
    steps: Array
    place: str

    def measure(self, low: float, high: float) -> AxisScale:
        """Give drag in per cent, lift in newtons."""
        if self.words.startswith("drag"):
            return AxisScale(low, high, self.place, "Extra drag (%)", 100.0 * SHARE)
        return AxisScale(low, high, self.place, "Lift (N)", float(self.steps.mean()))


def _every(kinds: Sequence[_Kind], ends: dict[str, tuple[float, float]]) -> UnknownForce:
    """No force in the first setting of all dives; then each kind at each of its places, setting by setting."""
    dives = len(kinds[0].steps)

    def strength(field: str) -> Array:
        blocks = [np.tile(kind.steps if kind.field == field else np.zeros(dives), (NODES, 1)) for kind in kinds]
        return np.concatenate([np.zeros((1, dives)), *blocks]).ravel()

    places = [np.linspace(*ends[kind.name], NODES) for kind in kinds]
    low, high, centre = (
        np.repeat(np.concatenate([[first], *values]), dives)
        for first, values in (
            (0.0, [np.full(NODES, place[0]) for place in places]),
            (1.0, [np.full(NODES, place[-1]) for place in places]),
            (0.0, places),
        )
    )
    return UnknownForce(
        drag_in_time=strength("drag_in_time"),
        drag_at_speed=strength("drag_at_speed"),
        lift_at_depth=strength("lift_at_depth"),
        centre=centre,
        width=np.maximum((high - low) / (NODES - 1), 1e-9),
        ends=(low, high),
    )
