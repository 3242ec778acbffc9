"""Currents from files: a CSV series against time and depth, or a CF NetCDF field. Arrays out, in SI."""

import math
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from missionplan.arrays import Array
from missionplan.datasets.csv_cells import check_file
from missionplan.datasets.packed_files import open_table
from missionplan.datasets.times import epoch_seconds
from missionplan.errors import InputError, Problem
from missionplan.mission.schema.site import Geographic

if TYPE_CHECKING:
    from xarray import DataArray, Dataset

MAX_BYTES = 200_000_000
"""Of a CSV file of a current."""
CSV_COLUMNS = ("t_s", "depth_m", "east_m_s", "north_m_s")
_MOST = {"t_s": 1e11, "depth_m": 11_000.0, "east_m_s": 12.0, "north_m_s": 12.0}
"""Sizes beyond which a number of the file is impossible: three thousand years, the deepest sea, Saltstraumen."""


@dataclass(frozen=True)
class CurrentSeries:
    """A current against time and depth.

    Attributes
    ----------
    time, depth : array
        Increasing [s since the mission's start, m].
    east, north : array, shape (time, depth)
        [m/s].
    """

    time: Array
    depth: Array
    east: Array
    north: Array


@dataclass(frozen=True)
class CurrentField:
    """A current against time, depth and position; nan where the file has none (land, below the bottom).

    Attributes
    ----------
    time, depth, latitude, longitude : array
        Increasing [s since the mission's start, m, rad, rad].
    east, north : array, shape (time, depth, latitude, longitude)
        [m/s].
    """

    time: Array
    depth: Array
    latitude: Array
    longitude: Array
    east: Array
    north: Array


def read_current_csv(path: Path, start: datetime | None = None, epoch: datetime | None = None) -> CurrentSeries:
    """Read a CSV file with the columns ``t_s, depth_m, east_m_s, north_m_s``, every depth at every time.

    Parameters
    ----------
    path : Path
    start : datetime, optional
        Of the mission: times by ISO 8601 count from it.
    epoch : datetime, optional
        From which the record's seconds count (`site.current.start`); default: from the mission's start, whenever it is.

    Raises
    ------
    InputError
        With every problem of the file.
    """
    shown = str(path)
    check_file(path, MAX_BYTES)
    try:
        with open_table(path) as stream:
            frame = pd.read_csv(stream, encoding="utf-8-sig", skipinitialspace=True)
    except (OSError, ValueError) as error:
        raise InputError([Problem(f"cannot be read as CSV: {str(error).strip()}", shown)]) from None
    missing = [name for name in CSV_COLUMNS if name not in frame]
    if missing:
        message = f"lacks the column {', '.join(missing)}; a current has {', '.join(CSV_COLUMNS)}"
        raise InputError([Problem(message, shown, 1)])
    twice = [name for name in CSV_COLUMNS if f"{name}.1" in frame]
    if twice or frame.empty:
        message = f"the column {twice[0]} stands twice" if twice else "has no rows of data"
        raise InputError([Problem(message, shown, 1)])
    values = frame[list(CSV_COLUMNS)].apply(pd.to_numeric, errors="coerce")
    if not pd.api.types.is_numeric_dtype(frame["t_s"]):
        if epoch is not None:
            message = "its times are dates, which site.current.start does not shift: leave it out, or give seconds"
            raise InputError([Problem(message, shown)])
        values["t_s"] = values["t_s"].fillna(_since(start, frame["t_s"], shown))
    bad = np.flatnonzero(~np.isfinite(values.to_numpy(dtype=float)).all(axis=1))
    problems = [Problem("expected four numbers", shown, int(row) + 2) for row in bad[:20]] or _impossible(values, shown)
    if problems:
        raise InputError(problems)
    table = values.pivot_table(index="t_s", columns="depth_m", values=["east_m_s", "north_m_s"], aggfunc="mean")
    if values.duplicated(["t_s", "depth_m"]).any():
        row = int(np.flatnonzero(values.duplicated(["t_s", "depth_m"]))[0])
        raise InputError([Problem("this row has the time and depth of an earlier one", shown, row + 2)])
    if table.isna().to_numpy().any():
        raise InputError([Problem("every depth must be given at every time", shown)])
    return CurrentSeries(
        table.index.to_numpy(dtype=float) + _lead(start, epoch, shown),
        table["east_m_s"].columns.to_numpy(dtype=float),
        table["east_m_s"].to_numpy(dtype=float),
        table["north_m_s"].to_numpy(dtype=float),
    )


def _lead(start: datetime | None, epoch: datetime | None, shown: str) -> float:
    """Seconds by which a record's epoch is after the mission's start; 0 where the record has none."""
    if epoch is None:
        return 0.0
    if start is None:
        raise InputError([Problem("the record has a start: the mission needs its `start` (UTC) too", shown)])
    return _utc(epoch).timestamp() - _utc(start).timestamp()


def _utc(moment: datetime) -> datetime:
    """A time with its zone, UTC where it has none."""
    return moment if moment.tzinfo is not None else moment.replace(tzinfo=UTC)


def _impossible(values: pd.DataFrame, shown: str) -> list[Problem]:
    """Rows with a current, a depth or a time that no sea has: a fill value, or another unit."""
    too_much = [values[name].abs() > most for name, most in _MOST.items()]
    rows = np.flatnonzero(np.any(too_much, axis=0))
    expected = ", ".join(f"{name} at most {most:g} in size" for name, most in _MOST.items())
    return [Problem(f"is impossible; expected {expected}", shown, int(row) + 2) for row in rows[:20]]


def _since(start: datetime | None, times: "pd.Series[str]", shown: str) -> "pd.Series[float]":
    """Times by ISO 8601 as seconds since the mission's start, nan where a cell holds none."""
    moments = epoch_seconds(times)
    if start is None:
        if moments.notna().any() and pd.to_numeric(times, errors="coerce").isna().all():
            raise InputError([Problem("its times are of the day: the mission needs its `start` (UTC)", shown)])
        return moments * math.nan
    return moments - _utc(start).timestamp()


_NAMES = {
    "time": ("time", "ocean_time", "Times"),
    "depth": ("depth", "Depth", "lev", "z"),
    "latitude": ("latitude", "lat", "Latitude"),
    "longitude": ("longitude", "lon", "Longitude"),
    "east": ("u", "water_u", "u_eastward", "uo"),
    "north": ("v", "water_v", "v_northward", "vo"),
}
_STANDARD_NAMES = {
    "east": ("eastward_sea_water_velocity", "surface_eastward_sea_water_velocity"),
    "north": ("northward_sea_water_velocity", "surface_northward_sea_water_velocity"),
}


def read_current_netcdf(path: Path, start: datetime | None, origin: Geographic) -> CurrentField:
    """Read a CF NetCDF field on a regular latitude-longitude grid (the layout of operational forecasts).

    Parameters
    ----------
    path : Path
    start : datetime or None
        The mission's start, UTC.
    origin : Geographic
        The site's. The longitudes returned are within half a turn of its own, and nodes far from it are left out.

    Raises
    ------
    InputError
        When the mission has no start, xarray is not installed, a variable is missing, or the grid is not regular.
    """
    shown = str(path)
    if start is None:
        raise InputError([Problem("a NetCDF current needs the mission's `start` (UTC)", shown)])
    try:
        import xarray
    except ImportError:
        hint = "pip install 'missionplan[netcdf]'"
        raise InputError([Problem("reading NetCDF needs xarray and netCDF4", shown, hint=hint)]) from None
    try:
        with xarray.open_dataset(path) as dataset:
            return _field(dataset, start, shown, origin)
    except InputError:
        raise
    except Exception as error:  # the libraries below raise many kinds for what is damaged
        words = str(error).partition("\n")[0]
        raise InputError([Problem(f"cannot be read as NetCDF: {words}", shown)]) from None


REACH = np.radians(8.0)
"""Of a field, what is this far from the origin is read [rad]: 890 km, beyond the farthest that a mission may go."""


def _field(dataset: "Dataset", start: datetime, shown: str, origin: Geographic) -> CurrentField:
    found = {key: _variable(dataset, key, shown) for key in _NAMES}
    axes = [found[key] for key in ("time", "depth", "latitude", "longitude")]
    if any(axis.ndim != 1 for axis in axes):
        raise InputError([Problem("expected one-dimensional time, depth, latitude and longitude", shown)])
    if any(axis.size == 0 for axis in axes):
        raise InputError([Problem("has no times, depths or positions", shown)])
    if not np.issubdtype(found["time"].dtype, np.datetime64):
        hint = "its attribute `units` has to say since when, such as `hours since 2025-06-01`"
        raise InputError([Problem("its times are no dates", shown, hint=hint)])
    moment = np.datetime64(start.astimezone(UTC).replace(tzinfo=None) if start.tzinfo else start, "ns")
    latitude, longitude = (np.radians(found[key].to_numpy().astype(float)) for key in ("latitude", "longitude"))
    # about the origin's meridian, so that neither the date line nor the convention of the file matters
    east = (longitude - origin.longitude + np.pi) % (2.0 * np.pi) - np.pi
    coordinates = [
        np.asarray((found["time"].to_numpy() - moment) / np.timedelta64(1, "s"), dtype=float),
        np.abs(found["depth"].to_numpy().astype(float)),
        latitude,
        origin.longitude + east,
    ]
    reach = min(REACH / max(np.cos(origin.latitude), 0.1), 0.5 * np.pi)
    kept = [np.unique(axis, return_index=True)[1] for axis in coordinates]
    for number, offset, most in ((2, latitude - origin.latitude, REACH), (3, east, reach)):
        first, last = np.searchsorted(offset[kept[number]], (-most, most))
        kept[number] = kept[number][max(first - 1, 0) : last + 1]  # and one node beyond on each side
    chosen = {axis.dims[0]: index for axis, index in zip(axes, kept, strict=True)}
    values = (found[key].isel(chosen).transpose(*chosen).to_numpy().astype(float) for key in ("east", "north"))
    return CurrentField(*(axis[index] for axis, index in zip(coordinates, kept, strict=True)), *values)


def _variable(dataset: "Dataset", key: str, shown: str) -> "DataArray":
    for name in _NAMES[key]:
        if name in dataset.variables:
            return dataset[name]
    for other in dataset.variables:
        if dataset[other].attrs.get("standard_name") in _STANDARD_NAMES.get(key, ()):
            return dataset[other]
    message = f"has no variable for {key}; looked for {', '.join(_NAMES[key])}"
    raise InputError([Problem(message, shown)])
