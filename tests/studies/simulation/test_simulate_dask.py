"""A Dask scheduler and two worker processes on loopback, for real."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from simulate_missions import chesapeake, chesapeake_data

from missionplan.errors import InputError
from missionplan.montecarlo.streams import BLOCK
from missionplan.studies.simulation.simulate import simulate

pytest.importorskip("distributed")
DATA = chesapeake_data()
QUICK = {"phases": DATA["phases"][:1], "requirements": DATA["requirements"][:1]}  # the way in alone: cheap blocks
QUIET = {**os.environ, "PYTHONWARNINGS": "ignore", "OMP_NUM_THREADS": "1"}


class Cluster:
    def __init__(self, folder):
        self._address = folder / "scheduler.json"
        self._folder, self._processes = folder, []
        self._start("scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard")
        self.workers = [self.start_worker() for _ in range(2)]

    def _start(self, *command):
        log = (self._folder / f"{len(self._processes)}.log").open("wb")
        with log:
            process = subprocess.Popen(
                [sys.executable, "-m", "dask", *command, "--scheduler-file", str(self._address)],
                stdout=log,
                stderr=log,
                env=QUIET,
                cwd=self._folder,
                start_new_session=True,
            )
        self._processes.append(process)
        return process

    def start_worker(self):
        return self._start("worker", "--nthreads", "1", "--no-dashboard", "--no-nanny", "--host", "127.0.0.1")

    @property
    def scheduler(self):
        deadline = time.monotonic() + 60.0
        while time.monotonic() < deadline:
            try:
                return json.loads(self._address.read_text())["address"]
            except (OSError, ValueError):
                time.sleep(0.05)
        logs = "\n".join(path.read_text() for path in self._folder.glob("*.log"))
        raise TimeoutError(f"no scheduler:\n{logs}")

    def wait_for_workers(self, count):
        from distributed import Client

        with Client(self.scheduler, timeout="30s") as client:
            client.wait_for_workers(count, timeout=60)

    def stop(self):
        for process in self._processes:
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    running = Cluster(tmp_path_factory.mktemp("cluster"))
    try:
        running.wait_for_workers(2)
        yield running
    finally:
        running.stop()


def bits(outcome):
    summary = outcome.summary()
    return json.dumps([summary[key] for key in ("phases", "total", "attrition", "sensitivities", "trials")])


@pytest.fixture(scope="module")
def mission(tmp_path_factory):
    folder = tmp_path_factory.mktemp("mission")
    rows = ["t_s,depth_m,east_m_s,north_m_s", *(f"{t},{d},{0.2 - d / 200},0.05" for t in (0, 90000) for d in (0, 12))]
    (folder / "current.csv").write_text("\n".join(rows) + "\n")
    return chesapeake(folder, {**QUICK, "site.current": {"file": "current.csv"}})


def test_a_cluster_gives_the_bits_of_one_process(cluster, mission):
    here = simulate(mission, trials=2 * BLOCK + 100, sheet=False)
    there = simulate(mission, trials=2 * BLOCK + 100, backend="dask", scheduler=cluster.scheduler, sheet=False)
    assert bits(there) == bits(here)


def test_a_worker_killed_in_mid_run_costs_no_results(cluster, mission):
    trials = 4 * BLOCK
    killed = []

    def kill_one(done, total):
        if 0 < done < total and not killed:
            victim = cluster.workers[0]
            os.killpg(victim.pid, signal.SIGKILL)
            killed.append(victim.wait())

    there = simulate(
        mission, trials=trials, backend="dask", scheduler=cluster.scheduler, progress=kill_one, sheet=False
    )
    assert killed == [-signal.SIGKILL]
    assert bits(there) == bits(simulate(mission, trials=trials, sheet=False))


@pytest.mark.slow  # it waits ten seconds for an answer
def test_no_scheduler_is_one_message(mission):
    with pytest.raises(InputError, match="no Dask scheduler answers"):
        simulate(mission, trials=10, backend="dask", scheduler="tcp://127.0.0.1:9")


def test_the_result_says_how_it_ran(cluster, mission):
    found = simulate(mission, trials=10, backend="dask", scheduler=cluster.scheduler)
    assert found.provenance.options["backend"] == "dask"
    assert Path(found.provenance.file).name == "mission.yaml"
