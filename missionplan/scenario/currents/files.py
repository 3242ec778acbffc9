"""NetCDF files that together hold one field: joined in time, variables by the names that models give them."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.errors import InputError, Problem
from missionplan.moments import moment_of
from missionplan.scenario.currents.attributes import (
    FieldAttributeError,
    depths,
    good,
    is_vertical,
    scale,
    speed_factor,
    times_along,
    word,
)

if TYPE_CHECKING:
    from xarray import DataArray, Dataset

Moments = NDArray[np.datetime64]
Window = Mapping[str, slice]


@dataclass(frozen=True)
class Carried:
    """What a field moves, by the names that models give its velocity."""

    name: str
    """How messages name it."""
    east: tuple[str, ...]
    north: tuple[str, ...]
    """Variables toward east and north, or along rows and columns."""
    standard_east: tuple[str, ...]
    standard_north: tuple[str, ...]
    """CF's names."""
    fastest: float
    """Faster than this is none [m/s]."""
    other: str
    """Pattern of names of what else moves, or the other way."""


SEA = Carried(
    "current",
    ("u_eastward", "water_u", "u_east", "utotal", "uo", "u", "u_sur", "u_sur_eastward"),
    ("v_northward", "water_v", "v_north", "vtotal", "vo", "v", "v_sur", "v_sur_northward"),
    ("eastward_sea_water_velocity", "surface_eastward_sea_water_velocity"),
    ("northward_sea_water_velocity", "surface_northward_sea_water_velocity"),
    12.0,  # Saltstraumen reaches 10 m/s
    r"(^|_)winds?(_(?!driven|induced|forced)|$)|stokes|(^|_)ice(_|$)|stress|transport|westward|southward",
)
WIND = Carried(
    "wind",
    ("u10", "10u", "uwnd", "u10m", "Uwind", "x_wind_10m", "eastward_wind", "wind_u", "u_wind", "u"),
    ("v10", "10v", "vwnd", "v10m", "Vwind", "y_wind_10m", "northward_wind", "wind_v", "v_wind", "v"),
    ("eastward_wind",),
    ("northward_wind",),
    90.0,
    r"sea_water|stress|transport|westward|southward",
)
_OF_UNITS = {"degreenorth": "latitude", "degreen": "latitude", "degreeeast": "longitude", "degreee": "longitude"}
_MODELS_SPEEDS = ("horizontalVelX", "horizontalVelY")
"""Velocities of SCHISM, which writes them in m/s and without `units`."""
_OTHER_WAY = ("north|(^|_)y_", "east|(^|_)x_")
"""Of the standard name of a component, what is the other's."""
_OTHER_WORDS = ("northward|meridional", "eastward|zonal")
"""Of its name for people."""
_STATISTIC = re.compile(r"standard_deviation|variance|maximum|minimum|range|sum_of_squares")
"""Of the cells that a value is of, what is no velocity of any moment (CF 1.11, appendix E)."""
_FILLS = 3
"""At fewer places no number stands for none."""
_MEMBERS = re.compile(r"(n_?)?ens(emble)?_?(mem(ber)?|number|id)?s?|mem(ber)?s?|reali[sz]ation|number")
"""Name of the dimension of an ensemble's members, in small letters."""


@dataclass(frozen=True)
class FieldFiles:
    """Open files of one field."""

    datasets: "Sequence[Dataset]"
    """In the order of their names; of what two of them hold of the same time, the last counts (a later forecast)."""
    shown: str
    """How messages name them."""
    carries: Carried = SEA
    """What moves."""

    def problem(self, message: str, hint: str = "") -> InputError:
        """Return the error of the files."""
        return InputError([Problem(message, self.shown, hint=hint)])

    def named(self, *names: str, standard: Sequence[str] = ()) -> str | None:
        """Return the first of some names that a file has, else a variable with one of the standard names."""
        for name in names:
            if any(name in dataset.variables for dataset in self.datasets):
                return name
        return next(iter(self._all_named(*standard)), None)

    def _all_named(self, *standard: str) -> list[str]:
        """Return the variables with one of the standard names."""
        pairs = [(dataset, name) for dataset in self.datasets for name in dataset.variables]
        return list(dict.fromkeys(str(name) for dataset, name in pairs if standard_name(dataset[name]) in standard))

    def required(self, what: str, *names: str, standard: Sequence[str] = ()) -> str:
        """Return the name of a variable, or raise InputError that says what is missing."""
        name = self.named(*names, standard=standard)
        if name is None:
            raise self.problem(f"has no variable for {what}; looked for {', '.join((*names, *standard))}")
        return name

    def variable(self, name: str) -> "DataArray":
        """Return a variable as the first file has it that does."""
        return next(dataset[name] for dataset in self.datasets if name in dataset.variables)

    def fixed(self, name: str, window: Window | None = None) -> Array:
        """Return the numbers of a variable that does not change; of one that has times, those of the first."""
        variable = self.variable(name)
        variable = variable.isel({dim: part for dim, part in (window or {}).items() if dim in variable.dims})
        if variable.ndim and self._times_of(variable) is not None:
            variable = variable.isel({variable.dims[0]: 0})
        return np.asarray(variable.to_numpy(), dtype=float)

    def moments(self, name: str) -> Moments:
        """Return the times of a variable, increasing.

        Raises InputError when it has none, or they are no dates.
        """
        return np.array(sorted(self._places(name)), dtype="datetime64[ns]")

    def series(self, name: str, moments: Moments, window: Window, order: Sequence[str]) -> NDArray[np.float32]:
        """Return a variable at some times.

        Raises InputError when it lacks a time.

        `window` is a part of each dimension, `order` the dimensions after the time, as wanted.
        """
        places = self._places(name)
        rows: list[NDArray[np.float32]] = []
        missing = [moment for moment in moments if moment not in places]
        if missing:
            raise self.problem(f"{name} lacks the time {np.datetime_as_string(missing[0], 's')}, which others have")
        numbers = [places[moment][0] for moment in moments]
        for number in dict.fromkeys(numbers):
            variable = self.datasets[number][name]
            steps = [places[moment][1] for moment in moments if places[moment][0] == number]
            first, last = min(steps), max(steps)
            part = {variable.dims[0]: slice(first, last + 1)}
            part |= {dim: kept for dim, kept in window.items() if dim in variable.dims}
            near = self.datasets[number].isel(part)
            block = good(near[name].transpose(variable.dims[0], *order), near).to_numpy()
            rows.append(np.asarray(block[np.array(steps) - first], dtype=np.float32))
        return np.concatenate(rows) if len(rows) > 1 else rows[0]

    def _places(self, name: str) -> dict[np.datetime64, tuple[int, int]]:
        """By time, the file and the step in it."""
        places: dict[np.datetime64, tuple[int, int]] = {}
        for number, dataset in enumerate(self.datasets):
            if name not in dataset.variables:
                continue
            times = self._times_of(dataset[name], dataset)
            if times is None:
                hint = "its attribute `units` has to say since when, such as `hours since 2025-06-01`"
                raise self.problem("its times are no dates", hint)
            places |= {moment: (number, step) for step, moment in enumerate(times) if not np.isnat(moment)}
        if not places:
            raise self.problem("has no times")
        return dict(sorted(places.items()))

    def _times_of(self, variable: "DataArray", dataset: "Dataset | None" = None) -> Moments | None:
        """Return the times along the first dimension of a variable; None where these are no dates."""
        dataset = dataset if dataset is not None else next(d for d in self.datasets if variable.name in d.variables)
        dim = variable.dims[0]
        if "Times" in dataset.variables and dataset["Times"].dims[:1] == (dim,):  # exact where `time` is of 32 bits
            # times by ISO 8601, as models write them: bytes, one string a row or one character a column
            texts = dataset["Times"].to_numpy()
            rows = texts if texts.ndim == 1 else np.array([b"".join(row) for row in texts])
            words = [row.decode() if isinstance(row, bytes) else str(row) for row in rows]
            try:
                times = [moment_of(text.strip(" \0")).replace(tzinfo=None) for text in words]
            except (ValueError, OverflowError) as error:
                raise FieldAttributeError(f"Times: {error}") from None
            return np.array(times, dtype="datetime64[ns]")
        return times_along(variable, dataset)

    def height_factor(self, name: str, otherwise: str = "") -> float:
        """Return what turns a height's unit into m; `otherwise` is that of a model whose files lack `units`.

        Raises FieldAttributeError when it has none of a length.
        """
        return scale(self.variable(name), "m", "a length such as m", otherwise)

    def depths(self, name: str, window: Window | None = None, otherwise: str = "") -> Array:
        """Return a vertical axis or the seafloor as depths, positive down [m].

        Raises FieldAttributeError as `attributes.depths` does.
        """
        return depths(self.variable(name), self.fixed(name, window), otherwise)

    def component(self, name: str, number: int) -> float:
        """Return what turns a component of the velocity into m/s: 0 toward east or along rows, 1 the other.

        Raises InputError or FieldAttributeError when it is one of something else, the other one, or in no unit of it.
        """
        if other := self._other(name, number):
            raise self.problem(f"{name} is a {other}; expected the {self.carries.name} toward east and north")
        return speed_factor(self.variable(name), "m/s" if name in _MODELS_SPEEDS else "")

    def _other(self, name: str, number: int | None = None) -> str:
        """What a component says that it is, where that is none: something else, a statistic, or not that asked for."""
        variable = self.variable(name)
        standard, statistic = word(variable, "standard_name").lower(), _STATISTIC.search(word(variable, "cell_methods"))
        text = re.sub(r"\W+", "_", word(variable, "long_name").lower())
        ways = _OTHER_WAY if standard else _OTHER_WORDS
        pattern = "|".join((self.carries.other, r"\s", *(() if number is None else (ways[number],))))
        is_other = re.search(pattern, standard or text)
        return standard or word(variable, "long_name") if is_other else statistic[0] if statistic else ""

    def components(self) -> tuple[str, str]:
        """Return the names of the velocity toward east, or along rows, and toward north: of several that which fits.

        Raises InputError when one is missing, or several have one standard name.
        """
        carries, chosen = self.carries, []
        sides = (("east", carries.east, carries.standard_east), ("north", carries.north, carries.standard_north))
        for way, names, standards in sides:
            usual = [name for name in names if self.named(name) and not self._other(name)]
            for standard in () if usual else standards:
                usual = usual or [name for name in self._all_named(standard) if not self._other(name)]
                if len(usual) > 1:
                    raise self.problem(f"which of {', '.join(usual)} is the {carries.name}? Each is a {standard}")
            what = f"the {carries.name} toward {way}"
            chosen.append(usual[0] if usual else self.required(what, *names, standard=standards))
        return chosen[0], chosen[1]

    def has_times(self, name: str) -> bool:
        """Whether a variable changes in time."""
        variable = self.variable(name)
        return bool(variable.ndim) and self._times_of(variable) is not None

    def members(self) -> str | None:
        """Return the dimension along which the members of an ensemble lie."""
        axes = [(str(dim), dataset[dim]) for dataset in self.datasets for dim in dataset.dims]
        names = (
            dim
            for dim, axis in axes
            if standard_name(axis) == "realization" or (_MEMBERS.fullmatch(dim.lower()) and not is_vertical(axis))
        )
        return next(names, None)

    def at_one_height(self) -> "FieldFiles":
        """Return a wind without the axis of its one height.

        Raises InputError when it has several.
        """
        chosen = []
        for dataset in self.datasets:
            axes = [dim for dim in dataset.sizes if dim in dataset.variables and is_vertical(dataset[dim])]
            several = [str(dim) for dim in axes if dataset.sizes[dim] > 1]
            if several:
                raise self.problem(f"has several heights along {several[0]}; expected the wind 10 m above the sea")
            chosen.append(dataset.isel(dict.fromkeys(axes, 0)))
        return replace(self, datasets=chosen)

    def size(self, dim: str) -> int:
        """Return the length of a dimension."""
        return next(int(dataset.sizes[dim]) for dataset in self.datasets if dim in dataset.sizes)

    def one_depth(self) -> Array:
        """Return the depth that a field without a vertical axis is of: a scalar coordinate (CF 1.11, 5.7), else 0."""
        for dataset in self.datasets if self.carries is SEA else ():
            for name, coordinate in dataset.coords.items():
                if coordinate.ndim == 0 and is_vertical(coordinate):
                    return np.atleast_1d(self.depths(str(name)))
        return np.zeros(1)

    def member(self, dimension: str, number: int) -> "FieldFiles":
        """Return one member of an ensemble."""
        chosen = [d.isel({dimension: number}) if dimension in d.dims else d for d in self.datasets]
        return replace(self, datasets=chosen, shown=f"{self.shown}, {dimension} {number}")


def standard_name(variable: "DataArray") -> str:
    """Standard name of a variable; of one without that of what its units are of alone (CF 1.11, 4.1 and 4.2)."""
    by_units = _OF_UNITS.get(word(variable, "units").lower().replace("_", "").replace("degrees", "degree"), "")
    return word(variable, "standard_name").lower() or by_units


def undeclared_fill(u: NDArray[np.floating], v: NDArray[np.floating]) -> tuple[float, float]:
    """Return the numbers that stand for none: both components have them at the same places; nan where there are none.

    They are one unit or more and far beyond all others, or one number, for a sea has no two components that agree to
    the digit, but by chance where they are rounded: it is beyond all others, or is written in nines and is most of
    what agrees.
    """
    finite = [np.where(np.isfinite(component), component, 0.0) for component in (u, v)]
    farthest = [float(side.flat[np.argmax(np.abs(side))]) if side.size else 0.0 for side in finite]
    places = [side == one for side, one in zip(finite, farthest, strict=True)]
    rest = [float(np.abs(side[~there]).max(initial=0.0)) for side, there in zip(finite, places, strict=True)]
    share = 1.0 if farthest[0] == farthest[1] else 0.5
    is_beyond = all(0.0 < other < share * abs(one) >= share for other, one in zip(rest, farthest, strict=True))
    if is_beyond and (share == 1.0 or np.array_equal(*places)) and np.sum(places[0] & places[1]) >= _FILLS:
        return farthest[0], farthest[1]
    common = _nines(u, v)
    return common, common


def _nines(u: NDArray[np.floating], v: NDArray[np.floating]) -> float:
    """Return the number written in nines that is most of what agrees; nan where there is none."""
    alike, count = np.unique(u[(u == v) & (u != 0.0)], return_counts=True)
    if not np.any(count >= _FILLS):
        return np.nan
    common = float(alike[np.argmax(count)])
    digits = f"{abs(common):.6g}".lstrip("0.").replace(".", "")
    is_nines = set(digits) == {"9"} and (len(digits) > 1 or abs(common) >= 1.0)
    is_most = count.max() > 0.5 * count.sum() and not np.all(u == common) and not np.all(v == common)
    return common if is_nines and is_most else np.nan


def velocities(
    files: FieldFiles, names: tuple[str, str], parts: tuple[NDArray[np.float32], NDArray[np.float32]]
) -> NDArray[np.complex64]:
    """Join the components of a velocity in m/s, as complex numbers.

    Raises InputError when a unit is none of a speed, or a value is impossible or stands for none: a fill value that the
    file does not declare.
    """
    scaled, fastest, hint = [], files.carries.fastest, "is its attribute `units` right, and `_FillValue` declared?"
    filled = undeclared_fill(*parts)
    if not np.isnan(filled[0]):
        shown = f"both {filled[0]:g}" if filled[0] == filled[1] else f"{filled[0]:g} and {filled[1]:g}"
        raise files.problem(f"{names[0]} and {names[1]} are {shown} at many places, which is no current", hint)
    for number, (name, values) in enumerate(zip(names, parts, strict=True)):
        part = values * np.float32(files.component(name, number))
        scaled.append(part)
        speeds = part[np.isfinite(part)]
        if speeds.size and float(np.abs(speeds).max()) > fastest:
            worst = float(speeds[np.argmax(np.abs(speeds))])
            raise files.problem(
                f"{name} reaches {worst:.6g} m/s; no {files.carries.name} is faster than {fastest:g} m/s", hint
            )
    joined = np.empty(scaled[0].shape, dtype=np.complex64)
    joined.real, joined.imag = scaled
    joined[~np.isfinite(joined)] = np.nan
    return joined
