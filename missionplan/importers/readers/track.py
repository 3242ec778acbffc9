"""Any track: a table of text or a NetCDF whose columns `--map` names, GPX and NMEA files of fixes.

`lat`, `lon` are fixes where `dr_lat`, `dr_lon` (or `dr_x`, `dr_y`) have the dead-reckoned position. A table with
one position alone has the vehicle's own: dead-reckoned under water, and fixes at the surface.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd

from missionplan.arrays import Array
from missionplan.errors import InputError, Problem
from missionplan.importers.geodesy import displacement
from missionplan.importers.importer import Importer, ReadOptions, SourceLog
from missionplan.importers.legs.rules import LegRules, depths_of
from missionplan.importers.mapping import QUANTITIES, MappedName
from missionplan.importers.sourcefiles.columns import ColumnStore
from missionplan.importers.sourcefiles.conversions import angles, quantities, times, unit_factor
from missionplan.importers.sourcefiles.netcdf import MAGIC, Variables, opened
from missionplan.importers.sourcefiles.plane import origin_of, plane_positions
from missionplan.importers.sourcefiles.position_files import add_gpx, add_nmea, empty_fixes, is_gpx, is_nmea
from missionplan.importers.sourcefiles.text_tables import text_chunks
from missionplan.importers.track import Fixes, Positions, Series, Track, fixes, positions, series

_ANGLES = ("lat", "lon", "dr_lat", "dr_lon")
_NO_COLUMNS = ("origin", "gps", "odometry")
_QUALITIES = {"hdop": "hdop", "accuracy": "hacc", "satellites": "satellites", "valid": "valid"}
_PLACES = (("lat", "lon"), ("dr_lat", "dr_lon"), ("x", "y"), ("dr_x", "dr_y"))
_DEPTH_UNITS = {"dbar": 1.0, "bar": 10.0}
"""Depth over pressure in the sea, to 1 % [m]."""


def recognises(path: Path, head: bytes) -> bool:
    """Whether a file is a GPX track or holds NMEA sentences; tables are read when `--map` names their columns."""
    return is_gpx(path, head) or is_nmea(path, head)


def read(files: Sequence[Path], options: ReadOptions, log: SourceLog) -> Track:
    """Read tables and files of fixes as one track.

    Raises
    ------
    InputError
        When tables are given, but not which columns have time and position.
    """
    store, found = ColumnStore(), empty_fixes()
    for path in log.each(sorted(files)):
        with path.open("rb") as stream:
            head = stream.read(4096)
        with log.reading(path):
            if is_gpx(path, head):
                add_gpx(path, found)
            elif is_nmea(path, head):
                add_nmea(path, found)
            else:
                _check_mapping(options.names, path)
                for part in _parts(path, head, options.names):  # some rows at a time
                    store.add(part)
    given = fixes(found["t"], found["lat"], found["lon"], hdop=found["hdop"], satellites=found["satellites"],
                  valid=found["valid"])  # fmt: skip
    return _track(files, store, given, options)


def _check_mapping(names: Mapping[str, MappedName], path: Path) -> None:
    has_place = any(set(pair) <= set(names) for pair in _PLACES)
    if "time" not in names or not (has_place or "depth" in names):
        hint = "--map time=UTC[iso] lat=Latitude[deg] lon=Longitude[deg] depth=z[m]"
        raise InputError([Problem("which columns have time and position, or depth?", str(path), hint=hint)])


def _parts(path: Path, head: bytes, names: Mapping[str, MappedName]) -> Iterator[dict[str, Array]]:
    columns = {quantity: each for quantity, each in names.items() if quantity not in _NO_COLUMNS}
    if head.startswith(MAGIC):
        with opened(path, "track") as data:
            yield from _of_netcdf(Variables(data), columns)
        return
    wanted = [each.name for each in columns.values()]
    for chunk in text_chunks(path, wanted):
        yield _of_text(chunk, columns)


def _of_text(chunk: pd.DataFrame, columns: Mapping[str, MappedName]) -> dict[str, Array]:
    found: dict[str, Array] = {}
    for quantity, each in columns.items():
        words = chunk[each.name]
        if quantity == "time":
            found["t"] = times(words, each.unit)
        elif quantity in _ANGLES:
            found[quantity] = angles(words, each.unit)
        elif quantity == "depth" and each.unit in _DEPTH_UNITS:
            found[quantity] = quantities(words, "", "") * _DEPTH_UNITS[each.unit]
        else:
            found[quantity] = quantities(words, each.unit, QUANTITIES[quantity])
    return found


def _of_netcdf(file: Variables, columns: Mapping[str, MappedName]) -> list[dict[str, Array]]:
    """Variables as named, a part for each dimension that they lie along, with that dimension's clock."""
    found = {quantity: file.find(each.name) for quantity, each in columns.items()}
    missing = [columns[quantity].name for quantity, name in found.items() if name is None]
    if missing:
        raise ValueError(f"no variable {', '.join(missing)}; it has {', '.join(sorted(file)[:20])}")
    names = {quantity: name for quantity, name in found.items() if name is not None}
    parts: dict[str, dict[str, Array]] = {}
    for quantity, name in names.items():
        if quantity == "time":
            continue
        part = parts.setdefault(file.dimension(name), {})
        if "t" not in part:
            is_same = file.dimension(names["time"]) == file.dimension(name)
            part["t"] = _netcdf_times(file, names["time"], columns["time"].unit) if is_same else file.clock(name)
        part[quantity] = file.numbers(name) * _netcdf_factor(quantity, columns[quantity].unit)
    return list(parts.values())


def _netcdf_times(file: Variables, name: str, unit: str) -> Array:
    if " since " in file.unit(name):
        return file.epoch(name)
    return times(pd.Series(file.numbers(name).astype(str)), "epoch" if unit == "iso" else unit)


def _netcdf_factor(quantity: str, unit: str) -> float:
    if quantity == "depth" and unit in _DEPTH_UNITS:
        return _DEPTH_UNITS[unit]
    wanted = QUANTITIES[quantity]
    return 1.0 if unit == wanted or not wanted else unit_factor(unit, wanted)


def _track(files: Sequence[Path], store: ColumnStore, given: Fixes, options: ReadOptions) -> Track:
    names, t = options.names, store["t"]
    heading = "heading_true" if "heading_true" in names else "heading"

    def channel(quantity: str) -> Series:
        return series(t, store[quantity]) if quantity in names else Series()

    track = Track(
        name=files[0].stem,
        format="track",
        fixes=given,
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
    origin, given = origin_of(names.get("origin")), len(track.fixes) > 0
    own = _places(store, names, "", track.fixes, origin) or Positions()
    if not given:
        track = replace(track, fixes=_own_fixes(own, store, names))
    reckoned = _places(store, names, "dr_", track.fixes, origin)
    if reckoned is not None:
        return replace(track, reckoned=reckoned, reckoning="the track's own dead-reckoned columns")
    if given and len(own):
        return replace(track, reckoned=own, reckoning="the table's positions, with fixes of other files")
    return _split(track, own)


def _places(
    store: ColumnStore, names: Mapping[str, MappedName], prefix: str, known: Fixes, origin: tuple[float, float] | None
) -> Positions | None:
    if f"{prefix}lat" in names and f"{prefix}lon" in names:
        return positions(store["t"], store[f"{prefix}lat"], store[f"{prefix}lon"])
    if f"{prefix}x" in names and f"{prefix}y" in names:
        return plane_positions(store["t"], store[f"{prefix}x"], store[f"{prefix}y"], known, origin)
    return None


def _own_fixes(own: Positions, store: ColumnStore, names: Mapping[str, MappedName]) -> Fixes:
    """Fixes of the table's own positions, with the qualities of the same rows."""
    rows = np.searchsorted(store["t"], own.t)
    quality = {name: store[quantity][rows] for name, quantity in _QUALITIES.items() if quantity in names}
    return fixes(own.t, own.latitude, own.longitude, **quality)


def _marks(t: Array, values: Array) -> tuple[float, ...]:
    """Times at which a mark rises from nothing or 0."""
    up = np.nan_to_num(values) > 0.0
    return tuple(float(each) for each in t[up & ~np.append(False, up[:-1])])


def _split(track: Track, own: Positions) -> Track:
    """Split the vehicle's own positions into dead-reckoned ones, under water, and fixes, at the surface.

    At the surface the position is dead-reckoned until it jumps to the fix: fixes count from the greatest step on that
    the position makes while the vehicle comes up and stays there. Where positions are blank under water, or no depth
    tells it apart, all are fixes.
    """
    if not len(track.depth) or not len(own):
        return track
    depths = depths_of(track.depth, LegRules())
    under = track.depth.at(own.t) > depths.surface
    if not under.any():
        return track
    is_fix = ~under
    starts = np.flatnonzero(under[:-1] & ~under[1:]) + 1
    for start in starts:
        after = np.flatnonzero(under[start:])
        end = start + int(after[0]) if len(after) else len(own)
        rows = slice(start - 1, end)
        steps = np.hypot(*displacement(own.latitude[rows][:-1], own.longitude[rows][:-1], own.latitude[rows][1:],
                                       own.longitude[rows][1:]))  # fmt: skip
        is_fix[start : start + int(np.argmax(steps))] = False
    notice = (
        "one position alone: it is taken for a fix at the surface, from its greatest step on, and as dead-reckoned else"
    )
    return replace(
        track,
        fixes=track.fixes[np.isin(track.fixes.t, own.t[is_fix])],
        reckoned=Positions(own.t[~is_fix], own.latitude[~is_fix], own.longitude[~is_fix]),
        reckoning="the table's positions under water",
        notices=(*track.notices, notice),
    )


IMPORTERS = (Importer("track", "tables and NetCDF with --map, GPX, NMEA", recognises, read),)
