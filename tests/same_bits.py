"""The numbers of every command on every shipped mission and data set, to hold one commit against another.

``python -m tests.same_bits record FOLDER`` runs the commands of the checkout that stands in the working directory and
keeps what each says in its ``summary.json`` (and what ``export`` and ``schema`` write) in FOLDER, one file a command;
``python -m tests.same_bits compare BEFORE AFTER`` names every number that is not the same to the bit, and exits with 1
if there is one. To compare two commits, record each in a checkout of its own.
"""

import json
import math
import os
import shlex
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).parents[1]
OF_THE_RUN = {
    "elapsed_s",
    "version",
    "options",
    "identity",
    "libraries",
    "provenance",
    "created_utc",
    "schema",
    "identity_parts",
}
"""Keys that tell of the run and not of its answer."""
FORMATS = ("csv", "json", "gpx", "geojson", "kml", "moos", "neptus", "iver", "qgc")
SHIPPED = "autosub-transition", "estuary", "fig8", "anchor-design", "chesapeake"


def commands() -> Iterator[str]:
    """Every command with its arguments; ``OUT`` stands for a folder of its own, ``INIT`` for the starter's."""
    for mission in SHIPPED:
        yield f"simulate missions/{mission}.yaml --trials 1500 --seed 3 --out OUT"
    yield "simulate missions/chesapeake.yaml --rare 'moor.offset > 24 m' --trials 1000 --seed 3 --out OUT"
    yield "simulate INIT/mission.yaml --trials 1500 --out OUT"
    yield "sweep-dmax missions/fig8.yaml --trials 1000 --seed 3 --out OUT"
    yield "sweep-dmax missions/chesapeake.yaml --trials 500 --seed 3 --out OUT"
    yield "plan-legs missions/fig8.yaml --trials 500 --seed 3 --out OUT"
    yield "size-anchor missions/anchor-design.yaml --trials 500 --seed 3 --out OUT"
    yield "size-anchor missions/chesapeake.yaml --trials 500 --seed 3 --out OUT"
    yield "sweep-transition missions/autosub-transition.yaml --out OUT"
    yield "explore missions/chesapeake.yaml --vary 'ingress.speed=1:2:0.25 m/s' --trials 300 --seed 3 --out OUT"
    yield "optimise missions/estuary.yaml --trials 300 --seed 3 --out OUT"
    yield "compare missions/chesapeake.yaml missions/estuary.yaml --trials 300 --out OUT"
    yield "identify missions/measured/avila-drag --out OUT"
    yield "identify missions/measured/avila-added-mass --out OUT"
    for data in ("avila-drag", "avila-added-mass", "table-1"):
        yield f"diagnose missions/chesapeake.yaml missions/measured/{data} --seed 3 --out OUT"
    yield "diagnose INIT/mission.yaml INIT/sea-trial --seed 3 --out OUT"
    yield "score INIT/mission.yaml INIT/sea-trial --seed 3 --out OUT"
    yield "tide INIT/record.csv --latitude '60 deg' --start 2026-05-01T00:00Z --out OUT"
    for mission in ("chesapeake", "estuary", "fig8"):
        for form in FORMATS:
            yield f"export missions/{mission}.yaml --to {form} --out OUT"
    for kind in ("mission", "vehicle", "dataset", "plan"):
        yield f"schema {kind}"


def _record(command: str, number: int, folder: Path, work: Path) -> None:
    out = work / f"out-{number}"
    line = command.replace("OUT", str(out)).replace("INIT", str(work / "starter"))
    done = subprocess.run(
        [sys.executable, "-m", "missionplan", *shlex.split(line)],
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=False,
    )
    kept: dict[str, object] = {"command": command, "exit": done.returncode}
    places = {str(work): "WORK", str(ROOT): "ROOT"}
    if (out / "summary.json").is_file():
        kept["summary"] = _answer(json.loads(_without(places, (out / "summary.json").read_text(encoding="utf-8"))))
    elif out.exists() and command.startswith("export"):
        files = [out] if out.is_file() else sorted(path for path in out.rglob("*") if path.is_file())
        kept["files"] = {path.name.replace(out.name, "OUT"): path.read_bytes().decode("latin-1") for path in files}
    else:
        kept["printed"] = _without(places, done.stdout)
        kept["said"] = _without(places, done.stderr)
    (folder / f"{number:02d}.json").write_text(json.dumps(kept, indent=1, sort_keys=True) + "\n", encoding="utf-8")


def _without(places: Mapping[str, str], text: str) -> str:
    """Return a text with names in the place of folders."""
    for folder, name in places.items():
        text = text.replace(folder, name)
    return text


def _answer(value: object) -> object:
    if isinstance(value, dict):
        return {key: _answer(inner) for key, inner in value.items() if key not in OF_THE_RUN}
    return [_answer(inner) for inner in value] if isinstance(value, list) else value


def record(folder: Path) -> int:
    """Run every command and keep what it says."""
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as work, ThreadPoolExecutor(2) as pool:
        subprocess.run(
            [sys.executable, "-m", "missionplan", "init", f"{work}/starter"],
            cwd=ROOT,
            env={**os.environ, "PYTHONPATH": str(ROOT)},
            check=True,
            stdout=subprocess.DEVNULL,
        )
        (Path(work) / "starter" / "record.csv").write_text(_tidal_record(), encoding="utf-8")
        lines = list(commands())
        list(pool.map(lambda numbered: _record(numbered[1], numbered[0], folder, Path(work)), enumerate(lines)))
    print(f"{len(lines)} commands recorded in {folder}")
    return 0


def _tidal_record() -> str:
    """A month of an M2 and a K1 tide at one depth, every half hour, with a ripple in place of noise."""
    rows = ["t_s,depth_m,east_m_s,north_m_s"]
    for step in range(30 * 48):
        hours = step / 2
        m2, k1 = 2 * math.pi * hours / 12.4206, 2 * math.pi * hours / 23.9345
        ripple = 0.01 * math.sin(1.7 * step**1.5)
        rows.append(f"{hours * 3600:.0f},10,{0.3 * math.cos(m2) + ripple:.5f},{0.1 * math.sin(k1) - ripple:.5f}")
    return "\n".join(rows) + "\n"


def differences(before: object, after: object, place: str = "") -> Iterator[str]:
    """Name every leaf of plain data that differs."""
    if isinstance(before, dict) and isinstance(after, dict):
        for key in sorted(before.keys() | after.keys()):
            yield from differences(before.get(key, "nothing"), after.get(key, "nothing"), f"{place}.{key}")
    elif isinstance(before, list) and isinstance(after, list) and len(before) == len(after):
        for number, (one, other) in enumerate(zip(before, after, strict=True)):
            yield from differences(one, other, f"{place}[{number}]")
    elif before != after:
        yield f"{place.lstrip('.')}: {str(before)[:100]!r} → {str(after)[:100]!r}"


def compare(before: Path, after: Path) -> int:
    """Print what differs between two records, command by command."""
    changed = 0
    for path in sorted({each.name for folder in (before, after) for each in folder.glob("*.json")}):
        if not ((before / path).is_file() and (after / path).is_file()):
            print(f"{path}: recorded once only")
            changed += 1
            continue
        one, other = (json.loads((folder / path).read_text(encoding="utf-8")) for folder in (before, after))
        found = list(differences(one, other))
        if found:
            changed += 1
            print(f"{one['command']}: {len(found)} differences\n  " + "\n  ".join(found[:8]))
    print(f"{changed} commands differ" if changed else "the same to the bit")
    return int(bool(changed))


if __name__ == "__main__":
    match sys.argv[1:]:
        case ["record", folder]:
            sys.exit(record(Path(folder).resolve()))
        case ["compare", before, after]:
            sys.exit(compare(Path(before), Path(after)))
        case _:
            sys.exit(__doc__)
