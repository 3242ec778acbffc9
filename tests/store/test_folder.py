"""Report folders: what cannot be written is found before the run, and what killed reports left is removed."""

import os
import subprocess
import sys
import threading

import pytest

from missionplan.errors import InputError
from missionplan.store.folder import check_new_folder, new_folder

KILLED = """
import os, sys
from pathlib import Path
from missionplan.store.folder import new_folder
with new_folder(Path(sys.argv[1])) as temporary:
    (temporary / "report.html").write_text("half")
    os.kill(os.getpid(), 9)
"""


def test_what_a_killed_report_left_is_removed_by_the_next(tmp_path):
    folder = tmp_path / "out"
    subprocess.run([sys.executable, "-c", KILLED, str(folder)], check=False)
    assert [path.name[:5] for path in tmp_path.iterdir()] == [".out."]
    with new_folder(folder) as temporary:
        (temporary / "report.html").write_text("whole")
    assert [path.name for path in tmp_path.iterdir()] == ["out"]
    assert [path.name for path in folder.iterdir()] == ["report.html"]


def test_what_another_still_writes_is_left_alone(tmp_path):
    with new_folder(tmp_path / "out") as first:
        with new_folder(tmp_path / "out") as second:
            assert first.is_dir()
        assert not second.exists()


def test_a_link_to_an_empty_folder_is_used_and_stays(tmp_path):
    (tmp_path / "empty").mkdir()
    (tmp_path / "out").symlink_to(tmp_path / "empty")
    with new_folder(tmp_path / "out") as temporary:
        (temporary / "report.html").write_text("whole")
    assert (tmp_path / "out").is_symlink()
    assert (tmp_path / "empty" / "report.html").read_text() == "whole"


@pytest.mark.parametrize(
    ("make", "name", "words"),
    [
        (lambda place: (place / "out").symlink_to("nowhere"), "out", "is a link to nowhere, which does not exist"),
        (lambda place: None, "a" * 300, "name too long"),
        (lambda place: None, "a" * 245, "name too long"),
        (lambda place: None, "a\x1bb", "control character"),
        (lambda place: (place / "file").touch(), "file/out", "is a file; a folder was expected"),
        (lambda place: (place / "out" / "summary.json").mkdir(parents=True), "out", "could not be written"),
    ],
)
def test_what_cannot_be_written_is_found_before(tmp_path, make, name, words):
    make(tmp_path)
    with pytest.raises(InputError, match=words):
        check_new_folder(tmp_path / name, force=True)


def test_threads_may_write_side_by_side(tmp_path):
    def write(number):
        with new_folder(tmp_path / f"out-{number}") as temporary:
            (temporary / "report.html").write_text(str(number))

    threads = [threading.Thread(target=write, args=(number,)) for number in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sorted(os.listdir(tmp_path)) == [f"out-{number}" for number in range(4)]  # noqa: PTH208
