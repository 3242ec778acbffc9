"""Rows of tank data as they are fitted: at most so many, and in blocks."""

import itertools
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from missionplan.datasets.tank import TankData, read_tank_data

MAX_ROWS = 600
"""Rows that are kept of a longer record, evenly."""
BLOCKS = 8
"""Blocks into which a record is divided."""
MAX_SINGLE_ROWS = 12
"""Up to so many rows each is a block by itself."""


def read_tank(folder: Path) -> TankData:
    """Read a data set of one of the tank's kinds, with the rows that are fitted.

    Raises
    ------
    InputError
        With every problem of `dataset.yaml` and of the tables.
    """
    return decimated(read_tank_data(folder))


def decimated(data: TankData) -> TankData:
    """Return every nth row of a long record, with a note of it."""
    count = len(next(iter(data.columns.values())))
    step = -(-count // MAX_ROWS)
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
    if count <= MAX_SINGLE_ROWS:
        return np.array([f"row {k + 1}" for k in range(count)])
    ends = np.linspace(0, count, BLOCKS + 1).astype(int)
    names = [f"rows {a + 1} to {b}" for a, b in itertools.pairwise(ends.tolist())]
    return np.repeat(names, np.diff(ends))
