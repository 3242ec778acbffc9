"""A current at one place from a CSV file: a series against time and depth. Arrays out, in SI."""

import math
from collections.abc import Mapping
from datetime import datetime
from pathlib import Path

import numpy as np
import pandas as pd

from missionplan.datasets.table import plain_table
from missionplan.errors import InputError, Problem
from missionplan.moments import epoch_seconds, utc
from missionplan.phases.recorded_currents import SeriesCurrent

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

    Parameters
    ----------
    limits : mapping of str to float
        Columns, and the size beyond which a number of each is impossible.
    start : datetime, optional
        Of the mission: times by ISO 8601 count from it.
    epoch : datetime, optional
        From which the record's seconds count (`site.current.start`); default: from the mission's start, whenever it is.

    Raises
    ------
    InputError
        With every problem of the file.
    """
    shown = str(path)
    frame = plain_table(path, limits, MAX_BYTES)
    values = frame[list(limits)].apply(pd.to_numeric, errors="coerce")
    if not pd.api.types.is_numeric_dtype(frame["t_s"]):
        if epoch is not None:
            message = "its times are dates, which site.current.start does not shift: leave it out, or give seconds"
            raise InputError([Problem(message, shown)])
        values["t_s"] = values["t_s"].fillna(_since(start, frame["t_s"], shown))
    bad = np.flatnonzero(~np.isfinite(values.to_numpy(dtype=float)).all(axis=1))
    problems = [Problem(f"expected {len(limits)} numbers", shown, int(row) + 2) for row in bad[:20]]
    problems = problems or _impossible(values, limits, shown)
    if problems:
        raise InputError(problems)
    if "depth_m" not in limits:
        values["depth_m"] = 0.0
    table = values.pivot_table(index="t_s", columns="depth_m", values=["east_m_s", "north_m_s"], aggfunc="mean")
    if values.duplicated(["t_s", "depth_m"]).any():
        row = int(np.flatnonzero(values.duplicated(["t_s", "depth_m"]))[0])
        raise InputError([Problem("this row has the time and depth of an earlier one", shown, row + 2)])
    if table.isna().to_numpy().any():
        raise InputError([Problem("every depth must be given at every time", shown)])
    return SeriesCurrent(
        table.index.to_numpy(dtype=float) + _lead(start, epoch, shown),
        table["east_m_s"].columns.to_numpy(dtype=float),
        table["east_m_s"].to_numpy(dtype=float),
        table["north_m_s"].to_numpy(dtype=float),
    )


def _lead(start: datetime | None, epoch: datetime | None, shown: str) -> float:
    """Seconds by which a record's epoch is after the mission's start; 0 where the record has none."""
    if epoch is None:
        return 0.0
    if start is None:
        raise InputError([Problem("the record has a start: the mission needs its `start` (UTC) too", shown)])
    return (utc(epoch) - utc(start)).total_seconds()


def _impossible(values: pd.DataFrame, limits: Mapping[str, float], shown: str) -> list[Problem]:
    """Rows with a current, a depth or a time that no sea has: a fill value, or another unit."""
    too_much = [values[name].abs() > most for name, most in limits.items()]
    rows = np.flatnonzero(np.any(too_much, axis=0))
    expected = ", ".join(f"{name} at most {most:g} in size" for name, most in limits.items())
    return [Problem(f"is impossible; expected {expected}", shown, int(row) + 2) for row in rows[:20]]


def _since(start: datetime | None, times: "pd.Series[str]", shown: str) -> "pd.Series[float]":
    """Times by ISO 8601 as seconds since the mission's start, nan where a cell holds none."""
    moments = epoch_seconds(times)
    if start is None:
        if moments.notna().any() and pd.to_numeric(times, errors="coerce").isna().all():
            raise InputError([Problem("its times are of the day: the mission needs its `start` (UTC)", shown)])
        return moments * math.nan
    return moments - utc(start).timestamp()
