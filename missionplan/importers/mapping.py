"""What the user says of a source's names: `lat=Latitude[deg]`, on the command line or in a YAML file."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from missionplan.errors import InputError, Problem, did_you_mean, shown
from missionplan.mission.reading.documents import load_document

QUANTITIES = {
    "time": "iso",
    "lat": "deg",
    "lon": "deg",
    "x": "m",
    "y": "m",
    "dr_lat": "deg",
    "dr_lon": "deg",
    "dr_x": "m",
    "dr_y": "m",
    "depth": "m",
    "heading": "deg",
    "heading_true": "deg",
    "pitch": "deg",
    "speed": "m/s",
    "declination": "deg",
    "hdop": "",
    "hacc": "m",
    "satellites": "",
    "valid": "",
    "gps": "",
    "odometry": "",
    "mark": "",
    "origin": "",
}
"""Quantities that a name can be given for, and the unit where none is."""
ASSIGNMENT = re.compile(rf"({'|'.join(QUANTITIES)})=(.+)", re.DOTALL)
_UNIT = re.compile(r"(.*?)\s*\[([^\[\]]*)\]")


@dataclass(frozen=True)
class MappedName:
    """A column, variable or topic, and the unit its values are in (``iso``, ``epoch``, ``ddmm`` and the like too)."""

    name: str
    unit: str


def read_mapping(entries: Sequence[str]) -> dict[str, MappedName]:
    """Read the entries of `--map`: `quantity=name[unit]`, several in one, or YAML files of them.

    Raises
    ------
    InputError
        All entries that are none.
    """
    found: dict[str, MappedName] = {}
    problems: list[Problem] = []
    for entry in entries:
        if entry.endswith((".yaml", ".yml")) and "=" not in entry:
            data = load_document(Path(entry)).data
            pairs = list(data.items()) if isinstance(data, Mapping) else [(entry, None)]
        else:
            pairs = [_pair(each) for each in _split(entry)]
        for quantity, name in pairs:
            problem = _problem(str(quantity), name)
            if problem is not None:
                problems.append(problem)
            else:
                found[str(quantity)] = mapped(str(quantity), str(name))
    if problems:
        raise InputError(problems)
    return found


def mapped(quantity: str, name: str) -> MappedName:
    """Split a name from its unit."""
    matched = _UNIT.fullmatch(name.strip())
    if matched is None:
        return MappedName(name.strip(), QUANTITIES[quantity])
    return MappedName(matched[1].strip(), matched[2].strip())


def _split(entry: str) -> list[str]:
    """Split `lat=Latitude[deg] time=UTC[iso]` before each quantity."""
    starts = [found.start() for found in re.finditer(rf"(?:^|(?<=\s))(?:{'|'.join(QUANTITIES)})=", entry)]
    if not starts or starts[0] != 0:
        return [entry]
    return [entry[start:end].strip() for start, end in zip(starts, [*starts[1:], len(entry)], strict=True)]


def _pair(entry: str) -> tuple[str, str | None]:
    quantity, equals, name = entry.partition("=")
    return quantity.strip(), name if equals and name.strip() else None


def _problem(quantity: str, name: object) -> Problem | None:
    if quantity not in QUANTITIES:
        hint = did_you_mean(quantity, QUANTITIES) or f"one of {', '.join(QUANTITIES)}"
        return Problem(f"given {shown(quantity)}, expected a quantity such as lat=Latitude[deg]", key="map", hint=hint)
    if name is None or str(name).strip() == "":
        return Problem(f"given {shown(quantity)} without a name, expected {quantity}=NAME[unit]", key="map")
    return None
