"""The answer on standard output of any encoding, full, or closed: a message at worst, and the report is kept."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from missionplan.cli.streams import remark

MISSION = Path(__file__).parents[2] / "missions" / "chesapeake.yaml"
NEEDS_FULL = pytest.mark.skipif(not Path("/dev/full").exists(), reason="this system has no /dev/full")


def run(words, *, stdout=subprocess.PIPE, encoding="utf-8"):
    environment = {**os.environ, "PYTHONIOENCODING": encoding, "PYTHONUTF8": "0"}
    command = [sys.executable, "-m", "missionplan", *words]
    return subprocess.run(command, stdout=stdout, stderr=subprocess.PIPE, env=environment, check=False)


def simulate(folder, *more):
    return ["simulate", str(MISSION), "--trials", "20", "--jobs", "1", "--out", str(folder), *more]


@pytest.mark.parametrize("encoding", ["ascii", "latin-1", "cp1252"])
def test_every_encoding_can_be_printed(tmp_path, encoding):
    printed = run(simulate(tmp_path / "table"), encoding=encoding)
    assert (printed.returncode in (0, 3), b"Traceback" in printed.stderr) == (True, False)
    assert "min" in printed.stdout.decode(encoding)
    summary = run(simulate(tmp_path / "json", "--json"), encoding=encoding)
    assert json.loads(summary.stdout.decode(encoding))["trials"] == 20


@NEEDS_FULL
@pytest.mark.parametrize("more", [(), ("--json",)])
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


@pytest.mark.parametrize("more", [(), ("--json",)])
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
@pytest.mark.parametrize("limit", [9, 13, 14])
def test_too_few_files_are_an_error_in_words(tmp_path, limit):
    command = [sys.executable, "-m", "missionplan", *simulate(tmp_path / "out")[:2], "--trials", "20000", "--jobs", "2"]
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
