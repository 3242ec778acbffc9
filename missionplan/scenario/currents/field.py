"""The field of an ocean model from its files: which model's they are, and the reader for its grid."""

from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from missionplan.errors import InputError, Problem
from missionplan.mission.reading.includes import REMOTE
from missionplan.packages import how_to_install
from missionplan.phases.fields.gridded_current import GriddedCurrent
from missionplan.scenario.currents.area import Area
from missionplan.scenario.currents.attributes import FieldAttributeError, tidied
from missionplan.scenario.currents.files import SEA, WIND, Carried, FieldFiles
from missionplan.scenario.currents.regular import LATITUDE, LONGITUDE, read_curved, read_regular
from missionplan.scenario.currents.unstructured import read_fvcom, read_ugrid, topology

if TYPE_CHECKING:
    from xarray import Dataset


def read_field(
    names: Sequence[str], area: Area, shown: str, member: int | None = None, carries: Carried = SEA
) -> GriddedCurrent:
    """Read the field that some files hold together.

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

    Raises
    ------
    InputError
        When they cannot be read, are of no grid that is known, or do not hold the mission's area.
    """
    with opened(names, shown) as opened_files:
        files = replace(opened_files, carries=carries)
        files = files.at_one_height() if carries is WIND else files
        dimension = files.members()
        if dimension is not None:
            files = files.member(dimension, member or 0)
        try:
            return _read(files, area)
        except InputError:
            raise
        except FieldAttributeError as error:
            raise files.problem(str(error)) from None
        except Exception as error:  # the libraries below raise many kinds for what is damaged
            words = str(error).partition("\n")[0]
            raise InputError([Problem(f"cannot be read as NetCDF: {words}", shown)]) from None


def member_count(names: Sequence[str], shown: str) -> int:
    """Count the members of the ensemble that files hold along a dimension; 1 where they hold none."""
    with opened(names, shown) as files:
        dimension = files.members()
        return 1 if dimension is None else int(max(d.sizes.get(dimension, 1) for d in files.datasets))


@contextmanager
def opened(names: Sequence[str], shown: str) -> Iterator[FieldFiles]:
    """Open files or addresses.

    Raises
    ------
    InputError
        When xarray is not installed, or one cannot be opened.
    """
    try:
        import xarray  # noqa: F401
    except ImportError:
        hint = how_to_install("netcdf")
        raise InputError([Problem("reading NetCDF needs xarray and netCDF4", shown, hint=hint)]) from None
    with ExitStack() as stack:
        yield FieldFiles([stack.enter_context(_opened(name)) for name in names], shown)


def _opened(name: str) -> "Dataset":
    import xarray

    try:
        return tidied(xarray.open_dataset(name, decode_times=False))
    except Exception as error:  # the libraries below raise many kinds for what is damaged
        words = str(error).partition("\n")[0]
        if name.startswith(REMOTE):
            hint = "an OPeNDAP address needs the network; a copy of the part you need serves without one"
            raise InputError([Problem(f"cannot be opened: {words}", name, hint=hint)]) from None
        if not _begins_as_netcdf(name):
            raise InputError([Problem("is no NetCDF file; expected NetCDF 3 or 4", name)]) from None
        raise InputError([Problem(f"cannot be read as NetCDF: {words}", name)]) from None


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
    if files.variable(position).ndim == 2:
        return read_curved(files, area)
    return read_regular(files, area)
