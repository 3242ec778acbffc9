"""YAML with line marks, loaded safely: limits on size, depth and nodes, no duplicate keys; JSON too."""

import json
import os
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from difflib import get_close_matches
from pathlib import Path
from typing import Any

import yaml

from missionplan.errors import UNPRINTABLE, InputError, KeyPath, LocalProblem, Problem, key_path, shown
from missionplan.store.folder import check_name

MAX_BYTES = 1_000_000
MAX_DEPTH = 24
MAX_NODES = 10_000
"""Nodes as written, and after aliases are expanded, or a file of a few lines could expand to billions."""
MAX_NUMBER_LENGTH = 80
"""Characters of a number: longer ones take minutes to convert."""
_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
"""That of libyaml, where PyYAML has it: ten times as fast."""


@dataclass
class Document:
    """Plain data of a YAML file, with the line of each value."""

    data: Any
    """Mappings, lists and scalars."""
    marks: dict[KeyPath, tuple[str, int | None]] = field(default_factory=dict)
    """File and line of each key path; empty where the data come from no file."""
    texts: dict[KeyPath, str] = field(default_factory=dict)
    """Text of each file, by the key path at which its data are."""

    @property
    def files(self) -> tuple[str, ...]:
        """Names of the files that the data come from."""
        return tuple(dict.fromkeys(file for file, _ in self.marks.values() if file))

    def mark(self, path: KeyPath) -> tuple[str, int | None]:
        """File and line of a key path, or of its nearest ancestor that has them."""
        for length in range(len(path), -1, -1):
            if path[:length] in self.marks:
                return self.marks[path[:length]]
        return "", None

    def problem(self, path: KeyPath, message: str, hint: str = "") -> Problem:
        """Build a problem that points at a key path."""
        file, line = self.mark(path)
        return Problem(message, file, line, key_path(path), hint)

    def located(self, problem: LocalProblem, within: KeyPath = ()) -> Problem:
        """Return the problem of a value at `within` with its file, line and whole key path."""
        return self.problem((*within, *problem.path), problem.message, problem.hint)

    def graft(self, path: KeyPath, other: "Document") -> None:
        """Put another document in the place of the value at `path`."""
        parent = self.data
        for key in path[:-1]:
            parent = parent[key]
        parent[path[-1]] = other.data
        for inner, mark in other.marks.items():
            self.marks[path + inner] = mark
        for inner, text in other.texts.items():
            self.texts[path + inner] = text


def read_text(path: Path, shown: str, *, max_bytes: int = MAX_BYTES) -> str:
    """Read a UTF-8 text file, which messages name as `shown`.

    Raises InputError when it is missing, a folder, unreadable, too large or not UTF-8.
    """
    check_name(shown)
    try:
        if path.is_dir():
            raise InputError([Problem("is a folder; a file was expected", shown)])
        if path.stat().st_size > max_bytes:
            raise InputError([Problem(f"is larger than {max_bytes / 1e6:g} MB", shown)])
        return path.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise InputError([Problem("no such file", shown, hint=nearest_file(path))]) from None
    except UnicodeDecodeError as error:
        raise InputError([Problem(f"is not UTF-8 text (byte {error.start})", shown)]) from None
    except OSError as error:
        raise InputError([Problem(f"cannot be read: {error.strerror or error}", shown)]) from None


def read_json(path: Path, *, max_bytes: int = MAX_BYTES) -> Any:
    """Read a JSON file; raises InputError as `read_text` does, and where it holds no JSON."""
    text = read_text(path, str(path), max_bytes=max_bytes)
    try:
        return json.loads(text)
    except (ValueError, RecursionError) as error:  # of what is cut off, nested too deep, or has too many digits
        raise InputError([Problem(f"is not valid JSON: {error}", str(path))]) from None


def unprintable_texts(data: object, path: KeyPath = ()) -> Iterator[LocalProblem]:
    """Yield a problem for each key and text that holds a control character, or another that no report can show."""
    if isinstance(data, str) and UNPRINTABLE.search(data):
        yield LocalProblem(path, f"given {shown(data)}, expected text without control characters")
    elif isinstance(data, dict):
        for key, value in data.items():
            if isinstance(key, str) and UNPRINTABLE.search(key):
                yield LocalProblem(path, f"the key {shown(key)} holds a control character")
            else:
                yield from unprintable_texts(value, (*path, key))
    elif isinstance(data, list):
        for index, value in enumerate(data):
            yield from unprintable_texts(value, (*path, index))


def nearest_file(path: Path, beside: Path | None = None) -> str:
    """Hint at the file that was meant, or at the outermost folder that is missing; names are told from `beside`."""
    with suppress(OSError):  # of a name that is too long for a file
        if path.is_symlink():
            return "it is a link to what is not there"
    missing = path
    while missing.parent != missing and not missing.parent.is_dir():
        missing = missing.parent
    relative_path = missing if beside is None else Path(os.path.relpath(missing, beside))
    folder = Path() if beside is None else relative_path.parent
    near = get_close_matches(missing.name, [entry.name for entry in missing.parent.glob("*")], n=1)
    parts = [] if missing == path else [f"there is no folder {relative_path}"]
    return "; ".join([*parts, *(f"did you mean {folder / name}?" for name in near)])


def load_document(path: Path, name: str | None = None) -> Document:
    """Load one YAML document with its line marks; messages have its path as given, or the `name`.

    Raises InputError with all problems of the file's syntax: duplicate keys, keys that are not text, too deep, too
    large.
    """
    name = str(path) if name is None else name
    text = read_text(path, name)
    try:
        _check_size(text, name, _LOADER)
        node = yaml.compose(text, Loader=_LOADER)
    except yaml.MarkedYAMLError as error:
        with suppress(yaml.YAMLError):  # libyaml looks far ahead, and has a limit of its own to depth
            _check_size(text, name, yaml.SafeLoader)
        line = error.problem_mark.line + 1 if error.problem_mark else None
        words = " ".join(part for part in (error.context, error.problem) if part)
        raise InputError([Problem(f"is not valid YAML: {words}", name, line)]) from None
    except yaml.YAMLError as error:
        raise InputError([Problem(f"is not valid YAML: {error}", name)]) from None
    if node is None:
        raise InputError([Problem("is empty", name)])
    builder = _Builder(name)
    document = Document(builder.build(node, ()), builder.marks, {(): text})
    unprintable = [document.located(problem) for problem in unprintable_texts(document.data)]
    if builder.problems or unprintable:
        raise InputError([*builder.problems, *unprintable])
    return document


def _check_size(text: str, name: str, loader: Any) -> None:
    """Refuse what is nested deeply or has too many values while it is parsed, before any function that recurses."""
    depth, nodes = 0, 0
    for event in yaml.parse(text, Loader=loader):
        nodes += isinstance(event, yaml.NodeEvent)
        if isinstance(event, yaml.CollectionStartEvent):
            depth += 1
        elif isinstance(event, yaml.CollectionEndEvent):
            depth -= 1
        line = event.start_mark.line + 1 if event.start_mark else None
        if depth > MAX_DEPTH:
            raise InputError([Problem(f"is nested deeper than {MAX_DEPTH} levels", name, line)])
        if nodes > MAX_NODES:
            raise InputError([Problem(f"has more than {MAX_NODES} values", name, line)])


_COLLECTIONS = ("tag:yaml.org,2002:map", "tag:yaml.org,2002:seq")
_NUMBERS = ("tag:yaml.org,2002:int", "tag:yaml.org,2002:float")


class _Builder:
    """Turns a node tree into plain data, counting nodes as aliases are expanded.

    Attributes
    ----------
    marks : dict
        File and line of each key path.
    problems : list of Problem
    """

    def __init__(self, name: str) -> None:
        self.name = name
        self.marks: dict[KeyPath, tuple[str, int | None]] = {}
        self.problems: list[Problem] = []
        self._nodes = 0
        self._scalars = yaml.SafeLoader("")

    def build(self, node: yaml.Node, path: KeyPath) -> object:
        """Return the data of a node, a None for each value that has a problem."""
        self._nodes += 1
        line = node.start_mark.line + 1
        if self._nodes > MAX_NODES or len(path) > MAX_DEPTH:
            message = f"expands to more than {MAX_NODES} values (aliases of aliases?)"
            raise InputError([Problem(message, self.name, line)])
        self.marks.setdefault(path, (self.name, line))
        tags = self._scalars.yaml_constructors if isinstance(node, yaml.ScalarNode) else _COLLECTIONS
        if node.tag not in tags:
            self.problems.append(Problem(f"the tag {node.tag} is not supported", self.name, line, key_path(path)))
            return None
        if isinstance(node, yaml.MappingNode):
            result: dict[str, object] = {}
            first_line: dict[str, int] = {}
            for key_node, value_node in node.value:
                key, line = key_node.value, key_node.start_mark.line + 1
                if not isinstance(key_node, yaml.ScalarNode) or key_node.tag == "tag:yaml.org,2002:merge":
                    message = "a key must be a plain word (merge keys are not supported)"
                    self.problems.append(Problem(message, self.name, line, key_path(path)))
                    continue
                here = (*path, key)
                if key in result:
                    message = f"duplicate key; first on line {first_line[key]}"
                    self.problems.append(Problem(message, self.name, line, key_path(here)))
                    continue
                first_line[key] = line
                self.marks[here] = (self.name, line)
                result[key] = self.build(value_node, here)
            return result
        if isinstance(node, yaml.SequenceNode):
            return [self.build(child, (*path, index)) for index, child in enumerate(node.value)]
        return self._scalar(node, path)

    def _scalar(self, node: yaml.Node, path: KeyPath) -> object:
        words = ""
        try:
            str(node.value).encode()  # an escape may spell half a character, which no file can hold
            if len(node.value) <= MAX_NUMBER_LENGTH or node.tag not in _NUMBERS:
                return self._scalars.construct_object(node)
            words = f"a number of {len(node.value)} characters"
        except (yaml.YAMLError, ValueError) as error:
            words = getattr(error, "problem", None) or str(error)
        except (LookupError, AttributeError, OverflowError):  # what a tag makes of text that it does not fit
            words = f"{shown(node.value)} is no {node.tag.rpartition(':')[2]}"
        self.problems.append(Problem(f"cannot be read: {words}", self.name, node.start_mark.line + 1, key_path(path)))
        return None
