"""pyglider's gridded time series, which hold no dead reckoning: refused with words."""

from collections.abc import Sequence
from pathlib import Path

from missionplan.errors import InputError, Problem
from missionplan.importers.importer import Importer, ReadOptions, SourceLog
from missionplan.importers.sourcefiles.netcdf import MAGIC, variable_names
from missionplan.importers.track import Track

_MARKS = {"latitude", "longitude", "profile_index", "distance_over_ground"}


def recognises(path: Path, head: bytes) -> bool:
    """Whether a file is a time series made by pyglider."""
    return path.suffix == ".nc" and head.startswith(MAGIC) and variable_names(path, "pyglider") >= _MARKS


def read(files: Sequence[Path], options: ReadOptions, log: SourceLog) -> Track:
    """Say why there is nothing to import.

    Raises
    ------
    InputError
        Always.
    """
    message = (
        "is pyglider's time series: its position is interpolated between the fixes, so that it holds no dead reckoning "
        "and no error of a leg"
    )
    raise InputError([Problem(message, str(path), hint="import the vehicle's raw logs") for path in files])


IMPORTERS = (Importer("pyglider", "pyglider's time series, refused: they hold no dead reckoning", recognises, read),)
