"""Pydantic's errors as problems of a document: with lines, key paths, and the nearest valid key."""

from collections.abc import Mapping, Sequence
from difflib import get_close_matches

from pydantic import BaseModel, ValidationError

from missionplan.errors import KeyPath, Problem, shown
from missionplan.mission.reading.documents import Document
from missionplan.mission.reading.fields import fields_at, keys_of, parsers_of, section_in

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


def _unknown_key(path: KeyPath, document: Document, model: type[BaseModel]) -> tuple[Problem, str]:
    """Return the problem of a key that no section has there, and the key that was probably meant."""
    known = list(fields_at(path[:-1], model))
    close = get_close_matches(str(path[-1]), known, n=1)
    hint = f"did you mean {close[0]}?" if close else f"known here: {', '.join(known)}"
    return document.problem(path, "unknown key", hint), close[0] if close else ""


def _expected(path: KeyPath, model: type[BaseModel]) -> str:
    field = fields_at(path[:-1], model).get(str(path[-1]))
    if field is None:
        return "a value here"
    section = section_in(field.annotation)
    mapping = [f"a mapping with {', '.join(keys_of(section))}"] if section else []
    quantities = dict.fromkeys(parser.expected for parser in parsers_of(field))
    return ", or ".join([*quantities, *mapping]) or "a value here"
