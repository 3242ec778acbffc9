"""A transit as a vehicle carries it out whose format cannot hold the plan's own rules: the loop of legs, changed.

The plan's rules are those of `LegLoop`: legs of at most d_max for the goal, aimed off as the mission compensates for
drift, and arrival where the fix on diving lies within the radius. A vehicle by another rule may take the point for
reached when its dead reckoning is near it, go through fixed points, or end after a fixed number of legs, wherever that
is. It may also go on without a fix that comes too late, by dead reckoning, or give up there or after a time.

A leg ends when its way through the water is made, which takes the same time in every trial: no time-out of a single
leg can end it before.
"""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from missionplan.arrays import Array, Scalars
from missionplan.phases.hooks import TrialState
from missionplan.phases.transit.leg_loop import LegLoop, length_of
from missionplan.phases.transit.plan import Environment, TransitNormals, TransitPlan, column


@dataclass(frozen=True)
class Execution:
    """What a vehicle does with a transit."""

    ends: Literal["fix", "reckoning", "count"]
    """The transit ends when the fix on diving lies within the arrival radius of the goal; on surfacing after the dead
    reckoning came within `capture` of the aim; after the legs to all of `points`."""
    aim: Array
    """Point that legs steer for, east and north of the coordinates' origin, shape (2,) or (2, n) [m]."""
    interval: float = float("inf")
    """Greatest length of a leg [m]."""
    surface_time: float | None = None
    """At the surface after each leg, where the vehicle stays for a fixed time [s]; None: until it has a fix."""
    fix_wait: float = float("inf")
    """For which it waits for a fix where it stays for no fixed time [s]."""
    key_wait: float = 0.0
    """At the surface after that [s]."""
    aborts: bool = False
    """Whether it gives up where no fix comes in its time at the surface; else it goes on by dead reckoning."""
    holds: bool = False
    """Whether it goes back to the leg's end at the surface once it has a fix, and holds its place there for the rest of
    its time. What that takes of the battery is not counted."""
    points: Array | None = None
    """Ends of the legs, in turn, of ``count``; else empty; shape (2, m) [m]."""
    capture: float = 0.0
    """Distance of the dead reckoning from the point at which a leg ends [m]."""
    time_out: float = float("inf")
    """Time after which the vehicle gives the transit up [s]."""
    reserve: float = 0.0
    """Share of the battery's energy with which left it gives up."""
    corrects: bool = False
    """Whether the vehicle itself aims off by the drift of its last leg; else not at all."""

    def at_surface(self, until_fix: Scalars) -> Scalars:
        """Return the time at the surface after a leg [s], where a fix takes `until_fix` to come."""
        if self.surface_time is not None:
            return self.surface_time
        return np.minimum(until_fix, self.fix_wait) + self.key_wait

    def without_fix(self, until_fix: Scalars) -> NDArray[np.bool_]:
        """Return the trials whose fixes come too late."""
        return np.atleast_1d(until_fix > (self.fix_wait if self.surface_time is None else self.surface_time))


class ExecutedLegLoop(LegLoop):
    """The loop of legs by the rules of an `Execution`; whether a trial arrived is for `arrived` to say."""

    def __init__(
        self,
        execution: Execution,
        plan: TransitPlan,
        state: TrialState,
        normals: TransitNormals,
        environment: Environment,
        tracked: int,
    ) -> None:
        at_surface = execution.at_surface(plan.surfacing_time)
        super().__init__(replace(plan, surfacing_time=at_surface), state, normals, environment, tracked)
        self.execution, self._number = execution, 0
        self._captured = np.zeros(state.trials, dtype=bool)
        self._lost = np.broadcast_to(execution.without_fix(plan.surfacing_time), state.trials)
        if self._lost.any() and self._fix is self._x:
            self._fix = self._x.copy()
        self._steered = np.zeros((2, state.trials))
        self._for_holding = np.maximum(at_surface - plan.surfacing_time, 0.0) if execution.holds else 0.0

    def _point(self) -> Array:
        """End of the leg, relative to the goal, shape (2, 1) or (2, n) [m]."""
        rule = self.execution
        point = rule.aim if rule.points is None else rule.points[:, min(self._number, rule.points.shape[1] - 1)]
        return column(point) - self._goal

    @override
    def _nominal(self) -> tuple[Array, Array]:
        """Leg and its length, zero for a trial that is not under way."""
        rule, course = self.execution, self._point() - self._fix
        left = length_of(course)
        whole = np.maximum(left - rule.capture, 0.0)
        self._captured = whole <= rule.interval
        length = np.minimum(whole, rule.interval)
        if self._moving is not None:
            length *= self._moving
        self._steered = course * (length / np.maximum(left, 1e-300))
        return length, self._steered

    @override
    def _surface(self, number: int) -> Array:
        reckoned = self._fix + self._steered
        surfaced = super()._surface(number)
        if self.execution.holds:  # the drift that is made good is that of all the time at the surface
            back = self._point() - self._fix
            reach = self._plan.speed * self._for_holding / np.maximum(length_of(back), 1e-300)
            back = back * np.minimum(reach, 1.0)
            if self._moving is not None:
                back = back * self._moving
            self._x, self._fix = self._x + back, self._fix + back
        if not self._lost.any():
            return surfaced
        self._fix = np.where(self._lost, reckoned, self._fix)
        return np.where(self._lost, reckoned, surfaced)

    @override
    def _far_from_goal(self) -> NDArray[np.bool_]:
        self._number += 1
        far: NDArray[np.bool_]
        if self.execution.points is not None:
            far = np.full(self._left.shape, self._number < self.execution.points.shape[1])
        else:
            far = ~self._captured if self.execution.ends == "reckoning" else super()._far_from_goal()
        return far & ~self._gave_up(self._now() - self._clock)

    def _gave_up(self, duration: Array) -> NDArray[np.bool_]:
        """Trials that have run out of time, or have surfaced in vain."""
        late: NDArray[np.bool_] = np.asarray(duration > self.execution.time_out)
        return late | (self._lost & (duration > 0.0)) if self.execution.aborts else late

    @override
    def _is_droppable(self) -> bool:
        return False

    @property
    def plan(self) -> TransitPlan:
        """The plan with the time that the vehicle stays at the surface."""
        return self._plan

    def arrived(self, duration: Array) -> NDArray[np.bool_]:
        """Trials that end within the radius, by where they truly are if they have no fix of it, in time."""
        off = np.where(self._lost, length_of(self._x), self._left)
        return (off < self._plan.arrival_radius) & ~self._gave_up(duration)
