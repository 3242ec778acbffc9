"""Horizontal motion of sinking and rising bodies in a current: carried by their layer, or by drag across the flow."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.phases.currents import Current
from missionplan.phases.mooring.vertical_motion import StepCallback


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

    def wait(self, duration: Array, depth: Array, pieces: int = 4, extra: Array | float = 0.0) -> None:
        """Drift at a depth [m] for a duration [s], with an extra velocity beyond the current, shape (2, n) [m/s]."""
        part = duration / pieces
        for _ in range(pieces):
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
