"""The answer on standard output of any encoding, full, or closed: a message at worst, and the report is kept."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from missionplan.cli.options import remark

MISSION = Path(__file__).parents[2] / "missions" / "chesapeake.yaml"
SMALL = """
name: small – 4 nmi ± nothing
navigation: {velocity_error: {sigma: 0.035 m/s}, surfacing_time: 90 s}
phases:
  - transit: {name: ingress, from: [0 m, 0 m], to: [4 nmi, 0 m], speed: 1.25 m/s, d_max: 4 nmi, arrival_radius: 50 m}
"""
UNDRAWN = """
from missionplan.cli import main
from missionplan.report.page import Drawn, drawing_by
def undrawn():
    with drawing_by(lambda figure, shown: Drawn("<svg/>")):
        main()
"""
COPIES = (
    UNDRAWN
    + """
import json, os, sys
def broken():
    reading, writing = os.pipe()
    os.close(reading)
    return writing
def ended(name, words):
    opened = {"full": lambda: os.open("/dev/full", os.O_WRONLY), "gone": broken}
    out = opened.get(name.partition("-")[0], lambda: os.open(name + ".out", os.O_WRONLY | os.O_CREAT))()
    said = os.open(name + ".err", os.O_WRONLY | os.O_CREAT)
    if copy := os.fork():
        return os.waitstatus_to_exitcode(os.waitpid(copy, 0)[1])
    os.dup2(out, 1), os.dup2(said, 2)
    sys.argv = ["missionplan", *words]
    undrawn()
runs = json.loads(sys.argv[1])
sys.argv = ["missionplan", *sys.argv[2:]]
try:
    undrawn()  # what it imports, its copies need not
except SystemExit:
    pass
print(*[ended(name, words) for name, words in runs.items()])
"""
)
"""Runs of one process's copies, each to an end of its own."""
NEEDS_FULL = pytest.mark.skipif(not Path("/dev/full").exists(), reason="this system has no /dev/full")


def simulate(folder, *more):
    mission = folder.parent / "small.yaml"
    mission.write_text(SMALL, encoding="utf-8")
    return ["simulate", str(mission), "--trials", "20", "--jobs", "1", "--no-assumptions", "--out", str(folder), *more]


def runs(folder, names, encoding, others=()):
    """Exit statuses of runs of the small mission, by their names, whose outputs are in the folder, and of others."""
    environment = {**os.environ, "PYTHONIOENCODING": encoding, "PYTHONUTF8": "0"}
    own = {name: simulate(folder / name, *(["--json"] if name.endswith("json") else [])) for name in names}
    words = {**own, **dict(others)}
    command = [sys.executable, "-c", COPIES, json.dumps(words), *simulate(folder / "first", "--quiet")]
    done = subprocess.run(command, capture_output=True, env=environment, cwd=folder, check=True)
    return dict(zip(words, map(int, done.stdout.split()), strict=True))


def check_printed(folder, ends, encoding):
    """A table, and a summary as JSON."""
    assert {ends["table"], ends["json"]} <= {0, 3}
    assert b"Traceback" not in (folder / "table.err").read_bytes() + (folder / "json.err").read_bytes()
    assert "min" in (folder / "table.out").read_bytes().decode(encoding)
    summary = json.loads((folder / "json.out").read_bytes().decode(encoding))
    assert (summary["trials"], summary["mission"]) == (20, "small – 4 nmi ± nothing")


@pytest.mark.slow
@pytest.mark.parametrize("encoding", ["latin-1", "cp1252"])
def test_every_encoding_can_be_printed(tmp_path, encoding):
    check_printed(tmp_path, runs(tmp_path, ["table", "json"], encoding), encoding)


OTHERS = {
    "full-effects": ["effects"],
    "full-help": ["--help"],
    "full-validate": ["validate", str(MISSION)],
    "full-version": ["--version"],
}


@NEEDS_FULL
def test_ascii_can_be_printed_a_full_output_is_said_and_a_reader_that_has_gone_away_is_no_error(tmp_path):
    ends = runs(tmp_path, ["table", "json", "full", "full-json", "gone", "gone-json"], "ascii", OTHERS)
    check_printed(tmp_path, ends, "ascii")
    for name in ("full", "full-json", *OTHERS):
        said = (tmp_path / f"{name}.err").read_bytes()
        assert (name, ends[name]) == (name, 1)
        assert b"cannot write to standard output" in said
        assert b"Traceback" not in said
    for name in ("full", "full-json"):
        assert b"the report is saved in" in (tmp_path / f"{name}.err").read_bytes()
        assert (tmp_path / name / "report.html").is_file()
    for name in ("gone", "gone-json"):
        said = (tmp_path / f"{name}.err").read_bytes()
        assert (ends[name] in (0, 3), b"Traceback" in said, b"Error" in said) == (True, False, False)
        assert (tmp_path / name / "report.html").is_file()


def test_closed_streams_are_no_error(tmp_path):
    command = [sys.executable, "-c", f"{UNDRAWN}undrawn()", *simulate(tmp_path / "out")]
    done = subprocess.run(["sh", "-c", 'exec "$@" >&- 2>&-', "sh", *command], check=False)
    assert done.returncode in (0, 3)
    assert (tmp_path / "out" / "report.html").is_file()


@pytest.mark.skipif(sys.platform == "win32", reason="this system has no limit of open files")
@pytest.mark.parametrize("limit", [13, *(pytest.param(each, marks=pytest.mark.slow) for each in (9, 14))])
def test_too_few_files_are_an_error_in_words(tmp_path, limit):
    command = [sys.executable, "-m", "missionplan", "simulate", str(MISSION), "--trials", "20000", "--jobs", "2"]
    lowered = ["sh", "-c", f'ulimit -n {limit}; exec "$@"', "sh", *command, "--out", str(tmp_path / "out")]
    done = subprocess.run(lowered, capture_output=True, check=False)
    assert (done.returncode, b"Traceback" in done.stderr) == (1, False)
    assert re.search(b"open no more files: raise the limit|Too many open files", done.stderr)


@pytest.mark.parametrize("is_terminal", [True, False])
def test_notes_break_at_words_on_a_terminal_alone(capsys, monkeypatch, is_terminal):
    words = "Note: " + "the flow may be laminar and the turbulent line too high; " * 4
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setattr(sys.stderr, "isatty", lambda: is_terminal)
    remark(words.strip())
    lines = capsys.readouterr().err.splitlines()
    assert (len(lines) > 2) == is_terminal
    assert " ".join(lines) == words.strip()
    assert not is_terminal or max(map(len, lines)) <= 80
