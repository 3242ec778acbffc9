"""Statics of a buoyant slender body that hangs by its nose on a line in a layered current.

Hoerner's cross-flow principle (Fluid-Dynamic Drag, 1965, ch. III): the drag across a slender body is that of the
velocity's component across its axis, the drag along it that of the component along it. The body turns freely about its
nose, from which `held_line` follows the line. `docs/mooring.md` has the equations and their limits.

Vectors are east, north and up from the anchor; trials are the last axis.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array, Scalars, bracketed_roots, over_trials, take_trials
from missionplan.physics.held_line import Float, HeldBody, HeldLine, HungLine, LowPoint, direction, hang, size
from missionplan.physics.seafloor import LayersAbove

_TOLERANCE = 1e-5
"""Step of angles [rad] and of the nose's altitude, in line lengths, after which there is no other; the next of Newton's
method, or the secant's, would be a hundredth of it or less."""
_STEPS, _LONG = 100, 12.0
"""Of the way to a pose, and the time of it in those of its end's decay: what is left then is a hundred-thousandth."""
_LYING = 1e-6
"""Length that lies on the seafloor before a float lifts the rest is known to this [m]."""
_WEAKEST = 1e-12
"""Tension that keeps a slack line's direction finite [N]."""


def laid(line: HeldLine, current: LayersAbove, altitude: Array, pull: Array) -> HungLine:
    """Follow a line down as `hang` does; lay what is beyond its lowest place on the seafloor, save what floats lift.

    On a smooth seafloor a level line keeps its tension. So much of it lies that the rest, lifted by its floats, comes
    down to the seafloor again: at the anchor, or level, where the same holds for what is beyond.
    """
    hung = hang(line, current, altitude, pull)
    trials = np.flatnonzero(hung.low.fallen[2] > hung.fallen[-1, 2] + _LYING)
    if not trials.size:
        return hung
    low = take_trials(hung.low, trials)
    rest = _beyond(take_trials(line, trials), take_trials(current, trials), low)
    fallen = np.concatenate((hung.fallen, np.repeat(hung.fallen[-1:], len(rest.fallen), axis=0)))
    load = hung.load.copy()
    is_before = np.arange(len(hung.fallen))[:, None, None] < low.number
    fallen[: len(hung.fallen), :, trials] = np.where(is_before, hung.fallen[..., trials], low.fallen)
    fallen[len(hung.fallen) :, :, trials] = low.fallen + rest.fallen
    load[:, trials] = rest.load
    return HungLine(fallen, load, hung.low)


def _beyond(line: HeldLine, current: LayersAbove, low: LowPoint) -> HungLine:
    """Lay what is beyond the lowest place of a line."""
    lifted = _Lifted(line, current, low)
    ahead = [np.where(item.distance > low.distance, item.distance - low.distance, np.inf) for item in line.floats]
    high = np.minimum.reduce([*ahead, line.length - low.distance])
    lying = bracketed_roots(lifted, np.zeros_like(high), high, 0.5 * high, tolerance=_LYING)
    rest = laid(lifted.after(lying), current, np.zeros_like(lying), lifted.pull)
    flat = direction(lifted.pull) * lying * (1.0 + line.compliance * size(lifted.pull))
    return HungLine(np.concatenate((flat[None], flat + rest.fallen)), rest.load, rest.low)


@dataclass(frozen=True)
class _Lifted:
    """How far a line stays above the seafloor that floats lift off, against the length that lies before them [m]."""

    line: HeldLine
    current: LayersAbove
    low: LowPoint

    @property
    def pull(self) -> Array:
        """Tension where it lies, level, shape (3, n) [N]."""
        return np.asarray(self.low.tension * np.array([[1.0], [1.0], [0.0]]))

    def after(self, lying: Array) -> HeldLine:
        """The line beyond so much that lies."""
        gone = self.low.distance + lying
        floats = tuple(
            Float(
                np.maximum(item.distance - gone, 0.0), np.where(item.distance > self.low.distance, item.buoyancy, 0.0)
            )
            for item in self.line.floats
        )
        return replace(self.line, length=self.line.length - gone, floats=floats)

    def evaluate(self, lying: Array) -> tuple[Array, Array]:
        above = -hang(self.after(lying), self.current, np.zeros_like(lying), self.pull).lowest
        return above, above

    def take(self, trials: NDArray[np.intp]) -> "_Lifted":
        return take_trials(self, trials)


@dataclass(frozen=True)
class HeldPose:
    """How the body stands on its line; arrays over trials."""

    nose: Array
    """East, north and up from the anchor, shape (3, n) [m]."""
    axis: Array
    """Unit vector from nose to tail, shape (3, n)."""
    tension_at_nose: Array
    tension_at_anchor: Array
    """Shape (3, n). With which the body pulls the line, and the line the anchor [N]."""

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
    current : LayersAbove
        Horizontal, constant within each layer.
    near : HeldPose, optional
        Where the search begins.
    """
    trials = current.velocity.shape[-1]
    length = over_trials(_highest(body, line, current), trials)
    start = near.nose[2] if near else 0.8 * length
    pitch = near.pitch if near else _Turning(body, current, start).first_guess()
    standing = _Standing(body, line, current, pitch)
    tolerance = _TOLERANCE * float(np.max(length))
    altitude = bracketed_roots(standing, np.zeros(trials), length, start, tolerance=tolerance)
    return standing.pose(altitude)


def _highest(body: HeldBody, line: HeldLine, current: LayersAbove) -> Scalars:
    """Length of the line under more than the greatest tension that there can be [m]."""
    if not np.any(line.compliance):
        return line.length
    fastest = np.sqrt((current.velocity**2).sum(axis=1).max(axis=0))
    across = body.section_drag * len(body.sections) + line.drag_factor * line.length
    tension = np.abs(body.net_buoyancy) + body.axial_drag(fastest) + across * fastest**2
    tension = tension + np.abs(line.wet_weight) * line.length + sum(item.buoyancy for item in line.floats)
    return np.asarray(line.length * (1.0 + line.compliance * tension))


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
        _, pull = self._trailing(altitude)
        excess = hang(self.line, self.current, altitude, pull).deepest - altitude
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
        axis, pull = self._trailing(altitude)
        hung = laid(self.line, self.current, altitude, pull)
        return HeldPose(np.concatenate((hung.fallen[-1, :2], altitude[None])), axis, pull, hung.load)

    def _trailing(self, altitude: Array) -> tuple[Array, Array]:
        """Axis, and the tension at the nose [N], shape (3, n) each."""
        body, quarter = self.body, np.full(altitude.size, 0.5 * np.pi)
        turning = _Turning(body, self.current, altitude)
        self.pitch = bracketed_roots(turning, -quarter, quarter, self.pitch, tolerance=_TOLERANCE)
        course, speeds = turning.flow(self.pitch)
        sine, cosine = np.sin(self.pitch), np.cos(self.pitch)
        axis = np.stack((course[0] * cosine, course[1] * cosine, sine))
        across = np.stack((course[0] * sine, course[1] * sine, -cosine))
        normal = body.section_drag * (speeds * np.abs(speeds)).sum(axis=0) * sine * np.abs(sine)
        pull = axis * body.axial_drag(speeds.mean(axis=0) * cosine) + across * normal
        pull[2] += body.net_buoyancy
        return axis, pull


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
        velocity, shear = self.current.with_shear(self.altitude + body.sections * sine)
        course = self._course(velocity)
        speeds, shears = (part[0] * course[0] + part[1] * course[1] for part in (velocity, shear))
        levers = body.section_drag * body.sections * np.abs(speeds)
        drag, steeper = (levers * speeds).sum(axis=0), 2.0 * (levers * body.sections * shears).sum(axis=0) * cosine
        righting, steep = np.abs(body.righting_moment), sine * np.abs(sine)
        moment = body.raising_moment * cosine - righting * sine - drag * steep
        slope = body.raising_moment * sine + righting * cosine + 2.0 * drag * np.abs(sine) * cosine + steeper * steep
        return moment, moment / np.maximum(np.abs(slope), _WEAKEST)

    def first_guess(self) -> Array:
        """Pitch in the uniform current at mid-body, without the righting moment: R cos θ = D sin² θ [rad]."""
        _, speeds = self.flow(np.full(self.altitude.size, 0.25 * np.pi))
        drag = self.body.section_drag * (self.body.sections * speeds * np.abs(speeds)).sum(axis=0)
        ratio = np.maximum(self.body.raising_moment, 0.0) / np.maximum(drag, _WEAKEST)
        return np.asarray(np.arccos(2.0 / (np.sqrt(ratio**2 + 4.0) + ratio)))

    def flow(self, pitch: Array) -> tuple[Array, Array]:
        """Direction in which the body trails, shape (2, n), and the current along it at the sections [m/s].

        It is the direction of the drag's moment about the nose; what flows across it is left out.
        """
        velocity = self.current.at(self.altitude + self.body.sections * np.sin(pitch))
        course = self._course(velocity)
        return course, velocity[0] * course[0] + velocity[1] * course[1]

    def _course(self, velocity: Array) -> Array:
        turning = (self.body.sections * np.sqrt(velocity[0] ** 2 + velocity[1] ** 2) * velocity).sum(axis=1)
        size = np.hypot(turning[0], turning[1])
        course = turning / np.where(size > 0.0, size, 1.0)
        course[0] += size <= 0.0  # in still water any direction will do
        return np.asarray(course)


def settling_nose(pose: HeldPose, length: Scalars, speed: Array, time: Scalars) -> Array:
    """Where the nose is a time after it stood above its anchor, on the way to a pose, shape (3, n) [m].

    Without inertia: the body turns about the anchor by the drag of what flows past it, u cos α − r α′, against its
    buoyancy. Drag goes with the square, and buoyancy balances it at the pose's angle A to the vertical, so that
    r α′ = u (cos α − cos A √(sin α/sin A)). After 5 r sin A/u that is within a tenth of A (`docs/mooring.md`).

    Parameters
    ----------
    length : float or array, shape (n,)
        Of the line [m].
    speed : array, shape (n,)
        u, of the current past the body [m/s].
    time : float or array, shape (n,)
        [s]
    """
    reach = np.maximum(np.hypot(pose.excursion, pose.nose[2]), _WEAKEST)
    sine, cosine = np.maximum(pose.excursion / reach, _WEAKEST), pose.nose[2] / reach
    turn = speed / reach
    settled = _LONG / np.maximum(0.5 * turn * (sine + 1.0 / sine), _WEAKEST)
    under_way = np.flatnonzero(time < settled)
    if under_way.size < speed.size:  # the others are there, and only these are followed
        nose = pose.nose.copy()
        if under_way.size:
            part = pose, length, speed, time
            nose[:, under_way] = settling_nose(*take_trials(part, under_way))
        return nose
    last = np.arctan2(sine, cosine)

    def rate(angle: Array) -> Array:
        flowing = cosine * np.sqrt(np.maximum(np.sin(angle), 0.0) / sine)
        return np.asarray(turn * (np.cos(angle) - flowing))

    angle, step = np.zeros(speed.size), time / _STEPS
    for _ in range(_STEPS):
        half = angle + 0.5 * step * rate(angle)
        angle = np.minimum(angle + step * rate(half), last)
    share = angle / last
    radius, angle = length + share * (reach - length), share * last
    across = radius * np.sin(angle) / np.maximum(pose.excursion, _WEAKEST)
    return np.stack((pose.nose[0] * across, pose.nose[1] * across, radius * np.cos(angle)))


def line_shape(line: HeldLine, current: LayersAbove, pose: HeldPose) -> Array:
    """Points of the line from the anchor to the nose of a pose, shape (k, 3, n) [m]."""
    fallen = laid(line, current, pose.nose[2], pose.tension_at_nose).fallen
    down = np.concatenate((np.zeros((1, *pose.nose.shape)), fallen))
    return np.asarray((pose.nose - down)[::-1])
