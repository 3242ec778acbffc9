"""Transit by dead reckoning in legs, with fixes at the surface between them: Briggs et al., section IV, Eqs. 18–24.

A leg of at most d_max aims at the target (Eqs. 18–20), or off it by the drift that the vehicle expects
(Eqs. 21–23, see `compensation`). Its velocity error is drawn once (Eq. 24). At its end the vehicle surfaces, takes a
fix, drifts with the surface layer for the surfacing time, and takes a fix on diving, on which arrival is judged and
from which the next leg starts. Checked against an integral equation (`expectation`) for σ/U from 0.005 to 0.4.

Read first `plan` (parameters and record), then `leg_loop` and `ground_velocity`. Without Monte Carlo: `rice_panels`
(the quadrature), `expectation` (the cost) and `policy` (optimal legs by dynamic programming).
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from missionplan.arrays import Array
from missionplan.phases.hooks import TrialState
from missionplan.phases.place import Contact
from missionplan.phases.transit.leg_loop import LegLoop, length_of
from missionplan.phases.transit.plan import Environment, Execution, TransitNormals, TransitPlan, TransitRecord, column


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
        self.execution, self._number, self._keeps_all = execution, 0, True
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

    @property
    def plan(self) -> TransitPlan:
        """The plan with the time that the vehicle stays at the surface."""
        return self._plan

    def arrived(self, duration: Array) -> NDArray[np.bool_]:
        """Trials that end within the radius, by where they truly are if they have no fix of it, in time."""
        off = np.where(self._lost, length_of(self._x), self._left)
        return (off < self._plan.arrival_radius) & ~self._gave_up(duration)


def transit(
    plan: TransitPlan,
    state: TrialState,
    normals: TransitNormals,
    environment: Environment | None = None,
    *,
    tracked: int = 0,
    execution: Execution | None = None,
) -> tuple[TrialState, TransitRecord]:
    """Take a block of trials through a transit.

    Trials that have failed before stay where they are and do not arrive; trials that start within the arrival radius
    have arrived without a leg. A trial that meets ground, land or a zone stops there. A point of `plan.via` is reached
    as the goal is, before the way to the next begins; what the vehicle has learned of the drift begins anew there.

    Parameters
    ----------
    state : TrialState
        At the fix before the first dive.
    environment : Environment, optional
        Default: still water, no compensation, no effects.
    tracked : int
        Number of trials, the first ones, whose tracks are kept.
    execution : Execution, optional
        Of a vehicle that goes by other rules than the plan's.

    Returns
    -------
    state, record : TrialState, TransitRecord
    """
    around = environment or Environment()
    if not plan.via or (execution is not None and execution.points is not None):  # those on the way are among them
        return _to_goal(plan, state, normals, around, tracked, execution)
    records: list[TransitRecord] = []
    for number, goal in enumerate((*plan.via, plan.goal)):
        part, later = replace(plan, goal=goal, via=()), replace(normals, first=number * plan.max_legs)
        state, record = _to_goal(part, state, later, around, tracked, _towards(execution, plan, goal))
        records.append(record)
    return state, _joined(records, state, plan)


def _towards(execution: Execution | None, plan: TransitPlan, goal: Array) -> Execution | None:
    """Aim off a point on the way as the goal is aimed off."""
    if execution is None:
        return None
    return replace(execution, aim=column(execution.aim) + column(goal) - column(plan.goal))


def _to_goal(
    plan: TransitPlan,
    state: TrialState,
    normals: TransitNormals,
    environment: Environment,
    tracked: int,
    execution: Execution | None = None,
) -> tuple[TrialState, TransitRecord]:
    """Take a block of trials straight to the goal."""
    run = plan, state, normals, environment, tracked
    legs = LegLoop(*run) if execution is None else ExecutedLegLoop(execution, *run)
    if isinstance(legs, ExecutedLegLoop):
        plan = legs.plan
    for number in range(plan.max_legs):
        if legs.all_arrived:
            break
        legs.run(number)
    end = legs.final_state()
    under_way, at_surface = plan.time_under_way(end.distance, end.surfacings), end.surfacings * plan.surfacing_time
    energy = under_way * plan.power_under_way + at_surface * plan.power_at_surface
    energy += end.surfacings * plan.surfacing_energy
    lost = end.left_record & ~(end.under_way & end.outrun)  # what cannot stem the current drifts off any record
    current = environment.current
    arrived = state.alive & ~end.under_way & ~end.contact.met
    if isinstance(legs, ExecutedLegLoop):
        arrived &= legs.arrived(under_way + at_surface)
    if current is not None and current.is_binding:
        arrived &= ~lost
    record = TransitRecord(
        duration=under_way + at_surface,
        surfacings=end.surfacings,
        distance=end.distance,
        arrival_error=np.sqrt(end.position[0] ** 2 + end.position[1] ** 2),
        energy=energy,
        arrived=arrived,
        outrun=end.outrun,
        left_record=lost,
        contact=end.contact,
        track=legs.track(),
        track_time=legs.track_time(),
    )
    goal = column(plan.goal)
    clock, used = state.clock + record.duration, state.energy + energy
    return TrialState(end.position + goal, end.fix + goal, clock, used, arrived), record


def _joined(records: Sequence[TransitRecord], end: TrialState, plan: TransitPlan) -> TransitRecord:
    """Join the records of the parts of a way."""
    trials = end.trials
    measured = len(records[0].contact.nearest) > 0
    contact, legs, rows = Contact.none(trials, measured=measured), np.zeros(trials), np.arange(trials)
    for record in records:
        contact.note(rows, record.contact, 0)
        here = record.contact.met
        contact.leg[here] = (record.contact.leg + legs)[here].astype(np.int64)
        legs = legs + record.surfacings
    away = end.position - column(plan.goal)
    track = time = None
    tracked = [
        (record.track[:, min(number, 1) :], record.track_time[min(number, 1) :])
        for number, record in enumerate(records)
        if record.track is not None and record.track_time is not None
    ]
    if tracked:
        tracks, times = zip(*tracked, strict=True)
        track, time = np.concatenate(tracks, axis=1), np.concatenate(times)
        order = np.argsort(np.isnan(time), axis=0, kind="stable")  # a trial's points one after the other, then nan
        time, track = np.take_along_axis(time, order, axis=0), np.take_along_axis(track, order[None], axis=1)
    return TransitRecord(
        duration=sum((record.duration for record in records), start=np.zeros(trials)),
        surfacings=legs,
        distance=sum((record.distance for record in records), start=np.zeros(trials)),
        arrival_error=np.sqrt(away[0] ** 2 + away[1] ** 2),
        energy=sum((record.energy for record in records), start=np.zeros(trials)),
        arrived=records[-1].arrived,
        outrun=np.any([record.outrun for record in records], axis=0),
        left_record=np.any([record.left_record for record in records], axis=0),
        contact=contact,
        track=track,
        track_time=time,
    )
