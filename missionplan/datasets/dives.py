"""Dive logs: depth against time, trimmed of bottom contact and thinned."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.datasets.reading import (
    RawDataset,
    problems_of,
    read_dataset,
    read_quantity,
)
from missionplan.errors import InputError, Problem
from missionplan.mission.schema.mission import Mission

COLUMNS = {"text": ("run",), "numeric": ("t_s", "depth_m", "pitch_deg", "density_kg_m3")}
RUN_KEYS = {"anchor_wet_weight": "N", "line_length": "m", "depth": "m"}

MOST_SAMPLES = 70
LEAST_SAMPLES = 10
LEAST_DIVES = 2
NEEDED = (
    f"{LEAST_DIVES} dives are needed to hold one out, 3 to find an outlying one, and two different anchor weights or "
    "line lengths to tell most causes apart"
)
MARGIN = 0.12
"""Share of the vehicle's depth at touchdown that is cut off above it."""
FINE = 6
STARTED = 0.15
"""Reading from which a dive is fitted [m]: before, the sensor rests, and quantised readings have no white noise."""
GROWTH = 1.6
"""Power by which bins grow along a dive: what tells a sensor's lag from a late clock is over in a second or two."""
LEAST_NOISE = 0.008
"""What neither sensor nor integration is better than, over a bin [m]."""
TOO_DEEP, TOO_FAST = 1.5, 3.0
"""Readings over the site's depth, and their rate [m/s], above which metres are doubted."""


@dataclass(frozen=True)
class DiveLog:
    """One dive as it is fitted.

    Attributes
    ----------
    name : str
        Of the run.
    t, depth, sd : array, shape (m,)
        Time since the separation by the log's clock [s], reading [m], and its noise's standard deviation [m], each
        of a bin of neighbours.
    fine : array, shape (f,)
        Times within the bins [s]: a model is averaged over them as the readings were.
    bins : array of int, shape (f,)
        Bin of each of them.
    shares : array, shape (f,)
        Weight of each in its bin's mean.
    wet_weight, line_length, site_depth : float
        Of this dive [N, m, m].
    """

    name: str
    t: Array
    depth: Array
    sd: Array
    fine: Array
    bins: NDArray[np.int_]
    shares: Array
    wet_weight: float
    line_length: float
    site_depth: float


@dataclass(frozen=True)
class DescentData:
    """Dives of a data set.

    Attributes
    ----------
    name, source : str
        Of the data set.
    dives : tuple of DiveLog
        In the order of the file.
    notices : tuple of str
        Treatments the reader should know of.
    """

    name: str
    source: str
    dives: tuple[DiveLog, ...]
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
    dives: list[DiveLog] = []
    deepest: dict[str, tuple[float, float]] = {}
    for name, run in table.groupby("run", sort=False):
        own = settings.get(str(name))
        problems += _check_run(str(name), run, own, raw)
        if own is not None:
            deepest[str(name)] = (float(run["depth_m"].max()), own.get("depth", math.inf))
        if own is not None and not problems:
            dive = _prepare(str(name), run, own, raw.noise.get("depth"), notices)
            dives += [dive] if dive else []
    if len(dives) < LEAST_DIVES and not problems:
        problems.append(Problem(f"has {len(dives)} usable dives, too few: {NEEDED}", raw.file))
    if problems:
        raise InputError(problems)
    notices += _suspicions(deepest, dives)
    return DescentData(raw.name, raw.source, tuple(dives), tuple(notices))


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


def _prepare(
    name: str, run: pd.DataFrame, own: dict[str, float], stated: float | None, notices: list[str]
) -> DiveLog | None:
    """Trim start and bottom contact, estimate the noise, thin by averaging; None when too little is left."""
    t, depth = run["t_s"].to_numpy(), run["depth_m"].to_numpy()
    deepest = (1.0 - MARGIN) * (own["depth"] - own["line_length"])
    beyond = np.flatnonzero(depth > deepest)
    end = int(beyond[0]) if len(beyond) else len(t)
    moving = np.flatnonzero(depth > STARTED)
    first = t[moving[0]] if len(moving) else 0.0
    keep = (np.arange(len(t)) < end) & (t >= max(0.0, first))
    t, depth = t[keep], depth[keep]
    if len(t) < LEAST_SAMPLES:
        notices.append(f"{name} is left out: {len(t)} samples between separation and touchdown, {LEAST_SAMPLES} needed")
        return None
    gap = float(np.diff(t).max())
    if gap > 0.2 * float(np.ptp(t)) and gap > 5.0 * float(np.median(np.diff(t))):
        notices.append(f"{name}: a gap of {gap:.1f} s in the log")
    noise = max(stated or 0.0, estimate_noise(t, depth))
    return binned(name, t, depth, noise, own["anchor_wet_weight"], own["line_length"], own["depth"])


def estimate_noise(t: Array, depth: Array) -> float:
    """Standard deviation of white noise, from how far each reading lies off the line between its neighbours [m].

    By the median size of that, each over its own standard deviation: times need not be even. A quantised reading can
    have a median of zero; then by the root mean square.

    Parameters
    ----------
    t, depth : array, shape (m,)
        Times [s] and readings [m].
    """
    share = (t[1:-1] - t[:-2]) / (t[2:] - t[:-2])
    off = depth[1:-1] - (1.0 - share) * depth[:-2] - share * depth[2:]
    scaled = off / np.sqrt(1.0 + share**2 + (1.0 - share) ** 2)
    by_median = float(np.median(np.abs(scaled))) / 0.6745
    return by_median if by_median > 0.0 else float(np.sqrt(np.mean(scaled**2)))


def binned(
    name: str, t: Array, depth: Array, noise: float, wet_weight: float, line_length: float, site_depth: float
) -> DiveLog:
    """Average neighbours until at most `MOST_SAMPLES` are left, and remember where in its bin each reading was.

    Within a bin at most `FINE` times are kept, of readings averaged first where there are more.
    """
    edges = np.arange(1, len(t))
    if len(t) > MOST_SAMPLES:
        shares = np.arange(1, MOST_SAMPLES) / MOST_SAMPLES
        edges = np.unique(np.maximum(np.round(len(t) * shares**GROWTH), 1.0)).astype(int)
    parts = np.split(np.arange(len(t)), edges)
    counts = np.array([len(part) for part in parts])
    inner = [piece for part in parts for piece in np.array_split(part, min(len(part), FINE))]
    fine = np.array([t[piece].mean() for piece in inner])
    bins = np.repeat(np.arange(len(parts)), np.minimum(counts, FINE))
    weights = np.array([len(piece) for piece in inner]) / counts[bins]
    times, depths = (np.array([values[part].mean() for part in parts]) for values in (t, depth))
    sd = np.maximum(noise / np.sqrt(counts), LEAST_NOISE)
    return DiveLog(name, times, depths, sd, fine, bins, weights, wet_weight, line_length, site_depth)


def _suspicions(deepest: Mapping[str, tuple[float, float]], dives: Sequence[DiveLog]) -> list[str]:
    """Say aloud, and never convert, when depths look like feet: deeper than the site, or faster than can be."""
    ratios = [reading / site for reading, site in deepest.values()]
    rate = float(np.median([_rate(dive) for dive in dives])) if dives else 0.0
    if ratios and np.median(ratios) > TOO_DEEP:
        seen = f"depths reach {np.median(ratios):.1f} times the depth of the site"
    elif rate > TOO_FAST:
        seen = f"depths grow by {rate:.1f} a second, faster than such a vehicle sinks in metres"
    else:
        return []
    return [f"{seen}: are they in feet (0.3048 m)? Nothing was converted"]


def _rate(dive: DiveLog) -> float:
    half = len(dive.t) // 2
    return float(np.polyfit(dive.t[half:], dive.depth[half:], 1)[0])
