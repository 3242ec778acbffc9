"""Motion of sinking and rising bodies: vertical, by fixed-step RK4 with the end of a stage interpolated; horizontal.

A stage runs on its own clock, which starts for each trial when its last stage ended, so that the steps of all trials
coincide though their events do not.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from missionplan.arrays import Array, Scalars, row_and_next
from missionplan.phases.currents import Current

STEP = 0.1
"""Default step, a twenty-fifth of the prototype's time constant [s]."""

StepCallback = Callable[[Scalars, Array, Array], None]
"""Called at each step with its start on the stage's clock [s], each trial's time in it [s], and mean depth [m]."""


class Forces(Protocol):
    """Vertical acceleration of a body; trials are the last axis."""

    @property
    def water_velocity(self) -> Scalars:
        """Downward velocity of the water [m/s]."""
        ...

    def acceleration(self, t: float, depth: Array, speed: Array) -> Array:
        """Of a body at a depth [m] with a downward speed through the water [m/s], at a time of the stage [s]."""
        ...


@dataclass(frozen=True)
class Stop:
    """End of a stage: a depth reached from above or below, shape (n,) [m], or the moment the body stops sinking."""

    deepest: Scalars = np.inf
    shallowest: Scalars = -np.inf
    at_rest: bool = False

    def left(self, depth: Array, rate: Array) -> Array:
        """Event function: reaches 0 when a trial's stage ends, from depth [m] and its rate [m/s]."""
        left = np.minimum(self.deepest - depth, depth - self.shallowest)
        return np.minimum(left, rate) if self.at_rest else left


@dataclass(frozen=True)
class Integration:
    """How a stage is integrated: the time at which it is cut and the step [s], and whether its history is kept."""

    time_limit: float
    step: float = STEP
    keep: bool = False


@dataclass(frozen=True)
class Stage:
    """A stage of a descent or ascent, integrated."""

    step: float
    """[s]."""
    time: Array
    depth: Array
    speed: Array
    """Shape (n,). End of each trial's stage: on the stage's clock [s], depth [m] and speed through the water [m/s]."""
    ended: NDArray[np.bool_]
    """False where the stage was cut at its time limit, shape (n,)."""
    depths: Array
    rates: Array
    """Shape (m, n). On the grid k·step of the stage's clock: depth [m] and its rate [m/s]; no rows unless kept."""

    def depth_at(self, t: Array) -> Array:
        """Depth at times of the stage's clock, shape (k, n) [s], constant beyond its ends [m]; needs a kept history."""
        if len(self.depths) < 2:
            return np.broadcast_to(self.depth, t.shape)
        inside = np.clip(t, 0.0, self.time) / self.step
        index = np.minimum(inside.astype(np.intp), len(self.depths) - 2)
        (z0, z1), (r0, r1) = (row_and_next(grid, index) for grid in (self.depths, self.rates))
        return hermite(inside - index, z0, self.step * r0, z1, self.step * r1)


@dataclass(frozen=True)
class Followed(Stage):
    """Two stages, one after the other, as one; the histories are those of the second."""

    first: Stage
    second: Stage

    @classmethod
    def by(cls, first: Stage, second: Stage) -> "Followed":
        """Return a stage and the one that follows it."""
        time, end = first.time + second.time, second
        return cls(end.step, time, end.depth, end.speed, end.ended, end.depths, end.rates, first=first, second=second)

    @override
    def depth_at(self, t: Array) -> Array:
        since = t - self.first.time
        return np.where(since < 0.0, self.first.depth_at(t), self.second.depth_at(since))


def integrate_stage(
    forces: Forces,
    depth: Array,
    speed: Array,
    stop: Stop,
    how: Integration,
    on_step: StepCallback | None = None,
) -> Stage:
    """Integrate the motion of bodies through one stage.

    Parameters
    ----------
    depth, speed : array, shape (n,)
        At the start: depth [m] and downward speed through the water [m/s].
    on_step : callable, optional
        For what happens during the stage, such as horizontal drift.
    """
    water, step = forces.water_velocity, how.step
    z, u, a = depth, speed, forces.acceleration(0.0, depth, speed)
    ends = _StageEnds(np.stack((z, u, a)), stop.left(z, u + water) > 0.0)
    stays_at_surface = bool(np.all(np.isneginf(stop.shallowest)))
    grid = [(z, u + water)]
    t = 0.0
    for k in range(max(1, math.ceil(how.time_limit / step))):
        if not ends.under_way.any():
            break
        t = k * step
        z1, u1 = _rk4(forces, t, (z, u, a), water, step)
        if stays_at_surface and (z1 < 0.0).any():  # a body does not rise out of the water
            u1 = np.where(z1 < 0.0, np.maximum(u1, -water), u1)
            z1 = np.maximum(z1, 0.0)
        a1 = forces.acceleration(t + step, z1, u1)
        ends.record(stop.left(z1, u1 + water) <= 0.0, t, (z, u, a), (z1, u1, a1))
        if on_step is not None:
            on_step(t, np.where(ends.under_way, step, 0.0), 0.5 * (z + z1))
        z, u, a = z1, u1, a1
        if how.keep:
            grid.append((z, u + water))
    ended = ~ends.under_way
    ends.record(ends.under_way, t + step, (z, u, a), (z, u, a))
    share = np.where(ended, ends.share(stop, water, step), 0.0) if ended.any() else np.zeros(ended.size)
    z0, (z, u) = ends.before[0], ends.at(share, water, step)
    if on_step is not None:
        on_step(ends.start, share * step, 0.5 * (z0 + z))
    depths, rates = (np.stack(values) if how.keep else np.empty((0, z.size)) for values in zip(*grid, strict=True))
    return Stage(step, ends.start + share * step, z, u, ended, depths, rates)


class _StageEnds:
    """The step in which each trial's stage ends: depth, speed and acceleration before and after, shape (3, n)."""

    def __init__(self, state: Array, under_way: NDArray[np.bool_]) -> None:
        self.under_way = under_way
        self.before, self.after = state.copy(), state.copy()
        self.start = np.zeros(state.shape[1])

    def record(self, over: NDArray[np.bool_], t: float, before: tuple[Array, ...], after: tuple[Array, ...]) -> None:
        """Record the step of the trials under way whose stage is over."""
        new = over & self.under_way
        if new.any():
            np.copyto(self.start, t, where=new)
            for kept, values in ((self.before, before), (self.after, after)):
                for row, value in zip(kept, values, strict=True):
                    np.copyto(row, value, where=new)
            self.under_way = self.under_way & ~new

    def at(self, share: Array, water: Scalars, step: float) -> tuple[Array, Array]:
        """Depth and speed at a share of the step, by cubic Hermite polynomials."""
        (z0, u0, a0), (z1, u1, a1) = self.before, self.after
        z = hermite(share, z0, step * (u0 + water), z1, step * (u1 + water))
        return z, hermite(share, u0, step * a0, u1, step * a1)

    def share(self, stop: Stop, water: Scalars, step: float) -> Array:
        """Share of the step at which the stage ends, by bisection to 1e-9."""
        low, high = np.zeros_like(self.start), np.ones_like(self.start)
        for _ in range(30):
            middle = 0.5 * (low + high)
            z, u = self.at(middle, water, step)
            past = stop.left(z, u + water) <= 0.0
            low, high = np.where(past, low, middle), np.where(past, middle, high)
        return high


def hermite(share: Array, y0: Array, slope0: Array, y1: Array, slope1: Array) -> Array:
    """Cubic with given values and slopes (per step) at both ends, at a share of the step."""
    rest = 1.0 - share
    rise = y1 - y0
    return y0 * rest + y1 * share + share * rest * ((slope0 - rise) * rest - (slope1 - rise) * share)


def _rk4(
    forces: Forces, t: float, state: tuple[Array, Array, Array], water: Scalars, step: float
) -> tuple[Array, Array]:
    """One step of the classical Runge–Kutta method for z' = u + w, u' = a(t, z, u), given a at its start."""
    z, u, k1 = state
    half = 0.5 * step
    drifted = z + half * water
    u2 = u + half * k1
    k2 = forces.acceleration(t + half, drifted + half * u, u2)
    u3 = u + half * k2
    k3 = forces.acceleration(t + half, drifted + half * u2, u3)
    k4 = forces.acceleration(t + step, z + step * (u3 + water), u + step * k3)
    inner = k2 + k3
    return z + step * (u + water + step / 6.0 * (k1 + inner)), u + step / 6.0 * (k1 + 2.0 * inner + k4)


_PIECES = 4
"""Parts of a wait at a depth, each with one velocity of the current."""


class HorizontalDrift:
    """Horizontal drift of a sinking or rising body with the current.

    `position` has shape (2, n) [m], `clock`, its time since the mission's start, shape (n,) [s]. Steps of a stage are
    gathered while the current is taken as steady, and moved through at once, with the water at their mean time and
    depth.
    """

    def __init__(self, current: Current, position: Array, t_start: Array) -> None:
        self.current, self.clock = current, t_start
        self._position = position
        self._gathered: _Steps | None = None

    @property
    def position(self) -> Array:
        """East and north, shape (2, n) [m]."""
        self._move()
        return self._position

    @position.setter
    def position(self, position: Array) -> None:
        self._position, self._gathered = position, None

    def wait(self, duration: Array, depth: Array, extra: Array | float = 0.0) -> None:
        """Drift at a depth [m] for a duration [s], with an extra velocity beyond the current, shape (2, n) [m/s]."""
        part = duration / _PIECES
        for _ in range(_PIECES):
            velocity = self.current.velocity(self.clock + 0.5 * part, depth, self.position) + extra
            self.position = self.position + part * velocity
            self.clock = self.clock + part

    def stage(self, below: Scalars = 0.0) -> StepCallback:
        """Return the callback that drifts with a stage, for a body that hangs a length `below` the moving one [m]."""
        start, steady = self.clock, self.current.steady_for

        def on_step(t: Scalars, spent: Array, depth: Array) -> None:
            if not steady:
                velocity = self.current.velocity(start + t + 0.5 * spent, depth + below, self.position)
                self.position = self.position + spent * velocity
                return
            self._gathered = _Steps.of(self._gathered, start, t, spent, depth + below)
            if np.max(self._gathered.spent, initial=0.0) >= steady:
                self._move()

        return on_step

    def advance(self, duration: Array) -> None:
        """Advance the clock by a stage's duration [s]."""
        self.clock = self.clock + duration

    def water(self, depth: Array) -> Array:
        """Velocity of the water about the body now, at a depth [m], shape (2, n) [m/s]."""
        velocity = self.current.velocity(self.clock, depth, self.position)
        return np.broadcast_to(velocity, self.position.shape)

    def _move(self) -> None:
        """Move through the steps that were gathered."""
        if self._gathered is None:
            return
        steps, self._gathered = self._gathered, None
        lasting = np.where(steps.spent > 0.0, steps.spent, 1.0)
        t, depth = steps.moment / lasting, steps.depth / lasting
        self._position = self._position + steps.spent * self.current.velocity(steps.start + t, depth, self._position)


class _Steps(NamedTuple):
    """Steps not yet moved through: the stage's start, and sums of times spent, and of middles and depths over time."""

    start: Array
    spent: Array
    moment: Array
    depth: Array

    @classmethod
    def of(cls, before: "_Steps | None", start: Array, t: Scalars, spent: Array, depth: Array) -> "_Steps":
        """Return the steps before, and one more that begins `t` after the start [s]."""
        moment, deep = spent * (t + 0.5 * spent), spent * depth
        if before is None:
            return cls(start, spent, moment, deep)
        return cls(start, before.spent + spent, before.moment + moment, before.depth + deep)


@dataclass(frozen=True)
class CrossFlowBody:
    """An upright body across the flow; each number is a float or an array over trials, shape (n,)."""

    drag: Scalars
    """k = ½ ρ C_d A of the drag k w|w| [N s²/m²]."""
    mass: Scalars
    """With its lateral added mass [kg]."""
    centre: Scalars = 0.0
    """Height of its middle, where the water acts on it, above the line's end [m]."""


@dataclass(frozen=True)
class TiedBodies:
    """What ties the drift of two bodies together: their drag and mass across the flow; without it, each goes alone."""

    anchor: CrossFlowBody
    vehicle: CrossFlowBody


class CrossFlowFall:
    """Horizontal motion of a lone falling body; `position` and `velocity` have shape (2, n) [m, m/s].

    Over a step the water's velocity is held. The velocity through it then falls off as w/(1 + c w t) with c = k/m, in
    an unchanged direction, so that a step is exact. `track` holds times of the stage [s] and positions, if kept.
    """

    def __init__(self, body: CrossFlowBody, drift: HorizontalDrift, velocity: Array, *, keep: bool = False) -> None:
        self._decay = body.drag / body.mass
        self._current, self._t_start = drift.current, drift.clock
        self.position, self.velocity = drift.position, velocity
        self._keep, self.track = keep, [(np.zeros(velocity.shape[1]), drift.position)]

    def stage(self) -> StepCallback:
        """Return the callback that moves the body with a stage."""

        def on_step(t: Scalars, spent: Array, depth: Array) -> None:
            water = self._current.velocity(self._t_start + t + 0.5 * spent, depth, self.position)
            through = self.velocity - water
            rate = self._decay * np.hypot(through[0], through[1])
            slowed = rate * spent
            reach = np.where(slowed > 1e-9, np.log1p(slowed) / np.maximum(rate, 1e-300), spent)
            self.position = self.position + water * spent + through * reach
            self.velocity = water + through / (1.0 + slowed)
            if self._keep:
                self.track.append((t + spent, self.position))

        return on_step
