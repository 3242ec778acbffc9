"""NetCDF files, opened without decoding, and their variables as plain arrays."""

import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from missionplan.arrays import Array
from missionplan.importers.importer import needed_module

if TYPE_CHECKING:
    from xarray import Dataset

MAGIC = (b"CDF", b"\x89HDF")
"""First bytes of NetCDF 3 and 4 files."""
_SINCE = re.compile(r"\s*(\w+?)s?\s+since\s+(.+)", re.IGNORECASE)
_SECONDS = {"nanosecond": 1e-9, "microsecond": 1e-6, "millisecond": 1e-3, "second": 1.0, "sec": 1.0, "s": 1.0}
_SECONDS |= {"minute": 60.0, "min": 60.0, "hour": 3600.0, "hr": 3600.0, "h": 3600.0, "day": 86400.0, "d": 86400.0}


@contextmanager
def opened(path: Path, format_name: str) -> Iterator["Dataset"]:
    """Open a file without decoding times or masks."""
    xarray = needed_module("xarray", "netcdf", format_name)
    needed_module("netCDF4", "netcdf", format_name)
    with xarray.open_dataset(path, engine="netcdf4", decode_times=False, cache=False) as data:
        yield data


def variable_names(path: Path, format_name: str) -> set[str]:
    """Names of the variables of a file; none where it cannot be read."""
    try:
        with opened(path, format_name) as data:
            return {str(name) for name in data.variables}
    except (OSError, ValueError, RuntimeError):
        return set()


def numbers(data: "Dataset", name: str, like: str | None = None) -> Array:
    """Values of a variable as floats; nan of the length of `like` where the file lacks it."""
    if name in data:
        return np.atleast_1d(np.asarray(data[name].values, dtype=float))
    return np.full(data[like].size if like else 0, np.nan)


def epoch_seconds(data: "Dataset", name: str) -> Array:
    """Times of a variable in seconds since 1970, by its units (``days since 2010-01-01``).

    Raises
    ------
    ValueError
        When its units are no times.
    """
    matched = _SINCE.fullmatch(str(data[name].attrs.get("units", "")))
    if matched is None or matched[1].lower() not in _SECONDS:
        raise ValueError(f"the units of {name} are no time since a date")
    zero = pd.Timestamp(matched[2].strip())
    zero = zero.tz_localize("UTC") if zero.tzinfo is None else zero.tz_convert("UTC")
    return np.asarray(zero.timestamp() + numbers(data, name) * _SECONDS[matched[1].lower()])
