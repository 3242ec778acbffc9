"""The keys that a mission file may have: fields of the section at a key path, and the quantities that they take."""

from collections.abc import Iterable, Iterator, Mapping
from typing import get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo
from typing_extensions import Doc

from missionplan.errors import KeyPath
from missionplan.mission.schema.quantities import OrWord
from missionplan.mission.schema.quantity_parser import QuantityParser
from missionplan.mission.schema.section import ReadBy


def fields_at(path: KeyPath, model: type[BaseModel]) -> dict[str, FieldInfo]:
    """Fields of the sections that may be at `path`, by the names that a file uses; none where none has that path."""
    current, names_follow = [model], False
    for part in path:
        if isinstance(part, int) or names_follow:  # an item of a list, or a name of the user's own
            names_follow = False
            continue
        found = [field for section in current if (field := keys_of(section).get(part)) is not None]
        current = [section for field in found for section in sections_in(field.annotation)]
        names_follow = any(get_origin(field.annotation) is Mapping for field in found)
    return {name: field for section in reversed(current) for name, field in keys_of(section).items()}


def keys_of(section: type[BaseModel]) -> dict[str, FieldInfo]:
    """Fields of a section, by the names that a file uses."""
    return {field.alias or name: field for name, field in section.model_fields.items() if name != "kind"}


def section_in(annotation: object) -> type[BaseModel] | None:
    """Return the first section that an annotation holds, inside unions, tuples and Annotated."""
    return next(sections_in(annotation), None)


def sections_in(annotation: object) -> Iterator[type[BaseModel]]:
    """Every section that an annotation holds."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for inner in getattr(annotation, "__args__", ()):
        yield from sections_in(inner)


def meaning_of(field: FieldInfo) -> str:
    """What the key of a field means, in a few words; empty where its section says so."""
    return next((each.documentation for each in field.metadata if isinstance(each, Doc)), "")


def parsers_of(field: FieldInfo) -> list[QuantityParser]:
    """How the quantities of a field are read, those inside lists and unions too, but not those of a section's keys."""
    return list(_parsers_among(field.metadata)) or list(_parsers_in(field.annotation))


def _parsers_in(annotation: object) -> Iterator[QuantityParser]:
    yield from _parsers_among(getattr(annotation, "__metadata__", ()))
    for inner in getattr(annotation, "__args__", ()):
        yield from _parsers_in(inner)


def _parsers_among(metadata: Iterable[object]) -> Iterator[QuantityParser]:
    for item in metadata:
        reader = item.read if isinstance(item, ReadBy) else None
        reader = reader.parser if isinstance(reader, OrWord) else reader
        if isinstance(reader, QuantityParser):
            yield reader
