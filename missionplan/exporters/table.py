"""Waypoints and moorings in columns: a CSV for spreadsheets, and for other forms with columns or attributes."""

import math
from collections.abc import Iterator

from missionplan.exporters import header, one_line, zones_lost
from missionplan.results import to_csv
from missionplan.results.plan import Plan, PlannedMooring, PlannedTransit, Waypoint

TITLE = "CSV"
NEEDS_ORIGIN = False

Cell = str | float | None
OF_TRANSITS = ("phase", "depth_m", "speed_m_s", "surface_time_s", "radius_m")
"""Columns of a waypoint that its transit says already."""
OF_MOORINGS = ("release_time_s", "hold_s", "galvanic_release_s")
_OF_WAYPOINTS = ("course_deg", "leg_m", "speed_m_s", "duration_s", "duration_p99_s", "time_out_s", "surface_time_s")


def lost(plan: Plan) -> tuple[str, ...]:
    """Say what the form cannot hold."""
    tables = [transit.name for transit in plan.transits if transit.surfacing.table]
    legs = (f"the table of legs of {name}; the waypoints are those of its nominal legs" for name in tables)
    return (*legs, *zones_lost(plan, "columns hold points"))


def files(plan: Plan, stem: str) -> dict[str, str | bytes]:
    """Write one file: lines of comment with `#`, then the table."""
    return {f"{stem}.csv": waypoints_csv(plan)}


def waypoints_csv(plan: Plan) -> str:
    """Write the table."""
    named = [{**row, "name": one_line(str(row["name"])), "phase": one_line(str(row["phase"]))} for row in rows(plan)]
    comments = "".join(f"# {line}\n" for line in header(plan, TITLE, lost(plan)))
    return comments + to_csv(named)


def rows(plan: Plan) -> Iterator[dict[str, Cell]]:
    """Yield a row for each waypoint and each mooring: names with units, angles in degrees, None where unknown."""
    for phase in plan.phases:
        if isinstance(phase, PlannedMooring):
            yield mooring_row(phase)
        else:
            yield from (waypoint_row(phase, waypoint) for waypoint in phase.waypoints)


def waypoint_row(transit: PlannedTransit, waypoint: Waypoint) -> dict[str, Cell]:
    """Return what a form in columns or with attributes says of a waypoint."""
    at_start = waypoint.kind == "start"
    return {
        "name": waypoint.name,
        "phase": transit.name,
        "kind": waypoint.kind,
        **place(waypoint),
        "course_deg": known(math.degrees(waypoint.course), 3),
        "leg_m": known(waypoint.length, 3),
        "depth_m": known(transit.depth, 3),
        "speed_m_s": known(transit.speed, 4),
        "duration_s": known(waypoint.duration, 1),
        "duration_p99_s": known(waypoint.duration_p99, 1),
        "time_out_s": None if at_start else waypoint.time_out,
        "surface_time_s": None if at_start else known(transit.surfacing.surface_time, 1),
        "elapsed_s": known(waypoint.elapsed, 1),
        "radius_m": known(transit.arrival_radius, 3) if waypoint.kind == "arrival" else None,
        **dict.fromkeys(OF_MOORINGS),
    }


def course_row(transit: PlannedTransit) -> dict[str, Cell]:
    """Return what a form with attributes says of a transit's course."""
    rule = transit.surfacing
    return {
        "depth_m": transit.depth,
        "speed_m_s": transit.speed,
        "surfacing_interval_m": rule.interval,
        "surfacing_interval_s": round(rule.interval_time, 1),
        "surface_time_s": rule.surface_time,
        "time_out_s": transit.time_out,
    }


def mooring_row(mooring: PlannedMooring) -> dict[str, Cell]:
    """Return what a form in columns or with attributes says of a mooring: the same names."""
    return {
        "name": mooring.name,
        "phase": mooring.name,
        "kind": "mooring",
        **place(mooring),
        "depth_m": known(mooring.water_depth, 3),
        **dict.fromkeys(_OF_WAYPOINTS),
        "elapsed_s": known(mooring.elapsed, 1),
        "radius_m": known(mooring.radius, 3),
        **{key: known(getattr(mooring, key.removesuffix("_s")), 1) for key in OF_MOORINGS},
    }


def place(point: Waypoint | PlannedMooring) -> dict[str, Cell]:
    """Return the columns of a position."""
    return {
        "east_m": round(point.east, 3),
        "north_m": round(point.north, 3),
        "latitude_deg": known(math.degrees(point.latitude), 8),
        "longitude_deg": known(math.degrees(point.longitude), 8),
    }


def known(value: float, digits: int) -> float | None:
    """Return a number rounded; None where it is not finite."""
    return round(value, digits) if math.isfinite(value) else None
