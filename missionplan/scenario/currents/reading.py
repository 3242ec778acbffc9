"""A current from its files: a series at one place (CSV), or the field of an ocean model, by the reader for its grid."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from missionplan.datasets.table import plain_table, times_from
from missionplan.errors import InputError, Problem
from missionplan.identity import how_to_install
from missionplan.mission.includes import REMOTE
from missionplan.moments import EPOCH_SCALE, utc
from missionplan.phases.gridded_current import GriddedCurrent
from missionplan.phases.recorded_currents import SeriesCurrent
from missionplan.scenario.currents.area import Area
from missionplan.scenario.currents.attributes import FieldAttributeError, runs, tidied
from missionplan.scenario.currents.files import SEA, WIND, Carried, FieldFiles, undeclared_fill
from missionplan.scenario.currents.regular import LATITUDE, LONGITUDE, read_curved, read_regular
from missionplan.scenario.currents.unstructured import read_fvcom, read_ugrid, topology

if TYPE_CHECKING:
    from xarray import Dataset


MAX_BYTES = 200_000_000
"""Of a CSV file of a current."""
_LONGEST = 1e11
"""Times larger than three thousand years are impossible [s]."""
CURRENT_LIMITS = {"t_s": _LONGEST, "depth_m": 11_000.0, "east_m_s": 12.0, "north_m_s": 12.0}
"""Columns of a current, with sizes beyond which a number is impossible: the deepest sea, Saltstraumen."""
WIND_LIMITS = {"t_s": _LONGEST, "east_m_s": 90.0, "north_m_s": 90.0}
"""Columns of a wind; no hurricane is faster."""


def read_series_csv(
    path: Path,
    limits: Mapping[str, float] = CURRENT_LIMITS,
    start: datetime | None = None,
    epoch: datetime | None = None,
) -> SeriesCurrent:
    """Read a CSV file of east and north components against time and, where it is among the columns, depth.

    Raises InputError with every problem of the file.

    `limits`: columns, and the size beyond which a number of each is impossible. `start`: of the mission: times by ISO
    8601 count from it. `epoch`: from which the record's seconds count (`site.current.start`); default: from the
    mission's start, whenever it is.
    """
    shown = str(path)
    frame = plain_table(path, limits, MAX_BYTES)
    values = frame[list(limits)].apply(pd.to_numeric, errors="coerce")
    if (values["t_s"].isna() & frame["t_s"].notna()).any() or values["t_s"].min() > EPOCH_SCALE:
        if epoch is not None:
            message = "its times are dates, which site.current.start does not shift: leave it out, or give seconds"
            raise InputError([Problem(message, shown)])
        values["t_s"] = times_from(frame["t_s"], None if start is None else utc(start).timestamp(), shown)
    bad = np.flatnonzero(~np.isfinite(values.to_numpy(dtype=float)).all(axis=1))
    problems = [Problem(f"expected {len(limits)} numbers", shown, int(frame.index[row])) for row in bad[:20]]
    problems = problems or _impossible(values, limits, shown)
    if problems:
        raise InputError(problems)
    if "depth_m" not in limits:
        values["depth_m"] = 0.0
    table = values.pivot_table(index="t_s", columns="depth_m", values=["east_m_s", "north_m_s"], aggfunc="mean")
    if values.duplicated(["t_s", "depth_m"]).any():
        row = int(values.index[values.duplicated(["t_s", "depth_m"])][0])
        raise InputError([Problem("this row has the time and depth of an earlier one", shown, row)])
    if table.isna().to_numpy().any():
        raise InputError([Problem("every depth must be given at every time", shown)])
    lead = 0.0  # by which the record's epoch is after the mission's start
    if epoch is not None:
        if start is None:
            raise InputError([Problem("the record has a start: the mission needs its `start` (UTC) too", shown)])
        lead = (utc(epoch) - utc(start)).total_seconds()
    return SeriesCurrent(
        table.index.to_numpy(dtype=float) + lead,
        table["east_m_s"].columns.to_numpy(dtype=float),
        table["east_m_s"].to_numpy(dtype=float),
        table["north_m_s"].to_numpy(dtype=float),
    )


def _impossible(values: pd.DataFrame, limits: Mapping[str, float], shown: str) -> list[Problem]:
    """Rows with a current, a depth or a time that no sea has: a fill value, or another unit."""
    velocity = values[["east_m_s", "north_m_s"]].to_numpy(dtype=float)
    is_filled = velocity == undeclared_fill(*velocity.T)
    too_much = [is_filled.all(axis=1), *(values[name].abs() > most for name, most in limits.items())]
    rows = np.flatnonzero(np.any([*too_much, values["depth_m"] < 0.0] if "depth_m" in limits else too_much, axis=0))
    expected = ", ".join(f"{name} at most {most:g} in size" for name, most in limits.items())
    expected += ", depths positive down" if "depth_m" in limits else ""
    return [Problem(f"is impossible; expected {expected}", shown, int(values.index[row])) for row in rows[:20]]


def read_field(
    names: Sequence[str], area: Area, shown: str, member: int | None = None, carries: Carried = SEA
) -> GriddedCurrent:
    """Read the field that some files hold together.

    Raises InputError when they cannot be read, are of no grid that is known, or do not hold the mission's area.

    Parameters
    ----------
    names : sequence of str
        Paths, or addresses.
    shown : str
        How messages name them.
    member : int, optional
        Of an ensemble along a dimension of the files, from 0.
    carries : Carried
        Whether it is a current or a wind.
    """
    with opened(names, shown) as opened_files:
        files = replace(opened_files, carries=carries)
        files = files.at_one_height() if carries is WIND else files
        dimension = files.members()
        if dimension is not None:
            files = files.member(dimension, member or 0)
        return _read(files, area)


def member_count(names: Sequence[str], shown: str) -> int:
    """Count the members of the ensemble that files hold along a dimension; 1 where they hold none."""
    with opened(names, shown) as files:
        dimension = files.members()
        return 1 if dimension is None else int(max(d.sizes.get(dimension, 1) for d in files.datasets))


@contextmanager
def opened(names: Sequence[str], shown: str) -> Iterator[FieldFiles]:
    """Open files or addresses.

    Raises InputError when xarray is not installed, or one cannot be opened or, as long as it is open, read.
    """
    try:
        import xarray  # noqa: F401
    except ImportError:
        hint = how_to_install("netcdf")
        raise InputError([Problem("reading NetCDF needs xarray and netCDF4", shown, hint=hint)]) from None
    with ExitStack() as stack:
        datasets = [tidied(stack.enter_context(_opened(name))) for name in names]
        try:
            yield FieldFiles([tidied(run) for dataset in datasets for run in runs(dataset)], shown)
        except InputError:
            raise
        except FieldAttributeError as error:
            raise InputError([Problem(str(error), shown)]) from None
        except Exception as error:  # the libraries below raise many kinds for what is damaged
            raise _unreadable(error, shown) from None


def _opened(name: str) -> "Dataset":
    import xarray

    try:
        return xarray.open_dataset(name, decode_times=False)
    except Exception as error:  # the libraries below raise many kinds for what is damaged
        if name.startswith(REMOTE):
            words = str(error).partition("\n")[0]
            hint = "an OPeNDAP address needs the network; a copy of the part you need serves without one"
            raise InputError([Problem(f"cannot be opened: {words}", name, hint=hint)]) from None
        if not _begins_as_netcdf(name):
            raise InputError([Problem("is no NetCDF file; expected NetCDF 3 or 4", name)]) from None
        raise _unreadable(error, name) from None


def _unreadable(error: Exception, name: str) -> InputError:
    """Return the error of a file that a library below cannot read, by the first line of its words."""
    return InputError([Problem(f"cannot be read as NetCDF: {str(error).partition(chr(10))[0]}", name)])


def _begins_as_netcdf(name: str) -> bool:
    """Whether the first bytes are those of NetCDF 3, or of HDF5, which NetCDF 4 is."""
    try:
        with Path(name).open("rb") as file:
            first = file.read(4)
    except OSError:
        return True  # whatever is wrong, the library has said it
    return first[:3] == b"CDF" or first == b"\x89HDF"


def _read(files: FieldFiles, area: Area) -> GriddedCurrent:
    if files.named("nv") and files.named("u"):
        return read_fvcom(files, area)
    if topology(files) is not None:
        return read_ugrid(files, area)
    position = files.named("lon_rho", "x_rho", *LATITUDE, "nav_lat", standard=("latitude",))
    if position is None:
        looked = ", ".join((*LATITUDE, *LONGITUDE, "lon_rho", "nv"))
        raise files.problem(
            f"is no grid that is known: no variable for latitude; looked for {looked}, {files.carries.east[0]}"
        )
    if files.variable(position).ndim == 0:
        hint = f"a record is read as CSV, with the columns {', '.join(CURRENT_LIMITS)}"
        raise files.problem(f"is a record at one place: {position} is one number", hint)
    if files.variable(position).ndim == 2:
        return read_curved(files, area)
    return read_regular(files, area)
