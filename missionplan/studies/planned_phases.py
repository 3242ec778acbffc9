"""Planned phases: nominal legs, what trials tell of them, which interval stands for a table of legs; moorings."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.errors import InputError, Problem
from missionplan.exporters import Executes
from missionplan.mission.schema.phases import LegTableSection, MoorPhase, TransitPhase
from missionplan.mission.schema.place import to_geographic
from missionplan.montecarlo.distributions import Distribution, Quantity, mean_of
from missionplan.montecarlo.streams import BlockStreams
from missionplan.phases.transit import transit
from missionplan.phases.transit.plan import Execution, LegTable
from missionplan.results.plan import PlannedMooring, PlannedTransit, SurfacingRule
from missionplan.results.plan_places import Waypoint, WaypointKind
from missionplan.scenario.phases import deployed, transit_normals
from missionplan.scenario.scenario import Scenario, leg_table
from missionplan.studies.leg_length import SweepScenario
from missionplan.studies.leg_length.paired_trials import PILOT_BLOCK, LegsAtSpeed, expected_cost, run_plans

TRIALS = 1024
"""Trials from which the 99 % durations are taken, and on which a table and intervals are compared."""
SHARE = 0.99
_MOST_POINTS = 2_000_000
"""Points of tracks that are kept at once, which bounds the memory."""
SHORTEST_LEG = 1e-3
"""A leg that is shorter is none [m]."""
ENOUGH = 0.99
"""Share of the trials that have arrived, after which a vehicle that cannot decide for itself makes no further legs."""
MOST_EXTRA_LEGS = 4


@dataclass(frozen=True)
class TransitDurations:
    """Durations that 99 % of the trials keep."""

    legs: Array
    """Under way, by the number of the leg, of the trials that sail it, shape (m,) [s]."""
    whole: float
    """Of the trials that arrive, from the first dive to the fix on arrival; nan where none does [s]."""
    arrived: float
    """Share of the trials that arrive."""
    surface_drift: Array
    """Mean drift at the surface after the last leg, shape (2,) [m]."""

    def leg(self, number: int) -> float:
        """Duration of a leg, from 0; that of the longest leg where no trial needed so many [s]."""
        if number < len(self.legs):
            return float(self.legs[number])
        return float(self.legs.max()) if len(self.legs) else float("nan")


def transit_durations(
    means: Scenario,
    phase: TransitPhase[Scalars],
    start: Array,
    begins: float,
    seed: int,
    execution: Execution | None = None,
) -> TransitDurations:
    """Sail a transit alone, from its nominal start.

    `means`: the mission at its means. `start`, shape (2,): [m]. `begins`: mission time of the first dive [s].
    `execution`: of the vehicle, by other rules than the plan's; its time-out is left out.
    """
    trials = min(TRIALS, max(_MOST_POINTS // means.navigation.max_legs, 1))
    drawn = means.sampled(seed=seed, block=0, size=trials)
    if execution is not None:
        execution = replace(execution, time_out=float("inf"))
        drawn = replace(drawn, executions={phase.name: execution})
    source = BlockStreams(seed, 0)
    state = replace(deployed(drawn, phase, start, source, trials), clock=np.full(trials, begins))
    normals = transit_normals(drawn, phase, source)
    with np.errstate(all="ignore"):  # a trial that cannot be computed has no duration
        plan, environment = drawn.transit_plan(phase), drawn.environment(phase)
        _, record = transit(plan, state, normals, environment, tracked=trials, execution=execution)
    time = record.track_time if record.track_time is not None else np.empty((1, trials))
    legs = time[1::2] - time[:-1:2]
    arrived = record.duration[record.arrived & np.isfinite(record.duration)]
    return TransitDurations(
        legs=np.array([np.quantile(leg[np.isfinite(leg)], SHARE) for leg in legs if np.isfinite(leg).any()]),
        whole=float(np.quantile(arrived, SHARE)) if arrived.size else float("nan"),
        arrived=arrived.size / trials,
        surface_drift=_last_drift(record.track),
    )


def _last_drift(track: Array | None) -> Array:
    """Mean over the trials of the drift at the surface after each one's last leg, shape (2,) [m]."""
    if track is None or track.shape[1] < 3:
        return np.zeros(2)
    drift = track[:, 2::2] - track[:, 1:-1:2]
    legs = np.isfinite(drift[0]).sum(axis=0)
    last = drift[:, np.maximum(legs - 1, 0), np.arange(drift.shape[2])]
    return np.asarray(last[:, legs > 0].mean(axis=1) if np.any(legs) else np.zeros(2))


SingleInterval = tuple[float, float, float]
"""Length of an interval in place of a table [m], and mean time of a transit beyond that by the table, of the trials
that arrive by both, with its standard error [s]."""


def single_interval(means: Scenario, phase: TransitPhase[Scalars], legs: LegTable, seed: int) -> SingleInterval:
    """Find the d_max of the mission's grid that costs least, and what it costs beyond the transit's table.

    It is chosen by the rule of `sweep-dmax`: of those that arrive as often as the mission requires the one of least
    time, and where none does, with failures counted.

    Raises InputError when the transit cannot be swept: the drift is as fast as the vehicle, or the energy does not
    suffice.
    """
    mission = means.mission
    swept = mission.model_copy(update={"sweep": mission.sweep.model_copy(update={"phase": phase.name})})
    scenario = SweepScenario.of(swept, means)
    candidates = [float(length) for length in scenario.d_max]
    plans = [LegsAtSpeed(legs), *(LegsAtSpeed(length) for length in candidates)]
    table, *single = run_plans(scenario, plans, seed, PILOT_BLOCK, TRIALS)
    scores = [expected_cost(trials, scenario.required_arrival, trials.duration) for trials in single]
    best = min(range(len(single)), key=scores.__getitem__)
    both = single[best].arrived & table.arrived
    extra = single[best].duration[both] - table.duration[both]
    mean, error = (extra.mean(), extra.std() / np.sqrt(extra.size)) if extra.size else (np.nan, np.nan)
    return candidates[best], float(mean), float(error)


class PhaseBuilder:
    """Goes through the phases of a mission at its means, with the place and the time in between."""

    def __init__(self, means: Scenario, seed: int, executes: Executes | None) -> None:
        self.means, self._seed, self._executes = means, seed, executes
        self._place, self._elapsed = np.zeros(2), 0.0
        self.notes: list[str] = []

    def phases(self) -> Iterator[PlannedTransit | PlannedMooring]:
        """Yield each phase as planned, and note what is left out."""
        for phase in self.means.drawn.phases:
            if isinstance(phase, TransitPhase):
                yield self._transit(phase)
            elif isinstance(phase, MoorPhase):
                yield self._mooring(phase)
            else:
                self.notes.append(f"{phase.label}, slowing down to hover, is no part of the course and is left out")

    def _transit(self, phase: TransitPhase[Scalars]) -> PlannedTransit:
        means = self.means
        if phase.start is not None:
            self._place = means.position(phase.start)
        start, begins = self._place, self._elapsed

        def sail(execution: Execution | None = None) -> TransitDurations:
            return transit_durations(means, phase, start, begins, self._seed, execution)

        durations = sail()
        waypoints = tuple(self._waypoints(phase, durations))
        self._elapsed += float(means.surfacing_time) if len(waypoints) > 1 else 0.0
        planned = PlannedTransit(
            name=phase.label,
            depth=float(phase.depth),
            speed=float(phase.speed),
            arrival_radius=float(phase.arrival_radius),
            surfacing=self._rule(phase),
            waypoints=waypoints,
            duration_p99=durations.whole,
        )
        if self._executes is None or len(waypoints) < 2:
            return planned
        aim = self._place - durations.surface_drift
        latitude, longitude = self._on_earth(aim)
        east, north = (float(part) for part in aim)
        aimed = replace(waypoints[-1], east=east, north=north, latitude=latitude, longitude=longitude)
        return _sailed_by_its_vehicle(replace(planned, aim=aimed), self._executes, sail)

    def _waypoints(self, phase: TransitPhase[Scalars], durations: TransitDurations) -> Iterator[Waypoint]:
        """Yield the start and the ends of the nominal legs (Briggs et al., Eqs. 18–20); moves on in place and time."""
        yield self._waypoint(f"{phase.label} 0", "start", math.nan, 0.0, (0.0, math.nan))
        done, goal = 0, self.means.position(phase.to)
        for target in (*self.means.ways(phase), goal):
            for leg in self._straight(phase, durations, target, done):
                done += 1
                at_point = leg.kind == "arrival"
                kind: WaypointKind = "arrival" if target is goal and at_point else "surfacing"
                yield replace(leg, kind=kind, is_via=at_point and target is not goal)

    def _straight(
        self, phase: TransitPhase[Scalars], durations: TransitDurations, goal: Array, done: int
    ) -> Iterator[Waypoint]:
        """Yield the ends of the nominal legs straight to a point, counted on from those already done."""
        means, plan = self.means, self.means.transit_plan(phase)
        vector = goal - self._place
        left = float(np.hypot(*vector))
        towards = vector / left if left > 0.0 else vector
        for number in range(done, done + plan.max_legs):
            if left < SHORTEST_LEG:
                break
            length = (
                float(leg_table(phase.d_max)(np.array(left)))
                if isinstance(phase.d_max, LegTableSection)
                else min(left, float(phase.d_max))
            )
            left = max(left - length, 0.0)
            nominal = float(plan.time_under_way(np.array(length), np.array(1.0)))
            self._place = goal - left * towards
            self._elapsed += nominal + (float(means.surfacing_time) if number else 0.0)
            kind: WaypointKind = "surfacing" if left >= SHORTEST_LEG else "arrival"
            course = math.atan2(towards[0], towards[1]) % (2.0 * math.pi)
            yield self._waypoint(f"{phase.label} {number + 1}", kind, course, length, (nominal, durations.leg(number)))
        if left >= SHORTEST_LEG:
            message = (
                f"given {plan.max_legs}, but {phase.label} is {left:.4g} m from its goal after so many nominal legs"
            )
            raise InputError([Problem(message, means.mission.file, key="navigation.max_legs")])
        self._place = goal

    def _waypoint(
        self, name: str, kind: WaypointKind, course: float, length: float, durations: tuple[float, float]
    ) -> Waypoint:
        latitude, longitude = self._on_earth(self._place)
        return Waypoint(
            name=name,
            kind=kind,
            east=float(self._place[0]),
            north=float(self._place[1]),
            latitude=latitude,
            longitude=longitude,
            course=course,
            length=length,
            duration=durations[0],
            duration_p99=durations[1],
            elapsed=self._elapsed,
        )

    def _rule(self, phase: TransitPhase[Scalars]) -> SurfacingRule:
        means, table = self.means, phase.d_max
        interval, extra, error = (
            self._single(phase, table) if isinstance(table, LegTableSection) else (float(table), 0.0, 0.0)
        )
        plan, time = means.transit_plan(phase), means.navigation.surfacing_time
        return SurfacingRule(
            interval=interval,
            interval_time=float(plan.time_under_way(np.array(interval), np.array(1.0))),
            surface_time=mean_of(time),
            surface_time_p99=_p99(time),
            table=table.table if isinstance(table, LegTableSection) else (),
            extra_time=extra,
            extra_time_error=error,
        )

    def _single(self, phase: TransitPhase[Scalars], table: LegTableSection) -> SingleInterval:
        try:
            return single_interval(self.means, phase, leg_table(table), self._seed)
        except InputError as error:
            reason = error.problems[0].message
            self.notes.append(f"{phase.label}: no interval in place of the table could be compared with it ({reason})")
            return max(length for _, length in table.table), math.nan, math.nan

    def _mooring(self, phase: MoorPhase[Scalars]) -> PlannedMooring:
        means, site = self.means, self.means.drawn.site
        latitude, longitude = self._on_earth(self._place)
        weight = phase.anchor_wet_weight
        begun = self._elapsed
        (written,) = (moor for moor in means.mission.moors if moor.name == phase.name)
        *on_bottom, release = phase.times_moored
        self._elapsed += float(sum((phase.release_time, *on_bottom, release)) + means.surfacing_time)
        return PlannedMooring(
            name=phase.label,
            east=float(self._place[0]),
            north=float(self._place[1]),
            latitude=latitude,
            longitude=longitude,
            radius=float(phase.radius),
            water_depth=math.nan if site is None or site.depth is None else float(site.depth),
            line_length=float(phase.line_length),
            anchor_wet_weight=math.nan if isinstance(weight, str) else float(weight),
            release_time=float(phase.release_time),
            release_time_p99=_p99(written.release_time),
            hold=float(sum(on_bottom)),
            galvanic_release=float(release),
            elapsed=begun,
            surface_time_p99=_p99(means.navigation.surfacing_time) if means.mission.navigation else 0.0,
        )

    def _on_earth(self, place: Array) -> tuple[float, float]:
        site = self.means.mission.site
        if site is None or site.origin is None:
            return math.nan, math.nan
        latitude, longitude = to_geographic(place[:1], place[1:], site.origin)
        return float(latitude[0]), float(longitude[0])


def _sailed_by_its_vehicle(
    planned: PlannedTransit, executes: Executes, sail: Callable[[Execution], TransitDurations]
) -> PlannedTransit:
    """Give a transit as many legs after the nominal ones as its vehicle needs, and durations by its rules."""
    extra, durations = 0, sail(executes(planned))
    if executes(planned).ends == "count":
        tried = [durations]
        while tried[-1].arrived < ENOUGH and len(tried) <= MOST_EXTRA_LEGS:
            tried.append(sail(executes(replace(planned, extra_legs=len(tried)))))
        extra = max(range(len(tried)), key=lambda number: tried[number].arrived)
        durations = tried[extra]
    return replace(
        planned,
        extra_legs=extra,
        duration_p99=durations.whole,
        waypoints=tuple(
            replace(point, duration_p99=durations.leg(number - 1)) if number else point
            for number, point in enumerate(planned.waypoints)
        ),
    )


def _p99(quantity: Quantity) -> float:
    return quantity.quantile(SHARE) if isinstance(quantity, Distribution) else float(quantity)
