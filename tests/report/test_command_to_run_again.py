"""The command that a report gives makes the same numbers, in its folder, from its own mission file."""

import json
import shlex
from dataclasses import replace
from pathlib import Path

import pytest
from typer.testing import CliRunner

import missionplan
from missionplan.cli import app
from missionplan.mission import load
from missionplan.report.html import rerun_command
from missionplan.results import Provenance

MISSION = Path(__file__).parents[2] / "missions" / "chesapeake.yaml"
TRIALS = 40


def numbers(folder):
    summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    return {key: value for key, value in summary.items() if key not in ("provenance", "elapsed_s", "created_utc")}


@pytest.mark.parametrize(
    "study",
    [
        missionplan.simulate,
        *(pytest.param(each, marks=pytest.mark.slow) for each in (missionplan.size_anchor, missionplan.sweep_dmax)),
    ],
)
def test_it_makes_the_same_numbers(tmp_path, monkeypatch, study):
    result = study(MISSION, trials=TRIALS, seed=3)
    folder = result.save(tmp_path / "report")
    command = rerun_command(result.provenance)
    assert command in (folder / "report.html").read_text(encoding="utf-8")
    monkeypatch.chdir(folder)
    found = CliRunner().invoke(app, [*shlex.split(command)[1:], "--quiet", "--out", "again"])
    assert found.exit_code in (0, 3), found.output
    again, first = numbers(folder / "again"), numbers(folder)
    assert again.keys() == first.keys()
    assert [key for key in first if "file" not in key and again[key] != first[key]] == []


def test_trials_of_the_mission_are_not_told_twice():
    few = load(MISSION.with_name("fig8.yaml")).with_({"sweep.d_max.points": 3})
    made = missionplan.sweep_dmax(few, trials=TRIALS).provenance
    assert f"--trials {TRIALS}" in rerun_command(made)
    assert "--trials" not in rerun_command(replace(made, trials=made.data["monte_carlo"]["trials"]))


def test_trials_on_the_way_to_a_precision_are_a_result():
    made = Provenance("simulate", "", "", 1, 12_000, {"precision": "total.success=0.01"}, elapsed_s=0.0)
    assert rerun_command(made) == "missionplan simulate mission.yaml --seed 1 --precision total.success=0.01"
