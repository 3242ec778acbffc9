"""DUNE and LSTS vehicles: LSF logs of IMC messages, decoded by imcpy.

Only messages of the wanted kinds are decoded. The file is framed here, so that a damaged rest loses nothing before it,
and no index file beside the log is read or written.
"""

import gzip
import math
import struct
from collections.abc import Iterator, Sequence
from io import BufferedIOBase
from pathlib import Path
from types import ModuleType
from typing import Protocol

import numpy as np

from missionplan.arrays import Array
from missionplan.importers.geodesy import moved
from missionplan.importers.importer import Importer, PartlyReadError, ReadOptions, SourceLog, needed_module
from missionplan.importers.stores import Samples, clock_jumps
from missionplan.importers.track import Break, Fixes, Positions, Series, Track, fixes, positions, series

_SYNC, _SWAPPED = 0xFE54, 0x54FE
_HEADER = struct.Struct("<HHHdHBHB")
_FOOTER = 2
_WANTED = ("GpsFix", "EstimatedState", "EulerAngles", "Depth", "Rpm")
_COLUMNS = {
    "GpsFix": ("t", "lat", "lon", "hacc", "hdop", "satellites", "valid"),
    "EstimatedState": ("t", "lat", "lon", "x", "y", "depth", "heading", "pitch", "source"),
    "EulerAngles": ("t", "heading", "pitch"),
    "Depth": ("t", "depth"),
    "Rpm": ("t", "rpm"),
}
_SIMULATED = (2, 3, 4)
"""Types of fixes that no receiver measured: dead reckoning, manual input, simulation."""


class _Message(Protocol):
    timestamp: float
    src: int

    def __getattr__(self, name: str) -> float: ...


def recognises(path: Path, head: bytes) -> bool:
    """Whether a file is an LSF log."""
    return path.name.endswith((".lsf", ".lsf.gz")) or head[:2] == struct.pack("<H", _SYNC)


def read(files: Sequence[Path], options: ReadOptions, log: SourceLog) -> Track:
    """Read LSF logs as one track."""
    library = needed_module("imcpy", "imc", "imc")
    found = {name: Samples(columns) for name, columns in _COLUMNS.items()}
    breaks: list[Break] = []
    for path in log.each(sorted(files)):
        with log.reading(path):
            before = len(found["EstimatedState"])
            try:
                _add(found, library, path)
            finally:
                breaks += clock_jumps(found["EstimatedState"]["t"][before:])
    state, angles = found["EstimatedState"], found["EulerAngles"]
    turning = state if len(state) else angles
    return Track(
        name=f"IMC vehicle, {files[0].parent.name or files[0].stem}",
        format="imc",
        fixes=_fixes(found["GpsFix"]),
        reckoned=_positions(state),
        reckoning="the vehicle's own (EstimatedState)" if len(state) else "there is no EstimatedState",
        depth=_depth(found),
        pitch=series(turning["t"], np.degrees(turning["pitch"])),
        heading=series(turning["t"], np.degrees(turning["heading"]) % 360.0),
        heading_from="true",
        rpm=series(found["Rpm"]["t"], found["Rpm"]["rpm"]),
        breaks=tuple(breaks),
    )


def _add(found: dict[str, Samples], library: ModuleType, path: Path) -> None:
    """Add the messages of one file, as far as it is whole.

    Raises
    ------
    PartlyReadError
        When the file ends within a message, or holds something else from some byte on.
    """
    names = {int(library.Factory.id_from_abbrev(name)): name for name in _WANTED}
    with gzip.open(path, "rb") if path.suffix == ".gz" else path.open("rb") as stream:
        for kind, packet in _packets(stream, frozenset(names)):
            message: _Message = library.Packet.deserialize(packet)
            found[names[kind]].add(*_values(names[kind], message))


def _packets(stream: BufferedIOBase, wanted: frozenset[int]) -> Iterator[tuple[int, bytes]]:
    place = 0
    while len(head := stream.read(_HEADER.size)) == _HEADER.size:
        sync, kind, size, *_ = _HEADER.unpack(head)
        if sync != _SYNC:
            words = "big-endian messages" if sync == _SWAPPED else "no IMC message"
            raise PartlyReadError(f"{words} from byte {place} on")
        rest = stream.read(size + _FOOTER)
        if len(rest) < size + _FOOTER:
            raise PartlyReadError(f"the file ends within a message at byte {place}")
        if kind in wanted:
            yield kind, head + rest
        place += len(head) + len(rest)
    if head:
        raise PartlyReadError(f"the file ends within a message at byte {place}")


def _values(name: str, message: _Message) -> tuple[float, ...]:
    m = message
    if name == "GpsFix":
        bits = int(m.validity)
        is_measured = float(bool(bits & 4) and int(m.type) not in _SIMULATED)
        hacc = m.hacc if bits & 32 else math.nan
        hdop = m.hdop if bits & 128 else math.nan
        # a fix that no receiver measured has no quality, so that its flag decides
        quality = (hacc, hdop, float(m.satellites)) if is_measured else (math.nan, math.nan, math.nan)
        return (m.timestamp, math.degrees(m.lat), math.degrees(m.lon), *quality, is_measured)
    if name == "EstimatedState":
        place = (math.degrees(m.lat), math.degrees(m.lon), m.x, m.y)
        return (m.timestamp, *place, m.depth, m.psi, m.theta, float(m.src))
    if name == "EulerAngles":
        return (m.timestamp, m.psi, m.theta)
    return (m.timestamp, float(m.value))


def _fixes(found: Samples) -> Fixes:
    return fixes(
        found["t"],
        found["lat"],
        found["lon"],
        accuracy=found["hacc"],
        hdop=found["hdop"],
        satellites=found["satellites"],
        valid=found["valid"],
    )


def _positions(state: Samples) -> Positions:
    """Positions of the vehicle that logged most: reference, and north and east of it."""
    own = _of_main_source(state)
    place = moved(state["lat"][own], state["lon"][own], state["y"][own], state["x"][own])
    return positions(state["t"][own], *place)


def _of_main_source(state: Samples) -> Array:
    source = state["source"]
    if not len(source):
        return np.zeros(0, dtype=bool)
    values, counts = np.unique(source, return_counts=True)
    return np.asarray(source == values[np.argmax(counts)])


def _depth(found: dict[str, Samples]) -> Series:
    state = found["EstimatedState"]
    known = series(state["t"], np.where(state["depth"] >= 0.0, state["depth"], np.nan))  # −1 is no depth
    return known if len(known) else series(found["Depth"]["t"], found["Depth"]["depth"])


IMPORTERS = (Importer("imc", "DUNE/LSTS LSF logs (imcpy)", recognises, read),)
