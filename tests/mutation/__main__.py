"""``python -m tests.mutation``: plant faults at the edges of the package, and see whether the nearest tests notice.

Faults are drawn by a seed from the modules at the edges, or from those that `--modules` names. Each is planted in a copy
of the tree and judged by the tests of `judges`. Ends with the score, and with 1 if it is below the bound.
"""

import argparse
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from queue import SimpleQueue
from random import Random

from .faults import Fault, faults, planted
from .judges import EDGES, judges

ROOT = Path(__file__).parents[2]
BOUND = 0.85
"""Share of faults that the nearest tests have to notice."""
LONGEST = 300
"""Processor time of one process for one fault [s]: how busy the machine is does not count."""
STANDSTILL = 3600.0
"""After which a process that waits for ever is ended [s]."""


def main(words: Sequence[str] | None = None) -> int:
    """Run; return 0 if the score reaches the bound."""
    parser = argparse.ArgumentParser(prog="python -m tests.mutation", description=__doc__)
    parser.add_argument("--modules", nargs="*", default=list(EDGES), help="folders and files below missionplan/")
    parser.add_argument("--count", type=int, default=120)
    parser.add_argument("--seed", type=int, default=int(time.time()))
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--bound", type=float, default=BOUND)
    options = parser.parse_args(words)
    print(f"seed {options.seed}")
    drawn_faults = drawn(options.modules, options.count, Random(options.seed))
    with tempfile.TemporaryDirectory(prefix="missionplan-mutation-") as scratch:
        copies: SimpleQueue[Path] = SimpleQueue()
        for number in range(options.jobs):
            copies.put(_copy(Path(scratch) / str(number)))

        def judged(fault: tuple[str, Fault]) -> str:
            place = copies.get()
            try:
                verdict = judge(place, *fault)
            finally:
                copies.put(place)
            print(f"{verdict:<9} {fault[0]}:{fault[1]}", flush=True)
            return verdict

        with ThreadPoolExecutor(options.jobs) as pool:
            found = Counter(pool.map(judged, drawn_faults))
    decided = found["killed"] + found["survived"]
    score = found["killed"] / decided if decided else 0.0
    print(
        f"{found['killed']} of {decided} noticed ({score:.0%}; at least {options.bound:.0%}), {found['undecided']} undecided"
    )
    return 0 if score >= options.bound else 1


def drawn(modules: Sequence[str], count: int, random: Random) -> list[tuple[str, Fault]]:
    """Draw modules at random and a fault in each, so that long modules do not take all."""
    package = ROOT / "missionplan"
    paths = sorted(
        path
        for name in modules
        for path in ([package / name] if name.endswith(".py") else (package / name).rglob("*.py"))
    )
    choices: dict[Path, list[Fault]] = {}
    found: list[tuple[str, Fault]] = []
    while paths and len(found) < count:
        path = random.choice(paths)
        if path not in choices:
            choices[path] = faults(path.read_text(encoding="utf-8"))
        if left := choices[path]:
            fault = left.pop(random.randrange(len(left)))
            found.append((path.relative_to(package).as_posix(), fault))
        else:
            paths.remove(path)
    return found


def judge(place: Path, module: str, fault: Fault) -> str:
    """Plant a fault in a copy of the tree: killed, survived, or undecided where no test is near or time runs out."""
    tests = judges(module, place / "tests")
    if not tests:
        return "undecided"
    path = place / "missionplan" / module
    kept = path.read_text(encoding="utf-8")
    path.write_text(planted(kept, fault), encoding="utf-8")
    compiled = {"PYTHONPYCACHEPREFIX": str(place / "compiled"), "PYTHONDONTWRITEBYTECODE": ""}
    words = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", *(f"tests/{each}" for each in tests)]
    try:
        ended = subprocess.run(
            ["sh", "-c", f'ulimit -t {LONGEST} && exec "$@"', "sh", *words],
            cwd=place,
            env={**os.environ, "PYTHONPATH": str(place), **compiled},
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            timeout=STANDSTILL,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return "undecided"
    finally:
        path.write_text(kept, encoding="utf-8")
    if -ended.returncode in (signal.SIGXCPU, signal.SIGKILL):
        return "undecided"
    return "survived" if ended.returncode == 0 else "killed"


def _copy(place: Path) -> Path:
    """Copy the tracked files, with what is shared beside them."""
    names = subprocess.run(
        ["git", "ls-files", "-z", "-co", "--exclude-standard"], cwd=ROOT, check=True, capture_output=True
    )
    tree = place / "missionplan"
    for name in filter(None, names.stdout.decode().split("\0")):
        if (ROOT / name).is_file():
            (tree / name).parent.mkdir(parents=True, exist_ok=True)
            (tree / name).write_bytes((ROOT / name).read_bytes())
    if (ROOT.parent / "shared").is_dir():
        (place / "shared").symlink_to(ROOT.parent / "shared")
    return tree


if __name__ == "__main__":
    sys.exit(main())
