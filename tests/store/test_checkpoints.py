import hashlib
import json
import os
import signal
import zipfile
from dataclasses import replace

import numpy as np
import pytest

from missionplan.errors import InputError, RunError
from missionplan.identity import Identity
from missionplan.store.checkpoints import Checkpoints, kept_or_run

MISSION = {"name": "a", "speed": "1.5 m/s"}
IDENTITY = Identity.of({"mission": MISSION}, {"command": "simulate"}, 1)
ARRAYS = {"mean": np.array([0.1, np.nan, -np.inf]), "count": np.array([3], dtype=np.int64), "empty": np.empty((2, 0))}


def test_a_block_comes_back_bit_for_bit(tmp_path):
    Checkpoints(tmp_path / "run", IDENTITY).write(3, 4096, ARRAYS)
    again = Checkpoints(tmp_path / "run", IDENTITY, resume=True)
    assert again.holds(3, 4096)
    found = again.read(3, 4096)
    assert list(found) == list(ARRAYS)
    for name, values in ARRAYS.items():
        assert found[name].dtype == values.dtype
        assert found[name].tobytes() == values.tobytes()


def test_a_block_cut_short_is_not_the_whole_block(tmp_path):
    store = Checkpoints(tmp_path, IDENTITY)
    store.write(3, 1000, ARRAYS)
    assert not store.holds(3, 4096)
    assert store.read(3, 4096) is None


def test_ctrl_c_while_a_block_is_written_stays_ctrl_c(tmp_path, monkeypatch):
    """Half-way into a member of the archive it became the ValueError of an archive that cannot be closed."""
    opened = zipfile.ZipFile.open

    def interrupted(self, name, mode="r", **options):
        member = opened(self, name, mode, **options)
        if mode == "w":
            signal.raise_signal(signal.SIGINT)
        return member

    store = Checkpoints(tmp_path, IDENTITY)
    monkeypatch.setattr(zipfile.ZipFile, "open", interrupted)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # ignored where tests run in the background
    try:
        with pytest.raises(KeyboardInterrupt):
            store.write(3, 4096, ARRAYS)
    finally:
        signal.signal(signal.SIGINT, before)
    monkeypatch.undo()
    assert store.holds(3, 4096)


def test_a_folder_in_use_is_not_taken_unasked(tmp_path):
    Checkpoints(tmp_path, IDENTITY)
    with pytest.raises(InputError, match="resume=True"):
        Checkpoints(tmp_path, IDENTITY)


@pytest.mark.parametrize(
    ("changed", "shown"),
    [
        (Identity.of({"mission": {**MISSION, "speed": "1.6 m/s"}}, IDENTITY.options, 1), "mission.speed: was 1.5 m/s"),
        (replace(IDENTITY, seed=2), "seed: was 1, now 2"),
        (replace(IDENTITY, program=replace(IDENTITY.program, code="0" * 64)), "code of missionplan: was "),
    ],
)
def test_another_run_is_refused_with_the_difference(tmp_path, changed, shown):
    Checkpoints(tmp_path, IDENTITY).write(0, 10, ARRAYS)
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    with pytest.raises(InputError) as caught:
        Checkpoints(tmp_path, changed, resume=True)
    (line,) = str(caught.value).splitlines()[1:]
    assert line.strip().startswith(shown)
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_a_block_of_another_run_is_not_read(tmp_path):
    Checkpoints(tmp_path / "a", IDENTITY).write(0, 10, ARRAYS)
    other = Checkpoints(tmp_path / "b", Identity.of({}, {}, 1))
    (tmp_path / "a" / "block-0000000-10.npz").rename(tmp_path / "b" / "block-0000000-10.npz")
    assert not other.holds(0, 10)
    assert other.read(0, 10) is None


@pytest.mark.parametrize("kept", [0, 1, 100, -1, -30])
def test_a_damaged_block_counts_as_missing(tmp_path, kept):
    store = Checkpoints(tmp_path, IDENTITY)
    store.write(0, 10, ARRAYS)
    (path,) = tmp_path.glob("block-*")
    path.write_bytes(path.read_bytes()[:kept])
    assert store.read(0, 10) is None
    assert not store.holds(0, 10)


def test_a_flipped_bit_counts_as_missing(tmp_path):
    store = Checkpoints(tmp_path, IDENTITY)
    store.write(0, 1000, {"values": np.arange(1000.0)})
    (path,) = tmp_path.glob("block-*")
    content = bytearray(path.read_bytes())
    content[content.index(b"values.npy") + 200] ^= 1
    path.write_bytes(bytes(content))
    assert store.read(0, 1000) is None


some_or_all = pytest.mark.parametrize("step", [7, pytest.param(1, marks=pytest.mark.slow)], ids=["some", "all"])


@some_or_all
def test_any_flipped_byte_of_a_block_is_noticed(tmp_path, caplog, step):
    store = Checkpoints(tmp_path, IDENTITY)
    store.write(0, 10, ARRAYS)
    (path,) = tmp_path.glob("block-*")
    content = path.read_bytes()
    for place in range(0, len(content), step):
        path.write_bytes(content[:place] + bytes([content[place] ^ 1 << place % 8]) + content[place + 1 :])
        assert store.read(0, 10) is None
    assert store.intact([(0, 10), (1, 10)]) == set()
    assert "block-0000000-10.npz" in caplog.text
    assert "block-0000001-10.npz" not in caplog.text


@some_or_all
def test_any_flipped_byte_of_run_json_leaves_the_blocks_usable(tmp_path, caplog, step):
    Checkpoints(tmp_path, IDENTITY).write(0, 10, ARRAYS)
    content = (tmp_path / "run.json").read_bytes()
    for place in range(0, len(content), step):
        changed = bytes([content[place] ^ 1 << place % 8])
        (tmp_path / "run.json").write_bytes(content[:place] + changed + content[place + 1 :])
        caplog.clear()
        assert Checkpoints(tmp_path, IDENTITY, resume=True).intact([(0, 10)]) == {(0, 10)}
        assert ("run.json is damaged" in caplog.text) or (changed + content[place : place + 1]).isspace()
    assert (tmp_path / "run.json").read_bytes() == content


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"\xff",
        b"[" * 100_000 + b"]" * 100_000,
        b'{"mission": ' * 100_000,
        b"[]",
        b"null",
        b'{"mission": 1, "options": 2, "version": 3, "sha256": 4}',
        b'{"mission": [], "options": {}, "version": null, "sha256": ""}',
    ],
)
@pytest.mark.parametrize("blocks", [0, 1])
def test_a_run_json_of_any_content_is_refused_or_passed_over(tmp_path, content, blocks):
    store = Checkpoints(tmp_path, IDENTITY)
    for block in range(blocks):
        store.write(block, 10, ARRAYS)
    (tmp_path / "run.json").write_bytes(content)
    if blocks:
        assert Checkpoints(tmp_path, IDENTITY, resume=True).intact([(0, 10)]) == {(0, 10)}
    else:
        with pytest.raises(InputError, match=r"run\.json"):
            Checkpoints(tmp_path, IDENTITY, resume=True)


def test_a_block_under_another_blocks_name_is_not_read(tmp_path):
    store = Checkpoints(tmp_path, IDENTITY)
    store.write(0, 10, ARRAYS)
    content = (tmp_path / "block-0000000-10.npz").read_bytes()
    (tmp_path / "block-0000001-10.npz").write_bytes(content)
    (tmp_path / "block-0000000-11.npz").write_bytes(content)
    assert store.intact([(0, 10), (1, 10), (0, 11)]) == {(0, 10)}


def test_blocks_being_a_file_is_said(tmp_path):
    (tmp_path / "blocks").write_text("precious")
    with pytest.raises(InputError, match="is a file"):
        Checkpoints(tmp_path / "blocks", IDENTITY, resume=True)


def test_a_folder_in_a_blocks_place_is_no_block(tmp_path):
    store = Checkpoints(tmp_path, IDENTITY)
    (tmp_path / "block-0000000-10.npz").mkdir()
    assert store.intact([(0, 10)]) == set()
    with pytest.raises(RunError, match="cannot write"):
        store.write(0, 10, ARRAYS)


def test_no_pickle_is_ever_read(tmp_path):
    store = Checkpoints(tmp_path, IDENTITY)
    label = {"digest": np.array(IDENTITY.digest), "block": np.array([0, 10])}
    np.savez(path := tmp_path / "block-0000000-10.npz", **label, evil=np.array([{}], dtype=object))
    path.write_bytes(path.read_bytes() + hashlib.sha256(path.read_bytes()).digest())
    assert store.read(0, 10) is None


def test_what_a_killed_write_left_is_swept(tmp_path):
    Checkpoints(tmp_path, IDENTITY)
    stray = tmp_path / ".block-0000000-10.npz.x1"
    stray.write_bytes(b"half")
    Checkpoints(tmp_path, IDENTITY, resume=True)
    assert not stray.exists()


def test_a_vanished_folder_is_said(tmp_path):
    store = Checkpoints(tmp_path / "run", IDENTITY)
    (tmp_path / "run" / "run.json").unlink()
    (tmp_path / "run").rmdir()
    with pytest.raises(RunError, match="no longer exists"):
        store.write(0, 10, ARRAYS)


def test_a_full_disk_is_said_and_leaves_no_half_block(tmp_path, monkeypatch):
    store = Checkpoints(tmp_path, IDENTITY)

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("pathlib.Path.replace", full)
    with pytest.raises(RunError, match="No space left on device"):
        store.write(0, 10, ARRAYS)
    assert [path.name for path in tmp_path.iterdir()] == ["run.json"]


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_a_read_only_folder_is_said(tmp_path):
    tmp_path.chmod(0o500)
    with pytest.raises(RunError, match="Permission denied"):
        Checkpoints(tmp_path, IDENTITY)


def test_a_path_that_cannot_be_a_folder_is_said(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(RunError, match="file"):
        Checkpoints(tmp_path / "file" / "run", IDENTITY)


def test_a_run_json_of_something_else_is_refused(tmp_path):
    (tmp_path / "run.json").write_text(json.dumps({"hello": 1}))
    with pytest.raises(InputError, match=r"run\.json"):
        Checkpoints(tmp_path, IDENTITY, resume=True)


def test_the_trials_done_are_told_before_and_after_each_block_kept_or_not(tmp_path):
    told, ran, items = [], [], [(0, 100), (1, 50)]

    def run(asked):
        for block, size in asked:
            ran.append((block, size))
            yield float(10 * block)

    for _ in range(2):
        store = Checkpoints(tmp_path, IDENTITY, resume=True)
        form = (lambda block: {"value": np.array(block)}), (lambda arrays: float(arrays["value"]))
        blocks = kept_or_run(items, run, store, lambda item: item, form, lambda *done: told.append(done))
        assert list(blocks) == [((0, 100), 0.0), ((1, 50), 10.0)]
        assert ran == items
    assert told == 2 * [(0, 150), (100, 150), (150, 150)]
