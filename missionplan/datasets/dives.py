"""Dive logs: depth against time.

Runs of dives: anchor, line and site of each, from `runs:` in `dataset.yaml`, else from the mission.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from itertools import chain
from pathlib import Path
from typing import Annotated

import numpy as np
import pandas as pd
from pydantic import Field
from typing_extensions import Doc

from missionplan.arrays import Array
from missionplan.datasets import DatasetFormat, DatasetSettings, RawDataset, read_dataset
from missionplan.datasets.records import DescentData, MeasuredDive, as_other, listed, repeated
from missionplan.datasets.table import Columns, wrong_cells
from missionplan.errors import Problem, counted, did_you_mean
from missionplan.mission import Mission
from missionplan.mission.schema import FileSection, Moment
from missionplan.mission.schema import quantity_parser as q
from missionplan.moments import EPOCH_SCALE
from missionplan.montecarlo.distributions import mean_of

Weight = Annotated[float, q.fixed("N", open_low=True)]


_CONDITIONS = ("anchor_wet_weight", "line_length", "depth")
DEEPEST = 11_000.0
"""Of the sea [m]."""


class RunSection(FileSection):
    """What differed from the mission in one run, and when its anchor separated, where its times are of the day."""

    anchor_wet_weight: Annotated[Weight | None, Doc("weight of this dive's anchor in water")] = None
    line_length: Annotated[q.FixedLength | None, Doc("length of this dive's line")] = None
    depth: Annotated[q.FixedLength | None, Doc("depth of the water there")] = None
    start: Annotated[Moment | None, Doc("date of this dive, where it is another than the data set's")] = None
    separation: Annotated[Moment | None, Doc("time at which the anchor separated")] = None

    @property
    def date(self) -> datetime | None:
        """When it was made, as far as the run says it."""
        return self.start or self.separation


class DivesSettings(DatasetSettings):
    """Keys of a data set of dives."""

    start: Annotated[Moment | None, Doc("date of the dives")] = None
    runs: Annotated[
        Mapping[str, RunSection], Doc("what differed, dive by dive"), Field(examples=[{"dive-1": {"depth": "40 m"}}])
    ] = {}


def date_of_runs(names: Iterable[str], settings: DivesSettings) -> float:
    """Mean date of runs [s since 1970]; nan where one has none."""
    dates = [settings.runs.get(name, RunSection()).date or settings.start for name in names]
    moments = [date.timestamp() for date in dates if date is not None]
    return math.fsum(moments) / len(moments) if moments and len(moments) == len(dates) else math.nan


@dataclass(frozen=True)
class DiveConditions:
    """Anchor's wet weight [N], length of the line [m] and depth of the site [m] of one dive."""

    wet_weight: float
    line_length: float
    site_depth: float


def conditions_of_runs(
    names: Iterable[str], raw: RawDataset[DivesSettings], mission: Mission
) -> tuple[dict[str, DiveConditions], list[Problem]]:
    """Return the conditions of the runs, and what is wrong with them.

    `names`: of the runs. `raw`: what ``dataset.yaml`` says of them. `mission`: where the rest is taken from, at its
    means.
    """
    conditions: dict[str, DiveConditions] = {}
    problems: list[Problem] = []
    if raw.settings is None:
        return conditions, problems
    default, names = _of_mission(mission), tuple(names)
    for name in raw.settings.runs:
        if name not in names:
            hint = did_you_mean(name, names)
            problems.append(raw.document.problem(("runs", name), "no row of the table is of this run", hint))
    for name in names:
        run = raw.settings.runs.get(name, RunSection())
        values = default | run.model_dump(exclude_none=True)
        missing = [key for key in _CONDITIONS if key not in values]
        messages = [f"needs {key}: neither the run nor the mission has it" for key in missing]
        if not missing:
            conditions[name] = DiveConditions(values["anchor_wet_weight"], values["line_length"], values["depth"])
            if conditions[name].site_depth > DEEPEST:
                messages.append(f"depth: expected at most {DEEPEST:g} m, the deepest sea")
            if conditions[name].site_depth <= conditions[name].line_length:
                messages.append("the line is as long as the site is deep: the vehicle is never pulled down")
        problems += [raw.document.problem(("runs", name), message) for message in messages]
    return conditions, problems


def _of_mission(mission: Mission) -> dict[str, float]:
    """Conditions of the mission's first mooring, at its means, as far as it has them."""
    conditions: dict[str, float] = {}
    if mission.site is not None and mission.site.depth is not None:
        conditions["depth"] = mean_of(mission.site.depth)
    if mission.moors:
        moor = mission.moors[0]
        conditions["line_length"] = mean_of(moor.line_length)
        if not isinstance(moor.anchor_wet_weight, str):
            conditions["anchor_wet_weight"] = mean_of(moor.anchor_wet_weight)
    return conditions


class DepthNoise(FileSection):
    """Standard deviation of a reading, where it is known."""

    depth: Annotated[q.FixedLength | None, Doc("standard deviation of a reading of the depth")] = None


class DescentSettings(DivesSettings):
    """Keys of a data set of kind ``descent``."""

    noise: Annotated[DepthNoise, Doc("errors of what was measured")] = DepthNoise()


HIGHEST = -2.0
"""Readings above it are no depths [m]: waves and the offset of a sensor stay within."""
BELOW_SEAFLOOR = 4.0
"""Readings deeper than this many depths of the site are not of this dive, even in feet (3.28)."""
SLOWEST, FASTEST = 0.01, 20.0
"""Mean speeds of a descent [m/s]: torpedo anchors, of tonnes, fall at 15 to 25."""
AWASH = -0.5
"""Readings down to it may be those of a vehicle at the surface [m]; such a log is refused when it meets the mission."""
IGNORED = ("pitch_deg", "density_kg_m3")
DESCENT = DatasetFormat(
    "descent",
    DescentSettings,
    Columns((("run", "t_s", "depth_m"),), optional=IGNORED, text=("run",), times=("t_s",)),
)


def read_descent(folder: Path, mission: Mission) -> DescentData:
    """Read a data set of kind ``descent``.

    `mission`: for anchor, line and site where the runs say nothing of them. Raises InputError: all problems of the
    folder at once.
    """
    raw = read_dataset(folder, DESCENT)
    raw, undated = _from_separations(raw)
    runs = {str(name): run for name, run in raw.table.groupby("run", sort=False)}
    problems = [problem for name, run in runs.items() for problem in _check_run(name, run, raw)]
    conditions, incomplete = conditions_of_runs(_described(raw), raw, mission)
    dives = [_measured(name, run, conditions[name]) for name, run in runs.items() if name in conditions]
    over = [next(filter(None, (check(dive, raw.file) for check in _CHECKS)), []) for dive in dives]
    settings = raw.checked([*undated, *problems, *incomplete, *chain(*over)])
    unused = [f"{column} is not used by the diagnosis of depths" for column in IGNORED if column in raw.table]
    kept, again = _counted_once(dives)
    notices = (*raw.notices, *unused, *again)
    date = date_of_runs([dive.name for dive in kept], settings)
    return DescentData(raw.name, raw.source, raw.file, kept, settings.noise.depth, notices, date)


def _counted_once(dives: Sequence[MeasuredDive]) -> tuple[tuple[MeasuredDive, ...], tuple[str, ...]]:
    """Leave out dives that repeat another of the file, with the same anchor, line and site, and say which."""
    first = repeated([(dive.identity, dive.wet_weight, dive.line_length, dive.site_depth) for dive in dives]).tolist()
    pairs = zip(dives, first, strict=True)
    again = [as_other(dive.name, dives[place].name) for k, (dive, place) in enumerate(pairs) if place < k]
    notice = f"{counted(len(again), 'dive')} of {len(dives)} stand in the file before, and count once: {listed(again)}"
    return tuple(dives[place] for place in dict.fromkeys(first)), (notice,) if again else ()


def _from_separations(
    raw: RawDataset[DescentSettings],
) -> tuple[RawDataset[DescentSettings], list[Problem]]:
    """Count times of the day from the run's separation; those that are seconds from it already are left as they are."""
    dated = raw.table["t_s"] > EPOCH_SCALE
    if not dated.any() or raw.settings is None:
        return raw, []
    problems, t = [], raw.table["t_s"].copy()
    for name, rows in raw.table[dated].groupby("run", sort=False):
        run = raw.settings.runs.get(str(name))
        if run is not None and run.separation is not None:
            t[rows.index] -= run.separation.timestamp()
        else:
            message = f"{name}: its times are of the day; say in runs: when its anchor separated"
            hint = "separation: 2026-05-01T10:20:30Z"
            problems.append(Problem(message, raw.file, int(rows.index[0]), "t_s", hint))
    return replace(raw, table=raw.table.assign(t_s=t)), problems


def _measured(name: str, run: pd.DataFrame, dive: DiveConditions) -> MeasuredDive:
    t, depth = run["t_s"].to_numpy(), run["depth_m"].to_numpy()
    return MeasuredDive(name, int(run.index[0]), t, depth, dive.wet_weight, dive.line_length, dive.site_depth)


def _check_still_diving(dive: MeasuredDive, file: str) -> list[Problem]:
    """Refuse a log that holds nothing of the descent."""
    shallowest, moored = float(dive.depth.min()), dive.site_depth - dive.line_length
    if not shallowest > max(dive.deepest_fitted, 0.0) or np.ptp(dive.depth) == 0.0:
        return []
    over = (
        f"the log begins when the dive is over: its depths are {shallowest:.4g} m and more, and the vehicle is moored"
    )
    at = f"at {moored:.4g} m (a site of {dive.site_depth:.4g} m less a line of {dive.line_length:.4g} m)"
    return [Problem(f"{dive.name}: {over} {at}", file, dive.line, "depth_m")]


def _check_above_seafloor(dive: MeasuredDive, file: str) -> list[Problem]:
    """Refuse a log of a dive that goes on far below the seafloor."""
    deepest = float(dive.depth.max())
    if deepest <= BELOW_SEAFLOOR * dive.site_depth - HIGHEST:
        return []
    message = f"{dive.name}: reaches {deepest:.4g} m, below the seafloor at {dive.site_depth:.4g} m"
    return [Problem(message, file, dive.line, "depth_m", "is the depth of the site right?")]


def _check_rate(dive: MeasuredDive, file: str) -> list[Problem]:
    """Refuse a log of a dive that sinks as nothing on an anchor does: its times are not in seconds."""
    t, depth = dive.t[1:-1], np.median([dive.depth[:-2], dive.depth[1:-1], dive.depth[2:]], axis=0)  # no single spikes
    if len(t) < 2:
        return []
    low, high = depth.min() + 0.2 * np.ptp(depth), depth.min() + 0.8 * np.ptp(depth)
    first = int(np.argmax(depth >= high))
    begin = int(np.flatnonzero(depth[: first + 1] <= low)[-1]) if depth[0] <= low else first
    if begin == first or SLOWEST <= (rate := (depth[first] - depth[begin]) / (t[first] - t[begin])) <= FASTEST:
        return []
    message = f"{dive.name}: sinks at {rate:.3g} m/s; expected {SLOWEST:g} to {FASTEST:g} m/s"
    return [Problem(message, file, dive.line, "t_s", "are its times in seconds?")]


_CHECKS = (_check_still_diving, _check_above_seafloor, _check_rate)
"""Of a dive whose site and line are known."""


def _described(raw: RawDataset[DescentSettings]) -> list[str]:
    """Names under ``runs:``, whether or not all is well with them."""
    runs = raw.document.data.get("runs")
    return list(runs) if isinstance(runs, dict) else []


def _check_run(name: str, run: pd.DataFrame, raw: RawDataset[DescentSettings]) -> list[Problem]:
    first, described = int(run.index[0]), _described(raw)
    if name not in described:
        names = ", ".join(described) or "none"
        message = f"run {name!r} is not among runs: in dataset.yaml ({names})"
        return [Problem(message, raw.file, first, "run", did_you_mean(name, described))]
    steps = np.diff(run["t_s"].to_numpy())
    problems = []
    for kind, wrong in (("twice", steps == 0.0), ("after a later one", steps < 0.0)):
        places = np.flatnonzero(wrong)
        if len(places):
            line = int(run.index[places[0] + 1])
            more = f"; {len(places) - 1} more like it" if len(places) > 1 else ""
            problems.append(Problem(f"{name}: a time stands {kind}{more}", raw.file, line, "t_s"))
    for wrong, message in (
        (run["depth_m"] < HIGHEST, f"stands more than {-HIGHEST:g} m above the water"),
        (run["depth_m"] > DEEPEST, f"lies deeper than the deepest sea, {DEEPEST:g} m"),
    ):
        problems += wrong_cells(run.index[wrong], message, raw.file, "depth_m")
    return problems or _check_measured(name, run["depth_m"].to_numpy(), raw.file, first)


def _check_measured(name: str, depth: Array, file: str, line: int) -> list[Problem]:
    """Refuse a run whose depths are no measurements of a dive."""
    if np.ptp(depth) == 0.0:
        message = f"all {len(depth)} depths are {depth[0]:.4g} m: the sensor did not measure, or did not move"
    elif depth.max() <= 0.0 and depth.min() < AWASH:
        message = f"no depth is below the water, the lowest is {depth.min():.4g} m: expected depths positive down"
    else:
        return []
    return [Problem(f"{name}: {message}", file, line, "depth_m")]
