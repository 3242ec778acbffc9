"""Rows of logs and records of real vehicles, which lie beside the repository."""

import importlib.util
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from missionplan import diagnose
from missionplan.importers.geodesy import displacement
from missionplan.importers.importing import import_logs
from missionplan.mission import Mission, load
from missionplan.results.learned.diagnosis import Diagnosis
from validation.rows import Measured, NotMeasurableHereError, Options, at_least, at_most, between, near, reported, row


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


@dataclass(frozen=True)
class Seen:
    """What a log of legs shows.

    Attributes
    ----------
    legs : int
    verdict, causes : str
    next_leg, next_by_last : float
        Root mean square error of the next leg by the extended mission and by the last leg's velocity error [m].
    whole, whole_by_mean : float
        Of the last part all the way, extended on the first, and by the stationary mean of the first part's errors [m].
    inside_90 : float
        Share of the last part's next legs inside their 90 % intervals.
    """

    legs: int
    verdict: str
    causes: str
    next_leg: float
    next_by_last: float
    whole: float
    whole_by_mean: float
    inside_90: float

    def numbers(self) -> list[float]:
        """Return its numbers."""
        return [float(self.legs), self.next_leg, self.next_by_last, self.whole, self.whole_by_mean, self.inside_90]


NUMBERS = (
    reported("legs"),
    reported("next leg, rms", "m"),
    reported("by the last leg", "m"),
    reported("last part all the way, rms", "m"),
    reported("by a stationary error", "m"),
    reported("next legs in 90 % intervals"),
)


def seen_in(folder: Path, mission: Mission, holdout: float = 0.38) -> tuple[Seen, Diagnosis]:
    """Diagnose a log of legs, and score the last part by what the first part tells."""
    found = diagnose(mission, folder, plan=False, holdout=holdout)
    last, said = found.last_part, found.calibration
    whole, mean = (float("nan"), float("nan"))
    inside = float("nan")
    if last is not None:
        whole, inside = last.whole.rmse, last.one_step.coverage_90
        mean = _stationary(folder, last.groups)
    seen = Seen(
        int(found.summary().get("observations", 0) or len(pd.read_csv(folder / "legs.csv"))),
        found.verdict,
        " + ".join(found.causes) or "none",
        float(said.get("next_leg_model_rms_m", float("nan"))),
        float(said.get("next_leg_last_leg_rms_m", float("nan"))),
        whole,
        mean,
        inside,
    )
    return seen, found


def _stationary(folder: Path, last: int) -> float:
    """Error of the last legs by the mean velocity error of those before, with no model at all [m]."""
    legs = pd.read_csv(folder / "legs.csv")
    if "ok" in legs:
        legs = legs[legs["ok"] == 1]
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
    case="97 legs over 14 days at 27.4° N; extended on legs 1 to 60, scored on 61 to 97",
    reference="yardsticks computed elsewhere: next leg by the last leg 451 m",
    accepted=[
        near("legs", 97.0, 0.0),
        at_most("next leg, rms", 400.0, "m"),
        near("by the last leg", 451.0, 5.0, "m"),
        reported("last part all the way, rms", "m"),
        reported("by a stationary error", "m"),
        between("next legs in 90 % intervals", 0.82, 0.98),
        near("persistence and inertial current claimed", 1.0, 0.0),
        near("a tide, compass or log claimed", 0.0, 0.0),
    ],
    cost=60.0,
)
def _modena(options: Options) -> Measured:
    folder = folder_of(options, "modena")
    seen, found = seen_in(folder, load(folder / "mission.yaml"))
    claimed = {"persistent-error", "inertial-current"} <= set(found.causes)
    wrong = {"tidal-current", "compass-bias", "compass-deviation", "speed-scale"} & set(found.causes)
    numbers = seen.numbers()
    numbers[0] = float(found.last_part.groups + 60 if found.last_part else numbers[0])
    return Measured([*numbers, float(claimed), float(bool(wrong))])


@row(
    "sea.saanich",
    "A glider in a quiet fjord: the model is adequate",
    case="20 legs; extended on the first 12, scored on the others",
    reference="independent errors of 0.026 m/s by an independent script",
    accepted=[
        *NUMBERS[:5],
        between("next legs in 90 % intervals", 0.75, 1.0),
        near("adequate", 1.0, 0.0),
    ],
    cost=15.0,
)
def _saanich(options: Options) -> list[float]:
    folder = folder_of(options, "saanich")
    seen, _found = seen_in(folder, load(folder / "mission.yaml"))
    return [*seen.numbers(), float(seen.verdict == "adequate")]


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
    "sea.comet",
    "Net weight from the measured density explains a glider's speed",
    case="4.1 h of yos in the stratified Baltic at 1 Hz, dives and climbs of more than 10 m",
    reference="speed through the water from the glider's current meter",
    accepted=[
        reported("constant terminal speed each way, rms", "m/s"),
        at_most("with buoyancy by the measured density, rms", 0.008, "m/s"),
    ],
)
def _comet(options: Options) -> Measured:
    data = pd.read_csv(folder_of(options, "comet") / "profile.csv")
    smooth = data.rolling(30, center=True).mean()
    rate = np.gradient(smooth["depth_m"], smooth["t_s"])
    steady = (
        (np.abs(rate) > 0.05) & (np.abs(np.gradient(smooth["buoyancy_drive_cc"])) < 0.5) & (smooth["depth_m"] > 5.0)
    )
    part = smooth[steady].dropna()
    down = np.gradient(smooth["depth_m"], smooth["t_s"])[part.index] > 0.0
    speed = part["speed_tw_adcp_mps"].to_numpy()
    flat = np.where(down, speed[down].mean(), speed[~down].mean())
    # drag k v² balances the net weight along the path: m − ρ(V + pumped) of both signs, m and V fitted
    net = part["density_kgm3"].to_numpy()
    path = np.abs(np.sin(np.radians(part["pitch_deg"].to_numpy())))
    columns = np.stack((path, -net * path, -net * part["buoyancy_drive_cc"].to_numpy() * 1e-6 * path), axis=1)
    signed = np.where(down, speed**2, -(speed**2))
    fitted = columns @ np.linalg.lstsq(columns, signed, rcond=None)[0]
    model = np.sqrt(np.maximum(np.where(down, fitted, -fitted), 0.0))
    return Measured([_rms(flat - speed), _rms(model - speed)])


def _rms(values: Any) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


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
