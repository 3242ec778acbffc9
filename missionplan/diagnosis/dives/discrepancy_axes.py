"""Axes along which the discrepancy of dive logs may be smooth: errors of the readings, and unknown forces.

A discrepancy may be smooth in the readings (an error of the sensor) or in a force on the vehicle. An unknown force
differs from dive to dive as weights do, and its effect builds up: a late force changes later readings only. Its
response is a simulation by the descent phase itself (a latent force model; Alvarez, Luengo & Lawrence 2009).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array, Scalars
from missionplan.diagnosis.coordinates import Coordinate
from missionplan.diagnosis.dives.forward import DescentForward
from missionplan.diagnosis.dives.linearised import DiveLinearisation, LinearisedDescent
from missionplan.diagnosis.dives.preparation import DiveLog
from missionplan.diagnosis.inference.axes import Axis, AxisScale, differing, directed, pointwise, scaled
from missionplan.phases.hooks import DescentEffect

AXIS_LABELS = {"time": "Time since the line is taut (s)", "speed": "Speed (m/s)", "depth": "Depth (m)"}
DRAG_BY_DEPTH = "drag that changes with depth"
DRAG_OF_SOME = "drag that is otherwise in one dive or some"
NODES = 17
"""Nodes of the hat basis of a force along an axis."""
READING, DRAG, LIFT, DELAY = 0.3, 0.3, 1.5, 0.5
"""Usual sizes of errors of a reading [m], of shares of the drag, of lifts [N] and delays [s]: those of the effects."""
WEIGHT = 0.15
"""Usual error of an anchor's wet weight in the log book, of itself."""
SOON = 1.0
"""Time in which a vehicle goes about its length: what the taut line sets off fades on a logarithm of its age [s]."""
FORCE_STEP = 0.002
"""Step of the differences, of the drag or of the wet weight: more would shift the speeds by a good part of a hat."""
MIN_SPEED_SHARE = 0.4
"""Lowest speed of the axis, of the greatest: terminal speeds lie above it, and the dive passes through lower ones."""


def descent_axes(model: LinearisedDescent, linear: DiveLinearisation) -> list[Axis]:
    """Errors of the depth, forces on all dives, and differences from dive to dive."""
    logs, readings = model.forward.logs, linear.readings
    depths = [readings[rows] for rows in model.parts]
    speed = np.concatenate([np.gradient(depth, log.t) for log, depth in zip(logs, depths, strict=True)])
    since_taut = np.concatenate([log.t - log.t[0] for log in logs])  # which is when the vehicle begins to move
    extents = {"time": since_taut, "depth": readings, "speed": speed}
    shared = [_reading_error(name, values) for name, values in extents.items()]
    forces = force_axes(model.forward.coarse, model.coordinates, linear.at, linear.release_delays, extents)
    # each dive's own of a common error of the depth, and delay; a force or a reading with a trend over dives
    dive = np.repeat(np.arange(len(logs)), [len(log.t) for log in logs])
    weight, drag = linear.sensitivity("weight"), linear.sensitivity("drag")
    axes = []
    if len(logs) > 1:
        eye = np.eye(len(logs))[dive]  # 1 where a reading is of a dive
        axes.append(_otherwise_in_each(shared[0], eye))
        delays = eye * linear.sensitivity("release")[:, None]
        axes.append(replace(differing("a delay that differs from dive to dive", delays), size=DELAY, in_some_runs=True))
    if len(logs) > 2:
        axes.append(_wrong_anchor(logs, eye, weight))
        axes.append(replace(differing(DRAG_OF_SOME, eye * drag[:, None]), size=DRAG, in_some_runs=True))
        lift = -weight / np.array([log.wet_weight for log in logs])[dive]
        axes.append(_trend("drag", drag, dive, DRAG, ("Extra drag (%)", 100.0)))
        axes.append(_trend("a lift", lift, dive, LIFT, ("Lift (N)", 1.0)))
        axes.append(_trend("an error of the depth read", eye.sum(axis=1), dive, READING, ("Error (m)", 1.0)))
    return [*shared, *forces, *axes]


def _reading_error(name: str, values: Array) -> Axis:
    """Error of the depth reading along an axis, of time by its logarithm, the same in all dives."""
    unit = SOON if name == "time" else None
    places = values if unit is None else np.log1p(values / unit)
    axis = pointwise(name, f"an error of the depth read that changes with {name}", scaled(places))
    words = AXIS_LABELS[name], "Error of the depth read (m)"
    scale = AxisScale(float(places.min()), float(places.max()), *words, unit=unit)
    return replace(axis, scale=scale, size=READING)


def drag_of_each_dive(logs: Sequence[DiveLog], axes: Sequence[Axis]) -> list[Axis]:
    """Drag that changes with depth in each of several dives otherwise, from that in all of them among some axes."""
    common = next(axis for axis in axes if axis.description == DRAG_BY_DEPTH)
    eye = np.repeat(np.eye(len(logs)), [len(log.t) for log in logs], axis=0)
    return [_otherwise_in_each(common, eye)] if len(logs) > 1 else []


def _otherwise_in_each(common: Axis, eye: Array) -> Axis:
    words = f"{common.description}, dive by dive"
    return Axis("run", words, common.places, directed(common.response, eye), size=common.size)


def _wrong_anchor(logs: Sequence[DiveLog], eye: Array, weight: Array) -> Axis:
    """An anchor that weighs otherwise than the log book has it, in one dive or in all dives with its label.

    `eye`, shape (N, d), is 1 where a reading is of a dive, `weight`, shape (N,), the sensitivity of the readings to the
    anchor's weight, of itself [m].
    """
    written = np.array([log.wet_weight for log in logs])
    labels = [np.flatnonzero(written == label) for label in np.unique(written)]
    several = [eye[:, dives].sum(axis=1) for dives in labels if 1 < len(dives) < len(logs)]
    columns = np.column_stack([eye, *several]) * weight[:, None]
    words = "an anchor that weighs otherwise than the log book says, in a dive or in all with its label"
    return replace(differing(words, columns), size=WEIGHT, in_some_runs=True)


def _trend(what: str, response: Array, dive: NDArray[np.int_], size: float, shown: tuple[str, float]) -> Axis:
    """A force or a reading that goes from one size in the first dive to another in the last, neither of them known.

    A trend without a level of its own would leave its mean to a cause.
    """
    ends, last = np.array([[0.0], [1.0]]), int(dive.max())
    columns = response[:, None] * np.column_stack([1.0 - dive / last, dive / last])
    scale = AxisScale(1.0, last + 1.0, "Dive", *shown)
    return Axis("run", f"{what} that grows or falls from dive to dive", ends, columns, scale, size)


@dataclass(frozen=True)
class UnknownForce(DescentEffect):
    """Drag or lift that is a hat function of time, speed or depth; every field a float or an array over trials.

    The hat is 1 at `centre` and falls to 0 over `width` to either side; beyond the axis' `ends` it is constant.
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
    forward: DescentForward,
    coordinates: Sequence[Coordinate],
    at: Array,
    delays: Array,
    extents: Mapping[str, Array],
) -> list[Axis]:
    """Axes along which a force on all dives may be smooth.

    `at`, (k,): where the model is fitted, in its coordinates. `delays`, (d,): release delay of each dive [s].
    `extents`: values at the readings of ``time`` [s], ``speed`` [m/s] and ``depth`` [m], shape (N,).
    """
    ends = {name: (float(values.min()), float(values.max())) for name, values in extents.items()}
    ends["speed"] = (MIN_SPEED_SHARE * ends["speed"][1], ends["speed"][1])
    # kinds of force on dives with given wet weights, shape (d,) [N]
    weight = np.array([log.wet_weight for log in forward.logs])
    shares = np.full(len(weight), FORCE_STEP)
    kinds = [
        _ForceKind("time", "drag that changes with time", "drag_in_time", shares, AXIS_LABELS["time"]),
        _ForceKind("speed", "drag that changes with speed", "drag_at_speed", shares, AXIS_LABELS["speed"]),
        _ForceKind(
            "depth", "a lift that changes with depth", "lift_at_depth", shares * weight.mean(), AXIS_LABELS["depth"]
        ),
        # bodies that sink steadily have as much drag as weight
        _ForceKind("depth", DRAG_BY_DEPTH, "lift_at_depth", shares * weight, AXIS_LABELS["depth"]),
    ]
    settings = np.repeat(at[:, None], 1 + NODES * len(kinds), axis=1)
    forced = replace(forward, given=(*forward.given, _all_forces(kinds, ends)))
    readings = forced.readings(coordinates, settings, np.broadcast_to(delays, (settings.shape[1], len(delays))))
    columns = np.split(readings[:, 1:] - readings[:, :1], len(kinds), axis=1)
    nodes = np.linspace(0.0, 1.0, NODES)[:, None]
    return [
        Axis(kind.name, kind.words, nodes, response, kind.scale(*ends[kind.name]), kind.size)
        for kind, response in zip(kinds, columns, strict=True)
    ]


class _ForceKind(NamedTuple):
    """A kind of force: its axis, in words, the field of the effect, the step for each dive, and the axis' label."""

    name: str
    words: str
    field: str
    steps: Array
    place: str

    @property
    def size(self) -> float:
        """Usual size in steps."""
        return LIFT / float(self.steps.mean()) if self.words.startswith("a lift") else DRAG / FORCE_STEP

    def scale(self, low: float, high: float) -> AxisScale:
        """Return labels and scale for a figure: drag in per cent, lift in newtons."""
        if self.words.startswith("drag"):
            return AxisScale(low, high, self.place, "Extra drag (%)", 100.0 * FORCE_STEP)
        return AxisScale(low, high, self.place, "Lift (N)", float(self.steps.mean()))


def _all_forces(kinds: Sequence[_ForceKind], ends: Mapping[str, tuple[float, float]]) -> UnknownForce:
    """No force in the first setting of all dives; then each kind at each of its nodes, setting by setting."""
    dives = len(kinds[0].steps)

    def strength(field: str) -> Array:
        blocks = [np.tile(kind.steps if kind.field == field else np.zeros(dives), (NODES, 1)) for kind in kinds]
        return np.concatenate([np.zeros((1, dives)), *blocks]).ravel()

    nodes = [np.linspace(*ends[kind.name], NODES) for kind in kinds]
    low, high, centre = (
        np.repeat(np.concatenate([[first], *values]), dives)
        for first, values in (
            (0.0, [np.full(NODES, node[0]) for node in nodes]),
            (1.0, [np.full(NODES, node[-1]) for node in nodes]),
            (0.0, nodes),
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
