"""DUNE and LSTS vehicles: LSF logs of IMC messages, decoded by imcpy.

Only messages of the wanted kinds are decoded. The file is framed here, so that a damaged rest loses nothing before it,
and no index file beside the log is read or written. A log holds messages of other systems too: those of the one that
logs its fixes and its own state are read. Format: LSTS/imc, IMC.xml (header, GpsFix, EstimatedState, Announce).
"""

import math
import struct
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any, BinaryIO

import numpy as np

from missionplan.arrays import Array
from missionplan.errors import InputError, Problem, counted, did_you_mean, shown
from missionplan.importers.geodesy import moved
from missionplan.importers.importer import (
    DAMAGED,
    Importer,
    PartlyReadError,
    ReadOptions,
    Samples,
    SourceLog,
    needed_module,
    unpacked,
)
from missionplan.importers.track import Break, Series, Track, clock_jumps, fixes, positions, series

_ORDERS = {0xFE54: "<", 0x54FE: ">"}
"""Byte order by the synchronisation word, read as little-endian."""
_FIELDS = "HHHdHBHB"
"""Synchronisation, kind, size, time, source, its entity, destination, its entity."""
_HEADER = struct.calcsize("<" + _FIELDS)
_FOOTER = 2
_COLUMNS = {
    "GpsFix": ("t", "lat", "lon", "accuracy", "hdop", "satellites", "valid"),
    "EstimatedState": ("t", "lat", "lon", "x", "y", "depth", "heading", "pitch"),
    "EulerAngles": ("t", "heading", "pitch"),
    "Depth": ("t", "depth"),
    "Rpm": ("t", "rpm"),
}
_SIMULATED = (2, 3, 4)
"""Types of fixes that no receiver measured: dead reckoning, manual input, simulation."""
_LEAST = 0.02
"""Share of all states from which on a system with fixes is a vehicle of its own; a few come over the radio."""


class _System:
    """Messages of one system."""

    def __init__(self) -> None:
        self.name = ""
        self.samples = {kind: Samples(columns) for kind, columns in _COLUMNS.items()}
        self.breaks: list[Break] = []


def recognises(path: Path, head: bytes) -> bool:
    """Whether a file is an LSF log."""
    return path.name.lower().endswith((".lsf", ".lsf.gz")) or int.from_bytes(head[:2], "little") in _ORDERS


def read(files: Sequence[Path], options: ReadOptions, log: SourceLog) -> Track:
    """Read LSF logs as one track.

    Raises InputError with the list, when they are of several vehicles of which none is chosen.
    """
    library = needed_module("imcpy", "imc", "imc")
    systems: dict[int, _System] = defaultdict(_System)
    for path in log.each(sorted(files)):
        with log.reading(path):
            before = {source: len(system.samples["EstimatedState"]) for source, system in systems.items()}
            try:
                _add(systems, library, path)
            finally:
                for source, system in systems.items():
                    system.breaks += clock_jumps(system.samples["EstimatedState"]["t"][before.get(source, 0) :])
    chosen = _chosen(systems, options.vehicle)
    samples = chosen.samples
    state, fixed = samples["EstimatedState"], samples["GpsFix"]
    turning = state if len(state) else samples["EulerAngles"]
    return Track(
        name=f"IMC vehicle, {chosen.name or files[0].parent.name or files[0].stem}",
        format="imc",
        fixes=fixes(fixed["t"], fixed["lat"], fixed["lon"],
                    **{name: fixed[name] for name in ("accuracy", "hdop", "satellites", "valid")}),
        reckoned=positions(state["t"], *moved(state["lat"], state["lon"], state["y"], state["x"])),
        reckoning="the vehicle's own (EstimatedState)" if len(state) else "there is no EstimatedState",
        depth=_depth(samples),
        pitch=series(turning["t"], np.degrees(turning["pitch"])),
        heading=series(turning["t"], np.degrees(turning["heading"]) % 360.0),
        heading_from="true",
        rpm=series(samples["Rpm"]["t"], samples["Rpm"]["rpm"]),
        breaks=tuple(chosen.breaks),
    )  # fmt: skip


def _chosen(systems: Mapping[int, _System], wanted: str | None) -> _System:
    """Return the system as chosen by name or number, else the only one that logs fixes and its own state.

    Raises InputError with the list.
    """
    counts = {source: (len(system.samples["EstimatedState"]), len(system.samples["GpsFix"]))
              for source, system in systems.items()}  # fmt: skip
    most = max((states for states, _ in counts.values()), default=0)
    vehicles = [source for source, (states, fixed) in counts.items() if fixed and states >= _LEAST * most]
    names = {source: systems[source].name or str(source) for source in counts}
    listed = ", ".join(
        f"{names[source]} ({counted(counts[source][0], 'state')}, {counts[source][1]} fixes)"
        for source in sorted(vehicles)
    )
    if wanted is not None:
        match = [source for source in counts if wanted.lower() in (names[source].lower(), str(source))]
        if not match:
            hint = did_you_mean(wanted, names.values())
            raise InputError([Problem(f"no system {shown(wanted)}; there is {listed}", key="vehicle", hint=hint)])
        return systems[match[0]]
    if len(vehicles) > 1:
        hint = f"choose one with --vehicle, such as --vehicle {names[vehicles[0]]}"
        raise InputError([Problem(f"logs of several systems: {listed}", key="vehicle", hint=hint)])
    main = vehicles or sorted(counts, key=lambda source: counts[source])[-1:]
    return systems[main[0]] if main else _System()


def _add(systems: dict[int, _System], library: ModuleType, path: Path) -> None:
    """Add the messages of one file, as far as it is whole.

    Raises PartlyReadError when the file ends within a message, or holds something else from some byte on.
    """
    names = {int(library.Factory.id_from_abbrev(name)): name for name in (*_COLUMNS, "Announce")}
    with unpacked(path) as stream:
        for kind, packet in _packets(stream, frozenset(names)):
            try:
                message: Any = library.Packet.deserialize(packet)  # as its definition says
            except DAMAGED as error:
                raise PartlyReadError(f"a message is damaged: {error}") from None
            system, name = systems[int(message.src)], names[kind]
            if name == "Announce":
                system.name = str(message.sys_name)
            else:
                system.samples[name].add(*_values(name, message))


def _packets(stream: BinaryIO, wanted: frozenset[int]) -> Iterator[tuple[int, bytes]]:
    place = 0
    while len(head := stream.read(_HEADER)) == _HEADER:
        order = _ORDERS.get(int.from_bytes(head[:2], "little"))
        if order is None:
            raise PartlyReadError(f"no IMC message from byte {place} on")
        _, kind, size, *_ = struct.unpack(order + _FIELDS, head)
        rest = stream.read(size + _FOOTER)
        if len(rest) < size + _FOOTER:
            raise PartlyReadError(f"the file ends within a message at byte {place}")
        if kind in wanted:
            yield kind, head + rest
        place += len(head) + len(rest)
    if head:
        raise PartlyReadError(f"the file ends within a message at byte {place}")


def _values(name: str, m: Any) -> tuple[float, ...]:
    if name == "GpsFix":
        bits = int(m.validity)
        is_measured = float(bool(bits & 4) and int(m.type) not in _SIMULATED)
        hacc = m.hacc if bits & 32 else math.nan
        hdop = m.hdop if bits & 128 else math.nan
        # a fix that no receiver measured has no quality, so that its flag decides
        quality = (hacc, hdop, float(m.satellites)) if is_measured else (math.nan, math.nan, math.nan)
        return (m.timestamp, math.degrees(m.lat), math.degrees(m.lon), *quality, is_measured)
    if name == "EstimatedState":
        return (m.timestamp, math.degrees(m.lat), math.degrees(m.lon), m.x, m.y, m.depth, m.psi, m.theta)
    if name == "EulerAngles":
        return (m.timestamp, m.psi, m.theta)
    return (m.timestamp, float(m.value))


def _depth(samples: Mapping[str, Samples]) -> Series:
    """Depth of the state, where −1 is no depth, else the sensor's."""
    state: Array = samples["EstimatedState"]["depth"]
    depth = series(samples["EstimatedState"]["t"], np.where(state >= 0.0, state, np.nan))
    return depth if len(depth) else series(samples["Depth"]["t"], samples["Depth"]["depth"])


IMPORTERS = (Importer("imc", "DUNE/LSTS LSF logs (imcpy)", recognises, read, is_choosing=True),)
