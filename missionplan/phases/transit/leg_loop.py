"""The legs of a transit, for a block of trials at once: the inner loop, written for speed.

Positions are relative to the goal. Arrays are updated in place, what a mission does not use is skipped, and trials that
have arrived are dropped from the arrays once they are half of them.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array, Normals, Scalars, take_trials
from missionplan.phases.hooks import TrialState
from missionplan.phases.place import Contact, Lookout, Way
from missionplan.phases.transit.compensation import Compensation, CompletedLeg, Memory, PlannedLeg
from missionplan.phases.transit.ground_velocity import GroundVelocity, leg_normals
from missionplan.phases.transit.plan import Environment, LegTable, LegTables, TransitNormals, TransitPlan, column

FARTHEST = 2e7
"""Half the Earth's circumference: a vehicle that a model carries farther from its goal is left there [m]."""
_MIN_TRIALS_TO_DROP = 256  # with fewer, dropping the arrived ones costs more than it saves


class FinalState(NamedTuple):
    """Totals and positions of all trials after the last leg, relative to the goal; shapes (n,) and (2, n)."""

    distance: Array
    surfacings: Array
    position: Array
    fix: Array
    under_way: NDArray[np.bool_]
    outrun: NDArray[np.bool_]
    left_record: NDArray[np.bool_]
    cause: NDArray[np.int8]
    leg: NDArray[np.int64]
    where: Array
    nearest: Array

    @property
    def contact(self) -> Contact:
        """What each trial met first."""
        return Contact(self.cause, self.leg, self.where, self.nearest)


class _Aim(NamedTuple):
    """A leg as it was aimed: start [s], fix on diving, nominal end and aim; the last two relative to the goal [m]."""

    t: Array
    dived: Array
    nominal_end: Array
    aim: Array


class LegLoop:
    """Trials under way: `run` takes them through one leg after the other, `final_state` returns all of them."""

    def __init__(
        self, plan: TransitPlan, state: TrialState, normals: TransitNormals, environment: Environment, tracked: int
    ) -> None:
        self._plan, self._normals, self._compensation = plan, normals, environment.compensation
        self._ground_velocity = GroundVelocity(plan, environment, normals, state.trials)
        self._fix_sd = self._ground_velocity.fix_sd()
        self._has_fix_error = bool(np.any(self._fix_sd))
        self._is_still = environment.is_still
        self._keeps_all = tracked > 0
        self._goal, self._clock = column(plan.goal), state.clock
        self._trials: NDArray[np.intp] | int = state.trials  # all of the block, or which of it
        self._rows: NDArray[np.intp] | int = state.trials if normals.rows is None else normals.rows
        self._x = state.position - self._goal
        # without fix errors the fix is the true position: the same array
        exact = not self._has_fix_error and np.array_equal(state.position, state.fix)
        self._fix = self._x if exact else state.fix - self._goal
        self._left = length_of(self._fix)
        self._distance, self._surfacings = np.zeros(state.trials), np.zeros(state.trials)
        self._done: FinalState | None = None  # of all trials, once some were dropped
        self._memory: Memory = self._compensation.begin(state.trials) if self._compensation else ()
        self._legs_begun = None if plan.length_lost is None else 0.0 * self._distance
        self._moving: Array | None = None  # 1 for a trial under way, 0 for one that is not; None while all are
        self._lookout = Lookout.over(environment.place, state.trials) if environment.place else None
        self._count = state.trials  # trials under way
        self._set_moving(state.alive & (self._left >= plan.arrival_radius))
        self._tracked = tracked
        self._track: list[Array] = []
        self._track_time: list[Array] = []
        self._mark(self._moving)
        self._allocate()

    @property
    def all_arrived(self) -> bool:
        """Whether no trial is under way."""
        return self._count == 0

    def run(self, number: int) -> None:
        """Run leg `number`, from 0, to the fix on diving after it."""
        moving = self._moving
        length, course = self._nominal()
        aim = None
        if self._compensation is not None:
            length, aim = self._aim_off(self._compensation, length, course)
        begun = None if self._lookout is None else (self._x + self._goal, self._now())
        self._move(number, length, course)
        self._distance += length
        if self._legs_begun is not None:
            self._legs_begun += 1.0 if moving is None else moving
        begun = self._look_out(number, begun, self._plan.depth)
        self._mark(moving)
        surfaced = self._surface(number)
        self._surfacings += 1.0 if moving is None else moving
        self._look_out(number, begun, 0.0)
        self._mark(moving)
        if self._compensation is not None and aim is not None:
            duration = self._duration(length, moving)
            error = (surfaced - aim.aim) / np.where(duration > 0.0, duration, 1.0)
            leg = CompletedLeg(
                error, duration, self._fix - surfaced, self._fix - aim.nominal_end, aim.t, aim.dived, course
            )
            self._memory = self._compensation.update(self._memory, leg)
        self._check_arrival()

    def final_state(self) -> FinalState:
        """Return the final state of all trials of the block."""
        moved = self._ground_velocity
        met = Contact.none(self._left.size) if self._lookout is None else self._lookout.contact
        now = FinalState(
            self._distance,
            self._surfacings,
            self._x,
            self._fix,
            self._far,
            moved.outrun,
            moved.left_record,
            met.cause,
            met.leg,
            met.where,
            met.nearest,
        )
        if self._done is None:
            return now
        for whole, part in zip(self._done, now, strict=True):
            np.asarray(whole)[..., self._trials] = part
        return self._done

    def track(self) -> Array | None:
        """Return the tracks of the first trials; None where none are kept."""
        return np.stack(self._track, axis=1) if self._track else None

    def track_time(self) -> Array | None:
        """Return when the tracked trials were at those points; None where no tracks are kept."""
        return np.stack(self._track_time) if self._track_time else None

    def _allocate(self) -> None:
        trials = self._left.size
        self._length, self._ratio = np.empty(trials), np.empty(trials)
        self._course, self._error = np.empty((2, trials)), np.empty((2, trials))

    def _nominal(self) -> tuple[Array, Array]:
        """Nominal leg ℓ′ and its length (Eqs. 18–20), zero for a trial that is not under way."""
        d_max, length, ratio, course = self._plan.d_max, self._length, self._ratio, self._course
        if isinstance(d_max, LegTable | LegTables):
            length[...] = d_max(self._left)
        else:
            np.minimum(self._left, d_max, out=length)
        if self._moving is not None:
            length *= self._moving
            np.maximum(self._left, 1e-300, out=self._left)  # a trial that has arrived may be on the goal
        np.divide(length, self._left, out=ratio)
        np.multiply(self._fix, ratio, out=course)
        np.negative(course, out=course)
        return length, course

    def _aim_off(self, compensation: Compensation, length: Array, course: Array) -> tuple[Array, _Aim]:
        """Adjust the nominal course in place (Eq. 22); return its length and how it was aimed."""
        nominal_end, dived, t = self._fix + course, self._fix + self._goal, self._now()
        duration, radius = self._duration(length, self._moving), self._plan.arrival_radius
        offset = compensation.offset(self._memory, PlannedLeg(t, dived, course, duration, self._goal, radius))
        course -= offset if self._moving is None else offset * self._moving
        return length_of(course), _Aim(t, dived, nominal_end, self._fix + course)

    def _move(self, number: int, length: Array, course: Array) -> None:
        """Move along `course` through the water, and over the ground with the velocity error and the current."""
        error, speed = self._plan.velocity_error, self._plan.speed
        normals = leg_normals(self._normals.velocity, self._normals.first + number, self._rows)
        if self._is_still and error.is_plain and self._legs_begun is None:
            np.multiply(length, error.root[0, 0] / speed, out=self._ratio)
            np.multiply(normals, self._ratio, out=self._error)
        else:
            duration, start = self._duration(length, self._moving), self._x + self._goal
            velocity = self._ground_velocity.of_leg(number, normals, self._now(), duration, start, course)
            np.multiply(velocity, duration, out=self._error)
        self._error += course
        self._x += self._error

    def _surface(self, number: int) -> Array:
        """Surface, drift and take both fixes; return the fix on surfacing relative to the goal."""
        surfaced = self._x
        if self._has_fix_error:
            surfaced = self._x + self._fix_sd * self._fix_noise(self._normals.fix_on_surfacing, number)
        elif not self._is_still and self._compensation is not None:
            surfaced = self._x.copy()
        if not self._is_still:
            velocity = self._ground_velocity.at_surface(self._now(), self._x + self._goal, self._moving)
            carried = velocity * self._plan.surfacing_time
            self._x += carried if self._moving is None else carried * self._moving
        if self._fix is self._x:
            return surfaced
        fix = self._x
        if self._has_fix_error:
            fix = self._x + self._fix_sd * self._fix_noise(self._normals.fix_on_diving, number)
        if self._moving is None:
            self._fix = fix if self._has_fix_error else fix.copy()
        else:
            np.copyto(self._fix, fix, where=self._moving > 0.0)
        return surfaced

    def _look_out(self, number: int, begun: tuple[Array, Array] | None, depth: Scalars) -> tuple[Array, Array] | None:
        """See what the trials met since a place and time, at a depth, and stop them there; where and when they are."""
        if self._lookout is None or begun is None:
            return None
        place, now = self._x + self._goal, self._now()
        self._lookout.watch(number + 1, Way(begun[0], place, begun[1], now, depth, depth), self._moving)
        stopped = self._lookout.contact.met
        if stopped.any():
            self._x[:, stopped] = (self._lookout.contact.where - self._goal)[:, stopped]
        return place, now

    def _fix_noise(self, source: Normals | None, number: int) -> Array:
        if source is None:
            raise ValueError("fixes have errors: TransitNormals needs fix_on_surfacing and fix_on_diving")
        return leg_normals(source, self._normals.first + number, self._rows)

    def _check_arrival(self) -> None:
        """Find who has arrived by the fix on diving, and drop those trials from the arrays once they are many."""
        np.multiply(self._fix, self._fix, out=self._error)
        np.add(self._error[0], self._error[1], out=self._left)
        np.sqrt(self._left, out=self._left)
        if self._left.max(initial=0.0) > FARTHEST:
            self._hold_back(self._left > FARTHEST)
        far = self._far_from_goal()
        if self._moving is not None:
            far &= self._moving > 0.0
        if self._lookout is not None and (stopped := self._lookout.contact.met).any():
            far &= ~stopped
        self._set_moving(far)
        if not self._keeps_all and 2 * self._count <= far.size and far.size > _MIN_TRIALS_TO_DROP:
            self._drop_all_but(np.flatnonzero(far))

    def _far_from_goal(self) -> NDArray[np.bool_]:
        return np.asarray(self._left >= self._plan.arrival_radius)

    def _hold_back(self, lost: NDArray[np.bool_]) -> None:
        """Put trials back to the farthest place: a current that grows with the distance carries them without end."""
        self._fix[:, lost] *= FARTHEST / self._left[lost]
        self._x[:, lost] = self._fix[:, lost]
        self._left[lost] = FARTHEST

    def _set_moving(self, moving: NDArray[np.bool_]) -> None:
        self._far = moving
        count = int(np.count_nonzero(moving))
        if count != self._count:
            self._count, self._moving = count, moving.astype(float)

    def _drop_all_but(self, kept: NDArray[np.intp]) -> None:
        self._done = self.final_state()
        is_exact = self._fix is self._x
        self._trials = kept if isinstance(self._trials, int) else self._trials[kept]
        self._rows = kept if isinstance(self._rows, int) else self._rows[kept]
        self._x = self._x[:, kept]
        self._fix = self._x if is_exact else self._fix[:, kept]
        self._left, self._clock = self._left[kept], self._clock[kept]
        self._goal = take_trials(self._goal, kept, alike=True)
        self._distance, self._surfacings = self._distance[kept], self._surfacings[kept]
        self._legs_begun = None if self._legs_begun is None else self._legs_begun[kept]
        self._memory = tuple(array[..., kept] for array in self._memory)
        self._plan = self._plan.take(kept)
        self._lookout = None if self._lookout is None else self._lookout.take(kept)
        self._ground_velocity = self._ground_velocity.take(self._plan, kept)
        self._fix_sd = take_trials(self._fix_sd, kept, alike=True)
        self._moving, self._far = None, np.ones(kept.size, dtype=bool)
        self._allocate()

    def _duration(self, length: Array, moving: Array | None) -> Array:
        """Time that a leg takes, acceleration from rest included [s]."""
        lost = self._plan.length_lost
        if lost is None:
            return length / self._plan.speed
        return (length + (lost if moving is None else lost * moving)) / self._plan.speed

    def _now(self) -> Array:
        """Time since the mission's start [s]."""
        legs = self._legs_begun if self._legs_begun is not None else self._surfacings
        under_way = self._plan.time_under_way(self._distance, legs)
        return self._clock + under_way + self._surfacings * self._plan.surfacing_time

    def _mark(self, moving: Array | None) -> None:
        """Record where the tracked trials are and when, nan for those that have arrived."""
        if not self._tracked:
            return
        place = self._x[:, : self._tracked] + self._goal[:, : self._tracked]
        time = np.array(np.broadcast_to(self._now(), self._left.shape)[: self._tracked])
        if self._track and moving is not None:
            ended = moving[: self._tracked] == 0.0
            place[:, ended] = np.nan
            time[ended] = np.nan
        self._track.append(place)
        self._track_time.append(time)


def length_of(vectors: Array) -> Array:
    """Lengths of vectors, shape (2, n); faster than hypot, whose protection from overflow is not needed here."""
    length: Array = np.sqrt(vectors[0] * vectors[0] + vectors[1] * vectors[1])
    return length
