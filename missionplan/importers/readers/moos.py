"""MOOS: `alog` files of pLogger, with the variables named by `--map`.

Lines are not in the order of time, and mail is repeated when a client registers. Times count from LOGSTART, which is
the clock times MOOSTimeWarp. Format: MOOS-IvP, ivp/src/app_alogscan and the documentation of pLogger. The plan is the
helm's behaviour file, of which pLogger keeps a copy beside the log (`*._bhv`).
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from datetime import datetime
from pathlib import Path

import numpy as np

from missionplan.arrays import Array
from missionplan.errors import InputError, Problem
from missionplan.importers.dives import split_at_surface
from missionplan.importers.geodesy import origin_of, plane_positions
from missionplan.importers.importer import ChannelStore, Identity, Importer, ReadOptions, Samples, SourceLog, unpacked
from missionplan.importers.mapping import QUANTITIES, MappedName, mapped, unit_factor
from missionplan.importers.track import Break, Fixes, Positions, Track, fixes, positions

_USUAL = {
    "lat": ("GPS_LATITUDE", "GPS_LAT"),
    "lon": ("GPS_LONGITUDE", "GPS_LONG", "GPS_LON"),
    "dr_lat": ("NAV_LAT", "NAV_LATITUDE"),
    "dr_lon": ("NAV_LONG", "NAV_LON", "NAV_LONGITUDE"),
    "dr_x": ("NAV_X",),
    "dr_y": ("NAV_Y",),
    "depth": ("NAV_DEPTH",),
    "heading_true": ("NAV_HEADING",),
    "pitch": ("NAV_PITCH[rad]",),
    "speed": ("NAV_SPEED",),
    "hdop": ("GPS_HDOP",),
    "satellites": ("GPS_SAT", "GPS_SATS", "GPS_NUM_SATS", "GPS_SATELLITES"),
}
_REPORTED = {"dr_lat": "LAT", "dr_lon": "LON", "dr_x": "X", "dr_y": "Y", "depth": "DEP", "heading_true": "HDG",
             "speed": "SPD"}  # fmt: skip
"""Parts of the vehicle's own node report, which stand for what is not logged by itself."""
_REPORT = b"NODE_REPORT_LOCAL"
_LOG_START = re.compile(rb"%%\s*LOG ?START\s+([\d.eE+]+)")
_OPENED = re.compile(rb"%%\s*FILE OPENED ON\s+(\w+ +\w+ +\d+ +\d+:\d+:\d+ +\d+)")
_COMMUNITY = re.compile(rb"\sMOOSDB_(\w+)")
_BEHAVIOUR = re.compile(r"\b(BHV_PeriodicSurface|BHV_Timer)\b.*?\{(.*?)\}", re.DOTALL)
_PERIOD = {
    "BHV_PeriodicSurface": re.compile(r"^\s*period\s*=\s*([\d.]+)", re.MULTILINE),
    "BHV_Timer": re.compile(r"(?=.*^\s*name\s*=\s*interval_).*^\s*duration\s*=\s*([\d.]+)", re.MULTILINE | re.DOTALL),
}
"""What ends a leg: the behaviour's own period, or the timer of that name in the files that `export` writes."""
_LONGEST_PERIOD = 86400.0
"""A longer one never ends [s]."""
_HEAD = 65536
_NEAR = 2.0 * 86400.0
"""Difference of two clocks that are the same: zones of time [s]."""
_FIRST, _LAST = 946684800.0, 4102444800.0
"""Years 2000 and 2100: dates between them are possible [s]."""


def recognises(path: Path, head: bytes) -> bool:
    """Whether a file is an `alog`."""
    return path.name.lower().endswith((".alog", ".alog.gz")) or (
        head.startswith(b"%%") and _LOG_START.search(head) is not None
    )


def identity(path: Path) -> Identity:
    """Community of the database that was logged."""
    with unpacked(path) as stream:
        match = _COMMUNITY.search(stream.read(_HEAD))
    return Identity(match[1].decode() if match else "")


def read(files: Sequence[Path], options: ReadOptions, log: SourceLog) -> Track:
    """Read `alog` files as one track."""
    names = _names(options.names)
    store = ChannelStore()
    starts: dict[Path, tuple[float, float]] = {}
    for path in files:
        with log.reading(path):
            starts[path] = _head(path)
    log.read.clear()  # each is noted again when it is read
    in_order = sorted(starts, key=lambda path: starts[path])
    shift, notices = _date(*starts[in_order[0]]) if in_order else (0.0, ())
    breaks: list[Break] = []
    for number, path in enumerate(log.each(in_order)):
        with log.reading(path):
            began = _add(store, path, names, starts[path][0] + shift)
            breaks += [Break(began, "the log was begun anew", at_surface_too=False)] if number else []
    gps_fixes, origin = _fixes(store), origin_of(options.names.get("origin")) or _planned_origin(files)
    used = [pair for pair in (("dr_lat", "dr_lon"), ("dr_x", "dr_y")) if pair[0] in store]
    quantities = {quantity: name.decode() for name, quantity in reversed(names.items())}
    track = Track(
        name=f"MOOS {files[0].stem}",
        format="moos",
        fixes=gps_fixes,
        reckoning=f"the vehicle's own ({', '.join(quantities[quantity] for quantity in used[0])})"
        if used
        else "none is logged",
        depth=store.series("depth", _factor(options.names, "depth")),
        pitch=store.series("pitch", _factor(options.names, "pitch", "rad")),
        heading=store.series("heading_true" if "heading_true" in store else "heading"),
        heading_from="true" if "heading_true" in store else "magnetic",
        speed=store.series("speed", _factor(options.names, "speed")),
        declination=store.series("declination"),
        breaks=tuple(breaks),
        marks=tuple(float(t) for t in store.series("mark").t),
        planned=_planned(files),
        notices=notices,
    )
    line = _reckoned(store, origin, gps_fixes)
    if len(gps_fixes):
        return replace(track, reckoned=line)
    return split_at_surface(replace(track, fixes=fixes(line.t, line.latitude, line.longitude)), line)


def _names(mapping: Mapping[str, MappedName]) -> dict[bytes, str]:
    """Quantities by the variable's name in capitals; what is given takes the place of the usual ones."""
    usual = {mapped(quantity, name).name: quantity for quantity, names in _USUAL.items() for name in names
             if quantity not in mapping}  # fmt: skip
    return {name.upper().encode(): quantity for name, quantity in usual.items()} | {
        variable.name.upper().encode(): quantity for quantity, variable in mapping.items()
    }


def _head(path: Path) -> tuple[float, float]:
    """LOGSTART of a file, and when it was opened by the computer's clock; nan where that is no date.

    Raises ValueError when it has no LOGSTART.
    """
    with unpacked(path) as stream:
        head = stream.read(_HEAD)
    start, opened = _LOG_START.search(head), _OPENED.search(head)
    if start is None:
        raise ValueError("no LOGSTART in its head: its times count from nothing known")
    try:
        words = " ".join((opened[1] if opened else b"").decode().split())
        clock = datetime.strptime(f"{words} +0000", "%a %b %d %H:%M:%S %Y %z").timestamp()
    except ValueError:
        return float(start[1]), np.nan
    return float(start[1]), clock if _FIRST < clock < _LAST else np.nan


def _date(start: float, opened: float) -> tuple[float, tuple[str, ...]]:
    """What turns the first file's LOGSTART, and with it all others, into seconds since 1970, and what is said of it.

    Under time warp LOGSTART is the clock times the warp, and so are all times within the log.
    """
    warp = start / opened if np.isfinite(opened) else 1.0
    if abs(start - opened) > _NEAR and abs(start / max(round(warp, 1), 0.1) - opened) <= _NEAR:
        warp = round(warp, 1)
        return start / warp - start, (
            f"the log runs under a time warp of {warp:g}: times count from when it was begun",
        )
    if _FIRST < start < _LAST:
        return 0.0, ()
    notice = (
        f"LOGSTART, {start:.0f} s, is no date (a time warp, not stated): times count from the log's start, as if "
        "that were 1970-01-01"
    )
    return -start, (notice,)


def _add(store: ChannelStore, path: Path, names: Mapping[bytes, str], start: float) -> float:
    """Read one file; returns when it begins [s]."""
    samples: dict[str, Samples] = {}
    with unpacked(path) as stream:
        for line in stream:
            cells = line.split(None, 3)
            if len(cells) < 4 or line.startswith(b"%"):
                continue
            name = cells[1].upper()
            try:
                if name in names:
                    reading = float(cells[0]), float(cells[3].strip(b'"\r\n '))
                    samples.setdefault(names[name], Samples(["t", "value"])).add(*reading)
                elif name == _REPORT:
                    for quantity, value in _of_report(cells[3]):
                        samples.setdefault(f"report {quantity}", Samples(["t", "value"])).add(float(cells[0]), value)
            except ValueError:
                continue
    for quantity in _REPORTED:
        reported = samples.pop(f"report {quantity}", None)
        if reported is not None:
            samples.setdefault(quantity, reported)
    if not samples:
        raise ValueError(f"none of the variables {', '.join(sorted(name.decode() for name in names))}")
    for quantity, readings in samples.items():
        store.add(quantity, readings["t"] + start, readings["value"])
    return start + min(float(readings["t"].min()) for readings in samples.values())


def _of_report(text: bytes) -> Iterator[tuple[str, float]]:
    pairs = dict(part.strip().split("=", 1) for part in text.decode("latin-1").upper().split(",") if "=" in part)
    for quantity, name in _REPORTED.items():
        if name in pairs:
            yield quantity, float(pairs[name])


def _beside(files: Sequence[Path], *endings: str) -> str:
    """Text of the files with one of some endings that the logger copied beside the logs."""
    folders = dict.fromkeys(path.parent for path in files)
    copies = sorted(path for folder in folders for path in folder.iterdir() if path.name.endswith(endings))
    return re.sub(r"//.*", "", "\n".join(path.read_text("utf-8", errors="replace") for path in copies))


def _planned_origin(files: Sequence[Path]) -> tuple[float, float] | None:
    """Origin of the plane by the mission file beside the logs: LatOrigin, LongOrigin."""
    text = _beside(files, "moos", "moos++")
    place = [re.search(rf"^\s*{name}\s*=\s*(-?[\d.]+)", text, re.MULTILINE | re.IGNORECASE)
             for name in ("LatOrigin", "LongOrigin")]  # fmt: skip
    return (float(place[0][1]), float(place[1][1])) if place[0] and place[1] else None


def _planned(files: Sequence[Path]) -> float | None:
    """Period of the helm's surfacing by the behaviour files beside the logs [s]: the shortest of them."""
    bodies = _BEHAVIOUR.findall(_beside(files, "bhv", "bhv++"))
    periods = [float(match[1]) for kind, body in bodies if (match := _PERIOD[kind].search(body))]
    return min((period for period in periods if 0.0 < period < _LONGEST_PERIOD), default=None)


def _factor(mapping: Mapping[str, MappedName], quantity: str, usual: str = "") -> float:
    unit, wanted = mapping[quantity].unit if quantity in mapping else usual, QUANTITIES[quantity]
    return 1.0 if not unit or unit == wanted or not wanted else unit_factor(unit, wanted)


def _fixes(store: ChannelStore) -> Fixes:
    """Fixes: latitude and longitude are published one after the other, each joins the longitude nearest in time."""
    latitude = store.series("lat")
    quality = {name: _nearest(store, key, latitude.t) for name, key in
               (("hdop", "hdop"), ("satellites", "satellites"), ("accuracy", "hacc"), ("valid", "valid"))}  # fmt: skip
    there = fixes(latitude.t, latitude.values, _nearest(store, "lon", latitude.t), **quality)
    if len(latitude) and not len(there):
        message = f"no position that can be one in {len(latitude)} latitudes, such as {latitude.values[0]:g}"
        raise InputError([Problem(message, key="lat", hint="are they in another unit? --map lat=NAME[ddmm] says it")])
    return there


def _nearest(store: ChannelStore, name: str, t: Array, within: float = 1.0) -> Array:
    """Value of a channel nearest in time; nan beyond `within` [s]."""
    channel = store.series(name)
    if not len(channel) or not len(t):
        return np.full(len(t), np.nan)
    after = np.clip(np.searchsorted(channel.t, t), 0, len(channel) - 1)
    before = np.maximum(after - 1, 0)
    best = np.where(np.abs(channel.t[before] - t) < np.abs(channel.t[after] - t), before, after)
    return np.where(np.abs(channel.t[best] - t) <= within, channel.values[best], np.nan)


def _reckoned(store: ChannelStore, origin: tuple[float, float] | None, fixes: Fixes) -> Positions:
    if "dr_lat" in store:
        north = store.series("dr_lat")
        return positions(north.t, north.values, _nearest(store, "dr_lon", north.t))
    east = store.series("dr_x")
    return plane_positions(east.t, east.values, _nearest(store, "dr_y", east.t), fixes, origin)


IMPORTERS = (Importer("moos", "MOOS alog, variables by --map", recognises, read, identify=identity),)
