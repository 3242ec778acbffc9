"""Checks of a navigation log's legs: enough of them, in order, and with possible values."""

import numpy as np
import pandas as pd

from missionplan.datasets.runs import DEEPEST
from missionplan.datasets.table import problems_at
from missionplan.errors import Problem, counted

MIN_LEGS = 8
MAX_LEGS = 2000
NEEDED = (
    f"{MIN_LEGS} legs are needed to tell a constant error from chance, 20 to find persistence, "
    "and a record of half a tidal period to find a tide"
)
LATITUDES = ("lat_start", "lat_dr_end", "lat_end")
LONGITUDES = ("lon_start", "lon_dr_end", "lon_end")
HIGHEST = -2.0
"""Mean depth that waves and an offset of the gauge leave a leg at the surface [m]."""
OVERLAP = 1.0
"""Time by which a leg may start before the previous one has ended: rounding [s]."""


def check_legs(legs: pd.DataFrame, file: str) -> list[Problem]:
    """Return everything that is wrong with the legs of a log.

    Parameters
    ----------
    legs : DataFrame
        Columns of a data set of kind ``transit``; the index is the file's line.
    file : str
        As messages name it.
    """
    problems = []
    if 0 < len(legs) < MIN_LEGS:
        problems.append(Problem(f"has {counted(len(legs), 'usable leg')}, too few: {NEEDED}", file))
    if len(legs) > MAX_LEGS:
        problems.append(Problem(f"has {len(legs)} legs; expected at most {MAX_LEGS}", file, hint="split it"))
    problems += [*_check_durations(legs, file), *_check_degrees(legs, file)]
    for _, run in legs.groupby(legs["run"] if "run" in legs else pd.Series("", index=legs.index)):
        problems += _check_order(run, file)
    return problems


def _at(lines: pd.Index, message: str, file: str, column: str) -> list[Problem]:
    return problems_at(lines, lambda line: Problem(message, file, line, column))


def _check_durations(legs: pd.DataFrame, file: str) -> list[Problem]:
    surface = legs["surface_s"].fillna(0.0) if "surface_s" in legs else pd.Series(0.0, index=legs.index)
    short = legs.index[legs["t_end_s"] - legs["t_start_s"] - surface <= 0.0]
    negative = legs.index[surface < 0.0]
    stated = legs["fix_sd_m"] if "fix_sd_m" in legs else pd.Series(1.0, index=legs.index)
    poor = legs.index[stated <= 0.0]
    depth = legs["depth_m"] if "depth_m" in legs else pd.Series(0.0, index=legs.index)
    nowhere = legs.index[(depth < HIGHEST) | (depth > DEEPEST)]
    return [
        *_at(nowhere, f"expected the leg's mean depth in metres, {HIGHEST:g} to {DEEPEST:g}", file, "depth_m"),
        *_at(poor, "expected more than 0 m", file, "fix_sd_m"),
        *_at(short, "the leg ends before it has begun", file, "t_end_s"),
        *_at(negative, "is negative", file, "surface_s"),
    ]


def _check_degrees(legs: pd.DataFrame, file: str) -> list[Problem]:
    problems = []
    for columns, limit in ((LATITUDES, 90.0), (LONGITUDES, 360.0)):
        for column in columns:
            if column in legs:
                message = f"expected degrees, at most {limit:g}"
                problems += _at(legs.index[legs[column].abs() > limit], message, file, column)
    return problems


def _check_order(run: pd.DataFrame, file: str) -> list[Problem]:
    """Check that the legs of one run follow one another."""
    repeated = run.index[run["t_start_s"].duplicated()]
    ordered = run.sort_values("t_start_s")
    starts, ends = ordered["t_start_s"].to_numpy(), ordered["t_end_s"].to_numpy()
    overlaps = (starts[1:] < ends[:-1] - OVERLAP) & (np.diff(starts) > 0.0)
    return [
        *_at(repeated, "two legs start at the same time", file, "t_start_s"),
        *_at(ordered.index[1:][overlaps], "the leg starts before the one before it has ended", file, "t_start_s"),
    ]
