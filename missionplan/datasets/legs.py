"""Navigation logs: legs between fixes, in metres east and north and seconds."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from missionplan.arrays import Array
from missionplan.datasets.reading import RawDataset, problems_of, read_dataset
from missionplan.errors import InputError, Problem
from missionplan.mission import Mission
from missionplan.mission.geodesy import to_plane
from missionplan.mission.schema.site import Geographic

PLANAR = ("x_start_m", "y_start_m", "x_dr_m", "y_dr_m", "x_end_m", "y_end_m")
GEOGRAPHIC = ("lat_start", "lon_start", "lat_dr_end", "lon_dr_end", "lat_end", "lon_end")
TIMES = ("t_start_s", "t_end_s")
OPTIONAL = ("surface_s", "speed_m_s", "heading_deg")
COLUMNS = {"text": ("leg", "run"), "numeric": (*TIMES, *PLANAR, *GEOGRAPHIC, *OPTIONAL)}

LEAST_LEGS = 8
MOST_LEGS = 2000
NEEDED = (
    f"{LEAST_LEGS} legs are needed to tell a constant error from chance, 20 to find persistence, "
    "and a record of half a tidal period to find a tide"
)
EPOCH_SCALE = 1e8
"""Times above this are seconds since 1970, not since the mission's start [s]."""
IMPOSSIBLE_SPEED = 3.0
OUTLIER = 15.0


@dataclass(frozen=True)
class TransitData:
    """Legs of a navigation log in the order of time.

    Attributes
    ----------
    name, source : str
        Of the data set.
    labels : array of str, shape (n,)
        Legs' names.
    run : array of int, shape (n,)
        Number of the run each leg belongs to.
    t_start : array, shape (n,)
        Since the mission's start, or since the first fix [s].
    under_way, surface : array, shape (n,)
        Time under way, and at the surface until the fix [s].
    start, dead_reckoned, end : array, shape (2, n)
        Fix on diving, dead-reckoned position on surfacing, fix on surfacing: east, north of the origin [m].
    origin : tuple or None
        Latitude and longitude of the origin, where known [rad].
    fix_sd : float or None
        Stated standard deviation of a fix, each axis [m].
    has_surface_time : bool
        Whether the log says how long the vehicle lay at the surface before the fix.
    notices : tuple of str
        Treatments the reader should know of.
    epoch : float or None
        Seconds since 1970 of the times' zero, where the log says.
    """

    name: str
    source: str
    labels: NDArray[np.str_]
    run: NDArray[np.int_]
    t_start: Array
    under_way: Array
    surface: Array
    start: Array
    dead_reckoned: Array
    end: Array
    origin: tuple[float, float] | None
    fix_sd: float | None
    has_surface_time: bool
    notices: tuple[str, ...]
    epoch: float | None = None

    @property
    def n(self) -> int:
        """Number of legs."""
        return len(self.t_start)

    @property
    def middle(self) -> Array:
        """Middle of each leg's time under way, shape (n,) [s]."""
        return self.t_start + 0.5 * self.under_way

    @property
    def latitude(self) -> float:
        """Latitude of the origin [rad]; nan where unknown."""
        return self.origin[0] if self.origin else float("nan")

    @property
    def velocity_error(self) -> Array:
        """Position error on surfacing over the time under way, shape (2, n) [m/s]."""
        return (self.end - self.dead_reckoned) / self.under_way

    def subset(self, keep: NDArray[np.bool_] | NDArray[np.int_]) -> "TransitData":
        """Keep some of the legs."""
        legs = ("labels", "run", "t_start", "under_way", "surface")
        values = {name: getattr(self, name)[keep] for name in legs}
        values |= {name: getattr(self, name)[:, keep] for name in ("start", "dead_reckoned", "end")}
        return TransitData(**{**self.__dict__, **values})


def read_transit(folder: Path, mission: Mission) -> TransitData:
    """Read a data set of kind ``transit``.

    Positions by latitude and longitude become metres in an azimuthal equidistant plane about the site's origin, or
    about the first fix.

    Raises
    ------
    InputError
        All problems of the folder at once.
    """
    raw = read_dataset(folder, {"transit": COLUMNS}, {"fix": "m"})
    geographic = GEOGRAPHIC[0] in raw.table and PLANAR[0] not in raw.table
    positions = GEOGRAPHIC if geographic else PLANAR
    problems = problems_of(raw, (*TIMES, *positions))
    notices = list(raw.notices)
    table = raw.table.dropna(subset=[*TIMES, *positions])
    if len(table) < len(raw.table):
        notices.append(f"{len(raw.table) - len(table)} legs without all of their times and positions are left out")
    problems += _check_rows(table, raw, geographic)
    if problems:
        raise InputError(problems)
    data = _build(table, raw, mission, geographic, notices)
    return _without_outliers(data)


def _check_rows(table: pd.DataFrame, raw: RawDataset, geographic: bool) -> list[Problem]:
    problems = []
    if len(table) < LEAST_LEGS:
        problems.append(Problem(f"has {len(table)} usable legs, too few: {NEEDED}", raw.file))
    if len(table) > MOST_LEGS:
        problems.append(Problem(f"has {len(table)} legs; expected at most {MOST_LEGS}", raw.file, hint="split it"))
    surface = table["surface_s"].fillna(0.0) if "surface_s" in table else 0.0
    short = table.index[table["t_end_s"] - table["t_start_s"] - surface <= 0.0]
    problems += [Problem("the leg ends before it has begun", raw.file, int(line), "t_end_s") for line in short[:5]]
    if "surface_s" in table:
        negative = table.index[table["surface_s"] < 0.0]
        problems += [Problem("is negative", raw.file, int(line), "surface_s") for line in negative[:5]]
    if geographic:
        for column in GEOGRAPHIC:
            limit = 90.0 if column.startswith("lat") else 360.0
            wrong = table.index[table[column].abs() > limit]
            message = f"expected degrees, at most {limit:g}"
            problems += [Problem(message, raw.file, int(line), column) for line in wrong[:5]]
    for _, run in table.groupby(table["run"] if "run" in table else pd.Series("", index=table.index)):
        repeated = run.index[run["t_start_s"].duplicated()]
        problems += [
            Problem("two legs start at the same time", raw.file, int(line), "t_start_s") for line in repeated[:5]
        ]
        ordered = run.sort_values("t_start_s")
        overlap = ordered["t_start_s"].to_numpy()[1:] < ordered["t_end_s"].to_numpy()[:-1] - 1.0
        problems += [
            Problem("the leg starts before the one before it has ended", raw.file, int(line), "t_start_s")
            for line in ordered.index[1:][overlap & ~ordered["t_start_s"].duplicated().to_numpy()[1:]][:5]
        ]
    return problems


def _build(table: pd.DataFrame, raw: RawDataset, mission: Mission, geographic: bool, notices: list[str]) -> TransitData:
    run_names = table["run"] if "run" in table else pd.Series("", index=table.index)
    if not table["t_start_s"].is_monotonic_increasing and "run" not in table:
        notices.append("the legs were not in the order of time; they have been sorted")
    table = table.assign(_run=pd.factorize(run_names)[0]).sort_values(["_run", "t_start_s"], kind="stable")
    origin = (
        (mission.site.origin.latitude, mission.site.origin.longitude) if mission.site and mission.site.origin else None
    )
    if geographic:
        if origin is None:
            origin = (float(np.radians(table["lat_start"].iloc[0])), float(np.radians(table["lon_start"].iloc[0])))
            notices.append("the mission has no site.origin; coordinates are metres from the first fix of the log")
        start, reckoned, end = (_plane(table, GEOGRAPHIC[k : k + 2], origin) for k in (0, 2, 4))
    else:
        start, reckoned, end = (table[list(PLANAR[k : k + 2])].to_numpy().T for k in (0, 2, 4))
    surface = table["surface_s"].fillna(0.0).to_numpy() if "surface_s" in table else np.zeros(len(table))
    t_start = table["t_start_s"].to_numpy()
    under_way = table["t_end_s"].to_numpy() - t_start - surface
    epoch = None
    if t_start.min() > EPOCH_SCALE:
        epoch = zero = mission.start.timestamp() if mission.start else float(t_start.min())
        notices += [] if mission.start else ["times and phases count from the first fix: the mission has no start"]
        t_start = t_start - zero
    labels = table["leg"].to_numpy(dtype=str) if "leg" in table else np.array([str(k + 1) for k in range(len(table))])
    return TransitData(
        raw.name,
        raw.source,
        labels,
        table["_run"].to_numpy(),
        t_start,
        under_way,
        surface,
        start,
        reckoned,
        end,
        origin,
        raw.noise.get("fix"),
        bool(np.any(surface > 0.0)),
        tuple(notices),
        epoch,
    )


def _plane(table: pd.DataFrame, columns: tuple[str, ...], origin: tuple[float, float]) -> Array:
    latitude, longitude = (np.radians(table[column].to_numpy()) for column in columns)
    return np.stack(to_plane(latitude, longitude, Geographic.model_construct(latitude=origin[0], longitude=origin[1])))


def _without_outliers(data: TransitData) -> TransitData:
    """Leave out legs whose error no water and no vehicle can explain: a wrong fix.

    A leg is one when its error is `OUTLIER` times the scaled median of all and faster than `IMPOSSIBLE_SPEED`.

    Raises
    ------
    InputError
        When too few legs remain.
    """
    error = data.velocity_error
    size = np.hypot(*(error - np.median(error, axis=1, keepdims=True)))
    outlier = (size > IMPOSSIBLE_SPEED) & (size > OUTLIER * np.median(size))
    if not outlier.any():
        return data
    names = ", ".join(data.labels[outlier][:8])
    notice = f"legs left out as wrong fixes (errors above {IMPOSSIBLE_SPEED:g} m/s, far from all others): {names}"
    kept = data.subset(~outlier)
    if kept.n < LEAST_LEGS:
        raise InputError(f"{data.name}: {kept.n} legs remain without wrong fixes, too few: {NEEDED}")
    return TransitData(**{**kept.__dict__, "notices": (*data.notices, notice)})
