"""The plan as a vehicle takes it: where to go, how deep, how fast, when to surface, when to release the anchor."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from datetime import datetime

TIME_OUT_MARGIN = 1.1
"""Time-out over the 99 % duration."""
CLIMB = math.radians(5.0)
"""Angle at which a vehicle is taken to climb to the surface, or steeper; those with a propeller climb at 10 to 30°, and
slower as they level off. A vehicle that climbs steeper makes the rest of its leg at the surface [rad]."""
FIX_WAIT = 600.0
"""Least time that a vehicle waits at the surface for a fix; a cold start of a receiver takes a minute or two [s]."""
ABORT_MARGIN = 1.5
"""Over the time-out: to give a mission up costs more than to be late, and one trial in a hundred is late."""
SURFACE_DEPTH = 0.3
"""Depth above which a vehicle is at the surface [m]."""
LONGEST_SINKING = 5.0
"""Time a metre of depth after which a vehicle lies at anchor whatever its depth gauge says: it sinks faster [s/m]."""


@dataclass(frozen=True)
class Waypoint:
    """A point of the course, with the leg that leads to it."""

    name: str
    """Such as ``ingress 2``."""
    kind: str
    """``start``, ``surfacing`` (where a planned leg ends) or ``arrival``."""
    east: float
    north: float
    """Of the origin [m]."""
    latitude: float
    longitude: float
    """[rad]; nan where the mission has no origin."""
    course: float
    """Of the leg over ground, clockwise from true north [rad]; nan at a start."""
    length: float
    """Of the leg [m]."""
    duration: float
    duration_p99: float
    """Time under way: length over speed, with the acceleration from rest; and what 99 % of the trials take at most for
    the leg of this number, course corrections included [s]."""
    elapsed: float
    """Since the mission's start, nominally [s]."""
    is_via: bool = False
    """Whether it is a point on the way that the transit goes round by: it is arrived at as the goal is."""

    @property
    def time_out(self) -> float:
        """Time after which the leg has failed, in whole seconds: the longer of its durations and a tenth [s]."""
        return time_out(self.duration, self.duration_p99)


@dataclass(frozen=True)
class SurfacingRule:
    """When the vehicle surfaces between a start and an arrival."""

    interval: float
    """Greatest length of a leg; with a table, the one that costs least in its place [m]."""
    interval_time: float
    """Time under way of such a leg in still water [s]."""
    surface_time: float
    surface_time_p99: float
    """At the surface, mean and 99 % quantile [s]."""
    table: tuple[tuple[float, float], ...] = ()
    """Distance left and length of the leg, linear between; empty where one length holds throughout [m]."""
    extra_time: float = 0.0
    extra_time_error: float = 0.0
    """Mean time that the one interval costs beyond the table, and its standard error; zero without a table [s]."""

    @property
    def fix_wait(self) -> float:
        """Time after which a vehicle at the surface gives up waiting for a fix [s]."""
        return fix_wait(self.surface_time_p99)


@dataclass(frozen=True)
class PlannedTransit:
    """A transit."""

    name: str
    depth: float
    speed: float
    """Run depth, and speed through the water [m, m/s]."""
    arrival_radius: float
    """[m]"""
    surfacing: SurfacingRule
    waypoints: tuple[Waypoint, ...]
    """The start, where each planned leg ends, and the goal last."""
    duration_p99: float
    """Time that 99 % of the trials that arrive take, from the first dive to the fix on arrival [s]."""
    aim: Waypoint | None = None
    """Point that a vehicle without a correction for drift steers for, so that the mean drift at the surface takes it to
    the goal; None: the goal."""
    extra_legs: int = 0
    """Legs for that point after the nominal ones, of a vehicle that cannot compare a fix with the goal."""

    @property
    def steered_for(self) -> Waypoint:
        """The goal, or the point that is steered for in its place."""
        return self.aim or self.goal

    @property
    def parts(self) -> tuple["PlannedTransit", ...]:
        """Its straight parts, from one point on the way to the next, each aimed off as the last one is."""
        ends = [number for number, point in enumerate(self.waypoints) if point.is_via]
        if not ends:
            return (self,)
        found, begin = [], 0
        for end in (*ends, len(self.waypoints) - 1):
            found.append(replace(self, waypoints=self.waypoints[begin : end + 1], aim=self._aimed(self.waypoints[end])))
            begin = end
        return tuple(found)

    def _aimed(self, end: Waypoint) -> Waypoint | None:
        """Point to steer for in place of one on the way: as far off as that in place of the goal."""
        if self.aim is None:
            return None
        shifted = {
            axis: getattr(end, axis) + getattr(self.aim, axis) - getattr(self.goal, axis)
            for axis in ("east", "north", "latitude", "longitude")
        }
        return replace(end, **shifted)

    @property
    def aim_off(self) -> float:
        """How far that point is from the goal [m]."""
        return math.hypot(self.steered_for.east - self.goal.east, self.steered_for.north - self.goal.north)

    @property
    def ascent_margin(self) -> float:
        """Way before the end of a leg at which the vehicle goes up, half a leg at most: none may be longer [m]."""
        return min(self.depth / math.tan(CLIMB), 0.5 * self.surfacing.interval)

    @property
    def sequence(self) -> tuple[Waypoint, ...]:
        """Where a vehicle goes that cannot compare a fix with the goal: the nominal legs' ends, then the last again."""
        last = self.steered_for
        again = [
            replace(last, name=f"{self.goal.name} again {number}", length=0.0, duration=0.0)
            for number in range(1, self.extra_legs + 1)
        ]
        return (*self.waypoints[1:-1], last, *again)

    @property
    def abort_time(self) -> float:
        """Time after which the vehicle gives the transit up: half more than the time-out, and one late fix [s]."""
        return ABORT_MARGIN * self.time_out + self.surfacing.fix_wait

    @property
    def start(self) -> Waypoint:
        """Where it begins."""
        return self.waypoints[0]

    @property
    def goal(self) -> Waypoint:
        """Where it ends."""
        return self.waypoints[-1]

    @property
    def legs(self) -> tuple[Waypoint, ...]:
        """The waypoints that a leg leads to."""
        return self.waypoints[1:]

    @property
    def time_out(self) -> float:
        """Time after which the transit has failed, surfacings included, whole seconds [s]."""
        nominal = self.goal.elapsed - self.start.elapsed + self.surfacing.surface_time
        return time_out(nominal, self.duration_p99)


@dataclass(frozen=True)
class PlannedMooring:
    """A mooring, about the fix on arrival."""

    name: str
    east: float
    north: float
    latitude: float
    longitude: float
    """Where the transit before it ends [m, rad]."""
    radius: float
    """Within which the anchor is to lie [m]."""
    water_depth: float
    """[m]; nan where the mission has none."""
    line_length: float
    """[m]"""
    anchor_wet_weight: float
    """[N]; nan where it is to be sized."""
    release_time: float
    release_time_p99: float
    """From the last fix until the anchor separates, mean and 99 % quantile [s]."""
    hold: float
    galvanic_release: float
    """Time on the bottom until the release is commanded, and until the link has corroded, means [s]."""
    elapsed: float
    """Mission time of the last fix before it, nominally [s]."""
    surface_time_p99: float = 0.0
    """At the surface after the ascent, 99 % quantile [s]."""

    @property
    def fix_wait(self) -> float:
        """Time after which a vehicle at the surface gives up waiting for a fix [s]."""
        return fix_wait(self.surface_time_p99)

    @property
    def touchdown_depth(self) -> float:
        """Depth of the vehicle below which its anchor lies on the bottom, a tenth less; nan where not known [m]."""
        return 0.9 * (self.water_depth - self.line_length) if self.water_depth > self.line_length else math.nan

    @property
    def longest_sinking(self) -> float:
        """Time after which the vehicle is taken to lie at anchor, whatever its depth gauge says [s]."""
        return max(60.0, LONGEST_SINKING * self.water_depth) if math.isfinite(self.water_depth) else FIX_WAIT

    @property
    def longest_release(self) -> float:
        """Time after the release is triggered when the vehicle should long have surfaced [s]."""
        return 3.0 * self.galvanic_release + FIX_WAIT


@dataclass(frozen=True)
class Fence:
    """A zone that the vehicle keeps out of."""

    name: str
    outline: tuple[tuple[float, float], ...]
    """Corners, latitude and longitude, the first one not repeated [rad]."""
    kind: str = "keep-out"
    """``land`` or ``keep-out``."""
    holes: tuple[tuple[tuple[float, float], ...], ...] = ()
    """Corners of the water inside it, as the outline's [rad]."""
    limits: Mapping[str, float] = field(default_factory=dict)
    """When and at which depths it holds: ``from_s``, ``to_s`` since the mission's start, ``above_m``, ``below_m``."""

    @property
    def is_limited(self) -> bool:
        """Whether the mission forbids it at some times or depths alone."""
        return bool(self.limits)


@dataclass(frozen=True)
class Plan:
    """The plan of a mission, its uncertain quantities at their means."""

    mission: str
    """The mission's name."""
    digest: str
    """SHA-256 of the mission's data as `mission.yaml` of a report has them, in hexadecimal digits; of a current's file
    the contents count, not the path."""
    version: str
    """Of missionplan."""
    start: datetime | None
    """UTC."""
    origin: tuple[float, float] | None
    """Latitude and longitude of the local plane [rad]."""
    phases: tuple[PlannedTransit | PlannedMooring, ...]
    """In the mission's order."""
    notes: tuple[str, ...] = ()
    """What the reader is to know of every form of the plan."""
    capacity: float = math.nan
    """Energy in the battery; nan where the mission gives none [Wh]."""
    fences: tuple[Fence, ...] = ()
    """Land and zones kept out of, where the mission has an origin."""
    has_thruster: bool = False
    """Whether the vehicle has a propeller."""
    corrects: bool = False
    """Whether the mission corrects the course for drift from fix to fix."""

    @property
    def transits(self) -> tuple[PlannedTransit, ...]:
        """The transits among the phases."""
        return tuple(phase for phase in self.phases if isinstance(phase, PlannedTransit))

    @property
    def parts(self) -> tuple[tuple[str, PlannedTransit | PlannedMooring], ...]:
        """The phases by their numbers, a transit round points on the way part by part: ``2.1``, ``2.2``."""
        found: list[tuple[str, PlannedTransit | PlannedMooring]] = []
        for number, phase in enumerate(self.phases, start=1):
            parts = phase.parts if isinstance(phase, PlannedTransit) else ()
            if len(parts) > 1:
                found += [(f"{number}.{count}", part) for count, part in enumerate(parts, start=1)]
            else:
                found.append((str(number), phase))
        return tuple(found)

    @property
    def moorings(self) -> tuple[PlannedMooring, ...]:
        """The moorings among the phases."""
        return tuple(phase for phase in self.phases if isinstance(phase, PlannedMooring))


def fix_wait(surface_time_p99: float) -> float:
    """Return for how long a vehicle waits for a fix: five times what 99 % take, ten minutes at least [s]."""
    return max(FIX_WAIT, 5.0 * surface_time_p99)


def time_out(nominal: float, p99: float) -> float:
    """Return the time-out of a duration, whole seconds [s]."""
    longest = nominal if math.isnan(p99) else max(nominal, p99)
    return float(math.ceil(TIME_OUT_MARGIN * longest - 1e-9))
