"""Rows of logs and records of real vehicles, which lie beside the repository."""

import importlib.util
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from missionplan import diagnose
from missionplan.importers import import_logs
from missionplan.importers.geodesy import displacement
from missionplan.mission import Mission, load
from missionplan.results.learned import Diagnosis
from validation.rows import NotMeasurableHereError, Options, at_least, at_most, between, near, reported, row


def folder_of(options: Options, *names: str) -> Path:
    """Return a folder of records.

    Raises
    ------
    NotMeasurableHereError
        When it is not here.
    """
    folder = options.data.joinpath(*names)
    if not folder.exists():
        raise NotMeasurableHereError(f"no record {'/'.join(names)} in the folder of data")
    return folder


NUMBERS = (
    reported("legs"),
    reported("next leg, rms", "m"),
    reported("next leg by the last one, rms", "m"),
    reported("next leg by the mean of the past, rms", "m"),
    reported("all the way, rms", "m"),
    reported("all the way by a stationary error, rms", "m"),
)
"""Of the last part of a log, predicted by what the first part told; then the coverage of the next legs."""


def numbers_of(folder: Path, mission: Mission, holdout: float = 0.38) -> tuple[list[float], Diagnosis]:
    """Diagnose the first part of a log, predict the last, leg by leg and all the way; the numbers and the diagnosis."""
    legs = _legs(folder)
    found = diagnose(mission, folder, plan=False, holdout=holdout)
    last = found.last_part
    if last is None:
        return [float(len(legs)), *[float("nan")] * 6], found
    ahead = last.one_step
    others = [ahead.yardsticks[name].rmse for name in ("last_leg", "mean_of_past")]
    whole = [last.whole.rmse, _stationary(legs, last.groups)]
    return [float(len(legs)), ahead.rmse, *others, *whole, ahead.coverage_90], found


def _legs(folder: Path) -> pd.DataFrame:
    legs = pd.read_csv(folder / "legs.csv")
    return legs[legs["ok"] == 1] if "ok" in legs else legs


def _stationary(legs: pd.DataFrame, last: int) -> float:
    """Error of the last legs by the mean velocity error of those before, with no model at all [m]."""
    if {"lat_dr_end", "lat_end"} <= set(legs):
        error = np.stack(displacement(legs["lat_dr_end"], legs["lon_dr_end"], legs["lat_end"], legs["lon_end"]))
    else:
        error = np.stack((legs["x_end_m"] - legs["x_dr_m"], legs["y_end_m"] - legs["y_dr_m"]))
    time = (legs["t_end_s"] - legs["t_start_s"]).to_numpy()
    mean = (error / time)[:, :-last].mean(axis=1, keepdims=True)
    return float(np.sqrt(np.mean(np.sum((error - mean * time)[:, -last:] ** 2, axis=0))))


def data_sets_below(folder: Path) -> Iterator[tuple[str, Path, Path]]:
    """Yield name, folder and mission of every data set of legs below a folder that has a mission beside it."""
    for settings in sorted(folder.rglob("dataset.yaml")):
        for mission in (settings.parent / "mission.yaml", settings.parent.parent / "mission.yaml"):
            if mission.exists() and (settings.parent / "legs.csv").exists():
                yield str(settings.parent.relative_to(folder)), settings.parent, mission
                break


@row(
    "sea.modena",
    "A glider in the Gulf of Mexico: persistence and an inertial current",
    case="97 legs over 14 days at 27.4° N; the next leg on all of them, the last 37 by what the first 60 tell",
    reference="yardsticks computed elsewhere: legs 11 to 97 by the last leg 451 m, by the mean of the past 1530 m",
    accepted=[
        near("persistence and inertial current claimed", 1.0, 0.0),
        near("a tide, compass or log claimed", 1.0, 0.0),
        at_most("next leg on 11 to 97, rms", 400.0, "m"),
        near("by the last one", 451.0, 5.0, "m"),
        near("by the mean of the past", 1530.0, 15.0, "m"),
        at_most("next leg, rms", 640.0, "m"),
        *NUMBERS[2:],
        between("next legs in 90 % intervals", 0.82, 0.98),
    ],
    differs="the record's description finds no error by heading; beside a persistence of days, an inertial current "
    "that wanders and a shear, a deviation of 13° gains 14 nats: 11 of them by legs 32 and 33, which alone went "
    "south-west, and 7 to 17 with other forms of the persistence and of the oscillation. It is larger than a "
    "compass's: what is told is that the error depends on heading, as part of what is not constant over the record, "
    "and nothing is to be corrected",
    cost=30.0,
)
def _modena(options: Options) -> list[float]:
    folder = folder_of(options, "modena")
    mission = load(folder / "mission.yaml")
    found = diagnose(mission, folder, plan=False)
    claimed = {"persistent-error", "inertial-current"} <= set(found.causes)
    wrong = {"tidal-current", "compass-bias", "compass-deviation", "speed-scale"} & set(found.causes)
    ahead = [found.calibration[f"next_leg_{name}_rms_m"] for name in ("model", "last_leg", "mean_so_far")]
    numbers, _first = numbers_of(folder, mission)
    return [float(claimed), float(bool(wrong)), *ahead, *numbers[1:]]


@row(
    "sea.saanich",
    "A glider in a quiet fjord: the model is adequate",
    case="20 legs; the last eight by what the first twelve tell",
    reference="independent errors of 0.026 m/s by an independent script",
    accepted=[near("adequate", 1.0, 0.0), *NUMBERS, between("next legs in 90 % intervals", 0.75, 1.0)],
    cost=15.0,
)
def _saanich(options: Options) -> list[float]:
    folder = folder_of(options, "saanich")
    numbers, _first = numbers_of(folder, load(folder / "mission.yaml"))
    adequate = diagnose(load(folder / "mission.yaml"), folder, plan=False).verdict == "adequate"
    return [float(adequate), *numbers]


_REMUS = """
name: REMUS 100 of a simulator
navigation: {velocity_error: {sigma: 0.02 m/s}, surfacing_time: 60 s, fix_error: 1 m}
phases:
  - transit: {from: [0 m, 0 m], to: [800 m, 0 m], speed: 1.2 m/s, d_max: 150 m, arrival_radius: 20 m}
monte_carlo: {trials: 1000, seed: 1}
"""


@row(
    "sea.museum",
    "A constant current is named and measured in the legs of another simulator",
    case="REMUS 100 of the Python Vehicle Simulator after its mend, 24 legs of 120 s",
    reference="0.150 m/s toward 60°, put in by that simulator",
    accepted=[near("current claimed", 1.0, 0.0), near("its speed", 0.150, 0.02, "m/s")],
    cost=15.0,
)
def _museum(options: Options) -> list[float]:
    import yaml

    folder = folder_of(options, "museum", "remus-current-after")
    found = diagnose(Mission.from_data(yaml.safe_load(_REMUS)), folder, plan=False)
    sizes = {
        each.name: each.value
        for entry in found.ranking[:1]
        for each in entry.parameters
        if each.effect == "mean-current"
    }
    speed = float(np.hypot(sizes.get("east", np.nan), sizes.get("north", np.nan)))
    return [float("mean-current" in found.causes), speed]


@row(
    "sea.current-fields",
    "Currents interpolated in the fields of ocean models",
    case="1000 random places, times and depths each of ROMS (WCOFS), FVCOM (SFBOFS) and SCHISM files as published",
    reference="interpolation by brute force, written apart",
    seed=25,
    accepted=[near("models compared", 3.0, 0.0), at_most("greatest difference", 1e-3, "m/s")],
    cost=30.0,
)
def _current_fields(options: Options) -> list[float]:
    folder_of(options, "currents")
    if importlib.util.find_spec("xarray") is None:
        raise NotMeasurableHereError("xarray is not installed")
    from tests.scenario.currents import test_published_fields as published

    worst, compare = [], published.compare
    published.DATA = options.data / "currents"
    published.compare = lambda *field: worst.append(compare(*field)) or worst[-1]
    try:
        for each in (
            published.test_roms_of_the_west_coast,
            published.test_fvcom_of_san_francisco_bay,
            published.test_schism_of_a_quarter_of_an_annulus,
        ):
            each()
    finally:
        published.compare = compare
    return [float(len(worst)), max(worst)]


_RAW = {
    "slocum-saanich": ("dbdreader", 20),
    "seaexplorer-sea035": ("numpy", 59),
    "seaglider-sg561": ("netCDF4", 8),
    "seaglider-sg180": ("netCDF4", 6),
    "og1-sg033": ("netCDF4", 10),
    "seaexplorer-sea046": ("numpy", 3),
    "moos-helm": ("numpy", 20),
    "slocum-bass2015": ("dbdreader", 2),
}
"""Raw logs, the library that reads them, and legs that count by the reference."""


@row(
    "sea.raw-logs",
    "Legs cut from raw logs are those of independent scripts",
    case="eight vehicles of four makes: Slocum, Seaglider, SeaExplorer, MOOS-IvP",
    reference="legs made by scripts of their own",
    accepted=[
        at_least("logs compared", 4.0),
        at_most("legs that count, more or fewer", 0.0),
        at_most("fixes apart, greatest", 5.0, "m"),
        at_most("times apart, greatest", 1.0, "s"),
        at_most("dead-reckoned ends apart, greatest", 11.0, "m"),
    ],
    cost=30.0,
)
def _raw_logs(options: Options) -> list[float]:
    folder_of(options, "raw")
    logs = [name for name, (module, _count) in _RAW.items() if importlib.util.find_spec(module)]
    missed, fixes, times, ends = 0, [0.0], [0.0], [0.0]
    for name in logs:
        folder = folder_of(options, "raw", name)
        result = import_logs([folder])
        missed += abs(result.counted - _RAW[name][1])
        reference = pd.read_csv(folder / "legs-reference.csv")
        for _, wanted in reference.iterrows():
            found = result.dives.loc[(result.dives["t_start_s"] - wanted["t_start_s"]).abs().idxmin()]
            times += [abs(found[key] - wanted[key]) for key in ("t_start_s", "t_end_s")]
            fixes += [_apart(found, wanted, end) for end in ("start", "end")]
            ends.append(_apart(found, wanted, "dr_end"))
    return [float(len(logs)), float(missed), max(fixes), max(times), float(np.nanmax(ends))]


def _apart(found: Any, wanted: Any, end: str) -> float:
    places = (found[f"lat_{end}"], found[f"lon_{end}"], wanted[f"lat_{end}"], wanted[f"lon_{end}"])
    return float(np.hypot(*displacement(*places)))
