"""NetCDF trajectories by the CF conventions: variables by standard name, one trajectory by its `cf_role`.

The vehicle's own position is dead-reckoned under water and a fix at the surface, as in a table with one position.
Where it is interpolated between fixes, as in pyglider's time series, there is nothing to import. Convention: CF 1.11,
chapter 9 and appendix H.4 (one trajectory, many as a matrix, contiguous and indexed ragged arrays).
"""

from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from missionplan.errors import InputError, Problem, shown
from missionplan.importers.importer import ColumnStore, Importer, ReadOptions, SourceLog
from missionplan.importers.mapping import QUANTITIES, MappedName
from missionplan.importers.readers.netcdf import MAGIC, Variables, opened, variable_names
from missionplan.importers.readers.track import split_track
from missionplan.importers.track import Track

if TYPE_CHECKING:
    from xarray import Dataset

_PYGLIDER = {"latitude", "longitude", "profile_index", "distance_over_ground"}
_NAMES = {
    "lat": ((), ("latitude",)),
    "lon": ((), ("longitude",)),
    "depth": (("depth",), ("depth", "sea_water_pressure", "sea_water_pressure_due_to_sea_water")),
    "heading_true": ((), ("platform_orientation", "platform_yaw", "platform_yaw_fore_starboard")),
    "pitch": ((), ("platform_pitch", "platform_pitch_fore_up", "platform_pitch_angle")),
    "speed": ((), ("platform_speed_wrt_sea_water",)),
    "declination": (("magnetic_declination", "magnetic_variation"), ()),
}


def _refuse(files: Sequence[Path], options: ReadOptions, log: SourceLog) -> Track:
    message = (
        "is a time series whose position is interpolated between the fixes, so that it holds no dead reckoning and no "
        "error of a leg"
    )
    raise InputError([Problem(message, str(path), hint="import the vehicle's raw logs") for path in files])


def recognises(path: Path, head: bytes) -> bool:
    """Whether a file is a trajectory by its feature type or the role of a variable."""
    return head.startswith(MAGIC) and _is_trajectory(path)


@lru_cache(maxsize=4096)
def _is_trajectory(path: Path) -> bool:
    try:
        with opened(path, "trajectory") as data:
            kind = str(data.attrs.get("featureType", "")).lower()
            return kind.startswith("trajectory") or _role(data) is not None
    except (OSError, ValueError, RuntimeError):
        return False


def _role(data: "Dataset") -> str | None:
    return next((str(name) for name in data.variables if data[name].attrs.get("cf_role") == "trajectory_id"), None)


def read(files: Sequence[Path], options: ReadOptions, log: SourceLog) -> Track:
    """Read the files as one track."""
    store, names, title = ColumnStore(), dict[str, MappedName](), ""
    for path in log.each(sorted(files)):
        with log.reading(path), opened(path, "trajectory") as data:
            one, title = _one(data, path, options.vehicle)
            file = Variables(one)
            columns = {quantity: file.find(*alias, standard=standard) for quantity, (alias, standard) in _NAMES.items()}
            if columns["lat"] is None or columns["lon"] is None:
                raise ValueError("no variables of the standard names latitude and longitude")
            if any("interpolat" in file.attribute(columns[axis] or "", "comment").lower() for axis in ("lat", "lon")):
                _refuse([path], options, log)
            said = " ".join(file.attribute(columns["heading_true"] or "", of) for of in ("long_name", "comment"))
            if "magnetic" in said.lower():
                columns["heading"] = columns.pop("heading_true")
            _add(store, file, columns)
            names |= {quantity: MappedName(name, QUANTITIES[quantity]) for quantity, name in columns.items() if name}
    return split_track(f"trajectory {title or files[0].stem}", "trajectory", store, names)


def _add(store: ColumnStore, file: Variables, columns: dict[str, str | None]) -> None:
    """Add the variables, those along one dimension with its clock."""
    along: dict[str, dict[str, np.ndarray]] = {}
    for quantity, name in columns.items():
        if name is None:
            continue
        part = along.setdefault(file.dimension(name), {"t": file.clock(name)})
        part[quantity] = np.where(file.validity(name) == 0.0, np.nan, file.in_unit(name, QUANTITIES[quantity]))
        if quantity == "depth" and file.attribute(name, "positive").lower() == "up":
            part[quantity] = -part[quantity]
    for part in along.values():
        store.add(part)


def _one(data: "Dataset", path: Path, wanted: str | None) -> tuple["Dataset", str]:
    """One trajectory of a file, and its name.

    Raises InputError with the list, when it holds several and none of them is chosen.
    """
    role = _role(data)
    values = np.empty(0) if role is None else np.atleast_1d(data[role].values)
    names = [(value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)).strip() for value in values]
    if role is None or len(names) < 2:
        return data, names[0] if names else ""
    if wanted is None or wanted not in names:
        message = f"no trajectory {shown(wanted)}" if wanted else "holds several trajectories"
        hint = f"choose one with --vehicle, such as --vehicle {names[0]}"
        raise InputError([Problem(f"{message}: {', '.join(names[:20])}", str(path), key="vehicle", hint=hint)])
    which, instances = names.index(wanted), str(data[role].dims[0])
    for name in data.variables:
        attributes, values = data[name].attrs, data[name].values
        if "sample_dimension" in attributes:  # contiguous ragged: the number of rows of each
            begin = int(values[:which].sum())
            rows: object = slice(begin, begin + int(values[which]))
            return data.isel({attributes["sample_dimension"]: rows, instances: which}), wanted
        if "instance_dimension" in attributes:  # indexed ragged: the number of each row's trajectory
            rows = np.flatnonzero(values == which)
            return data.isel({str(data[name].dims[0]): rows, instances: which}), wanted
    return data.isel({instances: which}), wanted


IMPORTERS = (
    Importer(
        "pyglider",
        "pyglider's time series, refused: they hold no dead reckoning",
        lambda path, head: head.startswith(MAGIC) and variable_names(path, "pyglider") >= _PYGLIDER,
        _refuse,
    ),
    Importer("trajectory", "NetCDF trajectories by the CF conventions", recognises, read, is_choosing=True),
)
