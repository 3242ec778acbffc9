"""The site's current where a mission reads it from a file."""

import hashlib
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from missionplan.errors import InputError, Problem
from missionplan.mission import Mission
from missionplan.mission.geodesy import to_plane
from missionplan.mission.schema.site import CurrentFile, Geographic, TidalCurrent
from missionplan.mission.views import required_origin
from missionplan.phases.currents import Current
from missionplan.phases.recorded_currents import FieldCurrent, Outside, SeriesCurrent, fill_gaps
from missionplan.scenario.tide_forecast import tidal_stream

if TYPE_CHECKING:
    from missionplan.scenario.current_files import CurrentField

NETCDF = (".nc", ".nc4", ".cdf", ".netcdf")
"""Endings of files that are read as NetCDF; others are read as CSV."""


def recorded_current(mission: Mission) -> Current | None:
    """Read the file of a mission's current, or forecast its tide; None where it has neither.

    Raises
    ------
    InputError
        When it cannot be read, or the mission lacks the `start` or the `site.origin` that a NetCDF field needs.
    """
    written = mission.site.current if mission.site else ()
    if isinstance(written, TidalCurrent):
        return tidal_stream(mission, written)
    source = current_file(mission)
    if source is None:
        return None
    from missionplan.scenario.current_files import read_current_csv, read_current_netcdf  # pandas: half a second

    if source.suffix.lower() not in NETCDF:
        series = read_current_csv(source, mission.start, _epoch(mission))
        return SeriesCurrent(series.time, series.depth, series.east, series.north, outside=_outside(mission))
    if _epoch(mission) is not None:
        message = "a NetCDF current has dates of its own; `start` is for a CSV record that counts seconds"
        raise InputError([Problem(message, mission.file, key="site.current.start")])
    origin = required_origin(mission, "a NetCDF current is placed by it")
    field = read_current_netcdf(source, mission.start, origin)
    return replace(placed(field, origin), outside=_outside(mission))


def current_file(mission: Mission) -> Path | None:
    """Return the path of the current's file; None where the mission has none."""
    written = mission.site.current if mission.site else ()
    return Path(written.file) if isinstance(written, CurrentFile) else None


def with_contents_named(text: str, mission: Mission) -> str:
    """Return text about a mission with the contents of its current's file in place of the file's path."""
    source = current_file(mission)
    if source is None:
        return text
    return text.replace(str(source), f"{source.name} (SHA-256 {hashlib.sha256(source.read_bytes()).hexdigest()})")


def _epoch(mission: Mission) -> datetime | None:
    written = mission.site.current if mission.site else ()
    return written.start if isinstance(written, CurrentFile) else None


def _outside(mission: Mission) -> Outside:
    written = mission.site.current if mission.site else ()
    return written.outside if isinstance(written, CurrentFile) else "error"


def placed(field: "CurrentField", origin: Geographic) -> FieldCurrent:
    """Return a field in the local plane of the origin.

    Each row of the grid keeps the north coordinate of its point on the origin's meridian, each column the east
    coordinate of its point on the origin's parallel. At a distance D to the north and east the error is
    D² tan(latitude)/R: 12 m at 10 km and 37°, little beside the spacing of the grid.
    """
    same = np.full_like
    _, north = to_plane(field.latitude, same(field.latitude, origin.longitude), origin)
    east, _ = to_plane(same(field.longitude, origin.latitude), field.longitude, origin)
    return FieldCurrent(field.time, field.depth, north, east, fill_gaps(field.east), fill_gaps(field.north))
