"""`load`: a mission file to a `Mission`, or every problem of the file at once."""

import os.path
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from missionplan.errors import InputError, Problem
from missionplan.mission.checks.cross_checks import cross_check, read_requirements
from missionplan.mission.reading.documents import Document, Path_, load_document
from missionplan.mission.schema.mission import Mission
from missionplan.mission.units import QuantityParser


def load(path: str | Path, *, allow_outside: bool = False) -> Mission:
    """Load and validate a mission file.

    Parameters
    ----------
    path : str or Path
        The mission file.
    allow_outside : bool
        Whether included files may lie outside the mission file's folder.

    Raises
    ------
    InputError
        With every problem of the file: file, line, key path, what was given, what was expected.
    """
    path = Path(path)
    document = load_document(path)
    if not isinstance(document.data, dict):
        raise InputError([document.problem((), "expected a mapping of sections such as `phases:`")])
    problems = include_files(document, path.parent, allow_outside=allow_outside)
    try:
        mission = Mission.model_validate(document.data)
    except ValidationError as error:
        details = error.errors(include_url=False)
        raise InputError(_in_order(problems + translate(details, document, Mission))) from None
    problems += cross_check(mission, document)
    requirements, wrong = read_requirements(mission, document)
    if problems + wrong:
        raise InputError(_in_order(problems + wrong))
    mission = mission.model_copy(update={"requirements": requirements})
    mission._raw, mission._file = document.data, str(path)
    return mission


def _in_order(problems: list[Problem]) -> list[Problem]:
    return sorted(problems, key=lambda problem: (problem.file, problem.line or 0))


def include_files(document: Document, folder: Path, *, allow_outside: bool) -> list[Problem]:
    """Put the vehicle file in its place and resolve the current's file, both within the mission's folder tree."""
    problems: list[Problem] = []
    vehicle = document.data.get("vehicle")
    if isinstance(vehicle, str):
        target = _resolve(vehicle, ("vehicle",), document, folder, allow_outside, problems)
        if target is None:
            del document.data["vehicle"]
        else:
            try:
                document.graft(("vehicle",), load_document(target, str(folder / vehicle)))
            except InputError as error:
                problems += error.problems
                del document.data["vehicle"]
    site = document.data.get("site")
    current = site.get("current") if isinstance(site, dict) else None
    if isinstance(current, dict) and isinstance(current.get("file"), str):
        target = _resolve(current["file"], ("site", "current", "file"), document, folder, allow_outside, problems)
        current["file"] = str(target or current["file"])
    return problems


def _resolve(
    name: str, path: Path_, document: Document, folder: Path, allow_outside: bool, problems: list[Problem]
) -> Path | None:
    if "\0" in name:
        problems.append(document.problem(path, f"given {_shown(name)}; no file's name holds a null character"))
        return None
    root, target = folder.resolve(), (folder / name).resolve()
    if not allow_outside and not target.is_relative_to(root):
        message = f"given {_shown(name)}, which lies outside the mission file's folder"
        problems.append(document.problem(path, message, "--allow-outside permits it"))
        return None
    if not os.path.isfile(target):  # noqa: PTH113 - raises nothing where a name is too long
        near = get_close_matches(target.name, [p.name for p in target.parent.glob("*")], n=1)
        hint = f"did you mean {Path(name).parent / near[0]}?" if near else ""
        problems.append(document.problem(path, f"given {_shown(name)}; there is no such file", hint))
        return None
    return target


def translate(details: list[ErrorDetails], document: Document, model: type[BaseModel]) -> list[Problem]:
    """Turn pydantic's errors into problems with lines, key paths and the nearest valid key."""
    problems: list[Problem] = []
    mistyped: set[Path_] = set()
    missing: list[Path_] = []
    for detail in details:
        path = tuple(part for part in detail["loc"] if not str(part).startswith("<"))
        context = detail.get("ctx") or {}
        if "problems" in context:
            problems += [document.problem((*path, *below), words) for below, words in context["problems"]]
        elif detail["type"] == "missing":
            missing.append(path)
        elif detail["type"] == "extra_forbidden":
            problem, meant = _unknown_key(path, document, model)
            problems.append(problem)
            mistyped.add((*path[:-1], meant))
        else:
            problems.append(document.problem(path, f"given {_shown(detail['input'])}, {_words(detail['msg'])}"))
    for path in missing:
        if path not in mistyped:
            problems.append(document.problem(path, f"missing; expected {_expected(path, model)}"))
    return problems


def _shown(value: Any) -> str:
    if isinstance(value, dict):
        return "a mapping"
    if isinstance(value, list | tuple):
        return "a list"
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."


def _words(message: str) -> str:
    """Pydantic's words, in this project's manner."""
    known = {
        "Input should be a valid dictionary or instance of ": "expected a mapping",
        "Input should be a valid tuple": "expected a list",
        "Input should be a valid list": "expected a list",
        "Input should be a valid integer": "expected a whole number",
        "Input should be a valid string": "expected text",
    }
    for start, words in known.items():
        if message.startswith(start):
            return words
    return message.replace("Input should be", "expected").replace("Field required", "missing")


def _fields(path: Path_, model: type[BaseModel]) -> dict[str, Any]:
    """Fields of the section at `path`, by the names that a file uses."""
    current: Any = model
    for part in path:
        if isinstance(part, int):
            continue
        field = _by_name(current).get(part)
        current = _section_in(field.annotation) if field is not None else None
        if current is None:
            return {}
    return _by_name(current)


def _by_name(model: type[BaseModel]) -> dict[str, Any]:
    return {field.alias or name: field for name, field in model.model_fields.items() if name != "kind"}


def _section_in(annotation: Any) -> type[BaseModel] | None:
    """The section that an annotation holds, inside unions, tuples and Annotated."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    for inner in getattr(annotation, "__args__", ()):
        found = _section_in(inner)
        if found is not None:
            return found
    return None


def _unknown_key(path: Path_, document: Document, model: type[BaseModel]) -> tuple[Problem, str]:
    """Problem of a key that no section has there, and the key that was probably meant."""
    known = list(_fields(path[:-1], model))
    close = get_close_matches(str(path[-1]), known, n=1)
    hint = f"did you mean {close[0]}?" if close else f"known here: {', '.join(known)}"
    return document.problem(path, "unknown key", hint), close[0] if close else ""


def _expected(path: Path_, model: type[BaseModel]) -> str:
    field = _fields(path[:-1], model).get(str(path[-1]))
    for item in getattr(field, "metadata", ()):
        parser = getattr(item, "func", None)
        if isinstance(parser, QuantityParser):
            return parser.expected
    section = _section_in(getattr(field, "annotation", None))
    return f"a mapping with {', '.join(_by_name(section))}" if section else "a value here"
