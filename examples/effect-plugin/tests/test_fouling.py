"""The plug-in is in the catalogue, and fouling that is hidden in a log is found by name."""

import csv
import json
import math
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

MISSION = """
name: Ten days on a survey
navigation:
  velocity_error: {sigma: 0.02 m/s}
  surfacing_time: 90 s
  fix_error: 3 m
phases:
  - transit: {name: out, from: [0 m, 0 m], to: [40 km, 0 m], speed: 1 m/s, d_max: 4 km, arrival_radius: 100 m}
"""


def run(*words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "missionplan", *words], capture_output=True, text=True, check=False, timeout=300
    )


def write_log(folder: Path, rate: float, seed: int) -> None:
    """Sixty legs of an hour in ten days, headings in turn, each flown in steps of a minute by a loop of its own."""
    rng = np.random.default_rng(seed)
    folder.mkdir()
    header = ["leg", "t_start_s", "t_end_s", "x_start_m", "y_start_m", "x_dr_m", "y_dr_m", "x_end_m", "y_end_m"]
    rows, clock, fix = [], 0.0, np.zeros(2)
    for leg in range(60):
        heading = math.radians(75.0 * leg)
        way = np.array([math.sin(heading), math.cos(heading)])
        drift = rng.normal(0.0, 0.02, 2)
        true = fix + rng.normal(0.0, 3.0, 2)
        believed = fix.copy()
        for minute in range(60):
            age = (clock + 60.0 * minute) / 86400.0
            true += 60.0 * ((1.0 - rate * age) * way + drift)
            believed += 60.0 * way
        after = true + rng.normal(0.0, 3.0, 2)
        rows.append([leg + 1, clock, clock + 3600.0, *fix, *believed, *after])
        clock, fix = clock + 14400.0, after
    with (folder / "legs.csv").open("w", newline="") as file:
        csv.writer(file).writerows([header, *rows])
    (folder / "dataset.yaml").write_text("kind: transit\nname: Survey\nfile: legs.csv\nnoise: {fix: 3 m}\n")


@pytest.mark.parametrize(("rate", "seed"), [(0.02, 1), (0.035, 2)])
def test_hidden_fouling_is_named(tmp_path: Path, rate: float, seed: int) -> None:
    write_log(tmp_path / "log", rate, seed)
    mission = tmp_path / "mission.yaml"
    mission.write_text(MISSION)
    report = tmp_path / "report"
    done = run("diagnose", str(mission), str(tmp_path / "log"), "--out", str(report), "--jobs", "1", "--quiet")
    assert done.returncode == 0, done.stderr
    found = json.loads((report / "diagnosis.json").read_text())
    assert found["causes"] == ["fouling"]
    (estimate,) = found["ranking"][0]["parameters"]
    assert estimate["low"] - 0.002 < rate < estimate["high"] + 0.002
    assert "fouling" in (report / "mission.yaml").read_text()
    simulated = run(
        "simulate", str(report / "mission.yaml"), "--trials", "200", "--jobs", "1", "--out", str(tmp_path / "plan")
    )
    assert simulated.returncode == 0, simulated.stderr


def test_the_catalogue_says_where_it_comes_from() -> None:
    shown = run("effects", "fouling")
    assert shown.returncode == 0
    assert "From: missionplan-fouling." in shown.stdout
    assert "rate: 0.02" in shown.stdout
