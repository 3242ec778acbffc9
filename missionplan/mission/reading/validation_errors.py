"""Pydantic's errors as problems of a document: with lines, key paths, and the nearest valid key."""

from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from typing import get_origin

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo

from missionplan.errors import KeyPath, Problem, shown
from missionplan.mission.reading.documents import Document
from missionplan.mission.schema.quantity_parser import QuantityParser
from missionplan.mission.schema.section import ReadBy

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
            problem, meant = _unknown_key(path, document, model)
            problems.append(problem)
            mistyped.add((*path[:-1], meant))
        else:
            problems.append(document.problem(path, f"given {_shown(detail['input'])}, {_message(detail['msg'])}"))
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


def _message(message: str) -> str:
    """Return this project's words for a message of pydantic's."""
    for start, words in _MESSAGES.items():
        if message.startswith(start):
            return words
    return message.replace("Input should be", "expected").replace("Field required", "missing")


def _fields(path: KeyPath, model: type[BaseModel]) -> dict[str, FieldInfo]:
    """Fields of the section at `path`, by the names that a file uses; none where no section has that path."""
    current, names_follow = model, False
    for part in path:
        if isinstance(part, int) or names_follow:  # an item of a list, or a name of the user's own
            names_follow = False
            continue
        field = _by_name(current).get(part)
        section = _section_in(field.annotation) if field is not None else None
        if field is None or section is None:
            return {}
        current, names_follow = section, get_origin(field.annotation) is Mapping
    return _by_name(current)


def _by_name(model: type[BaseModel]) -> dict[str, FieldInfo]:
    return {field.alias or name: field for name, field in model.model_fields.items() if name != "kind"}


def _section_in(annotation: object) -> type[BaseModel] | None:
    """Return the section that an annotation holds, inside unions, tuples and Annotated."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    for inner in getattr(annotation, "__args__", ()):
        found = _section_in(inner)
        if found is not None:
            return found
    return None


def _unknown_key(path: KeyPath, document: Document, model: type[BaseModel]) -> tuple[Problem, str]:
    """Return the problem of a key that no section has there, and the key that was probably meant."""
    known = list(_fields(path[:-1], model))
    close = get_close_matches(str(path[-1]), known, n=1)
    hint = f"did you mean {close[0]}?" if close else f"known here: {', '.join(known)}"
    return document.problem(path, "unknown key", hint), close[0] if close else ""


def _expected(path: KeyPath, model: type[BaseModel]) -> str:
    field = _fields(path[:-1], model).get(str(path[-1]))
    if field is None:
        return "a value here"
    for item in field.metadata:
        parser = item.read if isinstance(item, ReadBy) else None
        if isinstance(parser, QuantityParser):
            return parser.expected
    section = _section_in(field.annotation)
    mapping = [f"a mapping with {', '.join(_by_name(section))}"] if section else []
    return ", or ".join([*_quantities_in(field.annotation), *mapping]) or "a value here"


def _quantities_in(annotation: object) -> list[str]:
    """What the quantities inside a union are."""
    parsers = (item.read for item in getattr(annotation, "__metadata__", ()) if isinstance(item, ReadBy))
    found = [parser.expected for parser in parsers if isinstance(parser, QuantityParser)]
    for inner in getattr(annotation, "__args__", ()):
        found += [words for words in _quantities_in(inner) if words not in found]
    return found
