"""The site's current where a mission reads it from files."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from missionplan.arrays import Array
from missionplan.errors import InputError, Problem
from missionplan.mission import Mission
from missionplan.mission.geodesy import to_plane
from missionplan.mission.reading.includes import REMOTE
from missionplan.mission.schema.site import CurrentFile, Geographic, TidalCurrent
from missionplan.mission.views import required_origin
from missionplan.phases.currents import Current
from missionplan.phases.fields.ensemble import Ensemble
from missionplan.phases.recorded_currents import RecordedCurrent, SeriesCurrent
from missionplan.scenario.currents.tide_forecast import tidal_stream
from missionplan.store.paths import matching

NETCDF = (".nc", ".nc4", ".cdf", ".netcdf")
"""Endings of files that are read as NetCDF; others are read as CSV."""


def recorded_current(mission: Mission, also: Array | None = None) -> Current | None:
    """Read the files of a mission's current, or forecast its tide; None where it has neither.

    Parameters
    ----------
    mission : Mission
    also : array, shape (2, k), optional
        Places besides the mission's about which a field is needed [m].

    Raises
    ------
    InputError
        When they cannot be read, or the mission lacks the `start` or the `site.origin` that a NetCDF field needs.
    """
    if mission.site and isinstance(mission.site.current, TidalCurrent):
        return tidal_stream(mission, mission.site.current)
    written = current_source(mission)
    if written is None:
        return None
    return replace(_members(mission, written, also), outside=written.outside)


def current_source(mission: Mission) -> CurrentFile | None:
    """Return what the mission says of its current's files; None where it reads none."""
    written = mission.site.current if mission.site else ()
    return written if isinstance(written, CurrentFile) else None


def is_netcdf(name: str) -> bool:
    """Whether a file, a pattern or an address is read as NetCDF."""
    return name.startswith(REMOTE) or Path(name).suffix.lower() in NETCDF


def _members(mission: Mission, written: CurrentFile, also: Array | None) -> RecordedCurrent:
    """Read the current, or all members of an ensemble: files of their own, or along a dimension of one."""
    names: list[tuple[str, int | None, str]] = [(name, None, Path(name).name) for name in written.members]
    if len(names) == 1 and is_netcdf(written.members[0]):
        from missionplan.scenario.currents.field import member_count

        count = member_count(matching(written.members[0]), written.members[0])
        if count > 1:
            names = [(written.members[0], number, f"member {number + 1}") for number in range(count)]
    if len(names) == 1:
        return _read(mission, written, written.members[0], also)
    weights = written.weights or (1.0,) * len(names)
    if len(weights) != len(names):
        message = f"{len(weights)} weights for {len(names)} members"
        raise InputError([Problem(message, mission.file, key="site.current.weights")])
    shown = [name for *_, name in names]
    shown = shown if len(set(shown)) == len(shown) else [name for name, *_ in names]
    return Ensemble.of([_read(mission, written, name, also, number) for name, number, _ in names], shown, weights)


def _read(
    mission: Mission, written: CurrentFile, name: str, also: Array | None, member: int | None = None
) -> RecordedCurrent:
    if not is_netcdf(name):
        return _read_csv(mission, written, name)
    if written.start is not None:
        message = "a NetCDF current has dates of its own; `start` is for a CSV record that counts seconds"
        raise InputError([Problem(message, mission.file, key="site.current.start")])
    if mission.start is None:
        raise InputError([Problem("a NetCDF current needs the mission's `start` (UTC)", name)])
    from missionplan.scenario.currents.area import Area
    from missionplan.scenario.currents.field import read_field

    origin = required_origin(mission, "a NetCDF current is placed by it")
    start = np.datetime64(round(mission.start.timestamp() * 1e6), "us").astype("datetime64[ns]")
    places = mission_places(mission, origin)
    places = places if also is None else np.hstack((places, also))
    return read_field(matching(name), Area(origin, start, places, written.projection), name, member)


def _read_csv(mission: Mission, written: CurrentFile, name: str) -> SeriesCurrent:
    from missionplan.scenario.currents.csv_series import read_current_csv  # pandas: half a second

    if "*" in name:
        message = f"given {name}; a pattern is for NetCDF files, a CSV record is one file"
        raise InputError([Problem(message, mission.file, key="site.current.file")])
    series = read_current_csv(Path(name), mission.start, written.start)
    return SeriesCurrent(series.time, series.depth, series.east, series.north)


def mission_places(mission: Mission[object], origin: Geographic) -> Array:
    """Return where a mission's transits begin and end, and its origin, shape (2, k) [m]."""
    found = [np.zeros(2)]
    for phase in mission.transits:
        for place in (phase.start, phase.to):
            if isinstance(place, Geographic):
                found.append(np.hstack(to_plane(np.array([place.latitude]), np.array([place.longitude]), origin)))
            elif place is not None and all(isinstance(value, float) for value in place):
                found.append(np.array(place, dtype=float))
    return np.array(found).T
