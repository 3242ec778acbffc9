"""ArduSub, and ArduPilot else: dataflash logs (`.BIN`) and telemetry logs (`.tlog`), decoded by pymavlink.

Fixes are those of the receiver (`GPS`, `GPS_RAW_INT`: valid from a 3D fix on); the dead-reckoned position is the
autopilot's own estimate (`POS`, `GLOBAL_POSITION_INT`), else its metres north and east of the filter's origin (`XKF1`,
`LOCAL_POSITION_NED`). Messages: ardupilot.org, "Onboard Message Log Messages"; mavlink.io, "MAVLINK Common Message
Set".
"""

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from missionplan.arrays import Array
from missionplan.errors import InputError, Problem, shown
from missionplan.importers.geodesy import plane_positions
from missionplan.importers.importer import Importer, ReadOptions, SourceLog, needed_module
from missionplan.importers.stores import Samples
from missionplan.importers.track import Break, Positions, Track, fixes, positions, series

_MAGIC = b"\xa3\x95\x80"
"""First bytes of a dataflash log: the format of its formats."""
_STARTS = (b"\xfe", b"\xfd")
"""First byte of a MAVLink 1 or 2 packet, after a time of 8 bytes."""
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
    "attitude": ("t", "heading", "pitch"),
    "origin": ("lat", "lon"),
    "boot": ("t", "since"),
}
_TYPES = ("GPS", "POS", "XKF1", "NKF1", "CTUN", "ATT", "ORGN", "MSG", "HEARTBEAT", "GPS_RAW_INT", "GLOBAL_POSITION_INT",
          "LOCAL_POSITION_NED", "ATTITUDE", "GPS_GLOBAL_ORIGIN", "VFR_HUD", "SYSTEM_TIME")  # fmt: skip


class _Found:
    """Readings by kind, and what the messages say of the vehicle."""

    def __init__(self) -> None:
        self.samples = {name: Samples(columns) for name, columns in _COLUMNS.items()}
        self.kinds: Counter[int] = Counter()
        self.told: Counter[str] = Counter()


def recognises(path: Path, head: bytes) -> bool:
    """Whether a file is a dataflash or a telemetry log."""
    return head.startswith(_MAGIC) or (path.suffix.lower() == ".tlog" and head[8:9] in _STARTS)


def read(files: Sequence[Path], options: ReadOptions, log: SourceLog) -> Track:
    """Read logs as one track.

    Raises
    ------
    InputError
        When they are of several vehicles of which none is chosen, or of one that does not dive.
    """
    library = needed_module("pymavlink.mavutil", "ardupilot", "ardupilot")
    found = _Found()
    for path in log.each(sorted(files)):
        with log.reading(path):
            system = _system(library, path, options.vehicle)
            for message in _messages(library, path, system):
                _add(found, message)
    kind = found.kinds.most_common(1)[0][0] if found.kinds else _SUBMARINE
    if kind != _SUBMARINE:
        what = _KINDS.get(kind, f"a vehicle of MAV_TYPE {kind}")
        raise InputError([Problem(f"is the log of {what}, which does not dive", str(files[0]))])
    if log.read and not found.told["fix"]:
        message = "has no fix: no GPS message" if not found.told["gps"] else "has no fix: the GPS never had a position"
        raise InputError([Problem(message, str(log.read[0]), hint="legs go from fix to fix")])
    samples = found.samples
    attitude, depth = samples["attitude"], samples["depth"]
    own, how = _reckoned(samples)
    return Track(
        name="ArduSub",
        format="ardupilot",
        fixes=fixes(**{("latitude" if name == "lat" else "longitude" if name == "lon" else name): samples["fix"][name]
                       for name in _COLUMNS["fix"]}),
        reckoned=own,
        reckoning=how,
        depth=series(depth["t"], depth["depth"]),
        pitch=series(attitude["t"], attitude["pitch"]),
        heading=series(attitude["t"], attitude["heading"] % 360.0),
        heading_from="true",
        breaks=tuple(_restarts(samples["boot"])),
    )  # fmt: skip


def _messages(library: ModuleType, path: Path, system: int | None) -> Iterator[Any]:
    """Messages of the wanted types, of one vehicle; what the library prints is kept from the terminal."""
    with redirect_stdout(StringIO()), redirect_stderr(StringIO()):
        log = library.mavlink_connection(str(path))
    try:
        while True:
            with redirect_stdout(StringIO()), redirect_stderr(StringIO()):
                message = log.recv_match(type=list(_TYPES))
            if message is None:
                return
            if system is None or message.get_srcSystem() == system:
                yield message
    finally:
        close = getattr(log, "close", None)
        if close is not None:
            close()


def _system(library: ModuleType, path: Path, wanted: str | None) -> int | None:
    """System of a telemetry log whose messages are read; None for a dataflash log, which is of one vehicle.

    Raises
    ------
    InputError
        With the list, when it holds several and none of them is chosen.
    """
    if path.suffix.lower() != ".tlog":
        return None
    heard = Counter(
        message.get_srcSystem()
        for message in _messages(library, path, None)
        if message.get_type() == "HEARTBEAT" and message.type not in _NO_VEHICLES
    )
    if wanted is not None and wanted.isdigit() and int(wanted) in heard:
        return int(wanted)
    if len(heard) > 1 or (wanted is not None and heard):
        listed = ", ".join(f"{system} ({count} heartbeats)" for system, count in sorted(heard.items()))
        message = f"no system {shown(wanted)}; it holds {listed}" if wanted else f"holds several systems: {listed}"
        hint = f"choose one with --vehicle, such as --vehicle {min(heard)}"
        raise InputError([Problem(message, str(path), key="vehicle", hint=hint)])
    return next(iter(heard), None)


def _add(found: _Found, m: Any) -> None:
    """Add what one message says."""
    kind, t, samples = m.get_type(), float(m._timestamp), found.samples
    if kind == "HEARTBEAT":
        if m.type not in _NO_VEHICLES:
            found.kinds[int(m.type)] += 1
    elif kind == "MSG":
        firmware = str(m.Message).lower().split(" ")[0]
        if firmware in _FIRMWARE:
            found.kinds[_FIRMWARE[firmware]] += 1
    elif kind in ("GPS", "GPS_RAW_INT"):
        _add_fix(found, kind, t, m)
    elif kind == "POS":
        samples["place"].add(t, m.Lat, m.Lng)
    elif kind == "GLOBAL_POSITION_INT":
        samples["place"].add(t, m.lat * _E7, m.lon * _E7)
        samples["depth"].add(t, -1e-3 * m.relative_alt)
    elif kind in ("XKF1", "NKF1") and getattr(m, "C", 0) == 0:
        samples["plane"].add(t, m.PN, m.PE)
    elif kind == "LOCAL_POSITION_NED":
        samples["plane"].add(t, m.x, m.y)
    elif kind == "CTUN" and hasattr(m, "Alt"):
        samples["depth"].add(t, -m.Alt)
    elif kind == "ATT":
        samples["attitude"].add(t, m.Yaw, m.Pitch)
    elif kind == "ATTITUDE":
        samples["attitude"].add(t, math.degrees(m.yaw), math.degrees(m.pitch))
        samples["boot"].add(t, 1e-3 * m.time_boot_ms)
    elif kind == "ORGN" and getattr(m, "Type", 0) == 0:
        samples["origin"].add(m.Lat, m.Lng)
    elif kind == "GPS_GLOBAL_ORIGIN":
        samples["origin"].add(m.latitude * _E7, m.longitude * _E7)


def _add_fix(found: _Found, kind: str, t: float, m: Any) -> None:
    found.told["gps"] += 1
    if kind == "GPS":
        if getattr(m, "I", 0) != 0:
            return  # a second receiver
        row = (t, m.Lat, m.Lng, m.HDop, math.nan, float(m.NSats), float(m.Status >= _FIX_3D))
    else:
        hdop = 0.01 * m.eph if m.eph != 65535 else math.nan
        accuracy = 1e-3 * getattr(m, "h_acc", 0) or math.nan
        satellites = float(m.satellites_visible) if m.satellites_visible != 255 else math.nan
        row = (t, m.lat * _E7, m.lon * _E7, hdop, accuracy, satellites, float(m.fix_type >= _FIX_3D))
    found.told["fix"] += int(row[-1] == 1.0 and (row[1] != 0.0 or row[2] != 0.0))
    found.samples["fix"].add(*row)


def _reckoned(samples: dict[str, Samples]) -> tuple[Positions, str]:
    place, plane, origin = samples["place"], samples["plane"], samples["origin"]
    own = positions(place["t"], place["lat"], place["lon"])
    if len(own):
        return own, "the autopilot's own estimate (POS, GLOBAL_POSITION_INT)"
    if not len(plane) or not len(origin):
        return Positions(), "the autopilot logs no position of its own"
    first = float(origin["lat"][0]), float(origin["lon"][0])
    none = fixes(np.empty(0), np.empty(0), np.empty(0))
    return plane_positions(
        plane["t"], plane["east"], plane["north"], none, first
    ), "the autopilot's filter (north, east)"


def _restarts(boot: Samples) -> Iterator[Break]:
    """Moments at which the time since the autopilot's start begins again."""
    since: Array = boot["since"]
    for k in np.flatnonzero(np.diff(since) < -1.0):
        yield Break(float(boot["t"][k + 1]), "the autopilot was started anew", at_surface_too=False)


IMPORTERS = (Importer("ardupilot", "ArduSub dataflash and telemetry logs (pymavlink)", recognises, read),)
