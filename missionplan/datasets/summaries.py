"""Summaries of dives: a few numbers a test, as papers print them."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.datasets import DatasetFormat, RawDataset, read_dataset
from missionplan.datasets.dives import (
    DEEPEST,
    FASTEST,
    SLOWEST,
    DiveConditions,
    DivesSettings,
    conditions_of_runs,
    date_of_runs,
)
from missionplan.datasets.records import row_identities, row_texts, written_once
from missionplan.datasets.table import Columns, problems_at, wrong_cells
from missionplan.errors import Problem, did_you_mean
from missionplan.mission import Mission

SUMMARY = DatasetFormat(
    "summary",
    DivesSettings,
    Columns((("run", "quantity", "value"),), optional=("sd",), text=("run", "quantity")),
)
MEASURED = ("terminal_velocity_m_s", "descent_time_s")
SIMULATED = "simulated_"
KNOWN = tuple(sorted((*MEASURED, *(SIMULATED + quantity for quantity in MEASURED))))
RELATIVE_SD = 0.05
"""Standard deviation of a number that states none, as a share of it."""


@dataclass(frozen=True)
class TestSummary:
    """Numbers of one test."""

    name: str
    """Of the run."""
    quantities: tuple[str, ...]
    """Of `MEASURED`."""
    values: Array
    sd: Array
    """Shape (m,). Measured, or measured less simulated where the table prints both [SI]."""
    relative: tuple[bool, ...]
    """Whether a value is such a difference."""
    wet_weight: float
    line_length: float
    site_depth: float
    """[N, m, m]."""


@dataclass(frozen=True)
class SummaryData:
    """Tests of a data set of kind ``summary``."""

    name: str
    source: str
    tests: tuple[TestSummary, ...]
    notices: tuple[str, ...]
    date: float = math.nan
    """Of the tests [s since 1970]; nan where it is not known."""

    @property
    def identities(self) -> tuple[str, ...]:
        """Hash of each test."""
        return row_identities("summary", _numbers_of(self.tests))

    def subset(self, keep: NDArray[np.bool_]) -> "SummaryData":
        """Keep some of the tests."""
        return replace(self, tests=tuple(test for test, is_kept in zip(self.tests, keep, strict=True) if is_kept))


def read_summary(folder: Path, mission: Mission) -> SummaryData:
    """Read a data set of kind ``summary``.

    `mission`: for anchor, line and site where the runs say nothing of them. Raises InputError: all problems of the
    folder at once.
    """
    raw = read_dataset(folder, SUMMARY)
    runs = {str(name): run for name, run in raw.table.groupby("run", sort=False)}
    conditions, incomplete = conditions_of_runs(runs, raw, mission)
    settings = raw.checked([*_check_quantities(raw), *incomplete, *_check_speeds(raw, conditions)])
    notices = list(raw.notices)
    tests = [_test(name, _numbers(run), conditions[name], notices) for name, run in runs.items()]
    tests = [test for test in tests if test.quantities]
    once = written_once(_numbers_of(tests))
    if not once.all():
        notices.append(f"the tests stand {len(once) // once.sum()} times over, and count once")
    date = date_of_runs([test.name for test in tests], settings)
    return SummaryData(raw.name, raw.source, tuple(tests), tuple(notices), date).subset(once)


def _numbers_of(tests: Sequence[TestSummary]) -> list[str]:
    """Quantities and values of each test, as text."""
    return [" ".join(row_texts([test.quantities, test.values])) for test in tests]


def _check_quantities(raw: RawDataset[DivesSettings]) -> list[Problem]:
    quantities = raw.table["quantity"]

    def unknown(line: int) -> Problem:
        message = f"given {quantities[line]!r}, expected one of {', '.join(KNOWN)}"
        return Problem(message, raw.file, line, "quantity", did_you_mean(quantities[line], KNOWN))

    problems = problems_at(quantities.index[~quantities.isin(KNOWN)], unknown)
    problems += wrong_cells(raw.table.index[raw.table["value"] <= 0.0], "expected more than 0", raw.file, "value")
    if "sd" in raw.table:
        problems += wrong_cells(raw.table.index[raw.table["sd"] <= 0.0], "expected more than 0", raw.file, "sd")
    twice = raw.table.duplicated(["run", "quantity"])
    problems += wrong_cells(raw.table.index[twice], "this run has this quantity already", raw.file, "quantity")
    if not quantities.isin(MEASURED).any() and not raw.table.empty:
        problems.append(Problem(f"holds none of {', '.join(MEASURED)}", raw.file))
    return problems


def _check_speeds(raw: RawDataset[DivesSettings], conditions: Mapping[str, DiveConditions]) -> list[Problem]:
    """Return a problem for each speed and time of a descent that no dive has."""
    problems = []
    for line, (run, quantity, value) in zip(
        raw.table.index, raw.table[["run", "quantity", "value"]].to_numpy(), strict=True
    ):
        if run not in conditions or not value > 0.0:
            continue
        is_time = str(quantity).endswith("_time_s")
        if is_time and conditions[run].site_depth >= DEEPEST:  # not known yet
            continue
        speed = conditions[run].site_depth / value if is_time else value
        if not SLOWEST <= speed <= FASTEST:
            words = f"{value:g} s down to {conditions[run].site_depth:g} m" if is_time else "a descent"
            message = f"{words} at {speed:.3g} m/s; expected from {SLOWEST:g} to {FASTEST:g} m/s"
            problems.append(Problem(message, raw.file, int(line), "value"))
    return problems


def _numbers(run: pd.DataFrame) -> dict[str, tuple[float, float]]:
    """Value and standard deviation of each quantity; nan where none is stated."""
    sd = run["sd"] if "sd" in run else run["value"] * np.nan
    return {
        str(quantity): (float(value), float(spread))
        for quantity, value, spread in zip(run["quantity"], run["value"], sd, strict=True)
    }


def _test(
    name: str, numbers: Mapping[str, tuple[float, float]], conditions: DiveConditions, notices: list[str]
) -> TestSummary:
    quantities = tuple(quantity for quantity in MEASURED if quantity in numbers)
    simulated = [numbers.get(SIMULATED + quantity) for quantity in quantities]
    values, spreads = [], []
    for quantity, other in zip(quantities, simulated, strict=True):
        value, sd = numbers[quantity]
        if not np.isfinite(sd):
            sd = RELATIVE_SD * abs(value)
            notices.append(f"{name}: {quantity} states no sd; {100 * RELATIVE_SD:g} % is assumed")
        values.append(value - other[0] if other else value)
        spreads.append(sd)
    return TestSummary(
        name,
        quantities,
        np.array(values),
        np.array(spreads),
        tuple(other is not None for other in simulated),
        conditions.wet_weight,
        conditions.line_length,
        conditions.site_depth,
    )
