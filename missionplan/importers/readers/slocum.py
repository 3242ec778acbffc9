"""Slocum gliders: binary flight (dbd, mbd, sbd) and science (ebd, nbd, tbd) files, packed or not, by dbdreader.

dbdreader is licensed under the GPL-3: it is an extra of its own, and imported only when such a file is read. The
position is the vehicle's own dead reckoning, `m_lat` and `m_lon`; a fix is a new `m_gps_lat` and `m_gps_lon`.
"""

import math
import re
import tempfile
from collections.abc import Sequence
from pathlib import Path
from types import ModuleType

import numpy as np

from missionplan.arrays import Array
from missionplan.errors import InputError, Problem
from missionplan.importers.importer import (
    DAMAGED,
    ChannelStore,
    Identity,
    Importer,
    ReadOptions,
    SourceLog,
    needed_module,
)
from missionplan.importers.track import Break, Fixes, Track, fixes, positions

_FLIGHT = ("dbd", "mbd", "sbd", "dcd", "mcd", "scd")
_SCIENCE = ("ebd", "nbd", "tbd", "ecd", "ncd", "tcd")
_OF_FLIGHT = (
    "m_gps_lat", "m_gps_lon", "m_gps_status", "m_gps_num_satellites", "m_gps_uncertainty", "m_gps_mag_var",
    "m_lat", "m_lon", "m_depth", "m_pitch", "m_heading", "m_water_vx", "m_water_vy", "u_use_current_correction",
    "m_present_secs_into_mission",
)  # fmt: skip
_OF_SCIENCE = ("sci_water_pressure",)
_HEADER = 8192
"""Bytes within which the header of a file ends."""
_BAR = 10.0
"""Depth over pressure in the sea, to 1 % [m/bar]."""
_NAME = re.compile(r"(.+)-\d{4}-\d{3}-\d+-\d+$")
_DEGREES = math.degrees(1.0)
SHORTEST = 1800.0
"""Shortest leg that counts by default [s]: decimated files hold a dead-reckoned position only every few minutes."""


def recognises(path: Path, head: bytes) -> bool:
    """Whether a file is one of a Slocum's, by its name or its first line."""
    is_text = b"DBD_ASC" in head[:80]  # a table of dbd2asc, for `--map`
    return not is_text and (path.suffix[1:].lower() in (*_FLIGHT, *_SCIENCE) or head.startswith(b"dbd_label:"))


def identity(path: Path) -> Identity:
    """Vehicle that a file's header names, ``full_filename: maria-2022-164-7-0``, or its own name."""
    filename = re.search(rb"full_filename:\s*(\S+)", _header(path))
    matched = _NAME.match(filename[1].decode("latin-1") if filename else path.stem)
    return Identity(matched[1] if matched else "")


def _library(name: str) -> ModuleType:
    """Import the package, which makes a folder at home for lists of sensors as it is imported.

    Raises InputError when it is not installed, or that folder cannot be made.
    """
    try:
        return needed_module(name, "slocum", "slocum")
    except FileExistsError:  # another process has made the folder meanwhile
        return needed_module(name, "slocum", "slocum")
    except OSError as error:
        message = f"the package dbdreader keeps lists of sensors in a folder at home, which cannot be made: {error}"
        raise InputError([Problem(message, hint="set HOME to a folder that can be written to")]) from None


def _header(path: Path) -> bytes:
    """First bytes of a file, in which its header stands; unpacked where it is packed.

    Raises OSError or RuntimeError when it cannot be read, or not unpacked.
    """
    if path.suffix[2:3].lower() != "c":
        with path.open("rb") as stream:
            return stream.read(_HEADER)
    library = _library("dbdreader.decompress")
    with library.Decompressor(str(path)) as packed:
        return bytes(next(packed.decompressed_blocks(1), b""))[:_HEADER]


def read(files: Sequence[Path], options: ReadOptions, log: SourceLog) -> Track:
    """Read the files as one track."""
    library = _library("dbdreader")
    store = ChannelStore()
    with tempfile.TemporaryDirectory() as cache:
        _link_sensor_lists(library, Path(cache), files, options.cache)
        for path in log.each(sorted(files, key=lambda path: (_is_factored(path), path))):
            with log.reading(path, library.DbdError):
                _add(store, library, path, cache)
    if not log.read and log.passed_over and all("ache file" in problem.message for problem in log.passed_over):
        hint = "name the folder of the .cac files with --cache"
        raise InputError([Problem("no list of its sensors was found", log.passed_over[0].file, hint=hint)])
    t, latitude = store.joined("m_lat")
    return Track(
        name="Slocum glider",
        format="slocum",
        fixes=_fixes(store),
        reckoned=positions(t, latitude, store.at("m_lon", t)),
        reckoning="the vehicle's own (m_lat, m_lon)" if "m_lat" in store else "m_lat, m_lon are not logged",
        depth=store.series("m_depth") if "m_depth" in store else store.series("sci_water_pressure", _BAR),
        pitch=store.series("m_pitch", _DEGREES),
        heading=store.series("m_heading", _DEGREES),
        heading_from="magnetic",
        declination=store.series("m_gps_mag_var", -_DEGREES),
        current_east=store.series("m_water_vx"),
        current_north=store.series("m_water_vy"),
        breaks=tuple(_restarts(store)),
        shortest=SHORTEST,
    )


def _link_sensor_lists(library: ModuleType, folder: Path, files: Sequence[Path], cache: Path | None) -> None:
    """Gather the sensor lists under the names that the library looks for; what it writes goes there too."""
    places = [cache] if cache else list(dict.fromkeys(path.parent for path in files))
    for place in places:
        for sensor_list in sorted(path for path in place.rglob("*") if path.suffix.lower() in (".cac", ".ccc")):
            link = folder / f"{sensor_list.stem.lower()}.cac"
            if link.exists():
                continue
            if sensor_list.suffix.lower() == ".cac":
                link.symlink_to(sensor_list.resolve())
            else:
                with library.decompress.Decompressor(str(sensor_list)) as packed:
                    link.write_bytes(packed.decompress())


def _is_factored(path: Path) -> bool:
    """Whether a file refers to a list of its sensors elsewhere: those that hold one are read first."""
    try:
        match = re.search(rb"sensor_list_factored:\s*(\d)", _header(path))
    except DAMAGED:
        return True  # it is told when it is read
    return match is not None and match[1] == b"1"


def _check_header(path: Path) -> None:
    """Refuse a file whose header is cut off: the library would look for the rest of it for ever.

    Raises ValueError when it is.
    """
    lines = _header(path).split(b"\n")
    if not lines[0].startswith(b"dbd_label"):
        return  # no such file: the library says so
    tag_count = next((line.partition(b":")[2] for line in lines if line.startswith(b"num_ascii_tags:")), b"")
    if not tag_count.strip().isdigit() or int(tag_count) >= len(lines):
        raise ValueError("its header is cut off")


def _add(store: ChannelStore, library: ModuleType, path: Path, cache: str) -> None:
    _check_header(path)
    file = library.DBD(str(path), cacheDir=cache)
    try:
        names = [name for name in (*_OF_FLIGHT, *_OF_SCIENCE) if name in file.parameterNames]
        for name in names:
            t, values = file.get(name, discardBadLatLon=True)
            small = values.dtype == np.float64 and not name.endswith(("_lat", "_lon", "_mission"))
            store.add(name, t, values.astype(np.float32) if small else values)
    finally:
        file.close()


def _fixes(store: ChannelStore) -> Fixes:
    t, latitude = store.joined("m_gps_lat")
    status = store.at("m_gps_status", t)
    return fixes(
        t,
        latitude,
        store.at("m_gps_lon", t),
        accuracy=store.at("m_gps_uncertainty", t),
        satellites=store.at("m_gps_num_satellites", t),
        valid=np.where(np.isfinite(status), (status == 0.0).astype(float), np.nan),
    )


def _restarts(store: ChannelStore) -> list[Break]:
    """Moments at which the time since the mission's start begins again."""
    since = store.series("m_present_secs_into_mission")
    began: Array = since.t - since.values
    again = np.flatnonzero(np.diff(began) > 60.0)
    return [Break(float(since.t[k + 1]), "a new mission was started", at_surface_too=False) for k in again]


IMPORTERS = (
    Importer(
        "slocum", "Slocum dbd, mbd, sbd and their science files (dbdreader, GPL-3)", recognises, read, identify=identity
    ),
)
