"""OceanGliders OG1 netCDF: a deployment in one file, its fixes in LATITUDE_GPS and LONGITUDE_GPS.

Dead reckoning is the file's own flag DEAD_RECKONING (1 where LATITUDE and LONGITUDE are dead-reckoned), else the
displacements of a Seaglider's hydrodynamic model, summed from the last fix of each dive's beginning.
"""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from missionplan.arrays import Array
from missionplan.importers.importer import Importer, ReadOptions, SourceLog
from missionplan.importers.readers.seaglider import DiveFile, joined_dives, reckoned_from
from missionplan.importers.sourcefiles.netcdf import MAGIC, epoch_seconds, numbers, opened, variable_names
from missionplan.importers.track import Fixes, Positions, Series, Track, fixes, positions, series

if TYPE_CHECKING:
    from xarray import Dataset

_MARKS = {"TIME", "LATITUDE_GPS", "LONGITUDE_GPS"}
_FLAG = "DEAD_RECKONING"


def recognises(path: Path, head: bytes) -> bool:
    """Whether a file is of the OG1 format."""
    return path.suffix == ".nc" and head.startswith(MAGIC) and variable_names(path, "og1") >= _MARKS


def read(files: Sequence[Path], options: ReadOptions, log: SourceLog) -> Track:
    """Read the files as one track."""
    parts: list[DiveFile] = []
    how = ""
    for path in log.each(sorted(files)):
        with log.reading(path), opened(path, "og1") as data:
            found, how = _deployment(data)
            parts.append(found)
    return joined_dives(parts, "OG1 glider", "og1", how or "the file holds no dead reckoning")


def _deployment(data: "Dataset") -> tuple[DiveFile, str]:
    t = epoch_seconds(data, "TIME")
    fixed = _fixes(data, t)
    reckoned, how = _reckoned(data, t, fixed)
    depth = series(t, numbers(data, "DEPTH", "TIME"))
    gliding = numbers(data, "GLIDER_HORZ_VELO_MODEL", "TIME")
    return DiveFile(
        fixes=fixed,
        reckoned=reckoned,
        depth=depth,
        pitch=series(t, numbers(data, "PITCH", "TIME")),
        heading=series(t, numbers(data, "HEADING", "TIME")),
        speed=series(t, gliding) if how else Series(),
        declination=series(t, numbers(data, "MAGNETIC_DECLINATION", "TIME")),
    ), how


def _fixes(data: "Dataset", t: Array) -> Fixes:
    times = epoch_seconds(data, "TIME_GPS") if "TIME_GPS" in data else t
    return fixes(times, numbers(data, "LATITUDE_GPS"), numbers(data, "LONGITUDE_GPS"))


def _reckoned(data: "Dataset", t: Array, fixed: Fixes) -> tuple[Positions, str]:
    if _FLAG in data and np.any(numbers(data, _FLAG) == 1.0):
        own = numbers(data, _FLAG) == 1.0
        place = (numbers(data, name)[own] for name in ("LATITUDE", "LONGITUDE"))
        return positions(t[own], *place), f"the file's own, where {_FLAG} is 1"
    if {"north_displacement", "east_displacement", "divenum"} <= set(map(str, data.variables)):
        parts = list(_summed(data, t, fixed))
        joined = (np.concatenate([getattr(part, name) for part in parts]) for name in ("t", "latitude", "longitude"))
        return positions(*joined) if parts else Positions(), "the hydrodynamic model (displacements from the last fix)"
    return Positions(), ""


def _summed(data: "Dataset", t: Array, fixed: Fixes) -> Iterator[Positions]:
    """Displacements of each dive, summed from the last fix before the first of them that is none."""
    dive, depth = numbers(data, "divenum"), numbers(data, "DEPTH", "TIME")
    east, north = numbers(data, "east_displacement"), numbers(data, "north_displacement")
    for which in np.unique(dive[np.isfinite(dive)]):
        rows = np.flatnonzero((dive == which) & np.isfinite(east) & np.isfinite(north))
        if len(rows) and np.nanmax(depth[rows]) > 0.0:
            before = int(np.searchsorted(fixed.t, t[rows[0]])) - 1
            if before >= 0:
                place = float(fixed.latitude[before]), float(fixed.longitude[before])
                yield reckoned_from(t[rows], east[rows], north[rows], *place)


IMPORTER = Importer("og1", "OceanGliders OG1 netCDF", recognises, read)
