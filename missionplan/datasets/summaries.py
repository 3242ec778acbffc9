"""Summaries of dives: a few numbers a test, as papers print them."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from missionplan.arrays import Array
from missionplan.datasets.reading import problems_of, read_dataset, read_quantity
from missionplan.errors import InputError, Problem
from missionplan.mission import Mission
from missionplan.montecarlo.distributions import mean_of

COLUMNS = {"text": ("run", "quantity"), "numeric": ("value", "sd")}
MEASURED = ("terminal_velocity_m_s", "descent_time_s")
SIMULATED = "simulated_"
RUN_UNITS = {"anchor_wet_weight": "N", "line_length": "m", "depth": "m"}
SCALE_SD = 0.05
"""Standard deviation of a number that states none, as a share of it."""


@dataclass(frozen=True)
class TestSummary:
    """Numbers of one test.

    Attributes
    ----------
    name : str
        Of the run.
    quantities : tuple of str
        Of `MEASURED`.
    values, sd : array, shape (m,)
        Measured, or measured less simulated where the table prints both [SI].
    relative : array of bool, shape (m,)
        Whether a value is such a difference.
    wet_weight, line_length, site_depth : float
        [N, m, m]
    """

    name: str
    quantities: tuple[str, ...]
    values: Array
    sd: Array
    relative: tuple[bool, ...]
    wet_weight: float
    line_length: float
    site_depth: float


@dataclass(frozen=True)
class SummaryData:
    """Tests of a data set of kind ``summary``."""

    name: str
    source: str
    tests: tuple[TestSummary, ...]
    notices: tuple[str, ...]


def read_summary(folder: Path, mission: Mission) -> SummaryData:
    """Read a data set of kind ``summary``.

    Raises
    ------
    InputError
        All problems of the folder at once.
    """
    raw = read_dataset(folder, {"summary": COLUMNS}, {})
    problems = problems_of(raw, ("run", "quantity", "value"))
    known = {*MEASURED, *(SIMULATED + name for name in MEASURED)}
    for line, name in raw.table["quantity"].items():
        if name not in known:
            message = f"given {name!r}, expected one of {', '.join(sorted(known))}"
            problems.append(Problem(message, raw.file, int(str(line)), "quantity"))
    runs: Mapping[str, Mapping[str, str]] = raw.document.data.get("runs") or {}
    tests, notices = [], [*raw.notices]
    for name, rows in raw.table.groupby("run", sort=False):
        own = dict(runs.get(str(name)) or {})
        given = {
            key: read_quantity(raw.document, ("runs", str(name), key), text, RUN_UNITS.get(key, "m"), problems)
            for key, text in own.items()
        }
        spreads = rows["sd"] if "sd" in rows else rows["value"] * np.nan
        numbers = {
            str(quantity): (float(value), float(sd))
            for quantity, value, sd in zip(rows["quantity"], rows["value"], spreads, strict=True)
        }
        tests.append(_test(str(name), numbers, _settings(mission, given), notices))
    if not any(test.quantities for test in tests):
        problems.append(Problem(f"holds none of {', '.join(MEASURED)}", raw.file))
    if problems:
        raise InputError(problems)
    return SummaryData(raw.name, raw.source, tuple(test for test in tests if test.quantities), tuple(notices))


def _settings(mission: Mission, given: Mapping[str, float | None]) -> dict[str, float]:
    moor, site = mission.moors[0] if mission.moors else None, mission.site
    settings = {key: value for key, value in given.items() if value is not None}
    if moor is not None:
        settings.setdefault("line_length", mean_of(moor.line_length))
        if not isinstance(moor.anchor_wet_weight, str):
            settings.setdefault("anchor_wet_weight", mean_of(moor.anchor_wet_weight))
    if site is not None and site.depth is not None:
        settings.setdefault("depth", mean_of(site.depth))
    missing = [key for key in RUN_UNITS if key not in settings]
    if missing:
        raise InputError(f"{mission.file}: neither the runs nor the mission give {', '.join(missing)}")
    return settings


def _test(
    name: str, numbers: Mapping[str, tuple[float, float]], settings: Mapping[str, float], notices: list[str]
) -> TestSummary:
    found = [quantity for quantity in MEASURED if quantity in numbers]
    values, spreads, relative = [], [], []
    for quantity in found:
        value, sd = numbers[quantity]
        if not np.isfinite(sd):
            sd = SCALE_SD * abs(value)
            notices.append(f"{name}: {quantity} states no sd; {100 * SCALE_SD:g} % is assumed")
        simulated = numbers.get(SIMULATED + quantity)
        values.append(value - simulated[0] if simulated else value)
        spreads.append(sd)
        relative.append(simulated is not None)
    keys = ("anchor_wet_weight", "line_length", "depth")
    return TestSummary(
        name, tuple(found), np.array(values), np.array(spreads), tuple(relative), *(settings[key] for key in keys)
    )
