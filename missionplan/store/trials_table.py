"""A table with one row a trial, written as it grows."""

import io
from collections.abc import Mapping
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from missionplan.errors import InputError, Problem
from missionplan.packages import how_to_install

if TYPE_CHECKING:  # workers import this module: pandas takes half a second
    import pandas as pd


class TrialsTable:
    """Parquet in memory, a row group a block: inputs, quantities and events of every trial; null where not reached."""

    def __init__(self) -> None:
        """Start an empty table.

        Raises
        ------
        InputError
            When pyarrow, which writes it, is not installed: found out before the first trial is run.
        """
        try:
            import_module("pyarrow")
        except ImportError as error:
            raise InputError([Problem(f"needs pyarrow: {how_to_install('parquet')}", key="keep_trials")]) from error
        self._content = io.BytesIO()
        self._writer: Any = None

    def add(self, first: int, rows: Mapping[str, NDArray[np.generic]]) -> None:
        """Add a block whose first trial has the number `first`."""
        import pyarrow
        from pyarrow import parquet

        size = len(next(iter(rows.values())))
        columns = {"trial": pyarrow.array(np.arange(first, first + size))}
        columns |= {
            name: pyarrow.array(np.ascontiguousarray(values), from_pandas=True) for name, values in rows.items()
        }
        table = pyarrow.table(columns)
        if self._writer is None:
            self._writer = parquet.ParquetWriter(self._content, table.schema, compression="zstd")
        self._writer.write_table(table)

    def parquet(self) -> bytes:
        """Close the table and return the file."""
        self._writer.close()
        return self._content.getvalue()


def read_trials(content: bytes | None) -> "pd.DataFrame":
    """Read the table that a run kept.

    Raises
    ------
    InputError
        When it kept none.
    """
    if content is None:
        hint = "simulate(..., keep_trials=True) keeps them"
        raise InputError([Problem("the trials were not kept", key="trials", hint=hint)])
    from pandas import read_parquet

    return read_parquet(io.BytesIO(content))
