"""Navigation logs: legs between fixes, in metres east and north and seconds.

Checks of a navigation log's legs: enough of them, in order, and with possible values.
"""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import numpy as np
import pandas as pd
from pydantic import Field
from typing_extensions import Doc

from missionplan.arrays import Array
from missionplan.datasets import DatasetFormat, DatasetSettings, read_dataset
from missionplan.datasets.dives import DEEPEST
from missionplan.datasets.records import TransitData, as_other, first_known, listed
from missionplan.datasets.table import Columns, wrong_cells
from missionplan.errors import InputError, Problem, counted
from missionplan.mission import Mission
from missionplan.mission.schema import FileSection, Moment
from missionplan.mission.schema import quantity_parser as q
from missionplan.mission.schema.place import Geographic, to_plane
from missionplan.moments import EPOCH_SCALE

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

    `legs`: columns of a data set of kind ``transit``; the index is the file's line. `file`: as messages name it.
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


def _check_durations(legs: pd.DataFrame, file: str) -> list[Problem]:
    surface = legs["surface_s"].fillna(0.0) if "surface_s" in legs else pd.Series(0.0, index=legs.index)
    short = legs.index[legs["t_end_s"] - legs["t_start_s"] - surface <= 0.0]
    negative = legs.index[surface < 0.0]
    stated = legs["fix_sd_m"] if "fix_sd_m" in legs else pd.Series(1.0, index=legs.index)
    poor = legs.index[stated <= 0.0]
    depth = legs["depth_m"] if "depth_m" in legs else pd.Series(0.0, index=legs.index)
    nowhere = legs.index[(depth < HIGHEST) | (depth > DEEPEST)]
    return [
        *wrong_cells(nowhere, f"expected the leg's mean depth in metres, {HIGHEST:g} to {DEEPEST:g}", file, "depth_m"),
        *wrong_cells(poor, "expected more than 0 m", file, "fix_sd_m"),
        *wrong_cells(short, "the leg ends before it has begun", file, "t_end_s"),
        *wrong_cells(negative, "is negative", file, "surface_s"),
    ]


def _check_degrees(legs: pd.DataFrame, file: str) -> list[Problem]:
    problems = []
    for columns, limit in ((LATITUDES, 90.0), (LONGITUDES, 360.0)):
        for column in columns:
            if column in legs:
                message = f"expected degrees, at most {limit:g}"
                problems += wrong_cells(legs.index[legs[column].abs() > limit], message, file, column)
    return problems


def _check_order(run: pd.DataFrame, file: str) -> list[Problem]:
    """Check that the legs of one run follow one another."""
    repeated = run.index[run["t_start_s"].duplicated()]
    ordered = run.sort_values("t_start_s")
    starts, ends = ordered["t_start_s"].to_numpy(), ordered["t_end_s"].to_numpy()
    early = ordered.index[1:][(starts[1:] < ends[:-1] - OVERLAP) & (np.diff(starts) > 0.0)]
    return [
        *wrong_cells(repeated, "two legs start at the same time", file, "t_start_s"),
        *wrong_cells(early, "the leg starts before the one before it has ended", file, "t_start_s"),
    ]


class LegNoise(FileSection):
    """Errors of the fixes and of the dead reckoning, where they are known."""

    fix: Annotated[q.FixedLength | None, Doc("standard deviation of a fix, each axis")] = None
    reckoned_speed: Annotated[
        float | None, Field(gt=0.0, le=1.0, examples=[0.1]), Doc("error of a speed made where none was logged, over it")
    ] = None


class TransitSettings(DatasetSettings):
    """Keys of a data set of kind ``transit``."""

    start: Annotated[Moment | None, Doc("zero of times in seconds; default: the start of the mission")] = None
    noise: Annotated[LegNoise, Doc("errors of what was measured")] = LegNoise()


TIMES = ("t_start_s", "t_end_s")
STAMPS = ("t_start", "t_end")
"""Columns of times by ISO 8601."""
PLANAR = ("x_start_m", "y_start_m", "x_dr_m", "y_dr_m", "x_end_m", "y_end_m")
GEOGRAPHIC = ("lat_start", "lon_start", "lat_dr_end", "lon_dr_end", "lat_end", "lon_end")
TRANSIT = DatasetFormat(
    "transit",
    TransitSettings,
    Columns(
        tuple((*times, *places) for times in (TIMES, STAMPS) for places in (PLANAR, GEOGRAPHIC)),
        optional=("leg", "run", "surface_s", "speed_m_s", "heading_deg", "fix_sd_m", "depth_m"),
        text=("leg", "run"),
        times=(*TIMES, *STAMPS),
    ),
)

FARTHEST = 500_000.0
"""Greatest distance of a log from the mission's origin, as of anything in a mission [m]."""
IMPOSSIBLE_SPEED = 3.0
"""Velocity error that neither water nor vehicle explains [m/s]."""
OUTLIER = 15.0
"""Size of a wrong fix's velocity error, over the median of all."""


def read_transit(folder: Path, mission: Mission) -> TransitData:
    """Read a data set of kind ``transit``.

    Positions by latitude and longitude become metres in an azimuthal equidistant plane about the site's origin, or
    about the first fix.

    `mission`: for the origin of the coordinates and the start of time. Raises InputError: all problems of the folder at
    once.
    """
    raw = read_dataset(folder, TRANSIT)
    raw = replace(raw, table=raw.table.rename(columns=dict(zip(STAMPS, TIMES, strict=True))))
    numbers = [name for name in raw.table if name not in TRANSIT.columns.text]
    settings = raw.checked(check_legs(raw.table.drop_duplicates(numbers), raw.file))
    notices = list(raw.notices)
    legs = _since_start(_in_order(raw.table, notices), settings, notices)
    start, reckoned, end, origin = _positions(legs, mission, notices, raw.file)
    surface = legs["surface_s"].fillna(0.0).to_numpy() if "surface_s" in legs else np.zeros(len(legs))
    t_start = legs["t_start_s"].to_numpy()
    under_way = legs["t_end_s"].to_numpy() - t_start - surface
    epoch = _epoch(t_start, mission, notices)
    data = TransitData(
        raw.name,
        raw.source,
        legs["leg"].to_numpy(dtype=str) if "leg" in legs else np.array([str(k + 1) for k in range(len(legs))]),
        legs["_run"].to_numpy(),
        t_start if epoch is None else t_start - epoch,
        under_way,
        surface,
        start,
        reckoned,
        end,
        origin,
        settings.noise.fix,
        bool(np.any(surface > 0.0)),
        tuple(notices),
        epoch,
        _leg_fix_sd(legs),
        legs["depth_m"].to_numpy(dtype=float) if "depth_m" in legs and legs["depth_m"].notna().any() else None,
        settings.noise.reckoned_speed,
    )
    return _without_wrong_fixes(_counted_once(data))


def _leg_fix_sd(legs: pd.DataFrame) -> Array | None:
    """Stated standard deviations of the fixes after the legs; the median of them where one is blank [m]."""
    if "fix_sd_m" not in legs or legs["fix_sd_m"].isna().all():
        return None
    return np.asarray(legs["fix_sd_m"].fillna(legs["fix_sd_m"].median()), dtype=float)


def _in_order(legs: pd.DataFrame, notices: list[str]) -> pd.DataFrame:
    """Sort the legs by run and time, with the number of each leg's run in a column `_run`."""
    runs = legs["run"] if "run" in legs else pd.Series("", index=legs.index)
    if not legs["t_start_s"].is_monotonic_increasing and "run" not in legs:
        notices.append("the legs were not in the order of time; they have been sorted")
    return legs.assign(_run=pd.factorize(runs)[0]).sort_values(["_run", "t_start_s"], kind="stable")


def _since_start(legs: pd.DataFrame, settings: TransitSettings, notices: list[str]) -> pd.DataFrame:
    """Turn times from the data set's own zero into seconds since 1970."""
    if settings.start is None:
        return legs
    if legs["t_start_s"].min() > EPOCH_SCALE:
        notices.append("start of the data set is not used: its times are dates")
        return legs
    return legs.assign(**{name: legs[name] + settings.start.timestamp() for name in TIMES})


def _positions(
    legs: pd.DataFrame, mission: Mission, notices: list[str], file: str
) -> tuple[Array, Array, Array, tuple[float, float] | None]:
    """Fix on diving, dead-reckoned position and fix on surfacing, shape (2, n) each [m], and their origin [rad]."""
    site = mission.site
    origin = (site.origin.latitude, site.origin.longitude) if site and site.origin else None
    if PLANAR[0] in legs:
        start, reckoned, end = (legs[list(PLANAR[k : k + 2])].to_numpy().T for k in (0, 2, 4))
        return start, reckoned, end, origin
    if origin is None:
        origin = (float(np.radians(legs["lat_start"].iloc[0])), float(np.radians(legs["lon_start"].iloc[0])))
        notices.append("the mission has no site.origin; coordinates are metres from the first fix of the log")
    start, reckoned, end = (_plane(legs, GEOGRAPHIC[k : k + 2], origin) for k in (0, 2, 4))
    away, most = (distance / 1000.0 for distance in (float(np.hypot(*start).max()), FARTHEST))
    if away > most:
        problem = f"{away:.0f} km from the mission's site.origin, expected at most {most:.0f} km"
        raise InputError([Problem(problem, file, key=GEOGRAPHIC[0], hint="is this the mission's log?")])
    return start, reckoned, end, origin


def _plane(legs: pd.DataFrame, columns: Sequence[str], origin: tuple[float, float]) -> Array:
    latitude, longitude = (np.radians(legs[column].to_numpy()) for column in columns)
    return np.stack(to_plane(latitude, longitude, Geographic.model_construct(latitude=origin[0], longitude=origin[1])))


def _epoch(t_start: Array, mission: Mission, notices: list[str]) -> float | None:
    """Zero of the times in seconds since 1970: the mission's start, else the first fix; None for times from zero."""
    if t_start.min() <= EPOCH_SCALE:
        return None
    if mission.start:
        return mission.start.timestamp()
    notices.append("times and phases count from the first fix: the mission has no start")
    return float(t_start.min())


def _counted_once(data: TransitData) -> TransitData:
    """Leave out legs that repeat another of the log, under another name or in another run."""
    first = first_known(data)
    again = np.flatnonzero(first < np.arange(data.n))
    if not len(again):
        return data
    names = listed([as_other(data.labels[leg], data.labels[first[leg]]) for leg in again])
    notice = f"{counted(len(again), 'leg')} of {data.n} stand in the log before, and count once: {names}"
    kept = data.subset(np.unique(first))
    return replace(enough(kept, "of their own"), notices=(*data.notices, notice))


def enough(kept: TransitData, which: str, needed: str = NEEDED) -> TransitData:
    """Return the legs that are left of a log.

    Raises InputError when they are fewer than `MIN_LEGS`: `which` they are, and what is needed.
    """
    if kept.n < MIN_LEGS:
        raise InputError(f"{kept.name}: {counted(kept.n, 'leg')} {which}, too few: {needed}")
    return kept


def _without_wrong_fixes(data: TransitData) -> TransitData:
    """Leave out legs whose error neither water nor vehicle can explain.

    Those are errors of more than `OUTLIER` times the median of all that are faster than `IMPOSSIBLE_SPEED`.

    Raises InputError when too few legs remain.
    """
    error = data.velocity_error
    size = np.hypot(*(error - np.median(error, axis=1, keepdims=True)))
    wrong = (size > IMPOSSIBLE_SPEED) & (size > OUTLIER * np.median(size))
    if not wrong.any():
        return data
    names = listed(data.labels[wrong].tolist())
    notice = f"legs left out as wrong fixes (errors above {IMPOSSIBLE_SPEED:g} m/s, far from all others): {names}"
    return replace(enough(data.subset(~wrong), "without wrong fixes"), notices=(*data.notices, notice))
