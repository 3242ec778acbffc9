"""The site's current where a mission reads it from a file."""

from pathlib import Path

import numpy as np

from missionplan.mission import Mission
from missionplan.mission.geodesy import to_plane
from missionplan.mission.schema.site import CurrentFile, Geographic
from missionplan.mission.views import required_origin
from missionplan.phases.currents import Current, FieldCurrent, SeriesCurrent, fill_gaps
from missionplan.scenario.current_files import CurrentField, read_current_csv, read_current_netcdf

NETCDF = (".nc", ".nc4", ".cdf", ".netcdf")
"""Endings of files that are read as NetCDF; others are read as CSV."""


def recorded_current(mission: Mission) -> Current | None:
    """Read the current's file of a mission; None where it has none.

    Raises
    ------
    InputError
        When it cannot be read, or a NetCDF field has no `start` or no `site.origin` to be placed by.
    """
    source = current_file(mission)
    if source is None:
        return None
    if source.suffix.lower() not in NETCDF:
        series = read_current_csv(source)
        return SeriesCurrent(series.time, series.depth, series.east, series.north)
    field = read_current_netcdf(source, mission.start)
    return placed(field, required_origin(mission, "a NetCDF current is placed by it"))


def current_file(mission: Mission) -> Path | None:
    """Path of the current's file; None where the mission has none."""
    written = mission.site.current if mission.site else ()
    return Path(written.file) if isinstance(written, CurrentFile) else None


def placed(field: CurrentField, origin: Geographic) -> FieldCurrent:
    """Put a field into the local plane of the origin.

    Its rows lie where the origin's meridian crosses them, its columns where the origin's parallel does. D m to the
    north and east of it a node is then wrong by D² tan(latitude)/R, 12 m at 10 km and 37°: little beside the grid.
    """
    same = np.full_like
    _, north = to_plane(field.latitude, same(field.latitude, origin.longitude), origin)
    east, _ = to_plane(same(field.longitude, origin.latitude), field.longitude, origin)
    return FieldCurrent(field.time, field.depth, north, east, fill_gaps(field.east), fill_gaps(field.north))
