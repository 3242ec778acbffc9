"""What of a mission is its task: where it goes, how long it stays, what it must reach. Others are ways to do it."""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Annotated

from missionplan.results.entries import Entry, Record
from missionplan.results.plain_data import mapping, mappings

_PARTS = {
    "phases": re.compile(r"phases"),
    "place": re.compile(r"site\.origin\b.*"),
    "depth": re.compile(r"site\.depth\b.*"),
    "from": re.compile(r"(?!site\.|requirements)[^.]+\.from\b.*"),
    "to": re.compile(r"(?!site\.|requirements)[^.]+\.to\b.*"),
    "hold": re.compile(r"[^.]+\.hold\b.*"),
    "requirements": re.compile(r"requirements\b.*"),
}
"""Key paths, with phases by name, by the part of the task that they tell."""


@dataclass(frozen=True)
class DifferingValue(Record):
    """A value in which missions differ."""

    path: Annotated[str, Entry("key path, with phases by name")]
    values: Annotated[tuple[str, ...], Entry("in the order of the missions; empty where one does not have it")]


def parts_of_task(paths: Iterable[str]) -> dict[str, list[str]]:
    """Return the key paths that belong to a mission's task, by its part, such as ``from`` and ``to``."""
    found: dict[str, list[str]] = {}
    for path in paths:
        for part, pattern in _PARTS.items():
            if pattern.fullmatch(path):
                found.setdefault(part, []).append(path)
    return {part: found[part] for part in _PARTS if part in found}


def phase_names(mission: object) -> tuple[str, ...]:
    """Names of a mission's phases: given, or else their kinds."""
    entries = mappings(mapping(mission).get("phases"))
    return tuple(
        str(section.get("name", kind)) if isinstance(section, Mapping) else str(kind)
        for entry in entries
        for kind, section in entry.items()
    )
