"""What is done with a damaged case: each target draws a case into a folder, and does one thing with it."""

import json
import shutil
import signal
import sys
from collections.abc import Callable
from contextlib import chdir
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from random import Random
from tempfile import mkdtemp

import yaml

import missionplan
from missionplan.cli import main
from missionplan.errors import InputError
from missionplan.studies.validation.validate import validate

from . import examples, mutations

TRIALS = 20


@dataclass(frozen=True)
class Target:
    """Draws a case into a folder, and does one thing with a case.

    Attributes
    ----------
    draw : callable
        Writes the files of a case, from a random state.
    act : callable
        Does it, and returns the summary of the answer.
    limit : float
        CPU that it may take [s].
    """

    draw: Callable[[Path, Random], None]
    act: Callable[[Path], object]
    limit: float


def _draw_mission(folder: Path, random: Random) -> None:
    data = mutations.changed_tree(examples.mission(random.choice(examples.MISSIONS)), random)
    content = yaml.safe_dump(data, sort_keys=False).encode("utf-8", "surrogatepass")
    if random.random() < 0.2:
        content = mutations.changed_bytes(content, random)
    (folder / "mission.yaml").write_bytes(content)


def _draw_dataset(folder: Path, random: Random, kinds: tuple[str, ...] = tuple(examples.DATASETS)) -> None:
    kind = random.choice(kinds)
    name, keys = examples.DATASETS[kind]
    text, keys = examples.table(kind), dict(keys)
    changed = random.choice(("table", "table", "bytes", "keys"))
    content = mutations.changed_table(text, random) if changed == "table" else text.encode()
    if changed == "bytes":
        content = mutations.changed_bytes(content, random)
    examples.write_dataset(folder / "data", kind, keys, content)
    if changed == "keys":
        path = folder / "data" / "dataset.yaml"
        data = mutations.changed_tree(yaml.safe_load(path.read_text()), random)
        path.write_text(yaml.safe_dump(data, sort_keys=False), errors="surrogatepass")
    (folder / "mission.yaml").write_text(yaml.safe_dump(examples.mission(name), sort_keys=False))


def _draw_current(folder: Path, random: Random) -> None:
    data, text = examples.mission("chesapeake"), examples.table("current")
    data["site"]["current"] = {"file": "current.csv", "outside": random.choice(("error", "hold", "zero"))}
    as_table = random.random() < 0.7
    content = mutations.changed_table(text, random) if as_table else mutations.changed_bytes(text.encode(), random)
    (folder / "mission.yaml").write_text(yaml.safe_dump(data, sort_keys=False))
    (folder / "current.csv").write_bytes(content)


def _draw_tank(folder: Path, random: Random) -> None:
    _draw_dataset(folder, random, ("drag", "free-oscillation", "thruster", "propeller-transient"))


def _checked(path: Path) -> None:
    (found,) = validate([path])
    if found.problems:
        raise InputError(found.problems)


def _validate(folder: Path) -> None:
    _checked(folder / "mission.yaml")


def _simulate(folder: Path) -> object:
    return missionplan.simulate(missionplan.load(folder / "mission.yaml"), trials=TRIALS).summary()


def _read(folder: Path) -> None:
    _checked(folder / "data")


def _diagnose(folder: Path) -> object:
    mission = missionplan.load(folder / "mission.yaml")
    return missionplan.diagnose(mission, folder / "data", plan=False).summary()


def _identify(folder: Path) -> object:
    return missionplan.identify(folder / "data").summary()


@cache
def _finished_blocks() -> tuple[Path, dict]:
    folder = Path(mkdtemp(prefix="missionplan-fuzz-"))
    return folder, _resumed(folder / "blocks", resume=False)


def _resumed(blocks: Path, *, resume: bool) -> dict:
    mission = missionplan.Mission.from_data(examples.mission("chesapeake"))
    summary = missionplan.simulate(mission, trials=4106, checkpoint=blocks, resume=resume).summary()
    return {key: value for key, value in summary.items() if key not in ("elapsed_s", "created_utc")}


def _draw_blocks(folder: Path, random: Random) -> None:
    shutil.copytree(_finished_blocks()[0] / "blocks", folder / "blocks")
    paths = sorted((folder / "blocks").iterdir())
    for path in random.sample(paths, random.choice((1, 1, 2))):
        kind = random.randrange(5)
        if kind == 0:
            path.unlink()
        elif kind == 1:
            path.write_bytes((_finished_blocks()[0] / "blocks" / random.choice(paths).name).read_bytes())
        elif kind == 2 and path.suffix == ".json":
            path.write_text(json.dumps(mutations.changed_tree(json.loads(path.read_text()), random)))
        else:
            path.write_bytes(mutations.changed_bytes(path.read_bytes(), random))


def _resume(folder: Path) -> None:
    work = folder / "resumed"
    shutil.copytree(folder / "blocks", work)
    try:
        if _resumed(work, resume=True) != _finished_blocks()[1]:
            raise AssertionError("a damaged block changed the answer")
    finally:
        shutil.rmtree(work)


_COMMANDS = ("simulate", "sweep-dmax", "plan-legs", "size-anchor", "validate", "diagnose", "identify", "effects", "compare",
             "sweep-transition", "init", "bogus", "")  # fmt: skip
_OPTIONS = ("--trials", "--seed", "--jobs", "--precision", "--probability", "--phase", "--method", "--aim", "--backend",
            "--scheduler", "--out", "--resume", "--force", "--json", "--quiet", "--help", "--allow-outside", "--bogus")  # fmt: skip
_FLAGS = _OPTIONS[-7:]
_VALUES = ("1", "0", "-1", "2.5", "ten", "1e9", "nan", "5%", "success=0.1", "moor.offset=1 m", "", " ", "moor", "out", ".", "both",
           "energy", "threading", "a" * 300, "é", "mission.yaml", "data", "--", "/dev/null", "x/y/z", "out/mission.yaml")  # fmt: skip


def _draw_options(folder: Path, random: Random) -> None:
    (folder / "mission.yaml").write_text(yaml.safe_dump(examples.mission(random.choice(examples.MISSIONS[:2]))))
    examples.write_dataset(folder / "data", "drag", examples.DATASETS["drag"][1], examples.table("drag").encode())
    command = random.choice(_COMMANDS)
    words = [command, *{"diagnose": ["mission.yaml", "data"], "identify": ["data"]}.get(command, ["mission.yaml"])]
    if random.random() < 0.2:
        words[random.randrange(len(words))] = random.choice(_VALUES)
    if command in _COMMANDS[:4]:
        words += ["--trials", "10", "--jobs", "1"]
    for _ in range(random.randrange(3)):
        option = random.choice(_OPTIONS)
        words += [option, *([random.choice(_VALUES)] if option not in _FLAGS or random.random() < 0.1 else [])]
    (folder / "words.json").write_text(json.dumps(words))


def _run_options(folder: Path) -> None:
    words = json.loads((folder / "words.json").read_text())
    before, sys.argv = sys.argv, ["missionplan", *words]
    handlers = {number: signal.getsignal(number) for number in (signal.SIGTERM, signal.SIGHUP)}
    try:
        with chdir(folder):
            main()
    except SystemExit as end:
        if end.code not in (0, 1, 2, 3):
            raise AssertionError(f"exit status {end.code}") from None
    finally:
        sys.argv = before
        for number, handler in handlers.items():
            signal.signal(number, handler)


TARGETS = {
    "validate": Target(_draw_mission, _validate, 10.0),
    "simulate": Target(_draw_mission, _simulate, 20.0),
    "current": Target(_draw_current, _simulate, 20.0),
    "read": Target(_draw_dataset, _read, 5.0),
    "diagnose": Target(_draw_dataset, _diagnose, 120.0),
    "identify": Target(_draw_tank, _identify, 10.0),
    "resume": Target(_draw_blocks, _resume, 20.0),
    "options": Target(_draw_options, _run_options, 60.0),
}
