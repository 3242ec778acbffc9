"""Dive logs: depth against time."""

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from missionplan.arrays import Array
from missionplan.datasets.reading import (
    RawDataset,
    problems_of,
    read_dataset,
    read_quantity,
)
from missionplan.errors import InputError, Problem
from missionplan.mission import Mission

COLUMNS = {"text": ("run",), "numeric": ("t_s", "depth_m", "pitch_deg", "density_kg_m3")}
RUN_KEYS = {"anchor_wet_weight": "N", "line_length": "m", "depth": "m"}


@dataclass(frozen=True)
class MeasuredDive:
    """One dive as it was logged.

    Attributes
    ----------
    name : str
        Of the run.
    t, depth : array, shape (m,)
        Time since the separation by the log's clock [s], and reading [m].
    wet_weight, line_length, site_depth : float
        Of this dive [N, m, m].
    """

    name: str
    t: Array
    depth: Array
    wet_weight: float
    line_length: float
    site_depth: float


@dataclass(frozen=True)
class DescentData:
    """Dives of a data set.

    Attributes
    ----------
    name, source, file : str
        Of the data set; its CSV as messages name it.
    dives : tuple of MeasuredDive
        In the order of the file.
    depth_noise : float or None
        Stated standard deviation of a reading [m].
    notices : tuple of str
        Treatments the reader should know of.
    """

    name: str
    source: str
    file: str
    dives: tuple[MeasuredDive, ...]
    depth_noise: float | None
    notices: tuple[str, ...]


def read_descent(folder: Path, mission: Mission) -> DescentData:
    """Read a data set of kind ``descent``.

    Raises
    ------
    InputError
        All problems of the folder at once.
    """
    raw = read_dataset(folder, {"descent": COLUMNS}, {"depth": "m"})
    problems = problems_of(raw, ("run", "t_s", "depth_m"))
    settings = _read_runs(raw, mission, problems)
    table = raw.table.dropna(subset=["t_s", "depth_m"])
    notices = list(raw.notices)
    if len(table) < len(raw.table):
        notices.append(f"{len(raw.table) - len(table)} rows without time or depth are left out")
    for column in ("pitch_deg", "density_kg_m3"):
        if column in table:
            notices.append(f"{column} is not used by the diagnosis of depths")
    dives: list[MeasuredDive] = []
    for name, run in table.groupby("run", sort=False):
        own = settings.get(str(name))
        problems += _check_run(str(name), run, own, raw)
        if own is not None and not problems:
            t, depth = run["t_s"].to_numpy(), run["depth_m"].to_numpy()
            dives.append(MeasuredDive(str(name), t, depth, *(own[key] for key in RUN_KEYS)))
    if problems:
        raise InputError(problems)
    return DescentData(raw.name, raw.source, raw.file, tuple(dives), raw.noise.get("depth"), tuple(notices))


def _read_runs(raw: RawDataset, mission: Mission, problems: list[Problem]) -> dict[str, dict[str, float]]:
    """Settings of each run: its own, else the mission's."""
    document, runs = raw.document, raw.document.data.get("runs") or {}
    if not isinstance(runs, dict):
        problems.append(document.problem(("runs",), "expected a mapping of runs to what differed in them"))
        return {}
    defaults = _mission_settings(mission)
    settings = {}
    for name, given in runs.items():
        if not isinstance(given, dict):
            problems.append(document.problem(("runs", name), "expected a mapping such as {anchor_wet_weight: 9.5 N}"))
            continue
        own: dict[str, float] = {}
        for key, text in given.items():
            if key not in RUN_KEYS:
                message = f"unknown key; expected one of {', '.join(RUN_KEYS)}"
                problems.append(document.problem(("runs", name, key), message))
                continue
            value = read_quantity(document, ("runs", name, key), text, RUN_KEYS[key], problems)
            if value is not None and value <= 0.0:
                problems.append(document.problem(("runs", name, key), f"given {text}, expected more than 0"))
            own[key] = math.nan if value is None else value
        settings[str(name)] = _complete(own, defaults, document.problem(("runs", name), ""), problems)
    return settings


def _complete(
    own: dict[str, float], defaults: dict[str, float], place: Problem, problems: list[Problem]
) -> dict[str, float]:
    complete = {**defaults, **own}
    for key in RUN_KEYS:
        if key not in complete:
            message = f"needs {key}: neither the run nor the mission has it"
            problems.append(Problem(message, place.file, place.line, place.key))
    if complete.get("depth", math.inf) <= complete.get("line_length", 0.0):
        message = "the line is as long as the site is deep: the vehicle is never pulled down"
        problems.append(Problem(message, place.file, place.line, place.key))
    return complete


def _mission_settings(mission: Mission) -> dict[str, float]:
    from missionplan.montecarlo.distributions import mean_of

    settings: dict[str, float] = {}
    if mission.site is not None and mission.site.depth is not None:
        settings["depth"] = mean_of(mission.site.depth)
    if mission.moors:
        moor = mission.moors[0]
        settings["line_length"] = mean_of(moor.line_length)
        if not isinstance(moor.anchor_wet_weight, str):
            settings["anchor_wet_weight"] = mean_of(moor.anchor_wet_weight)
    return settings


def _check_run(name: str, run: pd.DataFrame, own: dict[str, float] | None, raw: RawDataset) -> list[Problem]:
    first = int(run.index[0])
    if own is None:
        known = ", ".join(str(key) for key in (raw.document.data.get("runs") or {})) or "none"
        return [Problem(f"run {name!r} is not among runs: in dataset.yaml ({known})", raw.file, first, "run")]
    times = run["t_s"].to_numpy()
    problems = []
    steps = np.diff(times)
    for kind, wrong in (("twice", steps == 0.0), ("after a later one", steps < 0.0)):
        places = np.flatnonzero(wrong)
        if len(places):
            line = int(run.index[places[0] + 1])
            more = f"; {len(places) - 1} more like it" if len(places) > 1 else ""
            problems.append(Problem(f"{name}: a time stands {kind}{more}", raw.file, line, "t_s"))
    return problems
