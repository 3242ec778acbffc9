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
TWO_RUNS = """
import sys
from missionplan.cli import main
for more in ([], ["--json"]):
    sys.argv = ["missionplan", *sys.argv[1:8], "--out", f"out{len(more)}", *more]
    try:
        main()
    except SystemExit as ended:
        print("\\nstatus", ended.code, flush=True)
"""
NEEDS_FULL = pytest.mark.skipif(not Path("/dev/full").exists(), reason="this system has no /dev/full")


def run(words, *, stdout=subprocess.PIPE, **more):
    command = [sys.executable, "-m", "missionplan", *words]
    return subprocess.run(command, stdout=stdout, stderr=subprocess.PIPE, check=False, **more)


def simulate(folder, *more):
    mission = folder.parent / "small.yaml"
    mission.write_text(SMALL, encoding="utf-8")
    return ["simulate", str(mission), "--trials", "20", "--jobs", "1", "--no-assumptions", "--out", str(folder), *more]


@pytest.mark.parametrize(
    "encoding", ["ascii", *(pytest.param(each, marks=pytest.mark.slow) for each in ("latin-1", "cp1252"))]
)
def test_every_encoding_can_be_printed(tmp_path, encoding):
    """A table, and a summary as JSON, one after the other in one process."""
    environment = {**os.environ, "PYTHONIOENCODING": encoding, "PYTHONUTF8": "0"}
    command = [sys.executable, "-c", TWO_RUNS, *simulate(tmp_path / "out")[:-2]]
    printed = subprocess.run(command, capture_output=True, env=environment, cwd=tmp_path, check=False)
    assert b"Traceback" not in printed.stderr
    table, first, summary, second, _ = re.split(r"\nstatus (\d)", printed.stdout.decode(encoding))
    assert "min" in table
    assert json.loads(summary)["trials"] == 20
    assert {first, second} <= {"0", "3"}


@NEEDS_FULL
@pytest.mark.parametrize("more", [(), pytest.param(("--json",), marks=pytest.mark.slow)])
def test_a_full_output_is_said_after_the_report_is_saved(tmp_path, more):
    with Path("/dev/full").open("wb") as full:
        done = run(simulate(tmp_path / "out", *more), stdout=full)
    assert done.returncode == 1
    assert b"cannot write to standard output" in done.stderr
    assert b"Traceback" not in done.stderr
    assert b"the report is saved in" in done.stderr
    assert (tmp_path / "out" / "report.html").is_file()


@NEEDS_FULL
@pytest.mark.parametrize("words", [["effects"], ["--help"], ["validate", str(MISSION)], ["--version"]])
def test_other_commands_say_it_too(words):
    with Path("/dev/full").open("wb") as full:
        done = run(words, stdout=full)
    assert (done.returncode, b"Traceback" in done.stderr) == (1, False)


@pytest.mark.parametrize("more", [pytest.param((), marks=pytest.mark.slow), ("--json",)])
def test_a_reader_that_has_gone_away_is_no_error(tmp_path, more):
    reading, writing = os.pipe()
    os.close(reading)
    done = run(simulate(tmp_path / "out", *more), stdout=writing)
    os.close(writing)
    assert (done.returncode in (0, 3), b"Traceback" in done.stderr, b"Error" in done.stderr) == (True, False, False)


def test_closed_streams_are_no_error(tmp_path):
    words = " ".join(simulate(tmp_path / "out"))
    done = subprocess.run(["sh", "-c", f"{sys.executable} -m missionplan {words} >&- 2>&-"], check=False)
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
