"""Seagliders: netCDF files of the basestation, one a dive.

Dead reckoning is that of the basestation's hydrodynamic model, whose displacements are summed from the fix before the
dive. Each file has three fixes: two before the dive, one after it.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from missionplan.arrays import Array
from missionplan.importers.geodesy import moved
from missionplan.importers.importer import Importer, ReadOptions, SourceLog
from missionplan.importers.sourcefiles.netcdf import MAGIC, epoch_seconds, numbers, opened, variable_names
from missionplan.importers.track import Fixes, Positions, Series, Track, fixes, positions, series

if TYPE_CHECKING:
    from xarray import Dataset

_MARKS = {"log_gps_lat", "north_displacement"}
_RECKONING = "the basestation's hydrodynamic model (displacements from the fix before the dive)"


@dataclass(frozen=True)
class DiveFile:
    """One dive of a glider whose displacements are summed from a fix."""

    fixes: Fixes
    reckoned: Positions
    depth: Series
    pitch: Series
    heading: Series
    speed: Series
    declination: Series


def recognises(path: Path, head: bytes) -> bool:
    """Whether a file is one of a basestation's dives."""
    return path.suffix == ".nc" and head.startswith(MAGIC) and variable_names(path, "seaglider") >= _MARKS


def read(files: Sequence[Path], options: ReadOptions, log: SourceLog) -> Track:
    """Read the files of all dives as one track."""
    dives: list[DiveFile] = []
    for path in log.each(sorted(files)):
        with log.reading(path), opened(path, "seaglider") as data:
            dives.append(_dive(data))
    return joined_dives(dives, _vehicle(files), "seaglider", _RECKONING)


def joined_dives(dives: Sequence[DiveFile], name: str, format_name: str, reckoning: str) -> Track:
    """Make one track of all dives."""

    def all_of(quantity: str) -> Series:
        parts: list[Series] = [getattr(dive, quantity) for dive in dives]
        return series(_concatenated([each.t for each in parts]), _concatenated([each.values for each in parts]))

    reckoned = [dive.reckoned for dive in dives]
    return Track(
        name=name,
        format=format_name,
        fixes=_all_fixes([dive.fixes for dive in dives]),
        reckoned=positions(
            *(_concatenated([getattr(each, axis) for each in reckoned]) for axis in ("t", "latitude", "longitude"))
        ),
        reckoning=reckoning,
        depth=all_of("depth"),
        pitch=all_of("pitch"),
        heading=all_of("heading"),
        heading_from="magnetic",
        speed=all_of("speed"),
        declination=all_of("declination"),
    )


def _concatenated(parts: Sequence[Array]) -> Array:
    return np.concatenate(parts) if parts else np.empty(0)


def _all_fixes(parts: Sequence[Fixes]) -> Fixes:
    columns = {name: _concatenated([getattr(each, name) for each in parts]) for name in Fixes.__dataclass_fields__}
    return fixes(**columns)


def reckoned_from(t: Array, east: Array, north: Array, latitude: float, longitude: float) -> Positions:
    """Sum displacements between readings from a position on."""
    place = moved(latitude, longitude, np.cumsum(np.nan_to_num(east)), np.cumsum(np.nan_to_num(north)))
    return positions(t, *place)


def _dive(data: "Dataset") -> DiveFile:
    t, latitude, longitude = (numbers(data, f"log_gps_{name}") for name in ("time", "lat", "lon"))
    if len(t) < 3:
        raise ValueError("fewer than three fixes: the dive was not completed")
    times = epoch_seconds(data, "time")
    east, north = numbers(data, "east_displacement"), numbers(data, "north_displacement")
    in_cm = "horz_speed" in data and str(data["horz_speed"].attrs.get("units", "")).startswith("cm")
    engineering = times if len(numbers(data, "eng_head")) == len(times) else np.empty(0)
    return DiveFile(
        fixes=fixes(
            t,
            latitude,
            longitude,
            accuracy=_positive(numbers(data, "log_gps_hpe", "log_gps_lat")),
            hdop=_positive(numbers(data, "log_gps_hdop", "log_gps_lat")),
            satellites=_positive(numbers(data, "log_gps_n_satellites", "log_gps_lat")),
        ),
        reckoned=reckoned_from(times, east, north, float(latitude[1]), float(longitude[1])),
        depth=series(times, numbers(data, "depth", "time")),
        pitch=_if_as_long(engineering, numbers(data, "eng_pitchAng")),
        heading=_if_as_long(engineering, numbers(data, "eng_head")),
        speed=series(times, (0.01 if in_cm else 1.0) * numbers(data, "horz_speed", "time")),
        declination=series(t, numbers(data, "log_gps_magvar", "log_gps_lat")),
    )


def _if_as_long(t: Array, values: Array) -> Series:
    return series(t, values) if len(t) == len(values) else Series()


def _positive(values: Array) -> Array:
    """Qualities; the basestation writes −1 where there is none."""
    return np.where(values > 0.0, values, np.nan)


def _vehicle(files: Sequence[Path]) -> str:
    name = files[0].stem
    return f"Seaglider {name[1:4]}" if name[:1] == "p" and name[1:].isdigit() else "Seaglider"


IMPORTER = Importer("seaglider", "Seaglider basestation netCDF, one file a dive", recognises, read)
