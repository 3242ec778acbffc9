"""Iver and EcoMapper: text logs of the vehicle's computer, separated by semicolons.

One position: the receiver's at the surface, dead-reckoned under water. Columns as in the log files that the makers'
VectorMap writes and public tools for EcoMapper and Iver2 logs read: Latitude, Longitude, Time, Date (month first, UTC),
Number of Sats, HDOP, C True Heading, Pitch Angle, DFS Depth (m), Vehicle Speed (kn).
"""

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from missionplan.importers.importer import Identity, Importer, ReadOptions, SourceLog
from missionplan.importers.mapping import mapped
from missionplan.importers.readers import track
from missionplan.importers.sourcefiles.text_tables import read_header
from missionplan.importers.track import Track

_COLUMNS = {
    "time": "Date+Time[%m/%d/%Y %H:%M:%S]",
    "lat": "Latitude[deg]",
    "lon": "Longitude[deg]",
    "depth": "DFS Depth (m)[m]",
    "heading_true": "C True Heading[deg]",
    "pitch": "Pitch Angle[deg]",
    "speed": "Vehicle Speed (kn)[knot]",
    "hdop": "HDOP",
    "satellites": "Number of Sats",
}
_NEEDED = ("latitude", "longitude", "time", "date", "dfs depth (m)")
_NAME = re.compile(r"(iver\d*-\d+|ecomapper[-_]?\d+)", re.IGNORECASE)


def recognises(path: Path, head: bytes) -> bool:
    """Whether a file's first line has the columns of such a log."""
    words = [word.strip().strip('"').lower() for word in head.split(b"\n")[0].decode("utf-8-sig", "replace").split(";")]
    return all(name in words for name in _NEEDED)


def identity(path: Path) -> Identity:
    """Vehicle that the name of a file ends with, such as ``20170627_193227_UTC_0_mission1_IVER2-135.log``."""
    found = _NAME.search(path.name)
    return Identity(found[1].upper() if found else "")


def read(files: Sequence[Path], options: ReadOptions, log: SourceLog) -> Track:
    """Read logs as one track."""
    there = {name.lower(): name for name in read_header(files[0])}
    usual = {quantity: mapped(quantity, name) for quantity, name in _COLUMNS.items()}
    names = {}
    for quantity, each in usual.items():
        own = [there.get(part.lower()) for part in each.name.split("+")]
        if all(own):
            names[quantity] = replace(each, name="+".join(str(part) for part in own))
    found = track.read(files, replace(options, names={**names, **options.names}), log)
    return replace(found, name="Iver", format="iver", reckoning="the vehicle's own position under water")


IMPORTERS = (Importer("iver", "Iver and EcoMapper text logs", recognises, read, identify=identity),)
