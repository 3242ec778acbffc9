"""Entries of results: a field states meaning, quantity and name once; summaries, rows and schemas come from that.

Parts of plain data, as a mission's file or a report's `summary.json` holds them: of the kind expected, or empty. What
these data hold is not checked when they are read back: a report may be of another version, a mission half written.
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sized
from dataclasses import dataclass, fields, is_dataclass, replace
from functools import cache
from inspect import cleandoc
from typing import Annotated, Any, get_args, get_origin


@dataclass(frozen=True)
class Entry:
    """Says that a field, or a property by the annotation of what it returns, is an entry of `summary.json`."""

    meaning: str = ""
    """In words; empty for a property, whose docstring says it."""
    unit: str = ""
    """Of its numbers, such as ``m/s``; the key ends with it: ``_m_s``."""
    key: str = ""
    """Instead of the attribute's name, without the unit; ``fixed.cost`` is the entry ``cost`` of ``fixed``."""
    ending: bool = True
    """Whether the key ends with the unit."""
    optional: bool = False
    """Whether the key is left out where there is nothing: None, or a list without items."""
    when: Callable[[Any], bool] | None = None
    """Of the record: whether the key is there; default: it is."""
    scale: float = 1.0
    """Numbers of the attribute are divided by it: J in a W h."""
    digits: int | None = None
    """Decimals that a number is rounded to; default: all that it has."""
    parts: tuple[str, ...] = ()
    """Entries of its own that are taken; default: all."""
    after: str = ""
    """Attribute that a property follows in tables; default: the last one."""
    inline: bool = False
    """Whether the entries of its value, a record, stand in its place."""


@dataclass(frozen=True)
class StatedField:
    """A field or property of a result that is an entry."""

    attribute: str
    groups: tuple[str, ...]
    """Entries of the summary inside which it stands."""
    key: str
    kind: object
    """Its type, without what is said of it."""
    entry: Entry
    """With its meaning."""


class Record:
    """A part of a result. Subclasses are frozen data classes, whose fields and properties may be entries."""

    def summary(self) -> dict[str, Any]:
        """Return the entries, as `summary.json` holds them: SI, keys that end with the unit."""
        return summary_of(self)

    def row(self) -> dict[str, Any]:
        """Return the entries as the row of a table: numbers alone, nan for what is not known."""
        items = [item for item in stated(type(self)) if item.entry.when is None or item.entry.when(self)]  # type: ignore[arg-type]
        return {item.key: _cell(_scaled(getattr(self, item.attribute), item.entry)) for item in items}


def summary_of(record: Any) -> dict[str, Any]:
    """Return the entries of a result or of a part of one, as `summary.json` holds them."""
    summary: dict[str, Any] = {}
    for item in stated(type(record)):  # type: ignore[arg-type]  # a class is hashable
        value = getattr(record, item.attribute)
        if item.entry.when is not None and not item.entry.when(record):
            continue
        if item.entry.optional and (value is None or (isinstance(value, Sized) and not len(value))):
            continue
        group = summary
        for name in item.groups:
            group = group.setdefault(name, {})
        stands = _plain(_scaled(value, item.entry))
        if item.entry.inline:
            group.update(stands)
            continue
        if item.entry.parts:
            stands = _only(item.entry.parts, stands)
        if isinstance(group.get(item.key), dict):  # other fields stand in this entry
            group[item.key].update(stands)
        else:
            group[item.key] = stands
    return summary


@cache
def stated(kind: type[Any]) -> tuple[StatedField, ...]:
    """Return the entries of a kind of result: its fields, then its properties, in the order of the source."""
    ordered: list[StatedField] = []
    for item in _stated(kind):
        before = [place for place, other in enumerate(ordered) if other.attribute == item.entry.after]
        ordered.insert(before[0] + 1 if before else len(ordered), item)
    return tuple(ordered)


def _stated(kind: type[Any]) -> Iterator[StatedField]:
    for field in fields(kind):
        yield from _entries(field.name, field.type, "")
    for base in reversed(kind.__mro__):
        for name, member in vars(base).items():
            read = getattr(member, "fget", None) or getattr(member, "func", None)  # a property, or a cached one
            if read is not None:
                yield from _entries(name, read.__annotations__.get("return"), read.__doc__ or "")


def _entries(attribute: str, annotation: object, docstring: str) -> Iterator[StatedField]:
    if get_origin(annotation) is not Annotated:
        return
    kind, *metadata = get_args(annotation)
    for entry in metadata:
        if isinstance(entry, Entry):
            ending = f"_{key_of_unit(entry.unit)}" if entry.unit and entry.ending else ""
            *groups, key = f"{entry.key or attribute}{ending}".split(".")
            meaning = entry.meaning or cleandoc(docstring).partition("\n\n")[0]
            yield StatedField(attribute, tuple(groups), key, kind, replace(entry, meaning=meaning))


def key_of_unit(unit: str) -> str:
    """Write a unit as keys end with it: ``m/s^2`` is ``m_s2``."""
    return unit.lower().replace("/", "_").replace(" ", "").replace("^", "")


def _scaled(value: Any, entry: Entry) -> Any:
    scaled = value if entry.scale == 1.0 or value is None else value / entry.scale
    return scaled if entry.digits is None or scaled is None else round(scaled, entry.digits)


def _plain(value: Any) -> Any:
    """What stands in a summary for a value: entries of its own, or the value."""
    if hasattr(value, "summary"):
        return value.summary()
    if isinstance(value, Mapping):
        return {name: _plain(inner) for name, inner in value.items()}
    if is_dataclass(value):
        return fields_of(value)
    if isinstance(value, tuple) and hasattr(value, "_asdict"):
        return value._asdict()
    if isinstance(value, tuple | list):
        return [_plain(inner) for inner in value]
    return value


def fields_of(value: Any) -> dict[str, Any]:
    """Return the fields of a data class by their names, as they stand in a summary."""
    return {field.name: _plain(getattr(value, field.name)) for field in fields(value)}


def _only(parts: tuple[str, ...], stands: Any) -> Any:
    if isinstance(stands, list):
        return [_only(parts, inner) for inner in stands]
    return stands and {key: stands[key] for key in parts if key in stands}


def _cell(value: Any) -> Any:
    return math.nan if value is None else getattr(value, "value", value)


def mapping(value: object) -> Mapping[str, object]:
    """Return a mapping as it is; an empty one for anything else."""
    return value if isinstance(value, Mapping) else {}


def mappings(value: object) -> list[Mapping[str, object]]:
    """Return the entries of a list that are mappings; none of anything else."""
    return [entry for entry in value if isinstance(entry, Mapping)] if isinstance(value, list | tuple) else []


def whole(value: object) -> int:
    """Return a whole number as it is; 0 for anything else."""
    return value if isinstance(value, int) else 0


def real(value: object) -> float:
    """Return a number; nan for anything else, and for one that no float holds."""
    try:
        return float(value) if isinstance(value, int | float) else math.nan
    except OverflowError:
        return math.nan
