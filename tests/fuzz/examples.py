"""What is changed: shipped missions, one with more keys, and a small data set of every kind."""

import copy
import shutil
from functools import cache
from pathlib import Path

import numpy as np
import yaml

from missionplan.studies.init import init

ROOT = Path(__file__).parents[2]
MISSIONS = ("chesapeake", "fig8", "anchor-design", "autosub-transition", "starter", "rich")


def write_field(path: Path, attributes: dict[str, dict[str, str]], scales: dict[str, float]) -> None:
    """Write a field, the same at any attributes whose units are these scales [SI]: 0.5 and 0.1 m/s at 5 to 20 m, slower below."""
    import netCDF4

    axes = {"time": 3600.0 * np.arange(4.0), "lev": np.array([5.0, 20.0, 60.0]), "lat": 45.0 + np.linspace(-0.1, 0.1, 3),
            "lon": -124.0 + np.linspace(-0.1, 0.1, 3)}  # fmt: skip
    with netCDF4.Dataset(path, "w") as file:
        for name, values in axes.items():
            file.createDimension(name, len(values))
            file.createVariable(name, "f8", (name,))[:] = values / scales.get(name, 1.0)
        for name, speed in (("u", 0.5), ("v", 0.1)):
            profile = speed * np.array([1.0, 0.7, 0.2])[None, :, None, None] / scales.get(name, 1.0)
            file.createVariable(name, "f8", tuple(axes))[:] = np.broadcast_to(profile, (4, 3, 3, 3))
        for name, own in attributes.items():
            file[name].setncatts(own)


@cache
def _trees() -> dict[str, dict]:
    found = {}
    for name in MISSIONS[:4]:
        found[name] = _with_vehicle(ROOT / "missions" / f"{name}.yaml")
    found["starter"] = _with_vehicle(ROOT / "missionplan" / "starter" / "mission.yaml")
    found["rich"] = _rich(found["starter"])
    return found


def _with_vehicle(path: Path) -> dict:
    data = yaml.safe_load(path.read_text())
    if isinstance(data.get("vehicle"), str):
        data["vehicle"] = yaml.safe_load((path.parent / data["vehicle"]).read_text())
    return data


def _rich(starter: dict) -> dict:
    """Return a mission with distributions of every form, effects, correlations and a sweep."""
    data = copy.deepcopy(starter)
    data["effects"] = [
        {"compass-bias": {"angle": {"mean": "0 deg", "sd": "2 deg"}}},
        {"mean-current": {"east": "0.05 m/s", "north": {"low": "-0.05 m/s", "high": "0.05 m/s"}}},
        {"line-payout": {"delay_per_length": "0.1 s/m"}},
        {"one-of": [_explanation(0.6, "speed-scale", "fraction"), _explanation(0.3, "drag-bias", "fraction")]},
    ]
    data["correlations"] = [{"between": ["site.current[0].speed", "site.current[1].speed"], "rho": 0.5}]
    data["sweep"] = {"d_max": {"from": 0.1, "to": 1.0, "points": 4, "of": "distance"}, "sigma": ["0.03 m/s"]}
    data["site"]["depth"] = {"choices": ["30 m", "31 m"]}
    data["navigation"]["surfacing_time"] = {"median": "90 s", "factor": 1.2}
    return data


def _explanation(probability: float, effect: str, parameter: str) -> dict:
    effects = [
        {effect: {parameter: {"mean": 0.01, "sd": 0.02}}},
        {"surface-drift": {"east": {"mean": "0 m/s", "sd": "0.1 m/s"}}},
    ]
    pair = {"between": [f"{effect}.{parameter}", "surface-drift.east"], "rho": 0.3}
    return {"probability": probability, "effects": effects, "correlations": [pair]}


def mission(name: str) -> dict:
    """Return a copy of a mission's data, the vehicle inside."""
    return copy.deepcopy(_trees()[name])


DATASETS = {
    "summary": ("chesapeake", {}),
    "descent": (
        "chesapeake",
        {"noise": {"depth": "0.05 m"}, "runs": {"a": {"depth": "12 m"}, "b": {"line_length": "5 m"}}},
    ),
    "transit": ("starter", {"noise": {"fix": "2 m"}}),
    "drag": ("chesapeake", {"reference_area": "0.01 m^2", "reference_length": "1 m"}),
    "free-oscillation": ("chesapeake", {"stiffness": "100 N/m", "mass": "10 kg"}),
    "thruster": ("chesapeake", {}),
    "propeller-transient": ("chesapeake", {"geometry": {"diameter": "0.3 m"}}),
}
"""By kind: the mission that they are diagnosed with, and keys of dataset.yaml."""


@cache
def table(kind: str) -> str:
    """Return the CSV of a small data set."""
    rng = np.random.default_rng(1)
    t = np.arange(0.0, 8.0, 0.25)
    if kind == "summary":
        return (ROOT / "missions/measured/table-1/table-1.csv").read_text()
    if kind == "transit":
        return (ROOT / "missionplan/starter/legs.csv").read_text() if _has_starter_log() else _starter_log()
    if kind == "descent":
        depth = 1.3 * (t - 1.5 * (1.0 - np.exp(-t / 1.5)))
        rows = [
            ("run,t_s,depth_m", *(f"{run},{a},{z + rng.normal(0, 0.05):.3f}" for a, z in zip(t, depth, strict=True)))
            for run in "ab"
        ]
        return "\n".join([*rows[0], *rows[1][1:]]) + "\n"
    if kind == "drag":
        return "speed_m_s,force_n\n" + "".join(f"{v:.2f},{9 * v**1.9:.3f}\n" for v in np.arange(0.2, 1.6, 0.2))
    if kind == "free-oscillation":
        wave = 0.1 * np.exp(-0.1 * t) * np.cos(2.7 * t) + rng.normal(0, 1e-3, t.size)
        return "t_s,displacement_m\n" + "".join(f"{a},{x:.5f}\n" for a, x in zip(t, wave, strict=True))
    if kind == "propeller-transient":
        rate = 600.0 * (1.0 - np.exp(-t))
        rows = zip(t, rate, 3e-5 * rate**2, 0.5 * (1.0 - np.exp(-t)), strict=True)
        return "t_s,rpm,thrust_n,speed_m_s\n" + "".join(f"{a},{n:.3f},{f:.4f},{v:.4f}\n" for a, n, f, v in rows)
    if kind == "current":
        rows = [f"{a},{z},0.1,{0.05 * np.sin(a / 3000):.4f}" for a in range(0, 90_000, 3000) for z in (0, 5, 12)]
        return "\n".join(["t_s,depth_m,east_m_s,north_m_s", *rows]) + "\n"
    volts = np.arange(-12.0, 13.0, 3.0)
    return "run,voltage_v,thrust_n\n" + "".join(f"a,{v},{0.05 * v * abs(v):.3f}\n" for v in volts)


def _has_starter_log() -> bool:
    return (ROOT / "missionplan/starter/legs.csv").is_file()


def _starter_log() -> str:
    import tempfile

    with tempfile.TemporaryDirectory() as folder:
        init(Path(folder) / "new")
        return (Path(folder) / "new" / "sea-trial" / "legs.csv").read_text()


def write_dataset(folder: Path, kind: str, keys: dict, content: bytes) -> None:
    """Write a data set folder."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "dataset.yaml").write_text(yaml.safe_dump({"kind": kind, "file": "rows.csv", **keys}, sort_keys=False))
    (folder / "rows.csv").write_bytes(content)


def copy_case(folder: Path, target: Path) -> None:
    """Copy a case's files, links as links."""
    shutil.copytree(folder, target, symlinks=True)
