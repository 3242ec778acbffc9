"""Values in which missions differ, with what each tells of the missions' tasks; phases by name."""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Literal, NamedTuple, get_args

from missionplan.errors import KeyPath, key_path
from missionplan.mission.quantity_paths import written_phases
from missionplan.mission.units import QuantityError, number_and_unit, parse_number_with_unit
from missionplan.results.entries import Entry, Record, mapping

PartOfTask = Literal["phases", "place", "depth", "from", "to", "hold", "requirements"]
"""What of its task a value of a mission tells."""


class MissionKey(NamedTuple):
    """Where a value of a mission stands: its keys within a section of the file, or within a phase."""

    keys: KeyPath
    phase: str = ""
    """What stands for the phase in key paths; empty in a section."""

    def path(self) -> str:
        """Return its key path, with phases by name."""
        return ".".join(filter(None, (self.phase, key_path(self.keys))))

    def part(self) -> PartOfTask | None:
        """Return the part of the mission's task that it tells; None for a way to do it."""
        match self.phase, self.keys:
            case "", ("site", "origin", *_):
                return "place"
            case "", ("site", "depth", *_):
                return "depth"
            case "", ("requirements", *_):
                return "requirements"
            case str(name), (("from" | "to" | "hold") as key, *_) if name:
                return key
        return None


@dataclass(frozen=True)
class DifferingValue(Record):
    """A value in which missions differ."""

    path: Annotated[str, Entry("key path, with phases by name")]
    values: Annotated[tuple[str, ...], Entry("in the order of the missions; empty where one does not have it")]
    mission_key: MissionKey


def parts_of_task(keys: Iterable[MissionKey], *, phases_differ: bool) -> dict[PartOfTask, list[str]]:
    """Return the parts of a mission's task that some values tell, in the order of `PartOfTask`, and in which phases."""
    phases: dict[PartOfTask | None, list[str]] = {"phases": []} if phases_differ else {}
    for key in keys:
        phases.setdefault(key.part(), []).append(key.phase)
    parts: tuple[PartOfTask, ...] = get_args(PartOfTask)
    return {part: list(dict.fromkeys(phases[part])) for part in parts if part in phases}


def phase_names(mission: object) -> tuple[str, ...]:
    """Names of a mission's phases: given, or else their kinds."""
    return tuple(phase.name for phase in written_phases(mapping(mission)))


def differing_values(missions: Sequence[object]) -> tuple[DifferingValue, ...]:
    """List the values in which any of some missions differs from the first, by key path with phases by name."""
    values = [dict(_values_by_key(mission, MissionKey(()))) for mission in missions]
    return tuple(
        DifferingValue(key.path(), tuple(_value_shown(by_key.get(key)) for by_key in values), key)
        for key in dict.fromkeys(key for by_key in values for key in by_key)
        if not all(_same(values[0].get(key), by_key.get(key)) for by_key in values[1:])
    )


def _values_by_key(value: object, at: MissionKey) -> Iterator[tuple[MissionKey, object]]:
    if isinstance(value, Mapping) and at == MissionKey(("posterior",)):
        yield at, str(value.get("sha256", ""))[:12]
        for effect, summary in mapping(value.get("summary")).items():
            yield MissionKey((*at.keys, effect)), mapping(summary).get("probability")
    elif isinstance(value, Mapping):
        for key, inner in value.items():
            yield from _values_by_key(inner, MissionKey((*at.keys, str(key)), at.phase))
    elif isinstance(value, list) and at == MissionKey(("phases",)):
        for phase in written_phases({"phases": value}):
            yield from _values_by_key(phase.section, MissionKey((), phase.key))
    elif isinstance(value, list) and at != MissionKey(("learned_from",)):
        for index, inner in enumerate(value):
            yield from _values_by_key(inner, MissionKey((*at.keys, index), at.phase))
    else:
        yield at, value


def _same(first: object, second: object) -> bool:
    if first == second:
        return True
    written = number_and_unit(second)
    if written is None or not isinstance(first, str):
        return False
    try:
        return math.isclose(*(parse_number_with_unit(str(text), written[1]) for text in (first, second)), rel_tol=1e-12)
    except QuantityError:
        return False


def _value_shown(value: object) -> str:
    if isinstance(value, list):
        return f"{len(value)} legs, dives or runs"
    return "" if value is None else str(value)
