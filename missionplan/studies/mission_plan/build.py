"""From a mission to its plan: nominal legs, their time-outs, the rule for surfacing, the moorings."""

import hashlib
import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from importlib.metadata import version

import numpy as np

from missionplan.arrays import Array, Scalars
from missionplan.errors import InputError, Problem
from missionplan.exporters.formats import Executes, execution_of, refusals_of
from missionplan.mission import Mission
from missionplan.mission.geodesy import to_geographic
from missionplan.mission.schema.phases import LegTableSection, MoorPhase, TransitPhase
from missionplan.mission.views import TransitMission
from missionplan.montecarlo.distributions import Distribution, Quantity, mean_of
from missionplan.phases.transit.execution import Execution
from missionplan.physics.propulsion import JOULES_PER_WATT_HOUR
from missionplan.results.base import to_yaml
from missionplan.results.plan import Fence, Plan, PlannedMooring, PlannedTransit, SurfacingRule, Waypoint
from missionplan.scenario.scenario import Scenario, leg_table
from missionplan.scenario.site_current import recorded_current
from missionplan.studies.mission_plan.transit_trials import (
    SHARE,
    SingleInterval,
    TransitDurations,
    single_interval,
    transit_durations,
)

SHORTEST_LEG = 1e-3
"""A leg that is shorter is none [m]."""


ENOUGH = 0.99
"""Share of the trials that have arrived, after which a vehicle that cannot decide for itself makes no further legs."""
MOST_EXTRA_LEGS = 4


def mission_plan(
    mission: Mission, *, seed: int | None = None, means: Scenario | None = None, to: str | None = None
) -> Plan:
    """Build the plan of a mission with at least one transit.

    `seed`: of the trials from which the time-outs are taken; default: the mission's. `means`: the mission at its means,
    where it is made already. `to`: format of the vehicle that it is for, whose own rules the time-outs and the point
    steered for then follow; default: the plan's rules. Raises InputError when the mission has no transit, or lacks what
    transits need, or allows fewer legs than its course has, or the vehicle of the format cannot do it.
    """
    TransitMission.of(mission)
    builder = _Builder(
        means or Scenario.at_means(mission, recorded_current(mission)),
        mission.monte_carlo.seed if seed is None else seed,
        execution_of(to) if to is not None else None,
    )
    phases = tuple(builder.phases())
    origin = mission.site.origin if mission.site else None
    plan = Plan(
        mission=mission.name,
        digest=hashlib.sha256(to_yaml(mission.identified()).encode()).hexdigest(),
        version=version("missionplan"),
        start=mission.start,
        origin=(origin.latitude, origin.longitude) if origin else None,
        phases=phases,
        notes=(*_notes(mission), *builder.notes),
        capacity=float(mean_of(mission.budget.capacity)) / JOULES_PER_WATT_HOUR
        if mission.budget and mission.budget.capacity is not None
        else math.nan,
        fences=tuple(_fences(builder.means)),
        has_thruster=mission.vehicle is not None and mission.vehicle.propulsion is not None,
        corrects=mission.navigation is not None and mission.navigation.drift_compensation != "none",
    )
    refused = refusals_of(to, plan) if to is not None else ()
    if refused:
        raise InputError([replace(problem, file=mission.file) for problem in refused])
    return plan


def executions(mission: Mission, to: str, plan: Plan) -> dict[str, Execution]:
    """Return how the vehicle of a format carries out each transit of the plan that was made for it, by its name."""
    executes = execution_of(to)
    if executes is None:
        return {}
    return {phase.name: executes(made) for phase, made in zip(mission.transits, plan.transits, strict=True)}


def plan_if_any(mission: Mission, means: Scenario, seed: int) -> Plan | None:
    """Build the plan; None where the mission has no transit, or more nominal legs than it allows."""
    try:
        return mission_plan(mission, seed=seed, means=means) if mission.transits else None
    except InputError:
        return None


class _Builder:
    """Goes through the phases of a mission at its means, with the place and the time in between."""

    def __init__(self, means: Scenario, seed: int, executes: Executes | None) -> None:
        self.means, self._seed, self._executes = means, seed, executes
        self._place, self._elapsed = np.zeros(2), 0.0
        self.notes: list[str] = []

    def phases(self) -> Iterator[PlannedTransit | PlannedMooring]:
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
                kind = "arrival" if target is goal and at_point else "surfacing"
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
            length = _leg_length(phase, left)
            left = max(left - length, 0.0)
            nominal = float(plan.time_under_way(np.array(length), np.array(1.0)))
            self._place = goal - left * towards
            self._elapsed += nominal + (float(means.surfacing_time) if number else 0.0)
            kind = "surfacing" if left >= SHORTEST_LEG else "arrival"
            course = math.atan2(towards[0], towards[1]) % (2.0 * math.pi)
            yield self._waypoint(f"{phase.label} {number + 1}", kind, course, length, (nominal, durations.leg(number)))
        if left >= SHORTEST_LEG:
            message = (
                f"given {plan.max_legs}, but {phase.label} is {left:.4g} m from its goal after so many nominal legs"
            )
            raise InputError([Problem(message, means.mission.file, key="navigation.max_legs")])
        self._place = goal

    def _waypoint(self, name: str, kind: str, course: float, length: float, durations: tuple[float, float]) -> Waypoint:
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
        if isinstance(table, LegTableSection):
            single = self._single(phase, table)
        else:
            single = SingleInterval(float(table), 0.0, 0.0)
        plan, time = means.transit_plan(phase), means.navigation.surfacing_time
        return SurfacingRule(
            interval=single.length,
            interval_time=float(plan.time_under_way(np.array(single.length), np.array(1.0))),
            surface_time=mean_of(time),
            surface_time_p99=_quantile(time),
            table=table.table if isinstance(table, LegTableSection) else (),
            extra_time=single.extra_time,
            extra_time_error=single.standard_error,
        )

    def _single(self, phase: TransitPhase[Scalars], table: LegTableSection) -> SingleInterval:
        try:
            return single_interval(self.means, phase, leg_table(table), self._seed)
        except InputError as error:
            reason = error.problems[0].message
            self.notes.append(f"{phase.label}: no interval in place of the table could be compared with it ({reason})")
            return SingleInterval(max(length for _, length in table.table), math.nan, math.nan)

    def _mooring(self, phase: MoorPhase[Scalars]) -> PlannedMooring:
        means, site = self.means, self.means.drawn.site
        latitude, longitude = self._on_earth(self._place)
        weight = phase.anchor_wet_weight
        begun = self._elapsed
        (written,) = (moor for moor in means.mission.moors if moor.name == phase.name)
        times = [float(each) for each in (phase.release_time, phase.hold, phase.galvanic_release)]
        self._elapsed += sum(times) + float(means.surfacing_time)
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
            release_time=times[0],
            release_time_p99=_quantile(written.release_time),
            hold=times[1],
            galvanic_release=times[2],
            elapsed=begun,
            surface_time_p99=_quantile(means.navigation.surfacing_time) if means.mission.navigation else 0.0,
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
    extra, found = 0, sail(executes(planned))
    if executes(planned).ends == "count":
        tried = [found]
        while tried[-1].arrived < ENOUGH and len(tried) <= MOST_EXTRA_LEGS:
            tried.append(sail(executes(replace(planned, extra_legs=len(tried)))))
        extra = max(range(len(tried)), key=lambda number: tried[number].arrived)
        found = tried[extra]
    return replace(
        planned,
        extra_legs=extra,
        duration_p99=found.whole,
        waypoints=tuple(
            replace(point, duration_p99=found.leg(number - 1)) if number else point
            for number, point in enumerate(planned.waypoints)
        ),
    )


def _fences(means: Scenario) -> Iterator[Fence]:
    """Yield land and zones kept out of, a polygon each."""
    site = means.mission.site
    if site is None or site.origin is None or means.place is None:
        return
    origin = site.origin

    def corners(ring: Iterable[tuple[float, float]]) -> tuple[tuple[float, float], ...]:
        east, north = np.array(list(ring))[:-1, :2].T
        return tuple(zip(*(axis.tolist() for axis in to_geographic(east, north, origin)), strict=True))

    for zone in means.place.zones:
        limits = {"from_s": zone.since, "to_s": zone.until, "above_m": zone.above, "below_m": zone.below}
        given = {key: value for key, value in limits.items() if math.isfinite(value)}
        for part in getattr(zone.geometry, "geoms", (zone.geometry,)):
            yield Fence(
                name=zone.name,
                outline=corners(part.exterior.coords),
                kind="land" if zone.is_land else "keep-out",
                holes=tuple(corners(hole.coords) for hole in part.interiors),
                limits=given,
            )


def _leg_length(phase: TransitPhase[Scalars], left: float) -> float:
    """Length of the nominal leg at a distance left (Eq. 19) [m]."""
    if isinstance(phase.d_max, LegTableSection):
        return float(leg_table(phase.d_max)(np.array(left)))
    return min(left, float(phase.d_max))


def _quantile(quantity: Quantity) -> float:
    return quantity.quantile(SHARE) if isinstance(quantity, Distribution) else float(quantity)


def _notes(mission: Mission) -> Iterator[str]:
    way = mission.navigation.drift_compensation if mission.navigation else "none"
    if way != "none":
        yield (
            f"the mission corrects its course for drift ({way}) from fix to fix; courses and waypoints here are those "
            "without drift, and the vehicle's own navigation has to correct them"
        )
    names = {phase.name for phase in mission.phases}
    uncertain = [path for path in mission.uncertain() if path.split(".")[0] in names]
    if uncertain:
        yield f"uncertain quantities are at their means: {', '.join(uncertain)}"
