"""The identity covers all that a number depends on, and names in what two of them differ."""

import dataclasses
import importlib.metadata
import json
import os
import shutil
import subprocess
import sys
from functools import partial
from pathlib import Path

import numpy as np
import pytest

import missionplan
from missionplan import InputError, Mission, simulate
from missionplan import identity as module
from missionplan.cli import main
from missionplan.identity import Identity, differences, digest_of, running_program
from tests.fixtures import TRANSIT

PACKAGE = Path(missionplan.__file__).parent
CHESAPEAKE = PACKAGE.parent / "missions" / "chesapeake.yaml"
MISSION = {"name": "a", "phases": [{"transit": {"speed": "1.5 m/s"}}]}


def with_plugin(monkeypatch, tmp_path, text, group="missionplan.effects"):
    (tmp_path / "fouling.py").write_text(text)
    entry = importlib.metadata.EntryPoint("fouling", "fouling:INFO", group)
    monkeypatch.setattr(module, "entry_points", lambda group: [entry] if group == entry.group else [])
    monkeypatch.setattr(sys, "path", [str(tmp_path), *sys.path])
    return module.running_program.__wrapped__()


def test_versions_of_numerical_libraries_and_python_are_in_it():
    libraries = running_program().libraries
    assert libraries["numpy"] == np.__version__
    assert {"scipy", "pandas", "python"} <= libraries.keys()


@pytest.mark.parametrize("group", ["missionplan.effects", "missionplan.importers"])
def test_the_source_of_a_plugin_is_in_it_and_it_is_not_run(monkeypatch, tmp_path, group):
    first = with_plugin(monkeypatch, tmp_path, "raise SystemExit\n", group)
    second = with_plugin(monkeypatch, tmp_path, "raise SystemExit  # other\n", group)
    (line,) = differences(first.parts(), second.parts())
    assert line.startswith("plug-in fouling: was ")


def test_a_plugin_whose_source_is_gone_is_said(monkeypatch):
    entry = importlib.metadata.EntryPoint("gone", "no_such_package:INFO", "missionplan.effects")
    monkeypatch.setattr(module, "entry_points", lambda group: [entry])
    assert module.running_program.__wrapped__().plugins == {"no_such_package": "missing"}


def test_every_file_of_the_package_counts_and_nothing_that_python_writes(tmp_path):
    copy = tmp_path / "missionplan"
    shutil.copytree(PACKAGE, copy, ignore=shutil.ignore_patterns("__pycache__"))
    same = module._digest_of_folder(str(copy))
    assert same == running_program().code
    (copy / "__pycache__").mkdir(exist_ok=True)
    (copy / "__pycache__" / "errors.cpython-311.pyc").write_bytes(b"x")
    assert module._digest_of_folder(str(copy)) == same
    water = copy / "physics" / "water.py"
    water.write_text(water.read_text().replace("9.80665", "9.9"))
    assert module._digest_of_folder(str(copy)) != same


@pytest.mark.parametrize(
    ("changed", "named"),
    [
        ({"inputs": {"mission": {**MISSION, "phases": [{"transit": {"speed": "1.6 m/s"}}]}}},
         "mission.phases[0].transit.speed: was 1.5 m/s, now 1.6 m/s"),
        ({"inputs": {"mission": MISSION, "datasets": ["x"]}}, "datasets[0]: was nothing, now x"),
        ({"options": {"keep": True}}, "option keep: was False, now True"),
        ({"options": {}}, "option keep: was False, now nothing"),
        ({"seed": 2}, "seed: was 1, now 2"),
        ({"program": dataclasses.replace(running_program(), code="f" * 64)}, "code of missionplan: was "),
        ({"program": dataclasses.replace(running_program(), version="9")}, "version of missionplan: was "),
        ({"program": dataclasses.replace(running_program(), libraries={})}, "library python: was "),
        ({"program": dataclasses.replace(running_program(), plugins={"p": "0" * 64})},
         "plug-in p: was nothing, now 000000000000"),
        ({"inputs": {"mission": dict(reversed(MISSION.items()))}}, "the order of keys in the inputs"),
    ],
)  # fmt: skip
def test_each_part_changes_the_digest_and_is_named(changed, named):
    before = Identity({"mission": MISSION}, {"keep": False}, 1)
    now = dataclasses.replace(before, **changed)
    assert now.digest != before.digest
    lines = differences(before.whole(), now.whole())
    assert lines[0].startswith(named)
    assert len(lines) == (8 if "library" in named else 1)


def test_an_identity_comes_back_from_a_file():
    before = Identity.of({"mission": MISSION, "axis": (np.float64(0.1), np.int64(3))}, {"jobs": 3, "trials": 2}, 1)
    assert Identity.from_whole(json.loads(json.dumps(before.whole()))) == before


def test_where_blocks_are_computed_is_no_part_of_it():
    here = Identity.of({}, {"jobs": 1, "backend": "loky", "scheduler": None, "trials": 2}, 1)
    there = Identity.of({}, {"jobs": 8, "backend": "dask", "scheduler": "tcp://a:1", "trials": 2}, 1)
    assert here == there


def test_a_summary_states_it_so_that_others_can_compute_it_again():
    mission = Mission.from_data(TRANSIT)
    one, two = (simulate(mission, trials=20, seed=seed).summary() for seed in (1, 2))
    again = simulate(mission, trials=20, seed=1, jobs=2, backend="threading").summary()
    assert one["schema"] == "missionplan/summary/1"
    assert one["identity"] == digest_of(json.loads(json.dumps(one["identity_parts"]))) == again["identity"]
    assert one["identity"] != two["identity"]
    assert differences(one["identity_parts"], two["identity_parts"]) == ["seed: was 1, now 2"]


def test_trials_of_the_file_and_of_an_option_are_one():
    asked = simulate(Mission.from_data(TRANSIT), trials=20, seed=3)
    written = simulate(Mission.from_data({**TRANSIT, "monte_carlo": {"trials": 20, "seed": 3}}))
    assert asked.provenance.identity == written.provenance.identity


def test_it_takes_no_noticeable_time():
    code = "import time, missionplan.identity as i; t = time.process_time(); i.running_program();"
    code += "print(time.process_time() - t)"
    taken = min(
        float(subprocess.run([sys.executable, "-c", code], capture_output=True, check=True).stdout) for _ in "ab"
    )
    assert taken < 0.25


@pytest.mark.parametrize(
    ("study", "options"),
    [
        (simulate, {}),
        (missionplan.explore, {"vary": "out.speed=1.2:1.8:0.6 m/s"}),
        (missionplan.optimise, {"choose": ["out.speed=1.2:1.8:0.6 m/s"]}),
    ],
    ids=lambda each: getattr(each, "__name__", ""),
)
def test_blocks_of_other_code_are_refused_and_stay(monkeypatch, tmp_path, study, options):
    required = [{"quantity": "out.arrived", "probability": 0.5}]
    mission = Mission.from_data({**TRANSIT, "requirements": required})
    run = partial(study, mission, trials=20, checkpoint=tmp_path / "blocks", **options)
    run()
    before = {path: path.read_bytes() for path in (tmp_path / "blocks").iterdir()}
    other = dataclasses.replace(
        running_program(), code="0" * 64, libraries={**running_program().libraries, "numpy": "9"}
    )
    monkeypatch.setattr(module, "running_program", lambda: other)
    with pytest.raises(InputError, match="another run") as caught:
        run(resume=True)
    named = [line.partition(":")[0].strip() for line in str(caught.value).splitlines()[1:]]
    assert named == ["code of missionplan", "library numpy"]
    assert {path: path.read_bytes() for path in (tmp_path / "blocks").iterdir()} == before


def test_a_resumed_run_of_a_copy_with_another_gravity_is_refused_and_overwrites_nothing(tmp_path, monkeypatch):
    copy = tmp_path / "other" / "missionplan"
    shutil.copytree(PACKAGE, copy)  # with what is compiled
    gravity = copy / "physics" / "water.py"
    gravity.write_text(gravity.read_text().replace("9.80665", "9.9"))
    (tmp_path / "transit.yaml").write_text(json.dumps(TRANSIT))
    words = ["missionplan", "simulate", "transit.yaml", "--jobs", "1", "--out", "out", "--quiet", "--trials"]
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", [*words, "50"])
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code in (0, 3)
    before = {path: path.read_bytes() for path in (tmp_path / "out").rglob("*") if path.is_file()}
    other = [sys.executable, "-m", *words, "100", "--resume"]
    environment = {**os.environ, "PYTHONPATH": str(copy.parent)}
    refused = subprocess.run(other, env=environment, capture_output=True, text=True, check=False)
    assert refused.returncode == 2
    assert "code of missionplan: was " in refused.stderr
    assert {path: path.read_bytes() for path in (tmp_path / "out").rglob("*") if path.is_file()} == before
