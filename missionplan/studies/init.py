"""`init`: a starter mission with its vehicle, and data sets of each kind."""

import cmath
import math
from collections.abc import Callable
from importlib.resources import files
from pathlib import Path

import numpy as np
import pandas as pd

from missionplan.arrays import Array
from missionplan.datasets.legs import STAMPS, TIMES
from missionplan.errors import InputError, Problem, did_you_mean, shown
from missionplan.mission import Mission, load
from missionplan.mission.views import navigation_of, transit_of
from missionplan.moments import moment_of
from missionplan.montecarlo.distributions import mean_of
from missionplan.montecarlo.streams import stream
from missionplan.results import to_csv, to_json
from missionplan.scenario.scenario import Scenario
from missionplan.store.folder import as_path, vacant, write_atomically
from missionplan.studies.schema import READ, Kind, schema

_START = "2026-05-01T08:00:00Z"


def init_data(kind: str, folder: str | Path = ".") -> tuple[Path, ...]:
    """Write a data set of a kind: ``dataset.yaml`` with comments, and its CSV.

    Parameters
    ----------
    kind : str
        Of the data set.
    folder : str or Path
        Created if absent. Other files in it are left alone.

    Returns
    -------
    tuple of Path
        The files written.

    Raises
    ------
    InputError
        When there is no such kind, or one of the files is there already: nothing is written then.
    RunError
        When the folder cannot be written.
    """
    if kind not in _TABLES:
        hint = did_you_mean(kind, _TABLES) or f"one of {', '.join(_TABLES)}"
        raise InputError([Problem(f"given {shown(kind)}, expected a kind of data set", key="data", hint=hint)])
    folder = as_path(folder, "folder")
    name, table = _TABLES[kind]
    paths = vacant(folder, ("dataset.yaml", name))
    text = (files("missionplan") / "starter" / "data" / f"{kind}.yaml").read_text(encoding="utf-8")
    write_atomically(paths[0], text)
    write_atomically(paths[1], to_csv(table()))
    return tuple(paths)


def _noise(kind: str, size: int) -> "np.ndarray[tuple[int], np.dtype[np.float64]]":
    return stream(1, f"starter-data.{kind}", 0).standard_normal(size)


def _legs() -> pd.DataFrame:
    legs = sea_trial(load(Path(str(files("missionplan") / "starter" / "mission.yaml"))), legs=24)
    for seconds, stamp in zip(TIMES, STAMPS, strict=True):
        moments = pd.Timestamp(moment_of(_START)) + pd.to_timedelta(legs[seconds], unit="s")
        legs[seconds] = moments.dt.strftime("%Y-%m-%dT%H:%M:%S.%f").str[:-5] + "Z"
        legs = legs.rename(columns={seconds: stamp})
    return legs.assign(surface_s=0.0, fix_sd_m=2.0)


def _dives() -> pd.DataFrame:
    """Dives that fall from rest to a terminal velocity, after the line has run out, and stop at its length."""
    tables = []
    for run, weight, line in (("dive-1", 12.0, 5.0), ("dive-2", 16.0, 5.0), ("dive-3", 16.0, 10.0)):
        t = np.arange(0.0, 30.0, 0.5)
        velocity = 0.35 * np.sqrt(weight)
        since = np.maximum(t - line / velocity, 0.0)
        depth = np.minimum(velocity * (since - 1.0 * (1.0 - np.exp(-since))), 20.0 - line)
        noise = 0.05 * _noise(f"descent.{run}", len(t))
        tables.append(pd.DataFrame({"run": run, "t_s": t, "depth_m": depth + noise}))
    return pd.concat(tables, ignore_index=True).round(3)


def _drag() -> pd.DataFrame:
    speed = np.repeat(np.arange(0.4, 1.7, 0.2), 3)
    force = 0.5 * 998.4 * 0.0114 * 0.25 * speed**2
    sd = 0.02 + 0.01 * force
    return pd.DataFrame(
        {"speed_m_s": speed, "force_n": force + sd * _noise("drag", len(speed)), "force_sd_n": sd}
    ).round(4)


def _oscillation() -> pd.DataFrame:
    t = np.arange(0.0, 12.0, 0.05)
    rate, decay = np.sqrt(400.0 / 19.0), 0.12  # 12 kg, and 7 kg of water that moves along
    displacement = 0.1 * np.exp(-decay * t) * np.cos(np.sqrt(rate**2 - decay**2) * t)
    noise = 0.001 * _noise("free-oscillation", len(t))
    return pd.DataFrame({"t_s": t, "displacement_m": displacement + noise}).round(5)


def _thruster() -> pd.DataFrame:
    rpm = np.repeat(np.array([-2000.0, -1500.0, -1000.0, 1000.0, 1500.0, 2000.0]), 4)
    speed = np.tile([0.0, 0.0, 0.5, 1.0], 6)
    thrust = 6e-6 * rpm * np.abs(rpm) * (1.0 - 0.4 * speed)
    table = {"rpm": rpm, "thrust_n": thrust + 0.1 * _noise("thruster", len(rpm)), "speed_m_s": speed}
    return pd.DataFrame(table).round(3)


def _propeller() -> pd.DataFrame:
    """Thrust that overshoots after a step of the shaft rate, and falls as the vehicle gains speed."""
    t = np.arange(0.0, 6.0, 0.02)
    since = np.maximum(t - 1.0, 0.0)
    rpm = np.where(t < 1.0, 600.0, 900.0)
    rate, speed = rpm * np.pi / 30.0, 0.6 + 0.5 * (1.0 - np.exp(-since / 1.5))
    overshoot = np.where(t < 1.0, 0.0, 3.0 * np.exp(-since / 0.3))
    thrust = 1.2e-3 * rate**2 - 0.02 * rate * speed + overshoot + 0.2 * _noise("propeller-transient", len(t))
    return pd.DataFrame({"t_s": t, "rpm": rpm, "thrust_n": thrust, "speed_m_s": speed}).round(3)


def _summary() -> pd.DataFrame:
    rows = []
    for run, depth in (("test-1", 10.0), ("test-2", 20.0), ("test-3", 30.0)):
        rows.append((run, "terminal_velocity_m_s", 1.3, 0.05))
        rows.append((run, "descent_time_s", round(2.0 + (depth - 5.0) / 1.3, 1), 0.5))
    return pd.DataFrame(rows, columns=["run", "quantity", "value", "sd"])


_TABLES: dict[str, tuple[str, Callable[[], pd.DataFrame]]] = {
    "transit": ("legs.csv", _legs),
    "descent": ("dives.csv", _dives),
    "drag": ("drag.csv", _drag),
    "free-oscillation": ("oscillation.csv", _oscillation),
    "thruster": ("thruster.csv", _thruster),
    "propeller-transient": ("steps.csv", _propeller),
    "summary": ("summary.csv", _summary),
}
"""By kind, the name of the CSV and the function that makes it."""
DATA_KINDS = tuple(_TABLES)


COMPASS_BIAS = math.radians(3.0)
"""Compass error of the sea trial, unknown to the mission: the course made, clockwise of that steered [rad]."""
LEGS = 32
"""Legs of the sea trial."""
SIDE = 400.0
"""Side of the square about the origin whose corners the sea trial steers for [m]."""

_TEXTS = {"mission.yaml": "mission.yaml", "vehicle.yaml": "vehicle.yaml", "dataset.yaml": "sea-trial/dataset.yaml"}
_LOG = "sea-trial/legs.csv"
_LOGS = ("first-log", "both-logs", "third-log")
_LOOP = (
    "mission.yaml",
    "next-trial.yaml",
    *(f"{log}/{name}" for log in _LOGS for name in ("dataset.yaml", "legs.csv")),
)
"""Files of the second round of docs/loop.md."""
_SCHEMAS: dict[str, Kind] = {f"schema/{kind}.json": kind for kind in READ}
"""For completion and checks in editors, named by the first line of each file."""


def init(folder: str | Path = ".", *, loop: bool = False) -> tuple[Path, ...]:
    """Write the starter files.

    Parameters
    ----------
    folder : str or Path
        Created if absent. Other files in it are left alone.
    loop : bool
        Write those of the second round of docs/loop.md instead: a mission, what it met at a made-up sea, and the trial
        in between.

    Returns
    -------
    tuple of Path
        The files written.

    Raises
    ------
    InputError
        When one of the files is there already: nothing is written then.
    RunError
        When the folder cannot be written.
    """
    folder = as_path(folder, "folder")
    texts = {f"loop/{name}": name for name in _LOOP} if loop else _TEXTS
    paths = vacant(folder, tuple(texts.values()) if loop else (*texts.values(), _LOG, *_SCHEMAS))
    for source, name in texts.items():
        write_atomically(folder / name, (files("missionplan") / "starter" / source).read_text(encoding="utf-8"))
    if loop:
        return tuple(paths)
    write_atomically(folder / _LOG, to_csv(sea_trial(load(folder / "mission.yaml"))))
    for name, kind in _SCHEMAS.items():
        write_atomically(folder / name, to_json(schema(kind)))
    return tuple(paths)


def sea_trial(mission: Mission, *, legs: int = LEGS, compass_bias: float = COMPASS_BIAS, seed: int = 7) -> pd.DataFrame:
    """Simulate a navigation log: a square sailed round and round, with a biased compass.

    On each leg the vehicle steers from its fix for the next corner, by dead reckoning through still water. It is also
    moved by the mission's mean current at the depth of its first transit, a velocity error drawn once a leg, and the
    compass's bias; every fix has its error. At the surface it drifts with the current for the mission's surfacing time.

    `mission`: with a site and navigation; distributions are taken at their means. `compass_bias`: clockwise from the
    course steered to the course made [rad]. Returns: columns of a data set of kind ``transit``.
    """
    transit, navigation = transit_of(mission), navigation_of(mission)
    draws = stream(seed, "sea-trial", 0).standard_normal((legs, 3, 2))
    errors = draws[:, 0] @ np.linalg.cholesky(navigation.velocity_error.covariance).T
    fixes = draws[:, 1:] * mean_of(navigation.fix_error)
    under_way, surface = (_mean_current(mission, depth) for depth in (mean_of(transit.depth), 0.0))
    speed, pause = mean_of(transit.speed), mean_of(navigation.surfacing_time)
    corners = 0.5 * SIDE * np.array([[1.0, 1.0], [1.0, -1.0], [-1.0, -1.0], [-1.0, 1.0]])
    time, position, rows = 0.0, corners[-1], []
    for leg in range(legs):
        dived = position + fixes[leg, 0]
        planned = corners[leg % 4] - dived
        duration = float(np.hypot(*planned)) / speed
        changed = (cmath.exp(-1j * compass_bias) - 1.0) * complex(*planned) / duration
        error = np.array([changed.real, changed.imag]) + errors[leg] + under_way
        position = position + planned + error * duration
        rows.append((leg + 1, time, time + duration, *dived, *(dived + planned), *(position + fixes[leg, 1])))
        position = position + surface * pause
        time += duration + pause
    columns = ("leg", "t_start_s", "t_end_s", "x_start_m", "y_start_m", "x_dr_m", "y_dr_m", "x_end_m", "y_end_m")
    return pd.DataFrame(rows, columns=list(columns)).round(2)


def _mean_current(mission: Mission, depth: float) -> Array:
    """Current at the origin at the start, every distribution at its mean, shape (2,) [m/s]."""
    current = Scenario.at_means(mission).current
    if current is None:
        return np.zeros(2)
    return np.broadcast_to(current.velocity(0.0, depth, np.zeros((2, 1))), (2, 1))[:, 0]
