"""Logs as vehicles write them: what a voyage's vehicle knew, in places on Earth. Imports nothing of the package."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

EPOCH = 1_780_000_000.0


@dataclass
class Log:
    """What the vehicle knew: (t, lat, lon, depth, heading, speed) under way, (t, lat, lon) of fixes [s, deg, m, m/s]."""

    states: list[tuple[float, ...]] = field(default_factory=list)
    fixes: list[tuple[float, float, float]] = field(default_factory=list)


def write_alog(path: Path, log: Log) -> None:
    """Write the log as pLogger does."""
    rows = []
    for t, latitude, longitude in log.fixes:
        rows += [(t, "GPS_LATITUDE", latitude), (t + 0.01, "GPS_LONGITUDE", longitude)]
    for t, latitude, longitude, depth, heading, speed in log.states:
        rows += [(t, "NAV_LAT", latitude), (t, "NAV_LONG", longitude), (t, "NAV_DEPTH", depth)]
        rows += [(t, "NAV_HEADING", heading), (t, "NAV_SPEED", speed)]
    lines = ["%" * 50, "%% LOG FILE:       ./made.alog", f"%% LOGSTART           {EPOCH:.1f}", "%" * 50]
    lines += [f"{t - EPOCH:.3f} {name} pNav {value:.9f}" for t, name, value in sorted(rows)]
    path.write_text("\n".join(lines) + "\n")


def write_lsf(path: Path, log: Log) -> None:
    """Write the log as DUNE does."""
    import imcpy

    messages = []
    for t, latitude, longitude in log.fixes:
        fix = imcpy.GpsFix()
        fix.timestamp, fix.lat, fix.lon = t, np.radians(latitude), np.radians(longitude)
        fix.hacc, fix.satellites, fix.validity = 3.0, 9, 4 | 32
        messages.append(fix)
    for t, latitude, longitude, depth, heading, speed in log.states:
        state = imcpy.EstimatedState()
        state.timestamp, state.lat, state.lon = t, np.radians(latitude), np.radians(longitude)
        state.depth, state.psi, state.u = depth, np.radians(heading), speed
        messages.append(state)
    messages.sort(key=lambda each: each.timestamp)
    path.write_bytes(b"".join(imcpy.Packet.serialize(each) for each in messages))
