"""NetCDF files: variables by name, alias or standard name, each along its own dimension with that dimension's clock."""

import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import lru_cache
from itertools import takewhile
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from missionplan.arrays import Array, without_nines
from missionplan.errors import InputError
from missionplan.importers.importer import needed_module
from missionplan.importers.mapping import DDMM, QUANTITIES, MappedName, ddmm_to_degrees, times, unit_factor
from missionplan.importers.track import Series, series
from missionplan.moments import clock
from missionplan.scenario.currents.attributes import bad_flags, valid

if TYPE_CHECKING:
    from xarray import Dataset

MAGIC = (b"CDF", b"\x89HDF")
"""First bytes of NetCDF 3 and 4 files."""
_GOOD_FLAGS = (1.0, 2.0, 5.0, 8.0)
"""Quality flags (OceanSITES, reference table 2) of values that are good, probably good, changed or interpolated."""


_BACKWARD = re.compile(r"(_|s|\s)(s|w|south|west)$", re.IGNORECASE)
"""Ends degrees that count toward south or west."""


@contextmanager
def opened(path: Path, format_name: str) -> Iterator["Dataset"]:
    """Open a file without decoding times."""
    xarray = needed_module("xarray", "netcdf", format_name)
    needed_module("netCDF4", "netcdf", format_name)
    with xarray.open_dataset(path, engine="netcdf4", decode_times=False, cache=False) as data:
        yield data


def variable_names(path: Path, format_name: str) -> frozenset[str]:
    """Names of the variables of a file, in small letters; none where it cannot be read."""
    return _names(path, path.stat().st_mtime_ns, format_name)


@lru_cache(maxsize=4096)
def _names(path: Path, _modified: int, format_name: str) -> frozenset[str]:
    try:
        with opened(path, format_name) as data:
            return frozenset(str(name).lower() for name in data.variables)
    except (OSError, ValueError, RuntimeError):
        return frozenset()


class Variables:
    """Variables of a file.

    The data set is opened without decoding times.
    """

    def __init__(self, data: "Dataset") -> None:
        self._data, self._variables = data, data.variables  # a DataArray with its coordinates takes a millisecond
        self._by_name = {str(name).lower(): str(name) for name in data.variables}

    def find(self, *names: str, standard: Sequence[str] = ()) -> str | None:
        """Find a variable by one of its names, else by a standard name; capitals do not count.

        Of several with the standard name, the one of the shortest name: ``depth`` rather than ``ctd_depth``.
        """
        for name in names:
            if name.lower() in self._by_name:
                return self._by_name[name.lower()]
        fitting = [
            name
            for name in self._by_name.values()
            if self._variables[name].size > 1
            and str(self._variables[name].attrs.get("standard_name", "")).lower() in standard
        ]
        return min(fitting, key=len, default=None)

    def numbers(self, name: str | None) -> Array:
        """Values as floats in one row; none where the file lacks the variable."""
        if name is None:
            return np.empty(0)
        has_range = any(str(key).startswith("valid_") for key in self._variables[name].attrs)
        values = np.atleast_1d(valid(self._data[name]) if has_range else self._variables[name].values)
        if values.dtype.kind in "SU":  # flags are often characters
            words = values.astype(str).ravel()
            return np.array([float(word) if word.strip().isdigit() else np.nan for word in words])
        return without_nines(np.asarray(values, dtype=float).ravel())

    def in_unit(self, name: str | None, wanted: str) -> Array:
        """Values in a unit, by the variable's own; a pressure becomes a depth."""
        try:
            return self.numbers(name) * (_factor(self.unit(name), wanted) if name else 1.0)
        except ValueError as error:
            raise ValueError(f"{name}: {error}") from None

    def unit(self, name: str | None) -> str:
        """Unit that a variable states; nothing where it states none."""
        return str(self._variables[name].attrs.get("units", "")).strip() if name else ""

    def like(self, name: str | None, other: str, wanted: str = "") -> Array:
        """Values in a unit where another variable stands; nan where missing, or along another dimension."""
        if name is None or self.dimension(name) != self.dimension(other):
            return np.full(self._variables[other].size, np.nan)
        return self.in_unit(name, wanted)

    def dimension(self, name: str) -> str:
        """Dimension of a variable: the longest one, as those of length 1 are no axis."""
        sizes = {str(axis): size for axis, size in self._variables[name].sizes.items()}
        return max(sizes, key=lambda axis: sizes[axis], default="")

    def clock(self, name: str) -> Array:
        """Times of a variable's values since 1970 [s], along its own dimension.

        Several clocks may lie along one: the one that shares a part of its name with the variable is its own, else
        the one of the shortest name. Raises LookupError when no time lies along its dimension.
        """
        along = self.dimension(name)
        clocks = [
            clock
            for clock in self._by_name.values()
            if self.dimension(clock) == along
            and self._variables[clock].size == self._variables[name].size
            and " since " in self.unit(clock)
        ]
        if not clocks:
            raise LookupError(f"no time lies along the dimension {along} of {name}")
        return self.epoch(max(clocks, key=lambda clock: (_shared(clock, name), -len(clock))))

    def epoch(self, name: str) -> Array:
        """Times of a variable since 1970 [s], by its units (``days since 2010-01-01``)."""
        zero, length = clock(self._variables[name].attrs)
        return np.asarray(zero + self.numbers(name) * length)

    def series(self, name: str | None, unit: str) -> Series:
        """Readings of a variable in a unit on its own clock, good ones; none where it is missing or has no clock."""
        if name is None:
            return Series()
        try:
            t = self.clock(name)
        except LookupError:
            return Series()
        return series(t, np.where(self.validity(name) == 0.0, np.nan, self.in_unit(name, unit)))

    def validity(self, name: str | None) -> Array:
        """1 where the quality flag of a variable calls it good, 0 where bad, nan where it says neither."""
        flag = self.find(f"{name}_qc") if name else None
        if name is None or flag is None:
            return np.full(self._variables[name].size if name else 0, np.nan)
        values, bad = self.like(flag, name), bad_flags(self._variables[flag])
        return np.where(np.isin(values, bad), 0.0, np.where(np.isin(values, _GOOD_FLAGS), 1.0, np.nan))

    def text(self, *names: str) -> str:
        """Text of a variable or, failing that, of an attribute of the file; nothing where it has neither."""
        variable = self.find(*names)
        if variable is not None and self._variables[variable].size:
            value = self._variables[variable].values.ravel()
            word = value[0] if len(value) == 1 else b"".join(value) if value.dtype.kind == "S" else value[0]
            return (word.decode("utf-8", "replace") if isinstance(word, bytes) else str(word)).strip()
        attributes = {str(key).lower(): value for key, value in self._data.attrs.items()}
        return next((str(attributes[name.lower()]).strip() for name in names if name.lower() in attributes), "")

    def __iter__(self) -> Iterator[str]:
        return iter(self._by_name.values())

    def attribute(self, name: str, of: str) -> str:
        """An attribute of a variable; nothing where it has none."""
        return str(self._variables[name].attrs.get(of, "")) if name else ""


def _shared(clock: str, name: str) -> int:
    """Number of the words in a row that a clock's name begins or ends with, as the variable's does."""
    clock_words, other = clock.lower().split("_"), name.lower().split("_")
    ends = ((clock_words, other), (clock_words[::-1], other[::-1]))
    return max(sum(1 for _ in takewhile(lambda pair: pair[0] == pair[1], zip(*pair, strict=False))) for pair in ends)


def _factor(unit: str, wanted: str) -> float:
    """Factor from a unit as files write it; 1 where it states none.

    Raises ValueError when it is one of something else, or none that is known.
    """
    if not wanted or unit in ("", "1", wanted):
        return 1.0
    if wanted == "deg" and unit.lower().startswith("deg"):
        return -1.0 if _BACKWARD.search(unit) else 1.0
    try:
        return unit_factor(unit, wanted)
    except InputError:
        raise ValueError(f"given the unit {unit!r}, expected one such as {wanted}") from None


def mapped_parts(file: Variables, columns: Mapping[str, MappedName]) -> list[dict[str, Array]]:
    """Variables as named, a part for each dimension that they lie along, with that dimension's clock."""
    variables = {quantity: file.find(column.name) for quantity, column in columns.items()}
    missing = [columns[quantity].name for quantity, name in variables.items() if name is None]
    if missing:
        raise ValueError(f"no variable {', '.join(missing)}; it has {', '.join(sorted(file)[:20])}")
    names = {quantity: name for quantity, name in variables.items() if name is not None}
    parts: dict[str, dict[str, Array]] = {}
    for quantity, name in names.items():
        if quantity == "time":
            continue
        part = parts.setdefault(file.dimension(name), {})
        if "t" not in part:
            is_same = file.dimension(names["time"]) == file.dimension(name)
            if is_same and " since " not in file.unit(names["time"]):
                words, unit = pd.Series(file.numbers(names["time"]).astype(str)), columns["time"].unit
                part["t"] = times(words, "epoch" if unit == "iso" else unit)
            else:
                part["t"] = file.epoch(names["time"]) if is_same else file.clock(name)
        part[quantity] = _mapped(file, name, columns[quantity].unit, QUANTITIES[quantity])
    return list(parts.values())


def _mapped(file: Variables, name: str, unit: str, usual: str) -> Array:
    """Values in the usual unit, from the one that the user names; where that is the usual one, from the file's."""
    if unit.lower() in DDMM:
        return ddmm_to_degrees(file.numbers(name))
    if unit == usual or not usual:
        return file.in_unit(name, usual)
    return file.numbers(name) * unit_factor(unit, usual)
