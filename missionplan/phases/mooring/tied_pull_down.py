"""Pull-down of two bodies tied by a taut line in a current, from the snatch to the anchor's touchdown.

Each step is split (Strang): half a step of the drag across the bodies, which is exact and never unstable, a step of all
else by the classical Runge–Kutta method, and another half step of the drag. Each half has the current at its middle.

Coordinates are the place of the vehicle's nose and the line's vector d from it to the anchor: east, north, down. With
forces F of water and weight, diagonal mass matrices M (axial down, lateral across), and the line as a constraint,

    M_v a_v = F_v + λ d,    M_a a_a = F_a - λ d,    d·(a_a - a_v) + |ḋ|² = 0,

where λ L is the tension. Both bodies stay upright: drag acts along and across them separately (cross-flow principle).
"""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array, Scalars, over_trials
from missionplan.phases.currents import Current
from missionplan.phases.mooring.forces import DescentHooks, Dive
from missionplan.phases.mooring.motion import CrossFlowFall, HorizontalDrift, Integration, Stage, TiedBodies, hermite
from missionplan.physics.drag import DragLaw


@dataclass(frozen=True)
class TiedState:
    """Vehicle and anchor on a taut line; rows are the vehicle's and the line's vector, each east, north, down."""

    place: Array
    """Of the vehicle's nose, and from it to the anchor, shape (6, n) [m]."""
    rate: Array
    """Their derivatives, shape (6, n) [m/s]."""

    @property
    def anchor(self) -> Array:
        """Place of the anchor, shape (3, n) [m]."""
        return self.place[:3] + self.place[3:]


class TiedForces:
    """Motion of both bodies on the taut line under each of their forces."""

    def __init__(self, dive: Dive, bodies: TiedBodies, hooks: DescentHooks, taut_at: Array) -> None:
        trials = taut_at.size
        self._dive, self._hooks, self._taut_at = dive, hooks, taut_at
        self.water_velocity = hooks.water_velocity
        self._factor = factor = hooks.mass_factor

        def per_mass(across: Scalars, along: Scalars) -> Array:
            return np.stack([over_trials(1.0 / (factor * mass), trials) for mass in (across, across, along)])

        self._per_vehicle = per_mass(bodies.vehicle.mass, dive.free_mass)
        self._per_anchor = per_mass(bodies.anchor.mass, dive.lone_mass)
        self._per_pair = self._per_vehicle + self._per_anchor
        self._decay = [bodies.vehicle.drag * self._per_vehicle[0], bodies.anchor.drag * self._per_anchor[0]]
        self._length_squared = over_trials(dive.line_length, trials) ** 2
        self._across = self._length_squared * self._per_pair[0]
        self._along = self._per_pair[2] - self._per_pair[0]

    def snatched(self, state: TiedState) -> TiedState:
        """State after the line has gone taut: an impulse along it ends the motion apart."""
        rate = state.rate.copy()
        rate[3:] = (rate[:3] + rate[3:]) / self._factor - rate[:3]  # an effect's mass takes part from now on
        self.tighten(state.place, rate)
        return TiedState(state.place, rate)

    def tighten(self, place: Array, rate: Array) -> None:
        """End the motion apart by an impulse along the line, in place."""
        line = place[3:]
        impulse = line * (_dot(line, rate[3:]) / self._mobility(line))
        rate[:3] += impulse * self._per_vehicle
        rate[3:] -= impulse * self._per_pair

    def hold(self, place: Array, rate: Array) -> None:
        """Hold the line at its length, and the vehicle in the water, in place."""
        line = place[3:]
        line *= np.sqrt(self._length_squared / _dot(line, line))
        self.tighten(place, rate)
        above = place[2] < 0.0
        if above.any():
            rate[2] = np.where(above, np.maximum(rate[2], 0.0), rate[2])
            place[2] = np.maximum(place[2], 0.0)

    def drag_across(self, place: Array, rate: Array, water: Array, duration: float) -> None:
        """Let the drag across both bodies act for a duration [s], in place; without other forces it is exact.

        The velocity w through the water falls off as w/(1 + c w t), c = k/m, which no step makes unstable.
        """
        vehicle = rate[:2] - water[0]
        anchor = rate[:2] + rate[3:5] - water[1]
        for through, decay in zip((vehicle, anchor), self._decay, strict=True):
            speed = np.sqrt(through[0] * through[0] + through[1] * through[1])
            through /= 1.0 + (duration * decay) * speed
        rate[3:5] = anchor - vehicle + (water[1] - water[0])
        rate[:2] = vehicle + water[0]
        self.tighten(place, rate)

    def acceleration(self, t: float, place: Array, rate: Array) -> Array:
        """Second derivative of a place under the vertical forces and the line, shape (6, n) [m/s²].

        At a time since the line went taut [s], of place and rate as in `TiedState`.
        """
        dive, hooks = self._dive, self._hooks
        line, turning = place[3:], rate[3:]
        vehicle = rate[2] - self.water_velocity
        anchor = vehicle + turning[2]
        lifted = dive.net_buoyancy + hooks.lift(place[2]) + self._drag(t, place[2], dive.vehicle_drag, vehicle)
        since = self._taut_at + t
        weight = dive.weight_at(since) * hooks.wet_weight_factor(since)
        sinking = -lifted * self._per_vehicle[2]
        apart = (weight - self._drag(t, place[2], dive.anchor_drag, anchor)) * self._per_anchor[2] - sinking
        tension = (line[2] * apart + _dot(turning, turning)) / self._mobility(line)
        pull = line * tension
        result = np.empty_like(place)
        np.multiply(pull, self._per_vehicle, out=result[:3])
        np.multiply(pull, -self._per_pair, out=result[3:])
        result[2] += sinking
        result[5] += apart
        return result

    def _drag(self, t: float, depth: Array, law: DragLaw, speed: Array) -> Scalars:
        """Drag of a body along its axis, with the effects' factor at the vehicle's depth [N]."""
        drag, hooks = law(speed), self._hooks
        if not hooks.changes_drag:
            return drag
        return drag * hooks.drag_factor(t, np.abs(speed)) * hooks.local_drag_factor(depth, self._dive.line_length)

    def _mobility(self, line: Array) -> Array:
        """Motion apart that an impulse d along the line ends: Σ d² (1/M_a + 1/M_v) [m²/kg]."""
        return np.asarray(self._across + line[2] * line[2] * self._along)


def _dot(a: Array, b: Array) -> Array:
    """Inner products of vectors, shape (3, n) each."""
    return np.asarray(a[0] * b[0] + a[1] * b[1] + a[2] * b[2])


LONGEST_STEP = 0.25
"""For lines that turn by up to four radians a second, as a shear of 4 m/s turns one of 1 m [s]."""

_Motion = tuple[Array, Array]
"""Place and rate, shape (6, n) each."""


@dataclass(frozen=True)
class TiedPullDown:
    """A pull-down, integrated."""

    stage: Stage
    """The vehicle's."""
    end: TiedState
    """At the anchor's touchdown."""
    places: Array
    """Shape (m, 6, n). On the grid of the stage; no rows unless kept [m]."""
    after: Array
    """When it begins, since the line went taut, shape (n,) [s]."""

    @property
    def times(self) -> Array:
        """Times of the one trial's places since the line went taut, shape (m,) [s]."""
        return float(self.after[0]) + self.stage.step * np.arange(len(self.places), dtype=np.float64)

    def anchor_depth_at(self, t: Array) -> Array:
        """Depth of the one trial's anchor at times since the line went taut, shape (k,) [m]; needs a kept history."""
        return np.interp(t, self.times, self.places[:, 2, 0] + self.places[:, 5, 0])


@dataclass
class TiedWater:
    """Water about both bodies; while it is taken as steady, it goes on changing as it did before."""

    current: Current
    centres: tuple[Scalars, Scalars]
    """Height of the vehicle's middle above its nose, and of the anchor's above the line's end [m]."""
    t_start: Array
    """When the line went taut, since the mission's start, shape (n,) [s]."""
    looked_up: tuple[tuple[float, Array], ...] = ()
    """The last two times since then, and what was found [s, m/s]."""

    def at(self, t: float, place: Array) -> Array:
        """Horizontal velocity about the vehicle and about the anchor, shape (2, 2, n) [m/s]."""
        if not self.looked_up or t >= self.looked_up[-1][0] + self.current.steady_for:
            self.looked_up = (*self.looked_up[-1:], (t, self._look_up(t, place)))
        last, water = self.looked_up[-1]
        if t == last or len(self.looked_up) < 2:
            return water
        before, earlier = self.looked_up[0]
        return np.asarray(water + (water - earlier) * ((t - last) / (last - before)))

    def _look_up(self, t: float, place: Array) -> Array:
        water = np.empty((2, 2, place.shape[1]))
        bodies = place[:3], place[:3] + place[3:]
        for row, body, centre in zip(water, bodies, self.centres, strict=True):
            row[:] = self.current.velocity(self.t_start + t, np.maximum(body[2] - centre, 0.0), body[:2])
        return water


def pull_down_tied(
    dive: Dive,
    bodies: TiedBodies,
    hooks: DescentHooks,
    before: tuple[Stage, Stage | None],
    falling: CrossFlowFall,
    afloat: HorizontalDrift,
    taut: NDArray[np.bool_],
    how: Integration,
) -> TiedPullDown:
    """Pull the vehicle down from the surface, from the moment the line is taut.

    The lone fall ends at the line's length in depth; the line is then laid along its direction to the anchor. The depth
    that this takes from the anchor, s²/2L with the distance s that it has been carried from below the vehicle, is the
    error of the moment at which the line goes taut.

    Parameters
    ----------
    before : tuple of Stage
        The anchor's lone fall, and how the vehicle came nose down, where that is simulated.
    falling, afloat : CrossFlowFall, HorizontalDrift
        Where anchor and vehicle are then.
    taut : array of bool, shape (n,)
        Trials in which the line pulls.
    how : Integration
        Its step is doubled up to `LONGEST_STEP`, so that two bodies cost less than twice as much as one.
    """
    lone, begun = before
    trials = lone.time.size
    rest = np.zeros((1, trials))
    line, bottom = (over_trials(value, trials) for value in (dive.line_length, dive.site_depth))
    toward = np.concatenate((falling.position - afloat.position, line[None]))
    toward *= line / np.sqrt(np.sum(toward * toward, axis=0))
    water = afloat.water(rest[0])
    if begun is None:
        forces = TiedForces(dive, bodies, hooks, lone.time)
        rate = np.concatenate((water, rest, falling.velocity - water, lone.speed[None]))
        start = forces.snatched(TiedState(np.concatenate((afloat.position, rest, toward)), rate))
    else:
        forces = TiedForces(dive, bodies, hooks.later(begun.time), lone.time + begun.time)
        sinking = (begun.speed + hooks.water_velocity)[None]
        rate = np.concatenate((water, sinking, falling.velocity - water, rest))
        start = TiedState(np.concatenate((afloat.position, begun.depth[None], toward)), rate)
        forces.tighten(start.place, start.rate)
    about = TiedWater(afloat.current, (bodies.vehicle.centre, bodies.anchor.centre), afloat.clock)
    how = replace(how, step=min(2.0 * how.step, LONGEST_STEP))
    pulled = integrate_tied(forces, about, start, bottom, taut, how)
    return pulled if begun is None else replace(pulled, after=begun.time)


def integrate_tied(
    forces: TiedForces,
    water: TiedWater,
    start: TiedState,
    bottom: Array,
    under_way: NDArray[np.bool_],
    how: Integration,
) -> TiedPullDown:
    """Integrate both bodies until the anchor is on the seafloor.

    Parameters
    ----------
    start : TiedState
        After the snatch.
    bottom : array, shape (n,)
        Depth of the seafloor [m].
    under_way : array of bool, shape (n,)
        Trials in which the line pulls; the others end at once.
    """
    step = how.step
    place, rate = start.place, start.rate
    ends = _Touchdowns(start, bottom, under_way)
    kept = [(place, rate)]
    t = 0.0
    for k in range(max(1, math.ceil(how.time_limit / step))):
        if not ends.under_way.any():
            break
        t = k * step
        before = place, rate
        rate = rate.copy()
        forces.drag_across(place, rate, water.at(t + 0.25 * step, place + 0.25 * step * rate), 0.5 * step)
        # one step of the classical Runge–Kutta method for p'' = a(t, p, p')
        half = 0.5 * step
        k1 = forces.acceleration(t, place, rate)
        rate2 = rate + half * k1
        k2 = forces.acceleration(t + half, place + half * rate, rate2)
        rate3 = rate + half * k2
        k3 = forces.acceleration(t + half, place + half * rate2, rate3)
        k4 = forces.acceleration(t + step, place + step * rate3, rate + step * k3)
        k2 += k3
        k1 += k2
        k2 += k1
        k2 += k4
        place, rate = place + step * (rate + (step / 6.0) * k1), rate + (step / 6.0) * k2
        forces.hold(place, rate)
        forces.drag_across(place, rate, water.at(t + 0.75 * step, place - 0.25 * step * rate), 0.5 * step)
        ends.record(ends.landed(place), t, before, (place, rate))
        if how.keep:
            kept.append((place, rate))
    ended = ~ends.under_way
    ends.record(np.flatnonzero(~ended), t + step, (place, rate), (place, rate))
    time, end = ends.touchdown(step)
    places, rates = (np.stack(part) if how.keep else np.empty((0, *place.shape)) for part in zip(*kept, strict=True))
    stage = Stage(step, time, end.place[2], end.rate[2] - forces.water_velocity, ended, places[:, 2], rates[:, 2])
    return TiedPullDown(stage, end, places, np.zeros_like(time))


class _Touchdowns:
    """The step in which each trial's anchor reaches the seafloor: place and rate before and after."""

    def __init__(self, start: TiedState, bottom: Array, under_way: NDArray[np.bool_]) -> None:
        self._before = np.stack((start.place, start.rate))
        self._after, self._bottom = self._before.copy(), bottom
        self._start = np.zeros(bottom.size)
        self.under_way = under_way.copy()

    def landed(self, place: Array) -> NDArray[np.intp]:
        """Trials under way whose anchor is now on the seafloor."""
        return np.flatnonzero(self.under_way & (place[2] + place[5] >= self._bottom))

    def record(self, trials: NDArray[np.intp], t: float, before: _Motion, after: _Motion) -> None:
        """Record the step in which trials end."""
        self._start[trials] = t
        for kept, motion in ((self._before, before), (self._after, after)):
            for part, values in zip(kept, motion, strict=True):
                part[:, trials] = values[:, trials]
        self.under_way[trials] = False

    def touchdown(self, step: float) -> tuple[Array, TiedState]:
        """Time of the touchdown, and the state then, by cubic Hermite polynomials."""
        low, high = np.zeros_like(self._start), np.ones_like(self._start)
        (p0, r0), (p1, r1) = self._before, self._after
        ends = [values[2] + values[5] for values in (p0, step * r0, p1, step * r1)]
        for _ in range(30):
            middle = 0.5 * (low + high)
            past = hermite(middle, *ends) >= self._bottom
            low, high = np.where(past, low, middle), np.where(past, middle, high)
        share = np.where(np.any(p0 != p1, axis=0), high, 0.0)  # a trial that was cut, or never pulled, stays
        place = hermite(share, p0, step * r0, p1, step * r1)
        mean = (p1 - p0) / step
        swing = (r0 - mean) * (1.0 - share) * (1.0 - 3.0 * share) - (r1 - mean) * share * (2.0 - 3.0 * share)
        return self._start + share * step, TiedState(place, np.where(share > 0.0, mean + swing, r0))
