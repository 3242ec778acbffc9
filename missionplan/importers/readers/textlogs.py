"""Text logs that vehicles write in columns of their own.

SeaExplorer: `gli` logs, plain or packed by gzip. The position stands still under water, or is dead-reckoned where the
column `DeadReckoning` is 1. A fix is a row with a new position that is not. `NavState` 116 is "at the surface,
acquiring GPS and transmitting" (codes as in the package oceglider: 100 descending, 105 set up, 110 inflecting down,
115 surfacing, 116, 117 ascending, 118 inflecting up).

Iver and EcoMapper: logs of the vehicle's computer, separated by semicolons. One position: the receiver's at the
surface, dead-reckoned under water. Columns as in the log files that the makers' VectorMap writes and public tools for
EcoMapper and Iver2 logs read: Latitude, Longitude, Time, Date (month first unless the log shows another order, UTC),
Number of Sats, HDOP, C True Heading, Pitch Angle, DFS Depth (m), Vehicle Speed (kn).
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd

from missionplan.arrays import Array
from missionplan.importers.importer import DAMAGED, ColumnStore, Identity, Importer, ReadOptions, SourceLog
from missionplan.importers.mapping import MappedName, angles, mapped, plain_numbers, times, without_unit
from missionplan.importers.readers import track
from missionplan.importers.readers.track import read_header, text_chunks
from missionplan.importers.track import Positions, Series, Track, fixes, positions, series

_COLUMNS = {
    "time": ("timestamp", "time", "date"),
    "lat": ("lat", "latitude", "nav_latitude"),
    "lon": ("lon", "longitude", "nav_longitude"),
    "depth": ("depth", "nav_depth"),
    "heading": ("heading",),
    "pitch": ("pitch",),
    "declination": ("declination",),
    "state": ("navstate", "nav_resource"),
    "reckoned": ("deadreckoning", "dead_reckoning"),
}
"""Names of the columns in small letters, as firmware versions have them."""
_FLAGS = {"true": "1", "false": "0"}
_NUMBERS = ("depth", "heading", "pitch", "declination", "state")
_NEEDED = ("time", "lat", "lon", "depth")
_MARKS = {"timestamp", "navstate", "heading", "depth"}
"""Columns by which such a log is recognised."""
_NAME = re.compile(r"([A-Za-z]+\d+)\.(\d+)\.")
_TIMES = ("%d/%m/%Y %H:%M:%S", "iso")
_IVER_DATES = ("%m/%d/%Y", "%d/%m/%Y", "iso")
_AT_SURFACE = 116.0
_MOST_FIXES = 0.5
"""Share of rows with a new position up to which each is kept when rows are thinned."""


def recognises(path: Path, head: bytes) -> bool:
    """Whether a file is a `gli` log."""
    return {word.replace("_", "") for word in _first_line(head)} >= _MARKS


def _first_line(head: bytes) -> list[str]:
    """Names of the columns that the first line has, in small letters."""
    line = head.split(b"\n")[0].decode("utf-8-sig", "replace")
    separator = max(";\t|,", key=line.count)
    return [word.strip().strip('"').lower() for word in line.split(separator)]


def identity(path: Path) -> Identity:
    """Vehicle and mission that the name of a file tells, such as ``sea035.10.gli.sub.12.gz``."""
    match = _NAME.match(path.name)
    return Identity(match[1].upper(), f"mission {int(match[2])}") if match else Identity()


def read(files: Sequence[Path], options: ReadOptions, log: SourceLog) -> Track:
    """Read `gli` logs as one track."""
    store = ColumnStore()
    for path in log.each(sorted(files, key=_number)):
        with log.reading(path):
            for part in _parts(path):
                store.add(part)
    t, latitude, longitude = store["t"], store["lat"], store["lon"]
    by_itself = store["reckoned"] == 1.0
    state = store["state"]
    begins = bool(len(t)) and state[0] == _AT_SURFACE  # else the first row repeats a fix of before the log
    moved = np.append(begins, (np.diff(latitude) != 0.0) | (np.diff(longitude) != 0.0))[: len(t)]
    back = np.append(False, by_itself[:-1])[: len(t)]  # the first fix after dead reckoning may be the place itself
    new = (moved | back) & ~by_itself
    line = positions(t[by_itself], latitude[by_itself], longitude[by_itself]) if by_itself.any() else Positions()
    return Track(
        name="SeaExplorer",
        format="seaexplorer",
        fixes=fixes(t[new], latitude[new], longitude[new]),
        reckoned=line,
        reckoning="the vehicle's own (DeadReckoning is 1)"
        if len(line)
        else "the vehicle's position stands still under water",
        depth=series(t, store["depth"]),
        pitch=series(t, store["pitch"]),
        heading=series(t, store["heading"]),
        heading_from="magnetic",
        declination=series(t, store["declination"]),
        at_surface=series(t, np.where(np.isfinite(state), (state == _AT_SURFACE).astype(float), np.nan))
        if (state == _AT_SURFACE).any()
        else Series(),
        breaks=store.breaks,
    )


def _number(path: Path) -> tuple[str, int, str]:
    """Order the files of one mission by their number, `SEA035.10.gli.sub.12.gz` after `.9`."""
    numbers = re.findall(r"\d+", path.name.removesuffix(".gz"))
    return str(path.parent), int(numbers[-1]) if numbers else 0, path.name


def _parts(path: Path) -> Iterator[dict[str, Array]]:
    """Read some rows at a time."""
    header = list(reversed(read_header(path)))
    names = {role: name for name in header for role, usual in _COLUMNS.items() if name.lower() in usual}
    missing = [role for role in _NEEDED if role not in names]
    if missing:
        raise ValueError(f"no column {', '.join(missing)}: not a gli log, or a damaged one")
    for table in text_chunks(path, list(names.values())):
        yield _columns({role: table[name] for role, name in names.items()})


def _columns(words: Mapping[str, "pd.Series[str]"]) -> dict[str, Array]:
    numbers = {role: plain_numbers(column) for role, column in words.items() if role in _NUMBERS}
    if "reckoned" in words:
        numbers["reckoned"] = plain_numbers(words["reckoned"].str.strip().str.lower().replace(_FLAGS))
    latitude, longitude = (angles(words[role], "ddmm") for role in ("lat", "lon"))
    moved = np.append(True, (np.diff(latitude) != 0.0) | (np.diff(longitude) != 0.0))[: len(latitude)]
    is_fix = moved & ~(numbers.get("reckoned", np.zeros(len(moved))) == 1.0)
    kept = {"keep": is_fix.astype(float)} if np.mean(is_fix) < _MOST_FIXES else {}
    few = words["time"].iloc[:: max(len(moved) // 50, 1)]
    form = max(_TIMES, key=lambda name: int(np.isfinite(times(few, name)).sum()))  # that which fits most of them
    t = times(words["time"], form)
    track.check_cells(words["time"], t, MappedName("Timestamp", form), is_first=True)
    return {"t": t, "lat": latitude, "lon": longitude, **numbers, **kept}


_IVER_COLUMNS = {
    "time": "Date+Time[%m/%d/%Y %H:%M:%S]",
    "lat": "Latitude[deg]",
    "lon": "Longitude[deg]",
    "depth": "DFS Depth[m]",
    "heading_true": "C True Heading[deg]",
    "pitch": "Pitch Angle[deg]",
    "speed": "Vehicle Speed[kn]",
    "hdop": "HDOP",
    "satellites": "Number of Sats",
}
"""Columns without the units that stand in brackets behind their names, and the units where none do."""
_IVER_NEEDED = {"latitude", "longitude", "time", "date", "dfs depth"}
_IVER_NAME = re.compile(r"(iver\d*-\d+|ecomapper[-_]?\d+)", re.IGNORECASE)


def recognises_iver(path: Path, head: bytes) -> bool:
    """Whether a file's first line has the columns of such a log."""
    return {without_unit(word) for word in _first_line(head)} >= _IVER_NEEDED


def identity_iver(path: Path) -> Identity:
    """Vehicle that the name of a file ends with, such as ``20170627_193227_UTC_0_mission1_IVER2-135.log``."""
    match = _IVER_NAME.search(path.name)
    return Identity(match[1].upper() if match else "")


def read_iver(files: Sequence[Path], options: ReadOptions, log: SourceLog) -> Track:
    """Read logs as one track."""
    header = {name.lower() for name in read_header(files[0])}
    names = {}
    for quantity, name in _IVER_COLUMNS.items():
        usual, there = mapped(quantity, name), {without_unit(heading) for heading in header}
        if set(usual.name.lower().split("+")) <= there:
            names[quantity] = usual if usual.name.lower() in header else mapped(quantity, usual.name)
    date, notices = _date_form(files, names["time"].name.split("+")[0])
    names["time"] = MappedName(names["time"].name, date if date == "iso" else f"{date} %H:%M:%S")
    iver_track = track.read(files, replace(options, names={**names, **options.names}), log)
    reckoning = "the vehicle's own position under water"
    return replace(iver_track, name="Iver", format="iver", reckoning=reckoning, notices=(*iver_track.notices, *notices))


def _date_form(files: Sequence[Path], column: str) -> tuple[str, tuple[str, ...]]:
    """Form of the dates: that which most have, else that of the files' names, else that in which a file's days follow.

    A notice says which was taken where nothing tells the day from the month.
    """
    written: list[tuple[Path, pd.Series[str]]] = []
    for path in files:
        with suppress(*DAMAGED):  # as the reader says
            written.append((path, pd.concat([rows[column] for rows in text_chunks(path, [column])]).drop_duplicates()))

    def fits(form: str) -> tuple[int, int, float]:
        count, named, span = 0, 0, 0.0
        for path, words in written:
            days = np.unique(times(words, form) // 86400.0)
            days = days[np.isfinite(days)]
            count, span = count + len(days), span + float(np.ptp(days) if len(days) else 0.0)
            named += any(f"{np.datetime64(int(day), 'D')}".replace("-", "") in path.name for day in days)
        return count, named, -span

    best = max(_IVER_DATES, key=fits)
    months, days = (np.concatenate([[], *(times(words, form) for _, words in written)]) for form in _IVER_DATES[:2])
    if best == "iso" or fits(_IVER_DATES[0]) != fits(_IVER_DATES[1]) or np.array_equal(months, days, equal_nan=True):
        return best, ()
    shown = written[0][1].iloc[0]
    return best, (f"dates such as {shown} are read month first: nothing in the log tells the day from the month",)


IMPORTERS = (
    Importer("seaexplorer", "SeaExplorer gli logs, plain or packed by gzip", recognises, read, identify=identity),
    Importer("iver", "Iver and EcoMapper text logs", recognises_iver, read_iver, identify=identity_iver),
)
