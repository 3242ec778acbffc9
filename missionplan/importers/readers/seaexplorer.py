"""SeaExplorer gliders: `gli` logs, text with semicolons, plain or packed by gzip.

The position stands still under water: it repeats the last fix. A fix is a row with a new position.
"""

import gzip
import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from missionplan.arrays import Array
from missionplan.importers.importer import Importer, ReadOptions, SourceLog
from missionplan.importers.sourcefiles.columns import ColumnStore
from missionplan.importers.sourcefiles.conversions import ddmm_to_degrees
from missionplan.importers.track import Track, fixes, series

_NEEDED = ("Timestamp", "Lat", "Lon", "Depth")
_USED = (*_NEEDED, "Heading", "Declination", "Pitch", "NavState")
_HEAD = re.compile(rb"\s*Timestamp;NavState;")
_TIME = "%d/%m/%Y %H:%M:%S"


def recognises(path: Path, head: bytes) -> bool:
    """Whether a file is a `gli` log."""
    return bool(_HEAD.match(head)) and b"Heading" in head


def read(files: Sequence[Path], options: ReadOptions, log: SourceLog) -> Track:
    """Read `gli` logs as one track."""
    store = ColumnStore()
    for path in log.each(sorted(files, key=_number)):
        with log.reading(path):
            store.add(_columns(path))
    t = store["t"]
    latitude, longitude = store["lat"], store["lon"]
    new = np.append(True, (np.diff(latitude) != 0.0) | (np.diff(longitude) != 0.0)) if len(t) else np.empty(0, bool)
    declination = series(t, store["declination"])
    return Track(
        name=_vehicle(files),
        format="seaexplorer",
        fixes=fixes(t[new], latitude[new], longitude[new]),
        reckoning="the vehicle's position stands still under water",
        depth=series(t, store["depth"]),
        pitch=series(t, store["pitch"]),
        heading=series(t, store["heading"]),
        heading_from="magnetic",
        declination=declination,
        breaks=store.breaks,
    )


def _number(path: Path) -> tuple[str, int, str]:
    """Order the files of one mission by their number, `SEA035.10.gli.sub.12.gz` after `.9`."""
    numbers = re.findall(r"\d+", path.name.removesuffix(".gz"))
    return str(path.parent), int(numbers[-1]) if numbers else 0, path.name


def _vehicle(files: Sequence[Path]) -> str:
    found = re.match(r"([A-Za-z]+\d+)\.(\d+)\.", files[0].name)
    return f"SeaExplorer {found[1].upper()}, mission {found[2]}" if found else "SeaExplorer"


def _columns(path: Path) -> dict[str, Array]:
    with gzip.open(path, "rb") if path.suffix == ".gz" else path.open("rb") as stream:
        table = pd.read_csv(
            stream, sep=";", usecols=lambda name: name.strip() in _USED, encoding="latin-1", low_memory=False
        )
    table.columns = [str(name).strip() for name in table.columns]
    missing = [name for name in _NEEDED if name not in table]
    if missing:
        raise ValueError(f"no column {', '.join(missing)}: not a gli log, or a damaged one")
    times = pd.to_datetime(table["Timestamp"], format=_TIME, errors="coerce", utc=True)
    seconds = (times - pd.Timestamp(0, tz="UTC")).dt.total_seconds().to_numpy()
    latitude, longitude = (ddmm_to_degrees(_numbers(table, name)) for name in ("Lat", "Lon"))
    held = {"depth": "Depth", "heading": "Heading", "pitch": "Pitch", "declination": "Declination"}
    return {
        "t": np.asarray(seconds, dtype=float),
        "lat": latitude,
        "lon": longitude,
        **{name: _numbers(table, column) for name, column in held.items()},
    }


def _numbers(table: pd.DataFrame, name: str) -> Array:
    if name not in table:
        return np.full(len(table), np.nan)
    return np.asarray(pd.to_numeric(table[name], errors="coerce"), dtype=float)


IMPORTER = Importer("seaexplorer", "SeaExplorer gli logs, plain or packed by gzip", recognises, read)
