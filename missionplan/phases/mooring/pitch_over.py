"""From the taut line to nose down: the vehicle, level at the surface, is pulled over by its nose.

A rigid body in the vertical plane, with M₁ along and M₂ across its axis (added masses included), I about its centre of
mass, which lies a behind the nose, and the velocities u along the axis, w across it and q of the pitch θ, nose down:

    M₁ u' - M₂ w q = F_e,   M₂ w' + M₁ u q = F_n,   I q' + (M₂ - M₁) u w = moment.

The forces are the line's at the nose, net buoyancy, weight and buoyancy at their centres, the base model's drag along
the axis, and the cross-flow drag section by section. The anchor hangs vertically a line's length below the nose.
"""

import math
from dataclasses import dataclass

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.phases.mooring.forces import DescentHooks, Dive, LoneFall, PullDown
from missionplan.phases.mooring.motion import Integration, Stage, Stop, integrate_stage
from missionplan.physics.vehicle_dynamics import PitchingBody, peak_tension

NOSE_DOWN = math.radians(80.0)
"""Pitch from which on the vehicle is taken as nose down, as in the base model."""
LONGEST = 20.0
"""Time after which a vehicle that has not turned over goes on as if it had [s]; a capsize takes one to five."""
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(6)


@dataclass(frozen=True)
class PitchOver:
    """A pitch-over, integrated."""

    stage: Stage
    """Of the nose, from the taut line to nose down."""
    turned: Array
    """Whether the vehicle came nose down before the anchor touched down, and within `LONGEST`, shape (n,)."""
    pitch: Array
    """At the end of the stage, nose down positive, shape (n,) [rad]."""


class _Motion:
    """Derivatives of nose depth, pitch, u, w and q, shape (5, n)."""

    def __init__(self, dive: Dive, body: PitchingBody, hooks: DescentHooks, taut_at: Array) -> None:
        self._dive, self._body, self._hooks, self._taut_at = dive, body, hooks, taut_at
        factor = hooks.mass_factor
        self.along, self.across = factor * dive.free_mass, factor * body.lateral_mass
        self.inertia, self.anchor = factor * body.inertia, factor * dive.lone_mass
        ends = body.centre - body.length, body.centre
        middle, half = 0.5 * (ends[0] + ends[1]), 0.5 * (ends[1] - ends[0])
        self._sections = [(middle + half * node, half * weight) for node, weight in zip(_NODES, _WEIGHTS, strict=True)]

    def snatched(self, lone: Stage) -> Array:
        """State after the line has gone taut: an impulse at the nose of the level body."""
        arm = self._body.centre
        give = 1.0 / self.across + arm * arm / self.inertia
        impulse = self._dive.lone_mass * lone.speed / (1.0 + self.anchor * give)
        rest = np.zeros_like(lone.speed)
        return np.stack((rest, rest, rest, impulse / self.across, arm * impulse / self.inertia))

    def rate(self, t: float, state: Array) -> Array:
        """Derivative of the state at a time since the line went taut [s]."""
        dive, body, hooks = self._dive, self._body, self._hooks
        depth, pitch, u, w, q = state
        sine, cosine = np.sin(pitch), np.cos(pitch)
        arm, water = body.centre, hooks.water_velocity
        along, across = u - water * sine, w - water * cosine
        sinking = u * sine + (w + arm * q) * cosine
        factor = hooks.drag_factor(t, np.abs(sinking)) * hooks.local_drag_factor(depth, dive.line_length)
        normal, moment = self._cross_flow(across, q)
        up = dive.net_buoyancy + hooks.lift(depth)
        force_along = -up * sine - factor * dive.vehicle_drag(along)
        moment = moment - (body.ahead * cosine - body.below * sine) * body.buoyancy
        moment = moment - (self.across - self.along) * along * across
        u1 = (force_along + self.across * w * q) / self.along
        w1 = (normal - up * cosine - self.along * u * q) / self.across
        q1 = moment / self.inertia
        since = self._taut_at + t
        weight = dive.weight_at(since) * hooks.wet_weight_factor(since) - factor * dive.anchor_drag(sinking - water)
        # the line's pull gives nose and anchor the same acceleration
        nose_acceleration = u1 * sine + (w1 + arm * q1) * cosine + u * q * cosine - (w + arm * q) * q * sine
        give = sine * sine / self.along + cosine * cosine * (1.0 / self.across + arm * arm / self.inertia)
        pull = (weight - self.anchor * nose_acceleration) / (1.0 + self.anchor * give)
        turning = q1 + pull * arm * cosine / self.inertia
        return np.stack((sinking, q, u1 + pull * sine / self.along, w1 + pull * cosine / self.across, turning))

    def _cross_flow(self, across: Array, q: Array) -> tuple[Array, Array]:
        """Force [N] and moment about the centre of mass [N m] of the drag across the body."""
        force, moment = np.zeros_like(across), np.zeros_like(across)
        for place, width in self._sections:
            flow = across + place * q
            drag = -self._body.drag_per_length * width * flow * np.abs(flow)
            force += drag
            moment += place * drag
        return force, moment


def pitch_over(
    dive: Dive, body: PitchingBody, hooks: DescentHooks, lone: Stage, deepest: Scalars, how: Integration
) -> PitchOver:
    """Integrate the pitch-over of a block of trials.

    Parameters
    ----------
    lone : Stage
        Of the anchor, which ends when the line is taut.
    deepest : float or array, shape (n,)
        Depth of the nose at which the anchor touches down; 0 where the line pulls nothing [m].
    how : Integration
        Its step is halved.
    """
    motion, step = _Motion(dive, body, hooks, lone.time), 0.5 * how.step
    state = motion.snatched(lone)
    before, after = state.copy(), state.copy()
    start, share = np.zeros_like(lone.time), np.zeros_like(lone.time)
    under_way = np.broadcast_to(np.asarray(deepest) > 0.0, lone.time.shape).copy()
    grid = [state]
    for k in range(max(1, math.ceil(min(how.time_limit, LONGEST) / step))):
        if not under_way.any():
            break
        # one step of the classical Runge–Kutta method
        t = k * step
        half = 0.5 * step
        k1 = motion.rate(t, state)
        k2 = motion.rate(t + half, state + half * k1)
        k3 = motion.rate(t + half, state + half * k2)
        k4 = motion.rate(t + step, state + step * k3)
        new: Array = state + step / 6.0 * (k1 + 2.0 * (k2 + k3) + k4)
        np.maximum(new[0], 0.0, out=new[0])
        part = np.minimum(_share(state[1], new[1], NOSE_DOWN), _share(state[0], new[0], deepest))
        over = under_way & (part <= 1.0)
        for kept, values in ((before, state), (after, new)):
            kept[:, under_way] = values[:, under_way]
        start[under_way], share[under_way] = k * step, np.minimum(part, 1.0)[under_way]
        under_way &= ~over
        state = new
        if how.keep:
            grid.append(state)
    end = before + share * (after - before)
    rates = [motion.rate(0.0, values)[0] for values in grid]
    sinking = motion.rate(0.0, end)[0]
    depths = np.stack([values[0] for values in grid]) if how.keep else np.empty((0, lone.time.size))
    ended = np.ones(lone.time.shape, dtype=bool)
    speed = np.where(start + share > 0.0, sinking, 0.0) - hooks.water_velocity
    stage = Stage(step, start + share * step, end[0], speed, ended, depths, np.stack(rates)[: len(depths)])
    return PitchOver(stage, end[1] >= NOSE_DOWN - 1e-6, end[1])


def _share(before: Array, after: Array, bound: Scalars) -> Array:
    """Share of a step at which a value reaches a bound from below; above 1 where it does not."""
    rise = after - before
    return np.where(after >= bound, (bound - before) / np.where(rise > 0.0, rise, 1.0), 2.0)


def snatch_tension(dive: Dive, hooks: DescentHooks, lone: Stage) -> Array:
    """Peak tension of the line as it goes taut, shape (n,) [N]."""
    if dive.spring is None:
        return np.full(lone.time.size, np.nan)
    fall = LoneFall(dive, hooks).acceleration(lone.time, lone.depth, lone.speed) * dive.lone_mass
    masses = dive.lone_mass, dive.spring.nose_mass
    return np.asarray(peak_tension(dive.spring.stiffness, lone.speed, masses, fall, dive.net_buoyancy))


def depth_lost(dive: Dive, hooks: DescentHooks, lone: Stage, pitched: PitchOver) -> Array:
    """How much higher the nose is at the end of the pitch-over than if it had been so at once, shape (n,) [m]."""
    time = pitched.stage.time
    speed = dive.lone_mass * lone.speed / (dive.joint_mass * hooks.mass_factor) - hooks.water_velocity
    at_once = integrate_stage(
        PullDown(dive, hooks, lone.time),
        np.zeros_like(time),
        np.where(time > 0.0, speed, 0.0),
        Stop(),
        Integration(float(np.max(time, initial=0.0)) + pitched.stage.step, pitched.stage.step, keep=True),
    )
    return np.asarray(at_once.depth_at(time[None])[0] - pitched.stage.depth)
