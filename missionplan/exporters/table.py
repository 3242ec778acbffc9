"""Waypoints and moorings in columns: a CSV for spreadsheets, and for other forms with columns or attributes."""

import math
from collections.abc import Iterator, Mapping

from missionplan.exporters import header, one_line, zones_lost
from missionplan.results import to_csv
from missionplan.results.plan import Plan, PlannedMooring, PlannedTransit
from missionplan.results.plan_places import Waypoint

TITLE = "CSV"
NEEDS_ORIGIN = False

Cell = str | float | None
COLUMNS = (
    *("name", "phase", "kind", "east_m", "north_m", "latitude_deg", "longitude_deg", "course_deg", "leg_m", "depth_m"),
    *("speed_m_s", "duration_s", "duration_p99_s", "time_out_s", "surface_time_s", "elapsed_s", "radius_m"),
    *("release_time_s", "hold_s", "galvanic_release_s"),
)


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
    rule = transit.surfacing
    return _columns(
        waypoint.summary(),
        phase=transit.name,
        depth_m=transit.depth,
        speed_m_s=transit.speed,
        surface_time_s=None if waypoint.kind == "start" else rule.surface_time,
        radius_m=transit.arrival_radius if waypoint.kind == "arrival" else None,
    )


def mooring_row(mooring: PlannedMooring) -> dict[str, Cell]:
    """Return what a form in columns or with attributes says of a mooring: the same names."""
    return _columns(mooring.summary(), phase=mooring.name, depth_m=mooring.water_depth)


def _columns(entries: Mapping[str, Cell], **more: Cell) -> dict[str, Cell]:
    """Arrange entries as columns, numbers to the millimetre and millisecond or better."""
    row = {**more, **entries}
    return {name: known(cell, 8) if isinstance(cell := row.get(name), float) else cell for name in COLUMNS}


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


def known(value: float, digits: int) -> float | None:
    """Return a number rounded; None where it is not finite."""
    return round(value, digits) if math.isfinite(value) else None
