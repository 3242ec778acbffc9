"""Pydantic's errors as problems of a document: with lines, key paths, and the nearest valid key.

The keys that a mission file may have: fields of the section at a key path, and the quantities that they take.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from difflib import get_close_matches
from typing import get_origin

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo
from typing_extensions import Doc

from missionplan.errors import KeyPath, Problem, shown
from missionplan.mission.documents import Document
from missionplan.mission.schema import ReadBy
from missionplan.mission.schema.quantity_parser import OrWord, QuantityParser


def fields_at(path: KeyPath, model: type[BaseModel]) -> dict[str, FieldInfo]:
    """Fields of the sections that may be at `path`, by the names that a file uses; none where none has that path."""
    current, names_follow = [model], False
    for part in path:
        if isinstance(part, int) or names_follow:  # an item of a list, or a name of the user's own
            names_follow = False
            continue
        fields = [field for section in current if (field := keys_of(section).get(part)) is not None]
        current = [section for field in fields for section in sections_in(field.annotation)]
        names_follow = any(get_origin(field.annotation) is Mapping for field in fields)
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
    return next((annotation.documentation for annotation in field.metadata if isinstance(annotation, Doc)), "")


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


MAX_SHOWN = 100
"""Problems that are looked into one by one: a file with more is something else altogether."""
_MESSAGES = {
    "Input should be a valid dictionary": "expected a mapping",
    "Input should be a valid tuple": "expected a list",
    "Input should be a valid list": "expected a list",
    "Input should be a valid integer": "expected a whole number",
    "Input should be a valid string": "expected text",
}
"""Messages of this project by how pydantic's start."""
_IN_QUOTES = "on, off, yes and no mean true and false in YAML; in quotes they are text"


def validation_problems(error: ValidationError, document: Document, model: type[BaseModel]) -> list[Problem]:
    """List the problems of a document that a model refused.

    A missing key is left out where an unknown one is probably the same with a typing error.
    """
    problems: list[Problem] = []
    mistyped: set[KeyPath] = set()
    missing: list[KeyPath] = []
    details = error.errors(include_url=False)
    for detail in details[:MAX_SHOWN]:
        path = _without_tags(detail["loc"], document.data)
        context = detail.get("ctx") or {}
        if "problems" in context:
            problems += [document.located(problem, path) for problem in context["problems"]]
        elif detail["type"] == "missing":
            missing.append(path)
        elif detail["type"] == "extra_forbidden":
            keys = list(fields_at(path[:-1], model))
            meant = next(iter(get_close_matches(str(path[-1]), keys, n=1)), "")
            near = f"did you mean {meant}?" if meant else f"known here: {', '.join(keys)}"
            problems.append(document.problem(path, "unknown key", near))
            mistyped.add((*path[:-1], meant))
        else:
            message = detail["msg"].replace("Input should be", "expected").replace("Field required", "missing")
            message = next((words for start, words in _MESSAGES.items() if detail["msg"].startswith(start)), message)
            hint = _IN_QUOTES if message == "expected text" and isinstance(detail["input"], bool) else ""
            problems.append(document.problem(path, f"given {_shown(detail['input'])}, {message}", hint))
    for path in missing:
        if path not in mistyped:
            problems.append(document.problem(path, f"missing; expected {_expected(path, model)}"))
    if len(details) > MAX_SHOWN:
        problems.append(document.problem((), f"{len(details) - MAX_SHOWN} more problems are not listed"))
    return problems


def _without_tags(location: KeyPath, data: object) -> KeyPath:
    """Leave the tags of unions, such as ``<layers>``, out of a location, but no key of the file that looks like one."""
    path: list[str | int] = []
    for part in location:
        if isinstance(data, Mapping):
            inside = part in data
        else:
            inside = isinstance(data, list | tuple) and isinstance(part, int) and part < len(data)
        if inside or not str(part).startswith("<"):
            path.append(part)
            data = data[part] if inside else None  # type: ignore[index]
    return tuple(path)


def in_order(problems: Sequence[Problem]) -> list[Problem]:
    """Sort problems by file and line."""
    return sorted(problems, key=lambda problem: (problem.file, problem.line or 0))


def _shown(value: object) -> str:
    if isinstance(value, dict):
        return "a mapping"
    return "a list" if isinstance(value, list | tuple) else shown(value)


def _expected(path: KeyPath, model: type[BaseModel]) -> str:
    field = fields_at(path[:-1], model).get(str(path[-1]))
    if field is None:
        return "a value here"
    section = section_in(field.annotation)
    mapping = [f"a mapping with {', '.join(keys_of(section))}"] if section else []
    quantities = dict.fromkeys(parser.expected for parser in parsers_of(field))
    return ", or ".join([*quantities, *mapping]) or "a value here"
