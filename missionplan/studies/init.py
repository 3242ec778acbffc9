"""`init`: a starter folder with a commented mission, vehicle and data set that run as they stand."""

import cmath
import math
from importlib.resources import files
from pathlib import Path

import numpy as np
import pandas as pd

from missionplan.arrays import Array
from missionplan.mission import Mission, load
from missionplan.mission.views import TransitMission
from missionplan.montecarlo.distributions import mean_of
from missionplan.montecarlo.streams import stream
from missionplan.results.base import to_csv, to_json
from missionplan.scenario.scenario import Scenario
from missionplan.store.folder import write_atomically
from missionplan.store.paths import as_path, vacant
from missionplan.studies.schemas.schema import KINDS, Kind, schema

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
_SCHEMAS: dict[str, Kind] = {f"schema/{kind}.json": kind for kind in KINDS}
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
    if loop:
        return _second_round(folder)
    paths = vacant(folder, (*_TEXTS.values(), _LOG, *_SCHEMAS))
    for source, name in _TEXTS.items():
        write_atomically(folder / name, (files("missionplan") / "starter" / source).read_text(encoding="utf-8"))
    write_atomically(folder / _LOG, to_csv(sea_trial(load(folder / "mission.yaml"))))
    for name, kind in _SCHEMAS.items():
        write_atomically(folder / name, to_json(schema(kind)))
    return tuple(paths)


def _second_round(folder: Path) -> tuple[Path, ...]:
    paths = vacant(folder, _LOOP)
    for name, path in zip(_LOOP, paths, strict=True):
        write_atomically(path, (files("missionplan") / "starter" / "loop" / name).read_text(encoding="utf-8"))
    return tuple(paths)


def sea_trial(mission: Mission, *, legs: int = LEGS, compass_bias: float = COMPASS_BIAS, seed: int = 7) -> pd.DataFrame:
    """Simulate a navigation log: a square sailed round and round, with a biased compass.

    On each leg the vehicle steers from its fix for the next corner, by dead reckoning through still water. It is also
    moved by the mission's mean current at the depth of its first transit, a velocity error drawn once a leg, and the
    compass's bias; every fix has its error. At the surface it drifts with the current for the mission's surfacing time.

    Parameters
    ----------
    mission : Mission
        With a site and navigation; distributions are taken at their means.
    legs : int
    compass_bias : float
        Clockwise from the course steered to the course made [rad].
    seed : int

    Returns
    -------
    DataFrame
        Columns of a data set of kind ``transit``.
    """
    checked = TransitMission.of(mission)
    transit, navigation = checked.transit(), checked.navigation
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
