"""A Dask cluster is used, and neither believed without proof nor waited for in vain."""

import logging
import os
import re
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


def package_that_fails(folder: Path) -> Path:
    (folder / "without").mkdir()
    (folder / "without" / "missionplan.py").write_text("raise ModuleNotFoundError('no module named missionplan')")
    return folder / "without"


def test_workers_that_are_not_there_have_other_code_or_no_package_are_said(
    start: Start, scheduler: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as patch:
        patch.setattr("missionplan.montecarlo.dask_cluster.ANSWER_TIME", 0.5)
        with pytest.raises(InputError, match="has no workers"):
            list(Workers(backend="dask", scheduler=scheduler).run(abs, range(2)))
    shutil.copytree(PACKAGE, tmp_path / "other" / "missionplan")
    changed = tmp_path / "other" / "missionplan" / "physics" / "water.py"
    changed.write_text(changed.read_text() + "\nCHANGED = 1.0\n")
    for path in (tmp_path / "other", package_that_fails(tmp_path)):
        start_worker(start, scheduler, path)
    with dask_cluster._connected(1, scheduler) as client:
        while len(client.nthreads()) < 2:
            time.sleep(0.05)
    with pytest.raises(InputError) as caught:
        list(Workers(backend="dask", scheduler=scheduler).run(abs, range(2)))
    told = sorted(problem.message.partition("missionplan")[2] for problem in caught.value.problems)
    assert len(told) == 2
    assert re.match(r" .* with other code \(code of missionplan: ", told[0])
    assert re.match(r": .*no module", told[1])
    assert len(set(re.findall(r"the worker (tcp://127\.0\.0\.1:\d+) (?:runs|cannot run) ", str(caught.value)))) == 2


def test_a_scheduler_without_the_package_is_said(start: Start, tmp_path: Path) -> None:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{free.getsockname()[1]}"
    words = ("scheduler", "--host", "127.0.0.1", "--port", address.rsplit(":")[-1], "--no-dashboard")
    start(*words, path=package_that_fails(tmp_path))
    start_worker(start, address)
    with pytest.raises(InputError, match=r"the Dask scheduler at .* cannot run missionplan: .*") as caught:
        list(Workers(backend="dask", scheduler=address).run(abs, range(2)))
    assert len(caught.value.problems) == 1


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


def test_a_cluster_of_one_thread_gives_the_results_in_order_until_it_is_lost(start: Start) -> None:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{free.getsockname()[1]}"
    process = start("scheduler", "--host", "127.0.0.1", "--port", address.rsplit(":")[-1], "--no-dashboard")
    start_worker(start, address)
    assert list(Workers(backend="dask", scheduler=address).run(abs, range(-6, 6))) == [*range(6, 0, -1), *range(6)]
    (session,) = Workers(backend="dask", scheduler=address).run(os.getsid, [0])
    assert session != os.getsid(0)
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
