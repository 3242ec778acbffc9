"""A record of a current meter or profiler (CSV or NetCDF, time against depth, gaps allowed), and the tide in it.

Constituents at each depth, a mean, what is left, and how well it forecasts its own record.
"""

import math
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, ClassVar

import numpy as np
import pandas as pd
from typing_extensions import override

from missionplan.arrays import Array
from missionplan.datasets.table import plain_table, times_from
from missionplan.errors import InputError, Problem
from missionplan.moments import EPOCH_SCALE, is_since, utc
from missionplan.results import Provenance, Result, to_csv, to_yaml
from missionplan.results.entries import Entry, Record
from missionplan.scenario.currents.attributes import depths, good, moments
from missionplan.scenario.currents.files import FieldFiles, undeclared_fill
from missionplan.scenario.currents.reading import CURRENT_LIMITS, MAX_BYTES, opened
from missionplan.scenario.site_current import NETCDF

if TYPE_CHECKING:
    from xarray import DataArray


@dataclass(frozen=True)
class Constituent(Record):
    """A tidal ellipse; standard errors are nan where the constituent is inferred."""

    name: str
    """Such as ``M2``."""
    major: Annotated[float, Entry("major semi-axis", "m/s")]
    minor: Annotated[float, Entry("minor semi-axis; negative where the current turns clockwise", "m/s")]
    toward: Annotated[float, Entry("direction of the major axis, clockwise from north, below π", "rad")]
    phase: Annotated[float, Entry("lag behind the equilibrium tide at Greenwich", "rad")]
    major_error: Annotated[float, Entry("standard error of the major semi-axis", "m/s")] = math.nan
    minor_error: Annotated[float, Entry("standard error of the minor semi-axis", "m/s")] = math.nan
    toward_error: Annotated[float, Entry("standard error of the direction", "rad")] = math.nan
    phase_error: Annotated[float, Entry("standard error of the phase", "rad")] = math.nan
    inferred_from: str = ""
    """The constituent from which it is inferred; empty where it is fitted."""

    @property
    def fitted_constituent(self) -> Annotated[str | None, Entry(key="inferred_from")]:
        """The constituent from which it is inferred; None where it is fitted."""
        return self.inferred_from or None

    def in_degrees(self) -> dict[str, object]:
        """Return the row of the table, angles in degrees."""
        row = {**self.row(), "inferred_from": self.inferred_from}
        return {
            key.replace("_rad", "_deg"): math.degrees(value) if key.endswith("_rad") else value
            for key, value in row.items()
        }


@dataclass(frozen=True)
class HeldOut(Record):
    """How the tide of the first part of a record forecast the rest."""

    samples: Annotated[int, Entry("of one component in the rest")]
    coverage: Annotated[float, Entry("share of them within the stated 90 % interval", key="coverage_90")]
    error: Annotated[float, Entry("root mean square of one component", "m/s")]


@dataclass(frozen=True)
class DepthTide(Record):
    """The tide at one depth."""

    depth: Annotated[float, Entry("below the surface", "m")]
    samples: Annotated[int, Entry("moments at which the current was measured")]
    east: Annotated[float, Entry("mean current towards the east", "m/s")]
    north: Annotated[float, Entry("mean current towards the north", "m/s")]
    mean_error: Annotated[float, Entry("standard error of either component of the mean", "m/s")]
    constituents: tuple[Constituent, ...]
    """The largest first."""
    residual: Annotated[
        float,
        Entry(
            "standard deviation of one component about the tide and the mean, "
            "what the fit does not know of them included",
            "m/s",
        ),
    ]
    residual_time: Annotated[float, Entry("coherence time of what is left", "s")]
    tidal_share: Annotated[float, Entry("share of the current's variance that the tide explains")]
    held_out: Annotated[HeldOut | None, Entry("null where the record is too short to hold some of it out")]

    @property
    def by_name(self) -> Annotated[dict[str, Constituent], Entry(key="constituents")]:
        """Constituents by name, the largest first."""
        return {wave.name: wave for wave in self.constituents}


@dataclass(frozen=True)
class TideResult(Result):
    """The tide in a record of a current."""

    report: ClassVar[str] = "missionplan.studies.tide.page"

    provenance: Provenance
    depths: Annotated[tuple[DepthTide, ...], Entry("from the surface down")]
    latitude: Annotated[float, Entry("of the record", "rad")]
    begins: Annotated[float, Entry("begin of the record, since 1970", "s")]
    days: Annotated[float, Entry("length of the record [d]")]
    time: Array
    measured: Array
    fitted: Array
    """At the depth of the picture: since 1970 [s], east and north; nan in gaps [m/s]."""
    shown_depth: float
    """Shown depth [m]."""
    unresolved: Annotated[tuple[str, ...], Entry("what the record is too short for, in words")]

    @property
    def forecast_error(self) -> str:
        """What the tide does not forecast, as ``site.current.error`` of a mission."""
        worst = max(self.depths, key=lambda tide: tide.residual)
        hours = max(worst.residual_time / 3600.0, 0.01)
        return f"{{sigma: {worst.residual:.4f} m/s, time: {hours:.2f} h}}"

    @property
    def shown(self) -> DepthTide:
        """The tide at the depth of the picture."""
        return next(tide for tide in self.depths if tide.depth == self.shown_depth)

    @override
    def to_frame(self) -> pd.DataFrame:
        rows = [
            {"depth_m": tide.depth, "constituent": wave.name, **wave.in_degrees()}
            for tide in self.depths
            for wave in tide.constituents
        ]
        return pd.DataFrame(rows)

    @override
    def files(self) -> dict[str, str | bytes]:
        return {"constituents.csv": to_csv(self.to_frame()), "tide.yaml": self.fragment()}

    def fragment(self) -> str:
        """Return `site.current.tide` of a mission, as the file that it may name."""
        head = (
            "# Phases are lags at Greenwich. In a mission:\n"
            f"# site: {{current: {{tide: tide.yaml, error: {self.forecast_error}}}}}\n"
        )
        depths = [
            {
                "depth": f"{tide.depth:g} m",
                "east": f"{tide.east:.4f} m/s",
                "north": f"{tide.north:.4f} m/s",
                "constituents": [
                    {
                        "name": wave.name,
                        "major": f"{wave.major:.4f} m/s",
                        "minor": f"{wave.minor:.4f} m/s",
                        "toward": f"{math.degrees(wave.toward):.2f} deg",
                        "phase": f"{math.degrees(wave.phase):.2f} deg",
                    }
                    for wave in tide.constituents
                ],
            }
            for tide in self.depths
        ]
        return head + to_yaml({"depths": depths})


FASTEST, DEEPEST = CURRENT_LIMITS["east_m_s"], CURRENT_LIMITS["depth_m"]
COLUMNS = tuple(CURRENT_LIMITS)
_LISTED = 20
_STANDARD = {
    "east": ("eastward_sea_water_velocity",),
    "north": ("northward_sea_water_velocity",),
    "depth": ("depth",),
    "latitude": ("latitude",),
}
_NAMES = {
    "time": ("time", "TIME", "ocean_time"),
    "depth": ("depth", "DEPTH", "bin_depth", "BINDEPTH", "z"),
    "east": ("u", "east", "UCUR", "u_1205", "water_u", "eastward_velocity", "uo"),
    "north": ("v", "north", "VCUR", "v_1206", "water_v", "northward_velocity", "vo"),
    "latitude": ("latitude", "lat", "LATITUDE"),
}


@dataclass(frozen=True)
class CurrentRecord:
    """A current measured at one place."""

    time: Array
    """Increasing, since the start of 1970, shape (k,) [s]."""
    depth: Array
    """Increasing, shape (m,) [m]."""
    east: Array
    north: Array
    """nan where nothing was measured, shape (k, m) [m/s]."""
    latitude: float = math.nan
    """nan where the file does not tell [rad]."""


def read_current_record(path: Path, start: datetime | None = None) -> CurrentRecord:
    """Read a record.

    `path`: CSV with the columns ``t_s, depth_m, east_m_s, north_m_s`` (`t_s` by ISO 8601, or seconds since `start`;
    empty cells of the velocity are gaps), or NetCDF with one time and at most one depth dimension. `start`: from which
    seconds of a CSV record count. Raises InputError with every problem of the file.
    """
    if path.suffix.lower() in NETCDF:
        with opened([str(path)], str(path)) as files:
            return _of_files(files)
    cells = plain_table(path, COLUMNS, MAX_BYTES)
    numbers = {name: pd.to_numeric(cells[name], errors="coerce") for name in COLUMNS}
    if start is None and (numbers["t_s"] <= EPOCH_SCALE).any():
        hint = "give times such as 2026-05-01T00:00:00Z, or --start"
        raise InputError([Problem("its times are seconds, and nothing says since when", str(path), hint=hint)])
    zero = 0.0 if start is None else utc(start).timestamp()
    times, _ = zero + times_from(cells["t_s"], zero, str(path)), numbers.pop("t_s")
    _check_cells(path, cells, times, numbers)
    rows = pd.DataFrame({"t": times, **numbers})
    if (again := rows.duplicated(["t", "depth_m"]).to_numpy().nonzero()[0]).size:
        raise InputError(
            [Problem("this row has the time and depth of an earlier one", str(path), int(cells.index[again[0]]))]
        )
    table = rows.pivot(index="t", columns="depth_m").astype(float)
    east, north = table["east_m_s"], table["north_m_s"]
    return CurrentRecord(
        table.index.to_numpy(dtype=float), east.columns.to_numpy(dtype=float), east.to_numpy(), north.to_numpy()
    )


def _check_cells(
    path: Path, cells: pd.DataFrame, times: "pd.Series[float]", numbers: dict[str, "pd.Series[float]"]
) -> None:
    shown, depth = str(path), numbers["depth_m"]
    velocity = pd.DataFrame({name: numbers[name] for name in COLUMNS[2:]})
    is_filled = velocity.to_numpy(dtype=float) == undeclared_fill(*velocity.to_numpy(dtype=float).T)
    fast = (velocity.abs() > FASTEST).any(axis=1) | is_filled.all(axis=1)
    words = f"is impossible; expected a depth of 0 to {DEEPEST:g} m and a current of at most {FASTEST:g} m/s"
    hint = "a fill value, or another unit? leave the cell empty where nothing was measured"
    wrong = [
        ("expected a time and a depth", times.isna() | depth.isna(), ""),
        (words, (depth < 0.0) | (depth > DEEPEST) | fast, hint),
        *((f"{name}: expected a number", numbers[name].isna() & cells[name].notna(), "") for name in COLUMNS[2:]),
    ]
    problems = [Problem(what, shown, int(row), hint=more)
                for what, where, more in wrong for row in cells.index[where][:_LISTED]]  # fmt: skip
    if problems:
        raise InputError(problems)


def _of_files(files: FieldFiles) -> CurrentRecord:
    beside = files.datasets[0]
    east, north = (good(_variable(files, key), beside).squeeze(drop=True) for key in ("east", "north"))
    time = _variable(files, "time")
    if not is_since(time.attrs.get("units")) or time.ndim != 1:
        raise files.problem("its times are no dates along one dimension")
    others = [name for name in east.dims if name != time.dims[0]]
    if time.dims[0] not in east.dims or len(others) > 1 or set(east.dims) != set(north.dims):
        message = f"expected currents against time and depth, they have {', '.join(map(str, east.dims))}"
        raise files.problem(message)
    axis = _variable(files, "depth")
    depth = np.atleast_1d(depths(axis, axis.squeeze().to_numpy().astype(float)))
    seconds = (moments(time) - np.datetime64(0, "s")) / np.timedelta64(1, "s")
    if len(np.unique(seconds)) < len(seconds):
        raise files.problem("has times that stand twice")
    order, down = np.argsort(seconds), np.argsort(depth)
    dims = (time.dims[0], *others)
    written = [side.transpose(*dims).to_numpy().astype(float).reshape(len(seconds), -1) for side in (east, north)]
    fills = undeclared_fill(*written)
    both = (written[0] == fills[0]) & (written[1] == fills[1])
    values = [
        _speeds(files, np.where(both, math.nan, part) * files.component(str(name), number))
        for number, (part, name) in enumerate(zip(written, (east.name, north.name), strict=True))
    ]
    if values[0].shape[1] != depth.size:
        raise files.problem(f"has {values[0].shape[1]} bins and {depth.size} depths")
    u, v = (speeds[order][:, down] for speeds in values)
    latitude = math.nan
    if files.named(*_NAMES["latitude"]):
        places = _variable(files, "latitude").to_numpy().astype(float).ravel()
        latitude = math.radians(float(places[0])) if places.size == 1 else math.nan
    return CurrentRecord(np.asarray(seconds, dtype=float)[order], depth[down], u, v, latitude)


def _speeds(files: FieldFiles, speeds: Array) -> Array:
    """Values of a component that are possible [m/s]; the file is refused where most are not, unless all are alike."""
    fast = np.abs(speeds) > FASTEST
    if fast.sum() > 0.5 * np.isfinite(speeds).sum() and np.ptp(np.abs(speeds[fast])) > 0.0:
        hint = "is its attribute `units` right?"
        raise files.problem(f"most of its currents are faster than {FASTEST:g} m/s", hint)
    return np.where(fast, math.nan, speeds)


def _variable(files: FieldFiles, key: str) -> "DataArray":
    return files.variable(files.required(key, *_NAMES[key], standard=_STANDARD.get(key, ())))
