import json
import os
import signal
import subprocess
import sys
import time
from dataclasses import replace

import numpy as np
import pytest
from simulate_missions import chesapeake, chesapeake_data

from missionplan.errors import InputError, RunError
from missionplan.montecarlo.statistics import Count, RunningStatistics
from missionplan.montecarlo.streams import BLOCK
from missionplan.results.failures import SUCCESS
from missionplan.scenario.scenario import Scenario
from missionplan.store.checkpoints import Checkpoints
from missionplan.studies.simulation import block_sequence as task
from missionplan.studies.simulation.block_sequence import Precision
from missionplan.studies.simulation.block_statistics import BlockStatistics
from missionplan.studies.simulation.simulate import simulate

pytestmark = pytest.mark.usefixtures("unplanned", "unheld")

TRIALS = 2 * BLOCK + 500
DATA = chesapeake_data()
QUICK = {"phases": DATA["phases"][:1], "requirements": DATA["requirements"][:1]}  # the way in alone: cheap blocks


def bits(outcome):
    """All results of a run, bit by bit, without when and how it ran."""
    summary = outcome.summary()
    for key in ("elapsed_s", "created_utc", "options", "file"):
        del summary[key]
    arrays = [outcome.tracks.position, *outcome.arrivals.values()]
    return json.dumps(summary), [array.tobytes() for array in arrays]


@pytest.fixture(scope="module")
def mission(tmp_path_factory):
    return chesapeake(tmp_path_factory.mktemp("mission"), QUICK)


@pytest.fixture(scope="module")
def whole_mission(tmp_path_factory):
    return chesapeake(tmp_path_factory.mktemp("mission"))


@pytest.fixture(scope="module")
def reference(mission):
    return bits(simulate(mission, trials=TRIALS, sheet=False))


@pytest.mark.parametrize(("jobs", "backend"), [(2, "loky"), (2, "threading")])
def test_bits_do_not_depend_on_jobs_or_backend(mission, reference, jobs, backend):
    assert bits(simulate(mission, trials=TRIALS, jobs=jobs, backend=backend, sheet=False)) == reference


def test_raising_the_trials_keeps_the_first_ones(mission):
    few, many = (simulate(mission, trials=n, sheet=False) for n in (300, 600))
    assert np.array_equal(few.tracks.position, many.tracks.position, equal_nan=True)
    for name, values in few.arrivals.items():
        assert np.array_equal(values, many.arrivals[name][:, :300])


def test_progress_counts_trials(mission):
    calls = []
    simulate(mission, trials=BLOCK + 10, progress=lambda *call: calls.append(call), sheet=False)
    assert calls == [(0, BLOCK + 10), (BLOCK, BLOCK + 10), (BLOCK + 10, BLOCK + 10)]


def test_a_precise_run_equals_the_run_of_that_many_trials(mission):
    stopped = simulate(mission, precision="total.duration=0.025%", sheet=False)
    error = stopped.total.quantities["duration_s"]
    assert error.standard_error < 0.00025 * error.mean
    assert stopped.provenance.trials in range(BLOCK, 9 * BLOCK, BLOCK)
    assert bits(stopped) == bits(simulate(mission, trials=stopped.provenance.trials, sheet=False))


@pytest.mark.parametrize(("share", "reached"), [(0.98, False), (1.02, True)])
def test_a_precision_is_reached_below_the_standard_error(share, reached):
    """Of a share of a half of n trials ½/√n; of a mean s/√n, or that over the mean."""
    values = 20.0 + np.random.default_rng(2).standard_normal(10_000)
    counts = {SUCCESS: Count(5000, 10_000)}
    totals = BlockStatistics(RunningStatistics.of({"moor.offset_m": values}), counts, {})
    error = share * values.std(ddof=1) / 100.0
    assert Precision("total.success", share * 0.005, False, True).is_reached(totals) is reached
    assert Precision("moor.offset_m", error, False, False).is_reached(totals) is reached
    assert Precision("moor.offset_m", error / values.mean(), True, False).is_reached(totals) is reached


def test_a_precision_that_is_not_reached_is_reported(whole_mission):
    found = simulate(whole_mission, trials=500, precision="moor.offset=0.1 mm", sheet=False)
    assert any("was not reached in 500 trials" in notice for notice in found.provenance.notices)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("0.5%", Precision("total.success", 0.005, relative=False, is_event=True)),
        ("success=0.002", Precision("total.success", 0.002, relative=False, is_event=True)),
        ("ingress.arrived = 1%", Precision("ingress.arrived", 0.01, relative=False, is_event=True)),
        ("total.duration=0.5%", Precision("total.duration_s", 0.005, relative=True, is_event=False)),
        ("moor.offset=5 cm", Precision("moor.offset_m", 0.05, relative=False, is_event=False)),
        ("total.energy=36 kJ", Precision("total.energy_wh", 10.0, relative=False, is_event=False)),
        ("ingress.surfacings=0.1", Precision("ingress.surfacings", 0.1, relative=False, is_event=False)),
    ],
)
def test_precisions_are_read(whole_mission, text, expected):
    found = Precision.parse(text, whole_mission)
    assert found == replace(expected, error=pytest.approx(expected.error))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("moor.offset=5", "unit"),
        ("moor.offset=5 s", "quantity in m"),
        ("mor.offset=5 m", "did you mean moor"),
        ("moor.ofset=1%", "did you mean offset"),
        ("half", "precision: given"),
        ("0%", "more than 0"),
    ],
)
def test_precisions_that_cannot_be_read(whole_mission, text, words):
    with pytest.raises(InputError, match=words):
        simulate(whole_mission, precision=text, sheet=False)


def test_finished_blocks_are_not_run_again(mission, reference, tmp_path, monkeypatch):
    folder = tmp_path / "run"
    simulate(mission, trials=BLOCK, checkpoint=folder, sheet=False)
    ran = []
    original = task.run_block

    def spying(scenario, seed, block, *rest):
        ran.append(block)
        return original(scenario, seed, block, *rest)

    monkeypatch.setattr(task, "run_block", spying)
    found = simulate(mission, trials=TRIALS, checkpoint=folder, resume=True, sheet=False)  # the trials have been raised
    assert ran == [1, 2]
    assert bits(found) == reference
    ran.clear()
    assert bits(simulate(mission, trials=TRIALS, checkpoint=folder, resume=True, sheet=False)) == reference
    assert ran == []


def test_rows_of_trials_are_resumed_too(mission, tmp_path):
    simulate(mission, trials=BLOCK, checkpoint=tmp_path, keep_trials=True, sheet=False)
    again = simulate(mission, trials=BLOCK + 100, checkpoint=tmp_path, keep_trials=True, resume=True, sheet=False)
    assert again.trials_table == simulate(mission, trials=BLOCK + 100, keep_trials=True, sheet=False).trials_table


def test_a_damaged_block_is_run_again(mission, tmp_path):
    first = simulate(mission, trials=BLOCK + 10, checkpoint=tmp_path, sheet=False)
    for path in tmp_path.glob("block-*"):
        content = bytearray(path.read_bytes())
        content[len(content) // 3] ^= 255
        path.write_bytes(bytes(content))
    assert bits(simulate(mission, trials=BLOCK + 10, checkpoint=tmp_path, resume=True, sheet=False)) == bits(first)


def failing_at(failed):
    """`run_block`, failing at one block."""
    original = task.run_block

    def run(scenario, seed, block, *rest):
        if block == failed:
            raise FloatingPointError("on purpose")
        return original(scenario, seed, block, *rest)

    return run


def test_a_failed_block_is_tried_again_on_resume(mission, tmp_path, monkeypatch):
    original = task.run_block
    monkeypatch.setattr(task, "run_block", failing_at(1))
    assert len(simulate(mission, trials=2 * BLOCK, checkpoint=tmp_path, sheet=False).failed_blocks) == 1
    monkeypatch.setattr(task, "run_block", original)
    found = simulate(mission, trials=2 * BLOCK, checkpoint=tmp_path, resume=True, sheet=False)
    assert bits(found) == bits(simulate(mission, trials=2 * BLOCK, sheet=False))


def test_the_tracks_are_those_of_the_first_block_that_did_not_fail(mission, monkeypatch):
    monkeypatch.setattr(task, "run_block", failing_at(0))
    found = simulate(mission, trials=BLOCK + 200, sheet=False)
    shown = task.BlockTask(Scenario.at_means(mission), mission.monte_carlo.seed).tracks(1, 200)
    assert found.tracks.position.shape[2] == 200
    assert np.array_equal(found.tracks.position, shown.position, equal_nan=True)


def test_a_changed_mission_is_refused_with_the_difference(mission, tmp_path):
    folder = tmp_path / "run"
    simulate(mission, trials=10, checkpoint=folder, sheet=False)
    changed = chesapeake(tmp_path, {**QUICK, "navigation.surfacing_time": "80 s"})
    with pytest.raises(InputError) as caught:
        simulate(changed, trials=10, checkpoint=folder, resume=True, sheet=False)
    assert "mission.navigation.surfacing_time: was 90 s, now 80 s" in str(caught.value)
    with pytest.raises(InputError, match="seed: was 1, now 2"):
        simulate(mission, trials=10, seed=2, checkpoint=folder, resume=True, sheet=False)
    with pytest.raises(InputError, match="resume=True"):
        simulate(mission, trials=10, checkpoint=folder, sheet=False)


def test_another_number_of_trials_in_the_file_is_no_change(tmp_path):
    simulate(chesapeake(tmp_path, QUICK), trials=10, checkpoint=tmp_path / "run", sheet=False)
    more = chesapeake(tmp_path, {**QUICK, "monte_carlo": {"trials": 20, "seed": 1}})
    assert simulate(more, checkpoint=tmp_path / "run", resume=True, sheet=False).provenance.trials == 20


def test_changed_data_of_the_current_are_a_change(tmp_path):
    rows = "t_s,depth_m,east_m_s,north_m_s\n0,0,{},0\n90000,0,0.1,0\n"
    (tmp_path / "current.csv").write_text(rows.format(0.1))
    mission = chesapeake(tmp_path, {**QUICK, "site.current": {"file": "current.csv"}})
    simulate(mission, trials=10, checkpoint=tmp_path / "run", sheet=False)
    (tmp_path / "current.csv").write_text(rows.format(0.2))
    with pytest.raises(InputError, match="SHA-256"):
        simulate(mission, trials=10, checkpoint=tmp_path / "run", resume=True, sheet=False)


def test_a_checkpoint_that_cannot_be_written_is_one_message(mission, tmp_path, monkeypatch):
    (tmp_path / "file").write_text("")
    with pytest.raises(RunError, match="cannot"):
        simulate(mission, trials=10, checkpoint=tmp_path / "file" / "run", sheet=False)
    folder = tmp_path / "run"

    def full(*_):
        raise OSError(28, "No space left on device")

    original = Checkpoints.write

    def filling(store, *block):
        monkeypatch.setattr("pathlib.Path.replace", full)
        original(store, *block)

    monkeypatch.setattr(Checkpoints, "write", filling)
    with pytest.raises(RunError, match="No space left on device"):
        simulate(mission, trials=10, checkpoint=folder, sheet=False)


RUN = """
import sys
from pathlib import Path
from missionplan.mission import load
from missionplan.results.failures import SUCCESS
from missionplan.scenario.scenario import Scenario
from missionplan.studies.simulation.simulate import simulate
if __name__ == "__main__":
    simulate(load(sys.argv[1]), trials=int(sys.argv[2]), checkpoint=Path(sys.argv[3]), resume=True)
"""


def test_a_killed_run_resumes_to_the_same_bits(mission, reference, tmp_path):
    folder = tmp_path / "run"
    script = tmp_path / "run.py"
    script.write_text(RUN)
    for blocks in (1, 2):  # killed twice, at two places
        command = [sys.executable, str(script), mission.file, str(TRIALS), str(folder)]
        process = subprocess.Popen(command, start_new_session=True)
        deadline = time.monotonic() + 60.0
        while len(list(folder.glob("block-*.npz"))) < blocks and time.monotonic() < deadline:
            time.sleep(0.002)
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        assert len(list(folder.glob("block-*.npz"))) >= blocks
    assert bits(simulate(mission, trials=TRIALS, checkpoint=folder, resume=True, sheet=False)) == reference
