"""Vertical motion of sinking and rising bodies: fixed-step RK4 over trials, with the end of a stage interpolated.

A stage runs on its own clock, which starts for each trial when its last stage ended, so that the steps of all trials
coincide though their events do not.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from missionplan.arrays import Array, Scalars, row_and_next

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
        time, own = first.time + second.time, second
        return cls(own.step, time, own.depth, own.speed, own.ended, own.depths, own.rates, first=first, second=second)

    @override
    def depth_at(self, t: Array) -> Array:
        since = t - self.first.time
        return np.where(since < 0.0, self.first.depth_at(t), self.second.depth_at(since))


def integrate_stage(
    forces: Forces,
    depth: Array,
    speed: Array,
    stop: Stop,
    *,
    time_limit: float,
    step: float = STEP,
    keep: bool = False,
    on_step: StepCallback | None = None,
) -> Stage:
    """Integrate the motion of bodies through one stage.

    Parameters
    ----------
    depth, speed : array, shape (n,)
        At the start: depth [m] and downward speed through the water [m/s].
    stop : Stop
        End of the stage.
    time_limit : float
        A stage that has not ended by then is cut [s].
    step : float
        [s].
    keep : bool
        Whether to keep depths and rates on the grid.
    on_step : callable, optional
        For what happens during the stage, such as horizontal drift.
    """
    water = forces.water_velocity
    z, u, a = depth, speed, forces.acceleration(0.0, depth, speed)
    ends = _StageEnds(np.stack((z, u, a)), stop.left(z, u + water) > 0.0)
    stays_at_surface = bool(np.all(np.isneginf(stop.shallowest)))
    grid = [(z, u + water)]
    t = 0.0
    for k in range(max(1, math.ceil(time_limit / step))):
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
        if keep:
            grid.append((z, u + water))
    ended = ~ends.under_way
    ends.record(ends.under_way, t + step, (z, u, a), (z, u, a))
    share = np.where(ended, ends.share(stop, water, step), 0.0)
    z0, (z, u) = ends.before[0], ends.at(share, water, step)
    if on_step is not None:
        on_step(ends.start, share * step, 0.5 * (z0 + z))
    depths, rates = (np.stack(values) if keep else np.empty((0, z.size)) for values in zip(*grid, strict=True))
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
