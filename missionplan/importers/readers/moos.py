"""MOOS: `alog` files of pLogger, with the variables named by `--map`."""

import re
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from missionplan.arrays import Array
from missionplan.importers.importer import Importer, ReadOptions, SourceLog
from missionplan.importers.mapping import QUANTITIES, MappedName, mapped
from missionplan.importers.sourcefiles.channels import ChannelStore, Samples
from missionplan.importers.sourcefiles.columns import clock_jumps
from missionplan.importers.sourcefiles.conversions import unit_factor
from missionplan.importers.sourcefiles.plane import origin_of, plane_positions
from missionplan.importers.track import Break, Fixes, Positions, Track, fixes, positions

_USUAL = {
    "lat": "GPS_LATITUDE",
    "lon": "GPS_LONGITUDE",
    "dr_lat": "NAV_LAT",
    "dr_lon": "NAV_LONG",
    "dr_x": "NAV_X",
    "dr_y": "NAV_Y",
    "depth": "NAV_DEPTH",
    "heading_true": "NAV_HEADING",
    "pitch": "NAV_PITCH[rad]",
    "speed": "NAV_SPEED",
    "hdop": "GPS_HDOP",
    "satellites": "GPS_SAT",
}
_LOG_START = re.compile(rb"%%\s*LOGSTART\s+([\d.]+)")


def recognises(path: Path, head: bytes) -> bool:
    """Whether a file is an `alog`."""
    return path.suffix == ".alog" or (head.startswith(b"%%") and _LOG_START.search(head) is not None)


def read(files: Sequence[Path], options: ReadOptions, log: SourceLog) -> Track:
    """Read `alog` files as one track."""
    names = {quantity: mapped(quantity, name) for quantity, name in _USUAL.items()} | dict(options.names)
    store = ChannelStore()
    breaks: list[Break] = []
    for path in log.each(sorted(files)):
        with log.reading(path):
            breaks += _add(store, path, {each.name: quantity for quantity, each in names.items()})
    found = _fixes(store, names)
    return Track(
        name=files[0].stem,
        format="moos",
        fixes=found,
        reckoned=_reckoned(store, names, found),
        reckoning="the vehicle's own (" + ", ".join(_used(store, names)) + ")"
        if _used(store, names)
        else "none is logged",
        depth=store.series("depth", _factor(names, "depth")),
        pitch=store.series("pitch", _factor(names, "pitch")),
        heading=store.series("heading_true" if "heading_true" in store else "heading"),
        heading_from="true" if "heading_true" in store else "magnetic",
        speed=store.series("speed", _factor(names, "speed")),
        declination=store.series("declination"),
        breaks=tuple(breaks),
        marks=tuple(float(t) for t in store.series("mark").t),
    )


def _add(store: ChannelStore, path: Path, wanted: Mapping[str, str]) -> list[Break]:
    """Read one file; its times count from LOGSTART."""
    samples: dict[str, Samples] = {}
    names = {name.encode(): quantity for name, quantity in wanted.items()}
    start, times = None, Samples(["t"])
    with path.open("rb") as stream:
        for line in stream:
            if line.startswith(b"%"):
                found = _LOG_START.match(line)
                start = float(found[1]) if found else start
                continue
            cells = line.split(None, 3)
            if len(cells) < 4 or cells[1] not in names:
                continue
            try:
                t, value = float(cells[0]), float(cells[3])
            except ValueError:
                continue
            samples.setdefault(names[cells[1]], Samples(["t", "value"])).add(t, value)
            times.add(t)
    if start is None:
        raise ValueError("no LOGSTART in its head: its times count from nothing known")
    if not samples:
        raise ValueError(f"none of the variables {', '.join(sorted(wanted))}")
    for quantity, each in samples.items():
        store.add(quantity, each["t"] + start, each["value"])
    return clock_jumps(times["t"] + start)


def _factor(names: Mapping[str, MappedName], quantity: str) -> float:
    unit, wanted = names[quantity].unit, QUANTITIES[quantity]
    return 1.0 if unit == wanted or not wanted else unit_factor(unit, wanted)


def _fixes(store: ChannelStore, names: Mapping[str, MappedName]) -> Fixes:
    """Fixes: latitude and longitude are published one after the other, each joins the longitude nearest in time."""
    t, latitude = store.joined("lat")
    longitude = _nearest(store, "lon", t)
    quality = {name: _nearest(store, key, t) for name, key in (("hdop", "hdop"), ("satellites", "satellites"))}
    return fixes(
        t, latitude, longitude, **quality, accuracy=_nearest(store, "hacc", t), valid=_nearest(store, "valid", t)
    )


def _nearest(store: ChannelStore, name: str, t: Array, within: float = 1.0) -> Array:
    """Value of a channel nearest in time; nan beyond `within` [s]."""
    known = store.series(name)
    if not len(known) or not len(t):
        return np.full(len(t), np.nan)
    after = np.clip(np.searchsorted(known.t, t), 0, len(known) - 1)
    before = np.maximum(after - 1, 0)
    best = np.where(np.abs(known.t[before] - t) < np.abs(known.t[after] - t), before, after)
    return np.where(np.abs(known.t[best] - t) <= within, known.values[best], np.nan)


def _used(store: ChannelStore, names: Mapping[str, MappedName]) -> list[str]:
    pair = ("dr_lat", "dr_lon") if "dr_lat" in store else ("dr_x", "dr_y") if "dr_x" in store else ()
    return [names[each].name for each in pair]


def _reckoned(store: ChannelStore, names: Mapping[str, MappedName], found: Fixes) -> Positions:
    if "dr_lat" in store:
        t, latitude = store.joined("dr_lat")
        return positions(t, latitude, _nearest(store, "dr_lon", t))
    t, east = store.joined("dr_x")
    return plane_positions(t, east, _nearest(store, "dr_y", t), found, origin_of(names.get("origin")))


IMPORTER = Importer("moos", "MOOS alog, variables by --map", recognises, read)
