"""Rows of tank data as the diagnosis takes them: at most so many, and in blocks."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from missionplan.studies.tank_data import TankData

MOST = 600
"""Rows that are kept of a longer record, evenly."""
BLOCKS = 8
FEW = 12
"""Up to so many rows each is held out by itself."""


def thinned(data: TankData) -> TankData:
    """Keep every so-manieth row of a long record, and note it."""
    count = len(next(iter(data.columns.values())))
    step = -(-count // MOST)
    if step == 1:
        return data
    note = f"{count} rows: every {step}th is used"
    return replace(
        data,
        columns={name: column[::step] for name, column in data.columns.items()},
        labels={name: column[::step] for name, column in data.labels.items()},
        notes=(*data.notes, note),
    )


def blocks(count: int) -> NDArray[np.str_]:
    """Name of each row's block: rows one by one where they are few, else even blocks in their order."""
    if count <= FEW:
        return np.array([f"row {k + 1}" for k in range(count)])
    ends = np.linspace(0, count, BLOCKS + 1).astype(int)
    names = [f"rows {a + 1} to {b}" for a, b in zip(ends[:-1], ends[1:], strict=True)]
    return np.repeat(names, np.diff(ends))
