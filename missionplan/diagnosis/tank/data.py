"""Rows of tank data as the diagnosis takes them: at most so many, and in blocks."""

import itertools
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from missionplan.datasets.tank import TankData, read_tank_data

MOST_ROWS = 600
"""Rows that are kept of a longer record, evenly."""
BLOCK_COUNT = 8
LEAVE_ONE_OUT_ROWS = 12
"""Up to so many rows each is held out by itself."""


@dataclass(frozen=True)
class TankSet:
    """A data set of the tank with what a report says of it."""

    name: str
    source: str
    notices: tuple[str, ...]
    tank: TankData


def read_tank(folder: Path) -> TankSet:
    """Read a data set of one of the tank's kinds.

    Raises
    ------
    InputError
        With every problem of `dataset.yaml` and of the tables.
    """
    data = every_nth_row(read_tank_data(folder))
    return TankSet(data.name, data.settings.source, data.notices, data)


def every_nth_row(data: TankData) -> TankData:
    """Keep every so-manieth row of a long record, and note it."""
    count = len(next(iter(data.columns.values())))
    step = -(-count // MOST_ROWS)
    if step == 1:
        return data
    note = f"{count} rows: every {step}th is used"
    return replace(
        data,
        columns={name: column[::step] for name, column in data.columns.items()},
        labels={name: column[::step] for name, column in data.labels.items()},
        notices=(*data.notices, note),
    )


def row_blocks(count: int) -> NDArray[np.str_]:
    """Name of each row's block: rows one by one where they are few, else even blocks in their order."""
    if count <= LEAVE_ONE_OUT_ROWS:
        return np.array([f"row {k + 1}" for k in range(count)])
    ends = np.linspace(0, count, BLOCK_COUNT + 1).astype(int)
    names = [f"rows {a + 1} to {b}" for a, b in itertools.pairwise(ends.tolist())]
    return np.repeat(names, np.diff(ends))
