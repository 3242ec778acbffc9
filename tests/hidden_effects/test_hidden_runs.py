"""Running a tool over cases, with a stand-in that never finds an effect."""

import pytest

from . import __main__ as study
from . import tool
from .cases import draw_case

STAND_IN = """
import json, sys
from pathlib import Path
words = sys.argv[1:]
if "--help" in words:
    sys.exit(0)
assert words[0] == "diagnose" and Path(words[1]).is_file() and (Path(words[2]) / "dataset.yaml").is_file()
if "dives.csv" in (Path(words[2]) / "dataset.yaml").read_text():
    print("no descents today", file=sys.stderr)
    sys.exit(2)
out = Path(words[words.index("--out") + 1])
out.mkdir()
found = {"verdict": "adequate", "causes": [], "credible_set": [[]], "ranking": []}
(out / "diagnosis.json").write_text(json.dumps(found))
"""


@pytest.fixture
def stand_in(tmp_path, monkeypatch):
    package = tmp_path / "stand_in_tool"
    package.mkdir()
    (package / "__init__.py").write_text("")
    (package / "__main__.py").write_text(STAND_IN)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    monkeypatch.setattr(tool, "PROGRAM", package.name)


@pytest.mark.parametrize("in_process", [True, False])
def test_runs_the_command_line(stand_in, tmp_path, in_process):
    assert tool.unavailable_reason() == ""
    leg = tool.diagnose(draw_case(1, "transit", "control"), tmp_path / "seen", tmp_path / "truth", in_process)
    assert (leg.diagnosis["verdict"], leg.error) == ("adequate", "")
    dive = tool.diagnose(draw_case(1, "descent", "control"), tmp_path / "seen", tmp_path / "truth", in_process)
    assert dive.error.startswith("exit status 2")
    assert "no descents today" in dive.error


def test_says_why_it_is_unavailable(monkeypatch):
    monkeypatch.setattr(tool, "PROGRAM", "no_such_tool_anywhere")
    assert "does not exist" in tool.unavailable_reason()


def test_study_prints_and_judges(stand_in, tmp_path, capsys):
    words = ["--cases", "3", "--kind", "transit", "--seed", "3", "--jobs", "1", "--in-process"]
    status = study.main([*words, "--json", str(tmp_path / "figures.json")])
    page = capsys.readouterr().out
    assert status == 1, "a tool that finds nothing is refuted"
    assert "transit: 3 cases" in page
    assert (tmp_path / "figures.json").exists()
    assert study.main([*words, "--cases", "2", "--scenario", "control", "--strengths"]) == 0
    assert "control" in capsys.readouterr().out
