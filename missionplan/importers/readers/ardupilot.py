"""ArduSub, and ArduPilot else: dataflash logs (`.BIN`) and telemetry logs (`.tlog`), these decoded by pymavlink.

Fixes are those of the receiver (`GPS`, `GPS_RAW_INT`: valid from a 3D fix on); the dead-reckoned position is the
autopilot's own estimate (`POS`, `GLOBAL_POSITION_INT`), else its metres north and east of the filter's origin (`XKF1`,
`LOCAL_POSITION_NED`). Messages: ardupilot.org, "Onboard Message Log Messages"; mavlink.io, "MAVLINK Common Message
Set".
"""

import math
import re
import struct
from collections import Counter
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import closing, redirect_stderr, redirect_stdout
from functools import partial
from io import StringIO
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np

from missionplan.arrays import Array
from missionplan.errors import InputError, Problem, shown
from missionplan.importers.geodesy import plane_positions
from missionplan.importers.importer import Identity, Importer, ReadOptions, Samples, SourceLog, needed_module
from missionplan.importers.track import Break, Positions, Track, fixes, positions, series

_MAGIC = b"\xa3\x95\x80"
"""First bytes of a dataflash log: the format of its formats."""
_STARTS = (b"\xfe", b"\xfd")
"""First byte of a MAVLink 1 or 2 packet, after a time of 8 bytes."""
_FORMATS = 0x80
"""Kind of the messages that tell the others' formats."""
_FORMAT = struct.Struct("<BB4s16s64s")
_PIECE = 1 << 20
_MICRO = 1e-6
_GPS_EPOCH = 315964800.0 - 18.0
"""1980-01-06, when receivers' weeks begin, less the leap seconds since (18 from 2017 on) [s]."""
_LETTERS = {
    "a": ("64s", 1), "b": ("b", 1), "B": ("B", 1), "h": ("h", 1), "H": ("H", 1), "i": ("i", 1), "I": ("I", 1),
    "f": ("f", 1), "d": ("d", 1), "g": ("e", 1), "n": ("4s", 1), "N": ("16s", 1), "Z": ("64s", 1), "M": ("B", 1),
    "c": ("h", 0.01), "C": ("H", 0.01), "e": ("i", 0.01), "E": ("I", 0.01), "L": ("i", 1e-7), "q": ("q", 1),
    "Q": ("Q", 1),
}  # fmt: skip
"""Letter of a field to its packing and the factor of its numbers (ArduPilot, libraries/AP_Logger/LogStructure.h)."""
_PROCESSOR = re.compile(rb"\b([0-9A-F]{8} [0-9A-F]{8} [0-9A-F]{8})\b")
_BEGINNING = 1_000_000
"""Bytes in which it stands."""
_SUBMARINE = 12
_NO_VEHICLES = (6, 18, 26, 27, 30)
"""MAV_TYPE of ground stations, companion computers, gimbals, ADS-B and cameras."""
_KINDS = {1: "an aeroplane", 2: "a multicopter", 3: "a multicopter", 4: "a helicopter", 10: "a rover", 11: "a boat",
          13: "a multicopter", 14: "a multicopter"}  # fmt: skip
_FIRMWARE = {"arducopter": 2, "arduplane": 1, "ardurover": 10, "rover": 10, "ardusub": _SUBMARINE}
_FIX_3D = 3
_E7 = 1e-7
_COLUMNS = {
    "fix": ("t", "lat", "lon", "hdop", "accuracy", "satellites", "valid"),
    "place": ("t", "lat", "lon"),
    "plane": ("t", "north", "east"),
    "depth": ("t", "depth"),
    "barometer": ("t", "depth"),
    "attitude": ("t", "heading", "pitch"),
    "origin": ("t", "lat", "lon"),
    "boot": ("t", "since"),
}


class _Found:
    """Readings by kind, and what the messages say of the vehicle."""

    def __init__(self) -> None:
        self.samples = {name: Samples(columns) for name, columns in _COLUMNS.items()}
        self.kinds: Counter[int] = Counter()
        self.told: Counter[str] = Counter()


def recognises(path: Path, head: bytes) -> bool:
    """Whether a file is a dataflash or a telemetry log."""
    return head.startswith(_MAGIC) or (path.suffix.lower() == ".tlog" and head[8:9] in _STARTS)


def identity(path: Path) -> Identity:
    """Number of the autopilot's processor, which a dataflash log begins with, ``Pixhawk1 003E0037 31365118 ...``."""
    with path.open("rb") as stream:
        match = _PROCESSOR.search(stream.read(_BEGINNING))
    return Identity(match[1].decode().replace(" ", "") if match else "")


def read(files: Sequence[Path], options: ReadOptions, log: SourceLog) -> Track:
    """Read logs as one track.

    Raises InputError when they are of several vehicles of which none is chosen, or of one that does not dive.
    """
    store = _Found()
    for path in log.each(sorted(files)):
        with log.reading(path):
            if path.suffix.lower() == ".tlog":
                library = needed_module("pymavlink.mavutil", "ardupilot", "ardupilot")
                _each_packet(library, path, _TAKEN, _system(library, path, options.vehicle), partial(_add, store))
            else:
                _each_record(path, _TAKEN, partial(_add, store))
    kind = store.kinds.most_common(1)[0][0] if store.kinds else _SUBMARINE
    if kind != _SUBMARINE:
        what = _KINDS.get(kind, f"a vehicle of MAV_TYPE {kind}")
        raise InputError([Problem(f"is the log of {what}, which does not dive", str(files[0]))])
    if log.read and not store.told["fix"]:
        message = "has no fix: no GPS message" if not store.told["gps"] else "has no fix: the GPS never had a position"
        raise InputError([Problem(message, str(log.read[0]), hint="legs go from fix to fix")])
    samples = store.samples
    attitude = samples["attitude"]
    depth = series(samples["depth"]["t"], samples["depth"]["depth"])
    depth = depth if len(depth) else series(samples["barometer"]["t"], samples["barometer"]["depth"])
    line, how = _reckoned(samples)
    return Track(
        name="ArduSub",
        format="ardupilot",
        fixes=fixes(
            **{
                ("latitude" if name == "lat" else "longitude" if name == "lon" else name): samples["fix"][name]
                for name in _COLUMNS["fix"]
            }
        ),
        reckoned=line,
        reckoning=how,
        depth=depth,
        pitch=series(attitude["t"], attitude["pitch"]),
        heading=series(attitude["t"], attitude["heading"] % 360.0),
        heading_from="true",
        breaks=tuple(_restarts(samples["boot"])),
    )


def _each_packet(
    library: ModuleType, path: Path, kinds: Collection[str], system: int | None, take: Callable[[str, float, Any], None]
) -> None:
    """Take each message of some kinds, of one vehicle; what the library prints is kept from the terminal."""
    with (
        redirect_stdout(StringIO()),
        redirect_stderr(StringIO()),
        closing(library.mavlink_connection(str(path))) as log,
    ):
        while (message := log.recv_match(type=list(kinds))) is not None:
            if system is None or message.get_srcSystem() == system:
                take(message.get_type(), float(message._timestamp), message)


def _each_record(path: Path, kinds: Collection[str], take: Callable[[str, float, Any], None]) -> None:
    """Take each message of some kinds of a dataflash log, from which all is read a piece at a time.

    Times count from the autopilot's start; the receiver's first fix tells when that was: before, its week may be any.
    """
    messages = (m for _, m in _records(path, ("GPS",)) if m.GWk > 0 and m.Status >= _FIX_3D)
    started = next((_gps_time(m) - _MICRO * m.TimeUS for m in messages), 0.0)
    for kind, message in _records(path, kinds):
        take(kind, started + _MICRO * getattr(message, "TimeUS", math.nan), message)


def _gps_time(message: Any) -> float:
    """Time since 1970 by the receiver's week and milliseconds [s]."""
    return _GPS_EPOCH + 604800.0 * float(message.GWk) + 1e-3 * float(message.GMS)


def _records(path: Path, kinds: Collection[str]) -> Iterator[tuple[str, Any]]:
    """Messages of a dataflash log, by the formats that it begins with; what is no message is passed over."""
    lengths, packings = [0] * 256, dict[int, _Packing]()
    lengths[_FORMATS] = _FORMAT.size + len(_MAGIC)
    with path.open("rb") as stream:
        data, place = b"", 0
        while piece := stream.read(_PIECE):
            data, place = data[place:] + piece, 0
            while place + len(_MAGIC) <= len(data):
                kind, length = data[place + 2], lengths[data[place + 2]]
                if data[place] != _MAGIC[0] or data[place + 1] != _MAGIC[1] or not length:
                    start = data.find(_MAGIC[:2], place + 1)
                    place = start if start >= 0 else len(data) - 1
                    continue
                if place + length > len(data):
                    break
                if kind == _FORMATS:
                    number, size, *words = _FORMAT.unpack_from(data, place + len(_MAGIC))
                    lengths[number] = size
                    name, letters, labels = (word.rstrip(b"\0").decode("latin-1") for word in words)
                    if name in kinds:
                        packings[number] = _Packing(name, letters, labels)
                elif kind in packings:
                    yield packings[kind].name, packings[kind].unpacked(data, place + len(_MAGIC))
                place += length


class _Packing:
    """How the messages of one kind are packed: a letter a field."""

    def __init__(self, name: str, letters: str, labels: str) -> None:
        self.name, self._labels = name, labels.split(",")
        self._struct = struct.Struct("<" + "".join(_LETTERS[letter][0] for letter in letters))
        self._factors = [_LETTERS[letter][1] for letter in letters]

    def unpacked(self, data: bytes, place: int) -> Any:
        """Fields as attributes, in their units."""
        values = self._struct.unpack_from(data, place)
        return SimpleNamespace(
            **{
                label: value.rstrip(b"\0").decode("latin-1") if isinstance(value, bytes) else value * factor
                for label, value, factor in zip(self._labels, values, self._factors, strict=False)
            }
        )


def _system(library: ModuleType, path: Path, wanted: str | None) -> int | None:
    """System of a telemetry log whose messages are read.

    Raises InputError with the list, when it holds several and none of them is chosen.
    """
    heard: Counter[int] = Counter()

    def hear(kind: str, t: float, message: Any) -> None:
        heard[message.get_srcSystem()] += int(message.type not in _NO_VEHICLES)

    _each_packet(library, path, ("HEARTBEAT",), None, hear)
    heard = +heard  # without those of which there are none
    if wanted is not None and wanted.isdigit() and int(wanted) in heard:
        return int(wanted)
    if len(heard) > 1 or (wanted is not None and heard):
        listed = ", ".join(f"{system} ({count} heartbeats)" for system, count in sorted(heard.items()))
        message = f"no system {shown(wanted)}; it holds {listed}" if wanted else f"holds several systems: {listed}"
        hint = f"choose one with --vehicle, such as --vehicle {min(heard)}"
        raise InputError([Problem(message, str(path), key="vehicle", hint=hint)])
    return next(iter(heard), None)


def _add(store: _Found, kind: str, t: float, m: Any) -> None:
    """Add what one message says, at its time since 1970 [s]."""
    if kind == "HEARTBEAT":
        store.kinds.update([int(m.type)] if m.type not in _NO_VEHICLES else [])
    elif kind == "MSG":
        firmware = str(m.Message).lower().split(" ")[0]
        store.kinds.update([_FIRMWARE[firmware]] if firmware in _FIRMWARE else [])
    elif getattr(m, _NUMBERED.get(kind, ""), 0) == 0:
        for name, values_of in _SAMPLED[kind]:
            values = values_of(m)
            if name == "fix":
                store.told["gps"] += 1
                store.told["fix"] += int(values[-1] == 1.0 and (values[0] != 0.0 or values[1] != 0.0))
            store.samples[name].add(t, *values)


def _raw_fix(m: Any) -> tuple[float, ...]:
    hdop = 0.01 * m.eph if m.eph != 65535 else math.nan
    accuracy = 1e-3 * getattr(m, "h_acc", 0) or math.nan
    satellites = float(m.satellites_visible) if m.satellites_visible != 255 else math.nan
    return m.lat * _E7, m.lon * _E7, hdop, accuracy, satellites, float(m.fix_type >= _FIX_3D)


_Sampled = tuple[str, Callable[[Any], tuple[float, ...]]]
_FILTER: _Sampled = ("plane", lambda m: (m.PN, m.PE))
_SAMPLED: Mapping[str, tuple[_Sampled, ...]] = {
    "GPS": (("fix", lambda m: (m.Lat, m.Lng, m.HDop, math.nan, float(m.NSats), float(m.Status >= _FIX_3D))),),
    "GPS_RAW_INT": (("fix", _raw_fix),),
    "POS": (("place", lambda m: (m.Lat, m.Lng)),),
    "GLOBAL_POSITION_INT": (
        ("place", lambda m: (m.lat * _E7, m.lon * _E7)),
        ("depth", lambda m: (-1e-3 * m.relative_alt,)),
    ),
    "XKF1": (_FILTER,),
    "NKF1": (_FILTER,),
    "LOCAL_POSITION_NED": (("plane", lambda m: (m.x, m.y)),),
    "CTUN": (("depth", lambda m: (-getattr(m, "Alt", math.nan),)),),
    "BARO": (("barometer", lambda m: (-m.Alt,)),),
    "ATT": (("attitude", lambda m: (m.Yaw, m.Pitch)),),
    "ATTITUDE": (
        ("attitude", lambda m: (math.degrees(m.yaw), math.degrees(m.pitch))),
        ("boot", lambda m: (1e-3 * m.time_boot_ms,)),
    ),
    "ORGN": (("origin", lambda m: (m.Lat, m.Lng)),),
    "GPS_GLOBAL_ORIGIN": (("origin", lambda m: (m.latitude * _E7, m.longitude * _E7)),),
}
"""Of a message of each kind, to which samples it adds, and their values but the time."""
_NUMBERED = {"GPS": "I", "BARO": "I", "XKF1": "C", "NKF1": "C", "ORGN": "Type"}
"""Field with the number of the receiver, barometer, filter's core or origin, of which the first is taken."""
_TAKEN = ("HEARTBEAT", "MSG", *_SAMPLED)


def _reckoned(samples: dict[str, Samples]) -> tuple[Positions, str]:
    place, plane, origin = samples["place"], samples["plane"], samples["origin"]
    line = positions(place["t"], place["lat"], place["lon"])
    if len(line):
        return line, "the autopilot's own estimate (POS, GLOBAL_POSITION_INT)"
    if not len(plane) or not len(origin):
        return Positions(), "the autopilot logs no position of its own"
    first = float(origin["lat"][0]), float(origin["lon"][0])
    none = fixes(np.empty(0), np.empty(0), np.empty(0))
    line = plane_positions(plane["t"], plane["east"], plane["north"], none, first)
    return line, "the autopilot's filter (north, east)"


def _restarts(boot: Samples) -> Iterator[Break]:
    """Moments at which the time since the autopilot's start begins again."""
    since: Array = boot["since"]
    for k in np.flatnonzero(np.diff(since) < -1.0):
        yield Break(float(boot["t"][k + 1]), "the autopilot was started anew", at_surface_too=False)


IMPORTERS = (
    Importer(
        "ardupilot", "ArduSub dataflash and telemetry logs", recognises, read, identify=identity, is_choosing=True
    ),
)
