"""A transit as a vehicle carries it out whose format cannot hold the plan's own rules: the loop of legs, changed.

The plan's rules are those of `LegLoop`: legs of at most d_max for the goal, aimed off as the mission compensates for
drift, and arrival where the fix on diving lies within the radius. A vehicle by another rule may take the point for
reached when its dead reckoning is near it, go through fixed points, or end after a fixed number of legs, wherever that
is.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from missionplan.arrays import Array
from missionplan.phases.state import TrialState
from missionplan.phases.transit.leg_loop import LegLoop, length_of
from missionplan.phases.transit.plan import Environment, TransitNormals, TransitPlan, column


@dataclass(frozen=True)
class Execution:
    """What a vehicle does with a transit.

    Attributes
    ----------
    ends : {"fix", "reckoning", "count"}
        The transit ends when the fix on diving lies within the arrival radius of the goal; on surfacing after the dead
        reckoning came within `capture` of the aim; after the legs to all of `points`.
    aim : array, shape (2,) or (2, n)
        Point that legs steer for, east and north of the coordinates' origin [m].
    interval : float
        Greatest length of a leg [m].
    surface_time : float or None
        At the surface after each leg, where the vehicle waits for a fixed time instead of for the fix [s].
    points : array, shape (2, m)
        Ends of the legs, in turn, of ``count``; else empty [m].
    capture : float
        Distance of the dead reckoning from the point at which a leg ends [m].
    time_out : float
        Time after which the vehicle gives the transit up [s].
    corrects : bool
        Whether the vehicle itself aims off by the drift of its last leg; else not at all.
    return_time : float
        For which it goes on to the leg's end at the surface once it has a fix, within its time there [s]. What that
        takes of the battery is not counted.
    """

    ends: Literal["fix", "reckoning", "count"]
    aim: Array
    interval: float = float("inf")
    surface_time: float | None = None
    points: Array | None = None
    capture: float = 0.0
    time_out: float = float("inf")
    corrects: bool = False
    return_time: float = 0.0


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
        super().__init__(plan, state, normals, environment, tracked)
        self.execution, self._number = execution, 0
        self._captured = np.zeros(state.trials, dtype=bool)

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
        return length, course * (length / np.maximum(left, 1e-300))

    @override
    def _surface(self, number: int) -> Array:
        surfaced = super()._surface(number)
        if self.execution.return_time > 0.0:
            back = self._point() - self._fix
            reach = self._plan.speed * self.execution.return_time / np.maximum(length_of(back), 1e-300)
            back = back * np.minimum(reach, 1.0)
            if self._moving is not None:
                back = back * self._moving
            self._x, self._fix = self._x + back, self._fix + back
        return surfaced

    @override
    def _far_from_goal(self) -> NDArray[np.bool_]:
        self._number += 1
        if self.execution.points is not None:
            return np.full(self._left.shape, self._number < self.execution.points.shape[1])
        return ~self._captured if self.execution.ends == "reckoning" else super()._far_from_goal()

    @override
    def _is_droppable(self) -> bool:
        return False

    def arrived(self, duration: Array) -> NDArray[np.bool_]:
        """Trials whose last fix lies within the radius, in time."""
        return (self._left < self._plan.arrival_radius) & (duration <= self.execution.time_out)
