"""NetCDF files, opened without decoding, and their variables as plain arrays."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from missionplan.arrays import Array
from missionplan.importers.importer import needed_module
from missionplan.moments import since

if TYPE_CHECKING:
    from xarray import Dataset

MAGIC = (b"CDF", b"\x89HDF")
"""First bytes of NetCDF 3 and 4 files."""


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
    attributes = data[name].attrs
    zero, length = since(str(attributes.get("units", "")), str(attributes.get("calendar", "")))
    return np.asarray(zero + numbers(data, name) * length)
