"""A Dask cluster is used, and neither believed without proof nor waited for in vain."""

import logging
import os
import shutil
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace

import pytest

import missionplan
from missionplan.errors import InputError, RunError
from missionplan.montecarlo import dask_cluster
from missionplan.montecarlo.blocks import Workers

pytest.importorskip("distributed")
pytestmark = pytest.mark.filterwarnings("ignore")  # of Dask's own making
PACKAGE = Path(missionplan.__file__).parent

Start = Callable[..., subprocess.Popen[str]]


@pytest.fixture
def start(tmp_path: Path) -> Iterator[Start]:
    """Start Dask's commands; end them after the test."""
    running: list[subprocess.Popen[str]] = []

    def begin(*words: str, path: Path = PACKAGE.parent) -> subprocess.Popen[str]:
        command = [sys.executable, "-m", "distributed.cli.dask_" + words[0], *words[1:]]
        environment = {**os.environ, "PYTHONPATH": str(path)}
        log = (tmp_path / f"log-{len(running)}").open("w")
        process = subprocess.Popen(
            command, env=environment, cwd=tmp_path, stdout=log, stderr=log, text=True, start_new_session=True
        )
        running.append(process)
        return process

    yield begin
    for process in reversed(running):
        process.kill()
    for process in running:
        process.wait()


@pytest.fixture
def scheduler(start: Start) -> str:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    start("scheduler", "--host", "127.0.0.1", "--port", str(port), "--no-dashboard")
    while True:
        with socket.socket() as probe:
            if probe.connect_ex(("127.0.0.1", port)) == 0:
                return f"tcp://127.0.0.1:{port}"
        time.sleep(0.05)


def start_worker(start: Start, scheduler: str, path: Path = PACKAGE.parent) -> None:
    words = ("--nthreads", "1", "--no-dashboard", "--no-nanny", "--host", "127.0.0.1")
    start("worker", scheduler, *words, path=path)


def test_a_cluster_of_one_thread_gives_the_results_in_order(start: Start, scheduler: str) -> None:
    start_worker(start, scheduler)
    assert list(Workers(backend="dask", scheduler=scheduler).run(abs, range(-6, 6))) == [*range(6, 0, -1), *range(6)]
    (session,) = Workers(backend="dask", scheduler=scheduler).run(os.getsid, [0])
    assert session != os.getsid(0)


def test_a_worker_with_other_code_is_named_and_not_believed(start: Start, scheduler: str, tmp_path: Path) -> None:
    shutil.copytree(PACKAGE, tmp_path / "other" / "missionplan")
    changed = tmp_path / "other" / "missionplan" / "physics" / "water.py"
    changed.write_text(changed.read_text() + "\nCHANGED = 1.0\n")
    start_worker(start, scheduler, tmp_path / "other")
    with pytest.raises(InputError, match=r"the worker tcp://127\.0\.0\.1:\d+ runs missionplan .* code "):
        list(Workers(backend="dask", scheduler=scheduler).run(abs, range(2)))


def test_a_worker_without_the_package_is_named(start: Start, scheduler: str, tmp_path: Path) -> None:
    (tmp_path / "without").mkdir()
    (tmp_path / "without" / "missionplan.py").write_text("raise ModuleNotFoundError('no module named missionplan')")
    start_worker(start, scheduler, tmp_path / "without")
    with pytest.raises(InputError, match=r"the worker tcp://127\.0\.0\.1:\d+ cannot run missionplan: .*no module"):
        list(Workers(backend="dask", scheduler=scheduler).run(abs, range(2)))


def test_a_scheduler_without_the_package_is_said(start: Start, tmp_path: Path) -> None:
    (tmp_path / "without").mkdir()
    (tmp_path / "without" / "missionplan.py").write_text("raise ModuleNotFoundError('no module named missionplan')")
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{free.getsockname()[1]}"
    words = ("scheduler", "--host", "127.0.0.1", "--port", address.rsplit(":")[-1], "--no-dashboard")
    start(*words, path=tmp_path / "without")
    start_worker(start, address)
    with pytest.raises(InputError, match=r"the Dask scheduler at .* cannot run missionplan: .*") as caught:
        list(Workers(backend="dask", scheduler=address).run(abs, range(2)))
    assert len(caught.value.problems) == 1


def test_a_scheduler_without_workers_is_said(scheduler: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("missionplan.montecarlo.dask_cluster.ANSWER_TIME", 1)
    with pytest.raises(InputError, match="has no workers"):
        list(Workers(backend="dask", scheduler=scheduler).run(abs, range(2)))


def test_another_service_at_the_address_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("missionplan.montecarlo.dask_cluster.ANSWER_TIME", 2)
    with socket.create_server(("127.0.0.1", 0)) as server:

        def answer() -> None:
            while True:
                try:
                    connection, _ = server.accept()
                except OSError:
                    return
                with connection:
                    connection.sendall(b"HTTP/1.1 400 Bad Request\r\nContent-Length: 0\r\n\r\n")

        threading.Thread(target=answer, daemon=True).start()
        address = f"tcp://127.0.0.1:{server.getsockname()[1]}"
        with pytest.raises(InputError, match=f"no Dask scheduler answers at {address}"):
            list(Workers(backend="dask", scheduler=address).run(abs, range(2)))
        server.shutdown(socket.SHUT_RDWR)
    # A client left half-made would be closed by the garbage collector amid the start of the next, and block it.
    assert not [thread for thread in threading.enumerate() if thread.name == "IO loop"]


def test_a_scheduler_that_is_lost_ends_the_run(start: Start, tmp_path: Path) -> None:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{free.getsockname()[1]}"
    process = start("scheduler", "--host", "127.0.0.1", "--port", address.rsplit(":")[-1], "--no-dashboard")
    start_worker(start, address)
    results = Workers(backend="dask", scheduler=address).run(time.sleep, [0.1] * 10_000)
    assert next(results) is None
    process.kill()
    with pytest.raises(RunError, match=r"no longer answers|no workers"):
        list(results)


def test_a_client_that_reconnects_in_vain_logs_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """Importing distributed sets the levels of its loggers: they are silenced after it."""
    log = logging.getLogger("distributed.client")

    def imported(name: str) -> SimpleNamespace:
        log.setLevel(logging.WARNING)
        return SimpleNamespace(Client=lambda *_, **__: SimpleNamespace(close=lambda: None))

    monkeypatch.setattr(dask_cluster, "import_module", imported)
    with dask_cluster._connected(1, "tcp://nowhere"):
        assert not log.isEnabledFor(logging.ERROR)
    assert log.isEnabledFor(logging.ERROR)
