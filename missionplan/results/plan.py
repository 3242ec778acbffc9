"""The plan as a vehicle takes it: where to go, how deep, how fast, when to surface, when to release the anchor."""

import math
from dataclasses import dataclass, replace
from datetime import datetime
from typing import Annotated, Literal

from missionplan.results.entries import Entry, Record
from missionplan.results.plan_places import East, Fence, Latitude, Longitude, North, PlaceInDegrees, Waypoint, time_out

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
class SurfacingRule(Record):
    """When the vehicle surfaces between a start and an arrival."""

    interval: Annotated[
        float, Entry("greatest length of a leg; with a table, the one that costs least in its place", "m", digits=3)
    ]
    interval_time: Annotated[float, Entry("under way of such a leg in still water", "s", digits=3)]
    surface_time: Annotated[float, Entry("at the surface for a fix, mean", "s", digits=3)]
    surface_time_p99: Annotated[float, Entry("what 99 % of them take at most", "s", digits=3)]
    table: Annotated[
        tuple[tuple[float, float], ...],
        Entry(
            "distance left and length of the leg, linear between rows, held beyond them, never beyond the goal; empty "
            "where one length holds",
            "m",
        ),
    ] = ()
    extra_time: Annotated[
        float, Entry("mean time that the one interval costs beyond the table; zero without one", "s", digits=3)
    ] = 0.0
    extra_time_error: Annotated[float, Entry("its standard error", "s", digits=3)] = 0.0

    @property
    def fix_wait(self) -> float:
        """Time after which a vehicle at the surface gives up waiting for a fix [s]."""
        return fix_wait(self.surface_time_p99)


@dataclass(frozen=True)
class PlannedTransit(Record):
    """A transit."""

    name: Annotated[str, Entry("of the phase")]
    depth: Annotated[float, Entry("at which it runs", "m")]
    speed: Annotated[float, Entry("through the water", "m/s")]
    arrival_radius: Annotated[float, Entry("it ends with a fix this near to the goal", "m")]
    surfacing: Annotated[SurfacingRule, Entry("when it surfaces")]
    waypoints: Annotated[tuple[Waypoint, ...], Entry("the start, where each planned leg ends, and the goal last")]
    duration_p99: Annotated[
        float, Entry("99 % of the trials that arrive take at most this, from first dive to last fix", "s", digits=1)
    ]
    aim: Waypoint | None = None
    """Point that a vehicle without a correction for drift steers for, so that the mean drift at the surface takes it to
    the goal; None: the goal."""
    extra_legs: int = 0
    """Legs for that point after the nominal ones, of a vehicle that cannot compare a fix with the goal."""

    @property
    def kind(self) -> Annotated[Literal["transit"], Entry(after="name")]:
        """Kind of phase."""
        return "transit"

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
        parts, begin = [], 0
        for end in (*ends, len(self.waypoints) - 1):
            last, aim = self.waypoints[end], self.aim
            if aim is not None:
                axes = ("east", "north", "latitude", "longitude")
                off = {axis: getattr(last, axis) + getattr(aim, axis) - getattr(self.goal, axis) for axis in axes}
                aim = replace(last, **off)
            parts.append(replace(self, waypoints=self.waypoints[begin : end + 1], aim=aim))
            begin = end
        return tuple(parts)

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
    def time_out(self) -> Annotated[float, Entry(unit="s")]:
        """Time after which the transit has failed: a tenth more than 99 % take, or than nominally; whole seconds."""
        nominal = self.goal.elapsed - self.start.elapsed + self.surfacing.surface_time
        return time_out(nominal, self.duration_p99)


@dataclass(frozen=True)
class PlannedMooring(Record):
    """A mooring where the transit before it ends, about the fix on arrival."""

    name: Annotated[str, Entry("of the phase")]
    east: East
    north: North
    latitude: Latitude
    longitude: Longitude
    radius: Annotated[float, Entry("within which of the fix on arrival the anchor is to lie", "m")]
    water_depth: Annotated[float, Entry("null where the mission has none", "m", digits=3)]
    line_length: Annotated[float, Entry("from anchor to vehicle", "m")]
    anchor_wet_weight: Annotated[float, Entry("null where it is to be sized", "N", digits=3)]
    release_time: Annotated[float, Entry("from the fix on arrival until the anchor separates, mean", "s", digits=2)]
    release_time_p99: Annotated[float, Entry("what 99 % of the releases take at most", "s", digits=2)]
    hold: Annotated[float, Entry("on the seafloor until the release is commanded", "s")]
    galvanic_release: Annotated[float, Entry("until the link has corroded", "s")]
    elapsed: Annotated[float, Entry("since the mission's start at the last fix before it, nominally", "s", digits=1)]
    surface_time_p99: float = 0.0
    """At the surface after the ascent, 99 % quantile [s]."""

    @property
    def kind(self) -> Annotated[Literal["mooring"], Entry(after="name")]:
        """Kind of phase."""
        return "mooring"

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
class Plan(Record):
    """The plan of a mission, its uncertain quantities at their means."""

    mission: Annotated[str, Entry("the mission's name")]
    digest: Annotated[
        str,
        Entry(
            "of the mission's data as `mission.yaml` of a report has them; of a current's file the contents count, not "
            "the path; the same in the header of every exported file",
            key="mission_sha256",
        ),
    ]
    version: Annotated[str, Entry("version that wrote the plan", key="missionplan")]
    start: datetime | None
    """UTC."""
    origin: tuple[float, float] | None
    """Latitude and longitude of the local plane [rad]."""
    phases: Annotated[tuple[PlannedTransit | PlannedMooring, ...], Entry("in the mission's order")]
    notes: Annotated[tuple[str, ...], Entry("what the reader is to know of every form of the plan")] = ()
    capacity: float = math.nan
    """Energy in the battery; nan where the mission gives none [Wh]."""
    fences: Annotated[tuple[Fence, ...], Entry("land and zones kept out of, where the mission has an origin")] = ()
    has_thruster: bool = False
    """Whether the vehicle has a propeller."""
    corrects: bool = False
    """Whether the mission corrects the course for drift from fix to fix."""

    @property
    def start_utc(self) -> Annotated[str | None, Entry(after="version")]:
        """When the mission starts, ISO 8601."""
        return self.start.isoformat() if self.start else None

    @property
    def origin_in_degrees(self) -> Annotated[PlaceInDegrees | None, Entry(key="origin", after="start_utc")]:
        """Origin of east and north; azimuthal equidistant on WGS 84."""
        return None if self.origin is None else PlaceInDegrees(*map(math.degrees, self.origin))

    @property
    def transits(self) -> tuple[PlannedTransit, ...]:
        """The transits among the phases."""
        return tuple(phase for phase in self.phases if isinstance(phase, PlannedTransit))

    @property
    def parts(self) -> tuple[tuple[str, PlannedTransit | PlannedMooring], ...]:
        """The phases by their numbers, a transit round points on the way part by part: ``2.1``, ``2.2``."""
        numbered_parts: list[tuple[str, PlannedTransit | PlannedMooring]] = []
        for number, phase in enumerate(self.phases, start=1):
            parts = phase.parts if isinstance(phase, PlannedTransit) else ()
            if len(parts) > 1:
                numbered_parts += [(f"{number}.{count}", part) for count, part in enumerate(parts, start=1)]
            else:
                numbered_parts.append((str(number), phase))
        return tuple(numbered_parts)

    @property
    def moorings(self) -> tuple[PlannedMooring, ...]:
        """The moorings among the phases."""
        return tuple(phase for phase in self.phases if isinstance(phase, PlannedMooring))


def fix_wait(surface_time_p99: float) -> float:
    """Return for how long a vehicle waits for a fix: five times what 99 % take, ten minutes at least [s]."""
    return max(FIX_WAIT, 5.0 * surface_time_p99)
