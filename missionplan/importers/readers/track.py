"""Any track: tables of text and NetCDF whose columns `--map` names, GPX tracks and NMEA 0183 sentences.

`lat`, `lon` are fixes where `dr_lat`, `dr_lon` (or `dr_x`, `dr_y`) have the dead-reckoned position. A table with
one position alone has the vehicle's own: dead-reckoned under water, and fixes at the surface. Tables have any
separator, a preface or none, and decimal points or commas.
"""

import codecs
import csv
import io
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import IO

import numpy as np
import pandas as pd

from missionplan.arrays import Array
from missionplan.importers.dives import split_at_surface
from missionplan.importers.geodesy import origin_of, plane_positions
from missionplan.importers.importer import (
    ColumnStore,
    Importer,
    PartlyReadError,
    ReadOptions,
    Samples,
    SourceLog,
    head_of,
    unpacked,
)
from missionplan.importers.mapping import (
    QUANTITIES,
    MappedName,
    angles,
    check_mapping,
    flags,
    own_unit,
    quantities,
    times,
    without_unit,
)
from missionplan.importers.readers.netcdf import MAGIC, Variables, mapped_parts, opened
from missionplan.importers.readers.receivers import FIX_COLUMNS, add_gpx, add_nmea, is_gpx, is_nmea
from missionplan.importers.track import Fixes, Positions, Series, Track, fixes, positions, series
from missionplan.moments import other_zone

_ANGLES = ("lat", "lon", "dr_lat", "dr_lon")
_WITH_ZONE = re.compile(r"(?:Z|[+-]\d{2}:?\d{2})\s*$")
_BACKWARD = re.compile(r"[\W_](?:S|W|south|west)\W*$", re.IGNORECASE)
_NO_COLUMNS = ("origin", "gps", "odometry")
_QUALITIES = {"hdop": "hdop", "accuracy": "hacc", "satellites": "satellites", "valid": "valid"}


def recognises(path: Path, head: bytes) -> bool:
    """Whether a file is a GPX track or holds NMEA sentences; tables are read when `--map` names their columns."""
    return is_gpx(path, head) or is_nmea(path, head)


def read(files: Sequence[Path], options: ReadOptions, log: SourceLog) -> Track:
    """Read tables and files of fixes as one track.

    Raises InputError when tables are given, but not which columns have time and position.
    """
    store, points = ColumnStore(), Samples(FIX_COLUMNS)
    for path in log.each(sorted(files)):
        with log.reading(path):
            head = head_of(path)
            if is_gpx(path, head):
                add_gpx(path, points)
            elif is_nmea(path, head):
                add_nmea(path, points)
            else:
                check_mapping(options.names, path)
                for part in _parts(path, head, options.names):  # some rows at a time
                    store.add(part)
    gps_fixes = fixes(
        points["t"],
        points["lat"],
        points["lon"],
        hdop=points["hdop"],
        satellites=points["satellites"],
        valid=points["valid"],
    )
    return _track(files, store, gps_fixes, options)


def _parts(path: Path, head: bytes, names: Mapping[str, MappedName]) -> Iterator[dict[str, Array]]:
    columns = {quantity: column for quantity, column in names.items() if quantity not in _NO_COLUMNS}
    if head.startswith(MAGIC):
        with opened(path, "track") as data:
            yield from mapped_parts(Variables(data), columns)
        return
    wanted = [column.name for column in columns.values()]
    heading = {asked: name for name, asked in _header(path, wanted)[2].items()}
    for number, chunk in enumerate(text_chunks(path, wanted)):
        for quantity, column in columns.items() if number == 0 and len(chunk) else ():
            own = " ".join(heading.get(part, "") for part in _names_in(column.name))
            columns[quantity] = MappedName(column.name, own_unit(column, quantity, own, chunk[column.name][0]))
            _check_heading(quantity, own, chunk[column.name])
        part = _of_text(chunk, columns)
        for quantity, column in columns.items():
            values = part["t" if quantity == "time" else quantity]
            check_cells(chunk[column.name], values, column, is_first=number == 0)
        yield part


def _check_heading(quantity: str, heading: str, words: "pd.Series[str]") -> None:
    """Refuse times of another zone, and degrees toward south or west, that the heading alone says so of."""
    zone = other_zone(heading) if quantity == "time" else ""
    if zone and not _WITH_ZONE.search(words.iloc[0]):
        raise ValueError(f"the column {heading!r} says {zone!r}: expected UTC, or a zone behind each time")
    if quantity in _ANGLES and _BACKWARD.search(heading) and not words.str.contains("[-SWsw]").any():
        raise ValueError(f"the column {heading!r} counts toward south or west: write its degrees below 0, or 123.5 W")


def check_cells(words: "pd.Series[str]", values: Array, asked: MappedName, *, is_first: bool) -> None:
    """Refuse times and numbers that are not of the form asked for: day and month exchanged are read up to the 12th.

    Raises PartlyReadError where rows before were read.
    """
    is_time = asked.unit == QUANTITIES["time"] or "%" in asked.unit
    plain = words.str.strip().str.replace(",", ".")
    is_word = (plain != "") if is_time else plain.str.contains(r"\d") & pd.to_numeric(plain, errors="coerce").isna()
    is_other = (is_word & ~np.isfinite(values)).to_numpy()
    if is_other.sum() > max(_OTHER * len(words), _FEW) or (is_other.any() and not np.isfinite(values).any()):
        shown, kind = words[is_other].iloc[0].strip(), "times" if is_time else "cells"
        message = f"{is_other.sum()} of {len(words)} {kind} in {asked.name} are not as {asked.unit} says: {shown!r:.60}"
        raise ValueError(message) if is_first else PartlyReadError(message)


def _of_text(chunk: pd.DataFrame, columns: Mapping[str, MappedName]) -> dict[str, Array]:
    part: dict[str, Array] = {}
    for quantity, column in columns.items():
        words = chunk[column.name]
        if quantity == "time":
            part["t"] = times(words, column.unit)
        elif quantity in _ANGLES:
            part[quantity] = angles(words, column.unit)
        elif quantity == "valid":
            part[quantity] = flags(words)
        else:
            part[quantity] = quantities(words, column.unit, QUANTITIES[quantity])
    return part


def _track(files: Sequence[Path], store: ColumnStore, fixes: Fixes, options: ReadOptions) -> Track:
    names, t = options.names, store["t"]
    heading = "heading_true" if "heading_true" in names else "heading"

    def channel(quantity: str) -> Series:
        return series(t, store[quantity]) if quantity in names else Series()

    track = Track(
        name=files[0].stem,
        format="track",
        fixes=fixes,
        depth=channel("depth"),
        pitch=channel("pitch"),
        heading=channel(heading),
        heading_from="true" if heading == "heading_true" else "magnetic",
        speed=channel("speed"),
        declination=channel("declination"),
        breaks=store.breaks,
        marks=_marks(t, store["mark"]) if "mark" in names else (),
    )
    return _with_positions(track, store, names)


def split_track(name: str, format_name: str, store: ColumnStore, names: Mapping[str, MappedName]) -> Track:
    """Make a track of columns with the vehicle's one position: dead-reckoned under water, fixes at the surface."""
    none = fixes(np.empty(0), np.empty(0), np.empty(0))
    return replace(_track([Path(name)], store, none, ReadOptions(names)), name=name, format=format_name)


def _with_positions(track: Track, store: ColumnStore, names: Mapping[str, MappedName]) -> Track:
    """Add fixes and dead-reckoned positions: of columns of their own, else of the one position that there is."""
    origin, has_fixes = origin_of(names.get("origin")), len(track.fixes) > 0
    line = _places(store, names, "", track.fixes, origin) or Positions()
    if not has_fixes:
        rows = np.searchsorted(store["t"], line.t)
        quality = {name: store[quantity][rows] for name, quantity in _QUALITIES.items() if quantity in names}
        track = replace(track, fixes=fixes(line.t, line.latitude, line.longitude, **quality))
    reckoned = _places(store, names, "dr_", track.fixes, origin)
    if reckoned is not None:
        return replace(track, reckoned=reckoned, reckoning="the track's own dead-reckoned columns")
    if has_fixes and len(line):
        return replace(track, reckoned=line, reckoning="the table's positions, with fixes of other files")
    return split_at_surface(track, line)


def _places(
    store: ColumnStore, names: Mapping[str, MappedName], prefix: str, fixes: Fixes, origin: tuple[float, float] | None
) -> Positions | None:
    if f"{prefix}lat" in names and f"{prefix}lon" in names:
        return positions(store["t"], store[f"{prefix}lat"], store[f"{prefix}lon"])
    if f"{prefix}x" in names and f"{prefix}y" in names:
        return plane_positions(store["t"], store[f"{prefix}x"], store[f"{prefix}y"], fixes, origin)
    return None


def _marks(t: Array, values: Array) -> tuple[float, ...]:
    """Times at which a mark rises from nothing or 0."""
    up = np.nan_to_num(values) > 0.0
    return tuple(float(moment) for moment in t[up & ~np.append(False, up[:-1])])


_OTHER = 0.05
"""Share of the times of some rows up to which they are damaged, and not of another form."""
_FEW = 3
"""And so many of them."""
_ROWS = 50_000
"""Rows that are held as text at a time."""
_PREFACE = 60
"""Lines among which the header is looked for."""
_LONGEST = 60
"""Characters of a name that a message shows."""
_SEPARATORS = (",", ";", "\t", "|")


def text_chunks(path: Path, wanted: Sequence[str]) -> Iterator[pd.DataFrame]:
    """Read columns as text, some rows at a time.

    A wanted name of the form `Date+Time` is several, joined by a space. Raises ValueError when no line has all these
    names.
    """
    line, separator, there = _header(path, wanted)
    with _opened(path) as stream:
        table = pd.read_csv(
            stream,
            sep=separator,
            skiprows=line,
            usecols=lambda name: name.strip() in there,
            dtype=str,
            keep_default_na=False,
            skipinitialspace=True,
            chunksize=_ROWS,
            on_bad_lines="skip",
            engine="c",
            index_col=False,
        )
        for chunk in table:
            chunk.columns = [there[str(name).strip()] for name in chunk.columns]
            yield pd.DataFrame({name: _joined(chunk, name) for name in wanted})


def read_header(path: Path) -> list[str]:
    """Names of the columns that the first line of a file has."""
    with _opened(path) as stream:
        line = stream.readline()
    separator = max(_SEPARATORS, key=line.count)
    return [cell.strip() for cell in next(csv.reader([line], delimiter=separator), [])]


def _names_in(name: str) -> list[str]:
    return [part.strip() for part in name.split("+")]


def _joined(chunk: pd.DataFrame, name: str) -> "pd.Series[str]":
    first, *others = _names_in(name)
    return chunk[first].str.cat(chunk[others], sep=" ") if others else chunk[first]


def _opened(path: Path) -> IO[str]:
    encoding = "utf-16" if head_of(path).startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)) else "utf-8-sig"
    return io.TextIOWrapper(unpacked(path), encoding=encoding, errors="replace", newline="")


def _cells(line: str, separator: str) -> list[str]:
    """Split a line; one with a cell longer than any name is none of names."""
    try:
        return line.split() if separator == r"\s+" else next(csv.reader([line], delimiter=separator), [])
    except csv.Error:
        return []


def _header(path: Path, wanted: Sequence[str]) -> tuple[int, str, dict[str, str]]:
    """Line of the header, from 0, its separator, and the headings of all columns there, in any case, to these names."""
    columns = list(dict.fromkeys(part for name in wanted for part in _names_in(name)))
    seen: list[str] = []
    with _opened(path) as stream:
        for number, line in zip(range(_PREFACE), stream, strict=False):
            for separator in (*_SEPARATORS, r"\s+"):
                names = [cell.strip() for cell in _cells(line, separator)]
                by_case = {convert(name).lower(): name for convert in (without_unit, str) for name in reversed(names)}
                there = {name if name in names else by_case.get(name.lower(), ""): name for name in columns}
                if "" not in there:
                    _check_directions(stream, separator, names, list(there))
                    return number, separator, there
                seen = max(seen, names, key=len)
    missing = [name for name in columns if name not in seen]
    raise ValueError(f"no column {', '.join(missing)}; it has {', '.join(name[:_LONGEST] for name in seen[:20])}")


def _check_directions(stream: IO[str], separator: str, names: Sequence[str], used: Sequence[str]) -> None:
    """Refuse a column beside one of directions, N or S, E or W, that nobody names: it would count north and east."""
    for line, _ in zip(stream, range(_PREFACE), strict=False):
        for name, following, cell in zip(names, names[1:], _cells(line, separator)[1:], strict=False):
            if name in used and following not in used and cell.strip().upper() in ("N", "S", "E", "W"):
                raise ValueError(
                    f"the column {following} says {cell.strip()}: name it with {name}, as {name}+{following}"
                )


IMPORTERS = (Importer("track", "tables and NetCDF with --map, GPX, NMEA", recognises, read),)
