"""Parameters of a transit: plan, leg lengths as tables, environment, how a vehicle carries it out; and its record."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array, Normals, Scalars, take_trials
from missionplan.phases.currents import Current
from missionplan.phases.hooks import TransitEffect
from missionplan.phases.place import Contact, Place
from missionplan.phases.transit.compensation import Compensation


@dataclass(frozen=True)
class LegTable:
    """Leg length against distance left: linear between knots, held at the ends, never beyond the target (Eq. 19)."""

    left: Array
    """Distance left, increasing, shape (k,) [m]."""
    leg: Array
    """Leg length, positive, shape (k,) [m]."""

    def __call__(self, left: Array) -> Array:
        """Leg length for each distance left [m]."""
        return np.minimum(left, np.interp(left, self.left, self.leg))

    @property
    def kinks(self) -> Array:
        """Distances left at which the leg length changes its slope, ascending [m]."""
        knots = np.concatenate((self.left, [max(self.left[-1], self.leg[-1]) + 1.0]))
        excess = knots - np.interp(knots, self.left, self.leg)
        before, after = excess[:-1], excess[1:]
        crossed = before * after < 0.0
        share = before[crossed] / (before[crossed] - after[crossed])
        crossings = knots[:-1][crossed] + share * np.diff(knots)[crossed]
        below = [self.leg[0]] if 0.0 < self.leg[0] < self.left[0] else []
        return np.unique(np.concatenate((self.left, crossings, below)))


@dataclass(frozen=True)
class LegTables:
    """Several tables, each for some of the trials: what lets many plans of legs run at once."""

    tables: Sequence[LegTable]
    ends: NDArray[np.intp]
    """Trial before which each table's trials end, the next table's begin; increasing; shape (k,)."""

    def __call__(self, left: Array) -> Array:
        """Leg length for each distance left, one per trial [m]."""
        parts = np.split(left, self.ends[:-1])
        return np.concatenate([table(part) for table, part in zip(self.tables, parts, strict=True)])

    def take(self, trials: NDArray[np.intp]) -> "LegTables":
        """Select trials, given in ascending order; tables that are left without trials are dropped."""
        ends = np.searchsorted(trials, self.ends)
        used = np.flatnonzero(np.diff(ends, prepend=0))
        return LegTables([self.tables[index] for index in used.tolist()], ends[used])


@dataclass(frozen=True)
class VelocityError:
    """Velocity error of a leg, N(v̄, Σ_v) (Eq. 24)."""

    mean: Array
    """v̄, east and north, shape (2, 1) or (2, n) [m/s]."""
    root: Array
    """Lower triangular R with R Rᵀ = Σ_v, shape (2, 2, 1) or (2, 2, n) [m/s]."""

    @classmethod
    def isotropic(cls, sigma: Scalars, mean: Array | None = None) -> "VelocityError":
        """Build Σ_v = σ_v² I (Eq. 26); `sigma` a float or an array over trials, `mean` of shape (2,) or (2, n)."""
        root = np.eye(2)[:, :, None] * np.atleast_1d(np.asarray(sigma, dtype=float))
        return cls(column(mean), root)

    @classmethod
    def general(cls, covariance: Array, mean: Array | None = None) -> "VelocityError":
        """Build from Σ_v of shape (2, 2), without negative eigenvalues; `mean` of shape (2,) or (2, n)."""
        (east, both), (_, north) = np.asarray(covariance, dtype=float)
        first = np.sqrt(east)
        across = both / first if first > 0.0 else 0.0
        root = np.array([[first, 0.0], [across, np.sqrt(max(north - across**2, 0.0))]])
        return cls(column(mean), root[:, :, None])

    @cached_property
    def is_isotropic(self) -> bool:
        """Whether Σ_v is a multiple of the identity."""
        return bool(np.all(self.root[1, 0] == 0.0) and np.all(self.root[0, 0] == self.root[1, 1]))

    @cached_property
    def is_plain(self) -> bool:
        """Whether it is isotropic about zero."""
        return self.is_isotropic and not np.any(self.mean)


def column(vector: Array | None) -> Array:
    """Return a vector with trials as its last axis: (2,) becomes (2, 1), None becomes zero."""
    array = np.zeros(2) if vector is None else np.asarray(vector, dtype=float)
    return array[:, None] if array.ndim == 1 else array


@dataclass(frozen=True)
class TransitPlan:
    """Parameters of one transit. Each number may be an array over trials."""

    goal: Array
    """x_f, east and north of the coordinates' origin, shape (2,) or (2, n) [m]."""
    speed: Scalars
    """U, through the water [m/s]."""
    arrival_radius: Scalars
    """r_x [m]."""
    d_max: Scalars | LegTable | LegTables
    """Maximum leg length, or leg length against distance left [m]."""
    surfacing_time: Scalars
    """t_s, at the surface after each leg [s]."""
    velocity_error: VelocityError
    fix_error: Scalars = 0.0
    """Standard deviation of a fix, each axis [m]."""
    depth: Scalars = 0.0
    """Run depth [m]."""
    max_legs: int = 400
    """Legs after which a trial counts as not arrived."""
    power_under_way: Scalars = 0.0
    power_at_surface: Scalars = 0.0
    """Total electrical power then [W]."""
    surfacing_energy: Scalars = 0.0
    """For each surfacing [J]."""
    latitude: float = float("nan")
    """Of the coordinates' origin, for effects [rad]; nan when unknown."""
    length_lost: Scalars | None = None
    """Distance lost while a leg gathers speed from rest, so that it takes (length + length lost)/U [m]; None where the
    vehicle is at speed at once. Legs are assumed to be much longer."""
    via: tuple[Array, ...] = ()
    """Points that are reached one after the other as the goal is, before it, shape (2,) or (2, n) [m]."""

    def take(self, trials: NDArray[np.intp]) -> "TransitPlan":
        """Select trials of those numbers that are arrays over trials; of `LegTables` in ascending order alone."""
        d_max = self.d_max
        if isinstance(d_max, LegTables):
            d_max = d_max.take(trials)
        elif not isinstance(d_max, LegTable):
            d_max = take_trials(d_max, trials, alike=True)
        columns = replace(self, goal=column(self.goal), via=tuple(map(column, self.via)), d_max=0.0)
        return replace(take_trials(columns, trials, alike=True), d_max=d_max)

    def time_under_way(self, distance: Array, legs: Array) -> Array:
        """Time of `legs` legs of a total `distance` through the water, acceleration from rest included [s]."""
        time: Array = distance / self.speed
        return time if self.length_lost is None else time + legs * (self.length_lost / self.speed)

    def nominal_time(self, start: Array) -> Array:
        """Time of the straight courses from a start, shape (2, 1) or (2, n), t_nom = ‖x_f − x_0‖/U [s]."""
        length: Scalars = 0.0
        for point in (*self.via, self.goal):
            length, start = length + np.hypot(*(column(point) - start)), column(point)
        return np.asarray(length / self.speed)

    def cost(self, record: "TransitRecord", nominal: Array) -> Array:
        """Cost c = (t_f − t_nom)/t_nom of each trial (Briggs et al., Eq. 25), the arrival's surfacing not charged.

        Parameters
        ----------
        record : TransitRecord
            Of a transit by this plan.
        nominal : array, shape (n,)
            t_nom [s].
        """
        charged = np.maximum(record.surfacings - 1.0, 0.0) * self.surfacing_time
        return np.asarray((self.time_under_way(record.distance, record.surfacings) + charged) / nominal - 1.0)


@dataclass(frozen=True)
class TransitNormals:
    """Standard normals of a transit, leg by leg."""

    velocity: Normals
    """Of the velocity error."""
    fix_on_surfacing: Normals | None = None
    fix_on_diving: Normals | None = None
    """Required where fixes have errors."""
    effects: Sequence[Normals | None] = ()
    """One per effect; required where the effect is random."""
    rows: NDArray[np.intp] | None = None
    """Which of the normals each trial takes, where several trials share them; default the first n; shape (n,)."""
    first: int = 0
    """Leg of which those of the first leg are, from 0: no leg of a part of a way has those of another part."""


@dataclass(frozen=True)
class Environment:
    """The environment of a transit, with the vehicle's drift compensation."""

    current: Current | None = None
    """The site's; None for still water."""
    compensation: Compensation | None = None
    """None to aim straight at the target."""
    effects: tuple[TransitEffect, ...] = ()
    """Effects that the base model leaves out."""
    place: Place | None = None
    """Ground and coast; None where the mission says nothing of them."""

    @property
    def is_still(self) -> bool:
        """Whether the velocity error alone takes the vehicle off its course."""
        return self.current is None and not self.effects


@dataclass(frozen=True)
class Execution:
    """What a vehicle does with a transit whose format cannot hold the plan's own rules.

    It may take the point for reached when its dead reckoning is near it, go through fixed points, or end after a fixed
    number of legs, wherever that is. It may also go on without a fix that comes too late, by dead reckoning, or give up
    there or after a time. A leg ends when its way through the water is made, which takes the same time in every trial:
    no time-out of a single leg can end it before.
    """

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


@dataclass(frozen=True)
class TransitRecord:
    """Results of a transit, an array of shape (n,) each; for trials that never arrived, up to their last leg."""

    duration: Array
    """From the start to the fix on arrival, its surfacing included [s]."""
    surfacings: Array
    """The arrival's included."""
    distance: Array
    """Through the water [m]."""
    arrival_error: Array
    """True distance from the goal at the end [m]."""
    energy: Array
    """Energy [J]."""
    arrived: NDArray[np.bool_]
    outrun: NDArray[np.bool_]
    """Whether on some leg the current, with the mean velocity error and the effects, was as fast as the vehicle."""
    left_record: NDArray[np.bool_]
    """Whether the trial left the record of the current, but for those that could not stem the current."""
    contact: Contact
    """What of ground, coast and zones each trial met first, where it stopped."""
    track: Array | None = field(default=None, repr=False)
    """True positions of the first k trials: the start, then for each leg where the vehicle surfaced and dived again;
    nan after arrival; shape (2, m, k) [m]."""
    track_time: Array | None = field(default=None, repr=False)
    """Since the mission's start, at the points of the track, shape (m, k) [s]."""
