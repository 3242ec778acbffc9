"""Statics of a buoyant slender body that hangs by its nose on a line in a layered current.

Hoerner's cross-flow principle (Fluid-Dynamic Drag, 1965, ch. III): the drag across a slender body, or a line, is that
of the velocity's component across its axis, the drag along it that of the component along it. The line has no weight
and does not stretch; the body turns freely about its nose. `docs/mooring.md` has the equations and their limits.

Vectors are east, north and up from the anchor; trials are the last axis.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array, Scalars, over_trials, take_trials
from missionplan.physics.bracketed_roots import bracketed_roots
from missionplan.physics.current_above import LayersAbove, ProfileAbove
from missionplan.physics.held_balance import balanced
from missionplan.physics.held_body import HeldBody, HeldLine

_LINE_SECTIONS = 20
_TOLERANCE = 1e-7
"""Of angles [rad] and of the nose's altitude, in line lengths."""
_WEAKEST = 1e-12
"""Tension that keeps a slack line's direction finite [N]."""


@dataclass(frozen=True)
class HeldPose:
    """How the body stands on its line; arrays over trials.

    Attributes
    ----------
    nose : array, shape (3, n)
        East, north and up from the anchor [m].
    axis : array, shape (3, n)
        Unit vector from nose to tail.
    tension_at_nose, tension_at_anchor : array, shape (3, n)
        With which the body pulls the line, and the line the anchor [N].
    """

    nose: Array
    axis: Array
    tension_at_nose: Array
    tension_at_anchor: Array

    @property
    def pitch(self) -> Array:
        """Elevation of the tail seen from the nose, shape (n,): 90° where the body stands on its nose [rad]."""
        return np.asarray(np.arcsin(np.clip(self.axis[2], -1.0, 1.0)))

    @property
    def line_angle(self) -> Array:
        """Angle of the line to the vertical at the anchor, shape (n,) [rad]."""
        east, north, up = self.tension_at_anchor
        return np.asarray(np.arctan2(np.hypot(east, north), up))

    @property
    def excursion(self) -> Array:
        """Horizontal distance of the nose from the anchor, shape (n,) [m]."""
        return np.asarray(np.hypot(self.nose[0], self.nose[1]))

    @property
    def tension(self) -> Array:
        """Greatest tension of the line, shape (n,) [N]."""
        ends = (self.tension_at_nose, self.tension_at_anchor)
        return np.asarray(np.maximum(*(np.sqrt((end**2).sum(axis=0)) for end in ends)))


def held_pose(body: HeldBody, line: HeldLine, current: LayersAbove, near: HeldPose | None = None) -> HeldPose:
    """Find how a block of bodies stands in a steady current.

    The nose's altitude is the root of (height of the line) - altitude, the pitch that of the moment about the nose at
    that altitude. A body that the current or its own weight takes down to the seafloor has its nose at altitude 0.

    Parameters
    ----------
    body : HeldBody
    line : HeldLine
    current : LayersAbove
        Horizontal, constant within each layer.
    near : HeldPose, optional
        Where the search begins.

    Returns
    -------
    HeldPose
    """
    trials = current.velocity.shape[-1]
    length = over_trials(line.length, trials)
    pitch, start = (near.pitch, near.nose[2]) if near else (np.full(trials, 0.25 * np.pi), 0.8 * length)
    if isinstance(current, ProfileAbove):

        def height(altitude: Array, pull: Array) -> Array:
            return np.asarray(_follow_line(line, body.density, current, altitude, pull)[0][-1, 2])

        pitch, start = balanced(body, current, height, length, (pitch, start))
    standing = _Standing(body, line, current, pitch)
    tolerance, patience = _TOLERANCE * float(np.max(length)), current.patience
    altitude = bracketed_roots(standing, np.zeros(trials), length, start, tolerance=tolerance, patience=patience)
    return standing.pose(altitude)


@dataclass
class _Standing:
    """Height of the line less an assumed altitude of the nose [m].

    `pitch` is where the search for it begins [rad]; `before` holds the last altitudes and what they gave, shape (2, n).
    """

    body: HeldBody
    line: HeldLine
    current: LayersAbove
    pitch: Array
    before: Array | None = None

    def evaluate(self, altitude: Array) -> tuple[Array, Array]:
        excess = self._hanging(altitude)[1][2] - altitude
        step = excess  # in a uniform current the altitude does not matter, and this step is the last
        if self.before is not None:
            moved, changed = altitude - self.before[0], excess - self.before[1]
            falls = (moved * changed < 0.0) & (np.abs(changed) > 0.1 * np.abs(moved))
            step = np.where(falls, -excess * moved / np.where(falls, changed, 1.0), excess)  # the secant's
        self.before = np.stack((altitude, excess))
        return excess, step

    def take(self, trials: NDArray[np.intp]) -> "_Standing":
        return take_trials(self, trials)

    def pose(self, altitude: Array) -> HeldPose:
        """Pose with the nose at its altitude [m]."""
        axis, nose, pull, load = self._hanging(altitude)
        return HeldPose(np.concatenate((nose[:2], altitude[None])), axis, pull, load)

    def _hanging(self, altitude: Array) -> tuple[Array, Array, Array, Array]:
        """Axis, vector from anchor to nose that the line makes [m], and the tensions at nose and anchor [N]."""
        body, quarter = self.body, np.full(altitude.size, 0.5 * np.pi)
        turning = _Turning(body, self.current, altitude)
        patience = self.current.patience
        self.pitch = bracketed_roots(turning, -quarter, quarter, self.pitch, tolerance=_TOLERANCE, patience=patience)
        course, speeds = turning.flow(self.pitch)
        sine, cosine = np.sin(self.pitch), np.cos(self.pitch)
        axis = np.stack((course[0] * cosine, course[1] * cosine, sine))
        across = np.stack((course[0] * sine, course[1] * sine, -cosine))
        normal = body.section_drag * (speeds * np.abs(speeds)).sum(axis=0) * sine * np.abs(sine)
        pull = axis * body.axial_drag(speeds.mean(axis=0) * cosine) + across * normal
        pull[2] += body.net_buoyancy
        places, load = _follow_line(self.line, body.density, self.current, altitude, pull)
        return axis, places[-1], pull, load


@dataclass(frozen=True)
class _Turning:
    """Moment about the nose, at an altitude, that raises the tail, against the pitch."""

    body: HeldBody
    current: LayersAbove
    altitude: Array

    def take(self, trials: NDArray[np.intp]) -> "_Turning":
        return take_trials(self, trials)

    def evaluate(self, pitch: Array) -> tuple[Array, Array]:
        """Moment [N m], and Newton's step [rad]."""
        body, sine, cosine = self.body, np.sin(pitch), np.cos(pitch)
        _, speeds = self.flow(pitch)
        drag = body.section_drag * (body.sections * speeds * np.abs(speeds)).sum(axis=0)
        righting = np.abs(body.righting_moment)
        moment = body.raising_moment * cosine - righting * sine - drag * sine * np.abs(sine)
        slope = body.raising_moment * sine + righting * cosine + 2.0 * drag * np.abs(sine) * cosine
        return moment, moment / np.maximum(np.abs(slope), _WEAKEST)

    def flow(self, pitch: Array) -> tuple[Array, Array]:
        """Direction in which the body trails, shape (2, n), and the current along it at the sections [m/s].

        It is the direction of the drag's moment about the nose; what flows across it is left out.
        """
        velocity = self.current.at(self.altitude + self.body.sections * np.sin(pitch))
        turning = (self.body.sections * np.hypot(velocity[0], velocity[1]) * velocity).sum(axis=1)
        size = np.hypot(turning[0], turning[1])
        course = turning / np.where(size > 0.0, size, 1.0)
        course[0] += size <= 0.0  # in still water any direction will do
        return course, velocity[0] * course[0] + velocity[1] * course[1]


def line_shape(line: HeldLine, density: Scalars, current: LayersAbove, pose: HeldPose) -> Array:
    """Points of the line from the anchor to the nose of a pose, shape (k, 3, n) [m]."""
    down, _ = _follow_line(line, density, current, pose.nose[2], pose.tension_at_nose)
    return np.asarray(down[-1] - np.concatenate((down[::-1], np.zeros((1, *pose.nose.shape)))))


def _follow_line(
    line: HeldLine, density: Scalars, current: LayersAbove, altitude: Array, pull: Array
) -> tuple[Array, Array]:
    """How far points of the line lie below the nose, shape (k, 3, n) [m], and its pull at the anchor, (3, n) [N]."""
    factor = 0.5 * density * line.coefficient * line.diameter * line.length / _LINE_SECTIONS
    if not np.any(factor):
        return (line.length * _direction(pull))[None], pull
    step = line.length / _LINE_SECTIONS

    def drag(velocity: Array, along: Array) -> Array:
        across = -along * (velocity * along[:2]).sum(axis=0)
        across[:2] += velocity
        return np.asarray(factor * np.sqrt((across**2).sum(axis=0)) * across)

    fallen = np.zeros_like(pull)
    places = np.empty((_LINE_SECTIONS, *pull.shape))
    for section in range(_LINE_SECTIONS):
        middle = altitude - fallen[2] - 0.5 * step * _direction(pull)[2]
        velocity = current.at(middle[None])[:, 0]
        along = _direction(pull + 0.5 * drag(velocity, _direction(pull)))
        pull = pull + drag(velocity, along)
        fallen = places[section] = fallen + step * along
    return places, pull


def _direction(vector: Array) -> Array:
    """Unit vector, shape (3, n)."""
    return np.asarray(vector / np.maximum(np.sqrt((vector**2).sum(axis=0)), _WEAKEST))
