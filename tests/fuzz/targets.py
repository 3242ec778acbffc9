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

import numpy as np
import yaml

import missionplan
from missionplan.cli import main
from missionplan.errors import InputError
from missionplan.mission.schema.place import Geographic
from missionplan.scenario.currents.area import Area
from missionplan.scenario.currents.reading import read_field
from missionplan.studies.validate import validate

from . import examples, mutations
from .hostile_names import NAMES, ODD, named
from .looking import look_at_folder

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


_DEPTHS = {"m": 1.0, "metres": 1.0, "cm": 0.01, "centimeters": 0.01, "km": 1e3, "ft": 0.3048, "fathoms": 1.8288, "": 0.0, "dbar": 0.0,
           "furlong s": 0.0, "1": 0.0, "é" * 50: 0.0}  # fmt: skip
_SPEEDS = {
    "m s-1": 1.0,
    "m/s": 1.0,
    "cm s**-1": 0.01,
    "knots": 1852 / 3600,
    "mm.s-1": 1e-3,
    "km/h": 1 / 3.6,
    "": 0.0,
    "m": 0.0,
    "s m-1": 0.0,
    "((": 0.0,
}
_TIMES = ("seconds since 2026-06-01", "s since 2026-06-01T02:00+02:00", "sec since 2026-5-31 19:0:0 -5", "second since 2026-06-01 UTC",
          "seconds since 2026-06-01 EST", "seconds since 2026-13-01", "seconds", "years since 2026-06-01", "")  # fmt: skip
_WRONG = (
    "",
    "up",
    "sideways",
    "height_above_sea_floor",
    "ocean_sigma_coordinate",
    "sigma: lev",
    "sigma: lev depth: u eta: v",
    "noleap",
    "é",
    "radian",
)


def _draw_field(folder: Path, random: Random) -> None:
    """Write a field in units at random: the same one, what has to be refused, or with attributes that are damaged besides."""
    depth, u, v = random.choice(list(_DEPTHS)), random.choice(list(_SPEEDS)), random.choice(list(_SPEEDS))
    sign = random.choice((1.0, 1.0, -1.0))
    attributes = {"time": {"units": random.choice(_TIMES)}, "u": {"units": u}, "v": {"units": v}, "lat": {"units": "degrees_north"},
                  "lon": {"units": "degrees_east"}, "lev": {"units": depth, "positive": "up" if sign < 0.0 else "down"}}  # fmt: skip
    for own in attributes.values():
        if random.random() < 0.1:
            key = next(iter(own))
            own[key.upper()] = own.pop(key)
    told = random.random() < 0.7
    if not told:
        own = attributes[random.choice(list(attributes))]
        own[random.choice(("units", "positive", "standard_name", "formula_terms", "calendar", "axis"))] = random.choice(
            _WRONG
        )
    scales = {"lev": sign * (_DEPTHS[depth] or 1.0), "u": _SPEEDS[u] or 1.0, "v": _SPEEDS[v] or 1.0}
    examples.write_field(folder / "field.nc", attributes, scales)
    content = (folder / "field.nc").read_bytes()
    if not told and random.random() < 0.3:
        (folder / "field.nc").write_bytes(mutations.changed_bytes(content, random))
    (folder / "told.json").write_text(json.dumps(told))


def _read_field(folder: Path) -> object:
    """Read it; what its attributes tell is the field that was written."""
    area = Area(Geographic.model_construct(latitude=np.radians(45.0), longitude=np.radians(-124.0)),
                np.datetime64("2026-06-01T00:30", "ns"), np.zeros((2, 1)))  # fmt: skip
    current = read_field([str(folder / "field.nc")], area, "field.nc")
    found = current.velocity(600.0, 10.0, np.zeros((2, 1)))[:, 0]
    if json.loads((folder / "told.json").read_text()) and not np.allclose(found, [0.45, 0.09], rtol=1e-5):
        raise AssertionError(f"another current: {found}")
    return {"east": float(found[0]), "north": float(found[1])}


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


_PIECES = tuple(piece for name in (*NAMES, *ODD) for piece in (name[: len(name) // 2], name, name[len(name) // 2 :]))


def _draw_names(folder: Path, random: Random) -> None:
    names = list(dict.fromkeys("".join(random.choices(_PIECES, k=random.randrange(1, 4))) for _ in range(6)))
    data = named(examples.mission(random.choice(examples.MISSIONS[:4])), names)
    (folder / "mission.yaml").write_text(yaml.safe_dump(data, sort_keys=False))


def _report(folder: Path) -> object:
    """Simulate a mission and save its report, in which every file has to be whole."""
    mission = missionplan.load(folder / "mission.yaml")
    outcome, report = missionplan.simulate(mission, trials=TRIALS), Path(mkdtemp(dir=folder)) / "report"
    try:
        outcome.save(report)
        look_at_folder(report, mission.raw)
    finally:
        shutil.rmtree(report.parent)
    return outcome.summary()


TARGETS = {
    "validate": Target(_draw_mission, _validate, 10.0),
    "simulate": Target(_draw_mission, _simulate, 20.0),
    "current": Target(_draw_current, _simulate, 20.0),
    "field": Target(_draw_field, _read_field, 5.0),
    "read": Target(_draw_dataset, _read, 5.0),
    "diagnose": Target(_draw_dataset, _diagnose, 120.0),
    "identify": Target(_draw_tank, _identify, 10.0),
    "names": Target(_draw_names, _report, 60.0),
    "resume": Target(_draw_blocks, _resume, 20.0),
    "options": Target(_draw_options, _run_options, 60.0),
}
