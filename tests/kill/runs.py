"""Simulations ended by a signal and resumed, resumed by other code, and started together: nothing is lost or mixed."""

import contextlib
import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import time
import uuid
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from random import Random

import missionplan

PACKAGE = Path(missionplan.__file__).parent
MISSION = Path(__file__).parents[2] / "missions" / "chesapeake.yaml"
TRIALS = "24000"
SIGNALS = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT)
PATIENCE = 30.0
"""Time in which all processes of a killed run must have ended [s]; on a busy machine they start late."""
_VOLATILE = ("elapsed_s", "created_utc", "options")
_MARK = "MISSIONPLAN_KILL"


@dataclass(frozen=True)
class Kill:
    """What is killed, how, and when: after a share of the time that an undisturbed run takes."""

    backend: str
    jobs: int
    signal: signal.Signals
    share: float


def draw(random: Random, backends: tuple[str, ...] = ("alone", "alone", "workers", "workers", "dask")) -> Kill:
    """Draw a kill; a fifth of them fall into the writing of the report, which comes last."""
    backend = random.choice(backends)
    share = random.uniform(0.85, 1.0) if random.random() < 0.2 else random.uniform(0.05, 1.0)
    return Kill(backend, 1 if backend == "alone" else 3, random.choice(SIGNALS), share)


def undisturbed(folder: Path) -> tuple[dict[str, object], float]:
    """Run once without a signal: its files, and how long it took [s]."""
    start = time.monotonic()
    _finish(_start(folder, Kill("alone", 1, signal.SIGINT, 0.0), ()), (0, 3))
    return files_of(folder), time.monotonic() - start


def killed_and_resumed(folder: Path, kill: Kill, duration: float) -> list[str]:
    """Kill a run and resume it; return what was wrong besides its files."""
    problems = []
    with _cluster(kill) as (more, workers):
        mark = uuid.uuid4().hex
        run = _start(folder, kill, more, mark)
        time.sleep(kill.share * duration)
        victim = workers[0] if workers else run
        victim.send_signal(kill.signal)
        _, words = run.communicate(timeout=600)
        if b"Traceback" in words:
            problems.append(f"a traceback: {words.decode()[-300:]}")
        allowed = (0, 3, 130, -kill.signal) if not workers else (0, 1, 3)
        if run.returncode not in allowed:
            problems.append(f"exit status {run.returncode}: {words.decode()[-300:]}")
        if left := _left(mark):
            problems.append(f"left behind: {left}")
    resumed = _start(folder, Kill("alone", 1, signal.SIGINT, 0.0), ("--resume",))
    _, words = resumed.communicate(timeout=600)
    if resumed.returncode not in (0, 3):
        problems.append(f"resumed with exit status {resumed.returncode}: {words.decode()[-300:]}")
    strays = [path.name for path in folder.parent.iterdir() if path.name.startswith(f".{folder.name}.")]
    return [*problems, *(f"half written: {name}" for name in strays)]


def resumed_by_other_code(folder: Path, share: float, duration: float) -> list[str]:
    """Kill a run, resume it by a copy of the package with another gravity, then by itself; return what was wrong."""
    copy = folder.parent / "other" / "missionplan"
    shutil.copytree(PACKAGE, copy, ignore=shutil.ignore_patterns("__pycache__"))
    gravity = copy / "physics" / "buoyancy.py"
    gravity.write_text(gravity.read_text().replace("9.80665", "9.9"))
    alone = Kill("alone", 1, signal.SIGKILL, share)
    run = _start(folder, alone, ())
    time.sleep(share * duration)
    run.kill()
    run.communicate(timeout=600)
    before = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    if not any("block-" in path.name for path in before):
        return ["no block was finished before the run was killed"]
    _, words = (refused := _start(folder, alone, ("--resume",), path=copy.parent)).communicate(timeout=600)
    problems = []
    if refused.returncode != 2 or b"code of missionplan: was " not in words:
        problems.append(f"exit status {refused.returncode} of other code: {words.decode()[-300:]}")
    if {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()} != before:
        problems.append("the refused run changed files")
    _finish(_start(folder, alone, ("--resume",)), (0, 3))
    return problems


def started_together(work: Path, count: int, *, shared: bool) -> list[str]:
    """Start simulations at once, each to its default folder or all to one; return what was wrong."""
    out = ("--out", "out") if shared else ()
    words = ("simulate", str(MISSION), "--trials", "50", "--jobs", "1", "--quiet", *out)
    command, work_dir = [sys.executable, "-m", "missionplan", *words], str(work)
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.PIPE}
    environment = {**os.environ, "PYTHONPATH": str(PACKAGE.parent)}
    runs = [subprocess.Popen(command, cwd=work_dir, env=environment, **quiet) for _ in range(count)]
    ends = [(run.communicate(timeout=900)[1].decode(), run.returncode) for run in runs]
    problems = [f"a traceback: {said[-300:]}" for said, _ in ends if "Traceback" in said]
    done = [said for said, status in ends if status in (0, 3)]
    if len(done) != (1 if shared else count):
        problems.append(f"{len(done)} of {count} runs came to their end: {[status for _, status in ends]}")
    refused = [said for said, status in ends if status == 2]
    problems += [
        f"refused otherwise: {said}" for said in refused if "another run" not in said and "not empty" not in said
    ]
    folders = [work / "out"] if shared else list((work / "reports" / MISSION.stem).iterdir())
    answers = [files_of(folder)["summary.json"] for folder in folders if (folder / "report.html").is_file()]
    if len(answers) != len(done) or any(answer != answers[0] for answer in answers):
        problems.append(f"{len(answers)} reports of {len(done)} runs, or unlike ones")
    left = {path.name for path in (work if shared else work / "reports" / MISSION.stem).iterdir()}
    return [*problems, *(f"left: {name}" for name in left if name.startswith("."))]


def files_of(folder: Path) -> dict[str, object]:
    """Return the files of a report but what tells the time: bytes, and the summary without its volatile keys."""
    found: dict[str, object] = {}
    for path in sorted(folder.rglob("*")):
        if path.is_file() and path.name != "report.html" and path.parent.name != "blocks":
            found[str(path.relative_to(folder))] = path.read_bytes()
    summary = json.loads(bytes(found["summary.json"]))
    return {**found, "summary.json": {key: value for key, value in summary.items() if key not in _VOLATILE}}


def _start(
    folder: Path, kill: Kill, more: tuple[str, ...], mark: str = "", path: Path = PACKAGE.parent
) -> subprocess.Popen[bytes]:
    words = ["simulate", str(MISSION), "--trials", TRIALS, "--jobs", str(kill.jobs), "--quiet", "--out", str(folder)]
    command = [sys.executable, "-m", "missionplan", *words, *more]
    folder.parent.mkdir(parents=True, exist_ok=True)

    def heed_signals() -> None:
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            signal.signal(number, signal.SIG_DFL)

    return subprocess.Popen(
        command,
        cwd=folder.parent,  # `-m` finds a package there before that of PYTHONPATH
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        env={**os.environ, _MARK: mark, "PYTHONPATH": str(path)},
        preexec_fn=heed_signals,
        start_new_session=True,
    )


def _finish(run: subprocess.Popen[bytes], statuses: tuple[int, ...]) -> None:
    _, words = run.communicate(timeout=600)
    if run.returncode not in statuses:
        raise RuntimeError(f"exit status {run.returncode}: {words.decode()}")


def _left(mark: str) -> list[str]:
    """Processes of a run that are still there after a while."""
    deadline, left = time.monotonic() + PATIENCE, ["?"]
    while left and time.monotonic() < deadline:
        time.sleep(0.2)
        left = []
        for process in Path("/proc").glob("[0-9]*"):
            with contextlib.suppress(OSError):
                if f"{_MARK}={mark}".encode() in (process / "environ").read_bytes():
                    left.append((process / "cmdline").read_bytes().replace(b"\0", b" ").decode()[:80])
    return left


@contextlib.contextmanager
def _cluster(kill: Kill) -> Iterator[tuple[tuple[str, ...], list[subprocess.Popen[bytes]]]]:
    """Start a Dask scheduler and two workers, where they are wanted."""
    if kill.backend != "dask":
        yield (), []
        return
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{free.getsockname()[1]}"
    dask = [sys.executable, "-m", "distributed.cli.dask_"]
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    scheduler = [
        *dask[:2],
        f"{dask[2]}scheduler",
        "--host",
        "127.0.0.1",
        "--port",
        address.rsplit(":")[-1],
        "--no-dashboard",
    ]
    worker = [
        *dask[:2],
        f"{dask[2]}worker",
        address,
        "--nthreads",
        "1",
        "--no-dashboard",
        "--no-nanny",
        "--host",
        "127.0.0.1",
    ]
    running = [subprocess.Popen(scheduler, **quiet)]
    try:
        while True:
            with socket.socket() as probe:
                if probe.connect_ex(("127.0.0.1", int(address.rsplit(":")[-1]))) == 0:
                    break
            time.sleep(0.1)
        running += [subprocess.Popen(worker, **quiet) for _ in range(2)]
        yield ("--backend", "dask", "--scheduler", address), running[1:]
    finally:
        for process in reversed(running):
            process.kill()
        for process in running:
            process.wait()
