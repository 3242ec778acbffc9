"""What the attributes of a NetCDF variable say, by CF: unit, direction, kind of axis, times. Converted, or refused."""

import re
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.mission.units import QuantityError, parse_number_with_unit
from missionplan.moments import clock, is_since

if TYPE_CHECKING:
    from xarray import DataArray, Dataset, Variable

PARAMETRIC = ("ocean_sigma_coordinate", "ocean_s_coordinate", "ocean_s_coordinate_g1", "ocean_s_coordinate_g2")
"""Vertical coordinates without dimension that are computed (CF 1.11, appendix D)."""
_DIMENSIONLESS = (*PARAMETRIC, "ocean_sigma_z_coordinate", "ocean_double_sigma_coordinate")
_KNOWN = {
    **{name: name for name in ("units", "standard_name", "positive", "formula_terms", "axis", "calendar", "time_zone")},
    "timezone": "time_zone",
}
FINEST, COARSEST = 1e-3, 2e3
"""Units of depths and heights [m]; fm is a femtometre to some and a fathom to others, nm a nanometre or a mile."""
_FLAGS = (3, 4, 9)
"""Flags of OceanSITES (reference table 2) and QARTOD: bad, or suspect; bad; missing."""
_BAD = re.compile(r"bad|fail|suspect|missing|invalid")
"""Of the meaning of a flag."""
_NUMBER = re.compile(r"(\d*\.?\d+(?:[eE][-+]?\d+)?)[\s*]*(?=[A-Za-z])")
_BEGUN = "forecast_reference_time"
_LONGEST = 9.2e9
"""Times farther from 1970 than this do not fit into 64 bits of nanoseconds [s]."""


class FieldAttributeError(ValueError):
    """Attributes that say nothing that can be used, or what cannot be."""


def tidied(dataset: "Dataset") -> "Dataset":
    """Write the names of CF's attributes in lower case: files have `Units` and `UNITS` too; and let time come first."""
    for variable in dataset.variables.values():
        variable.attrs = {_KNOWN.get(str(key).lower(), str(key)): value for key, value in variable.attrs.items()}
    clocks = [dim for dim in dataset.dims if clocks_along(dataset, str(dim))]
    return dataset.transpose(*clocks, ...) if len(clocks) == 1 else dataset


def word(variable: "DataArray", key: str) -> str:
    """Return the text of an attribute; empty where there is none."""
    return str(variable.attrs.get(key, "")).strip()


@lru_cache(maxsize=64)
def factor(units: str, si: str) -> float | None:
    """Return what turns a unit, written as UDUNITS and models do, into an SI unit; None where it is of another kind.

    Examples
    --------
    >>> factor("cm s-1", "m/s"), factor("0.01 m s-1", "m/s"), factor("Meters", "m"), factor("dbar", "m")
    (0.01, 0.01, 1.0, None)
    """
    begun = _NUMBER.match(units.strip())
    number, units = (begun[1], units.strip()[begun.end() :]) if begun else ("1", units.strip())
    plain = re.sub(r"(?<=[A-Za-z])\s*\^?(\*\*)?\s*\(?([+-]?\d+)\)?", r"**\2", units)
    plain = re.sub(r"(?<=[A-Za-z\d])\s*[.·]\s*(?=[A-Za-z])", "*", plain)
    plain = re.sub(r"[\s*]+(s|sec|seconds?|h|hr|hours?)\*\*-1$", r"/\1", plain, flags=re.IGNORECASE)
    for written in dict.fromkeys((plain, plain.lower())):
        try:
            return parse_number_with_unit(f"{number} {written}", si)
        except QuantityError:
            continue
    return None


def scale(variable: "DataArray", si: str, expected: str, otherwise: str = "") -> float:
    """Return what turns a variable's values into SI.

    Raises FieldAttributeError when it has no `units`, or those of something else.

    A message says what was `expected`. `otherwise` is the unit where the variable has none: a model's, whose format
    fixes it.
    """
    units = word(variable, "units") or otherwise
    if not units:
        raise FieldAttributeError(f"{variable.name} has no attribute `units`; expected {expected}")
    unit_factor = factor(units, si)
    if unit_factor is None or (si == "m" and not FINEST <= unit_factor <= COARSEST):
        raise FieldAttributeError(f"{variable.name} is in {units!r}; expected {expected}")
    return unit_factor


def speed_factor(variable: "DataArray", otherwise: str = "") -> float:
    """Return what turns a velocity into m/s; see `scale`."""
    return scale(variable, "m/s", "a speed such as m s-1, cm s-1 or knots", otherwise)


def is_vertical(variable: "DataArray") -> bool:
    """Whether a variable's attributes say that it is a vertical axis."""
    standard, units = word(variable, "standard_name").lower(), word(variable, "units")
    return (
        word(variable, "axis").upper() == "Z"
        or any(key in variable.attrs for key in ("positive", "formula_terms"))
        or standard in _DIMENSIONLESS
        or standard.startswith(("depth", "height", "altitude"))
        or bool(units and (factor(units, "m") or factor(units, "Pa")))
    )


def is_dimensionless(variable: "DataArray") -> bool:
    """Whether a vertical axis has no depths but what a formula turns into depths."""
    return "formula_terms" in variable.attrs or word(variable, "standard_name").lower() in _DIMENSIONLESS


def depths(variable: "DataArray", values: Array, otherwise: str = "") -> Array:
    """Turn the values of a vertical axis, or of the seafloor, into depths, positive down [m].

    `positive` says which way they count, else `standard_name`, else their sign. Raises FieldAttributeError when they
    are no lengths, count from elsewhere than the surface, or nothing says which way.
    """
    standard, name = word(variable, "standard_name").lower(), variable.name
    if "sea_floor" in standard and not standard.startswith("sea_floor_depth"):
        raise FieldAttributeError(f"{name} is a {standard}; expected depths below the surface")
    if is_dimensionless(variable):
        raise FieldAttributeError(f"{name} is a {standard or 'coordinate with formula_terms'}; expected depths")
    expected = "depths in units such as m; of pressures give the depths"
    size = scale(variable, "m", expected, otherwise) * np.asarray(values, dtype=float)
    return -size if counts_up(variable, size) else size


def counts_up(variable: "DataArray", values: Array) -> bool:
    """Whether a vertical axis or the seafloor counts up; see `depths`."""
    positive, standard = word(variable, "positive").lower(), word(variable, "standard_name").lower()
    if positive:
        if positive not in ("up", "down"):
            raise FieldAttributeError(f"{variable.name} has positive = {positive!r}; expected up or down")
        return positive == "up"
    if standard.startswith(("depth", "sea_floor_depth")):
        return False
    if standard.startswith(("height", "altitude")):
        return True
    numbers = values[np.isfinite(values)]
    if numbers.size and numbers.min() < 0.0 < numbers.max():
        message = f"{variable.name} has values of both signs; expected an attribute `positive`, up or down"
        raise FieldAttributeError(message)
    return bool(numbers.size and numbers.min() < 0.0)


def is_degrees(variable: "DataArray", east: bool) -> bool | None:
    """Whether a horizontal coordinate is in degrees, or in a length; None where nothing says it.

    Raises FieldAttributeError when it is in something else, such as radians, or degrees of another direction or of
    another pole.
    """
    units, standard = word(variable, "units").lower(), word(variable, "standard_name").lower()
    if standard in ("grid_longitude", "grid_latitude"):
        raise FieldAttributeError(
            f"{variable.name} is a {standard}, about another pole; expected longitudes and latitudes"
        )
    if not units:
        return None
    if units.startswith("deg"):
        ending = units.removeprefix("degrees").removeprefix("degree").removeprefix("deg").strip("_ ")
        if ending[:1] in tuple("nsw" if east else "sew"):
            raise FieldAttributeError(
                f"{variable.name} is in {units!r}; expected degrees {'east' if east else 'north'}"
            )
        return True
    scale(variable, "m", "degrees_east and degrees_north, or lengths of a projection")
    return False


def clocks_along(dataset: "Dataset", dim: str) -> list[str]:
    """Return the variables that hold the times along a dimension: units since a moment.

    The axis itself before others, and what its standard name calls the time before what nothing does.
    """
    clocks = [
        str(name)
        for name, variable in dataset.variables.items()
        if variable.dims == (dim,)
        and is_since(variable.attrs.get("units"))
        and str(variable.attrs.get("standard_name", "time")).strip().lower() == "time"
    ]
    return [dim] if dim in clocks else [name for name in clocks if "standard_name" in dataset[name].attrs] or clocks


def times_along(variable: "DataArray", dataset: "Dataset") -> NDArray[np.datetime64] | None:
    """Return the times along the first dimension of a variable; None where these are no dates.

    Those of a mean are the middles of its intervals (CF 1.11, 7.1 and 7.3). Raises FieldAttributeError when there are
    several, or as `moments` does.
    """
    clocks = clocks_along(dataset, str(variable.dims[0]))
    if not clocks:
        return None
    if len(clocks) > 1:
        raise FieldAttributeError(f"which of {', '.join(clocks)} is the time? Its attribute `standard_name` says it")
    clock = dataset[clocks[0]]
    ends = dataset.variables.get(word(clock, "bounds"))
    if ends is None or not re.search(rf"\b{clocks[0]}: mean\b", word(variable, "cell_methods")):
        return moments(clock)
    return moments(clock.copy(data=np.asarray(ends, dtype=float).mean(axis=-1)))


def valid(variable: "DataArray") -> NDArray[np.floating]:
    """Return values, nan where they are beyond the valid ones; of packed numbers these are packed too (NUG, app. A).

    Raises FieldAttributeError when the valid range is not of two numbers.
    """
    values, said, packed = variable.to_numpy(), variable.attrs, variable.encoding
    written = said.get("valid_range", (said.get("valid_min", -np.inf), said.get("valid_max", np.inf)))
    try:
        low, high = (float(bound) for bound in written)
    except (TypeError, ValueError):
        message = f"{variable.name} has a valid range of {written!r}; expected two numbers"
        raise FieldAttributeError(message) from None
    if "scale_factor" in packed and any(np.asarray(bound).dtype.kind in "iu" for bound in written):
        low, high = sorted(packed["scale_factor"] * bound + packed.get("add_offset", 0.0) for bound in (low, high))
    if not np.isfinite([low, high]).any() or "_Unsigned" in packed:
        return np.asarray(values)
    slack = 1e-6 * np.abs(values)
    return np.where((values >= low - slack) & (values <= high + slack), values, np.nan)


def good(variable: "DataArray", beside: "Dataset") -> "DataArray":
    """Return a variable, nan where it is beyond the valid values, or a flag beside it calls it bad or missing."""
    name, others = variable.name, word(variable, "ancillary_variables").split()
    names = [f"{name}_QC", f"{name}_qc", *(other for other in others if re.search(r"flag|qc", other, re.IGNORECASE))]
    flag = next((beside[other] for other in names if other in beside.variables), None)
    values = variable.copy(data=valid(variable))
    return (
        values if flag is None or not set(flag.dims) <= set(values.dims) else values.where(~flag.isin(bad_flags(flag)))
    )


def bad_flags(flag: "DataArray | Variable") -> list[float]:
    """Values by which a flag calls others bad, by what it says that they mean, else by what they usually do."""
    meanings = re.split(r"[\s,]+", str(flag.attrs.get("flag_meanings", "")).strip().lower())
    codes = np.ravel(flag.attrs.get("flag_values", ())).tolist()
    pairs = list(zip(codes, meanings, strict=True)) if len(codes) == len(meanings) else []
    return [code for code, meaning in pairs if _BAD.search(meaning)] or list(_FLAGS)


def runs(dataset: "Dataset") -> "list[Dataset]":
    """Return the runs of a forecast that a dataset holds, the latest last; itself where it holds one."""
    for name, variable in dataset.variables.items():
        if variable.ndim == 1 and str(variable.attrs.get("standard_name", "")) == _BEGUN:
            dim, starts = str(variable.dims[0]), moments(dataset[name])
            clocks = clocks_along(dataset, dim)
            if clocks and np.unique(dataset[clocks[0]]).size == starts.size:
                continue  # each time stands once
            parts = [np.flatnonzero(starts == start) for start in np.unique(starts)]
            return [dataset.isel({dim: part if clocks else part[0]}) for part in parts]
    return [dataset]


def moments(variable: "DataArray") -> NDArray[np.datetime64]:
    """Return times in UTC, to the millisecond, shape (t,).

    Raises FieldAttributeError when their units, calendar or zone cannot be read, or they are beyond the years 1678 to
    2262.
    """
    try:
        zero, length = clock(variable.attrs)
    except (ValueError, OverflowError) as error:
        raise FieldAttributeError(f"{variable.name}: {error}") from None
    seconds = np.asarray(variable.to_numpy(), dtype=float) * length
    if np.any(np.abs(seconds + zero) > _LONGEST):
        raise FieldAttributeError(f"{variable.name} reaches beyond the years 1678 to 2262")
    is_finite = np.isfinite(seconds)
    whole = np.rint(1e3 * np.where(is_finite, seconds, 0.0)) + np.rint(1e3 * zero)
    times = whole.astype(np.int64).astype("datetime64[ms]").astype("datetime64[ns]")
    times[~is_finite] = np.datetime64("NaT", "ns")
    return np.asarray(times)
