"""What a result tells the crew to do: one object, which terminal, page, JSON and Python show."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated

from missionplan.results.assumption import Assumption
from missionplan.results.entries import Entry, Record

_STEP = re.compile(r"([^.\[\]]+)|\[(\d+)\]")


@dataclass(frozen=True)
class Change(Record):
    """A key of the mission that is to have another value."""

    key: Annotated[str, Entry("key path, as ``--vary`` and ``Mission.with_`` take it")]
    was: Annotated[object, Entry("value in the mission file; null where it has none")]
    now: Annotated[object, Entry("value as a mission file has it")]


@dataclass(frozen=True)
class Decision(Record):
    """What to do, how sure that is, on which assumptions, and what changes in the mission."""

    do: Annotated[str, Entry("what to do, as the headline says it")]
    sure: Annotated[Mapping[str, object] | None, Entry("how sure: a probability with its interval; null where none")]
    assumes: Annotated[tuple[Assumption, ...], Entry("what is taken for granted, each with its worth")]
    changes: Annotated[tuple[Change, ...], Entry("keys of the mission, was and now")]
    not_in_this_probability: Annotated[tuple[str, ...], Entry("what a mission may fail of that this does not hold")]


def written(data: Mapping[str, object], key: str) -> object:
    """Return what a mission's data has at a key path that begins with a section or a phase's name; None for nothing."""
    first, *rest = (name or int(number) for name, number in _STEP.findall(key))
    value: object = data.get(str(first))
    if value is None:
        value = next((phase for phase in _phases(data) if phase.get("name") == first), None)
    for step in rest:
        if isinstance(value, Mapping):
            value = value.get(step)
        elif isinstance(value, Sequence) and not isinstance(value, str) and isinstance(step, int) and step < len(value):
            value = value[step]
        else:
            return None
    return value


def _phases(data: Mapping[str, object]) -> list[Mapping[str, object]]:
    """Return each phase with its name, its kind where it has none."""
    entries = data.get("phases")
    found: list[Mapping[str, object]] = []
    for entry in entries if isinstance(entries, Sequence) else ():
        for kind, phase in entry.items() if isinstance(entry, Mapping) else ():
            found.append({"name": kind, **phase} if isinstance(phase, Mapping) else {"name": kind})
    return found


def changes_of(data: Mapping[str, object], values: Mapping[str, object]) -> tuple[Change, ...]:
    """Return the keys whose values differ from the mission's."""
    pairs = ((key, written(data, key), now) for key, now in values.items())
    return tuple(Change(key, was, now) for key, was, now in pairs if was != now)
