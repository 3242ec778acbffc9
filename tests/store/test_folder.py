"""Report folders: what cannot be written is found before the run, and what killed reports left is removed."""

import os
import subprocess
import sys
import threading

import pytest

from missionplan.errors import InputError
from missionplan.store.folder import check_new_folder, claimed, is_claimed, new_folder, new_folder_name

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
    assert {path.name[:5] for path in tmp_path.iterdir()} == {".out."}
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


HELD = """
import sys, time
from pathlib import Path
from missionplan.store.folder import claimed
with claimed(Path(sys.argv[1])):
    (Path(sys.argv[1]) / "blocks").mkdir(parents=True)
    print("held", flush=True)
    time.sleep(600)
"""


def test_a_held_folder_is_refused_to_others_until_its_holder_ends_whatever_ends_it(tmp_path):
    folder = tmp_path / "out"
    with subprocess.Popen([sys.executable, "-c", HELD, str(folder)], stdout=subprocess.PIPE) as holder:
        assert holder.stdout.readline() == b"held\n"
        for force in (False, True):
            with pytest.raises(InputError, match=r"not empty|another run is writing"), claimed(folder, force=force):
                pass
        assert is_claimed(folder)
        assert (folder / "blocks").is_dir()
        holder.kill()
    assert not is_claimed(folder)
    with claimed(folder, force=True):
        assert is_claimed(folder)
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


def test_a_hold_without_a_result_leaves_nothing(tmp_path):
    with pytest.raises(ZeroDivisionError), claimed(tmp_path / "reports" / "mission" / "run"):
        raise ZeroDivisionError
    assert list(tmp_path.iterdir()) == []


def test_of_eight_that_write_to_one_folder_together_one_wins_and_the_others_change_nothing(tmp_path):
    ready, ends = threading.Barrier(8), []

    def write(number):
        ready.wait()
        try:
            with claimed(tmp_path / "reports" / "out"), new_folder(tmp_path / "reports" / "out") as temporary:
                (temporary / "report.html").write_text(str(number))
            ends.append(number)
        except InputError as error:
            ends.append(str(error))

    threads = [threading.Thread(target=write, args=(number,)) for number in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    (winner,) = (end for end in ends if isinstance(end, int))
    assert (tmp_path / "reports" / "out" / "report.html").read_text() == str(winner)
    assert all("another run is writing" in end or "not empty" in end for end in ends if isinstance(end, str))
    assert [path.name for path in (tmp_path / "reports").iterdir()] == ["out"]


def test_runs_that_start_together_get_folders_of_their_own(tmp_path):
    assert len({new_folder_name(tmp_path, "simulate") for _ in range(100)}) == 100
