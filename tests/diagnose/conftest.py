"""Missions and data set folders that tests write."""

import numpy as np
import pandas as pd
import pytest
import yaml

from missionplan.mission import load

TRANSIT = {
    "name": "Legs in a bay",
    "site": {"origin": {"latitude": "37 deg", "longitude": "-76 deg"}},
    "navigation": {"velocity_error": {"sigma": "0.03 m/s"}, "surfacing_time": "90 s", "fix_error": "3 m"},
    "phases": [
        {
            "transit": {
                "name": "out",
                "from": ["0 m", "0 m"],
                "to": ["8 km", "0 m"],
                "speed": "1.2 m/s",
                "d_max": "1 km",
                "arrival_radius": "60 m",
            }
        }
    ],
}

DESCENT = {
    "name": "Dives in a lake",
    "vehicle": {
        "hull": {"length": "1.12 m", "diameter": "0.12 m"},
        "appendage_factor": 1.25,
        "mass": "10.2 kg",
        "net_buoyancy": "0.9 N",
        "anchor": {"diameter": "0.12 m", "flooded_mass": "2.6 kg"},
    },
    "site": {"depth": "24 m", "water": {"density": "1000 kg/m^3", "viscosity": "1.1e-6 m^2/s"}},
    "phases": [{"moor": {"radius": "20 m", "anchor_wet_weight": "12 N", "line_length": "5 m"}}],
}


@pytest.fixture
def mission(tmp_path):
    def make(data):
        path = tmp_path / "base.yaml"
        path.write_text(yaml.safe_dump(data))
        return load(path)

    return make


@pytest.fixture
def transit_mission(mission):
    return mission(TRANSIT)


@pytest.fixture
def descent_mission(mission):
    return mission(DESCENT)


@pytest.fixture
def folder(tmp_path):
    """Write a data set folder from dataset.yaml's keys and a table (or the CSV's text)."""

    def write(keys, table):
        place = tmp_path / "data"
        place.mkdir(exist_ok=True)
        (place / "dataset.yaml").write_text(yaml.safe_dump({"file": "rows.csv", **keys}))
        text = table if isinstance(table, str) else table.to_csv(index=False)
        (place / "rows.csv").write_text(text)
        return place

    return write


@pytest.fixture
def legs():
    """Make a table of legs."""
    return make_legs


def make_legs(n=48, seed=1, sigma=0.03, error=None):
    """Legs on a wandering course with independent errors, and what `error(t, heading)` adds [m/s]."""
    rng = np.random.default_rng(seed)
    duration = rng.uniform(500.0, 1100.0, n)
    t = np.concatenate([[0.0], np.cumsum(duration + 120.0)[:-1]])
    heading = rng.uniform(0.0, 2.0 * np.pi, n)
    through = 1.2 * duration * np.stack([np.sin(heading), np.cos(heading)])
    wrong = rng.normal(0.0, sigma, (2, n))
    if error is not None:
        wrong = wrong + error(t + 0.5 * duration, heading)
    moved = through + wrong * duration
    start = np.cumsum(np.concatenate([np.zeros((2, 1)), moved[:, :-1]], axis=1), axis=1)
    fixed = start + rng.normal(0.0, 3.0, (2, n))
    reckoned, end = fixed + through, start + moved + rng.normal(0.0, 3.0, (2, n))
    columns = {"leg": np.arange(n) + 1, "t_start_s": t, "t_end_s": t + duration}
    for name, (x, y) in {"start": fixed, "dr": reckoned, "end": end}.items():
        columns |= {f"x_{name}_m": x, f"y_{name}_m": y}
    return pd.DataFrame(columns)
